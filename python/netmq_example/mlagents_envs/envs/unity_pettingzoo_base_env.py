"""The common half of UnityAECEnv and UnityParallelEnv, as in mlagents_envs.envs.unity_pettingzoo_base_env.

Its agents are those that wanted an action or have ended in the last step, each `Behavior?team=0?agent_id=3`. An agent
that has ended and began anew in the same step is shown at its end first, and wants an action again after the next step.
Agents with choices see {"observation": …, "action_mask": …}: an array for each branch, in which True is forbidden as in
ML-Agents' steps. PettingZoo's own environments have it the other way round.
"""

from typing import Any

import numpy as np

from netmq_example.mlagents_envs.base_env import ActionTuple, BaseEnv, BehaviorSpec, DecisionStep, TerminalStep
from netmq_example.mlagents_envs.envs.env_helpers import (
    _agent_id_to_behavior,
    _behavior_to_agent_id,
    action_space,
    derived,
    find_spaces,
)
from netmq_example.mlagents_envs.exception import UnityActionException, UnityException


class UnityPettingzooBaseEnv:
    """Its constructor resets the environment, and its close closes it. `seed` is that of the action spaces."""

    # The class of PettingZoo's that it is as well.
    kind: str

    def __new__(cls: Any, *args: object, **words: object) -> Any:
        return object.__new__(derived(cls, cls.kind))

    def __init__(self, env: BaseEnv, seed: int | None = None, metadata: dict[str, Any] | None = None) -> None:
        self._env = env
        self._seed = seed
        self.metadata = metadata or {}
        manager = getattr(env, "_side_channel_manager", None)
        channels = getattr(manager, "_side_channels_dict", {})
        self.side_channel = {type(channel).__name__: channel for channel in channels.values()}
        self._action_spaces: dict[str, Any] = {}
        self._observation_spaces: dict[str, Any] = {}
        self.is_closed = False
        UnityPettingzooBaseEnv.reset(self)

    def _assert_loaded(self) -> None:
        if self.is_closed:
            raise UnityException("the environment is closed")

    def _make_spaces(self, name: str, spec: BehaviorSpec) -> None:
        spaces = find_spaces()
        seen = [spaces.Box(-np.inf, np.inf, each.shape, np.float32) for each in spec.observation_specs]
        self._observation_spaces[name] = seen[0] if len(seen) == 1 else spaces.Tuple(seen)
        self._action_spaces[name] = action_space(spaces, spec.action_spec)
        if self._action_spaces[name] is None:
            raise UnityException(f"the agents of {name} have no actions")
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
        space = self.action_space(current_agent)
        given = self._current_action[_agent_id_to_behavior(current_agent)]
        both = given.continuous.size and given.discrete.size
        for part, done in zip(space, action, strict=True) if both else [(space, action)]:
            value = np.asarray(done, part.dtype)
            if not part.contains(value):
                raise UnityActionException(f"{current_agent} takes {space}, not {action!r:.60}")
            half = given.continuous if part.dtype == np.float32 else given.discrete
            half[self._rows[current_agent]] = value

    def _step(self) -> None:
        for name, actions in self._current_action.items():
            self._env.set_actions(name, actions)
        self._env.step()
        self._update()

    def _update(self) -> None:
        # All that are in the last step, and those of them that have not been taken leave of.
        self._agents: list[str] = []
        self._live_agents: list[str] = []
        self._agent_index = 0
        self._observations: dict[str, Any] = {}
        self.rewards: dict[str, float] = {}
        self._cumm_rewards: dict[str, float] = {}
        self.dones: dict[str, bool] = {}
        self.infos: dict[str, dict[str, Any]] = {}
        # An agent's row in its behavior's actions.
        self._rows: dict[str, int | None] = {}
        self._current_action: dict[str, ActionTuple] = {}
        for name, spec in self._env.behavior_specs.items():
            if name not in self._action_spaces:
                self._make_spaces(name, spec)
            decisions, ends = self._env.get_steps(name)
            self._current_action[name] = spec.action_spec.empty_action(len(decisions))
            # Of an agent that has ended, and has begun anew, its end.
            each: dict[int, Any] = {**decisions, **ends}
            for agent_id, step in each.items():
                agent = _behavior_to_agent_id(name, agent_id)
                self._rows[agent] = decisions.agent_id_to_index.get(agent_id)
                self._take(agent, name, step)
        self._possible_agents.update(self._agents)
        self._live_agents = sorted(self._agents)

    def _take(self, agent: str, name: str, step: DecisionStep | TerminalStep) -> None:
        self._agents.append(agent)
        self._observations[agent] = step.obs[0] if len(step.obs) == 1 else step.obs
        self.rewards[agent] = self._cumm_rewards[agent] = step.reward
        self.dones[agent] = isinstance(step, TerminalStep)
        self.infos[agent] = {"behavior_name": name, "group_id": step.group_id, "group_reward": step.group_reward}
        if isinstance(step, TerminalStep):
            self.infos[agent]["interrupted"] = step.interrupted
        elif step.action_mask is not None:
            self._observations[agent] = {"observation": step.obs, "action_mask": step.action_mask}

    def reset(self) -> Any:
        self._assert_loaded()
        self._possible_agents: set[str] = set()
        self._env.reset()
        self._update()
        return self._observations

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
