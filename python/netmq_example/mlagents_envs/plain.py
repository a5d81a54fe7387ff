"""Gymnasium's spaces as ML-Agents has what is done and seen: rows of floats and whole numbers, and float32 arrays.

    done = Done(Dict(steer=Box(-1, 1, (2,)), gear=Discrete(5)))         done.spec: 2 floats and a branch of 5
    batch = done.batch(floats, whole_numbers)                           as Gymnasium batches actions
    seen = Seen(Dict(eye=Box(0, 255, (24, 32, 3), np.uint8)), 5)        seen.specs: eye, [3, 24, 32]
    arrays = seen.split(batch of observations)

It needs gymnasium and numpy.
"""

import functools
import math
import operator
from collections.abc import Iterator
from typing import Any

import numpy as np
from gymnasium import spaces

from netmq_example.envs.remote import MASK
from netmq_example.messages import MessageError
from netmq_example.mlagents_envs.base_env import ActionSpec, DimensionProperty, ObservationSpec, ObservationType
from netmq_example.mlagents_envs.scene_clock import PICTURE, as_picture, channels_last

# The last dimension of a picture.
CHANNELS = (1, 3, 4)


class Done:
    """Actions of a space: floats of each Box, and a branch for each number of all others."""

    def __init__(self, space: spaces.Space[Any]) -> None:
        self.space = space
        self.leaves = [leaf for _, leaf in leaves_of(space, "action", ())]
        floats = sum(math.prod(leaf.shape) for leaf in self.leaves if isinstance(leaf, spaces.Box))
        self.spec = ActionSpec(floats, tuple(choices for leaf in self.leaves for choices in choices_of(leaf)))

    def batch(self, floats: Any, numbers: Any) -> Any:
        """Of [agents, size] each."""
        parts = []
        for leaf in self.leaves:
            size = math.prod(leaf.shape)
            if isinstance(leaf, spaces.Box):
                parts.append(floats[:, :size].reshape(-1, *leaf.shape))
                floats = floats[:, size:]
            else:
                # They may begin elsewhere than at 0.
                part = numbers[:, :size].reshape(-1, *leaf.shape) + getattr(leaf, "start", 0)
                parts.append(part.astype(leaf.dtype, copy=False))
                numbers = numbers[:, size:]
        return nested(self.space, iter(parts))


class Seen:
    """Observations of a space: one for each array in it. What is called action_mask says which `choices` there are."""

    def __init__(self, space: spaces.Space[Any], choices: int, channels_first: bool = True) -> None:
        self.channels_first = channels_first
        self.leaves = dict(leaves_of(space, "observation", ()))
        mask = self.leaves.get((MASK,))
        # Of another size it is something else.
        self.masked = bool(choices) and mask is not None and math.prod(mask.shape) == choices
        if self.masked:
            del self.leaves[MASK,]
        self.specs = [self.described(path, leaf) for path, leaf in self.leaves.items()]

    def described(self, path: tuple[Any, ...], leaf: Any) -> ObservationSpec:
        name = ".".join(map(str, path)) or "observation"
        shape: tuple[int, ...] = leaf.shape or (1,)
        if is_picture(leaf):
            spec = ObservationSpec((shape[2], *shape[:2]), PICTURE, ObservationType.DEFAULT, name)
            return spec if self.channels_first else channels_last(spec)
        # An attention or a convolution may make sense of more dimensions, or none.
        properties = (DimensionProperty.NONE if len(shape) == 1 else DimensionProperty.UNSPECIFIED,) * len(shape)
        return ObservationSpec(shape, properties, ObservationType.DEFAULT, name)

    def split(self, batch: Any) -> list[Any]:
        """An array for each observation; the batch belongs to nobody else."""
        seen = []
        for path, leaf in self.leaves.items():
            part = functools.reduce(operator.getitem, path, batch)
            if is_picture(leaf):
                part = as_picture(np.moveaxis(part, 3, 1) if self.channels_first else part)
            elif part.dtype != np.float32:
                part = part.astype(np.float32)
            seen.append(part if leaf.shape else part.reshape(-1, 1))
        return seen


def is_picture(leaf: Any) -> bool:
    return len(leaf.shape) == 3 and leaf.dtype == np.uint8 and leaf.shape[2] in CHANNELS


def choices_of(leaf: Any) -> list[int]:
    """How many there are of each whole number of an action."""
    match leaf:
        case spaces.Discrete():
            return [int(leaf.n)]
        case spaces.MultiDiscrete():
            return list(map(int, leaf.nvec.flat))
        case spaces.MultiBinary():
            return [2] * math.prod(leaf.shape)
    return []


def leaves_of(space: Any, which: str, path: tuple[Any, ...]) -> Iterator[tuple[tuple[Any, ...], Any]]:
    match space:
        case spaces.Dict() | spaces.Tuple():
            for key, part in space.items() if isinstance(space, spaces.Dict) else enumerate(space):
                yield from leaves_of(part, which, (*path, key))
        case spaces.Box() | spaces.Discrete() | spaces.MultiDiscrete() | spaces.MultiBinary():
            yield path, space
        case _:
            where = f" at {'.'.join(map(str, path))}" if path else ""
            what = f"ML-Agents has no {which} {space!s:.80}{where}"
            raise MessageError(f"no-{which}", f"{what}: take gymnasium.make")


def nested(space: Any, parts: Iterator[Any]) -> Any:
    """The parts of all leaves as a batch of the space."""
    match space:
        case spaces.Dict():
            return {key: nested(part, parts) for key, part in space.items()}
        case spaces.Tuple():
            return tuple(nested(part, parts) for part in space)
    return next(parts)
