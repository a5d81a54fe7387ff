"""Lesson 11, the simulator of agents: answers for all of them in one message. The twin of SceneSimulator.cs, and of
the attributes.

    class Car(Agent):
        speed: Annotated[float, Obs(".speed")] = 0.0            seen under the key speed
        place: Annotated[Any, Obs()] = np.zeros(2)              without a locator the field's name is the key

Take home: this file with tree.py, locator.py, mapping.py and reader.py, and simulator.py, simulation.py and spaces.py
of lesson 09, with messages.py of lesson 05.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_type_hints

# In their own lessons' folders; at home they lie beside this file.
sys.path += [str(Path(__file__).resolve().parents[1] / folder) for folder in ("05_messages", "09_environment")]
from locator import parse
from mapping import ordinal, quoted
from messages import Message, MessageError, take
from simulation import draws
from simulator import SimulatorBase
from tree import read, write


@dataclass(frozen=True)
class Obs:
    locator: str = ""


class Agent:
    """Your own derives from it, and has on_reset, on_action, on_tick and on_info as it needs them."""

    def __init__(self, name: str = "agent") -> None:
        self.name, self.chance, self.options = name, draws(0), dict[str, Any]()
        self.sources = declared(type(self), name)
        self.begin()

    def begin(self) -> None:
        self.reward, self.terminated, self.truncated, self.infos = 0.0, False, False, list[Any]()

    def on_reset(self) -> None: ...
    def on_action(self, action: Any) -> None: ...
    def on_tick(self, dt: float) -> None: ...
    def on_info(self, info: Any) -> None: ...

    def observe(self) -> Iterator[tuple[str, Any]]:
        """Canonical locators, and the values that stand there now."""
        return ((text, getattr(self, field)) for text, field in self.sources)

    def take(self) -> dict[str, Any]:
        """What Python is told is told once."""
        ends = {"terminated": self.terminated, "truncated": self.truncated}
        said = {"reward": self.reward, **ends, "infos": self.infos}
        self.reward, self.infos = 0.0, []
        return said


def declared(kind: type, name: str) -> list[tuple[str, str]]:
    scope, hints = parse(f"{quoted(name)}@"), get_type_hints(kind, include_extras=True)
    marks = {field: mark for field, hint in hints.items() for mark in getattr(hint, "__metadata__", ())}
    return [(parse(mark.locator, field, scope).text, field) for field, mark in marks.items() if isinstance(mark, Obs)]


class SceneSimulator(SimulatorBase):
    """For an environment of this name. Each agent has a name of its own."""

    def __init__(self, name: str, dt: float, agents: list[Agent]) -> None:
        super().__init__(name)
        self.dt, self.agents = dt, {agent.name: agent for agent in agents}

    def describe(self) -> Message:
        return Message("hello", 0, {"name": self.name, "dt": self.dt})

    def do(self, request: Message) -> Message:
        said = read(take(request.values, "state", str), request.arrays)
        match request.kind:
            case "reset":
                asked, chance = [self.find(name) for name in said["agents"]], draws(take(request.values, "seed", int))
                for agent in asked:
                    agent.begin()
                    agent.chance, agent.options = chance, said["options"]
                for agent in asked:
                    agent.on_reset()
                self.episodes += 1
            case "step":
                asked = [self.find(name) for name in said["actions"]]
                for agent in asked:
                    agent.on_action(said["actions"][agent.name])
                for agent in self.agents.values():
                    agent.on_tick(self.dt)
                self.steps += 1
            case "info":
                self.find(said["to"]).on_info(said["info"])
                return Message("ok", request.id)
            case _:
                raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of reset, step, info, close")
        return self.state(request.id, asked)

    def find(self, name: str) -> Agent:
        if name in self.agents:
            return self.agents[name]
        raise MessageError("unknown-agent", f"no agent is named {name!a:.40}; there are: {', '.join(self.agents)}")

    def state(self, id: int, asked: list[Agent]) -> Message:
        # In the order of their locators: the whole of a thing before its parts, and the same on every side.
        seen = sorted((pair for agent in asked for pair in agent.observe()), key=lambda pair: ordinal(pair[0]))
        observations = [list(pair) for pair in seen]
        message, told = Message("state", id), {agent.name: agent.take() for agent in asked}
        tree = {"agents": told, "infos": [], "observations": observations}
        message.values["state"] = write(tree, message.arrays)
        return message
