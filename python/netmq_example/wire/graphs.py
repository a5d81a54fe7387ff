"""Gymnasium's GraphInstance. By the scene's clock there are no graphs, and no gymnasium is needed."""

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from gymnasium.spaces import GraphInstance as GraphInstance
else:
    try:
        from gymnasium.spaces import GraphInstance
    except ModuleNotFoundError:

        class GraphInstance(NamedTuple):
            nodes: Any
            edges: Any
            edge_links: Any
