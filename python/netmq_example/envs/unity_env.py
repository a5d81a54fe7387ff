"""An agent of a Unity scene for Gymnasium. Several agents at once are in unity_parallel_env.py.

    import gymnasium
    import netmq_example.envs                          registers it, where the package is not installed

    env = gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", observation_space=…, action_space=…)
    seen, info = env.reset(seed=1)
    seen, reward, terminated, truncated, info = env.step(action)

Without `launch=["Build/Coins.exe"]`, or `file_name="Build/Coins"`, it waits for Play. The spaces are declared here;
what is in them is declared in C#, at the fields that hold it.

`info` is {"env": [...], "agent": [...]}, what the scene and the agent have sent since the last answer. If the simulator
is lost, or the agent has left, the episode is truncated, and `info["lost"]` says why. MessageError is the simulator's
refusal, or says what is wrong with its answer. In C# the other side is SceneSimulator.cs. It needs gymnasium and numpy.
"""

import os
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
from gymnasium.spaces import Space

from netmq_example import arguments
from netmq_example.envs.common import MadeAnew, frames_per_second, hello_from, info_in, options_as_bytes
from netmq_example.envs.connection import Simulators
from netmq_example.envs.merge import empty, fitted
from netmq_example.envs.plan import Sight, form_in
from netmq_example.envs.rendering import MODES, Rendered, check_words
from netmq_example.errors import Lost
from netmq_example.locator import quoted
from netmq_example.messages import ENCODER, Message, MessageError
from netmq_example.wire import trees
from netmq_example.wire.records import (
    ABSENT,
    ASKS,
    NOTHING,
    RESET,
    STEP,
    TERMINATED,
    TRUNCATED,
    Record,
    rewards_in,
    seeds,
)
from netmq_example.wire.space_bytes import codec_of
from netmq_example.wire.trees import SIZE

Spaces = dict[str, Space[Any]]
ENDPOINT = "tcp://127.0.0.1:5561"


class UnityGymEnv(MadeAnew, Rendered, gymnasium.Env[Any, Any]):
    """One agent. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket.

    Pictures and films, and what `views`, `render_fps` and `view_endpoint` are for, are in rendering.py.
    """

    metadata: dict[str, Any] = {"render_modes": MODES, "render_fps": 50}  # noqa: RUF012, Gymnasium's own way.

    def __init__(
        self,
        env_name: str,
        observation_space: Space[Any],
        action_space: Space[Any],
        agent_name: str = "agent",
        file_name: str | os.PathLike[str] | None = None,
        render_mode: str | None = None,
        views: Sequence[str] = ("",),
        render_fps: float | None = None,
        view_endpoint: str = "",
        **where: Any,
    ) -> None:
        check_words(render_mode, views, render_fps)
        self.observation_space = observation_space
        self.action_space = action_space
        self.name = arguments.text("agent_name", agent_name)
        self.agents = Agents(env_name, {self.name: observation_space}, {self.name: action_space}, file_name, **where)
        self.show(self.agents.simulators, render_mode, views, view_endpoint)
        # Also when nobody calls close: at garbage collection, and at the end of the program. And only once.
        self.close_once = self.started(self.agents.simulators, self.agents.accept)
        self.metadata = {**self.metadata, "render_fps": render_fps or self.agents.fps}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        # The scene gets a seed each time, so that an episode never depends on the one before.
        seed = int(self.np_random.integers(2**53)) if seed is None else int(seed)
        seen, info = self.agents.reset([self.name], seed, options)[self.name]
        self.filmed(begins=True)
        return seen, info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if not self.agents.names:
            raise gymnasium.error.ResetNeeded("call reset before step")
        seen, reward, terminated, truncated, info = self.agents.step({self.name: action})[self.name]
        self.filmed(begins=False)
        return seen, reward, terminated, truncated, info

    def send_info(self, info: Any, agent: str | None = None) -> None:
        """To the scene itself, or to an agent: what a value is, trees.py says. `bytes` are C#'s `byte[]`."""
        self.agents.send_info(info, agent or "")

    def close(self) -> None:
        self.end_films()
        self.close_once()


class Agents:
    """Some agents of a scene, whose observations and actions are one message.

    agents = Agents("Coins", {"car": observation_space}, {"car": action_space})
    agents.simulators.start(owner, agents.accept)                                     waits for Play
    seen, info = agents.reset(["car"], seed=1)["car"]
    seen, reward, terminated, truncated, info = agents.step({"car": action})["car"]

    An answer is complete: for several agents it waits until all of them have one. What a message does not write stays
    as it was; what it writes must fit the spaces. Observations are copies. `where` is what Simulators takes;
    `file_name` is gymize's name for its `launch`.
    """

    def __init__(
        self,
        env_name: str,
        observations: Spaces,
        actions: Spaces,
        file_name: str | os.PathLike[str] | None = None,
        **where: Any,
    ) -> None:
        self.env_name = arguments.text("env_name", env_name)
        check_spaces(observations, actions)
        self.sights = {name: Sight(name, space) for name, space in observations.items()}
        self.actions = {name: ActionRows(name, space) for name, space in actions.items()}
        # Those of the last reset, whose rows are in this order.
        self.names: list[str] = []
        self.fps = 0
        self.simulators = Simulators(default=ENDPOINT, **launched_as(file_name, where))

    def accept(self, hello: Message) -> None:
        hello_from(hello, self.env_name)
        self.fps = max(1, frames_per_second(hello))

    def reset(self, names: list[str], seed: int, options: dict[str, Any] | None = None) -> dict[str, Any]:
        """Observation and info of each."""
        data = scene_options(names, options)
        count = len(names)
        request = Record(ASKS, 0, seeds([seed] * count), [RESET] * count, [b""] * count, options=data)
        state = self.simulators.begin(self.accept, lambda _: self.simulators.connection.ask(request))
        self.names = list(names)
        for sight in self.sights.values():
            sight.forget()
        results = self.results(names, state)
        # A value that only C# has was an error. One that only Python has may come later, as of a disabled sensor.
        for name, row in zip(names, state.rows, strict=True):
            if row:
                self.sights[name].warn(row)
        return {name: (result[0], result[-1]) for name, result in results.items()}

    def step(self, actions: dict[str, Any]) -> dict[str, Any]:
        """Observation, reward, terminated, truncated and info of each."""
        rows = {name: self.actions[name].write(action) for name, action in actions.items()}
        orders = [STEP if name in rows else NOTHING for name in self.names]
        each = [rows.get(name, b"") for name in self.names]
        try:
            state = self.simulators.connection.ask(Record(ASKS, 0, bytes(8 * len(each)), orders, each))
        except Lost as lost:
            return {name: self.gone(name, str(lost)) for name in actions}
        return self.results(actions, state)

    def send_info(self, info: Any, to: str) -> None:
        """To an agent's OnInfo; to "", the scene's."""
        try:
            data = trees.write([to, info])
        except MessageError as error:
            raise ValueError(f"the info cannot be sent: {error}") from None
        self.simulators.connection.ask(Message("info", 0, {}, [trees.array_of(data)]))

    def results(self, names: Any, state: Record) -> dict[str, Any]:
        """The results of these agents in a state."""
        rewards = rewards_in(state)
        results = dict[str, Any]()
        for at, name in enumerate(self.names):
            if name not in names:
                continue
            ends = state.flags[at]
            info = {"env": [], "agent": [], **info_in(state.infos[at])}
            if ends & ABSENT:
                # An agent that was over by then has ended as it said; the episode of another one is cut.
                seen = self.sights[name].again()
                if ends == ABSENT:
                    ends |= TRUNCATED
                    info["lost"] = f"agent {name} has left the scene"
            else:
                seen = self.sights[name].read(state.rows[at])
            results[name] = seen, rewards[at], bool(ends & TERMINATED), bool(ends & TRUNCATED), info
        return results

    def gone(self, name: str, why: str) -> tuple[Any, ...]:
        """Nothing after its last observation is known."""
        return self.sights[name].again(), 0.0, False, True, {"env": [], "agent": [], "lost": why}


class ActionRows:
    """Actions of one space as values (trees.py)."""

    def __init__(self, name: str, space: Space[Any]) -> None:
        self.where = f"action of {name}"
        self.space = space
        # Of most spaces the form is always the same: then what is in the space is written as its numbers alone.
        self.codec = codec_of(space)
        self.head = fixed_form(space)

    def write(self, action: Any) -> bytes:
        if not self.head or action not in self.space:
            return trees.write(fitted(self.space, action, self.where))
        parts = [self.head]
        self.codec.write(action, parts)
        return b"".join(parts)


def fixed_form(space: Space[Any]) -> bytes:
    """The beginning of each value of a space, if that is always the same; else nothing."""
    form = form_in(space)
    if form is None:
        return b""
    text = ENCODER.encode(form).encode()
    return SIZE.pack(len(text)) + text


def scene_options(names: Sequence[str], options: dict[str, Any] | None) -> bytes:
    """The part that each reset carries: whose rows these are, and the options."""
    options_as_bytes(options)
    return trees.write({"agents": list(names), "options": dict(options or {})})


def launched_as(file_name: Any, where: dict[str, Any]) -> dict[str, Any]:
    if file_name is None:
        return where
    if not isinstance(file_name, str | os.PathLike) or not os.fspath(file_name):
        raise ValueError(f"file_name takes the path of a game, not {file_name!r:.40}")
    return {"launch": file_name, **where}


def check_spaces(observations: Any, actions: Any) -> None:
    """Refuse a space that has no place in a message, before the wait for a simulator."""
    for which, each in (("observation", observations), ("action", actions)):
        if not isinstance(each, Mapping) or not each:
            raise ValueError(f"{which} spaces take a dict of agents and spaces, not {each!r:.40}")
    if observations.keys() != actions.keys():
        raise ValueError(f"the agents with observations are {[*observations]}, those with actions {[*actions]}")
    for name, space in observations.items():
        empty(space, f"{quoted(arguments.text('the name of an agent', name))}@")
        empty(actions[name], f"action of {name}")
