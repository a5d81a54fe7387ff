"""The message standard of this kit: a JSON header, then one frame of raw bytes for each array.

    frame 1     {"kind":"frame","version":1,"id":7,"values":{"bottom_up":true},
                 "arrays":[{"dtype":"uint8","shape":[240,320,3]}]}           JSON, UTF-8, at most 64 KB
    frame 2...  the arrays' items, row after row, little-endian; all arrays together at most 64 MB

`values` are texts, numbers, true and false by name. A reply has the request's id, and its kind is `ok`, or `error` with
the values `code`, for programs, and `text`, for people. Fields that this version does not know are ignored.
The C# side is Message.cs. It needs only Python; `Array.numpy` needs numpy.
"""

import json
import math
from dataclasses import dataclass, field
from typing import Any

VERSION, HEADER_LIMIT, LIMIT = 1, 64 * 1024, 64 * 1024 * 1024
# Whole numbers nearer to zero than this are exact in every JSON reader, also in one that knows only floats.
EXACT = 2**53
# The names are numpy's, and their items' sizes in bytes.
DTYPES = {"uint8": 1, "uint16": 2, "int32": 4, "int64": 8, "float32": 4, "float64": 8}


def refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is not JSON")


# Made once: json.loads and json.dumps make a new one at each call, which takes longer than the header itself.
DECODER = json.JSONDecoder(parse_constant=refuse_constant)
# NaN is not JSON. Letters beyond ASCII become \u1234, so that no encoding on the way can spoil them.
ENCODER = json.JSONEncoder(separators=(",", ":"), allow_nan=False)


class MessageError(Exception):
    """What is wrong with a message: a code for programs, a text for people, and the message's id where it has one."""

    def __init__(self, code: str, text: str, id: int = 0) -> None:
        super().__init__(f"{code}: {text}")
        self.code, self.text, self.id = code, text, id


@dataclass(slots=True)
class Array:
    """Numbers, and how they are to be read. `data` is any bytes: a memoryview, a zmq.Frame, a numpy array."""

    dtype: str
    shape: tuple[int, ...]
    data: Any

    def __post_init__(self) -> None:
        if self.dtype not in DTYPES:
            raise MessageError("bad-dtype", f"dtype {self.dtype!a:.40} is none of {', '.join(DTYPES)}")
        size, view = math.prod(self.shape) * DTYPES[self.dtype], memoryview(self.data)
        if size != view.nbytes or not view.c_contiguous:
            raise MessageError("bad-shape", f"{self.dtype} {self.shape} is {size} contiguous bytes, not {view.nbytes}")

    def numpy(self) -> Any:
        """The numbers for numpy, in the very memory that ZeroMQ received them in."""
        try:
            import numpy as np
        except ImportError:
            raise MessageError("no-numpy", "arrays need numpy where they are read: pip install numpy") from None
        return np.frombuffer(self.data, np.dtype(self.dtype).newbyteorder("<")).reshape(self.shape)


@dataclass(slots=True)
class Message:
    kind: str
    id: int = 0
    values: dict[str, Any] = field(default_factory=dict)
    arrays: list[Array] = field(default_factory=list)

    def frames(self) -> list[Any]:
        arrays = [{"dtype": array.dtype, "shape": array.shape} for array in self.arrays]
        header = {"kind": self.kind, "version": VERSION, "id": self.id, "values": self.values, "arrays": arrays}
        return [ENCODER.encode(header).encode(), *(array.data for array in self.arrays)]


def read(frames: list[Any]) -> Message:
    """The message in the frames that were received, whose payloads are not copied; MessageError says what is wrong."""
    if len(frames[0]) > HEADER_LIMIT or sum(map(len, frames[1:])) > LIMIT:
        raise MessageError("too-big", f"a header has at most {HEADER_LIMIT} bytes, all arrays together {LIMIT}")
    try:
        header = DECODER.decode(text := bytes(frames[0]).decode())
        if "\\u" in text:
            # Half a character, such as \ud800 alone, is none that could be printed, and another one in C#.
            json.dumps(header, ensure_ascii=False).encode()
    except (ValueError, RecursionError) as error:
        raise MessageError("bad-json", f"the header is not JSON in UTF-8: {error!s:.80}") from None
    try:
        return read_fields(header, frames[1:])
    except MessageError as error:
        if type(header) is dict and type(id := header.get("id")) is int and 0 <= id < EXACT:
            error.id = id
        raise


def read_fields(header: Any, payloads: list[Any]) -> Message:
    # The version comes first: another one may have other fields.
    if (version := take(header, "version", int)) != VERSION:
        raise MessageError("bad-version", f"version {version!s:.9}, here {VERSION}: are both sides of one release?")
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
    for array, payload in zip(arrays, payloads, strict=True):
        dtype, shape = take(array, "dtype", str), take(array, "shape", list)
        whole = {*map(type, shape)} <= {int} and min(shape, default=0) >= 0
        # Its items are counted also where a 0 makes nothing of them: numpy takes no larger shape.
        if len(shape) > 8 or not whole or math.prod(filter(None, shape)) > LIMIT:
            raise MessageError("bad-shape", f"a shape is at most 8 whole numbers, of at most {LIMIT} items")
        message.arrays.append(Array(dtype, tuple(shape), payload))
    return message


def take(where: Any, name: str, kind: type) -> Any:
    if type(where) is not dict:
        raise MessageError("wrong-type", f"expected an object with '{name}'")
    if name not in where:
        raise MessageError("missing-field", f"there is no '{name}'")
    # Not isinstance: to Python, True is a whole number.
    if type(where[name]) is not kind:
        raise MessageError("wrong-type", f"'{name}' must be {kind.__name__}")
    return where[name]
