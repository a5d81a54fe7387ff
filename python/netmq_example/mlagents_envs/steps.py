"""The agents whose turn it is, and those that have ended: base_env.py has these names. It needs numpy."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from netmq_example.mlagents_envs.exception import NoSteps
from netmq_example.mlagents_envs.specs import BehaviorSpec

AgentId = int
GroupId = int
NO_FLOATS, NO_NUMBERS, NO_FLAGS = np.zeros(0, np.float32), np.zeros(0, np.int32), np.zeros(0, bool)


class DecisionStep(NamedTuple):
    """Of one agent. `action_mask` has for each branch an array of choices, in which True is forbidden."""

    obs: list[Any]
    reward: float
    agent_id: AgentId
    action_mask: list[Any] | None
    group_id: GroupId
    group_reward: float


class TerminalStep(NamedTuple):
    obs: list[Any]
    reward: float
    interrupted: bool
    agent_id: AgentId
    group_id: GroupId
    group_reward: float


class Steps(Mapping[AgentId, Any]):
    """Of several agents, by their ids."""

    obs: list[Any]
    reward: Any
    agent_id: Any
    group_id: Any
    group_reward: Any
    _agent_id_to_index: dict[AgentId, int] | None = None

    @property
    def agent_id_to_index(self) -> dict[AgentId, int]:
        if self._agent_id_to_index is None:
            self._agent_id_to_index = {found: at for at, found in enumerate(self)}
        return self._agent_id_to_index

    def __len__(self) -> int:
        return len(self.agent_id)

    def __iter__(self) -> Iterator[AgentId]:
        return iter(np.asarray(self.agent_id).tolist())

    def __contains__(self, agent_id: object) -> bool:
        return agent_id in self.agent_id_to_index

    def index(self, agent_id: AgentId) -> int:
        if agent_id not in self.agent_id_to_index:
            raise NoSteps(f"agent {agent_id!r:.40} is not among these {len(self)}")
        return self.agent_id_to_index[agent_id]


class DecisionSteps(Steps):
    """Of the agents that want an action. `action_mask` has for each branch an array [agents, choices], True is
    forbidden; it is None where there are no branches.
    """

    def __init__(
        self,
        obs: list[Any],
        reward: Any,
        agent_id: Any,
        action_mask: list[Any] | None,
        group_id: Any,
        group_reward: Any,
    ) -> None:
        self.obs = obs
        self.reward = reward
        self.agent_id = agent_id
        self.action_mask = action_mask
        self.group_id = group_id
        self.group_reward = group_reward

    def __getitem__(self, agent_id: AgentId) -> DecisionStep:
        at = self.index(agent_id)
        masks = None if self.action_mask is None else [mask[at] for mask in self.action_mask]
        seen = [one[at] for one in self.obs]
        return DecisionStep(seen, self.reward[at], agent_id, masks, self.group_id[at], self.group_reward[at])

    @staticmethod
    def empty(spec: BehaviorSpec) -> "DecisionSteps":
        seen, reward, ids, group, group_reward = nobody(spec)
        return DecisionSteps(seen, reward, ids, None, group, group_reward)


class TerminalSteps(Steps):
    """Of the agents whose episode has ended; `interrupted` says that it was cut, by its time or by a disturbance."""

    def __init__(
        self, obs: list[Any], reward: Any, interrupted: Any, agent_id: Any, group_id: Any, group_reward: Any
    ) -> None:
        self.obs = obs
        self.reward = reward
        self.interrupted = interrupted
        self.agent_id = agent_id
        self.group_id = group_id
        self.group_reward = group_reward

    def __getitem__(self, agent_id: AgentId) -> TerminalStep:
        at = self.index(agent_id)
        seen = [one[at] for one in self.obs]
        return TerminalStep(
            seen, self.reward[at], self.interrupted[at], agent_id, self.group_id[at], self.group_reward[at]
        )

    @staticmethod
    def empty(spec: BehaviorSpec) -> "TerminalSteps":
        seen, reward, ids, group, group_reward = nobody(spec)
        return TerminalSteps(seen, reward, NO_FLAGS, ids, group, group_reward)


def nobody(spec: BehaviorSpec) -> tuple[list[Any], Any, Any, Any, Any]:
    """Observations, rewards, ids, groups and their rewards, of no agent. Arrays without items may be anybody's."""
    seen = [np.zeros((0, *one.shape), np.float32) for one in spec.observation_specs]
    return seen, NO_FLOATS, NO_NUMBERS, NO_NUMBERS, NO_FLOATS


class BatchedStepResult(NamedTuple):
    """Both kinds of steps together, as early in 2020."""

    obs: list[Any]
    reward: Any
    done: Any
    max_step: Any
    agent_id: Any
    action_mask: list[Any] | None

    def n_agents(self) -> int:
        return len(self.agent_id)


def batched(now: DecisionSteps, over: TerminalSteps) -> BatchedStepResult:
    """First those that have ended."""
    obs = [np.concatenate(both) for both in zip(over.obs, now.obs, strict=True)]
    done = np.arange(len(over) + len(now)) < len(over)
    max_step = np.append(over.interrupted, np.zeros(len(now), bool))
    masks = now.action_mask and [
        np.concatenate([np.zeros((len(over), mask.shape[1]), bool), mask]) for mask in now.action_mask
    ]
    ids = np.append(over.agent_id, now.agent_id)
    return BatchedStepResult(obs, np.append(over.reward, now.reward), done, max_step, ids, masks)
