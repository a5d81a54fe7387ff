"""A scene without Unity: agents whose fields say what is seen of them, and the simulator that answers for all of them.

    class Car(Agent):
        speed: Annotated[float, Obs(".speed")] = 0.0            seen under the key speed
        place: Annotated[Any, Obs()] = np.zeros(2)              without a locator the field's name is the key

        def on_action(self, action): ...

    simulator = SceneSimulator("Coins", 0.1, [Car("car")])      0.1 s a step
    EnvironmentClient("tcp://127.0.0.1:5561", timeout=30).run(simulator)

Its resets and steps are records (records.py), with a row for each agent that is asked for. The options of a reset are
{"agents": names, "options": {...}}, and the rows keep the order of these names. An action is any value (trees.py); what
is seen are locators, each with a value, and an info is {"env": [...], "agent": [...]}. The message `info` has
[name or "", info].

A wrong class is a LocatorError that names class and field; a wrong request is answered with an error. In C# it is
Obs.cs, AgentState.cs and SceneSimulator.cs. It needs gymnasium and numpy.
"""

import functools
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, get_type_hints

from netmq_example import arguments, check
from netmq_example.locator import APPEND, LocatorError, ordinal, parse, quoted
from netmq_example.messages import Message, MessageError, take
from netmq_example.scene.agents import info_of
from netmq_example.scene.answers import answer_to, hello_of, options_in, unknown
from netmq_example.scene.simulator import SimulatorBase
from netmq_example.wire import trees
from netmq_example.wire.records import RESET, STEP, Record
from netmq_example.wire.split_mix import draws


@dataclass(frozen=True)
class Obs:
    """Marks a field that is seen."""

    locator: str = ""

    def __post_init__(self) -> None:
        check.instance("locator", self.locator, str)


class Agent:
    """Your own derives from it, and has on_reset, on_action, on_tick and on_info as it needs them.

    They set `reward`, `terminated` and `truncated`, append to `infos`, and draw numbers from `rng`. An agent that
    has ended has no more ticks until the next reset.
    """

    def __init__(self, name: str = "agent") -> None:
        self.name = arguments.text("name", name)
        self.sources = declared(type(self), name)
        self.begin(draws(0), {})

    def begin(self, rng: Iterator[float], options: dict[str, Any]) -> None:
        """A new episode: numbers from 0 to 1 that are the same for the same seed, and the options of reset."""
        self.rng = rng
        self.options = options
        self.reward = 0.0
        self.terminated = False
        self.truncated = False
        self.infos: list[Any] = []

    def on_reset(self) -> None: ...
    def on_action(self, action: Any) -> None: ...
    def on_tick(self, dt: float) -> None: ...
    def on_info(self, info: Any) -> None: ...

    def observe(self) -> Iterator[tuple[str, Any]]:
        """Canonical locators, and the values that stand there now."""
        return ((text, getattr(self, field)) for text, field in self.sources)

    def take(self) -> dict[str, Any]:
        """What is sent to Python once."""
        taken: dict[str, Any] = {"reward": self.reward, "terminated": self.terminated, "truncated": self.truncated}
        if self.infos:
            taken["agent"] = self.infos
        self.reward = 0.0
        self.infos = []
        return taken


def declared(kind: type, name: str) -> list[tuple[str, str]]:
    """Canonical locators, and the fields that go there; LocatorError names the field that is wrong."""
    scope = parse(f"{quoted(name)}@")
    hints = get_type_hints(kind, include_extras=True)
    marks = [(field, mark) for field, hint in hints.items() for mark in getattr(hint, "__metadata__", ())]
    found: list[tuple[str, str]] = []
    for field, mark in marks:
        if not isinstance(mark, Obs):
            continue
        try:
            locator = parse(mark.locator, field, scope)
        except LocatorError as error:
            raise LocatorError(f'{kind.__name__}.{field}, locator "{mark.locator}": {error}') from None
        appends = any(mapping.destination[-1:] == (APPEND,) for mapping in locator.mappings)
        for text, other in found:
            if text == locator.text and not appends:
                both = f"{kind.__name__}.{other} and {kind.__name__}.{field}"
                raise LocatorError(f"{both} go to one place: {locator.text}")
        found.append((locator.text, field))
    return found


class SceneSimulator(SimulatorBase):
    """For an environment of this name, with steps of `dt` seconds. What is in `infos` is sent to Python once."""

    def __init__(self, name: str, dt: float, agents: Iterable[Agent]) -> None:
        super().__init__(arguments.text("name", name))
        self.dt = check.seconds("dt", dt)
        if isinstance(agents, str | bytes | dict) or not isinstance(agents, Iterable):
            raise TypeError(f"agents takes a list of Agents, not {agents!r:.40}")
        agents = list(agents)
        for agent in agents:
            if not isinstance(agent, Agent):
                raise TypeError(f"agents takes Agents, not {agent!r:.40}")
        self.agents = {agent.name: agent for agent in agents}
        self.infos: list[Any] = []
        # Those of the last reset: each has a row.
        self.asked: list[Agent] = []
        self.reset_options: dict[str, Any] = {}
        if len(self.agents) < len(agents):
            names = ", ".join(repr(agent.name) for agent in agents)
            raise ValueError(f"two agents have one name: {names}; each needs a name of its own")

    def on_info(self, info: Any) -> None:
        """Python has sent something to the environment itself."""

    def describe(self) -> Message:
        # What is seen, the fields say; into which spaces it goes, Python does.
        return hello_of(self.name, self.dt, {})

    def say(self, request: Message) -> Message:
        if request.kind != "info":
            raise unknown(request, "info")
        to, info = info_of(request)
        receiver = self.find(to) if to else self
        receiver.on_info(info)
        return Message("told", request.id)

    def do(self, request: Record) -> Record:
        if RESET in request.flags:
            said = options_in(request)
            self.reset_options = take(said, "options", dict)
            self.asked = [self.find(name) for name in take(said, "agents", list)]
        if len(self.asked) != len(request.flags):
            raise MessageError(
                "wrong-agents", f"{len(request.flags)} rows, but {len(self.asked)} agents were asked for"
            )
        orders = list(zip(self.asked, request.flags, request.rows, strict=True))
        stepping = {agent: trees.read(row) for agent, order, row in orders if order == STEP}
        if stepping:
            self.step(stepping)
        self.reset(request)
        outcomes = []
        rows = []
        for agent, order, _ in orders:
            outcomes.append(agent.take() if order else {})
            if order and self.infos:
                outcomes[-1]["env"] = self.infos
            rows.append(self.seen(agent) if order else b"")
        self.infos = []
        return answer_to(request, [agent.name for agent in self.asked], outcomes, rows)

    def reset(self, request: Record) -> None:
        seeds = struct.unpack(f"<{len(request.flags)}q", request.numbers)
        # Agents of one seed draw from the same numbers, one after the other.
        rngs = {seed: draws(seed) for seed in seeds}
        resetting = {
            agent: seed for agent, order, seed in zip(self.asked, request.flags, seeds, strict=True) if order == RESET
        }
        if len(resetting) == len(request.flags):
            self.infos = []
            # Also those for which Python does not ask: they move.
            for agent in self.agents.values():
                resetting.setdefault(agent, seeds[0])
        for agent, seed in resetting.items():
            agent.begin(rngs[seed], self.reset_options)
        for agent, order in zip(self.asked, request.flags, strict=True):
            if order == RESET:
                agent.on_reset()
                self.episodes += 1

    def step(self, actions: dict[Agent, Any]) -> None:
        for agent, action in actions.items():
            agent.on_action(action)
        for agent in self.agents.values():
            if not (agent.terminated or agent.truncated):
                agent.on_tick(self.dt)
        self.steps += 1

    def find(self, name: Any) -> Agent:
        if isinstance(name, str) and name in self.agents:
            return self.agents[name]
        raise MessageError("unknown-agent", f"no agent is named {name!a:.40}; there are: {', '.join(self.agents)}")

    def seen(self, agent: Agent) -> bytes:
        """In the order of the locators: the whole of a thing before its parts, and the same in every language."""
        pairs = []
        for other in self.agents.values():
            pairs += [pair for pair in other.observe() if other is agent or names(pair[0], agent.name)]
        return trees.write_pairs(sorted(pairs, key=lambda pair: ordinal(pair[0])))


@functools.lru_cache(1000)
def names(text: str, agent: str) -> bool:
    """Whether this locator goes into the observation of this agent, too."""
    return any(mapping.names(agent) for mapping in parse(text).mappings)
