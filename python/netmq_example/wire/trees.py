"""Values of any kind as bytes: their form as JSON, and then their numbers.

    data = write({"speed": 2.5, "picture": np.zeros((24, 32, 3), np.uint8), "says": ["hello"]})
    value = read(data)              the same, fresh; tuples come back as lists

    uint32, little-endian       how many bytes the form has
    ...                         the form, JSON in ASCII
    ...                         the numbers, little-endian, one after the other, as the form says

    "null"  "bool"  "int64"  "float64"              0, 1, 8 and 8 bytes
    "text"                                          uint32, how many bytes; then UTF-8
    "bytes"                                         uint32, how many bytes; then these
    {"image": "bytes"}                              a PNG or JPEG file, of which the pixels are read: uint8
                                                    [height, width, 3], in grey [height, width]; needs Pillow
    "float32[2,3]"                                  an array
    [form, …]                                       a list
    {"dict": {"speed": form, …}}                    a dict
    {"graph": [nodes, edges, edge_links]}           Gymnasium's GraphInstance; without edges both are "null"

The form of most values stays the same from step to step, and so it is looked at once. An array of a dtype that no
message has, other than int8, travels as the next larger one, and loses nothing. MessageError says what has no place in
a message, or what is wrong with what a peer sent. In C# it is MessageTree.cs. It needs numpy, and gymnasium for graphs.
"""

import functools
import importlib
import math
import re
import struct
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from netmq_example import arguments, check
from netmq_example.json_text import ENCODER, parsed, shallow
from netmq_example.messages import DTYPES, LIMIT, Array, MessageError
from netmq_example.wire.graphs import GraphInstance

SIZE = struct.Struct("<I")
INT64 = struct.Struct("<q")
FLOAT64 = struct.Struct("<d")
# Those of a message, and int8, which masks have in Gymnasium; C# reads that as int32.
ARRAYS = (*DTYPES, "int8")
# The dtypes that neither has, and those that they travel as.
WIDER = {"bool": "uint8", "int16": "int32", "uint32": "int64", "float16": "float32"}
# Forms are looked at once, but whoever sends ever new ones, or long ones, fills no memory.
MOST_KEPT = 200
LONGEST_KEPT = 16 * 1024
# In bytes. To read one takes a hundred times as much memory.
LONGEST_FORM = 1024 * 1024
# What is wrong with bytes that are none of these.
REASONS = (ValueError, LookupError, TypeError, struct.error)

# Takes the numbers and where its own begin; returns the value and where the next one's begin.
Reader = Callable[[Any, int], tuple[Any, int]]
T = TypeVar("T")


def write(value: Any) -> bytes:
    return written(lambda parts: form_of(value, parts))


def array_of(data: bytes) -> Array:
    """A value in a message of lesson 05, which has only arrays and flat values."""
    return Array("uint8", (len(data),), data)


def write_pairs(pairs: list[tuple[str, Any]]) -> bytes:
    """Locators, and what stands there now (lesson 11); as form it has [["'car'@['speed'] = $", form], …]."""
    return written(lambda parts: [[text, form_of(value, parts)] for text, value in pairs])


def written(form_and: Callable[[list[Any]], Any]) -> bytes:
    parts: list[Any] = []
    try:
        form = shallow(ENCODER.encode(form_and(parts))).encode()
    except MessageError:
        raise
    except (ValueError, RecursionError) as error:
        raise MessageError("bad-tree", f"it is no text, or has no end: {error!s:.80}") from None
    return b"".join([SIZE.pack(len(form)), form, *parts])


def pairs_of(form: bytes) -> list[tuple[str, Any]]:
    """The way back: texts with their forms."""
    try:
        pairs = check.instance("pairs", parsed(form), list)
        return [(arguments.text("a locator", text), part) for text, part in pairs]
    except REASONS as error:
        raise bad(error) from None


def read(data: Any) -> Any:
    form, numbers = parted(data)
    try:
        value, end = reader_of(form)(numbers, 0)
    except REASONS as error:
        raise bad(error) from None
    if end != len(numbers):
        raise bad("more follows it")
    return value


def parted(data: Any) -> tuple[bytes, memoryview]:
    """The form, and the numbers, which are not copied."""
    view = memoryview(data).cast("B")
    if len(view) < SIZE.size:
        raise bad("it ends too early")
    (size,) = SIZE.unpack_from(view)
    if size > LONGEST_FORM:
        raise bad(f"its form has {size} bytes, and {LONGEST_FORM} at most")
    form = bytes(view[SIZE.size : SIZE.size + size])
    if len(form) < size:
        raise bad("it ends too early")
    return form, view[SIZE.size + size :]


def bad(why: object) -> MessageError:
    # It is a ValueError as well, and says already what is wrong.
    return why if isinstance(why, MessageError) else MessageError("bad-tree", f"this is no value: {why!s:.80}")


def form_of(value: Any, parts: list[Any]) -> Any:
    """The form, while the numbers are added to `parts`."""
    match value:
        case None:
            return "null"
        case bool():
            parts.append(b"\1" if value else b"\0")
            return "bool"
        case str():
            parts.append(sized(value.encode()))
            return "text"
        case bytes() | bytearray():
            parts.append(sized(value))
            return "bytes"
        case int():
            if not -(2**63) <= value < 2**63:
                raise MessageError("bad-value", f"{value!s:.20} is too large for an int64")
            parts.append(INT64.pack(value))
            return "int64"
        case float():
            if not math.isfinite(value):
                raise MessageError("bad-value", f"{value} is not finite")
            parts.append(FLOAT64.pack(value))
            return "float64"
        case np.generic():
            return form_of(value.item(), parts)
        case np.ndarray():
            name, dtype = sent_as(value.dtype)
            parts.append(np.asarray(value, dtype).tobytes())
            return f"{name}[{','.join(map(str, value.shape))}]"
        # Before the tuple, which it is as well.
        case GraphInstance():
            return {"graph": [form_of(part, parts) for part in value]}
        case dict():
            others = [key for key in value if not isinstance(key, str)]
            if others:
                raise MessageError("bad-tree", f"the keys of a dict are texts, not {others[0]!a:.40}")
            # Half a character, such as \ud800 alone, is none that could be printed: encode refuses it.
            for key in value:
                key.encode()
            return {"dict": {key: form_of(part, parts) for key, part in value.items()}}
        case list() | tuple():
            return [form_of(part, parts) for part in value]
    raise MessageError("bad-tree", f"{type(value).__name__} has no place in a message")


@functools.lru_cache(100)
def sent_as(dtype: Any) -> tuple[str, Any]:
    """The dtype as which an array travels; numpy makes its name anew each time."""
    name = WIDER.get(dtype.name, dtype.name)
    if name not in ARRAYS:
        raise MessageError("bad-dtype", f"dtype {name!a:.40} is none of {', '.join(ARRAYS)}")
    return name, np.dtype(name).newbyteorder("<")


def sized(data: bytes | bytearray) -> bytes:
    return SIZE.pack(len(data)) + data


def kept(make: Callable[[bytes], T]) -> Callable[[bytes], T]:
    """Called once for each form."""
    cached = functools.lru_cache(MOST_KEPT)(make)

    def found(form: bytes) -> T:
        return (cached if len(form) <= LONGEST_KEPT else make)(form)

    found.cache_info = cached.cache_info  # type: ignore[attr-defined]
    return found


@kept
def reader_of(form: bytes) -> Reader:
    try:
        return reader(parsed(form))
    except REASONS as error:
        raise bad(error) from None


def reader(form: Any) -> Reader:
    match form:
        case "null":
            return lambda _, at: (None, at)
        case "bool":
            return lambda numbers, at: (bool(numbers[at]), at + 1)
        case "int64":
            return lambda numbers, at: (INT64.unpack_from(numbers, at)[0], at + 8)
        case "float64":
            return read_float
        case "text":
            return read_text
        case "bytes":
            return read_bytes
        case str():
            return array_reader(form)
        case list():
            return made_of([reader(part) for part in form], list)
        case {"dict": dict(parts)} if len(form) == 1:
            each = [reader(part) for part in parts.values()]
            return made_of(each, lambda values: dict(zip(parts, values, strict=True)))
        case {"graph": [_, _, _] as three} if len(form) == 1:
            return made_of([reader(part) for part in three], GraphInstance._make)
        case {"image": "bytes"} if len(form) == 1:
            return read_image
    raise ValueError(f"{form!a:.40} is no form")


def in_turn(readers: list[Reader], numbers: Any, at: int) -> tuple[list[Any], int]:
    values = []
    for read_next in readers:
        value, at = read_next(numbers, at)
        values.append(value)
    return values, at


def made_of(readers: list[Reader], make: Callable[[list[Any]], Any]) -> Reader:
    def read_parts(numbers: Any, at: int) -> tuple[Any, int]:
        values, at = in_turn(readers, numbers, at)
        return make(values), at

    return read_parts


def read_float(numbers: Any, at: int) -> tuple[float, int]:
    (number,) = FLOAT64.unpack_from(numbers, at)
    if not math.isfinite(number):
        raise MessageError("bad-value", f"{number} is not finite")
    return number, at + 8


def read_text(numbers: Any, at: int) -> tuple[str, int]:
    data, at = read_bytes(numbers, at)
    return data.decode(), at


def read_bytes(numbers: Any, at: int) -> tuple[bytes, int]:
    (size,) = SIZE.unpack_from(numbers, at)
    begin = at + SIZE.size
    if begin + size > len(numbers):
        raise ValueError("a text is longer than what is there")
    return bytes(numbers[begin : begin + size]), begin + size


def read_image(numbers: Any, at: int) -> tuple[Any, int]:
    # By name: only whoever gets a picture needs Pillow.
    pictures = importlib.import_module("netmq_example.camera.pictures")
    data, at = read_bytes(numbers, at)
    return pictures.decode_any(data), at


def array_form(form: str) -> tuple[str, tuple[int, ...], int]:
    """Dtype, shape, and how many numbers an array has."""
    parts = re.fullmatch(r"(\w+)\[((?:\d{1,9}(?:,\d{1,9}){0,7})?)\]", form, re.ASCII)
    if not parts or parts[1] not in ARRAYS:
        raise ValueError(f"{form!a:.40} is no array of {', '.join(ARRAYS)}")
    shape = tuple(map(int, parts[2].split(","))) if parts[2] else ()
    # Also where a 0 makes nothing of them: numpy takes no larger shape.
    if math.prod(filter(None, shape)) > LIMIT:
        raise ValueError(f"an array has at most {LIMIT} items")
    return parts[1], shape, math.prod(shape)


def array_reader(form: str) -> Reader:
    name, shape, count = array_form(form)
    dtype = np.dtype(name).newbyteorder("<")

    def read_array(numbers: Any, at: int) -> tuple[Any, int]:
        # Of nothing numpy reads nothing: it takes a count of 0 for a mistake.
        items = np.frombuffer(numbers, dtype, count, at) if count else np.empty(0, dtype)
        return items.reshape(shape).copy(), at + count * dtype.itemsize

    return read_array
