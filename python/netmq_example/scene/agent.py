"""An agent of a scene: your own derives from it. It needs only Python.

    class Ball(Agent):                                              in code: spaces, and what is in them
        observation, action = Box(-12, 12, (2,), np.float32), Discrete(3)

        def on_action(self, action): ...
        def observe(self): return [self.place, self.speed]

    class Car(Agent):                                               by attributes: its fields say what is seen of it
        speed: Annotated[float, Obs(".speed")] = 0.0                seen under the key speed
        place: Annotated[Any, Obs()] = np.zeros(2)                  without a locator the field's name is the key

Without `observation` or `action` Python's side says which space it is. In C# it is Agent.cs.
"""

import importlib
import warnings
from dataclasses import dataclass
from typing import Any, Self, get_type_hints

from netmq_example import arguments, check
from netmq_example.wire import trees
from netmq_example.wire.split_mix import Draws, draws

# Bytes of infos that wait for an answer.
MOST_WAITING = 12_000


@dataclass(frozen=True)
class Obs:
    """Marks a field that is seen."""

    locator: str = ""

    def __post_init__(self) -> None:
        check.instance("locator", self.locator, str)


class Infos:
    """Infos for the next answer: no more than so many bytes, and those that are left out are counted."""

    def __init__(self) -> None:
        self.waiting: list[Any] = []
        self.size = 0
        self.dropped = 0

    def send(self, info: Any) -> None:
        """MessageError says what is no info: texts, numbers, true, false, lists, dicts and arrays."""
        data = trees.write(info)
        if self.size + len(data) > MOST_WAITING:
            self.dropped += 1
            return
        self.size += len(data)
        # As it is now, whatever becomes of it.
        self.waiting.append(trees.read(data))

    def take(self) -> list[Any]:
        taken = self.waiting
        if self.dropped:
            taken.append({"dropped": self.dropped})
        self.waiting, self.size, self.dropped = [], 0, 0
        return taken


class Agent:
    """Its methods set or change `reward`, `terminated` and `truncated`, put named values of this step into `info`, and
    draw numbers from 0 to 1 by `rng()`, the same for the same seed. `options` are those of the reset. An agent that has
    ended has no more ticks until the next reset.
    """

    name: str = "agent"
    # How many ticks one of its steps takes.
    period: int = 1
    # How many numbers options={"state": […]} has; they are in `state` then, which is empty otherwise.
    state_size: int = 0
    observation: Any = None
    action: Any = None

    rng: Draws
    options: dict[str, Any]
    state: list[float]
    reward: float
    terminated: bool
    truncated: bool
    info: dict[str, Any]
    # Infos for the next answer, and the reward since the last one in real time.
    _infos: Infos
    _earned: float

    def __init_subclass__(cls, **words: Any) -> None:
        super().__init_subclass__(**words)
        warn_of_slips(cls, Agent)

    # Here and not in __init__, which a class of your own may have without calling this one's.
    def __new__(cls, *_: Any, **__: Any) -> Self:
        agent = super().__new__(cls)
        begin(agent, draws(0), {}, [])
        return agent

    def __init__(self, name: str | None = None) -> None:
        if name is not None:
            self.name = arguments.text("name", name)
        declared(type(self), self.name)

    def on_reset(self) -> None:
        """An episode begins."""

    def on_action(self, action: Any) -> None:
        """A step begins. Others may have done theirs already: who moves all at once remembers it for on_tick."""

    def on_tick(self, dt: float) -> None:
        """So many seconds pass."""

    def on_stepped(self) -> None:
        """A step is over: rewards and ends."""

    def observe(self) -> Any:
        """What is seen now, in the space `observation`."""

    def on_info(self, info: Any) -> None:
        """Python has sent this agent something."""

    def render(self) -> Any:
        """A picture, uint8 [height, width, 3], the highest row first; None if it draws none."""

    def send_info(self, info: Any) -> None:
        """Tell Python something, with the next answer."""
        self._infos.send(info)


def warn_of_slips(kind: type, base: type) -> None:
    """A method that is never called would be silent."""
    for name in vars(kind):
        if name.startswith("on_") and not hasattr(base, name):
            known = ", ".join(each for each in vars(base) if each.startswith("on_"))
            warnings.warn(f"nobody calls {kind.__name__}.{name}: {base.__name__} has {known}", stacklevel=4)


def begin(agent: Agent, rng: Draws, options: dict[str, Any], state: list[float]) -> None:
    agent.rng = rng
    agent.options = options
    agent.state = state
    agent.reward = 0.0
    agent.terminated = False
    agent.truncated = False
    agent.info = {}
    agent._infos = Infos()
    agent._earned = 0.0


def over(agent: Agent) -> bool:
    return bool(agent.terminated or agent.truncated)


def marked(kind: type[Agent]) -> list[tuple[str, Obs]]:
    hints = get_type_hints(kind, include_extras=True)
    marks = [(field, mark) for field, hint in hints.items() for mark in getattr(hint, "__metadata__", ())]
    return [(field, mark) for field, mark in marks if isinstance(mark, Obs)]


def declared(kind: type[Agent], name: str) -> list[Any]:
    """What is seen of it, see attributes.py; LocatorError names the field that is wrong."""
    marks = marked(kind)
    # By name: a copy of a lesson whose agents have no attributes goes without.
    return importlib.import_module("netmq_example.scene.attributes").declared(kind, name, marks) if marks else []
