"""The types of mlagents_envs.base_env, with its names: what is seen and done by the agents whose turn it is.

    steps.obs[0]                    one array for each observation, [agents, …]
    steps[7].reward                 of the agent with the id 7; `7 in steps` says whether it is there
    ActionTuple(continuous=floats, discrete=whole_numbers)      each [agents, size]

environment.py uses them. It needs numpy.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from netmq_example.mlagents_envs.exception import UnityActionException

__all__ = [
    "ActionSpec",
    "ActionTuple",
    "AgentId",
    "BatchedStepResult",
    "BehaviorName",
    "BehaviorSpec",
    "DecisionStep",
    "DecisionSteps",
    "ObservationSpec",
    "TerminalStep",
    "TerminalSteps",
]

AgentId = int
BehaviorName = str


class ActionTuple:
    """float32 and int32, [agents, size]; what is not given has size 0."""

    def __init__(self, continuous: Any = None, discrete: Any = None) -> None:
        self.continuous, self.discrete = np.zeros((1, 0), np.float32), np.zeros((1, 0), np.int32)
        if continuous is not None:
            self.add_continuous(continuous)
        if discrete is not None:
            self.add_discrete(discrete)

    def add_continuous(self, continuous: Any) -> None:
        self.continuous = np.asarray(continuous, np.float32)
        if not self.discrete.size:
            self.discrete = np.zeros((len(self.continuous), 0), np.int32)

    def add_discrete(self, discrete: Any) -> None:
        self.discrete = np.asarray(discrete).astype(np.int32)
        if not np.array_equal(self.discrete, discrete):
            raise UnityActionException(f"discrete actions are whole numbers, not {discrete!r:.60}")
        if not self.continuous.size:
            self.continuous = np.zeros((len(self.discrete), 0), np.float32)


class ActionSpec(NamedTuple):
    """How many floats, and for each whole number how many choices there are."""

    continuous_size: int
    discrete_branches: tuple[int, ...]

    @property
    def discrete_size(self) -> int:
        return len(self.discrete_branches)

    def is_continuous(self) -> bool:
        return self.continuous_size > 0 and not self.discrete_branches

    def is_discrete(self) -> bool:
        return self.discrete_size > 0 and not self.continuous_size

    def empty_action(self, n_agents: int) -> ActionTuple:
        return ActionTuple(np.zeros((n_agents, self.continuous_size)), np.zeros((n_agents, self.discrete_size)))

    def random_action(self, n_agents: int) -> ActionTuple:
        rng = np.random.default_rng()
        floats = rng.uniform(-1, 1, (n_agents, self.continuous_size))
        return ActionTuple(floats, rng.integers(self.discrete_branches, size=(n_agents, self.discrete_size)))


class ObservationSpec(NamedTuple):
    """The name of one observation, and its shape for one agent."""

    shape: tuple[int, ...]
    name: str


class BehaviorSpec(NamedTuple):
    """The observations, in the order of `obs`, and the parts of an action."""

    observation_specs: list[ObservationSpec]
    action_spec: ActionSpec


class DecisionStep(NamedTuple):
    """Of one agent. Nothing is masked, and nobody is in a group."""

    obs: list[Any]
    reward: float
    agent_id: AgentId
    action_mask: None = None
    group_id: int = 0
    group_reward: float = 0.0


class TerminalStep(NamedTuple):
    obs: list[Any]
    reward: float
    interrupted: bool
    agent_id: AgentId
    group_id: int = 0
    group_reward: float = 0.0


@dataclass
class Steps(Mapping[AgentId, Any]):
    """Of several agents, by their ids."""

    obs: list[Any]
    reward: Any
    agent_id: Any

    def __len__(self) -> int:
        return len(self.agent_id)

    def __iter__(self) -> Iterator[AgentId]:
        return iter(self.agent_id.tolist())

    @property
    def agent_id_to_index(self) -> dict[AgentId, int]:
        return {found: at for at, found in enumerate(self)}

    @property
    def group_id(self) -> Any:
        return np.zeros(len(self), np.int32)

    @property
    def group_reward(self) -> Any:
        return np.zeros(len(self), np.float32)


class DecisionSteps(Steps):
    """Of the agents that want an action."""

    action_mask = None

    def __getitem__(self, agent_id: AgentId) -> DecisionStep:
        at = self.agent_id_to_index[agent_id]
        return DecisionStep([seen[at] for seen in self.obs], self.reward[at], agent_id)


@dataclass
class TerminalSteps(Steps):
    """Of the agents whose episode has ended; `interrupted` says that it was truncated."""

    interrupted: Any

    def __getitem__(self, agent_id: AgentId) -> TerminalStep:
        at = self.agent_id_to_index[agent_id]
        return TerminalStep([seen[at] for seen in self.obs], self.reward[at], self.interrupted[at], agent_id)


class BatchedStepResult(NamedTuple):
    """Both together, as early in 2020."""

    obs: list[Any]
    reward: Any
    done: Any
    max_step: Any
    agent_id: Any

    def n_agents(self) -> int:
        return len(self.agent_id)
