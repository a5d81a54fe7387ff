"""Lesson 11, the simulator of agents: answers for all of them in one message. In C#: SceneSimulator.cs.

Lesson 11, an agent of a scene: what it sees is said where it is declared. In C#: AgentState.cs, and of the
attributes.

    class Car(Agent):
        speed: Annotated[float, Obs(".speed")] = 0.0            seen under the key speed
        place: Annotated[Any, Obs()] = np.zeros(2)              without a locator the field's name is the key
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, get_type_hints

from netmq_example.locator import APPEND, LocatorError, ordinal, parse, quoted
from netmq_example.messages import Message, MessageError, take
from netmq_example.simulation.simulator import SimulatorBase
from netmq_example.spaces import read, write
from netmq_example.split_mix import draws


@dataclass(frozen=True)
class Obs:
    locator: str = ""


class Agent:
    """Your own derives from it, and has on_reset, on_action, on_tick and on_info as it needs them. Who has ended has no
    more ticks until the next reset."""

    def __init__(self, name: str = "agent") -> None:
        self.name, self.sources = name, declared(type(self), name)
        self.begin(draws(0), {})

    def begin(self, chance: Iterator[float], options: dict[str, Any]) -> None:
        self.chance, self.options = chance, options
        self.reward, self.terminated, self.truncated, self.infos = 0.0, False, False, list[Any]()

    def on_reset(self) -> None: ...
    def on_action(self, action: Any) -> None: ...
    def on_tick(self, dt: float) -> None: ...
    def on_info(self, info: Any) -> None: ...

    def observe(self) -> Iterator[tuple[str, Any]]:
        """Canonical locators, and the values that stand there now."""
        return ((text, getattr(self, field)) for text, field in self.sources)

    def take(self) -> dict[str, Any]:
        """What Python is told is told once, whatever numpy or Python made it of."""
        ends = {"terminated": bool(self.terminated), "truncated": bool(self.truncated)}
        said = {"reward": float(self.reward), **ends, "infos": self.infos}
        self.reward, self.infos = 0.0, []
        return said


def declared(kind: type, name: str) -> list[tuple[str, str]]:
    """Canonical locators, and the fields that go there; LocatorError names the field that is wrong."""
    scope, found = parse(f"{quoted(name)}@"), list[tuple[str, str]]()
    hints = get_type_hints(kind, include_extras=True)
    marks = [(field, mark) for field, hint in hints.items() for mark in getattr(hint, "__metadata__", ())]
    for field, mark in marks:
        if not isinstance(mark, Obs):
            continue
        try:
            locator = parse(mark.locator, field, scope)
        except LocatorError as error:
            raise LocatorError(f'{kind.__name__}.{field}, locator "{mark.locator}": {error}') from None
        appends = any(mapping.destination[-1:] == (APPEND,) for mapping in locator.mappings)
        if not appends and (other := next((other for text, other in found if text == locator.text), None)):
            both = " and ".join(f"{kind.__name__}.{each}" for each in (other, field))
            raise LocatorError(f"{both} go to one place: {locator.text}")
        found.append((locator.text, field))
    return found


class SceneSimulator(SimulatorBase):
    """For an environment of this name. Each agent has a name of its own; what is in `infos` Python is told once."""

    def __init__(self, name: str, dt: float, agents: list[Agent]) -> None:
        super().__init__(name)
        self.dt, self.agents, self.infos = dt, {agent.name: agent for agent in agents}, list[Any]()
        if len(self.agents) < len(agents):
            names = ", ".join(repr(agent.name) for agent in agents)
            raise ValueError(f"two agents have one name: {names}; each needs a name of its own")

    def on_info(self, info: Any) -> None:
        """Python has said something to the environment itself."""

    def describe(self) -> Message:
        return Message("hello", 0, {"name": self.name, "dt": self.dt})

    def do(self, request: Message) -> Message:
        said = read(take(request.values, "state", str), request.arrays)
        match request.kind:
            case "reset":
                names, options = take(said, "agents", list), take(said, "options", dict)
                chance, asked = draws(take(request.values, "seed", int)), [*dict.fromkeys(map(self.find, names))]
                self.infos = []
                # Also those whom Python does not ask: they move.
                for agent in self.agents.values():
                    agent.begin(chance, options)
                for agent in asked:
                    agent.on_reset()
                self.episodes += 1
            case "step":
                actions = take(said, "actions", dict)
                asked = [self.find(name) for name in actions]
                for agent in asked:
                    agent.on_action(actions[agent.name])
                for agent in self.agents.values():
                    if not (agent.terminated or agent.truncated):
                        agent.on_tick(self.dt)
                self.steps += 1
            case "info" if "info" in said:
                hearer = self.find(to) if (to := take(said, "to", str)) else self
                hearer.on_info(said["info"])
                return Message("ok", request.id)
            case _:
                kind = f"{request.kind!a:.40} with these fields"
                raise MessageError("unknown-kind", f"kind {kind} is none of reset, step, info, close")
        return self.state(request.id, asked)

    def find(self, name: Any) -> Agent:
        if isinstance(name, str) and name in self.agents:
            return self.agents[name]
        raise MessageError("unknown-agent", f"no agent is named {name!a:.40}; there are: {', '.join(self.agents)}")

    def state(self, id: int, asked: list[Agent]) -> Message:
        # In the order of their locators: the whole of a thing before its parts, and the same on every side.
        seen = sorted((pair for agent in asked for pair in agent.observe()), key=lambda pair: ordinal(pair[0]))
        observations = [list(pair) for pair in seen]
        message, told = Message("state", id), {agent.name: agent.take() for agent in asked}
        tree = {"agents": told, "infos": self.infos, "observations": observations}
        self.infos = []
        message.values["state"] = write(tree, message.arrays)
        return message
