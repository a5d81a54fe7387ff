"""The names of PettingZoo's agents, as mlagents_envs.envs.env_helpers makes them, and libraries that are loaded late.

    "Ball?team=0?agent_id=3"        the agent 3 of the behavior "Ball?team=0"

It needs nothing but Python, until an environment is made.
"""

import functools
import importlib
from typing import Any

from netmq_example.extras import pip_install, without

AGENT_ID = "?agent_id="


def _behavior_to_agent_id(behavior_name: str, unique_id: int) -> str:
    return f"{behavior_name}{AGENT_ID}{unique_id}"


def _agent_id_to_behavior(agent_id: str) -> str:
    return agent_id.partition(AGENT_ID)[0]


def find_spaces() -> Any:
    """The spaces of gym where it is installed, else Gymnasium's."""
    for library in ("gym", "gymnasium"):
        try:
            return importlib.import_module(f"{library}.spaces")
        except ModuleNotFoundError as error:
            if error.name not in (library, f"{library}.spaces"):
                raise without(error) from None
    raise ModuleNotFoundError(f"no gym and no gymnasium, whose spaces this has: {pip_install('gymnasium')}", name="gym")


def action_space(spaces: Any, spec: Any) -> Any:
    """Floats from -1 to 1, and choices: both in a tuple. None where nothing is done."""
    parts = [spaces.Box(-1, 1, (spec.continuous_size,))] if spec.continuous_size else []
    if spec.discrete_size == 1:
        parts.append(spaces.Discrete(spec.discrete_branches[0]))
    elif spec.discrete_size:
        parts.append(spaces.MultiDiscrete(spec.discrete_branches))
    return spaces.Tuple(parts) if len(parts) > 1 else next(iter(parts), None)


@functools.cache
def derived(kind: Any, base: str) -> Any:
    """The same class, derived from PettingZoo's as well, which is loaded only when an object is made."""
    try:
        found = getattr(importlib.import_module("pettingzoo"), base)
    except ImportError as error:
        raise without(error) from None
    return type(kind.__name__, (kind, found), {"__module__": kind.__module__, "__doc__": kind.__doc__})
