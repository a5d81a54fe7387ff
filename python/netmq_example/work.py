"""A kind of work: a generator that yields a step whenever it could stop.

    def count(total: int, finished: bytes, text: str) -> Iterator[Step]:
        for unit in range(1, total + 1):
            yield Step(unit, total)

    kinds = {"count": Kind(count, most=10_000)}

It gets the goal's count, its checkpoint's bytes and the goal's text. Between two steps its worker shows how far it is,
keeps its checkpoint, and hears a cancel. A checkpoint is an array of all that is finished; work that is begun with its
bytes goes on from there.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from netmq_example import arguments, check
from netmq_example.messages import EXACT, Array


class WorkError(Exception):
    """Why it cannot be done, in words for the client. Any other exception is a mistake in the work."""


@dataclass(frozen=True)
class Step:
    done: int
    total: int
    text: str = ""
    checkpoint: Array | None = None

    def __post_init__(self) -> None:
        for name in ("done", "total"):
            check.count(name, check.instance(name, getattr(self, name), int), least=0, most=EXACT - 1)
        check.instance("text", self.text, str)
        check.instance("checkpoint", self.checkpoint, Array, type(None))


@dataclass(frozen=True)
class Kind:
    """`most` is the largest count of a goal: it keeps a goal's time, memory and messages within bounds."""

    work: Callable[[int, bytes, str], Iterator[Step]]
    most: int
    has_checkpoint: bool = False

    def __post_init__(self) -> None:
        arguments.function("work", self.work)
        check.count("most", self.most)
        check.instance("has_checkpoint", self.has_checkpoint, bool)
