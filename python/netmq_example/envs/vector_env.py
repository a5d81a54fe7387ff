"""A vector environment: one simulator with many areas, and each step of all of them is one message.

    import gymnasium
    import netmq_example.envs

    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", num_envs=16)    waits for a simulator with 16 areas

Arrays and infos are those of Gymnasium's SyncVectorEnv with as many environments. A finished area resets as
`autoreset_mode` says: in the next step, which is Gymnasium's default, in the same one, or when reset gets a mask. A
simulator that is lost ends all episodes: they are truncated, and `infos["lost"]` says why. The C# side is
AreaSimulator.cs. For agents of lesson 11 it is unity_vector_env.py.
"""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space, iterate

from netmq_example.envs.common import (
    MadeAnew,
    checked_options,
    gives_pictures,
    known_render_mode,
)
from netmq_example.envs.remote_areas import RemoteAreas
from netmq_example.wire.spaces import shown


class AreasEnv(MadeAnew, VectorEnv[Any, Any, Any]):
    """RemoteAreas with the methods of Gymnasium's vector environments."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012, Gymnasium's own way.
    # Until it is made: Gymnasium closes what is forgotten, also when there is nothing yet to be closed.
    closed = True

    def __init__(self, areas: RemoteAreas, autoreset_mode: AutoresetMode | str, render_mode: str | None) -> None:
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.observation_mode = "same"
        self.render_mode = known_render_mode(render_mode)
        self.areas = areas
        self.num_envs = areas.count
        self.over = np.ones(self.num_envs, bool)
        self.close_once = areas.simulators.start(self, areas.accept)
        spaces: Any = areas.spaces
        self.single_observation_space, self.single_action_space = spaces
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode, "render_fps": areas.fps}
        self.closed = False

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        options = checked_options(options)
        mask = np.asarray(options.pop("reset_mask", np.ones(self.num_envs, bool)))
        if mask.shape != (self.num_envs,) or mask.dtype != bool or not mask.any():
            raise ValueError(f"reset_mask must be {self.num_envs} times true or false, one of them true: {mask!r:.80}")
        seen, infos = self.areas.begin(mask, seed, options)
        self.over[mask] = False
        return seen, self.gathered(infos)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        if not self.areas.seen:
            raise gymnasium.error.ResetNeeded("call reset before step")
        if actions not in self.action_space:
            raise ValueError(f"actions {shown(actions)} are not in {shown(self.action_space)}")
        if self.autoreset_mode == AutoresetMode.DISABLED and self.over.any():
            raise ValueError(f"areas {np.flatnonzero(self.over)} are over: reset(options={{'reset_mask': …}}) first")
        if self.over.all():
            # All were lost, perhaps: then it is another simulator that they begin in.
            seen, infos = self.areas.begin(self.over)
            rewards, terminated, truncated = np.zeros(self.num_envs), ~self.over, ~self.over
        else:
            seen, rewards, terminated, truncated, infos = self.areas.step(actions, self.over)
        self.over = terminated | truncated
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self.over.any():
            seen, infos = self.begin_at_once(seen, truncated, infos)
        return seen, rewards, terminated, truncated, self.gathered(infos)

    def begin_at_once(self, last: Any, truncated: Any, ends: list[Any]) -> tuple[Any, list[Any]]:
        """Finished areas begin their next episode. Its info has the last observation and info of the old one."""
        each = list(iterate(self.observation_space, last))
        seen, infos = self.areas.begin(self.over)
        for area, over in enumerate(self.over):
            final = {"final_obs": each[area], "final_info": ends[area]} if over else ends[area]
            infos[area] = {**final, **infos[area]}
            if not over and "lost" in infos[area]:
                truncated[area] = True
        self.over = np.zeros(self.num_envs, bool)
        return seen, infos

    def gathered(self, infos: list[dict[str, Any]]) -> dict[str, Any]:
        """As Gymnasium has them: an array for each name, and beside it one that says whose value is meant."""
        all_of_them: dict[str, Any] = {}
        for area, info in enumerate(infos):
            if info:
                all_of_them = self._add_info(all_of_them, info, area)
        return all_of_them

    def render(self) -> tuple[Any, ...] | None:
        return tuple(self.areas.render()) if gives_pictures(self.render_mode) else None

    # As Gymnasium's own vector environments have them: one for each area.
    np_random = property(lambda self: tuple(random for random, _ in self.areas.random))
    np_random_seed = property(lambda self: tuple(seed for _, seed in self.areas.random))

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """The attribute that an environment of one area would have, once for each: only pictures differ."""
        if name in ("reset", "step", "close"):
            raise ValueError(f"call {name} of the vector environment itself, not by call")
        if name == "render":
            return self.render() or (None,) * self.num_envs
        if name in ("np_random", "np_random_seed"):
            return tuple(getattr(self, name))
        single = {"observation_space": "single_observation_space", "action_space": "single_action_space"}
        value = getattr(self, single.get(name, name))
        return (value(*args, **kwargs) if callable(value) else value,) * self.num_envs

    def get_attr(self, name: str) -> tuple[Any, ...]:
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """One value for all areas, or a list of equal ones: they are one simulator."""
        each = list(values) if isinstance(values, list | tuple) else [values]
        if any(value != each[0] for value in each[1:]):
            raise ValueError(f"{name} is the same for all areas, not {values!r:.80}")
        setattr(self, name, each[0])

    def close_extras(self, **kwargs: Any) -> None:
        self.close_once()


class ZmqVectorEnv(AreasEnv):
    """The areas of one simulator. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    def __init__(
        self,
        num_envs: int,
        name: str,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **where: Any,
    ) -> None:
        known_render_mode(render_mode)
        super().__init__(RemoteAreas(num_envs, name, max_episode_steps, **where), autoreset_mode, render_mode)
