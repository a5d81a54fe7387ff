"""The types of mlagents_envs.base_env, with its names: what is seen and done by the agents whose turn it is.

    steps.obs[0]                    one array for each observation, [agents, …], float32
    steps[7].reward                 of the agent with the id 7; `7 in steps` says whether it is there
    ActionTuple(continuous=floats, discrete=whole_numbers)      each [agents, size]

BaseEnv is what a wrapper or a trainer needs of an environment; environment.py has one. It needs numpy.
"""

import functools
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum, IntFlag
from typing import Any, NamedTuple

from netmq_example.extras import without

try:
    import numpy as np
except ImportError as error:
    raise without(error) from None

from netmq_example.mlagents_envs.exception import NoSteps, UnityActionException

BehaviorName = str
AgentId = int
GroupId = int
# Arrays without items may be anybody's.
NO_FLOATS, NO_IDS, NO_FLAGS = np.zeros(0, np.float32), np.zeros(0, np.int32), np.zeros(0, bool)


class _ActionTupleBase:
    """The floats and the whole numbers of some agents, [agents, size]; whichever is not given has size 0."""

    # A trainer keeps logarithms of probabilities in place of whole numbers, which are floats.
    discrete_dtype: Any = np.int32

    def __init__(self, continuous: Any = None, discrete: Any = None) -> None:
        self.continuous: Any = None
        self.discrete: Any = None
        if continuous is not None:
            self.add_continuous(continuous)
        if discrete is not None:
            self.add_discrete(discrete)

    def add_continuous(self, continuous: Any) -> None:
        self.continuous = np.asarray(continuous, np.float32)
        if self.discrete is None:
            self.discrete = np.zeros((len(self.continuous), 0), self.discrete_dtype)

    def add_discrete(self, discrete: Any) -> None:
        given = np.asarray(discrete)
        self.discrete = given.astype(self.discrete_dtype, copy=False)
        # As lists: to compare two arrays takes numpy longer right after a wait.
        if self.discrete_dtype is np.int32 and self.discrete is not given and self.discrete.tolist() != given.tolist():
            raise UnityActionException(f"discrete actions are whole numbers of 32 bits, not {discrete!r:.60}")
        if self.continuous is None:
            self.continuous = np.zeros((len(self.discrete), 0), np.float32)


class ActionTuple(_ActionTupleBase):
    """float32 and int32."""


class ActionSpec(NamedTuple):
    """How many floats, and for each whole number how many choices there are."""

    continuous_size: int
    discrete_branches: tuple[int, ...]

    @staticmethod
    def create_continuous(continuous_size: int) -> "ActionSpec":
        return ActionSpec(continuous_size, ())

    @staticmethod
    def create_discrete(discrete_branches: tuple[int, ...]) -> "ActionSpec":
        return ActionSpec(0, tuple(discrete_branches))

    @staticmethod
    def create_hybrid(continuous_size: int, discrete_branches: tuple[int, ...]) -> "ActionSpec":
        return ActionSpec(continuous_size, tuple(discrete_branches))

    @property
    def discrete_size(self) -> int:
        return len(self.discrete_branches)

    def is_continuous(self) -> bool:
        return self.continuous_size > 0 and not self.discrete_branches

    def is_discrete(self) -> bool:
        return self.discrete_size > 0 and not self.continuous_size

    def empty_action(self, n_agents: int) -> ActionTuple:
        floats = np.zeros((n_agents, self.continuous_size), np.float32)
        return ActionTuple(floats, np.zeros((n_agents, self.discrete_size), np.int32))

    def random_action(self, n_agents: int) -> ActionTuple:
        """By numpy's common generator, which programs seed by np.random.seed."""
        floats = np.random.uniform(-1, 1, (n_agents, self.continuous_size))
        columns = [np.random.randint(0, choices, n_agents) for choices in self.discrete_branches]
        return ActionTuple(floats, np.column_stack(columns) if columns else np.zeros((n_agents, 0), np.int32))


class DimensionProperty(IntFlag):
    """The use of one dimension of an observation."""

    UNSPECIFIED = 0
    NONE = 1
    # A convolution makes sense along it.
    TRANSLATIONAL_EQUIVARIANCE = 2
    # There may be fewer, the rest is zeros, and their order says nothing.
    VARIABLE_SIZE = 4


class ObservationType(Enum):
    DEFAULT = 0
    GOAL_SIGNAL = 1


class ObservationSpec(NamedTuple):
    """One observation of one agent: its shape, and a property for each dimension."""

    shape: tuple[int, ...]
    dimension_property: tuple[DimensionProperty, ...]
    observation_type: ObservationType
    name: str


class BehaviorSpec(NamedTuple):
    """The observations, in the order of `obs`, and the parts of an action. The properties are the names of 2020."""

    observation_specs: list[ObservationSpec]
    action_spec: ActionSpec

    @property
    def observation_shapes(self) -> list[tuple[int, ...]]:
        return [spec.shape for spec in self.observation_specs]

    @property
    def action_shape(self) -> Any:
        """How many floats, or how many choices each branch has."""
        return self.action_spec.continuous_size if self.is_action_continuous() else self.action_spec.discrete_branches

    @property
    def action_size(self) -> int:
        return self.action_spec.continuous_size if self.is_action_continuous() else self.action_spec.discrete_size

    @property
    def discrete_action_branches(self) -> tuple[int, ...] | None:
        return self.action_spec.discrete_branches or None

    def is_action_continuous(self) -> bool:
        return self.action_spec.is_continuous()

    def is_action_discrete(self) -> bool:
        return self.action_spec.is_discrete()


class BehaviorMapping(dict[BehaviorName, BehaviorSpec]):
    """An environment's: behaviors that come later are in it as well."""


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

    agent_id: Any

    @functools.cached_property
    def agent_id_to_index(self) -> dict[AgentId, int]:
        return {found: at for at, found in enumerate(self)}

    def __len__(self) -> int:
        return len(self.agent_id)

    def __iter__(self) -> Iterator[AgentId]:
        return iter(np.asarray(self.agent_id).tolist())

    def __contains__(self, agent_id: object) -> bool:
        return agent_id in self.agent_id_to_index

    def index(self, agent_id: AgentId) -> int:
        if agent_id not in self:
            raise NoSteps(f"agent {agent_id!r:.40} is not among these {len(self)}")
        return self.agent_id_to_index[agent_id]


@dataclass(eq=False, repr=False)
class DecisionSteps(Steps):
    """Of the agents that want an action. `action_mask` has for each branch an array [agents, choices], True is
    forbidden; it is None where there are no branches.
    """

    obs: list[Any]
    reward: Any
    agent_id: Any
    action_mask: list[Any] | None
    group_id: Any
    group_reward: Any

    def __getitem__(self, agent_id: AgentId) -> DecisionStep:
        at = self.index(agent_id)
        masks = None if self.action_mask is None else [mask[at] for mask in self.action_mask]
        group = self.group_id[at], self.group_reward[at]
        return DecisionStep([one[at] for one in self.obs], self.reward[at], agent_id, masks, *group)

    @staticmethod
    def empty(spec: BehaviorSpec) -> "DecisionSteps":
        return DecisionSteps(unseen(spec), NO_FLOATS, NO_IDS, None, NO_IDS, NO_FLOATS)


@dataclass(eq=False, repr=False)
class TerminalSteps(Steps):
    """Of the agents whose episode has ended; `interrupted` says that it was cut, by its time or by a disturbance."""

    obs: list[Any]
    reward: Any
    interrupted: Any
    agent_id: Any
    group_id: Any
    group_reward: Any

    def __getitem__(self, agent_id: AgentId) -> TerminalStep:
        at = self.index(agent_id)
        group = self.group_id[at], self.group_reward[at]
        return TerminalStep([one[at] for one in self.obs], self.reward[at], self.interrupted[at], agent_id, *group)

    @staticmethod
    def empty(spec: BehaviorSpec) -> "TerminalSteps":
        return TerminalSteps(unseen(spec), NO_FLOATS, NO_FLAGS, NO_IDS, NO_IDS, NO_FLOATS)


def unseen(spec: BehaviorSpec) -> list[Any]:
    return [np.zeros((0, *one.shape), np.float32) for one in spec.observation_specs]


class BaseEnv(ABC):
    """An environment of several behaviors, each of many agents. A step goes on until one of them wants an action."""

    @abstractmethod
    def step(self) -> None:
        """Go on with the actions that were set; of whom none was set, it is zeros."""

    @abstractmethod
    def reset(self) -> None:
        """Begin all episodes anew."""

    @abstractmethod
    def close(self) -> None:
        """End the simulator, and the connection."""

    @property
    @abstractmethod
    def behavior_specs(self) -> Mapping[str, BehaviorSpec]:
        """What is seen and done, by behavior; later ones are added."""

    @abstractmethod
    def set_actions(self, behavior_name: BehaviorName, action: ActionTuple) -> None:
        """Of all agents of the DecisionSteps, in their order, for the next step."""

    @abstractmethod
    def set_action_for_agent(self, behavior_name: BehaviorName, agent_id: AgentId, action: ActionTuple) -> None:
        """Of one agent; its arrays have one row."""

    @abstractmethod
    def get_steps(self, behavior_name: BehaviorName) -> tuple[DecisionSteps, TerminalSteps]:
        """Of the agents that want an action, and of those that have ended in the last step."""
