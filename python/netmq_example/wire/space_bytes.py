"""What is in Gymnasium's spaces as bytes, as spaces.py lists them.

    bytes_of = Bytes(Discrete(2))
    row = bytes_of.write(1)                         8 bytes
    action = bytes_of.read(row)                     np.int64(1), or MessageError: not-in-space

In C# they are SpaceReader.cs and SpaceWriter.cs. It needs gymnasium and numpy.
"""

import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces

from netmq_example.messages import MessageError
from netmq_example.wire import trees
from netmq_example.wire.batches import together, unstacked
from netmq_example.wire.spaces import REASONS, Codec, Numbers, exactly, misfit, no_place

SIZE = trees.SIZE
NO_EDGES = 2**32 - 1
# Items of a sequence, nodes or edges: more would take a step minutes.
MOST_ITEMS = 1_000_000
FEW_ITEMS = 1000


class Bytes:
    """What is in a space, as bytes and back. `size` is how many bytes it always has, or None."""

    def __init__(self, space: spaces.Space[Any]) -> None:
        self.space = space
        self.codec = codec_of(space)
        self.size = self.codec.size

    def write(self, value: Any) -> bytes:
        """ValueError, TypeError or LookupError if it cannot be in the space, and MessageError if a number would become
        another one; whether it is in the space, is not looked at."""
        parts: list[bytes] = []
        self.codec.write(value, parts)
        return b"".join(parts)

    def read(self, row: Any) -> Any:
        """Fresh and writable. MessageError says what is not in the space."""
        view = memoryview(row)
        try:
            value, end = self.codec.read(view, 0)
        except REASONS as error:
            why = f"{len(view)} bytes are not in {self.space}: {error!s:.80}"
            raise error if isinstance(error, MessageError) else MessageError("not-in-space", why) from None
        if end != len(view):
            raise MessageError("not-in-space", f"{len(view)} bytes are not in {self.space}, which has {end}")
        return value


class Whole(Codec):
    """Parts one after the other: those of a Dict or a Tuple."""

    def __init__(self, keys: list[str] | None, parts: list[Codec]) -> None:
        self.keys = keys
        self.known = {*(keys or ())}
        self.parts = parts
        sizes = [part.size for part in parts]
        self.size = None if None in sizes else sum(sizes)

    def each(self, value: Any) -> Any:
        if self.keys is None:
            if len(value) != len(self.parts):
                raise ValueError(f"{len(value)} parts are not {len(self.parts)}")
            return value
        if not isinstance(value, Mapping):
            raise ValueError(f"{type(value).__name__} is no dict")
        if value.keys() != self.known:
            lacks = [key for key in self.keys if key not in value]
            why = f"it lacks {lacks[0]!r}" if lacks else f"it has {next(iter(value.keys() - self.known))!r}"
            raise MessageError("not-in-space", f"{why}; the keys are {', '.join(self.keys)}")
        return [value[key] for key in self.keys]

    def whole(self, values: list[Any]) -> Any:
        return tuple(values) if self.keys is None else dict(zip(self.keys, values, strict=True))

    def write(self, value: Any, parts: list[bytes]) -> None:
        for number, (part, item) in enumerate(zip(self.parts, self.each(value), strict=True)):
            try:
                part.write(item, parts)
            except REASONS as error:
                raise self.placed(number, error) from None

    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        values = []
        for number, part in enumerate(self.parts):
            try:
                value, at = part.read(view, at)
            except MessageError as error:
                raise self.placed(number, error) from None
            values.append(value)
        return self.whole(values), at

    def placed(self, number: int, error: Exception) -> MessageError:
        """The same error, and in which part."""
        code, text = (error.code, error.text) if isinstance(error, MessageError) else ("not-in-space", f"{error!s:.80}")
        place = f"[{(self.keys[number] if self.keys else number)!r}]{'' if text[:1] == '[' else ': '}"
        return MessageError(code, place + text)

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
        parts.append(trees.sized(value.encode()))

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
            parts.append(exactly(links, np.dtype("<i4")).reshape(len(edges), 2).tobytes())

    def read(self, view: memoryview, at: int) -> tuple[Any, int]:
        nodes, at = read_size(view, at)
        edges, at = read_size(view, at, NO_EDGES)
        items, at = read_items(self.nodes, nodes, view, at)
        all_nodes: Any = together(self.space.node_space, items)
        if edges == NO_EDGES:
            return self.checked(spaces.GraphInstance(all_nodes, None, None)), at
        if not self.edges or self.space.edge_space is None:
            raise ValueError("it has edges, and its space has none")
        items, at = read_items(self.edges, edges, view, at)
        end = at + 8 * edges
        links = np.array(struct.unpack_from(f"<{2 * edges}i", view, at), np.int32).reshape(edges, 2)
        all_edges: Any = together(self.space.edge_space, items)
        return self.checked(spaces.GraphInstance(all_nodes, all_edges, links)), end

    def checked(self, graph: spaces.GraphInstance) -> spaces.GraphInstance:
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


def codec_of(space: spaces.Space[Any]) -> Codec:
    match space:
        case spaces.Box():
            return Numbers(space, space.low, space.high)
        case spaces.Discrete():
            return Numbers(space, int(space.start), int(space.start) + int(space.n) - 1)
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
    raise no_place(space)


def read_size(view: memoryview, at: int, none: int = -1) -> tuple[int, int]:
    (size,) = SIZE.unpack_from(view, at)
    if size > MOST_ITEMS and size != none:
        raise ValueError(f"{size} items are more than {MOST_ITEMS}")
    return size, at + SIZE.size


def read_items(codec: Codec, count: int, view: memoryview, at: int) -> tuple[list[Any], int]:
    """One after the other; of numbers all at once: one by one they would take twenty times as long."""
    # Each has a byte at least, or there are only few.
    if count > len(view) - at + FEW_ITEMS:
        raise ValueError(f"{count} items are not in {len(view) - at} bytes")
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
