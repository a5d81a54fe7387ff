"""Many agents of one kind, each of lesson 11, as a vector environment: one scene, and one message for all of them.

    spaces = {"observation_space": …, "action_space": …}
    envs = gymnasium.make_vec("NetMQExample/Unity-v0", num_envs=16, env_name="Coins", **spaces)        waits for Play

The scene has the agents agent_0 to agent_15: `agent_name`, and a number. Each ends, and begins anew, by itself. Lesson
17's hub has as many scenes in place of them, each with an agent that is called `agent_name`. All else is as in
vector_env.py; what is seen is declared in C#, as for unity_env.py.
"""

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Space
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space, iterate

from netmq_example import arguments
from netmq_example.envs.common import frames_per_second, hello_from
from netmq_example.envs.plan import Sight
from netmq_example.envs.remote_areas import RemoteAreas
from netmq_example.envs.unity_env import (
    ENDPOINT,
    ActionRows,
    check_spaces,
    launched_as,
    scene_options,
)
from netmq_example.envs.vector_env import AreasEnv
from netmq_example.messages import Message, MessageError
from netmq_example.wire.space_bytes import together


class RemoteScene(RemoteAreas):
    """Agents in place of areas, in one scene or in as many."""

    def __init__(
        self, num_envs: int, env_name: str, spaces: list[Space[Any]], agent_name: str, steps: Any, **where: Any
    ) -> None:
        self.agent_name = arguments.text("agent_name", agent_name)
        check_spaces({agent_name: spaces[0]}, {agent_name: spaces[1]})
        super().__init__(num_envs, arguments.text("env_name", env_name), steps, ENDPOINT, **where)
        self.spaces = spaces
        self.together = batch_space(spaces[1], self.count)
        self.rows = ActionRows(agent_name, spaces[1])
        self.names: list[str] = []
        self.sights: list[Sight] = []

    def accept(self, hello: Message) -> None:
        hello_from(hello, self.name)
        areas = hello.values.get("areas")
        if areas not in (None, self.count):
            raise MessageError("wrong-areas", f"num_envs is {self.count}, the hub has {areas!a:.20} scenes")
        each = [f"{self.agent_name}_{number}" for number in range(self.count)]
        self.names = each if areas is None else [self.agent_name] * self.count
        self.sights = [Sight(name, self.spaces[0]) for name in self.names] if self.spaces else []
        self.fps = frames_per_second(hello)

    def options(self, options: Any = None) -> bytes:
        # The hub gives them to each of its scenes as they are.
        return scene_options(self.names[:1] if len({*self.names}) < len(self.names) else self.names, options)

    def action_rows(self, actions: Any) -> list[bytes]:
        return [self.rows.write(action) for action in iterate(self.together, actions)]

    def info(self, data: Any) -> dict[str, Any]:
        # As that of a single environment has both.
        return {"env": [], "agent": [], **super().info(data)}

    def forget(self, mask: Any) -> None:
        for area in np.flatnonzero(mask):
            self.sights[area].forget()

    def look(self, rows: Sequence[Any]) -> Any:
        self.seen = list(rows)
        each = zip(self.sights, rows, strict=True)
        return self.batch([sight.read(row) if row else sight.again() for sight, row in each])

    def look_again(self) -> Any:
        return self.batch([sight.again() for sight in self.sights])

    def batch(self, each: list[Any]) -> Any:
        return together(self.sights[0].space, each)


class UnityVectorEnv(AreasEnv):
    """`where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012, Gymnasium's own way.

    def __init__(
        self,
        num_envs: int,
        env_name: str,
        observation_space: Space[Any],
        action_space: Space[Any],
        agent_name: str = "agent",
        file_name: str | os.PathLike[str] | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **where: Any,
    ) -> None:
        if render_mode is not None:
            raise ValueError(f"render_mode takes None, not {render_mode!r:.40}: lesson 12 makes films")
        spaces = [observation_space, action_space]
        where = launched_as(file_name, where)
        areas = RemoteScene(num_envs, env_name, spaces, agent_name, max_episode_steps, **where)
        super().__init__(areas, autoreset_mode, render_mode)
