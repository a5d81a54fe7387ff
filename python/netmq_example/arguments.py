"""More rules, as those of check.py, which no program of a lesson needs by itself.

self.dt = arguments.number("dt", dt, least=0)
"""

import math
import os
from pathlib import Path
from typing import Any, TypeVar

from netmq_example.check import instance, is_number

T = TypeVar("T")


def number(name: str, value: Any, least: float = -math.inf, most: float = math.inf) -> float:
    """A finite number from `least` to `most`."""
    if is_number(value) and least <= value <= most:
        return float(value)
    within = "" if math.isinf(least) and math.isinf(most) else f" from {least:g} to {most:g}"
    raise ValueError(f"{name} takes a number{within}, not {value!r:.40}")


def text(name: str, value: Any) -> str:
    """A text that is not empty."""
    if isinstance(value, str) and value:
        return value
    raise ValueError(f"{name} takes a text that is not empty, not {value!r:.40}")


def path(name: str, value: Any) -> Path:
    """A path; an empty text, as of a variable that is not set, is not the folder where the program was started."""
    if isinstance(value, str | os.PathLike) and os.fspath(value):
        return Path(value)
    raise ValueError(f"{name} takes a path that is not empty, not {value!r:.40}")


def blocking(name: str, value: T, *kinds: Any) -> T:
    """The same for a context or a socket. Those of zmq.asyncio derive from pyzmq's own, but their calls do not wait."""
    if any(kind.__module__ == "zmq.asyncio" for kind in type(value).__mro__):
        raise TypeError(f"{name} is one of zmq.asyncio: take one of zmq, and await its calls by asyncio.to_thread")
    return instance(name, value, *kinds)


def context(value: Any) -> Any:
    """The caller's zmq.Context, still open, or pyzmq's own for this process."""
    import zmq

    if value is None:
        return zmq.Context.instance()
    return not_closed("context", blocking("context", value, zmq.Context))


def keys(value: T, method: str = "apply", made: str = "ClientKeys(folder)") -> T:
    """The keys that netmq_example.security makes of a folder, or None."""
    if value is None or hasattr(value, method):
        return value
    raise TypeError(f"keys takes {made} of netmq_example.security, not {value!r:.40}")


def function(name: str, value: T) -> T:
    """The same for a function, or anything else that can be called."""
    if callable(value):
        return value
    raise TypeError(f"{name} takes a function, not {value!r:.40}")


def not_closed(name: str, value: T) -> T:
    """A socket, a context or the like that is still open: libzmq's own words for it do not say so."""
    if value.closed:  # type: ignore[attr-defined]
        raise ValueError(f"{name} is closed: make a new one")
    return value


def data(name: str, value: Any) -> bytes:
    """Bytes, or a copy of what holds them: a bytearray, an array. bytes(5) would be five zeros."""
    try:
        return memoryview(value).tobytes()
    except TypeError:
        raise TypeError(f"{name} takes bytes, not {value!r:.40}") from None


def regular_file(path: Path, most: int) -> Path:
    """A file of at most so many bytes, or OSError: a pipe or a device may have no end."""
    if path.stat().st_size > most or not path.is_file():
        raise OSError(f"{path.name!r:.80} must be a regular file of at most {most} bytes")
    return path
