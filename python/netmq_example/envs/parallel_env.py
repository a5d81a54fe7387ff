"""An environment of several agents: a PettingZoo ParallelEnv, and each step of all of them is one message.

    from netmq_example.envs import ZmqParallelEnv

    env = ZmqParallelEnv("Pursuit")                            waits for a simulator on tcp://127.0.0.1:5560
    env = ZmqParallelEnv("Pursuit", launch="Build/Pursuit")                 starts the game by its path

An agent that ends leaves `agents`. A simulator that is lost ends the episode of all: they are truncated, and each one's
info has `lost`; the next reset waits for another one. What the game has sent meanwhile is `told` in each one's info:
lists of infos by agent, those of the environment as `env`. `send_info` is the other way, at any time. With
`real_time=True` the world goes on while Python thinks, and a step waits for the next tick. The C# side is
AgentSimulator.cs.
It needs pettingzoo.
"""

import contextlib
import time
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space
from gymnasium.utils import seeding
from pettingzoo import ParallelEnv

from netmq_example import check
from netmq_example.envs.connection import Lost, Simulators
from netmq_example.infos import LONGEST, pack, unpack
from netmq_example.messages import Array, Message, MessageError, take
from netmq_example.spaces import (
    frames_per_second,
    from_array,
    gives_pictures,
    known_render_mode,
    picture,
    sendable,
    shown,
    space_of,
    to_array,
)

ENDPOINT = "tcp://127.0.0.1:5560"

Spaces = dict[str, tuple[Space[Any], Space[Any]]]


class RemoteAgents:
    """The agents as messages: their spaces, and what a state has of each.

    `where` is what Simulators takes: endpoint, launch, wait, timeout, socket.
    """

    def __init__(self, name: str, **where: Any) -> None:
        self.name = check.text("name", name)
        self.fps = 0
        self.dt = 0.0
        self.spaces: Spaces = {}
        # What each agent saw last, as it came.
        self.last: dict[str, Array] = {}
        self.simulators = Simulators(default=ENDPOINT, **where)
        self.ask = self.simulators.connection.ask

    def accept(self, hello: Message) -> None:
        name = take(hello.values, "name", str)
        if name != self.name:
            raise MessageError("wrong-name", f"this environment is {self.name}, the simulator's is {name!a:.40}")
        arrays = list(hello.arrays)
        spaces: Spaces = {}
        for agent, kinds in unpack(take(hello.values, "agents", str)):
            if agent in ("", "env", *spaces):
                raise MessageError("bad-agents", f"{agent!a:.40} is another agent, or stands for the environment")
            observation = space_of(take(kinds, "observation", str), arrays)
            action = space_of(take(kinds, "action", str), arrays)
            spaces[agent] = (observation, action)
        if self.spaces and spaces != self.spaces:
            raise MessageError("other-spaces", f"the simulator before this one had {self.spaces!s:.80}")
        self.fps = frames_per_second(hello)
        self.dt = take(hello.values, "dt", float)
        # The same objects for ever: a trainer that draws actions by chance has seeded them.
        self.spaces = self.spaces or spaces

    def read(self, state: Message, living: list[str]) -> tuple[dict[str, Any], ...]:
        """Observations, rewards, terminated, truncated and infos, each by agent."""
        infos = unpack(take(state.values, "infos", str), reserved=("told", "lost"))
        names = [name for name, _ in infos]
        if names != living or len(state.arrays) != 3 + len(living):
            raise MessageError("wrong-agents", f"a state of {names!s:.80}, but those that live are {living}")
        most = np.finfo(np.float64).max
        flags = Box(0, 1, (len(living),), np.uint8)
        rewards = from_array(Box(-most, most, (len(living),), np.float64), state.arrays[:1]).tolist()
        terminated = from_array(flags, state.arrays[1:2]).astype(bool).tolist()
        truncated = from_array(flags, state.arrays[2:3]).astype(bool).tolist()
        last = dict(zip(living, state.arrays[3:], strict=True))
        seen = self.seen(last)
        told = told_in(state)
        added = {"told": told} if told else {}
        by_agent = [dict(zip(living, each, strict=True)) for each in (rewards, terminated, truncated)]
        self.last = last
        return seen, *by_agent, {agent: {**info, **added} for agent, info in infos}

    def seen(self, arrays: dict[str, Array]) -> dict[str, Any]:
        return {agent: from_array(self.spaces[agent][0], [array]) for agent, array in arrays.items()}


def told_in(answer: Message) -> dict[str, list[Any]]:
    """What the game has sent since the answer before: lists of infos by agent, those of the environment as `env`."""
    told: dict[str, list[Any]] = {}
    for agent, info in unpack(answer.values.get("told", "[]")):
        told.setdefault(agent or "env", []).append(info)
    return told


class ZmqParallelEnv(ParallelEnv[str, Any, Any]):  # type: ignore[misc]
    """The game of one simulator. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    def __init__(self, name: str = "Pursuit", render_mode: Any = None, real_time: bool = False, **where: Any) -> None:
        self.render_mode = known_render_mode(render_mode)
        self.real_time = check.instance("real_time", real_time, bool)
        self.agents: list[str] = []
        # When the next tick is due, in real time.
        self.next = 0.0
        self.picture = np.zeros((240, 320, 3), np.uint8)
        self.random, _ = seeding.np_random()
        self.remote = RemoteAgents(name, **where)
        self.close_once = self.remote.simulators.start(self, self.remote.accept)
        self.possible_agents = list(self.remote.spaces)
        self.metadata = {
            "name": f"NetMQExample/{name}-v0",
            "render_modes": ["rgb_array"],
            "render_fps": self.remote.fps,
        }

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
        # One message for all of them.
        arrays = [to_array(actions[agent], self.action_space(agent).dtype) for agent in self.agents]
        try:
            state = self.remote.ask("step", {}, arrays)
            seen, rewards, terminated, truncated, infos = self.remote.read(state, self.agents)
        except Lost as lost:
            # Nobody knows what came after these observations. They are read anew: their user may have changed them.
            seen = self.remote.seen({agent: self.remote.last[agent] for agent in self.agents})
            rewards = dict.fromkeys(self.agents, 0.0)
            terminated = dict.fromkeys(self.agents, False)
            truncated = dict.fromkeys(self.agents, True)
            infos = {agent: {"lost": str(lost)} for agent in self.agents}
        self.agents = [agent for agent in self.agents if not terminated[agent] and not truncated[agent]]
        return seen, rewards, terminated, truncated, infos

    def send_info(self, info: dict[str, Any], agent: str = "") -> dict[str, list[Any]]:
        """Send an info to an agent, or to the environment; those of the game come back."""
        if agent not in ("", *self.possible_agents):
            raise ValueError(f"agent {agent!r:.40} is none of {self.possible_agents}, nor the environment, ''")
        text = pack([(agent, info)])
        if len(text) > LONGEST:
            raise ValueError(f"an info has at most {LONGEST} characters, not {len(text)}")
        return told_in(self.remote.ask("info", {"infos": text}, []))

    def render(self) -> Any:
        if not gives_pictures(self.render_mode):
            return None
        # A film goes on when the simulator is lost, with the picture before; step says that it is.
        with contextlib.suppress(Lost):
            self.picture = picture(self.remote.ask("render", {}, []).arrays)
        return self.picture

    def close(self) -> None:
        self.close_once()
