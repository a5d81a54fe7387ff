"""Gymnasium's spaces: how a simulator describes them in its hello, and their numbers as bytes (others: space_bytes.py).

    description = described(Discrete(2))            ["discrete", 2, 0, "int64"]; space_of(description) is the way back

Once both sides know a space, what is in it travels without a word: its arrays' numbers, little-endian, in the order of
the space's parts.

    description (a value, trees.py)                             bytes
    ["box", dtype, low, high]                                   its numbers; low and high are arrays of its shape
    ["discrete", n, start, dtype]                               one number
    ["multi_binary", shape]                                     int8, 0 or 1, for each
    ["multi_discrete", counts, starts, dtype]                   its numbers; counts and starts are arrays of its shape
    ["text", shortest, longest, characters]                     uint32, how many bytes; then UTF-8
    ["dict", [[key, space], …]]   ["tuple", [space, …]]         one part after the other
    ["sequence", space, stacked]                                uint32, how many; then one after the other
    ["graph", nodes' space, edges' space or null]               uint32 nodes, uint32 edges, or 2**32 - 1 for none; the
                                                                nodes, the edges, and int32 [edges, 2]
    ["one_of", [space, …]]                                      uint32, which one; then what is in it

In C# it is GymSpace.cs. It needs gymnasium and numpy.
"""

import math
import operator
from abc import ABC, abstractmethod
from collections import OrderedDict
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.spaces import Space

from netmq_example.messages import LIMIT, MessageError
from netmq_example.wire import trees

# Numbers that are compared one by one, and the types of one whole number.
FEW = 16
WHOLE = (int, np.int64)
# Gymnasium's constructors and numpy raise these, and so does reading past the end.
REASONS = (*trees.REASONS, AssertionError, ArithmeticError, AttributeError)


def described(space: Space[Any]) -> list[Any]:
    """For a hello. ValueError names a space that none of Gymnasium's own is."""
    match space:
        case spaces.Box():
            return ["box", space.dtype.name, sendable(space.low), sendable(space.high)]
        case spaces.Discrete():
            return ["discrete", int(space.n), int(space.start), np.dtype(space.dtype).name]
        case spaces.MultiBinary():
            return ["multi_binary", list(map(int, space.shape))]
        case spaces.MultiDiscrete():
            return ["multi_discrete", sendable(space.nvec), sendable(space.start), space.dtype.name]
        case spaces.Text():
            return ["text", space.min_length, space.max_length, "".join(sorted(space.character_list))]
        case spaces.Dict():
            return ["dict", [[key, described(part)] for key, part in space.items()]]
        case spaces.Tuple():
            return ["tuple", [described(part) for part in space]]
        case spaces.Sequence():
            return ["sequence", described(space.feature_space), space.stack]
        case spaces.Graph():
            edges = None if space.edge_space is None else described(space.edge_space)
            return ["graph", described(space.node_space), edges]
        case spaces.OneOf():
            return ["one_of", [described(part) for part in space.spaces]]
    raise no_place(space)


def no_place(space: Any, where: str = "") -> ValueError:
    return ValueError(f"{where}{space} has no place in a message; Gymnasium's own spaces have")


def sendable(limits: Any) -> Any:
    """No message has uint64: the same bits as int64, of which `made` makes them again."""
    return limits.view(np.int64) if limits.dtype == np.uint64 else limits


def space_of(description: Any) -> Space[Any]:
    """MessageError says why a description is of none."""
    try:
        # Limits that do not fit their dtype would make another space.
        with np.errstate(over="raise", invalid="raise"):
            return made(description)
    except MessageError:
        raise
    except REASONS as error:
        text = " ".join(f"{description!s:.60} makes no space: {error!s:.80}".split())
        raise MessageError("bad-space", text) from None


def made(description: Any) -> Space[Any]:
    match description:
        case ["box", str(dtype), np.ndarray() as low, np.ndarray() as high]:
            kind: Any = np.dtype(dtype).type
            return spaces.Box(low.astype(kind), high.astype(kind), dtype=kind)
        case ["discrete", int(count), int(start), str(dtype)]:
            # Gymnasium before 1.2 has but one dtype.
            words: dict[str, Any] = {} if dtype == "int64" else {"dtype": np.dtype(dtype).type}
            return spaces.Discrete(count, start=start, **words)
        case ["multi_binary", list(shape)]:
            return spaces.MultiBinary(shape[0] if len(shape) == 1 else shape)
        case ["multi_discrete", np.ndarray() as counts, np.ndarray() as starts, str(dtype)]:
            return spaces.MultiDiscrete(counts, dtype=np.dtype(dtype).type, start=starts)
        case ["text", int(shortest), int(longest), str(characters)]:
            return spaces.Text(longest, min_length=shortest, charset=characters)
        case ["dict", list(parts)]:
            # Of a plain dict Gymnasium sorts the keys.
            return spaces.Dict(OrderedDict((str(key), made(part)) for key, part in parts))
        case ["tuple", list(parts)]:
            return spaces.Tuple([made(part) for part in parts])
        case ["sequence", list(part), bool(stack)]:
            return spaces.Sequence(made(part), stack=stack)
        case ["graph", list(nodes), edges]:
            node_space: Any = made(nodes)
            edge_space: Any = None if edges is None else made(edges)
            return spaces.Graph(node_space, edge_space)
        case ["one_of", list(parts)]:
            return spaces.OneOf([made(part) for part in parts])
    known = "box, discrete, multi_binary, multi_discrete, text, dict, tuple, sequence, graph, one_of"
    raise MessageError("unknown-space", f"space {description!s:.40} is none of {known}")


class Codec(ABC):
    size: Any = None

    @abstractmethod
    def write(self, value: Any, parts: list[bytes]) -> None: ...

    @abstractmethod
    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        """Return the value that begins there, and where it ends."""

    def write_block(self, count: int, values: Any, blocks: list[Any]) -> None:
        """Of a fixed size: uint8 [count, …] for each part."""
        raise NotImplementedError

    def read_block(self, block: Any, at: int) -> Any:
        """Of a fixed size: what is in uint8 [count, size], from this column on."""
        raise NotImplementedError


class Numbers(Codec):
    """An array, or one number, each of its numbers between two."""

    def __init__(self, space: Any, low: Any, high: Any) -> None:
        self.space = space
        self.dtype = np.dtype(space.dtype)
        self.shape: tuple[int, ...] = space.shape
        self.count = math.prod(self.shape)
        self.size = self.count * self.dtype.itemsize
        if self.size > LIMIT:
            raise MessageError("bad-space", f"{self.size} bytes of {shown(space)} are more than a message has, {LIMIT}")
        self.low = low
        self.high = high
        # One number has no array around it: np.int64(1), as Discrete samples it.
        self.single = isinstance(space, spaces.Discrete)
        # All bytes that a picture can have are in the space.
        whole = np.iinfo(self.dtype) if self.dtype.kind in "iu" else None
        self.checked = not whole or bool(np.any(low > whole.min)) or bool(np.any(high < whole.max))
        # Of few numbers Python's own compare faster than numpy, which is slow right after a wait.
        few = self.checked and 0 < self.count <= FEW
        self.lows = np.broadcast_to(low, self.shape).ravel().tolist() if few else []
        self.highs = np.broadcast_to(high, self.shape).ravel().tolist() if few else []

    def write(self, value: Any, parts: list[bytes]) -> None:
        if self.size == 8 and type(value) in WHOLE and self.single:
            parts.append(trees.INT64.pack(value))
        else:
            items = self.exact(value)
            if items.shape != self.shape:
                raise misfit(items, self.space)
            parts.append(items.tobytes())

    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        if at + self.size > len(view):
            raise ValueError("it ends too early")
        items: Any = np.ndarray(self.shape, self.dtype, view, at).copy()
        self.check(items)
        return items[()] if self.single else items, at + self.size

    def write_block(self, count: int, values: Any, blocks: list[Any]) -> None:
        items = np.ascontiguousarray(self.exact(values))
        blocks.append(items.reshape(count, self.count).view(np.uint8).reshape(count, self.size))

    def read_block(self, block: Any, at: int) -> Any:
        part = np.ascontiguousarray(block[:, at : at + self.size]).copy()
        items = part.view(self.dtype).reshape(len(block), *self.shape)
        self.check(items)
        return items

    def exact(self, value: Any) -> Any:
        try:
            return exactly(value, self.dtype)
        except ArithmeticError:
            raise misfit(np.asarray(value), self.space) from None

    def check(self, items: Any) -> None:
        """Of one value, or of a batch."""
        if not self.checked:
            return
        # NaN is not between any two numbers.
        if self.lows and items.size <= FEW:
            numbers = items.ravel().tolist()
            times = len(numbers) // self.count
            lows, highs = self.lows * times, self.highs * times
            fits = all(map(operator.le, lows, numbers)) and all(map(operator.ge, highs, numbers))
        else:
            # Of a few numbers, as most have, all() would take twice as long.
            fits = b"\0" not in ((items >= self.low) & (items <= self.high)).tobytes()
        if not fits:
            raise misfit(items, self.space)


def exactly(value: Any, dtype: Any) -> Any:
    """The numbers as an array of a dtype. ArithmeticError: one would become another; TypeError: there are others."""
    given = np.asarray(value)
    if given.dtype == dtype:
        return given
    if given.dtype.kind == "O":
        # Among numbers null is NaN.
        given = given.astype(np.float64)
    if given.dtype.kind not in "biuf":
        raise TypeError(f"{value!r:.40} is no number")
    with np.errstate(over="raise", invalid="raise"):
        items = given.astype(dtype)
        # Of numbers with a fraction it is only their precision that may change.
        if items.dtype.kind == "f" and given.dtype.kind == "f":
            return items
        # A whole number as one with a fraction: what is compared with it loses as much.
        back = items.astype(given.dtype) if items.dtype.kind == "f" else items
    if not (back == given).all():
        raise ArithmeticError(f"{value!r:.40} would become another number as {items.dtype}")
    return items


def misfit(items: Any, space: Space[Any]) -> MessageError:
    # Of a peer's array or text no more is made than is shown.
    few = items
    if isinstance(items, np.ndarray):
        few = items.flat[:10].tolist() if items.ndim else items.item()
    elif isinstance(items, str):
        few = items[:200]
    numbers = " ".join(f"{few!r:.200}".split())
    form = f"{items.dtype} {items.shape} " if isinstance(items, np.ndarray) else ""
    return MessageError("not-in-space", f"{form}{numbers} is not in {shown(space)}")


def shown(items: Any) -> str:
    """In one line, with the dtype of an array, which numpy's own text often leaves out."""
    dtype = f"{items.dtype} " if isinstance(items, np.ndarray) else ""
    return dtype + " ".join(f"{items!r:.200}".split())


def write_dict(values: dict[str, Any], word: str) -> bytes:
    try:
        return trees.write(values)
    except MessageError:
        for name, value in values.items():
            try:
                trees.write({name: value})
            except MessageError as error:
                raise MessageError(error.code, f"{word} {name!a:.40} cannot be sent: {error.text}") from None
        raise
