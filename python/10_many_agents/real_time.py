"""Lesson 10, real time: the world goes on while Python thinks, for whoever asks for it. In C#: RealTime.cs.

AgentSimulator puts each game into this shell. It is stepped as ever, until a reset has the option `real_time`. From
then on each step first makes up for the ticks that the clock has seen since the last one, with the actions from then;
rewards are summed. It is Python that keeps the pace: `ZmqParallelEnv(real_time=True)` sends no more than one step for
each tick.
"""

import time
from collections.abc import Callable, Iterator
from typing import Any

from agent_simulation import AgentSimulation

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
