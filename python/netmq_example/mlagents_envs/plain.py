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
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from gymnasium import spaces

from netmq_example.envs.remote import MASK
from netmq_example.messages import MessageError
from netmq_example.mlagents_envs.base_env import ActionSpec, DimensionProperty, ObservationSpec, ObservationType
from netmq_example.mlagents_envs.scene_clock import PICTURE, as_picture, channels_last

# The last dimension of a picture.
CHANNELS = (1, 3, 4)
CURE = "take gymnasium.make"

Maker = Callable[[Any, Any], Any]


class Done:
    """Actions of a space: floats of each Box, and a branch for each number of all others."""

    def __init__(self, space: spaces.Space[Any]) -> None:
        self.floats = 0
        self.branches: list[int] = []
        # It takes floats and whole numbers, [agents, size].
        self.batch = self.maker(space)
        self.spec = ActionSpec(self.floats, tuple(self.branches))

    def maker(self, space: Any) -> Maker:
        match space:
            case spaces.Dict():
                parts = {key: self.maker(part) for key, part in space.items()}
                return lambda floats, numbers: {key: make(floats, numbers) for key, make in parts.items()}
            case spaces.Tuple():
                items = [self.maker(part) for part in space]
                return lambda floats, numbers: tuple(make(floats, numbers) for make in items)
            case spaces.Box():
                part = part_of(space, self.floats)
                self.floats += math.prod(space.shape)
                return lambda floats, _: part(floats)
            case spaces.Discrete():
                return self.choices(space, [int(space.n)])
            case spaces.MultiDiscrete():
                return self.choices(space, space.nvec.ravel().tolist())
            case spaces.MultiBinary():
                return self.choices(space, [2] * math.prod(space.shape))
        raise MessageError("no-action", f"ML-Agents has no action {space!s:.80}: {CURE}")

    def choices(self, space: Any, counts: list[int]) -> Maker:
        part = part_of(space, len(self.branches))
        self.branches += counts
        # They may begin elsewhere than at 0.
        start = getattr(space, "start", 0)
        if not np.any(start):
            return lambda _, numbers: part(numbers).astype(space.dtype)
        return lambda _, numbers: (part(numbers) + start).astype(space.dtype)


def part_of(space: Any, at: int) -> Callable[[Any], Any]:
    """Takes the columns of a space, from this one on, out of [agents, size]."""
    end = at + math.prod(space.shape)
    shape = -1, *space.shape
    # By fewer calls of numpy, which is slow right after a wait.
    return (lambda rows: rows[:, at:end].reshape(shape)) if space.shape else lambda rows: rows[:, at]


class Seen:
    """Observations of a space: one for each array in it. What is called action_mask says which `choices` there are."""

    def __init__(self, space: spaces.Space[Any], choices: int, channels_first: bool = True) -> None:
        self.channels_first = channels_first
        leaves = dict(leaves_of(space, ()))
        mask = leaves.get((MASK,))
        # Of another size it is something else.
        self.masked = bool(choices) and mask is not None and math.prod(mask.shape) == choices
        if self.masked:
            del leaves[MASK,]
        self.specs = [self.described(path, leaf) for path, leaf in leaves.items()]
        self.readers = [(path, self.reader(leaf)) for path, leaf in leaves.items()]

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
        return [read(functools.reduce(operator.getitem, path, batch)) for path, read in self.readers]

    def reader(self, leaf: Any) -> Callable[[Any], Any]:
        if is_picture(leaf):
            return lambda part: as_picture(np.moveaxis(part, 3, 1) if self.channels_first else part)
        if leaf.dtype == np.float32 and leaf.shape:
            return lambda part: part
        if leaf.shape:
            return lambda part: part.astype(np.float32)
        return lambda part: part.astype(np.float32).reshape(-1, 1)


def is_picture(leaf: Any) -> bool:
    return len(leaf.shape) == 3 and leaf.dtype == np.uint8 and leaf.shape[2] in CHANNELS


def leaves_of(space: Any, path: tuple[Any, ...]) -> Iterator[tuple[tuple[Any, ...], Any]]:
    match space:
        case spaces.Dict() | spaces.Tuple():
            for key, part in space.items() if isinstance(space, spaces.Dict) else enumerate(space):
                yield from leaves_of(part, (*path, key))
        case spaces.Box() | spaces.Discrete() | spaces.MultiDiscrete() | spaces.MultiBinary():
            yield path, space
        case _:
            where = f" at {'.'.join(map(str, path))}" if path else ""
            raise MessageError("no-observation", f"ML-Agents has no observation {space!s:.80}{where}: {CURE}")
