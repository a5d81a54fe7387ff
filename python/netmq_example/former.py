"""How version 0.3 wrote it: this goes on for one version with a DeprecationWarning, and ends with the next.

class LazyPirate:
    @positional("context", "endpoint", "timeout", "tries", "report")
    def __init__(self, endpoint, *, timeout=0.5, tries=5, context=None): ...
"""

import functools
import importlib
import pkgutil
import sys
import warnings
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import zmq

P = ParamSpec("P")
T = TypeVar("T")

# The names that netmq_example.program had, by the module that each has moved to.
FROM_PROGRAM = {
    "asking": "at_least_one client_endpoint client_options connected positive_seconds wrong_usage",
    "console": "log_lines unhindered",
    "extras": "importing",
    "trouble": "cure",
    "large": "few_answers_wait receive_frames",
}


def renamed(old: str, new: str, value: T, level: int = 3) -> T:
    """The value that had another name."""
    warnings.warn(f"{old} is {new} now, and ends with the next version", DeprecationWarning, stacklevel=level)
    return value


def positional(*names: str) -> Callable[[Callable[P, None]], Callable[P, None]]:
    """For an __init__ whose words had another order: a context or a socket came first, and no word needed its name."""

    def decorate(init: Callable[P, None]) -> Callable[P, None]:
        @functools.wraps(init)
        def call(self: Any, *args: Any, **words: Any) -> None:
            if not is_former(args, words, names) or len(args) > len(names):
                cast(Any, init)(self, *args, **words)
                return
            name = type(self).__name__
            cure = f"write {name}(endpoint, …) with all others by name; its reports go to logging"
            warnings.warn(cure, DeprecationWarning, stacklevel=2)
            words = dict(zip(names, args, strict=False)) | words
            report = words.pop("report", words.pop("log", None))
            cast(Any, init)(self, **words)
            if report:
                self.report = report

        return cast(Callable[P, None], call)

    return decorate


def is_former(args: tuple[Any, ...], words: dict[str, Any], names: tuple[str, ...]) -> bool:
    first = args[0] if args else None
    is_long = len(args) > 1 and names[0] == "endpoint"
    return "report" in words or "log" in words or isinstance(first, zmq.Context | zmq.Socket) or is_long


def moved(old: str, new: str) -> None:
    """For a module that only imports the names of its new place; the modules of a package are the same ones there."""
    warnings.warn(f"{old} is {new} now, and ends with the next version", DeprecationWarning, stacklevel=3)
    for each in pkgutil.iter_modules(getattr(sys.modules[new], "__path__", ())):
        sys.modules[f"{old}.{each.name}"] = importlib.import_module(f"{new}.{each.name}")


def from_program(name: str) -> Any:
    for module, names in FROM_PROGRAM.items():
        if name in names.split():
            old, new = f"netmq_example.program.{name}", f"netmq_example.{module}.{name}"
            return renamed(old, new, getattr(importlib.import_module(f"netmq_example.{module}"), name), level=4)
    raise AttributeError(f"module 'netmq_example.program' has no attribute {name!r}")
