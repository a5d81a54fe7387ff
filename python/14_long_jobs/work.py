"""Lesson 14, the kinds of work: each is a generator that yields a step whenever it could stop.

    for step in picture(100, b"", ""): ...

netmq_example/work.py says what a step is. Put your own kinds into KINDS.
"""

import time
from array import array
from collections import deque
from collections.abc import Iterator

from netmq_example.messages import Array

# A kind of your own raises WorkError when it cannot be done.
from netmq_example.work import Kind, Step, WorkError  # noqa: F401

UNIT_SECONDS = 0.02
# After so many turns a point counts as inside the Mandelbrot set.
MOST_TURNS = 2000


def count(total: int, finished: bytes, text: str) -> Iterator[Step]:
    """Waits a little for each unit. Its checkpoint has a byte for each, so that one sees that none is done twice."""
    for unit in range(len(finished) + 1, total + 1):
        time.sleep(UNIT_SECONDS)
        finished += bytes([unit % 256])
        yield Step(unit, total, checkpoint=Array("uint8", (unit,), finished))


def picture(side: int, finished: bytes, text: str) -> Iterator[Step]:
    """The Mandelbrot set in stripes, from the top; RGB. The picture so far is the checkpoint."""
    for y in range(len(finished) // (3 * side), side):
        stripe = bytearray()
        for x in range(side):
            turns = turns_at(complex(3 * x / side - 2.25, 3 * y / side - 1.5))
            inside = turns == MOST_TURNS
            stripe += bytes(3) if inside else bytes((turns * 9 % 256, turns * 5 % 256, turns * 13 % 256))
        finished += stripe
        yield Step(y + 1, side, checkpoint=Array("uint8", (y + 1, side, 3), finished))


def turns_at(point: complex) -> int:
    """How long the point takes to leave."""
    z = 0j
    turns = 0
    while turns < MOST_TURNS and abs(z) <= 2:
        z = z * z + point
        turns += 1
    return turns


def path(size: int, finished: bytes, text: str) -> Iterator[Step]:
    """The shortest way from corner to corner, through walls with one gap each. To keep a search costs more than to
    search again: it has no checkpoint."""
    side = 10 * size
    gaps = {y: y * y * 7919 % side for y in range(2, side - 1, 4)}
    steps = array("i", [-1]) * (side * side)
    steps[0] = 0
    edge = deque([0])
    visited = 0
    while edge:
        cell = edge.popleft()
        x, y = cell % side, cell // side
        visited += 1
        if visited % 1000 == 0:
            yield Step(visited, side * side, f"{len(edge)} cells at the edge")
        for near_x, near_y in ((x + 1, y), (x, y + 1), (x - 1, y), (x, y - 1)):
            near = near_y * side + near_x
            if 0 <= near_x < side and 0 <= near_y < side and steps[near] < 0 and gaps.get(near_y, near_x) == near_x:
                steps[near] = steps[cell] + 1
                edge.append(near)
    yield Step(side * side, side * side, f"a path of {steps[-1]} steps")


def ignores_cancel(total: int, finished: bytes, text: str) -> Iterator[Step]:
    """Trouble on command: it does not stop in between, and so hears no cancel."""
    yield Step(1, total, "deaf from here on")
    time.sleep(total * UNIT_SECONDS)
    yield Step(total, total)


# By the name in the goal.
KINDS = {
    "count": Kind(count, 10_000, has_checkpoint=True),
    "picture": Kind(picture, 200, has_checkpoint=True),
    "path": Kind(path, 300),
    "deaf": Kind(ignores_cancel, 10_000),
}
