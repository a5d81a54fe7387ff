"""Gymnasium's spaces as ML-Agents has what is done and seen: rows of floats and whole numbers, and float32 arrays.

    done = Done(Dict(steer=Box(-1, 1, (2,)), gear=Discrete(5)))             done.spec: 2 floats and a branch of 5
    batch = done.batch(floats, whole_numbers)                               as Gymnasium batches actions
    seen = Seen(Dict(eye=Box(0, 255, (24, 32, 3), np.uint8)), done.spec)    seen.specs: eye, [3, 24, 32]
    arrays = seen.split(seen.parts(batch of observations))

It needs gymnasium and numpy.
"""

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from gymnasium import spaces

from netmq_example.messages import MessageError
from netmq_example.mlagents_envs.clock import PICTURE, as_picture, channels_last
from netmq_example.mlagents_envs.specs import ActionSpec, DimensionProperty, ObservationSpec, ObservationType

CURE = "take gymnasium.make"
MASK = "action_mask"
# The last dimension of a picture.
CHANNELS = (1, 3, 4)

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
                at = self.floats
                self.floats = end = at + math.prod(space.shape)
                return lambda floats, _: within(space, floats[:, at:end].reshape(-1, *space.shape))
            case spaces.Discrete() | spaces.MultiDiscrete():
                # Whole numbers may begin elsewhere than at 0.
                return self.choices(space, space.n if isinstance(space, spaces.Discrete) else space.nvec, space.start)
            case spaces.MultiBinary():
                return self.choices(space, np.full(space.shape, 2), 0)
        raise MessageError("no-action", f"ML-Agents has no action {space!s:.80}: {CURE}")

    def choices(self, space: Any, counts: Any, start: Any) -> Maker:
        at = len(self.branches)
        self.branches += np.ravel(counts).tolist()
        end = len(self.branches)
        if not np.any(start):
            return lambda _, numbers: numbers[:, at:end].reshape(-1, *space.shape).astype(space.dtype)
        return lambda _, numbers: (numbers[:, at:end].reshape(-1, *space.shape) + start).astype(space.dtype)


def within(space: spaces.Box, given: Any) -> Any:
    """Actions as the space has them. The float32 of a limit of float64 is that limit."""
    if space.dtype == np.float32:
        return given
    action = given.astype(space.dtype)
    for limit in (space.low, space.high):
        action = np.where(given == limit.astype(np.float32), limit, action)
    return action


class Seen:
    """Observations of a space: one for each array in it. What is called action_mask says what may be done."""

    def __init__(self, space: spaces.Space[Any], done: ActionSpec, channels_first: bool) -> None:
        self.channels_first = channels_first
        self.leaves = list(leaves_of(space, ()))
        masks = [at for at, (path, _) in enumerate(self.leaves) if path[:1] == (MASK,)]
        # Of another size it is something else.
        size = sum(math.prod(self.leaves[at][1].shape) for at in masks)
        self.masks = masks if size == sum(done.discrete_branches) else []
        self.others = [at for at in range(len(self.leaves)) if at not in self.masks]
        described = [self.described(*self.leaves[at]) for at in self.others]
        self.specs = [spec for spec, _ in described]
        self.readers = [reader for _, reader in described]

    def described(self, path: tuple[Any, ...], space: Any) -> tuple[ObservationSpec, Callable[[Any], Any]]:
        name = ".".join(map(str, path)) or "observation"
        shape: tuple[int, ...] = space.shape or (1,)
        if len(shape) == 3 and space.dtype == np.uint8 and shape[2] in CHANNELS:
            spec = ObservationSpec((shape[2], *shape[:2]), PICTURE, ObservationType.DEFAULT, name)
            return (spec, first) if self.channels_first else (channels_last(spec), as_picture)
        # An attention or a convolution may make sense of more dimensions, or none.
        properties = (DimensionProperty.NONE if len(shape) == 1 else DimensionProperty.UNSPECIFIED,) * len(shape)
        spec = ObservationSpec(shape, properties, ObservationType.DEFAULT, name)
        if space.dtype == np.float32 and space.shape:
            return spec, lambda part: part.copy()
        return spec, lambda part: part.astype(np.float32).reshape(len(part), *shape)

    def parts(self, batch: Any) -> list[Any]:
        """The part of each leaf."""
        return [part_of(batch, path) for path, _ in self.leaves]

    def split(self, parts: list[Any]) -> list[Any]:
        """A fresh array for each observation."""
        return [read(parts[at]) for at, read in zip(self.others, self.readers, strict=True)]

    def allowed(self, parts: list[Any]) -> Any:
        """Each row's masks side by side, as the scene has them: 1 may be done."""
        return np.concatenate([parts[at].reshape(len(parts[at]), -1) for at in self.masks], axis=1)


def first(batch: Any) -> Any:
    """A picture's channels come first."""
    return as_picture(np.ascontiguousarray(np.moveaxis(batch, 3, 1)))


def leaves_of(space: Any, path: tuple[Any, ...]) -> Iterator[tuple[tuple[Any, ...], Any]]:
    match space:
        case spaces.Dict():
            for key, part in space.items():
                yield from leaves_of(part, (*path, key))
        case spaces.Tuple():
            for at, part in enumerate(space):
                yield from leaves_of(part, (*path, at))
        case spaces.Box() | spaces.Discrete() | spaces.MultiDiscrete() | spaces.MultiBinary():
            yield path, space
        case _:
            where = f" at {'.'.join(map(str, path))}" if path else ""
            raise MessageError("no-observation", f"ML-Agents has no observation {space!s:.80}{where}: {CURE}")


def part_of(batch: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        batch = batch[key]
    return batch
