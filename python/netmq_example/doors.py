"""The names of a package, each loaded when it is first used, so that its import loads nothing. It needs only Python.

    if TYPE_CHECKING:
        from netmq_example.camera.client import DriverClient as DriverClient

    __all__ = ["DriverClient"]

    # Hidden from a type checker, to which any name would exist.
    if not TYPE_CHECKING:
        ROOMS = {"client": "DriverClient"}
        __getattr__, __dir__ = door(__name__, ROOMS)

A copy of a lesson has only the modules that it needs. A name of another one is an AttributeError there, as help(),
dir() and hasattr() expect it. A package that is missing is an ImportError with its cure.
"""

import importlib
import sys
from collections.abc import Callable
from typing import Any


def door(package: str, rooms: dict[str, str]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package, by the names that are in each of its modules."""
    places = {name: f"{package}.{room}" for room, names in rooms.items() for name in names.split()}

    def load(name: str) -> Any:
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        try:
            found = getattr(importlib.import_module(places[name]), name)
        except ModuleNotFoundError as error:
            if str(error.name).startswith("netmq_example"):
                raise AttributeError(f"{name} needs {error.name}, which is not in this copy") from None
            from netmq_example.extras import without

            raise without(error) from None
        setattr(sys.modules[package], name, found)
        return found

    return load, lambda: sorted({*vars(sys.modules[package]), *places})
