"""Lesson 11, the beginning: what a space has before anything was seen, and never a sample.

    empty(space, "'car'@")              zeros as near as the space has them, "", (), no nodes

All of Gymnasium's fundamental and composite spaces but OneOf: of another one it says where it is.
Take home: this file with mapping.py. It needs gymnasium.
"""

from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.spaces import GraphInstance, Space
from gymnasium.vector.utils import create_empty_array
from mapping import spelled


def empty(space: Space[Any], where: str) -> Any:
    match space:
        case spaces.Box():
            return np.asarray(np.clip(np.zeros(space.shape, space.dtype), space.low, space.high))
        case spaces.Discrete():
            return space.start
        case spaces.Text():
            return space.character_list[0] * space.min_length if space.min_length else ""
        case spaces.Dict():
            return {key: empty(part, where + spelled((key,))) for key, part in space.items()}
        case spaces.Tuple():
            return tuple(empty(part, f"{where}[{at}]") for at, part in enumerate(space))
        case spaces.Sequence():
            empty(space.feature_space, f"{where}[]")
            # Also where it is stacked: fitted stacks what is handed out.
            return ()
        case spaces.Graph():
            nodes: Any = create_empty_array(space.node_space, 0)
            return GraphInstance(nodes, None, None)
        case spaces.MultiDiscrete():
            return space.start.copy()
        case spaces.MultiBinary():
            return np.zeros(space.shape, space.dtype)
    raise ValueError(f"{where}: {space} has no place in a message; Gymnasium's own spaces have, but OneOf")
