"""Lesson 11, fitting: a value as something of its space, or an error that says where.

    fitted(space, value, "'car'@")      a fresh copy, cast to the space's dtype; what does not fit is refused:
                                        'car'@['speed']: float32 [3] is not in Box(0.0, 1.0, (2,), float32)

A sequence has at most 50,000 items, unless it is one stack of numbers.
"""

import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.spaces import GraphInstance, Space
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from mapping import spelled
from merge import MOST, REASONS, cast
from messages import MessageError


def fitted(space: Space[Any], value: Any, where: str) -> Any:
    fit: Any = value
    match space:
        case spaces.Dict() if isinstance(value, dict) and value.keys() == space.keys():
            return {key: fitted(part, value[key], where + spelled((key,))) for key, part in space.items()}
        case spaces.Tuple() if isinstance(value, list | tuple) and len(value) == len(space):
            return tuple(fitted(part, value[at], f"{where}[{at}]") for at, part in enumerate(space))
        case spaces.Sequence() if isinstance(value, Iterable) and not isinstance(value, str):
            return sequence(space, value, where)
        case spaces.Graph() if isinstance(value, GraphInstance):
            fit = graph(space, value, where)
        case spaces.Text() if isinstance(value, str):
            pass
        case spaces.Dict() | spaces.Tuple() | spaces.Sequence() | spaces.Graph() | spaces.Text():
            raise misfit(space, value, where)
        case _:
            try:
                fit = cast(np.empty(space.shape or (), space.dtype), value)
            except REASONS:
                raise misfit(space, value, where) from None
            fit = fit[()] if isinstance(space, spaces.Discrete) else fit
    if fit not in space:
        raise misfit(space, value, where)
    return fit


def sequence(space: spaces.Sequence, value: Any, where: str) -> Any:
    """All its items at once where they are numbers: one by one they would take twenty times as long."""
    feature: Any = space.feature_space
    try:
        # A dict of stacked arrays is a stack as well.
        items = iterate(space.stacked_feature_space, value) if isinstance(value, dict) and space.stack else value
        items = items if isinstance(items, np.ndarray) else list(items)
        count, numbers = len(items), None
    except REASONS:
        raise misfit(space, value, where) from None
    if count and isinstance(feature, spaces.Box | spaces.Discrete | spaces.MultiBinary | spaces.MultiDiscrete):
        with suppress(*REASONS):
            numbers = cast(np.empty(0, feature.dtype), items)
            # The shape first: a space of so many items may be larger than the memory.
            fits = numbers.shape == (count, *(feature.shape or ())) and numbers in batch_space(feature, count)
            numbers = numbers if fits else None
    if space.stack and numbers is not None:
        return numbers
    if count > MOST:
        raise MessageError("too-many", f"{where}: {count} items, but at most {MOST}, or a stack of numbers that fit")
    if numbers is not None:
        return tuple(numbers[at] if isinstance(feature, spaces.Discrete) else numbers[at, ...] for at in range(count))
    # Or one of them is wrong, and this says which.
    parts = tuple(fitted(feature, item, f"{where}[{at}]") for at, item in enumerate(items))
    return stacked(feature, parts) if space.stack else parts


def stacked(feature: Space[Any], items: tuple[Any, ...]) -> Any:
    """Items as a stack: an array with one dimension more, or a dict of such."""
    room: Any = create_empty_array(feature, len(items))
    return concatenate(feature, items, room) if items else room


def graph(space: spaces.Graph, value: GraphInstance, where: str) -> GraphInstance:
    def stack(part: Space[Any] | None, items: Any, name: str) -> Any:
        if items is None or part is None:
            return None
        return fitted(spaces.Sequence(part, stack=True), items, f"{where}.{name}")

    try:
        links = None if value.edge_links is None else cast(np.empty(0, np.int32), value.edge_links)
    except REASONS:
        raise misfit(space, value, where) from None
    nodes = stack(space.node_space, value.nodes, "nodes")
    return GraphInstance(nodes, stack(space.edge_space, value.edges, "edges"), links)


def misfit(space: Space[Any], value: Any, where: str) -> MessageError:
    shown = f"{value.dtype} {list(value.shape)}" if isinstance(value, np.ndarray) else type(value).__name__
    return MessageError("not-in-space", f"{where}: {shown} {' '.join(repr(value).split())[:60]} is not in {space}")
