"""Rows of records, cut and joined as bytes: what they mean, the hub does not need to know. And the few values it reads.

    one, other = cut(section)                       a section of one row for each row
    section = join(0, [one, other])                 the way back, of the answers of several simulators

records.py says how the bytes stand. It needs numpy.
"""

import struct
from collections.abc import Sequence
from typing import Any

from netmq_example.messages import MessageError
from netmq_example.wire import trees
from netmq_example.wire.records import ASKS, ENDED, FORM, SEEN, SIZE, SIZES, WHO, Section
from netmq_example.wire.sections import with_infos, with_sizes


def cut(section: Section) -> list[Section]:
    if len(section.marks) == 1:
        return [section]
    infos = dict(section.each_info())
    pieces = []
    for at, row in enumerate(section.rows(ASKS)):
        number = section.numbers[8 * at : 8 * at + 8]
        piece = Section(section.kind, number, section.marks[at : at + 1], values=b"" if row is None else row)
        if row is not None and section.columns:
            piece.columns = section.columns & (FORM | SIZES)
            piece.form = section.form
            piece.sizes = SIZE.pack(len(row)) if piece.columns & SIZES else b""
        pieces.append(with_infos(piece, {0: infos[at]}) if at in infos else piece)
    return pieces


def join(kind: int, pieces: Sequence[Section], who: Sequence[int] = ()) -> Section:
    """Rows of an answer, one of each piece; with `who` of those who have ended."""
    numbers, marks = b"".join([piece.numbers for piece in pieces]), b"".join([piece.marks for piece in pieces])
    section = Section(kind, numbers, marks)
    seen = [piece for piece in pieces if piece.marks[0] & SEEN]
    rows = [piece.values for piece in seen]
    forms = {piece.form for piece in seen}
    if len(forms) > 1 or (forms != {b""} and len({*map(len, rows)}) > 1):
        # Each row has its own form then, as a value has it.
        rows = [b"".join((SIZE.pack(len(one.form)), one.form, one.values)) if one.form else one.values for one in seen]
    elif forms and forms != {b""}:
        section.columns, (section.form,) = FORM, forms
    with_sizes(section, rows)
    if who:
        section.columns |= WHO | ENDED
        section.who = struct.pack(f"<{len(who)}I", *who)
    if any(piece.table for piece in pieces):
        with_infos(section, {at: piece.infos for at, piece in enumerate(pieces) if piece.table})
    return section


def taken(data: Any) -> Any:
    """A value; MessageError says that these bytes are none, or need a package that this hub does not have."""
    try:
        return trees.read(data)
    except ImportError as error:
        raise MessageError("bad-tree", f"the hub cannot read it: {error!s:.80}") from None


def text_in(value: Any) -> str:
    if not isinstance(value, str):
        raise MessageError("bad-tree", "a name is a text")
    return value
