"""Changes of a file's text that can be read, and taken back: each a position, the old words and the new ones."""

import hashlib
from collections.abc import Iterable
from typing import NamedTuple


class Edit(NamedTuple):
    """At a position of the text that it is made for: the words there, and the words instead."""

    at: int
    old: str
    new: str


def decoded(data: bytes) -> str:
    """A text in which every byte has come along, whatever the encoding: only ASCII is looked for and written."""
    return data.decode(codec(data))


def encoded(text: str, like: bytes) -> bytes:
    return text.encode(codec(like))


def codec(data: bytes) -> str:
    wide = {b"\xff\xfe": "utf-16-le", b"\xfe\xff": "utf-16-be"}
    # An odd length is no text of two bytes each.
    return wide.get(data[:2], "latin-1") if len(data) % 2 == 0 else "latin-1"


def applied(data: bytes, edits: Iterable[Edit]) -> bytes:
    """The file after these edits; a ValueError if it is not as they expect it."""
    text, parts, done = decoded(data), [], 0
    for edit in sorted(edits):
        if edit.at < done or text[edit.at : edit.at + len(edit.old)] != edit.old:
            raise ValueError(f"there is no {edit.old!r} at {edit.at}")
        parts += [text[done : edit.at], edit.new]
        done = edit.at + len(edit.old)
    return encoded("".join([*parts, text[done:]]), data)


def reversed_(edits: Iterable[Edit]) -> list[Edit]:
    """The edits that take these back, in the text after them."""
    found, shift = [], 0
    for edit in sorted(edits):
        found.append(Edit(edit.at + shift, edit.new, edit.old))
        shift += len(edit.new) - len(edit.old)
    return found


def difference(old: bytes, new: bytes) -> list[Edit]:
    before, after = decoded(old), decoded(new)
    if before == after:
        return []
    shorter = min(len(before), len(after))
    begin = next((i for i in range(shorter) if before[i] != after[i]), shorter)
    end = next((i for i in range(shorter - begin) if before[-1 - i] != after[-1 - i]), shorter - begin)
    return [Edit(begin, before[begin : len(before) - end], after[begin : len(after) - end])]


def checksum(data: bytes) -> str:
    """Of every byte: positions count the ends of the lines."""
    return hashlib.sha256(data).hexdigest()
