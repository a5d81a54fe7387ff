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

    def write(self, value: Any, parts: list[bytes]) -> None:
        parts.append(self.exact(value).reshape(self.shape).tobytes())

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
        # NaN is not between any two numbers. Of a few numbers, as most have, all() would take twice as long.
        if self.checked and b"\0" in ((items >= self.low) & (items <= self.high)).tobytes():
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
