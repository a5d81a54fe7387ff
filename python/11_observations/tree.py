"""Lesson 11, trees: a value of any space as a message has it, one JSON text and the message's arrays.

    5   0.5   true   null   "a text"   [1, 2]       as JSON has them; tuples are lists
    {"array": 0}                                    the first array of the message
    {"dict": {"speed": 5, "picture": {"array": 0}}}            a dict
    {"graph": {"nodes": …, "edges": …, "edge_links": …}}       Gymnasium's GraphInstance; without edges both are null

An array whose dtype no message has travels as the next larger one, and loses nothing. The C# side is MessageTree.cs.
"""

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import GraphInstance

# In their own lessons' folders; at home they lie beside this file.
sys.path += [str(Path(__file__).resolve().parents[1] / folder) for folder in ("05_messages", "09_environment")]
from messages import DECODER, ENCODER, EXACT, Array, Message, MessageError
from messages import read as read_message
from spaces import to_array

WIDER = {"bool": "uint8", "int8": "int32", "int16": "int32", "uint32": "int64", "float16": "float32"}


def write(value: Any, arrays: list[Array]) -> str:
    """The text of a value, whose arrays are added to those of its message; MessageError says what has no text."""
    try:
        return ENCODER.encode(whole(node_of(value, arrays)))
    except (ValueError, RecursionError) as error:
        raise MessageError("bad-tree", f"it is no text, or has no end: {error!s:.80}") from None


def read(text: str, arrays: list[Array]) -> Any:
    """The value that a text means; MessageError says why it means none. Its arrays are those of the message."""
    try:
        return value_of(whole(DECODER.decode(text)), arrays)
    except (ValueError, RecursionError) as error:
        raise MessageError("bad-tree", f"it is not JSON: {error!s:.80}") from None


def request(kind: str, said: Any, values: dict[str, Any]) -> tuple[dict[str, Any], list[Array]]:
    """Values and arrays of a request; ValueError says what no simulator could read, before anything is sent."""
    arrays = list[Array]()
    try:
        values = {**values, "state": write(said, arrays)}
        read_message(Message(kind, EXACT - 1, values, arrays).frames())
    except MessageError as error:
        raise ValueError(f"{kind} cannot be sent: {error}") from None
    return values, arrays


def node_of(value: Any, arrays: list[Array]) -> Any:
    match value:
        case None | bool() | str():
            return value
        case int() | float():
            return exact(value)
        case np.generic():
            return node_of(value.item(), arrays)
        case np.ndarray():
            arrays.append(to_array(value, WIDER.get(value.dtype.name, value.dtype.newbyteorder("="))))
            return {"array": len(arrays) - 1}
        # Before the tuple, which it is as well.
        case GraphInstance():
            return {"graph": {name: node_of(part, arrays) for name, part in value._asdict().items()}}
        case dict():
            if others := [key for key in value if not isinstance(key, str)]:
                raise MessageError("bad-tree", f"the keys of a dict are texts, not {others[0]!a:.40}")
            return {"dict": {key: node_of(part, arrays) for key, part in value.items()}}
        case list() | tuple():
            return [node_of(part, arrays) for part in value]
    raise MessageError("bad-tree", f"{type(value).__name__} has no place in a message")


def value_of(node: Any, arrays: list[Array]) -> Any:
    match node:
        case None | bool() | str():
            return node
        case int() | float():
            return exact(node)
        case list():
            return [value_of(part, arrays) for part in node]
        case {"array": at, **others} if not others and type(at) is int and 0 <= at < len(arrays):
            return arrays[at].numpy()
        case {"dict": dict(parts), **others} if not others:
            return {key: value_of(part, arrays) for key, part in parts.items()}
        case {"graph": dict(parts), **others} if not others and set(parts) == set(GraphInstance._fields):
            return GraphInstance(**{key: value_of(part, arrays) for key, part in parts.items()})
    raise MessageError("bad-tree", f"{node!a:.60} is no array of {len(arrays)}, no dict and no graph")


def whole(node: Any) -> Any:
    """ValueError: half a character, such as \\ud800 alone, is none that could be printed."""
    json.dumps(node, ensure_ascii=False).encode()
    return node


def exact(number: float) -> float:
    """As in a header: whole numbers nearer to zero than 2**53, and none that is not finite."""
    if abs(number) < (math.inf if isinstance(number, float) else EXACT):
        return number
    raise MessageError("bad-value", f"{number!s:.20} is not finite, or too large to be exact")
