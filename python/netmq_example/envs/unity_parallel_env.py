"""Lesson 11, several agents of a Unity scene as PettingZoo wants them.

env = unity_parallel.UnityParallelEnv("Coins", observation_spaces={"car": …, "bus": …}, action_spaces={…})
env = pettingzoo.utils.parallel_to_aec(env)                          one after the other
"""

import copy
import weakref
from typing import Any

import numpy as np
from gymnasium.spaces import Space
from pettingzoo import ParallelEnv

from netmq_example.envs.unity_env import Agents, Spaces


def own(spaces: Spaces) -> Spaces:
    """Copies: who samples from the space of one agent must not change what another one samples."""
    return {name: copy.deepcopy(space) for name, space in spaces.items()}


class UnityParallelEnv(ParallelEnv):  # type: ignore[misc, unused-ignore]
    """Agents may end one after the other. `where` is what lesson 09's Simulators takes."""

    def __init__(
        self,
        env_name: str,
        observation_spaces: Spaces,
        action_spaces: Spaces,
        file_name: str | None = None,
        render_mode: str | None = None,
        **where: Any,
    ) -> None:
        self.metadata = {"name": env_name, "render_modes": []}
        self.observation_spaces, self.action_spaces = own(observation_spaces), own(action_spaces)
        if render_mode is not None:
            raise ValueError(f"render_mode takes None, not {render_mode!r:.40}: lesson 12 makes films")
        self.render_mode = render_mode
        self.possible_agents, self.agents = list(observation_spaces), list[str]()
        self.random = np.random.default_rng()
        where = {"launch": file_name or (), **where}
        self.scene = Agents(env_name, self.observation_spaces, self.action_spaces, **where)
        self.close_once = weakref.finalize(self, self.scene.simulators.close)

    # The same object each time: whoever samples has seeded it.
    def observation_space(self, agent: str) -> Space[Any]:
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space[Any]:
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], ...]:
        """Observations and infos."""
        if seed is not None:
            self.random = np.random.default_rng(seed)
        self.agents = self.possible_agents.copy()
        said = self.scene.reset(self.agents, int(self.random.integers(2**53)), options)
        return tuple({name: parts[at] for name, parts in said.items()} for at in range(2))

    def step(self, actions: dict[str, Any]) -> tuple[dict[str, Any], ...]:
        """Observations, rewards, terminations, truncations and infos, also of those that end with this step."""
        if not isinstance(actions, dict) or not actions or actions.keys() != set(self.agents):
            raise ValueError(f"actions {actions!r:.200}, but those that live are {self.agents}")
        said = self.scene.step({name: actions[name] for name in self.agents})
        self.agents = [name for name, (_, _, *ends, _) in said.items() if not any(ends)]
        return tuple({name: parts[at] for name, parts in said.items()} for at in range(5))

    def send_info(self, info: Any, agent: str = "") -> None:
        """To an agent, or to the scene itself, which is ""."""
        self.scene.send_info(info, agent)

    def close(self) -> None:
        self.close_once()
