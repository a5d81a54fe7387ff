"""The names of PettingZoo's agents, as mlagents_envs.envs.env_helpers makes them, and libraries that are loaded late.

    "Ball?team=0?agent_id=3"        the agent 3 of the behavior "Ball?team=0"

It needs nothing but Python.
"""

import functools
import importlib
import sys
from typing import Any, TypeVar
from urllib.parse import parse_qs, urlparse

from netmq_example.extras import pip_install, without

T = TypeVar("T")

AGENT_ID = "?agent_id="


def _behavior_to_agent_id(behavior_name: str, unique_id: int) -> str:
    return f"{behavior_name}{AGENT_ID}{unique_id}"


def _agent_id_to_behavior(agent_id: str) -> str:
    return agent_id.partition(AGENT_ID)[0]


def _parse_behavior(full_behavior: str) -> tuple[str, int]:
    """The behavior's name and its team."""
    parsed = urlparse(full_behavior)
    return parsed.path, int(parse_qs(parsed.query).get("team", ["0"])[0])


def find_spaces() -> Any:
    """The spaces of gym where it is installed, else Gymnasium's."""
    for library in ("gym", "gymnasium"):
        try:
            return importlib.import_module(f"{library}.spaces")
        except ModuleNotFoundError as error:
            if error.name not in (library, f"{library}.spaces"):
                raise without(error) from None
    raise ModuleNotFoundError(f"no gym and no gymnasium, whose spaces this has: {pip_install('gymnasium')}", name="gym")


@functools.cache
def derived(kind: Any, base: Any) -> Any:
    return type(kind.__name__, (kind, base), {"__module__": kind.__module__, "__doc__": kind.__doc__})


def with_base(kind: type[T], library: str, base: str, needed: bool) -> type[T]:
    """The same class, derived from a library's base as well: the library is loaded only when an object is made."""
    if not needed and not sys.modules.get(library):
        return kind
    try:
        found = getattr(importlib.import_module(library), base)
    except ImportError as error:
        raise without(error) from None
    own: Any = kind
    both: type[T] = kind if issubclass(kind, found) else derived(own, found)
    return both
