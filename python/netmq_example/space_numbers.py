"""Numbers of a space as bytes: those of a box, a discrete space and the like, one array of them or many at once.

Codec is what each space has, and the others are in space_bytes.py. It needs gymnasium and numpy.
"""

import math
from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.spaces import Space

from netmq_example.messages import LIMIT, MessageError


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
        self.count = math.prod(self.shape)
        self.size = self.count * self.dtype.itemsize
        if self.size > LIMIT:
            raise MessageError("bad-space", f"{self.size} bytes of {shown(space)} are more than a message has, {LIMIT}")
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


def misfit(items: Any, space: Space[Any]) -> MessageError:
    numbers = " ".join(f"{items.tolist() if isinstance(items, np.ndarray) else items!r:.200}".split())[:200]
    form = f"{items.dtype} {items.shape} " if isinstance(items, np.ndarray) else ""
    return MessageError("not-in-space", f"{form}{numbers} is not in {shown(space)}")


def shown(items: Any) -> str:
    """In one line, with the dtype of an array, which numpy's own text often leaves out."""
    dtype = f"{items.dtype} " if isinstance(items, np.ndarray) else ""
    return dtype + " ".join(f"{items!r:.200}".split())
