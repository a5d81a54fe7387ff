"""The message standard of this kit: a JSON header, then one frame of raw bytes for each array.

    frame 1     {"kind":"frame","version":1,"id":7,"values":{"bottom_up":true},
                 "arrays":[{"dtype":"uint8","shape":[240,320,3]}]}           JSON, UTF-8, at most 64 KB
    frame 2...  the arrays' items, row after row, little-endian; at most 1000 arrays, all together at most 64 MB

`values` are texts, numbers, true and false by name. A reply has the request's id, and its kind is `ok`, or `error` with
the values `code`, for programs, and `text`, for people. Fields that this version does not know are ignored.
The C# side is Message.cs. Take home: this file. It needs only Python, and imports no numpy and no ZeroMQ.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

VERSION = 1
HEADER_LIMIT, LIMIT, MOST_ARRAYS = 64 * 1024, 64 * 1024 * 1024, 1000
# Whole numbers nearer to zero than this are exact in every JSON reader, also in one that knows only floats.
EXACT = 2**53
# The names are numpy's, and their items' sizes in bytes.
DTYPES = {"uint8": 1, "uint16": 2, "int32": 4, "int64": 8, "float32": 4, "float64": 8}
WORDS = {str: "text", int: "a whole number", dict: "an object", list: "a list"}

Bytes = bytes | bytearray | memoryview
Value = str | int | float | bool


class MessageError(Exception):
    """What is wrong with a message: a code for programs, a text for people, and the message's id where it has one."""

    def __init__(self, code: str, text: str, id: int = 0) -> None:
        super().__init__(f"{code}: {text}")
        self.code, self.text, self.id = code, text, id


@dataclass
class Array:
    dtype: str
    shape: tuple[int, ...]
    data: Bytes


@dataclass
class Message:
    kind: str
    id: int = 0
    values: dict[str, Value] = field(default_factory=dict)
    arrays: list[Array] = field(default_factory=list)

    def frames(self) -> list[Bytes]:
        arrays = [{"dtype": array.dtype, "shape": array.shape} for array in self.arrays]
        header = {"kind": self.kind, "version": VERSION, "id": self.id, "values": self.values, "arrays": arrays}
        # NaN is not JSON. Letters beyond ASCII become \u1234, so that no encoding on the way can spoil them.
        text = json.dumps(header, separators=(",", ":"), allow_nan=False)
        return [text.encode(), *(array.data for array in self.arrays)]


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def read(frames: Sequence[Bytes]) -> Message:
    """The message in the frames that were received, whose payloads are not copied; MessageError says what is wrong."""
    if len(frames) > MOST_ARRAYS + 1:
        raise MessageError("bad-frames", f"more than {MOST_ARRAYS} frames follow the header")
    if len(frames[0]) > HEADER_LIMIT:
        raise MessageError("too-big", f"the header has {len(frames[0])} bytes, the limit is {HEADER_LIMIT}")
    try:
        header = json.loads(bytes(frames[0]).decode(), parse_constant=refuse_constant)
    except (ValueError, RecursionError) as error:
        raise MessageError("bad-json", f"the header is not JSON in UTF-8: {error!s:.80}") from None
    id = header.get("id") if type(header) is dict else 0
    try:
        return read_fields(header, frames[1:])
    except MessageError as error:
        error.id = id if type(id) is int and 0 <= id < EXACT else 0
        raise


def refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is not JSON")


def read_fields(header: Any, payloads: Sequence[Bytes]) -> Message:
    # The version comes first: another one may have other fields.
    if (version := take(header, "version", int)) != VERSION:
        cure = "use messages.py and Message.cs of the same release on both sides"
        raise MessageError("bad-version", f"the message has version {version!s:.9}, this side has {VERSION}; {cure}")
    message = Message(take(header, "kind", str), take(header, "id", int), take(header, "values", dict))
    if not 0 <= message.id < EXACT:
        raise MessageError("bad-value", "'id' must be 0 to 2**53 - 1")
    for name, value in message.values.items():
        if type(value) not in (str, int, float, bool):
            raise MessageError("wrong-type", f"value {name!a:.40} must be text, a number, true or false")
        if not isinstance(value, str) and not abs(value) < (math.inf if type(value) is float else EXACT):
            raise MessageError("bad-value", f"value {name!a:.40} is too large to be exact")
    arrays = take(header, "arrays", list)
    if len(arrays) != len(payloads):
        raise MessageError("bad-frames", f"the header lists {len(arrays)} arrays, but {len(payloads)} frames follow it")
    if (size := sum(len(payload) for payload in payloads)) > LIMIT:
        raise MessageError("too-big", f"the arrays have {size} bytes, the limit is {LIMIT}")
    message.arrays = [read_array(array, payload) for array, payload in zip(arrays, payloads, strict=True)]
    return message


def read_array(array: Any, data: Bytes) -> Array:
    dtype, shape = take(array, "dtype", str), take(array, "shape", list)
    if dtype not in DTYPES:
        raise MessageError("bad-dtype", f"dtype {dtype!a:.40} is none of {', '.join(DTYPES)}")
    if len(shape) > 8 or any(type(size) is not int or not 0 <= size <= LIMIT for size in shape):
        raise MessageError("bad-shape", f"a shape is at most 8 whole numbers from 0 to {LIMIT}")
    if (size := math.prod(shape) * DTYPES[dtype]) != len(data):
        raise MessageError("bad-shape", f"{dtype} {shape} is {size} bytes, but its frame has {len(data)}")
    return Array(dtype, tuple(shape), data)


def take(where: Any, name: str, kind: type) -> Any:
    if type(where) is not dict:
        raise MessageError("wrong-type", f"expected an object with '{name}'")
    if name not in where:
        raise MessageError("missing-field", f"there is no '{name}'")
    # Not isinstance: to Python, True is a whole number.
    if type(where[name]) is not kind:
        raise MessageError("wrong-type", f"'{name}' must be {WORDS[kind]}")
    return where[name]
