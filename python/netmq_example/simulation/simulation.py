"""Lesson 10, real time: the world goes on while Python thinks, for whoever asks for it. In C#: RealTime.cs.

AgentSimulator puts each game into this shell. It is stepped as ever, until a reset has the option `real_time`. From
then on each step first makes up for the ticks that the clock has seen since the last one, with the actions from then;
rewards are summed. It is Python that keeps the pace: `ZmqParallelEnv(real_time=True)` sends no more than one step for
each tick.

Lesson 09, a simulation: what a world needs, so that an environment can be made of it. In C#: Simulation.cs.

Lesson 10, a world of several agents, and nothing else: no network and no clock. In C#: AgentSimulation.cs.
"""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any

from gymnasium.spaces import Space

from netmq_example.spaces import InfoQueue


class Simulation(ABC):
    """Your own derives from it. `dt` is how many seconds one step takes, `size` how many numbers its state has."""

    name: str
    dt: float
    size: int
    observation: Space[Any]
    action: Space[Any]

    @abstractmethod
    def reset(self, chance: Iterator[float], options: dict[str, Any], state: list[float]) -> None:
        """Begin an episode: by chance, or in a state if one is given: `size` numbers."""

    @abstractmethod
    def apply(self, action: Any) -> None:
        """Do it, for `dt` seconds."""

    @abstractmethod
    def observe(self) -> Any:
        """What is seen now: something of the space `observation`."""

    @abstractmethod
    def judge(self) -> dict[str, Any]:
        """The values reward, terminated and truncated, and any others for `info`."""

    def render(self) -> Any:
        """A picture, uint8 [height, width, 3], the highest row first."""
        raise NotImplementedError(f"{self.name} draws no pictures")


class AgentSimulation(ABC):
    """Your own game derives from it. `agents` are their names with what each sees and what it does."""

    name: str
    dt: float
    agents: dict[str, tuple[Space[Any], Space[Any]]]

    def __init__(self) -> None:
        self.infos = InfoQueue()

    @abstractmethod
    def reset(self, chance: Iterator[float], options: dict[str, Any]) -> None:
        """Begin an episode, in which all agents live."""

    @abstractmethod
    def apply(self, actions: dict[str, Any]) -> None:
        """Do what the agents that live want, for `dt` seconds."""

    @abstractmethod
    def observe(self, agent: str) -> Any:
        """What it sees now."""

    @abstractmethod
    def judge(self, agent: str) -> dict[str, Any]:
        """The values reward, terminated and truncated, and any others for its info."""

    def on_info(self, agent: str, info: dict[str, Any]) -> None:  # noqa: B027, whoever wants to hear overrides it.
        """Python has said something to an agent, or to the environment: ""."""

    def render(self) -> Any:
        """A picture, uint8 [height, width, 3], the highest row first."""
        raise NotImplementedError(f"{self.name} draws no pictures")


# Seconds. Who slept longer, as a computer does, has not that much made up for.
MOST = 10.0


class RealTime(AgentSimulation):
    """Another game around a game."""

    def __init__(self, game: AgentSimulation, clock: Callable[[], float] = time.monotonic) -> None:
        self.game, self.clock = game, clock
        self.name, self.dt, self.agents, self.infos = game.name, game.dt, game.agents, game.infos
        self.real, self.next = False, 0.0
        self.living, self.actions, self.verdicts = list[str](), dict[str, Any](), dict[str, dict[str, Any]]()

    def reset(self, chance: Iterator[float], options: dict[str, Any]) -> None:
        self.game.reset(chance, options)
        self.real, self.next = options.get("real_time") is True, self.clock() + self.dt
        self.living, self.actions, self.verdicts = list(self.agents), {}, {}

    def apply(self, actions: dict[str, Any]) -> None:
        # The tick that is due now has the new actions, those before it the old ones.
        self.catch_up(self.clock() - self.dt)
        self.actions = actions
        self.tick()

    def catch_up(self, until: float) -> None:
        self.next = max(self.next, until - MOST)
        while self.real and self.living and until >= self.next:
            self.tick()

    def tick(self) -> None:
        self.next += self.dt
        if self.living:
            self.game.apply({agent: self.actions[agent] for agent in self.living if agent in self.actions})
        for agent in self.living:
            verdict = self.game.judge(agent)
            verdict["reward"] += self.verdicts.get(agent, {"reward": 0.0})["reward"]
            self.verdicts[agent] = verdict
        over = {agent for agent, verdict in self.verdicts.items() if verdict["terminated"] or verdict["truncated"]}
        self.living = [agent for agent in self.living if agent not in over]

    def observe(self, agent: str) -> Any:
        return self.game.observe(agent)

    def judge(self, agent: str) -> dict[str, Any]:
        return self.verdicts.pop(agent)

    def on_info(self, agent: str, info: dict[str, Any]) -> None:
        self.game.on_info(agent, info)

    def render(self) -> Any:
        return self.game.render()
