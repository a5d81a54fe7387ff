"""Lesson 10, the environment of several agents: a PettingZoo ParallelEnv, and each step of all is one message.

    from netmq_example.envs.parallel_env import ZmqParallelEnv
    env = ZmqParallelEnv("Pursuit")                            waits for a simulator on tcp://127.0.0.1:5560
    env = ZmqParallelEnv("Pursuit", launch="Build/Pursuit")                 starts the game by its path

Who ends leaves `agents`. A simulator that is lost ends the episode of all: they are truncated, and each one's info has
`lost`; the next reset waits for another one. What the game has said meanwhile is `told` in each one's info: lists of
infos by agent, those of the environment as `env`. `send_info` is the other way, at any time. With `real_time=True` the
world goes on while Python thinks, and a step waits for the next tick.
They need pettingzoo.

Lesson 10, the agents as Python sees them: their spaces, and what a message says of each.
"""

import contextlib
import time
import weakref
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space
from gymnasium.utils import seeding
from pettingzoo import ParallelEnv

from netmq_example.envs.connection import Lost, Simulators
from netmq_example.messages import Array, Message, MessageError, take
from netmq_example.spaces import (
    LIMIT,
    drawn,
    from_array,
    gives_pictures,
    pack,
    picture,
    sendable,
    shown,
    space_of,
    to_array,
    unpack,
)

ENDPOINT = "tcp://127.0.0.1:5560"


class RemoteAgents:
    """`where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    def __init__(self, name: str, **where: Any) -> None:
        self.name, self.dt, self.spaces = name, 0.0, dict[str, tuple[Space[Any], Space[Any]]]()
        self.last = dict[str, Array]()
        self.simulators = Simulators(default=ENDPOINT, **where)
        self.ask = self.simulators.connection.ask

    def accept(self, hello: Message) -> None:
        if (name := take(hello.values, "name", str)) != self.name:
            raise MessageError("wrong-name", f"this environment is {self.name}, the simulator's is {name!a:.40}")
        arrays, spaces = list(hello.arrays), dict[str, tuple[Space[Any], Space[Any]]]()
        for agent, kinds in unpack(take(hello.values, "agents", str)):
            if agent in ("", "env", *spaces):
                raise MessageError("bad-agents", f"{agent!a:.40} is another agent, or stands for the environment")
            seen, done = (space_of(take(kinds, which, str), arrays) for which in ("observation", "action"))
            spaces[agent] = (seen, done)
        if self.spaces and spaces != self.spaces:
            raise MessageError("other-spaces", f"the simulator before this one had {self.spaces!s:.80}")
        # The same objects for ever: whoever draws actions by chance has seeded them.
        self.spaces, self.dt = self.spaces or spaces, take(hello.values, "dt", float)

    def read(self, state: Message, living: list[str]) -> tuple[dict[str, Any], ...]:
        """Observations, rewards, terminated, truncated and infos, each by agent."""
        infos = unpack(take(state.values, "infos", str), own=("told", "lost"))
        if (names := [name for name, _ in infos]) != living or len(state.arrays) != 3 + len(living):
            raise MessageError("wrong-agents", f"a state of {names!s:.80}, but those that live are {living}")
        reward, *flags = ([array] for array in state.arrays[:3])
        most, count = np.finfo(np.float64).max, (len(living),)
        rewards = map(float, from_array(Box(-most, most, count, np.float64), reward))
        terminated, truncated = (map(bool, from_array(Box(0, 1, count, np.uint8), flag)) for flag in flags)
        last = dict(zip(living, state.arrays[3:], strict=True))
        seen, said = self.seen(last), {"told": heard} if (heard := told(state)) else {}
        by_agent = [dict(zip(living, each, strict=True)) for each in (rewards, terminated, truncated)]
        self.last = last
        return seen, *by_agent, {agent: {**info, **said} for agent, info in infos}

    def seen(self, arrays: dict[str, Array]) -> dict[str, Any]:
        return {agent: from_array(self.spaces[agent][0], [array]) for agent, array in arrays.items()}


def told(answer: Message) -> dict[str, list[Any]]:
    """What the game has said since the answer before: lists of infos by agent, those of the environment as `env`."""
    said = dict[str, list[Any]]()
    for agent, info in unpack(answer.values.get("told", "[]")):
        said.setdefault(agent or "env", []).append(info)
    return said


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
