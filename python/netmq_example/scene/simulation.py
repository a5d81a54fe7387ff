"""The world that an environment steps, without network and clock. Your own derives from one of these classes.

    class Ball(Simulation):                                      one agent: worlds/cart_pole.py is an example
        name, dt, size = "Ball", 0.02, 2
        observation, action = Box(-12, 12, (2,), np.float32), Discrete(3)
        ...                                                      reset, apply, observe, reward_and_end

    class Tag(AgentSimulation): ...                              several agents: worlds/pursuit.py is an example
    RealTime(Tag())                                              goes on while Python thinks, if a reset asks for it

`rng` gives numbers from 0 to 1, the same for the same seed. Simulator, AreaSimulator and AgentSimulator answer an
environment's requests with them. In C# they are Simulation.cs, AgentSimulation.cs and RealTime.cs.
"""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any

from gymnasium.spaces import Space

from netmq_example import arguments, check
from netmq_example.wire import trees

# Bytes of infos that wait for an answer.
MOST_WAITING = 12_000
# More than that is not made up for when Python, or the whole computer, has slept.
MOST_SECONDS = 10.0


class InfoQueue:
    """Infos that wait for the next answer: no more than that, and those that are left out are counted."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        self.infos: list[list[Any]] = []
        self.size = 0
        self.dropped = 0

    def send(self, agent: str, info: dict[str, Any]) -> None:
        """MessageError says what is no info: texts, numbers, true, false, lists, dicts and arrays by name."""
        one = [agent, dict(info)]
        size = len(trees.write(one))
        if self.size + size > MOST_WAITING:
            self.dropped += 1
        else:
            self.size += size
            self.infos.append(one)

    def take(self) -> bytes:
        """All of them as a value, or nothing; and from then on the queue is empty."""
        lost = [["", {"dropped": self.dropped}]] if self.dropped else []
        infos = self.infos + lost
        self.clear()
        return trees.write(infos) if infos else b""


class Simulation(ABC):
    """A world of one agent. `dt` is how many seconds one step takes, `size` how many numbers its state has."""

    name: str
    dt: float
    size: int
    observation: Space[Any]
    action: Space[Any]

    @abstractmethod
    def reset(self, rng: Iterator[float], options: dict[str, Any], state: list[float]) -> None:
        """Begin an episode: by chance, or in a state if one is given: `size` numbers."""

    @abstractmethod
    def apply(self, action: Any) -> None:
        """Do it, for `dt` seconds."""

    @abstractmethod
    def observe(self) -> Any:
        """The observation now, in the space `observation`."""

    @abstractmethod
    def reward_and_end(self) -> dict[str, Any]:
        """The values reward, terminated and truncated, and any others for `info`."""

    def render(self) -> Any:
        """A picture, uint8 [height, width, 3], the highest row first."""
        raise NotImplementedError(f"{self.name} draws no pictures")


class AgentSimulation(ABC):
    """A game of several agents. `agents` are their names with what each sees and what it does."""

    name: str
    dt: float
    agents: dict[str, tuple[Space[Any], Space[Any]]]

    def __init__(self) -> None:
        self.infos = InfoQueue()

    @abstractmethod
    def reset(self, rng: Iterator[float], options: dict[str, Any]) -> None:
        """Begin an episode, in which all agents live."""

    @abstractmethod
    def apply(self, actions: dict[str, Any]) -> None:
        """Do what the agents that live want, for `dt` seconds."""

    @abstractmethod
    def observe(self, agent: str) -> Any:
        """The agent's observation now."""

    @abstractmethod
    def reward_and_end(self, agent: str) -> dict[str, Any]:
        """The values reward, terminated and truncated, and any others for its info."""

    def on_info(self, agent: str, info: dict[str, Any]) -> None:  # noqa: B027, to override it is optional.
        """Python has sent an info to an agent, or to the environment: ""."""

    def render(self) -> Any:
        """A picture, uint8 [height, width, 3], the highest row first."""
        raise NotImplementedError(f"{self.name} draws no pictures")


class RealTime(AgentSimulation):
    """A game around a game. It is stepped as ever, until a reset has the option `real_time`.

    From then on each step first makes up for the ticks that the clock has seen since the last one, with the actions
    from then; rewards are summed. It is Python that keeps the pace: `ZmqParallelEnv(real_time=True)` sends no more than
    one step for each tick.
    """

    def __init__(self, game: AgentSimulation, clock: Callable[[], float] = time.monotonic) -> None:
        check.instance("game", game, AgentSimulation)
        self.game = game
        self.clock = arguments.function("clock", clock)
        self.name, self.dt, self.agents, self.infos = game.name, game.dt, game.agents, game.infos
        self.real = False
        self.next = 0.0
        self.living: list[str] = []
        self.actions: dict[str, Any] = {}
        self.outcomes: dict[str, dict[str, Any]] = {}

    def reset(self, rng: Iterator[float], options: dict[str, Any]) -> None:
        self.game.reset(rng, options)
        self.real = options.get("real_time") is True
        self.next = self.clock() + self.dt
        self.living = list(self.agents)
        self.actions = {}
        self.outcomes = {}

    def apply(self, actions: dict[str, Any]) -> None:
        # The tick that is due now has the new actions, those before it the old ones.
        self.catch_up(self.clock() - self.dt)
        self.actions = actions
        self.tick()

    def catch_up(self, until: float) -> None:
        self.next = max(self.next, until - MOST_SECONDS)
        while self.real and self.living and until >= self.next:
            self.tick()

    def tick(self) -> None:
        self.next += self.dt
        if self.living:
            self.game.apply({agent: self.actions[agent] for agent in self.living if agent in self.actions})
        for agent in self.living:
            outcome = self.game.reward_and_end(agent)
            if agent in self.outcomes:
                outcome["reward"] += self.outcomes[agent]["reward"]
            self.outcomes[agent] = outcome
        over = {agent for agent, outcome in self.outcomes.items() if outcome["terminated"] or outcome["truncated"]}
        self.living = [agent for agent in self.living if agent not in over]

    def observe(self, agent: str) -> Any:
        return self.game.observe(agent)

    def reward_and_end(self, agent: str) -> dict[str, Any]:
        return self.outcomes.pop(agent)

    def on_info(self, agent: str, info: dict[str, Any]) -> None:
        self.game.on_info(agent, info)

    def render(self) -> Any:
        return self.game.render()
