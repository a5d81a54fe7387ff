"""Several agents of a Unity scene for PettingZoo: all at once, or one after the other.

    spaces = {"observation_spaces": {"car": …, "bus": …}, "action_spaces": {"car": …, "bus": …}}
    env = UnityParallelEnv("Coins", **spaces)                           waits for Play
    seen, infos = env.reset(seed=1)
    seen, rewards, terminations, truncations, infos = env.step({"car": …, "bus": …})

    env = UnityAECEnv("Coins", **spaces)                                one after the other, as env.agent_iter() says

Infos, errors, and where the simulator comes from are those of unity_env.py. It needs pettingzoo, gymnasium and numpy.
"""

import copy
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Space
from pettingzoo import ParallelEnv
from pettingzoo.utils import BaseWrapper, parallel_to_aec

from netmq_example.envs.common import MadeAnew
from netmq_example.envs.rendering import MODES, Rendered, check_words
from netmq_example.envs.unity_env import Agents, Spaces


class UnityParallelEnv(MadeAnew, Rendered, ParallelEnv):  # type: ignore[misc, unused-ignore]
    """Agents may end one after the other. `where` is what Simulators takes; films are in rendering.py."""

    def __init__(
        self,
        env_name: str,
        observation_spaces: Spaces,
        action_spaces: Spaces,
        file_name: str | os.PathLike[str] | None = None,
        render_mode: str | None = None,
        views: Sequence[str] = ("",),
        render_fps: float | None = None,
        view_endpoint: str = "",
        **where: Any,
    ) -> None:
        check_words(render_mode, views, render_fps)
        self.observation_spaces = copies(observation_spaces)
        self.action_spaces = copies(action_spaces)
        self.scene = Agents(env_name, self.observation_spaces, self.action_spaces, file_name, **where)
        self.show(self.scene.simulators, render_mode, views, view_endpoint)
        # Also when nobody calls close: at garbage collection, and at the end of the program. And only once.
        self.close_once = self.started(self.scene.simulators, self.scene.accept)
        self.metadata = {
            "name": env_name,
            "render_modes": MODES,
            "render_fps": render_fps or self.scene.fps,
            "is_parallelizable": True,
        }
        self.possible_agents = list(self.observation_spaces)
        self.agents: list[str] = []
        self.random = np.random.default_rng()

    # The same object each time: a caller that samples has seeded it.
    def observation_space(self, agent: str) -> Space[Any]:
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space[Any]:
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], ...]:
        """Observations and infos."""
        if seed is not None:
            self.random = np.random.default_rng(seed)
        self.agents = self.possible_agents.copy()
        results = by_agent(self.scene.reset(self.agents, int(self.random.integers(2**53)), options), 2)
        self.filmed(begins=True)
        return results

    def step(self, actions: dict[str, Any]) -> tuple[dict[str, Any], ...]:
        """Observations, rewards, terminations, truncations and infos, also of those that end with this step."""
        if not isinstance(actions, dict) or actions.keys() != set(self.agents):
            raise ValueError(f"actions {actions!r:.200}, but those that live are {self.agents}")
        if not actions:
            # Wrappers step once more when all are over; PettingZoo's own environments have nothing to say then.
            return {}, {}, {}, {}, {}
        results = by_agent(self.scene.step({name: actions[name] for name in self.agents}), 5)
        _, _, terminations, truncations, _ = results
        self.agents = [name for name in self.agents if not terminations[name] and not truncations[name]]
        self.filmed(begins=False)
        return results

    def send_info(self, info: Any, agent: str = "") -> None:
        """To an agent, or to the scene itself, which is ""."""
        self.scene.send_info(info, agent)

    def close(self) -> None:
        self.end_films()
        self.close_once()


class UnityAECEnv(MadeAnew, BaseWrapper):  # type: ignore[misc, unused-ignore]
    """One after the other: it takes what UnityParallelEnv takes. Nothing moves until the last agent has chosen."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(parallel_to_aec(UnityParallelEnv(*args, **kwargs)))

    def send_info(self, info: Any, agent: str = "") -> None:
        """To an agent, or to the scene itself, which is ""."""
        self.unwrapped.send_info(info, agent)

    def begin_render(self, screen_width: int = -1, screen_height: int = -1, fullscreen: bool = False) -> None:
        """As in rendering.py."""
        self.unwrapped.begin_render(screen_width, screen_height, fullscreen)

    def end_render(self) -> None:
        """As in rendering.py."""
        self.unwrapped.end_render()

    def render_all(self, video_paths: Any = None) -> dict[str, Any]:
        """As in rendering.py."""
        films: dict[str, Any] = self.unwrapped.render_all(video_paths)
        return films


def copies(spaces: Spaces) -> Spaces:
    """A sample from the space of one agent must not change the samples of another one."""
    return {name: copy.deepcopy(space) for name, space in spaces.items()} if isinstance(spaces, Mapping) else spaces


def by_agent(results: dict[str, Any], count: int) -> tuple[dict[str, Any], ...]:
    """For each agent a tuple of so many things becomes for each thing a dict of the agents."""
    return tuple({name: result[at] for name, result in results.items()} for at in range(count))
