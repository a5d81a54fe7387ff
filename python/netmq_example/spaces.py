"""What is seen and what is done, as an environment and its simulator send it: spaces, and values of any space.

**Spaces** (lesson 09). A hello names the kinds, `box` or `discrete`, as the values `observation` and `action`. Its
arrays are the rest: of a box the lowest and the highest numbers, whose dtype and shape are those of the box; of a
discrete one how many there are, an int64. An observation or an action is then one array. What is not in its space is
refused. In C# it is GymSpace.cs.

    kind, arrays = described(Discrete(2))               "discrete" and one array; space_of(kind, arrays) is the way back
    action = from_array(Discrete(2), [to_array(1, np.int64)])

**Trees** (lesson 11) are values of any space: JSON, and the message's arrays. An array whose dtype no message has
travels as the next larger one, and loses nothing. In C# it is MessageTree.cs.

    5   0.5   true   null   "a text"   [1, 2]           as JSON has them; tuples are lists
    {"array": 0}                                        the first array of the message
    {"dict": {"speed": 5, "picture": {"array": 0}}}     a dict
    {"graph": {"nodes": …, "edges": …, "edge_links": …}}        Gymnasium's GraphInstance; without edges both are null

MessageError says what is wrong with what a peer sent, ValueError what cannot be sent. It needs gymnasium.
"""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import logger
from gymnasium.spaces import Box, Discrete, GraphInstance, Space

from netmq_example.messages import DECODER, ENCODER, EXACT, Array, Message, MessageError, take
from netmq_example.messages import read as read_message

# The dtypes that a message has not, and those that they travel as.
WIDER = {"bool": "uint8", "int8": "int32", "int16": "int32", "uint32": "int64", "float16": "float32"}


# Spaces


def space_of(kind: str, arrays: list[Array]) -> Space[Any]:
    """The space of this kind; what belongs to it is taken from the beginning of `arrays`."""
    if kind not in ("box", "discrete"):
        raise MessageError("unknown-space", f"space {kind!a:.40} is none of box, discrete")
    try:
        if kind == "discrete":
            return Discrete(int(arrays.pop(0).numpy()))
        low, high = arrays.pop(0).numpy(), arrays.pop(0).numpy()
        return Box(low, high, dtype=low.dtype.type)
    except (LookupError, ValueError, TypeError, ArithmeticError, AssertionError) as error:
        raise MessageError("bad-space", f"its arrays make no {kind}: {error!s:.80}") from None


def offered(hello: Message, name: str, before: list[Space[Any]] | None) -> list[Space[Any]]:
    """What a simulator of this name sees and takes; MessageError says why its hello is refused."""
    found = take(hello.values, "name", str)
    if found != name:
        raise MessageError("wrong-name", f"this environment is {name}, the simulator's is {found!a:.40}")
    arrays = list(hello.arrays)
    spaces = [space_of(take(hello.values, which, str), arrays) for which in ("observation", "action")]
    if before and spaces != before:
        raise MessageError("other-spaces", f"the simulator before this one had {before}, not {spaces}")
    return spaces


def described(space: Space[Any]) -> tuple[str, list[Array]]:
    """The other way round: a space's kind, and its arrays."""
    if isinstance(space, Discrete) and space.start == 0:
        return "discrete", [to_array(space.n, np.int64)]
    if isinstance(space, Box):
        return "box", [to_array(space.low, space.dtype), to_array(space.high, space.dtype)]
    raise MessageError("unknown-space", f"{space!s:.40} is none of Box, Discrete from 0")


def frames_per_second(hello: Message) -> int:
    """As many steps as there are in a second of the world's own time."""
    dt: float = take(hello.values, "dt", float)
    return round(1 / max(1e-3, dt))


def to_array(items: Any, dtype: Any) -> Array:
    items = np.asarray(items, dtype)
    return Array(str(items.dtype), items.shape, items.tobytes())


def from_array(space: Space[Any], arrays: list[Array]) -> Any:
    """The one array as something of this space, fresh and writable: what was received goes with its message."""
    if len(arrays) != 1:
        raise MessageError("not-in-space", f"{len(arrays)} arrays are not one of {space}")
    # [()] makes a number of an array without dimensions, and changes no other.
    items = arrays[0].numpy().copy()[()]
    if (items.dtype, items.shape) != (space.dtype, space.shape) or items not in space:
        numbers = " ".join(f"{items.tolist()!r:.200}".split())
        raise MessageError("not-in-space", f"{items.dtype} {items.shape} {numbers} is not in {shown(space)}")
    return items


def picture(arrays: list[Array]) -> Any:
    """The one array as a picture, uint8 [height, width, 3]."""
    if [(array.dtype, array.shape[2:]) for array in arrays] != [("uint8", (3,))]:
        forms = [(array.dtype, array.shape) for array in arrays]
        raise MessageError("no-picture", f"{forms!s:.80} is not one array uint8 [height, width, 3]")
    return arrays[0].numpy().copy()


def known_render_mode(mode: Any) -> Any:
    """None, or the one that has pictures."""
    if mode not in (None, "rgb_array"):
        raise ValueError(f"render_mode takes 'rgb_array' or None, not {mode!r:.40}; lesson 12 makes films")
    return mode


def gives_pictures(mode: Any) -> bool:
    """Whether render has pictures to give; where it has none it warns, as Gymnasium's own environments do."""
    if mode is None:
        logger.warn('render gives no picture: make the environment with render_mode="rgb_array"')
    return mode is not None


def shown(items: Any) -> str:
    """In one line, with the dtype of an array, which numpy's own text often leaves out."""
    dtype = f"{items.dtype} " if isinstance(items, np.ndarray) else ""
    return dtype + " ".join(f"{items!r:.200}".split())


def copied(options: Any) -> dict[str, Any]:
    """A copy of the options of a reset."""
    options = {} if options is None else options
    if not isinstance(options, Mapping) or "seed" in options:
        raise ValueError(f"options must be a dict, without seed, which is reset's own: {options!r:.80}")
    return dict(options)


def sendable(options: Any, **others: int) -> tuple[dict[str, Any], list[Array]]:
    """What reset sends: the options, beside these others, and the option `state` as an array.

    ValueError names what no simulator could read, before anything is sent.
    """
    values = {**copied(options), **others}
    try:
        state = [to_array(values.pop("state"), np.float64)] if "state" in values else []
    except (ValueError, TypeError) as error:
        raise ValueError(f"state cannot be sent: {error!s:.80}") from None
    # One by one, and then together.
    for some in *({name: value} for name, value in values.items()), values:
        try:
            read_message(Message("reset", EXACT - 1, some).frames())
        except (ValueError, TypeError, RecursionError, MessageError) as error:
            raise ValueError(f"{', '.join(map(str, some)):.40} cannot be sent: {error!s:.200}") from None
    return values, state


# Trees


def write(value: Any, arrays: list[Array]) -> str:
    """The text of a value, whose arrays are added to those of its message; MessageError says what has no text."""
    try:
        return ENCODER.encode(whole(node_of(value, arrays)))
    except (ValueError, RecursionError) as error:
        raise MessageError("bad-tree", f"it is no text, or has no end: {error!s:.80}") from None


def read(text: str, arrays: list[Array]) -> Any:
    """The value that a text stands for; MessageError says why it is none. Its arrays are those of the message."""
    try:
        return value_of(whole(DECODER.decode(text)), arrays)
    except (ValueError, RecursionError) as error:
        raise MessageError("bad-tree", f"it is not JSON: {error!s:.80}") from None


def request(kind: str, tree: Any, values: dict[str, Any]) -> tuple[dict[str, Any], list[Array]]:
    """Values and arrays of a request; ValueError says what no simulator could read, before anything is sent."""
    arrays = list[Array]()
    try:
        values = {**values, "state": write(tree, arrays)}
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
            others = [key for key in value if not isinstance(key, str)]
            if others:
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
