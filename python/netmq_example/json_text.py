"""JSON from a peer and for one: UTF-8, without NaN and half characters, and 64 levels deep at most, as in C#.

    value = parsed(frame)                       of bytes; ValueError says what is wrong with them
    value = json.loads(shallow(text))           ValueError says that it nests deeper

Without this limit each version of Python would refuse it at another depth. It needs only Python.
"""

import json
import re
from collections.abc import Callable
from typing import Any

DEEPEST = 64
# A bracket; or a text, in which a bracket is a character like any other.
PARTS = re.compile(r'"(?:[^"\\]++|\\.)*+"?|[][{}]', re.DOTALL)
# Escapes; of those that are half a character, such as \\ud800 alone, the name. It could not be printed.
HALVES = re.compile(r"\\u[dD][89abAB]..\\u[dD][c-fC-F]..|\\(u[dD][89a-fA-F])?.")
# Those of JSON, and no others.
BLANKS = " \t\n\r"


def refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is not JSON")


# Made once: json.loads and json.dumps make a new one at each call, which takes longer than a small text itself.
DECODER = json.JSONDecoder(parse_constant=refuse_constant)
# NaN is not JSON. Letters beyond ASCII become \u1234, so that no encoding on the way can spoil them.
ENCODER = json.JSONEncoder(separators=(",", ":"), allow_nan=False)
# The same texts as the encoder makes of these, sooner.
quoted = json.encoder.encode_basestring_ascii
WRITERS: dict[type, Callable[[Any], str]] = {str: quoted, int: int.__repr__, float: float.__repr__}


def parsed(frame: Any) -> Any:
    """The value in a frame of JSON; ValueError says why there is none."""
    text = shallow(str(frame, "utf-8").strip(BLANKS))
    value, end = DECODER.raw_decode(text)
    if end < len(text):
        raise ValueError("more follows it")
    if "\\u" in text and any(HALVES.findall(text)):
        raise ValueError("half a character")
    return value


def written(value: Any) -> str:
    """A text, a number, true or false as JSON, for which the encoder takes long."""
    return WRITERS.get(type(value), ENCODER.encode)(value)


def shallow(text: str) -> str:
    """The same text; ValueError if it nests more than 64 levels deep."""
    # Most texts have fewer brackets, and cost two counts.
    if text.count("[") + text.count("{") > DEEPEST:
        depth = 0
        for part in PARTS.finditer(text):
            if part[0] in "[{":
                depth += 1
            elif part[0] in "]}":
                depth -= 1
            if depth > DEEPEST:
                raise ValueError(f"it nests more than {DEEPEST} levels deep")
    return text
