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
        # Each array, its columns among all floats or all branches, and where its choices begin, unless that is at 0.
        self.leaves: list[tuple[Any, slice, Any]] = []
        floats = 0
        branches: list[int] = []
        for _, leaf in leaves_of(space, (), "action"):
            if isinstance(leaf, spaces.Box):
                self.leaves.append((leaf, slice(floats, floats + math.prod(leaf.shape)), None))
                floats += math.prod(leaf.shape)
            else:
                choices, start = choices_of(leaf), getattr(leaf, "start", 0)
                columns = slice(len(branches), len(branches) + len(choices))
                self.leaves.append((leaf, columns, start if np.any(start) else None))
                branches += choices
        self.spec = ActionSpec(floats, tuple(branches))

    def batch(self, floats: Any, numbers: Any) -> Any:
        """Of floats and whole numbers, [agents, size]."""
        parts = []
        for leaf, columns, start in self.leaves:
            is_float = isinstance(leaf, spaces.Box)
            part = (floats if is_float else numbers)[:, columns].reshape(-1, *leaf.shape)
            part = part if start is None else part + start
            parts.append(part if is_float else part.astype(leaf.dtype))
        return filled(self.space, iter(parts))


def choices_of(leaf: Any) -> list[int]:
    match leaf:
        case spaces.Discrete():
            return [int(leaf.n)]
        case spaces.MultiDiscrete():
            return [*leaf.nvec.ravel().tolist()]
    return [2] * math.prod(leaf.shape)


def filled(space: Any, parts: Iterator[Any]) -> Any:
    """The space's own dicts and tuples, with these arrays in them."""
    match space:
        case spaces.Dict():
            return {key: filled(part, parts) for key, part in space.items()}
        case spaces.Tuple():
            return tuple(filled(part, parts) for part in space)
    return next(parts)


class Seen:
    """Observations of a space: one for each array in it. What is called action_mask says which `choices` there are."""

    def __init__(self, space: spaces.Space[Any], choices: int, channels_first: bool = True) -> None:
        self.channels_first = channels_first
        self.leaves = dict(leaves_of(space, (), "observation"))
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
        return [self.read(functools.reduce(operator.getitem, path, batch), leaf) for path, leaf in self.leaves.items()]

    def read(self, part: Any, leaf: Any) -> Any:
        if is_picture(leaf):
            return as_picture(np.moveaxis(part, 3, 1) if self.channels_first else part)
        if leaf.dtype == np.float32 and leaf.shape:
            return part
        return part.astype(np.float32).reshape(-1, *(leaf.shape or (1,)))


def is_picture(leaf: Any) -> bool:
    return len(leaf.shape) == 3 and leaf.dtype == np.uint8 and leaf.shape[2] in CHANNELS


def leaves_of(space: Any, path: tuple[Any, ...], word: str) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """The arrays of a space, each with the keys that lead to it."""
    match space:
        case spaces.Dict() | spaces.Tuple():
            for key, part in space.items() if isinstance(space, spaces.Dict) else enumerate(space):
                yield from leaves_of(part, (*path, key), word)
        case spaces.Box() | spaces.Discrete() | spaces.MultiDiscrete() | spaces.MultiBinary():
            yield path, space
        case _:
            where = f" at {'.'.join(map(str, path))}" if path else ""
            raise MessageError(f"no-{word}", f"ML-Agents has no {word} {space!s:.80}{where}: take gymnasium.make")
