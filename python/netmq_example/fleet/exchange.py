"""One step or reset of a trainer, split among its areas and joined again.

    exchange = Exchange(request, 2, parameters, playing)           exchange.parts: what each area is asked
    part = exchange.again(0, answer)                               where an agent is over: how it begins anew, or None
    answer = exchange.joined({0: answer, 1: other})                one answer, for all

Of several scenes none begins anew by itself: it gets a second request, a reset, and here the two answers become one.
So an episode stays a seed and the actions after it. A single scene gets all as it is: who comes and goes while others
begin anew, only the scene itself knows. An episode begins there when all begin at once.
"""

import functools
import struct
import uuid
from typing import Any

from netmq_example.fleet import pieces
from netmq_example.fleet.members import Part
from netmq_example.messages import MessageError
from netmq_example.wire import records, trees
from netmq_example.wire.records import Record, Section
from netmq_example.wire.sections import with_infos

OVER = records.TERMINATED | records.TRUNCATED
# All marks but those of somebody who has come.
NOT_NEW = bytes(mark for mark in range(256) if not mark & records.NEW)
HERE = "a hub steps simulators as often as it must, and so "
# Channels whose messages set something that stays set, and how their keys begin: with a text, or with a number.
PARAMETERS = {
    uuid.UUID("534c891e-810f-11ea-a9d0-822485860400").bytes_le: True,
    uuid.UUID("60ccf7d0-4f7e-11ea-b238-784f4387d1f7").bytes_le: True,
    uuid.UUID("e951342c-4f7e-11ea-b238-784f4387d1f7").bytes_le: False,
}


class Playing:
    """The agents that play in a scene. When all reset at once, an episode begins, and what was before is over. It holds
    for those that have left, too: in another simulator they may be there, as they were at the end of its last episode.
    """

    def __init__(self) -> None:
        self.rows: set[tuple[int, int]] = set()

    def begins(self, sections: list[Section]) -> bool:
        orders = [(one.kind, row, order) for one in sections for row, order in enumerate(one.marks) if order]
        reset = {(kind, row) for kind, row, order in orders if order == records.RESET}
        if not reset:
            return False
        begins = len(reset) == len(orders) and reset >= self.rows
        self.rows = reset if begins else self.rows | reset
        return begins

    def see(self, sections: list[Section]) -> None:
        """Newcomers play as well."""
        for one in sections:
            if one.marks.translate(None, NOT_NEW):
                self.rows.update((one.kind, row) for row, mark in enumerate(one.marks) if mark & records.NEW)


class Exchange:
    """Until all areas have answered."""

    def __init__(self, request: Record, areas: int, parameters: dict[bytes, bytes], playing: Playing) -> None:
        """`parameters` are those that the trainer has set: each simulator of a new episode gets them first."""
        if request.bits & records.REAL_TIME:
            raise MessageError("real-time", f"{HERE}has no real time: leave out real_time, or connect the scene itself")
        if request.bits & records.SCENE_CLOCK:
            raise MessageError("scenes-clock", f"{HERE}has no clock of a scene's: connect the scene itself")
        if any(section.columns & ~(records.FORM | records.SIZES) for section in request.sections):
            raise MessageError("bad-record", "a request has no such columns by Python's clock")
        self.request = request
        self.areas = areas
        self.playing = playing
        self.autoreset = bool(request.bits & records.AUTORESET)
        self.before = b"".join(parameters.values())
        if request.exchange:
            parameters = parameters | parameters_in(bytes(request.exchange))
        self.parameters = parameters
        self.after = b"".join(parameters.values())
        # Answers of those scenes whose episode is over, and another one begins.
        self.ended: dict[int, Record] = {}
        self.parts = self.whole() if areas == 1 else self.split()

    def whole(self) -> dict[int, Part]:
        sections, request = self.request.sections, self.request
        if not sections:
            raise MessageError("bad-record", "a request asks for one kind at least")
        said = request.said if request.has(records.RESET) else b""
        bits = request.bits & records.AUTORESET
        return {0: self.part(sections, self.playing.begins(sections), said, request.exchange, self.before, bits)}

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
        for area, piece in enumerate(pieces.cut(section)):
            order = piece.marks[0]
            if order or request.exchange:
                said = request.said if order == records.RESET else b""
                parts[area] = self.part([piece], order == records.RESET, said, request.exchange, self.before)
        return parts

    def part(
        self, sections: list[Section], begins: bool, said: Any, exchange: Any, known: bytes, bits: int = 0
    ) -> Part:
        if begins and exchange is not None:
            exchange = known + bytes(exchange)
        frame = Record(records.ASKS, 0, sections, bits, said, exchange).frame()
        return Part(frame, [(section.kind, len(section.marks)) for section in sections], begins)

    def again(self, area: int, answer: Record) -> Part | None:
        """The second request to one of several scenes: a reset that the trainer has left to the simulator."""
        if area in self.ended or not self.autoreset or self.areas == 1:
            return None
        (section,) = self.request.sections
        mark, order = answer.sections[0].marks[0], section.marks[area]
        if order not in (records.STEP, records.LAST) or not (mark & OVER and mark & records.SEEN):
            return None
        self.ended[area] = answer
        return self.reset([Section(section.kind, section.numbers[8 * area : 8 * area + 8], bytes((records.RESET,)))])

    def anew(self, answer: Record) -> Part | None:
        """How the episode of a single scene can be begun where all of them have just begun anew."""
        self.playing.see(answer.sections)
        ended = {(one.kind, row) for one in answer.sections if one.columns & records.ENDED for row in one.whose()}
        if not ended or not ended >= self.playing.rows:
            return None
        rows = [
            (
                one,
                bytes(records.RESET if (one.kind, row) in ended else records.NOTHING for row in range(len(one.marks))),
            )
            for one in self.request.sections
        ]
        return self.reset([Section(one.kind, one.numbers, marks) for one, marks in rows])

    def reset(self, sections: list[Section]) -> Part:
        return self.part(sections, True, b"", None if self.request.exchange is None else b"", self.after)

    def joined(self, answers: dict[int, Record]) -> Record:
        """MessageError says why the trainer gets none. Of an area that was not asked there is nothing."""
        each = [*self.ended.values(), *answers.values()]
        one = self.areas == 1
        exchange = [answer.exchange for answer in each]
        return Record(
            records.ANSWERS,
            self.request.id,
            each[0].sections if one else self.of_all(answers),
            said=each[0].said if one else b"",
            exchange=None if self.request.exchange is None or None in exchange else b"".join(exchange),
        )

    def of_all(self, answers: dict[int, Record]) -> list[Section]:
        kind = self.request.sections[0].kind
        nothing = Section(kind, bytes(8), b"\0")
        now = [said_in(answers[area]) if area in answers else nothing for area in range(self.areas)]
        for area in self.ended:
            begun(now[area])
        who = sorted(self.ended)
        last = [over(said_in(self.ended[area])) for area in who]
        return [pieces.join(kind, now), *([pieces.join(kind, last, who)] if who else [])]


def plain_parts(section: Section) -> dict[int, Part]:
    """Of most steps, where all parts have one form."""
    steps = len(section.marks.translate(None, bytes((records.NOTHING, records.RESET))))
    size = len(section.values) // steps if steps else 0
    reset = head_of(section.kind, records.RESET, 0)
    numbers, values, rows = bytes(section.numbers), bytes(section.values), [(section.kind, 1)]
    parts, at = {}, 0
    for area, order in enumerate(section.marks):
        if order == records.RESET:
            parts[area] = Part(b"".join((reset[:48], numbers[8 * area : 8 * area + 8], reset[56:])), rows, True)
        elif order:
            head = head_of(section.kind, order, size)
            parts[area] = Part(b"".join((head, values[at : at + size], records.ZEROS[size % 8])), rows, False)
            at += size
    return parts


@functools.lru_cache(100)
def head_of(kind: int, order: int, size: int) -> bytes:
    """All before an action of so many bytes; the seed stands at 48."""
    head = records.HEAD.pack(records.ASKS, 0, 1, 0, 0, 0, 0) + records.SECTION.pack(kind, 0, 1, 0, size, 0, 0)
    return head + bytes(8) + bytes((order,)) + records.ZEROS[1]


def over(piece: Section) -> Section:
    """The last row of an episode, whoever has left with it."""
    piece.marks = bytes((piece.marks[0] & ~records.ABSENT,))
    return piece


def begun(piece: Section) -> Section:
    """The first row of an episode that has begun in a step: nothing was earned in it."""
    piece.marks = bytes((piece.marks[0] | (records.NEW if piece.marks[0] & records.SEEN else 0),))
    piece.numbers = bytes(8)
    return piece


def said_in(answer: Record) -> Section:
    """The one row, whose info has what the scene itself has said."""
    (piece,) = answer.sections
    if answer.said:
        info = pieces.taken(piece.infos) if piece.table else {}
        if not isinstance(info, dict) or "env" in info:
            raise MessageError("bad-info", "an info is a dict, in which the name env is the scene's own")
        with_infos(piece, {0: trees.write({**info, "env": pieces.taken(answer.said)})})
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
