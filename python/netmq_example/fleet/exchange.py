"""One step or reset of a trainer, split among its areas and joined again.

    exchange = Exchange(request, 2, parameters, playing)           exchange.parts: what each area is asked
    part = exchange.again(0, answer)                               where somebody is over: how he begins anew, or None
    answer = exchange.joined({0: answer, 1: other})                one answer, for all

A simulator gets steps and resets: no `last`, and no order to begin anew by itself. So an episode stays a seed and the
actions after it. Here they are made of its answers: whose time is up is truncated, and who begins anew has two rows.
"""

import copy
import functools
import struct
import uuid
from typing import Any

from netmq_example.fleet import pieces
from netmq_example.fleet.members import Part
from netmq_example.messages import MessageError
from netmq_example.wire.records import (
    ABSENT,
    ANSWERS,
    ASKS,
    AUTORESET,
    FORM,
    HEAD,
    LAST,
    NEW,
    NOTHING,
    REAL_TIME,
    RESET,
    SCENE_CLOCK,
    SECTION,
    SIZES,
    STEP,
    TERMINATED,
    TRUNCATED,
    ZEROS,
    Record,
    Section,
    with_infos,
)

OVER = TERMINATED | TRUNCATED
# Every mark, and those that a simulator gets in place of them.
TOLD = bytes(STEP if mark == LAST else mark for mark in range(256))
HERE = "a hub steps simulators as often as it must, and so "
# Channels whose messages set something that stays set, and how their keys begin: with a text, or with a number.
PARAMETERS = {
    uuid.UUID("534c891e-810f-11ea-a9d0-822485860400").bytes_le: True,
    uuid.UUID("60ccf7d0-4f7e-11ea-b238-784f4387d1f7").bytes_le: True,
    uuid.UUID("e951342c-4f7e-11ea-b238-784f4387d1f7").bytes_le: False,
}


class Playing:
    """Who plays in a scene: when all of them reset at once, an episode begins, and what was before is over."""

    def __init__(self) -> None:
        self.rows: set[tuple[int, int]] = set()
        # The last ones of each kind.
        self.marks: dict[int, bytes] = {}

    def begins(self, sections: list[Section]) -> bool:
        orders = [(one.kind, row, order) for one in sections for row, order in enumerate(one.marks) if order]
        reset = {(kind, row) for kind, row, order in orders if order == RESET}
        if not reset:
            return False
        here = {(kind, row) for kind, row in self.rows if not self.marks.get(kind, bytes(row + 1))[row] & ABSENT}
        begins = len(reset) == len(orders) and reset >= here
        self.rows = reset if begins else self.rows | reset
        return begins


class Exchange:
    """Until all areas have answered."""

    def __init__(self, request: Record, areas: int, parameters: dict[bytes, bytes], playing: Playing) -> None:
        """`parameters` are those that the trainer has set: each simulator of a new episode gets them first."""
        if request.bits & REAL_TIME:
            raise MessageError("real-time", f"{HERE}has no real time: leave out real_time, or connect the scene itself")
        if request.bits & SCENE_CLOCK:
            raise MessageError("scenes-clock", f"{HERE}has no clock of a scene's: connect the scene itself")
        if any(section.columns & ~(FORM | SIZES) for section in request.sections):
            raise MessageError("bad-record", "a request has no such columns by Python's clock")
        self.request = request
        self.areas = areas
        self.playing = playing
        self.autoreset = bool(request.bits & AUTORESET)
        self.last = request.has(LAST)
        self.before = b"".join(parameters.values())
        if request.exchange:
            parameters |= parameters_in(bytes(request.exchange))
        self.after = b"".join(parameters.values())
        # Answers after which somebody begins anew, and the orders by which he does.
        self.ended: dict[int, tuple[Record, list[bytes]]] = {}
        self.parts = self.whole() if areas == 1 else self.split()

    def whole(self) -> dict[int, Part]:
        sections = [copy.copy(section) for section in self.request.sections]
        if not sections:
            raise MessageError("bad-record", "a request asks for one kind at least")
        for section in sections:
            section.marks = section.marks.translate(TOLD)
        said = self.request.said if self.request.has(RESET) else b""
        return {0: self.part(sections, self.playing.begins(sections), said, self.request.exchange, self.before)}

    def split(self) -> dict[int, Part]:
        areas, request = self.areas, self.request
        if len(request.sections) != 1 or len(request.sections[0].marks) != areas:
            rows = sum(len(section.marks) for section in request.sections)
            cure = f"make_vec(…, num_envs={areas}), or FleetSocket(…, 1) for a scene of several agents"
            raise MessageError("wrong-areas", f"{areas} scenes of an agent were asked for, not {rows} rows: {cure}")
        (section,) = request.sections
        if not (section.columns or section.table or request.exchange is not None or request.said):
            return plain_parts(section)
        parts = {}
        for area, piece in enumerate(pieces.cut(section, ASKS)):
            order = piece.marks[0]
            if order or request.exchange:
                piece.marks = piece.marks.translate(TOLD)
                said = request.said if order == RESET else b""
                parts[area] = self.part([piece], order == RESET, said, request.exchange, self.before)
        return parts

    def part(self, sections: list[Section], begins: bool, said: Any, exchange: Any, parameters: bytes) -> Part:
        if begins and exchange is not None:
            exchange = parameters + bytes(exchange)
        frame = Record(ASKS, 0, sections, 0, said, exchange).frame()
        return Part(frame, [(section.kind, len(section.marks)) for section in sections], begins)

    def again(self, area: int, answer: Record) -> Part | None:
        """What this area is asked once more: its own resets, where the trainer has left them to the simulator."""
        if area in self.ended or not (self.last or self.autoreset):
            return None
        asked = self.request.sections
        if self.areas > 1:
            (section,) = asked
            seed = section.numbers[8 * area : 8 * area + 8]
            asked = [Section(section.kind, seed, section.marks[area : area + 1])]
        both = list(zip(answer.sections, asked, strict=True))
        if self.last:
            for section, theirs in both:
                section.marks = bytes(map(at_its_end, section.marks, theirs.marks))
        if not self.autoreset or not any(mark & OVER for section, _ in both for mark in section.marks):
            return None
        orders = [bytes(map(reset_of, section.marks, theirs.marks)) for section, theirs in both]
        if not b"".join(orders).strip(b"\0"):
            return None
        self.ended[area] = answer, orders
        sections = [Section(one.kind, one.numbers, marks) for one, marks in zip(asked, orders, strict=True)]
        begins = self.areas > 1 or self.playing.begins(sections)
        return self.part(sections, begins, b"", None if self.request.exchange is None else b"", self.after)

    def joined(self, answers: dict[int, Record]) -> Record:
        """MessageError says why the trainer gets none. Of an area that was not asked there is nothing."""
        sections = self.of_all(answers) if self.areas > 1 else self.of_one(answers[0])
        each = [*(before for before, _ in self.ended.values()), *answers.values()]
        said = [one.said for one in each if one.said] if self.areas == 1 else []
        exchange = [one.exchange for one in each]
        return Record(
            ANSWERS,
            self.request.id,
            sections,
            said=pieces.given([part for one in said for part in pieces.taken(one)]) if said[1:] else b"".join(said),
            exchange=None if self.request.exchange is None or None in exchange else b"".join(exchange),
        )

    def of_all(self, answers: dict[int, Record]) -> list[Section]:
        kind = self.request.sections[0].kind
        nothing = Section(kind, bytes(8), b"\0")
        now = [said_in(answers[area]) if area in answers else nothing for area in range(self.areas)]
        for area in self.ended:
            begun(now[area])
        who = sorted(self.ended)
        last = [said_in(self.ended[area][0]) for area in who]
        return [pieces.join(kind, now), *([pieces.join(kind, last, who)] if who else [])]

    def of_one(self, answer: Record) -> list[Section]:
        self.playing.marks = {section.kind: section.marks for section in answer.sections}
        if not self.ended:
            return answer.sections
        ((before, orders),) = self.ended.values()
        now, ended = [], []
        for first, then, resets in zip(before.sections, answer.sections, orders, strict=True):
            one, other = pieces.cut(first, ANSWERS), pieces.cut(then, ANSWERS)
            rows = [begun(b) if reset else later(a, b) for a, b, reset in zip(one, other, resets, strict=True)]
            now.append(pieces.join(first.kind, rows))
            who = [row for row, reset in enumerate(resets) if reset]
            if who:
                ended.append(pieces.join(first.kind, [one[row] for row in who], who))
        return now + ended


def plain_parts(section: Section) -> dict[int, Part]:
    """Of most steps, where all parts have one form."""
    steps = len(section.marks.translate(None, bytes((NOTHING, RESET))))
    size = len(section.values) // steps if steps else 0
    step, reset = head_of(section.kind, STEP, size), head_of(section.kind, RESET, 0)
    numbers, values, rows = bytes(section.numbers), bytes(section.values), [(section.kind, 1)]
    parts, at = {}, 0
    for area, order in enumerate(section.marks):
        if order == RESET:
            parts[area] = Part(b"".join((reset[:48], numbers[8 * area : 8 * area + 8], reset[56:])), rows, True)
        elif order:
            parts[area] = Part(b"".join((step, values[at : at + size], ZEROS[size % 8])), rows, False)
            at += size
    return parts


@functools.lru_cache(100)
def head_of(kind: int, order: int, size: int) -> bytes:
    """All before an action of so many bytes; the seed stands at 48."""
    head = HEAD.pack(ASKS, 0, 1, 0, 0, 0, 0) + SECTION.pack(kind, 0, 1, 0, size, 0, 0)
    return head + bytes(8) + bytes((order,)) + ZEROS[1]


def at_its_end(mark: int, order: int) -> int:
    """Its time is up, unless it has left."""
    return mark | TRUNCATED if order == LAST and not mark & ABSENT else mark


def reset_of(mark: int, order: int) -> int:
    return RESET if order in (STEP, LAST) and mark & OVER and not mark & ABSENT else NOTHING


def begun(piece: Section) -> Section:
    """The first row of an episode that has begun in a step: nothing was earned in it."""
    piece.marks = bytes((piece.marks[0] | NEW,))
    piece.numbers = bytes(8)
    return piece


def later(before: Section, after: Section) -> Section:
    """Of somebody who was not asked while others began anew: he may have left, or come, just then."""
    if not after.marks[0]:
        return before
    if after.marks[0] & ABSENT:
        after.marks = bytes((after.marks[0] | before.marks[0] & OVER,))
        after.numbers = before.numbers
    return after


def said_in(answer: Record) -> Section:
    """The one row, whose info has what the scene itself has said."""
    (piece,) = answer.sections
    if answer.said:
        info = pieces.taken(piece.infos) if piece.table else {}
        if not isinstance(info, dict) or "env" in info:
            raise MessageError("bad-info", "an info is a dict, in which the name env is the scene's own")
        with_infos(piece, {0: pieces.given({**info, "env": pieces.taken(answer.said)})})
    return piece


def parameters_in(exchange: bytes) -> dict[bytes, bytes]:
    """The messages that set something, by what they set."""
    found, at = {}, 0
    while at + 24 <= len(exchange):
        channel, (size, key) = exchange[at : at + 16], struct.unpack_from("<ii", exchange, at + 16)
        end = at + 20 + size
        if not at < end <= len(exchange):
            break
        if channel in PARAMETERS:
            name = exchange[at + 20 : at + 24 + (max(0, key) if PARAMETERS[channel] else 0)]
            found[channel + name] = exchange[at:end]
        at = end
    return found
