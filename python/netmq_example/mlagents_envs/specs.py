"""What is done and seen by the agents of a behavior: base_env.py has these names. It needs numpy."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from enum import Enum, IntFlag
from typing import Any, NamedTuple

import numpy as np

from netmq_example.mlagents_envs.exception import UnityActionException

BehaviorName = str


class _ActionTupleBase(ABC):
    """The floats and the whole numbers of some agents, [agents, size]; whichever is not given has size 0."""

    def __init__(self, continuous: Any = None, discrete: Any = None) -> None:
        self._continuous: Any = None
        self._discrete: Any = None
        if continuous is not None:
            self.add_continuous(continuous)
        if discrete is not None:
            self.add_discrete(discrete)

    @property
    def continuous(self) -> Any:
        return self._continuous

    @property
    def discrete(self) -> Any:
        return self._discrete

    def add_continuous(self, continuous: Any) -> None:
        self._continuous = np.asarray(continuous, np.float32)
        if self._discrete is None:
            self._discrete = np.zeros((len(self._continuous), 0), self.discrete_dtype)

    def add_discrete(self, discrete: Any) -> None:
        given = np.asarray(discrete)
        self._discrete = given.astype(self.discrete_dtype, copy=False)
        if given.dtype.kind not in "iub" and self.discrete_dtype == np.int32 and (self._discrete != given).any():
            raise UnityActionException(f"discrete actions are whole numbers, not {discrete!r:.60}")
        if self._continuous is None:
            self._continuous = np.zeros((len(self._discrete), 0), np.float32)

    @property
    @abstractmethod
    def discrete_dtype(self) -> Any:
        """That of the whole numbers; a trainer keeps logarithms of probabilities in their place, which are floats."""


class ActionTuple(_ActionTupleBase):
    """float32 and int32."""

    @property
    def discrete_dtype(self) -> Any:
        return np.int32


def as_tuple(action: Any, floats: int) -> Any:
    """An action; early in 2020 it was an array."""
    if isinstance(action, _ActionTupleBase) or hasattr(action, "discrete"):
        return action
    return ActionTuple(action) if floats else ActionTuple(discrete=action)


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

    def _validate_action(self, actions: ActionTuple, n_agents: int, name: str) -> ActionTuple:
        for what, given, size in (
            ("floats", actions.continuous, self.continuous_size),
            ("whole numbers", actions.discrete, self.discrete_size),
        ):
            if getattr(given, "shape", ()) != (n_agents, size):
                got = np.shape(given)
                raise UnityActionException(f"{name} takes {(n_agents, size)} {what}, [agents, size], and not {got}")
        return actions


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


class BehaviorMapping(Mapping[BehaviorName, BehaviorSpec]):
    """A view: what comes later is in it as well."""

    def __init__(self, specs: dict[BehaviorName, BehaviorSpec]) -> None:
        self._dict = specs

    def __len__(self) -> int:
        return len(self._dict)

    def __getitem__(self, behavior: BehaviorName) -> BehaviorSpec:
        return self._dict[behavior]

    def __iter__(self) -> Iterator[BehaviorName]:
        return iter(self._dict)
