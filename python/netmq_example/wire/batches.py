"""Values of Gymnasium's spaces: many as a batch, and the one that stands for nothing seen yet. It needs numpy."""

from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate

from netmq_example.wire.spaces import no_place


def together(space: spaces.Space[Any], values: list[Any]) -> Any:
    """A batch, as Gymnasium makes it of single ones."""
    room: Any = create_empty_array(space, len(values))
    # Of nothing Gymnasium stacks nothing, with an error.
    return concatenate(space, values, room) if values else room


def empty(space: spaces.Space[Any], where: str) -> Any:
    """The value of a space before anything was seen, never a sample: zeros as near as it has them, "", (), no nodes."""
    match space:
        case spaces.Box():
            return np.asarray(np.clip(np.zeros(space.shape, space.dtype), space.low, space.high))
        case spaces.Discrete():
            return space.start
        case spaces.Text():
            return space.character_list[0] * space.min_length if space.min_length else ""
        case spaces.Dict():
            return {key: empty(part, f"{where}[{key!r}]") for key, part in space.items()}
        case spaces.Tuple():
            return tuple(empty(part, f"{where}[{at}]") for at, part in enumerate(space))
        case spaces.Sequence():
            empty(space.feature_space, f"{where}[]")
            # Also where it is stacked: fitted stacks what is handed out.
            return ()
        case spaces.Graph():
            nodes: Any = create_empty_array(space.node_space, 0)
            return spaces.GraphInstance(nodes, None, None)
        case spaces.MultiDiscrete():
            return space.start.copy()
        case spaces.MultiBinary():
            return np.zeros(space.shape, space.dtype)
        case spaces.OneOf():
            return np.int64(0), empty(space.spaces[0], where)
    raise no_place(space, f"{where}: ")


def unstacked(space: Any, values: Any) -> list[Any]:
    """The way back, however many they are."""
    return list(iterate(batch_space(space, 1), values))
