"""An environment of several agents: a PettingZoo ParallelEnv, and each step of all of them is one message.

    from netmq_example.envs import ZmqParallelEnv

    env = ZmqParallelEnv("Pursuit")                            waits for a simulator on tcp://127.0.0.1:5560
    env = ZmqParallelEnv("Pursuit", launch="Build/Pursuit")                 starts the game by its path

An agent that ends leaves `agents`. A simulator that is lost ends the episode of all: they are truncated, and each one's
info has `lost`; the next reset waits for another one. Each one's info has the game's infos as `told`: a list
for each agent, those of the environment as `env`. `send_info` is the other way, at any time. With
`real_time=True` the world goes on while Python thinks, and a step waits for the next tick. The C# side is
AgentSimulator.cs.
It needs pettingzoo.
"""

import contextlib
import time
from typing import Any

from gymnasium.spaces import Space
from gymnasium.utils import seeding
from pettingzoo import ParallelEnv

from netmq_example import arguments, check
from netmq_example.envs.common import (
    MadeAnew,
    frames_per_second,
    gives_pictures,
    hello_from,
    info_in,
    known_render_mode,
    no_picture,
    observation_and_action,
    options_as_bytes,
    picture,
    same,
)
from netmq_example.envs.connection import Simulators
from netmq_example.errors import Lost
from netmq_example.messages import Message, MessageError, take
from netmq_example.wire import trees
from netmq_example.wire.records import ASKS, NOTHING, RESET, STEP, TERMINATED, TRUNCATED, Record, rewards_in, seeds
from netmq_example.wire.space_bytes import Bytes
from netmq_example.wire.spaces import shown

ENDPOINT = "tcp://127.0.0.1:5560"
# Bytes of an info.
LONGEST_INFO = 12_000

Spaces = dict[str, list[Space[Any]]]


class RemoteAgents:
    """The agents as messages: their spaces, and what a state has of each.

    `where` is what Simulators takes: endpoint, launch, wait, timeout, socket.
    """

    def __init__(self, name: str, **where: Any) -> None:
        self.name = arguments.text("name", name)
        self.fps = 0
        self.dt = 0.0
        self.spaces: Spaces = {}
        self.bytes: dict[str, list[Bytes]] = {}
        # Each agent's last observation, as bytes.
        self.last: dict[str, Any] = {}
        self.simulators = Simulators(default=ENDPOINT, **where)
        self.ask = self.simulators.connection.ask

    def accept(self, hello: Message) -> None:
        spaces: Spaces = {}
        for pair in take(hello_from(hello, self.name), "agents", list):
            agent, described = pair if type(pair) is list and len(pair) == 2 else (None, None)
            if not isinstance(agent, str) or agent in ("", "env", *spaces):
                raise MessageError("bad-agents", f"{agent!a:.40} is another agent, or stands for the environment")
            spaces[agent] = observation_and_action(described)
        if not spaces:
            raise MessageError("bad-agents", f"{self.name} has no agents")
        self.fps = frames_per_second(hello)
        self.dt = take(hello.values, "dt", float)
        self.spaces = same(spaces, self.spaces)
        self.bytes = {agent: [Bytes(space) for space in both] for agent, both in self.spaces.items()}

    def request(self, order: int, rows: dict[str, bytes], seed: int = 0, options: bytes = b"") -> Record:
        """For those agents that have a row; the others have no part in it."""
        orders = [order if agent in rows else NOTHING for agent in self.spaces]
        each = [rows.get(agent, b"") for agent in self.spaces]
        return Record(ASKS, 0, seeds([seed] * len(orders)), orders, each, options=options)

    def read(self, state: Record, living: list[str]) -> tuple[dict[str, Any], ...]:
        """Observations, rewards, terminated, truncated and infos, each by agent."""
        at = {agent: number for number, agent in enumerate(self.spaces) if agent in living}
        rewards = rewards_in(state)
        last = {agent: state.rows[number] for agent, number in at.items()}
        seen = self.seen(last)
        game_infos = infos_in(state.options)
        infos = {}
        for agent, number in at.items():
            info = info_in(state.infos[number])
            if not info.keys().isdisjoint(("told", "lost")):
                raise MessageError("bad-info", "these names are the environment's own: told, lost")
            infos[agent] = {**info, "told": game_infos} if game_infos else info
        self.last = last
        ends = {agent: state.flags[number] for agent, number in at.items()}
        return (
            seen,
            {agent: rewards[number] for agent, number in at.items()},
            {agent: bool(end & TERMINATED) for agent, end in ends.items()},
            {agent: bool(end & TRUNCATED) for agent, end in ends.items()},
            infos,
        )

    def seen(self, rows: dict[str, Any]) -> dict[str, Any]:
        return {agent: self.bytes[agent][0].read(row) for agent, row in rows.items()}


def infos_in(data: Any) -> dict[str, list[Any]]:
    """The game's infos since the last answer: a list for each agent, those of the environment as `env`."""
    infos: dict[str, list[Any]] = {}
    pairs = trees.read(data) if data else []
    for pair in pairs if type(pairs) is list else [pairs]:
        if type(pair) is not list or [type(part) for part in pair] != [str, dict]:
            raise MessageError("bad-info", f"{pair!a:.40} is no agent and its info")
        infos.setdefault(pair[0] or "env", []).append(pair[1])
    return infos


class ZmqParallelEnv(MadeAnew, ParallelEnv[str, Any, Any]):  # type: ignore[misc]
    """The game of one simulator. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    def __init__(self, name: str = "Pursuit", render_mode: Any = None, real_time: bool = False, **where: Any) -> None:
        self.render_mode = known_render_mode(render_mode)
        self.real_time = check.instance("real_time", real_time, bool)
        self.agents: list[str] = []
        # When the next tick is due, in real time.
        self.next = 0.0
        self.picture = no_picture()
        self.random, _ = seeding.np_random()
        self.remote = RemoteAgents(name, **where)
        self.close_once = self.remote.simulators.start(self, self.remote.accept)
        self.possible_agents = list(self.remote.spaces)
        self.observation_spaces = {agent: spaces[0] for agent, spaces in self.remote.spaces.items()}
        self.action_spaces = {agent: spaces[1] for agent, spaces in self.remote.spaces.items()}
        self.metadata = {
            "name": f"NetMQExample/{name}-v0",
            "render_modes": ["rgb_array"],
            "render_fps": self.remote.fps,
            "is_parallelizable": True,
        }

    def observation_space(self, agent: str) -> Space[Any]:
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space[Any]:
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, Any]:
        if seed is not None:
            self.random, _ = seeding.np_random(seed)
        # The simulator gets a seed each time, so that an episode never depends on the one before.
        seed = int(self.random.integers(2**53)) if seed is None else seed
        data = options_as_bytes(options, real_time=self.real_time)
        request = self.remote.request(RESET, dict.fromkeys(self.possible_agents, b""), seed, data)
        state = self.remote.simulators.begin(self.remote.accept, lambda _: self.remote.ask(request))
        self.next = time.monotonic() + self.remote.dt
        self.agents = self.possible_agents[:]
        seen, *_, infos = self.remote.read(state, self.agents)
        return seen, infos

    def step(self, actions: dict[str, Any]) -> tuple[Any, Any, Any, Any, Any]:
        if not isinstance(actions, dict) or actions.keys() != set(self.agents):
            raise ValueError(f"actions {actions!r:.200}, but those that live are {self.agents}")
        if not actions:
            # Wrappers step once more when all are over; PettingZoo's own environments have nothing to say then.
            return {}, {}, {}, {}, {}
        for agent, action in actions.items():
            if action not in self.action_space(agent):
                raise ValueError(f"action {shown(action)} of {agent} is not in {shown(self.action_space(agent))}")
        if self.real_time:
            time.sleep(max(0.0, self.next - time.monotonic()))
            self.next = time.monotonic() + self.remote.dt
        # One message for all of them.
        rows = {agent: self.remote.bytes[agent][1].write(action) for agent, action in actions.items()}
        try:
            state = self.remote.ask(self.remote.request(STEP, rows))
            seen, rewards, terminated, truncated, infos = self.remote.read(state, self.agents)
        except Lost as lost:
            # The last observations stand for unknown ones. They are read again: their user may have changed them.
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
        try:
            data = trees.write([agent, check.instance("info", info, dict)])
        except MessageError as error:
            raise ValueError(f"the info cannot be sent: {error}") from None
        if len(data) > LONGEST_INFO:
            raise ValueError(f"an info has at most {LONGEST_INFO} bytes, not {len(data)}")
        answer = self.remote.ask(Message("info", 0, {}, [trees.array_of(data)]))
        return infos_in(answer.arrays[0].data if answer.arrays else b"")

    def render(self) -> Any:
        if not gives_pictures(self.render_mode):
            return None
        # A film goes on when the simulator is lost, with the picture before; step says that it is.
        with contextlib.suppress(Lost):
            self.picture = picture(self.remote.ask(Message("render")).arrays)
        return self.picture

    def close(self) -> None:
        self.close_once()
