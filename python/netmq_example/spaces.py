"""Gymnasium's spaces: how a simulator describes them in its hello, and what is in them as bytes.

    description = described(Discrete(2))            ["discrete", 2, 0, "int64"]; space_of(description) is the way back
    bytes_of = Bytes(Discrete(2))
    row = bytes_of.write(1)                         8 bytes
    action = bytes_of.read(row)                     np.int64(1), or MessageError: not-in-space

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

import struct
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Sequence as Items
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.spaces import GraphInstance, Space
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate

from netmq_example import trees
from netmq_example.messages import MessageError

SIZE = trees.SIZE
NO_EDGES = 2**32 - 1
# Items of a sequence, nodes or edges: more would take a step minutes.
MOST_ITEMS = 1_000_000
# What Gymnasium's constructors and numpy raise, and reading past the end.
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
            return ["text", space.min_length, space.max_length, "".join(space.character_list)]
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
    raise ValueError(f"{space} has no place in a message; Gymnasium's own spaces have")


def sendable(limits: Any) -> Any:
    """No message has uint64: the same bits as int64, of which `made` makes them again."""
    return limits.view(np.int64) if limits.dtype == np.uint64 else limits


def space_of(description: Any) -> Space[Any]:
    """MessageError says why a description is of none."""
    try:
        return made(description)
    except MessageError:
        raise
    except REASONS as error:
        raise MessageError("bad-space", f"{description!s:.60} makes no space: {error!s:.80}") from None


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


class Bytes:
    """What is in a space, as bytes and back. `size` is how many bytes it always has, or None."""

    def __init__(self, space: Space[Any]) -> None:
        self.space = space
        self.codec = codec_of(space)
        self.size = self.codec.size

    def write(self, value: Any) -> bytes:
        """ValueError, TypeError or LookupError if it cannot be in the space; whether it is, is not looked at."""
        parts: list[bytes] = []
        self.codec.write(value, parts)
        return b"".join(parts)

    def read(self, row: Any) -> Any:
        """Fresh and writable. MessageError says what is not in the space."""
        view = memoryview(row)
        try:
            value, end = self.codec.read(view, 0)
        except REASONS as error:
            raise MessageError("not-in-space", f"{len(view)} bytes are not in {self.space}: {error!s:.80}") from None
        if end != len(view):
            raise MessageError("not-in-space", f"{len(view)} bytes are not in {self.space}, which has {end}")
        return value

    def write_all(self, count: int, values: Any) -> list[bytes]:
        """Rows of so many, which are together as Gymnasium batches them."""
        if self.size is None:
            return [self.write(value) for value in iterate(batch_space(self.space, count), values)]
        blocks: list[Any] = []
        self.codec.write_block(count, values, blocks)
        data = np.concatenate(blocks, axis=1).tobytes()
        return [data[at : at + self.size] for at in range(0, len(data), self.size)] or [b""] * count

    def read_all(self, rows: Items[Any]) -> Any:
        """Together, as Gymnasium batches them."""
        if self.size is None or any(len(row) != self.size for row in rows):
            return together(self.space, [self.read(row) for row in rows])
        block = np.frombuffer(b"".join(rows), np.uint8).reshape(len(rows), self.size)
        return self.codec.read_block(block, 0)


def together(space: Space[Any], values: list[Any]) -> Any:
    """A batch, as Gymnasium makes it of single ones."""
    room: Any = create_empty_array(space, len(values))
    return concatenate(space, values, room)


def unstacked(space: Any, values: Any) -> list[Any]:
    """The way back, however many they are."""
    return list(iterate(batch_space(space, 1), values))


class Codec(ABC):
    size: Any = None

    @abstractmethod
    def write(self, value: Any, parts: list[bytes]) -> None: ...

    @abstractmethod
    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        """What begins there, and where it ends."""

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
        self.count = int(np.prod(self.shape))
        self.size = self.count * self.dtype.itemsize
        self.low = low
        self.high = high
        # One number has no array around it: np.int64(1), as Discrete samples it.
        self.single = isinstance(space, spaces.Discrete)
        # Whatever the bytes of a picture are, they are in the space.
        whole = np.iinfo(self.dtype) if self.dtype.kind in "iu" else None
        self.checked = not whole or bool(np.any(low > whole.min)) or bool(np.any(high < whole.max))

    def write(self, value: Any, parts: list[bytes]) -> None:
        parts.append(np.asarray(value, self.dtype).reshape(self.shape).tobytes())

    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        if at + self.size > len(view):
            raise ValueError("it ends too early")
        items: Any = np.ndarray(self.shape, self.dtype, view, at).copy()
        self.check(items)
        return items[()] if self.single else items, at + self.size

    def write_block(self, count: int, values: Any, blocks: list[Any]) -> None:
        items = np.ascontiguousarray(values, self.dtype)
        blocks.append(items.reshape(count, self.count).view(np.uint8).reshape(count, self.size))

    def read_block(self, block: Any, at: int) -> Any:
        part = np.ascontiguousarray(block[:, at : at + self.size]).copy()
        items = part.view(self.dtype).reshape(len(block), *self.shape)
        self.check(items)
        return items

    def check(self, items: Any) -> None:
        # NaN is not between any two numbers. Of a few numbers, as most have, all() would take twice as long.
        if self.checked and b"\0" in ((items >= self.low) & (items <= self.high)).tobytes():
            raise misfit(items, self.space)


class Whole(Codec):
    """Parts one after the other: those of a Dict or a Tuple."""

    def __init__(self, keys: list[str] | None, parts: list[Codec]) -> None:
        self.keys = keys
        self.parts = parts
        sizes = [part.size for part in parts]
        self.size = None if None in sizes else sum(sizes)

    def each(self, value: Any) -> Any:
        if self.keys is None:
            if len(value) != len(self.parts):
                raise ValueError(f"{len(value)} parts are not {len(self.parts)}")
            return value
        return [value[key] for key in self.keys]

    def whole(self, values: list[Any]) -> Any:
        return tuple(values) if self.keys is None else dict(zip(self.keys, values, strict=True))

    def write(self, value: Any, parts: list[bytes]) -> None:
        for part, item in zip(self.parts, self.each(value), strict=True):
            part.write(item, parts)

    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        values = []
        for part in self.parts:
            value, at = part.read(view, at)
            values.append(value)
        return self.whole(values), at

    def write_block(self, count: int, values: Any, blocks: list[Any]) -> None:
        for part, items in zip(self.parts, self.each(values), strict=True):
            part.write_block(count, items, blocks)

    def read_block(self, block: Any, at: int) -> Any:
        values = []
        for part in self.parts:
            values.append(part.read_block(block, at))
            at += part.size
        return self.whole(values)


class Text(Codec):
    def __init__(self, space: spaces.Text) -> None:
        self.space = space

    def write(self, value: Any, parts: list[bytes]) -> None:
        parts.append(trees.text_bytes(value))

    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        text, at = trees.read_text(view, at)
        if text not in self.space:
            raise misfit(text, self.space)
        return text, at


class Sequence(Codec):
    def __init__(self, space: spaces.Sequence) -> None:
        self.space = space
        self.feature = codec_of(space.feature_space)

    def write(self, value: Any, parts: list[bytes]) -> None:
        items = unstacked(self.space.feature_space, value) if self.space.stack else list(value)
        parts.append(SIZE.pack(len(items)))
        for item in items:
            self.feature.write(item, parts)

    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        count, at = read_size(view, at)
        items, at = read_items(self.feature, count, view, at)
        return together(self.space.feature_space, items) if self.space.stack else tuple(items), at


class Graph(Codec):
    def __init__(self, space: spaces.Graph) -> None:
        self.space = space
        self.nodes = codec_of(space.node_space)
        self.edges = None if space.edge_space is None else codec_of(space.edge_space)

    def write(self, value: Any, parts: list[bytes]) -> None:
        nodes, edges, links = value
        nodes = unstacked(self.space.node_space, nodes)
        with_edges = self.edges is not None and edges is not None
        edges = unstacked(self.space.edge_space, edges) if with_edges else []
        parts += [SIZE.pack(len(nodes)), SIZE.pack(len(edges) if with_edges else NO_EDGES)]
        for node in nodes:
            self.nodes.write(node, parts)
        if self.edges and with_edges:
            for edge in edges:
                self.edges.write(edge, parts)
            parts.append(np.asarray(links, "<i4").reshape(len(edges), 2).tobytes())

    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        nodes, at = read_size(view, at)
        edges, at = read_size(view, at, NO_EDGES)
        items, at = read_items(self.nodes, nodes, view, at)
        all_nodes: Any = together(self.space.node_space, items)
        if edges == NO_EDGES:
            return self.checked(GraphInstance(all_nodes, None, None)), at
        if not self.edges or self.space.edge_space is None:
            raise ValueError("it has edges, and its space has none")
        items, at = read_items(self.edges, edges, view, at)
        end = at + 8 * edges
        links = np.array(struct.unpack_from(f"<{2 * edges}i", view, at), np.int32).reshape(edges, 2)
        all_edges: Any = together(self.space.edge_space, items)
        return self.checked(GraphInstance(all_nodes, all_edges, links)), end

    def checked(self, graph: GraphInstance) -> GraphInstance:
        if graph not in self.space:
            raise misfit(graph, self.space)
        return graph


class OneOf(Codec):
    def __init__(self, space: Any) -> None:
        self.parts = [codec_of(part) for part in space.spaces]

    def write(self, value: Any, parts: list[bytes]) -> None:
        which, item = value
        parts.append(SIZE.pack(which))
        self.parts[which].write(item, parts)

    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        (which,) = SIZE.unpack_from(view, at)
        value, at = self.parts[which].read(view, at + SIZE.size)
        # As Gymnasium samples it.
        return (np.int64(which), value), at


def codec_of(space: Space[Any]) -> Codec:
    match space:
        case spaces.Box():
            return Numbers(space, space.low, space.high)
        case spaces.Discrete():
            return Numbers(space, space.start, space.start + space.n - 1)
        case spaces.MultiBinary():
            return Numbers(space, 0, 1)
        case spaces.MultiDiscrete():
            return Numbers(space, space.start, space.start + space.nvec - 1)
        case spaces.Dict():
            return Whole(list(space), [codec_of(part) for part in space.values()])
        case spaces.Tuple():
            return Whole(None, [codec_of(part) for part in space])
        case spaces.Text():
            return Text(space)
        case spaces.Sequence():
            return Sequence(space)
        case spaces.Graph():
            return Graph(space)
        case spaces.OneOf():
            return OneOf(space)
    raise ValueError(f"{space} has no place in a message; Gymnasium's own spaces have")


def read_size(view: memoryview, at: int, none: int = -1) -> tuple[int, int]:
    (size,) = SIZE.unpack_from(view, at)
    if size > MOST_ITEMS and size != none:
        raise ValueError(f"{size} items are more than {MOST_ITEMS}")
    return size, at + SIZE.size


def read_items(codec: Codec, count: int, view: memoryview, at: int) -> tuple[list[Any], int]:
    """One after the other; of numbers all at once: one by one they would take twenty times as long."""
    if codec.size:
        end = at + count * codec.size
        if end > len(view):
            raise ValueError("it ends too early")
        block = np.frombuffer(view[at:end], np.uint8).reshape(count, codec.size) if count else None
        if isinstance(codec, Numbers) and block is not None:
            return [item[()] if codec.single else item for item in codec.read_block(block, 0)], end
    items = []
    for _ in range(count):
        item, at = codec.read(view, at)
        items.append(item)
    return items, at


def misfit(items: Any, space: Space[Any]) -> MessageError:
    numbers = " ".join(f"{items.tolist() if isinstance(items, np.ndarray) else items!r:.200}".split())[:200]
    form = f"{items.dtype} {items.shape} " if isinstance(items, np.ndarray) else ""
    return MessageError("not-in-space", f"{form}{numbers} is not in {shown(space)}")


def shown(items: Any) -> str:
    """In one line, with the dtype of an array, which numpy's own text often leaves out."""
    dtype = f"{items.dtype} " if isinstance(items, np.ndarray) else ""
    return dtype + " ".join(f"{items!r:.200}".split())
