"""A scene without Unity: agents whose fields say what is seen of them, and the simulator that answers for all of them.

    class Car(Agent):
        speed: Annotated[float, Obs(".speed")] = 0.0            seen under the key speed
        place: Annotated[Any, Obs()] = np.zeros(2)              without a locator the field's name is the key

        def on_action(self, action): ...

    simulator = SceneSimulator("Coins", 0.1, [Car("car")])      0.1 s a step
    EnvironmentClient("tcp://127.0.0.1:5561", 30).run(simulator)

Its messages are those of lesson 05. Each has one value `state`, the text of a tree of values (spaces.py):

    reset, seed      {"agents": names, "options": {...}}      state    {"agents": {name: what Agent.take returns},
    step             {"actions": {name: action}}                        "infos": [...],
    info             {"to": name or "", "info": value}        ok        "observations": [[locator, value], ...]}

A wrong class is a LocatorError that names class and field; a wrong request is answered with an error. In C# it is
Obs.cs, AgentState.cs and SceneSimulator.cs. It needs gymnasium and numpy.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, get_type_hints

from netmq_example import check
from netmq_example.locator import APPEND, LocatorError, ordinal, parse, quoted
from netmq_example.messages import Message, MessageError, take
from netmq_example.simulation.simulator import SimulatorBase
from netmq_example.spaces import read, write
from netmq_example.split_mix import draws


@dataclass(frozen=True)
class Obs:
    """Marks a field that is seen."""

    locator: str = ""

    def __post_init__(self) -> None:
        check.instance("locator", self.locator, str)


class Agent:
    """Your own derives from it, and has on_reset, on_action, on_tick and on_info as it needs them.

    They set `reward`, `terminated` and `truncated`, append to `infos`, and draw numbers from `chance`. An agent that
    has ended has no more ticks until the next reset.
    """

    def __init__(self, name: str = "agent") -> None:
        self.name = check.text("name", name)
        self.sources = declared(type(self), name)
        self.begin(draws(0), {})

    def begin(self, chance: Iterator[float], options: dict[str, Any]) -> None:
        """A new episode: numbers from 0 to 1 that are the same for the same seed, and the options of reset."""
        self.chance = chance
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
        """What is sent to Python once; plain values, whatever numpy or Python made of them."""
        taken = {
            "reward": float(self.reward),
            "terminated": bool(self.terminated),
            "truncated": bool(self.truncated),
            "infos": self.infos,
        }
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
        super().__init__(check.text("name", name))
        self.dt = check.seconds("dt", dt)
        if isinstance(agents, str | bytes | dict) or not isinstance(agents, Iterable):
            raise TypeError(f"agents takes a list of Agents, not {agents!r:.40}")
        agents = list(agents)
        for agent in agents:
            if not isinstance(agent, Agent):
                raise TypeError(f"agents takes Agents, not {agent!r:.40}")
        self.agents = {agent.name: agent for agent in agents}
        self.infos: list[Any] = []
        if len(self.agents) < len(agents):
            names = ", ".join(repr(agent.name) for agent in agents)
            raise ValueError(f"two agents have one name: {names}; each needs a name of its own")

    def on_info(self, info: Any) -> None:
        """Python has sent something to the environment itself."""

    def describe(self) -> Message:
        return Message("hello", 0, {"name": self.name, "dt": self.dt})

    def do(self, request: Message) -> Message:
        content = read(take(request.values, "state", str), request.arrays)
        match request.kind:
            case "reset":
                asked = self.reset(content, take(request.values, "seed", int))
            case "step":
                asked = self.step(take(content, "actions", dict))
            case "info" if "info" in content:
                to = take(content, "to", str)
                receiver = self.find(to) if to else self
                receiver.on_info(content["info"])
                return Message("ok", request.id)
            case _:
                kind = f"{request.kind!a:.40} with these fields"
                raise MessageError("unknown-kind", f"kind {kind} is none of reset, step, info, close")
        return self.state(request.id, asked)

    def reset(self, content: Any, seed: int) -> list[Agent]:
        names = take(content, "agents", list)
        options = take(content, "options", dict)
        asked = list(dict.fromkeys(map(self.find, names)))
        chance = draws(seed)
        self.infos = []
        # Also those for which Python does not ask: they move.
        for agent in self.agents.values():
            agent.begin(chance, options)
        for agent in asked:
            agent.on_reset()
        self.episodes += 1
        return asked

    def step(self, actions: dict[str, Any]) -> list[Agent]:
        asked = [self.find(name) for name in actions]
        for agent in asked:
            agent.on_action(actions[agent.name])
        for agent in self.agents.values():
            if not (agent.terminated or agent.truncated):
                agent.on_tick(self.dt)
        self.steps += 1
        return asked

    def find(self, name: Any) -> Agent:
        if isinstance(name, str) and name in self.agents:
            return self.agents[name]
        raise MessageError("unknown-agent", f"no agent is named {name!a:.40}; there are: {', '.join(self.agents)}")

    def state(self, id: int, asked: list[Agent]) -> Message:
        # In the order of their locators: the whole of a thing before its parts, and the same in every language.
        seen = sorted((pair for agent in asked for pair in agent.observe()), key=lambda pair: ordinal(pair[0]))
        taken = {agent.name: agent.take() for agent in asked}
        message = Message("state", id)
        tree = {"agents": taken, "infos": self.infos, "observations": [list(pair) for pair in seen]}
        self.infos = []
        message.values["state"] = write(tree, message.arrays)
        return message
