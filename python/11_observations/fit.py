"""Lesson 11, fitting: what a space begins with, and a value as something of its space, or an error that says where.

    empty(space)             zeros as near as the space has them, "", (), no nodes; never a sample
    fitted(space, value, "'car'@")      a fresh copy, cast to the space's dtype; what does not fit is refused:
                                        'car'@['speed']: float32 [3] is not in Box(0.0, 1.0, (2,), float32)

All of Gymnasium's fundamental and composite spaces but OneOf.
Take home: this file with merge.py, locator.py, mapping.py and reader.py, and messages.py of lesson 05.
"""

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.spaces import GraphInstance, Space
from gymnasium.vector.utils import concatenate, create_empty_array, iterate

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from mapping import spelled
from merge import REASONS, cast
from messages import MessageError


def empty(space: Space[Any]) -> Any:
    match space:
        case spaces.Box():
            return np.asarray(np.clip(np.zeros(space.shape, space.dtype), space.low, space.high))
        case spaces.Discrete():
            return space.start
        case spaces.Text():
            return space.character_list[0] * space.min_length if space.min_length else ""
        case spaces.Dict():
            return {key: empty(part) for key, part in space.items()}
        case spaces.Tuple():
            return tuple(map(empty, space))
        case spaces.Sequence():
            # Also where it is stacked: fitted stacks what is handed out.
            return ()
        case spaces.Graph():
            return GraphInstance(some(space.node_space, ()), None, None)
        case spaces.MultiDiscrete():
            return space.start.copy()
        case spaces.MultiBinary():
            return np.zeros(space.shape, space.dtype)
    raise NotImplementedError(f"{space} has no place in a message")


def fitted(space: Space[Any], value: Any, where: str) -> Any:
    fit: Any = value
    match space:
        case spaces.Dict() if isinstance(value, dict) and value.keys() == space.keys():
            return {key: fitted(part, value[key], where + spelled((key,))) for key, part in space.items()}
        case spaces.Tuple() if isinstance(value, list | tuple) and len(value) == len(space):
            return tuple(fitted(part, value[at], f"{where}[{at}]") for at, part in enumerate(space))
        case spaces.Sequence() if isinstance(value, Iterable) and not isinstance(value, str):
            feature = space.feature_space
            # A dict of stacked arrays is a stack as well.
            items = iterate(space.stacked_feature_space, value) if isinstance(value, dict) and space.stack else value
            parts = tuple(fitted(feature, item, f"{where}[{at}]") for at, item in enumerate(items))
            if not space.stack:
                return parts
            return some(feature, parts)
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


def some(feature: Space[Any], items: tuple[Any, ...]) -> Any:
    """Items as a stack: an array with one dimension more, or a dict of such."""
    room: Any = create_empty_array(feature, len(items))
    return concatenate(feature, items, room) if items else room


def graph(space: spaces.Graph, value: GraphInstance, where: str) -> GraphInstance:
    def stacked(part: Space[Any] | None, items: Any, name: str) -> Any:
        return (
            None
            if items is None or part is None
            else fitted(spaces.Sequence(part, stack=True), items, f"{where}.{name}")
        )

    links = None if value.edge_links is None else np.array(value.edge_links, np.int32)
    nodes = stacked(space.node_space, value.nodes, "nodes")
    return GraphInstance(nodes, stacked(space.edge_space, value.edges, "edges"), links)


def misfit(space: Space[Any], value: Any, where: str) -> MessageError:
    shown = f"{value.dtype} {list(value.shape)}" if isinstance(value, np.ndarray) else type(value).__name__
    return MessageError("not-in-space", f"{where}: {shown} {' '.join(repr(value).split())[:60]} is not in {space}")
