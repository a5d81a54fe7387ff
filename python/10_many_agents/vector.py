"""Lesson 10, the vector environment: one simulator with many areas, and each step of all of them is one message.

    import vector, gymnasium
    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", num_envs=16)    waits for a simulator with 16 areas

An area whose episode is over begins anew as `autoreset_mode` says: in the next step, which is Gymnasium's default, in
the same one, or when reset gets a mask. A simulator that is lost ends all episodes: they are truncated, and
`infos["lost"]` says why.
"""

import sys
import weakref
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from remote_areas import RemoteAreas

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "09_environment"))
import environment  # noqa: F401, it registers the environments.
from spaces import drawn, gives_pictures, shown


class ZmqVectorEnv(VectorEnv[Any, Any, Any]):
    """The areas of one simulator. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012, Gymnasium's own way.

    def __init__(
        self,
        num_envs: int,
        name: str,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **where: Any,
    ) -> None:
        self.num_envs, self.mode, self.render_mode = num_envs, AutoresetMode(autoreset_mode), drawn(render_mode)
        self.areas = RemoteAreas(num_envs, name, max_episode_steps or np.inf, **where)
        self.over = np.ones(num_envs, bool)
        # Also when nobody calls close: at garbage collection, and at the end of the program. And only once.
        self.close_once = weakref.finalize(self, self.areas.simulators.close)
        try:
            self.areas.simulators.find(self.areas.accept)
        except BaseException:
            self.close()
            raise
        self.single_observation_space, self.single_action_space = self.areas.spaces
        self.observation_space, self.action_space = (batch_space(space, num_envs) for space in self.areas.spaces)
        self.metadata = {**self.metadata, "autoreset_mode": self.mode, "render_fps": self.areas.fps}

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        options = dict(options or {})
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
        if self.mode == AutoresetMode.DISABLED and self.over.any():
            raise ValueError(f"areas {np.flatnonzero(self.over)} are over: reset(options={{'reset_mask': …}}) first")
        if self.over.all():
            # All were lost, perhaps: then it is another simulator that they begin in.
            seen, infos = self.areas.begin(self.over)
            rewards, terminated, truncated = np.zeros(self.num_envs), ~self.over, ~self.over
        else:
            seen, rewards, terminated, truncated, infos = self.areas.step(actions, self.over)
        self.over = terminated | truncated
        if self.mode == AutoresetMode.SAME_STEP and self.over.any():
            seen, infos = self.begin_at_once(seen, truncated, infos)
        return seen, rewards, terminated, truncated, self.gathered(infos)

    def begin_at_once(self, last: Any, truncated: Any, ends: list[Any]) -> tuple[Any, list[Any]]:
        """Whose episode is over begins the next one, and what it ended with is in its info."""
        seen, infos = self.areas.begin(self.over)
        for area, over in enumerate(self.over):
            final = {"final_obs": last[area], "final_info": ends[area]} if over else ends[area]
            infos[area] = {**final, **infos[area]}
            truncated[area] |= not over and "lost" in infos[area]
        self.over = np.zeros(self.num_envs, bool)
        return seen, infos

    def gathered(self, infos: list[dict[str, Any]]) -> dict[str, Any]:
        """As Gymnasium has them: an array for each name, and beside it one that says whose value is meant."""
        all_of_them = dict[str, Any]()
        for area, info in enumerate(infos):
            all_of_them = self._add_info(all_of_them, info, area)
        return all_of_them

    def render(self) -> tuple[Any, ...] | None:
        return tuple(self.areas.render()) if gives_pictures(self.render_mode) else None

    # As Gymnasium has them: one for each area.
    np_random = property(lambda self: tuple(random for random, _ in self.areas.random))
    np_random_seed = property(lambda self: tuple(seed for _, seed in self.areas.random))

    def close_extras(self, **kwargs: Any) -> None:
        self.close_once()


for name in "CartPole", "Car":
    gymnasium.registry[f"NetMQExample/{name}-v0"].vector_entry_point = f"{__name__}:ZmqVectorEnv"
