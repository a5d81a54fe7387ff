"""A clock decides when an agent has its turn: environment.py steps by that of the scene, or by Python's.

It makes the records that are sent, and reads those that come: `specs` and `turns` are by behavior. It needs numpy.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np

from netmq_example.messages import Message, MessageError
from netmq_example.mlagents_envs.specs import ActionTuple, BehaviorSpec, DimensionProperty, ObservationSpec
from netmq_example.mlagents_envs.steps import DecisionSteps, TerminalSteps
from netmq_example.wire.records import Record, Section

# Of a picture [channels, height, width].
PICTURE = (
    DimensionProperty.NONE,
    DimensionProperty.TRANSLATIONAL_EQUIVARIANCE,
    DimensionProperty.TRANSLATIONAL_EQUIVARIANCE,
)


class Turn:
    """The steps of one behavior. Those of nobody are made when somebody looks at them."""

    def __init__(self, decisions: DecisionSteps | None = None, ended: TerminalSteps | None = None) -> None:
        self.decisions = decisions
        self.ended = ended

    def steps(self, spec: BehaviorSpec) -> tuple[DecisionSteps, TerminalSteps]:
        if self.decisions is None:
            self.decisions = DecisionSteps.empty(spec)
        if self.ended is None:
            self.ended = TerminalSteps.empty(spec)
        return self.decisions, self.ended


class Clock(ABC):
    """`specs` and `turns` are kept up to date by `read`."""

    def __init__(self) -> None:
        self.specs: dict[str, BehaviorSpec] = {}
        self.turns: dict[str, Turn] = {}

    @abstractmethod
    def connected(self, hello: Message) -> None:
        """Take a simulator, the first one or another; MessageError says why it is refused."""

    @abstractmethod
    def reset(self) -> Record: ...

    @abstractmethod
    def step(self, actions: Mapping[str, ActionTuple]) -> Record:
        """Actions by behavior; where there are none, it is zeros."""

    @abstractmethod
    def read(self, answer: Record, begins: bool) -> None:
        """MessageError says what is wrong with it."""

    def limited(self) -> Record | None:
        """The last step once more, if rounding alone had taken its actions out of their limits, as the simulator says.

        None: they were within them, and something else is wrong. ValueError names the action.
        """
        return None


# Of so few rewards Python's own sum is faster than numpy, which is slow right after a wait.
FEW = 32


def rewards_of(section: Section) -> Any:
    rewards = np.frombuffer(section.numbers, np.float64).astype(np.float32)
    if not math.isfinite(sum(rewards.tolist()) if len(rewards) < FEW else rewards.sum()):
        raise MessageError("bad-reward", f"the rewards are {rewards!s:.80}")
    return rewards


def branches_of(block: Any, branches: tuple[int, ...]) -> list[Any] | None:
    """A mask for each branch, of all masks side by side."""
    if len(branches) == 1:
        return [block]
    masks = []
    at = 0
    for choices in branches:
        masks.append(block[:, at : at + choices])
        at += choices
    return masks or None


def as_picture(part: Any) -> Any:
    """Bytes as numbers from 0 to 1."""
    return np.true_divide(part, np.float32(255), dtype=np.float32)


def channels_last(spec: ObservationSpec) -> ObservationSpec:
    """As ML-Agents had pictures before 2024."""
    first, *rest = spec.shape
    channels, *others = spec.dimension_property
    return spec._replace(shape=(*rest, first), dimension_property=(*others, channels))
