"""Lesson 11, the beginning: what a space has before anything was seen, and never a sample.

    empty(space, "'car'@")              zeros as near as the space has them, "", (), no nodes
    warn({"car": space}, locators)       names what stays so, when values go to the places of these locators alone

All of Gymnasium's fundamental and composite spaces but OneOf: of another one it says where it is.
It needs gymnasium.
"""

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.spaces import GraphInstance, Space
from gymnasium.vector.utils import create_empty_array
from locator import Locator
from mapping import Path, quoted, spelled


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


def warn(observations: dict[str, Space[Any]], locators: list[Locator]) -> None:
    """Of what stays empty, because none of these locators goes there."""
    for agent, space in observations.items():
        paths = [one.destination for locator in locators for one in locator.mappings if one.names(agent)]
        for path in unwritten(space, paths):
            place = f"{quoted(agent)}@{spelled(path)}"
            warnings.warn(f"nothing writes {place}: is there such a member in C#? It stays as it is", stacklevel=3)


def unwritten(space: Space[Any], paths: list[Path], at: Path = ()) -> Iterator[Path]:
    """Keys, also of dicts in dicts, in which nothing arrives. Who gets a part of something gets something."""
    if not any(path[: len(at)] == at for path in paths):
        yield at
    elif isinstance(space, spaces.Dict) and at not in paths:
        for key, part in space.items():
            yield from unwritten(part, paths, (*at, key))
