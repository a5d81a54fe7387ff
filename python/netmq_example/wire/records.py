"""Resets and steps as bytes: what an environment asks of its simulator and what that answers, each in one frame.

    request = Record(ASKS, 7, seeds([0]), [STEP], [action])
    record = read(ASKS, request.frame())                                record.rows[0], record.flags[0]
    answer = Record(ANSWERS, record.id, rewards([1.0]), [TERMINATED], [seen])

All numbers are little-endian; n is how many there are, areas or agents, each of which has a row.

    0            uint8       1: a request, 2: an answer; a message of lesson 05 begins with {, which is 123
    1            uint8       1: there is an exchange of side channels (lesson 13), else 0
    2            uint16      0
    4            uint32      n
    8            int64       the id of the request, and of its answer
    16           uint32      how many bytes of options there are
    20           uint32      how many bytes the exchange has
    24           n * 8       of a request the seeds, int64; of an answer the rewards, float64
    24 + 8 n     n * 4       uint32, how many bytes each row has
    24 + 12 n    n * 4       uint32, how many bytes each info has
    24 + 16 n    n           uint8: of a request 0 nothing, 1 step, 2 reset; of an answer 1 terminated + 2 truncated,
                             or 4, this agent is not there
    24 + 17 n                the options, the exchange, the rows, the infos

A row is an action or an observation, as its space says (spaces.py). Options are those of a reset, and infos those of a
step; both are values (trees.py), or empty. A request has a row for each that steps, an answer for each that is there.
In C# it is Records.cs. MessageError says what is wrong with what a peer sent. It needs only Python.
"""

import itertools
import math
import struct
from collections.abc import Iterable, Sequence
from typing import Any

from netmq_example import messages
from netmq_example.messages import EXACT, LIMIT, MessageError

ASKS, ANSWERS = 1, 2
NOTHING, STEP, RESET = 0, 1, 2
TERMINATED, TRUNCATED, ABSENT = 1, 2, 4
HEAD = struct.Struct("<BBHIqII")
# For each row a number, two sizes and a mark.
EACH = 17


class Record:
    """`numbers` are the bytes of seeds or rewards, `flags` orders or ends; without an exchange that is None."""

    __slots__ = ("exchange", "flags", "id", "infos", "kind", "numbers", "options", "rows")

    def __init__(
        self,
        kind: int,
        id: int,
        numbers: Any,
        flags: Iterable[int],
        rows: Sequence[Any],
        infos: Sequence[Any] = (),
        options: Any = b"",
        exchange: Any = None,
    ) -> None:
        self.kind = kind
        self.id = id
        self.numbers = numbers
        self.flags = bytes(flags)
        self.rows = rows
        self.infos = infos or [b""] * len(rows)
        self.options = options
        self.exchange = exchange

    def frame(self) -> bytes:
        count = len(self.flags)
        exchange = b"" if self.exchange is None else self.exchange
        head = HEAD.pack(self.kind, self.exchange is not None, 0, count, self.id, len(self.options), len(exchange))
        sizes = struct.pack(f"<{2 * count}I", *map(len, self.rows), *map(len, self.infos))
        whole = b"".join((head, self.numbers, sizes, self.flags, self.options, exchange, *self.rows, *self.infos))
        if len(whole) > LIMIT:
            raise too_big(len(whole))
        return whole

    def frames(self) -> list[bytes]:
        """As a message of lesson 05 has them."""
        return [self.frame()]


def is_record(frames: list[Any]) -> bool:
    return len(frames) == 1 and bytes(memoryview(frames[0])[:1]) in (b"\1", b"\2")


def read_frames(kind: int, frames: list[Any]) -> Any:
    """The received Record of this kind, or Message."""
    return read(kind, frames[0]) if is_record(frames) else messages.Message.read(frames)


def read(kind: int, frame: Any) -> Record:
    """The record in a frame, which is not copied."""
    view = memoryview(frame).cast("B")
    if len(view) > LIMIT:
        raise too_big(len(view))
    if len(view) < HEAD.size:
        raise bad("it ends too early")
    found, has_exchange, _, count, id, options, exchange = HEAD.unpack_from(view)
    # An id beyond EXACT could not be named in an error, which is a message.
    if found != kind or not 0 < count <= len(view) // EACH or not 0 <= id < EXACT:
        raise bad(f"kind {found}, id {id} and {count} rows cannot be")
    at = HEAD.size + 8 * count
    begin = HEAD.size + EACH * count
    if len(view) < begin:
        raise bad("it ends too early")
    sizes = struct.unpack_from(f"<{2 * count}I", view, at)
    flags = bytes(view[begin - count : begin])
    if max(flags) > (RESET if kind == ASKS else TERMINATED | TRUNCATED | ABSENT):
        raise bad(f"mark {max(flags)} is none")
    ends = list(itertools.accumulate((options, exchange, *sizes), initial=begin))
    if ends[-1] != len(view):
        raise bad(f"it has {len(view)} bytes in place of {ends[-1]}")
    parts = [view[one:other] for one, other in itertools.pairwise(ends)]
    rows, infos = parts[2 : 2 + count], parts[2 + count :]
    return Record(kind, id, view[HEAD.size : at], flags, rows, infos, parts[0], parts[1] if has_exchange & 1 else None)


def too_big(size: int) -> MessageError:
    return MessageError("too-big", f"a step has at most {LIMIT} bytes, not {size}")


def bad(why: str) -> MessageError:
    return MessageError("bad-record", f"this is no reset, no step and no answer to one: {why}")


def seeds(numbers: Sequence[int]) -> bytes:
    try:
        return struct.pack(f"<{len(numbers)}q", *numbers)
    except struct.error:
        wrong = ", ".join(map(str, numbers))
        raise ValueError(f"seed {wrong:.40} cannot be sent: it is a whole number below 2**63") from None


def rewards(numbers: Sequence[float]) -> bytes:
    return struct.pack(f"<{len(numbers)}d", *numbers)


def rewards_in(answer: Record) -> tuple[float, ...]:
    """One for each row. MessageError if one is not finite: whoever learned from it would know nothing any more."""
    numbers: tuple[float, ...] = struct.unpack(f"<{len(answer.flags)}d", answer.numbers)
    for number in numbers:
        if not math.isfinite(number):
            raise MessageError("bad-reward", f"the reward is {number}")
    return numbers
