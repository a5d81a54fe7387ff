"""Lesson 14, the kinds of work: each is a generator that yields a step whenever it could stop.

    for step in picture(100, b"", ""): ...

It gets the goal's count, its checkpoint's bytes and the goal's text. Between two steps its worker shows how far it is,
keeps its checkpoint, and hears a cancel. A checkpoint is an array of all that is finished; work that is begun with its
bytes goes on from there. Put your own kinds into KINDS.
"""

import time
from array import array
from collections import deque
from collections.abc import Callable, Iterator
from typing import NamedTuple

from netmq_example.messages import Array

# Seconds that a unit of `count` takes, and iterations after which a point counts as inside the Mandelbrot set.
UNIT, INSIDE = 0.02, 2000


class WorkError(Exception):
    """Why it cannot be done, in words for whoever wants it done. Any other exception is a mistake in the work."""


class Step(NamedTuple):
    done: int
    total: int
    text: str = ""
    checkpoint: Array | None = None


def count(total: int, finished: bytes, text: str) -> Iterator[Step]:
    """Waits a little for each unit. Its checkpoint has a byte for each, so that one sees that none is done twice."""
    for unit in range(len(finished) + 1, total + 1):
        time.sleep(UNIT)
        finished += bytes([unit % 256])
        yield Step(unit, total, checkpoint=Array("uint8", (unit,), finished))


def picture(side: int, finished: bytes, text: str) -> Iterator[Step]:
    """The Mandelbrot set in stripes, from the top; RGB. What is drawn so far is the checkpoint."""
    for y in range(len(finished) // (3 * side), side):
        stripe = bytearray()
        for x in range(side):
            point, z, turns = complex(3 * x / side - 2.25, 3 * y / side - 1.5), 0j, 0
            while turns < INSIDE and abs(z) <= 2:
                z, turns = z * z + point, turns + 1
            stripe += bytes(3) if turns == INSIDE else bytes((turns * 9 % 256, turns * 5 % 256, turns * 13 % 256))
        finished += stripe
        yield Step(y + 1, side, checkpoint=Array("uint8", (y + 1, side, 3), finished))


def path(size: int, finished: bytes, text: str) -> Iterator[Step]:
    """The shortest way from corner to corner, through walls with one gap each. To keep a search costs more than to
    search again: it has no checkpoint."""
    side = 10 * size
    gaps = {y: y * y * 7919 % side for y in range(2, side - 1, 4)}
    steps, edge, visited = array("i", [-1]) * (side * side), deque([0]), 0
    steps[0] = 0
    while edge:
        x, y = (cell := edge.popleft()) % side, cell // side
        visited += 1
        if visited % 1000 == 0:
            yield Step(visited, side * side, f"{len(edge)} cells at the edge")
        for near_x, near_y in ((x + 1, y), (x, y + 1), (x - 1, y), (x, y - 1)):
            near = near_y * side + near_x
            if 0 <= near_x < side and 0 <= near_y < side and steps[near] < 0 and gaps.get(near_y, near_x) == near_x:
                steps[near] = steps[cell] + 1
                edge.append(near)
    yield Step(side * side, side * side, f"a path of {steps[-1]} steps")


def deaf(total: int, finished: bytes, text: str) -> Iterator[Step]:
    """Trouble on command: it never stops in between, and so hears no cancel."""
    yield Step(1, total, "deaf from here on")
    time.sleep(total * UNIT)
    yield Step(total, total)


class Kind(NamedTuple):
    work: Callable[[int, bytes, str], Iterator[Step]]
    most: int
    has_checkpoint: bool = False


# By the name in the goal. The limits keep a goal's time, memory and messages within bounds.
KINDS = {
    "count": Kind(count, 10_000, True),
    "picture": Kind(picture, 200, True),
    "path": Kind(path, 300),
    "deaf": Kind(deaf, 10_000),
}
