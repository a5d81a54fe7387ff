"""Lesson 11, the simulator of agents: answers for all of them in one message. In C#: SceneSimulator.cs.
"""

import sys
from pathlib import Path
from typing import Any

# In their own lessons' folders; at home they lie beside this file.
sys.path += [str(Path(__file__).resolve().parents[1] / folder) for folder in ("05_messages", "09_environment")]
from mapping import ordinal
from messages import Message, MessageError, take
from scene_agent import Agent
from simulation import draws
from simulator import SimulatorBase
from tree import read, write


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
