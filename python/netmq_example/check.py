"""Rules that many classes share for what they are given. One line says what is wrong with it: ValueError or TypeError.

self.tries = check.count("tries", tries)
"""

import math
import re
from typing import Any, TypeVar

T = TypeVar("T")

DAY = 86_400


def seconds(name: str, value: Any, zero: bool = False) -> float:
    """A number of seconds, at most a day, and more than 0 unless `zero` is fine as well."""
    if is_number(value) and (0 < value <= DAY or (zero and value == 0)):
        return float(value)
    least = "0 or more" if zero else "more than 0"
    raise ValueError(f"{name} takes seconds, {least} and at most a day, not {value!r:.40}")


def count(name: str, value: Any, least: int = 1, most: int = 2**31 - 1) -> int:
    """A whole number from `least` to `most`."""
    if is_number(value) and int(value) == value and least <= value <= most:
        return int(value)
    raise ValueError(f"{name} takes a whole number from {least} to {most}, not {value!r:.40}")


def is_number(value: Any) -> bool:
    """Also one of numpy's; NaN, infinity, a bool and an array of one number are none."""
    # Whether float() takes such an array, numpy's versions do not agree.
    if isinstance(value, bool | str | bytes) or not hasattr(value, "__float__") or getattr(value, "ndim", False):
        return False
    try:
        return math.isfinite(float(value))
    except (TypeError, ValueError, OverflowError):
        return False


def instance(name: str, value: T, *kinds: Any) -> T:
    """Something of one of these classes; Callable and None's own class may be among them."""
    if isinstance(value, kinds):
        return value
    words = " or ".join("None" if kind is type(None) else kind.__name__ for kind in kinds)
    article = "an" if words[0].lower() in "aeio" else "a"
    raise TypeError(f"{name} takes {article} {words}, not {value!r:.40}")


def endpoint(value: Any, example: str, lowest_port: int = 1, beacon: bool = False) -> str:
    """Where to connect or, with 0 as the lowest port, to bind: by HTTP where the example is, and otherwise by TCP.

    libzmq takes port 99999 as 34463, without an error. What is not of TCP, as ipc:// and inproc://, is left to libzmq.
    With `beacon` also beacon://NAME:PORT, for those who look for it by BeaconSearch.
    """
    scheme = example.partition(":")[0]
    if scheme == "tcp" and isinstance(value, str) and re.match(r"(?!tcp:|beacon:)[a-z]+://.", value):
        return value
    place = rf"(?:{scheme}://[\w.*-]+{'|beacon://[A-Za-z0-9._-]{1,32}' if beacon else ''}):(\*|\d{{1,5}})"
    port = re.fullmatch(place, value, re.ASCII) if isinstance(value, str) else None
    if port and lowest_port <= int(port[1].replace("*", "0")) <= 65535:
        return str(value)
    raise ValueError(f"bad endpoint '{value!s:.80}': write it like {example}, port {lowest_port} to 65535")
