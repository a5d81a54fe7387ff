"""Rows of records and parts of values, cut and joined as bytes: what they mean, the hub does not need to know.

    one, other = cut(section)                       a section of one row for each row
    section = join(0, [one, other])                 the way back, of the answers of several simulators
    value = taken(data)                             dicts and lists, and their leaves as they are
    data = given({**value, "env": other})           the way back

records.py and trees.py say how the bytes stand. It needs only Python.
"""

import math
import struct
from collections.abc import Sequence
from typing import Any, NamedTuple

from netmq_example.json_text import shallow
from netmq_example.messages import DECODER, DTYPES, ENCODER, MessageError
from netmq_example.wire.records import ASKS, ENDED, FORM, SEEN, SIZE, SIZES, WHO, Section
from netmq_example.wire.sections import with_infos

# How many bytes a number has. Arrays are float32[2,3].
NUMBERS = {"null": 0, "bool": 1, "int64": 8, "float64": 8}
REASONS = (ValueError, LookupError, TypeError, RecursionError, struct.error)


class Leaf(NamedTuple):
    form: Any
    data: bytes


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
    own = len({len(row) for row in rows}) > 1 or any(piece.columns & SIZES for piece in seen)
    if len(forms) > 1 or (own and forms != {b""}):
        # Each row has its own form then, as a value has it.
        rows = [b"".join((SIZE.pack(len(one.form)), one.form, one.values)) if one.form else one.values for one in seen]
        own = True
    elif forms and forms != {b""}:
        section.columns, (section.form,) = FORM, forms
    section.values = b"".join(rows)
    if own:
        section.columns = SIZES
        section.sizes = struct.pack(f"<{len(rows)}I", *map(len, rows))
    if who:
        section.columns |= WHO | ENDED
        section.who = struct.pack(f"<{len(who)}I", *who)
    if any(piece.table for piece in pieces):
        with_infos(section, {at: piece.infos for at, piece in enumerate(pieces) if piece.table})
    return section


def taken(data: Any) -> Any:
    """A value; MessageError says that these bytes are none."""
    try:
        view = bytes(data)
        end = SIZE.size + SIZE.unpack_from(view)[0]
        value, at = parts(DECODER.decode(shallow(view[SIZE.size : end].decode())), view, end)
        if at != len(view):
            raise ValueError(f"it has {len(view)} bytes in place of {at}")
    except REASONS as error:
        raise MessageError("bad-tree", f"this is no value: {error!s:.80}") from None
    return value


def parts(form: Any, data: bytes, at: int) -> tuple[Any, int]:
    """The part that begins there, and where the next one does."""
    value: Any
    if isinstance(form, list):
        value = []
        for each in form:
            one, at = parts(each, data, at)
            value.append(one)
        return value, at
    if isinstance(form, dict) and "dict" in form:
        value = {}
        for name, each in form["dict"].items():
            value[name], at = parts(each, data, at)
        return value, at
    begin = at
    if isinstance(form, dict) and "graph" in form:
        _, at = parts(form["graph"], data, at)
    elif form in ("text", "bytes") or isinstance(form, dict):
        at += SIZE.size + SIZE.unpack_from(data, at)[0]
    elif form in NUMBERS:
        at += NUMBERS[form]
    else:
        dtype, _, shape = form.rstrip("]").partition("[")
        at += DTYPES[dtype] * math.prod(map(int, filter(None, shape.split(","))))
    return Leaf(form, data[begin:at]), at


def given(value: Any) -> bytes:
    numbers: list[bytes] = []
    form = ENCODER.encode(form_of(value, numbers)).encode()
    return b"".join([SIZE.pack(len(form)), form, *numbers])


def form_of(value: Any, numbers: list[bytes]) -> Any:
    if isinstance(value, Leaf):
        numbers.append(value.data)
        return value.form
    if isinstance(value, dict):
        return {"dict": {name: form_of(each, numbers) for name, each in value.items()}}
    return [form_of(each, numbers) for each in value]


def text(words: str) -> Leaf:
    return Leaf("text", SIZE.pack(len(words.encode())) + words.encode())


def whole(number: int) -> Leaf:
    return Leaf("int64", struct.pack("<q", number))


def words_of(leaf: Any) -> str:
    if not isinstance(leaf, Leaf) or leaf.form != "text":
        raise MessageError("bad-tree", "a name is a text")
    return leaf.data[SIZE.size :].decode()
