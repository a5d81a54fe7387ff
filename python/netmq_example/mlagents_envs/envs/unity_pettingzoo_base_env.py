"""The common half of UnityAECEnv and UnityParallelEnv, as in mlagents_envs.envs.unity_pettingzoo_base_env.

Its agents are those that wanted an action or have ended in the last step, each `Behavior?team=0?agent_id=3`. An agent
that has ended and began anew in the same step is shown at its end first, and wants an action again after the next step.
Agents with choices see {"observation": …, "action_mask": …}: an array for each branch, in which True is forbidden as in
ML-Agents' steps. PettingZoo's own environments have it the other way round.
"""

from typing import Any

import numpy as np

from netmq_example.mlagents_envs.base_env import ActionTuple, BaseEnv
from netmq_example.mlagents_envs.envs.env_helpers import _agent_id_to_behavior, _behavior_to_agent_id, find_spaces
from netmq_example.mlagents_envs.exception import UnityActionException, UnityException


class UnityPettingzooBaseEnv:
    """`seed` is that of the action spaces. Closing it closes the environment."""

    def __init__(self, env: BaseEnv, seed: int | None = None, metadata: dict[str, Any] | None = None) -> None:
        self._env = env
        self._seed = seed
        self.metadata = metadata or {}
        manager = getattr(env, "_side_channel_manager", None)
        channels = getattr(manager, "_side_channels_dict", {})
        self.side_channel = {type(channel).__name__: channel for channel in channels.values()}
        self._agent_index = 0
        self._possible_agents: set[str] = set()
        self._action_spaces: dict[str, Any] = {}
        self._observation_spaces: dict[str, Any] = {}
        self._forget()
        self.is_closed = False
        if not env.behavior_specs:
            # The first step is a reset, which brings the names.
            env.step()
            self._update()
        self._make_spaces()

    def _forget(self) -> None:
        # All that are in the last step, and those of them that have not been taken leave of.
        self._agents: list[str] = []
        self._live_agents: list[str] = []
        self._observations: dict[str, Any] = {}
        self.rewards: dict[str, float] = {}
        self._cumm_rewards: dict[str, float] = {}
        self.dones: dict[str, bool] = {}
        self.infos: dict[str, dict[str, Any]] = {}
        # An agent's row in its behavior's actions.
        self._rows: dict[str, int] = {}
        self._current_action: dict[str, ActionTuple] = {}

    def _assert_loaded(self) -> None:
        if self.is_closed:
            raise UnityException("the environment is closed")

    def _make_spaces(self) -> None:
        """Behaviors may come later."""
        spaces = find_spaces()
        for name, spec in self._env.behavior_specs.items():
            if name in self._action_spaces:
                continue
            seen = [spaces.Box(-np.inf, np.inf, each.shape, np.float32) for each in spec.observation_specs]
            self._observation_spaces[name] = seen[0] if len(seen) == 1 else spaces.Tuple(seen)
            parts = []
            if spec.action_spec.continuous_size:
                parts.append(spaces.Box(-1, 1, (spec.action_spec.continuous_size,), np.float32))
            if spec.action_spec.discrete_size == 1:
                parts.append(spaces.Discrete(spec.action_spec.discrete_branches[0]))
            elif spec.action_spec.discrete_size:
                parts.append(spaces.MultiDiscrete(spec.action_spec.discrete_branches))
            if not parts:
                raise UnityException(f"the agents of {name} have no actions")
            self._action_spaces[name] = parts[0] if len(parts) == 1 else spaces.Tuple(parts)
            if self._seed is not None:
                self._action_spaces[name].seed(self._seed)

    def action_space(self, agent: str) -> Any:
        return self._action_spaces[_agent_id_to_behavior(agent)]

    def observation_space(self, agent: str) -> Any:
        return self._observation_spaces[_agent_id_to_behavior(agent)]

    @property
    def action_spaces(self) -> dict[str, Any]:
        return {agent: self.action_space(agent) for agent in self._possible_agents}

    @property
    def observation_spaces(self) -> dict[str, Any]:
        return {agent: self.observation_space(agent) for agent in self._possible_agents}

    def _process_action(self, current_agent: str, action: Any) -> None:
        """An agent that has ended takes None, and is gone."""
        if self.dones[current_agent]:
            self._live_agents.remove(current_agent)
            each: dict[str, Any]
            for each in (self._observations, self.dones, self.rewards, self._cumm_rewards, self.infos):
                del each[current_agent]
            return
        name, row = _agent_id_to_behavior(current_agent), self._rows[current_agent]
        spec = self._env.behavior_specs[name].action_spec
        parts = [*action] if spec.continuous_size and spec.discrete_size else [action]
        space = self._action_spaces[name]
        wanted = [*space] if len(parts) == 2 else [space]
        parts = [np.asarray(part, kind.dtype) for part, kind in zip(parts, wanted, strict=True)]
        for part, kind in zip(parts, wanted, strict=True):
            if not kind.contains(part):
                raise UnityActionException(f"{current_agent} takes {space}, not {action!r:.60}")
        if spec.continuous_size:
            self._current_action[name].continuous[row] = parts[0]
        if spec.discrete_size:
            self._current_action[name].discrete[row] = parts[-1]

    def _step(self) -> None:
        for name, actions in self._current_action.items():
            self._env.set_actions(name, actions)
        self._env.step()
        self._update()
        self._agent_index = 0

    def _update(self) -> None:
        self._forget()
        self._make_spaces()
        for name, spec in self._env.behavior_specs.items():
            decisions, ends = self._env.get_steps(name)
            self._current_action[name] = spec.action_spec.empty_action(len(decisions))
            for row, agent_id in enumerate(decisions.agent_id):
                if agent_id not in ends:
                    agent = _behavior_to_agent_id(name, agent_id)
                    self._rows[agent] = row
                    seen: Any = [obs[row] for obs in decisions.obs]
                    if decisions.action_mask is not None:
                        masks = [mask[row] for mask in decisions.action_mask]
                        seen = {"observation": seen, "action_mask": masks}
                    self._take(agent, seen, decisions, row, {})
            for row, agent_id in enumerate(ends.agent_id):
                agent = _behavior_to_agent_id(name, agent_id)
                self.dones[agent] = True
                self._take(agent, [obs[row] for obs in ends.obs], ends, row, {"interrupted": ends.interrupted[row]})
        self._possible_agents.update(self._agents)
        self._live_agents = sorted(self._agents)

    def _take(self, agent: str, seen: Any, steps: Any, row: int, more: dict[str, Any]) -> None:
        self._agents.append(agent)
        self._observations[agent] = seen[0] if len(seen) == 1 else seen
        self.dones.setdefault(agent, False)
        self.rewards[agent] = self._cumm_rewards[agent] = steps.reward[row]
        group = {"group_id": steps.group_id[row], "group_reward": steps.group_reward[row]}
        self.infos[agent] = {"behavior_name": _agent_id_to_behavior(agent), **group, **more}

    def reset(self) -> Any:
        self._assert_loaded()
        self._agent_index = 0
        self._possible_agents = set()
        self._env.reset()
        self._update()
        self.rewards = dict.fromkeys(self._agents, 0.0)
        self._cumm_rewards = dict.fromkeys(self._agents, 0.0)

    def seed(self, seed: int | None = None) -> None:
        self._seed = seed

    def render(self, mode: str = "human") -> None:
        """The scene shows itself."""

    def state(self) -> None:
        """ML-Agents has none."""

    @property
    def agents(self) -> list[str]:
        return sorted(self._live_agents)

    @property
    def possible_agents(self) -> list[str]:
        """All that were there since the last reset."""
        return sorted(self._possible_agents)

    def close(self) -> None:
        if not self.is_closed:
            self.is_closed = True
            self._env.close()
