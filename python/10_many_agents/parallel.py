"""Lesson 10, the environment of several agents: a PettingZoo ParallelEnv, and each step of all is one message.

    from parallel import ZmqParallelEnv
    env = ZmqParallelEnv("Pursuit")                            waits for a simulator on tcp://127.0.0.1:5560
    env = ZmqParallelEnv("Pursuit", launch="Build/Pursuit")                 starts the game by its path

Who ends leaves `agents`. A simulator that is lost ends the episode of all: they are truncated, and each one's info has
`lost`; the next reset waits for another one. What the game has said meanwhile is `told` in each one's info: lists of
infos by agent, those of the environment as `env`. `send_info` is the other way, at any time. With `real_time=True` the
world goes on while Python thinks, and a step waits for the next tick.
They need pettingzoo.
"""

import contextlib
import sys
import time
import weakref
from pathlib import Path
from typing import Any

import numpy as np

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "09_environment"))
from connection import Lost
from gymnasium.spaces import Space
from gymnasium.utils import seeding
from infos import LIMIT, pack
from pettingzoo import ParallelEnv
from remote_agents import RemoteAgents, told
from spaces import drawn, gives_pictures, picture, sendable, shown, to_array


class ZmqParallelEnv(ParallelEnv[str, Any, Any]):  # type: ignore[misc]
    """The game of one simulator. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    def __init__(self, name: str = "Pursuit", render_mode: Any = None, real_time: bool = False, **where: Any) -> None:
        self.agents, self.render_mode, self.real_time, self.next = list[str](), drawn(render_mode), real_time, 0.0
        self.picture = np.zeros((240, 320, 3), np.uint8)
        self.random, _ = seeding.np_random()
        self.remote = RemoteAgents(name, **where)
        # Also when nobody calls close: at garbage collection, and at the end of the program. And only once.
        self.close_once = weakref.finalize(self, self.remote.simulators.close)
        try:
            self.remote.simulators.find(self.remote.accept)
        except BaseException:
            self.close()
            raise
        self.possible_agents = list(self.remote.spaces)
        fps = round(1 / max(1e-3, self.remote.dt))
        self.metadata = {"name": f"NetMQExample/{name}-v0", "render_modes": ["rgb_array"], "render_fps": fps}

    def observation_space(self, agent: str) -> Space[Any]:
        return self.remote.spaces[agent][0]

    def action_space(self, agent: str) -> Space[Any]:
        return self.remote.spaces[agent][1]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, Any]:
        if seed is not None:
            self.random, _ = seeding.np_random(seed)
        # The simulator gets a seed each time, so that an episode never depends on the one before.
        seed = int(self.random.integers(2**53)) if seed is None else seed
        values, begin = sendable(options, seed=seed, real_time=self.real_time)
        if begin:
            raise ValueError("state cannot be sent: a game begins by chance")
        state = self.remote.simulators.begin(self.remote.accept, lambda _: self.remote.ask("reset", values, []))
        self.next = time.monotonic() + self.remote.dt
        self.agents = self.possible_agents[:]
        seen, *_, infos = self.remote.read(state, self.agents)
        return seen, infos

    def step(self, actions: dict[str, Any]) -> tuple[Any, Any, Any, Any, Any]:
        if not isinstance(actions, dict) or not actions or actions.keys() != set(self.agents):
            raise ValueError(f"actions {actions!r:.200}, but those that live are {self.agents}")
        for agent, action in actions.items():
            if action not in self.action_space(agent):
                raise ValueError(f"action {shown(action)} of {agent} is not in {shown(self.action_space(agent))}")
        if self.real_time:
            time.sleep(max(0.0, self.next - time.monotonic()))
            self.next = time.monotonic() + self.remote.dt
        arrays = [to_array(actions[agent], self.action_space(agent).dtype) for agent in self.agents]
        try:
            state = self.remote.ask("step", {}, arrays)
            seen, rewards, terminated, truncated, infos = self.remote.read(state, self.agents)
        except Lost as lost:
            # Nobody knows what came after what was seen last; it is read anew, as who got it may have changed it.
            seen = self.remote.seen({agent: self.remote.last[agent] for agent in self.agents})
            rewards, terminated, truncated = (dict.fromkeys(self.agents, value) for value in (0.0, False, True))
            infos = {agent: {"lost": str(lost)} for agent in self.agents}
        self.agents = [agent for agent in self.agents if not terminated[agent] and not truncated[agent]]
        return seen, rewards, terminated, truncated, infos

    def send_info(self, info: dict[str, Any], agent: str = "") -> dict[str, list[Any]]:
        """Say something to an agent, or to the environment; what the game had to say comes back."""
        if agent not in ("", *self.possible_agents):
            raise ValueError(f"agent {agent!r:.40} is none of {self.possible_agents}, nor the environment, ''")
        if len(text := pack([(agent, info)])) > LIMIT:
            raise ValueError(f"an info has at most {LIMIT} characters, not {len(text)}")
        return told(self.remote.ask("info", {"infos": text}, []))

    def render(self) -> Any:
        if not gives_pictures(self.render_mode):
            return None
        # Who films goes on when the simulator is lost, which step says, with the picture before.
        with contextlib.suppress(Lost):
            self.picture = picture(self.remote.ask("render", {}, []).arrays)
        return self.picture

    def close(self) -> None:
        self.close_once()
