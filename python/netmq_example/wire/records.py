"""Resets and steps as bytes: what an environment asks of its simulator and what that answers, each in one frame.

    request = Record(ASKS, 7, [Section(0, seeds([3]), bytes([RESET]))])
    record = read(ASKS, request.frame())                            record.sections[0].marks[0]
    answer = Record(ANSWERS, record.id, [Section(0, rewards([0.0]), bytes([SEEN]), values=row)])

All numbers are little-endian. Every part begins at a multiple of 8, with zeros before it.

     0  uint8     3: a request, 4: an answer; a message of lesson 05 begins with {, which is 123
     1  uint8     1: there is an exchange of side channels (lesson 13), 2: who ends begins anew within this exchange,
                  4: the scene's clock, 8: real time, 16: of the scene's clock: begin all anew
     2  uint16    how many sections there are; of the scene's clock that may be none              4  uint32  0
     8  int64     the id of the request, and of its answer
    16  uint32    how many bytes of options or infos      20  uint32  how many bytes the exchange has
    24            the options of a reset, or in an answer the scene's own infos: a value (trees.py), by the scene's
                  clock {"kinds": [...]}, those that are new; the exchange; and the sections, one for each kind of
                  agent, and with ENDED one more of those that have ended

A section has n rows, and row i is agent i of its kind, unless WHO or IDS says whose it is:

     0  uint16    the kind, its place in the hello         2  uint16  columns, see below
     4  uint32    n      8  uint32  i, how many infos      12  uint32  bytes of values     16  uint32  bytes of infos
    20  uint32    0
    24            of a request n int64, the seeds; of an answer n float64, the rewards
                  n uint8, of a request 0 nothing, 1 step, 2 reset, 3 step and then your time is up; of an answer
                  1 terminated + 2 truncated + 4 not there + 8 new + 16 wants an action + 32 has a row of values
        WHO     1 n uint32
        IDS     2 n int32, the agents' ids; the scene's clock only
        GROUPS  4 n int32, groups, 0 is none, and n float32, their rewards
        MASKS   8 uint32, how many bytes a row has, and n times so many uint8: one for each choice of each branch, one
                  branch after the other, 1 is forbidden
        SIZES  16 uint32 for each row of values: its size; without it all are of one size
        FORM   32 uint32, how many bytes, and the form of all rows in ASCII: a row then has only its numbers. In any
                  row of locators its own agent is not named: 'car'@['speed'] = $ is written @['speed'] = $
        ENDED  64 these have ended in this exchange; it has WHO or IDS
                  the values: an action for each that steps, or an observation for each mark with 32
                  i pairs of uint32, row and size, and then the infos: values

In C# it is Records.cs. MessageError says what is wrong with what a peer sent. It needs only Python.
"""

import struct
from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

from netmq_example import messages
from netmq_example.messages import EXACT, LIMIT, MessageError

# The version, which a hello has, is the last.
ASKS, ANSWERS, RECORD = 3, 4, 2
EXCHANGE, AUTORESET, SCENE_CLOCK, REAL_TIME, ANEW = 1, 2, 4, 8, 16
NOTHING, STEP, RESET, LAST = 0, 1, 2, 3
TERMINATED, TRUNCATED, ABSENT, NEW, WANTS, SEEN = 1, 2, 4, 8, 16, 32
WHO, IDS, GROUPS, MASKS, SIZES, FORM, ENDED = 1, 2, 4, 8, 16, 32, 64
HEAD = struct.Struct("<BBHIqII")
SECTION = struct.Struct("<HHIIIII")
SIZE = struct.Struct("<I")
# Zeros up to a multiple of 8.
ZEROS = [bytes(-size % 8) for size in range(8)]
# The marks whose row has no values, of a request and of an answer.
WITHOUT_VALUES = {
    ASKS: bytes(mark for mark in range(256) if mark not in (STEP, LAST)),
    ANSWERS: bytes(mark for mark in range(256) if not mark & SEEN),
}
MOST_MARK = {ASKS: LAST, ANSWERS: 2 * SEEN - 1}


@dataclass(slots=True, eq=False)
class Section:
    """The rows of one kind. All parts are bytes, as they stand in a frame; `infos` are the pairs and then the infos."""

    kind: int
    numbers: Any
    marks: bytes
    _: KW_ONLY
    values: Any = b""
    columns: int = 0
    who: Any = b""
    ids: Any = b""
    groups: Any = b""
    masks: Any = b""
    sizes: Any = b""
    form: bytes = b""
    table: Any = b""
    infos: Any = b""

    def parts(self) -> list[Any]:
        count = len(self.marks)
        values = self.values
        parts = [
            SECTION.pack(self.kind, self.columns, count, len(self.table) // 8, len(values), len(self.infos), 0),
            self.numbers,
            self.marks,
            ZEROS[count % 8],
        ]
        if self.columns:
            for column in (self.who, self.ids, self.groups):
                parts += [column, ZEROS[len(column) % 8]]
            if self.columns & MASKS:
                parts += [SIZE.pack(len(self.masks) // count), self.masks, ZEROS[(SIZE.size + len(self.masks)) % 8]]
            parts += [self.sizes, ZEROS[len(self.sizes) % 8]]
            if self.columns & FORM:
                parts += [SIZE.pack(len(self.form)), self.form, ZEROS[(SIZE.size + len(self.form)) % 8]]
        parts += [values, ZEROS[len(values) % 8]]
        if self.table:
            parts += [self.table, self.infos, ZEROS[len(self.infos) % 8]]
        return parts

    def whose(self) -> Sequence[int]:
        """The agent of each row."""
        return self.who.cast("I") if self.columns & WHO else range(len(self.marks))

    def rows(self, kind: int) -> list[Any]:
        """The values of each row, or None; `kind` is that of the record."""
        without = WITHOUT_VALUES[kind]
        count = len(self.marks.translate(None, without))
        each = iter(self.parted(count))
        return [None if mark in without else next(each) for mark in self.marks]

    def parted(self, count: int) -> Iterator[Any]:
        at = 0
        if self.columns & SIZES:
            sizes = struct.unpack(f"<{count}I", self.sizes)
        else:
            sizes = (len(self.values) // count,) * count if count else ()
        for size in sizes:
            yield self.values[at : at + size]
            at += size

    def each_info(self) -> Iterator[tuple[int, Any]]:
        """Rows with what was said of them."""
        at = 0
        for row, size in struct.iter_unpack("<II", self.table):
            yield row, self.infos[at : at + size]
            at += size


@dataclass(slots=True, eq=False)
class Record:
    """`said` are the options of a request, or the scene's infos of an answer; without an exchange that is None."""

    kind: int
    id: int
    sections: list[Section]
    bits: int = 0
    said: Any = b""
    exchange: Any = None

    def frame(self) -> bytes:
        said = self.said
        exchange = b"" if self.exchange is None else self.exchange
        bits = self.bits & ~EXCHANGE if self.exchange is None else self.bits | EXCHANGE
        head = HEAD.pack(self.kind, bits, len(self.sections), 0, self.id, len(said), len(exchange))
        parts = [head, said, ZEROS[len(said) % 8], exchange, ZEROS[len(exchange) % 8]]
        for section in self.sections:
            parts += section.parts()
        whole = b"".join(parts)
        if len(whole) > LIMIT:
            raise too_big(len(whole))
        return whole

    def frames(self) -> list[bytes]:
        """As a message of lesson 05 has them."""
        return [self.frame()]

    def has(self, order: int) -> bool:
        return any(order in section.marks for section in self.sections)


def is_record(frames: list[Any]) -> bool:
    return len(frames) == 1 and bytes(memoryview(frames[0])[:1]) in (b"\1", b"\2", b"\3", b"\4")


def read_frames(kind: int, frames: list[Any]) -> Any:
    """The received Record of this kind, or Message."""
    return read(kind, frames[0]) if is_record(frames) else messages.Message.read(frames)


def read(kind: int, frame: Any) -> Record:
    """The record in a frame, which is not copied."""
    view = memoryview(frame).cast("B")
    size = len(view)
    if size > LIMIT:
        raise too_big(size)
    if size < HEAD.size:
        raise bad("it ends too early")
    found, bits, count, zero, id, said, exchange = HEAD.unpack_from(view)
    if found in (1, 2):
        raise MessageError("old-record", "the other side has the record of an older kit: update the one that is older")
    # An id beyond EXACT could not be named in an error, which is a message.
    if found != kind or bits > 31 or bits & (ANEW | SCENE_CLOCK) == ANEW or zero or not 0 <= id < EXACT:
        raise bad(f"kind {found}, bits {bits} and id {id} cannot be")
    if exchange and not bits & EXCHANGE:
        raise bad("an exchange that its bits deny")
    at = HEAD.size
    after = at + said + -said % 8
    end = after + exchange + -exchange % 8
    if end > size:
        raise bad("it ends too early")
    channels = view[after : after + exchange] if bits & EXCHANGE else None
    record = Record(kind, id, [], bits, view[at : at + said], channels)
    for _ in range(count):
        section, end = read_section(kind, view, end)
        record.sections.append(section)
    if end != size:
        raise bad(f"it has {size} bytes in place of {end}")
    return record


def read_section(kind: int, view: memoryview, at: int) -> tuple[Section, int]:
    size = len(view)
    if at + SECTION.size > size:
        raise bad("it ends too early")
    which, columns, count, infos, values, info_bytes, zero = SECTION.unpack_from(view, at)
    begin = at + SECTION.size
    at = begin + 9 * count + -count % 8
    # Looked at before anything is made of it: a frame may claim thousands of millions.
    if at + values + 8 * infos + info_bytes > size:
        raise bad("it ends too early")
    end_of_numbers = begin + 8 * count
    marks = bytes(view[end_of_numbers : end_of_numbers + count])
    if zero or not count or columns > 127 or infos > count or (marks and max(marks) > MOST_MARK[kind]):
        raise bad(f"a section of {count} rows, columns {columns} and {infos} infos cannot be")
    section = Section(which, view[begin:end_of_numbers], marks, columns=columns)
    rows = len(marks.translate(None, WITHOUT_VALUES[kind]))
    if columns:
        at = read_columns(section, view, at, rows)
    known = sum(section.sizes.cast("I")) == values if columns & SIZES else not values % rows if rows else not values
    if not known:
        raise bad(f"{values} bytes are no {rows} rows")
    section.values = view[at : at + values]
    at += values + -values % 8
    # Columns have moved it.
    end = at + 8 * infos + info_bytes + -info_bytes % 8
    if end > size:
        raise bad("it ends too early")
    if infos or info_bytes:
        section.table = view[at : at + 8 * infos]
        section.infos = view[at + 8 * infos : at + 8 * infos + info_bytes]
        if sum(size for _, size in struct.iter_unpack("<II", section.table)) != info_bytes:
            raise bad("its infos have other sizes")
        if any(row >= count for row, _ in struct.iter_unpack("<II", section.table)):
            raise bad("an info is of no row")
    return section, end


def read_columns(section: Section, view: memoryview, at: int, rows: int) -> int:
    columns = section.columns
    count = len(section.marks)
    if (columns & ENDED and not columns & (WHO | IDS)) or (columns & SIZES and columns & FORM):
        raise bad(f"columns {columns} cannot be together")

    def take(size: int) -> memoryview:
        nonlocal at
        part = view[at : at + size]
        if len(part) < size:
            raise bad("it ends too early")
        at += size + -size % 8
        return part

    def measured(count: int) -> memoryview:
        """So many pieces of a size that stands before them."""
        size = int.from_bytes(view[at : at + SIZE.size], "little")
        return take(SIZE.size + count * size)[SIZE.size :]

    if columns & WHO:
        section.who = take(4 * count)
    if columns & IDS:
        section.ids = take(4 * count)
    if columns & GROUPS:
        section.groups = take(8 * count)
    if columns & MASKS:
        section.masks = measured(count)
        if not section.masks:
            raise bad("masks of no choices")
    if columns & SIZES:
        section.sizes = take(4 * rows)
    if columns & FORM:
        section.form = bytes(measured(1))
    return at


def too_big(size: int) -> MessageError:
    return MessageError("too-big", f"a step has at most {LIMIT} bytes, not {size}")


def bad(why: str) -> MessageError:
    return MessageError("bad-record", f"this is no reset, no step and no answer to one: {why}")
