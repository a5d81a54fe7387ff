"""Seeds, rewards, rows and infos, as they go into a section of a record and come out of it. It needs only Python."""

import math
import struct
from collections.abc import Sequence

from netmq_example.messages import MessageError
from netmq_example.wire.records import SIZES, Section


def with_infos(section: Section, infos: dict[int, bytes]) -> Section:
    """The same section, which says this of these rows."""
    section.table = b"".join(struct.pack("<II", row, len(data)) for row, data in infos.items())
    section.infos = b"".join(infos.values())
    return section


def with_sizes(section: Section, rows: Sequence[bytes]) -> Section:
    """The same section with these values; where their sizes differ, each is said."""
    section.values = b"".join(rows)
    if len({*map(len, rows)}) > 1:
        section.columns |= SIZES
        section.sizes = struct.pack(f"<{len(rows)}I", *map(len, rows))
    return section


def seeds(numbers: Sequence[int]) -> bytes:
    try:
        return struct.pack(f"<{len(numbers)}q", *numbers)
    except struct.error:
        wrong = ", ".join(map(str, numbers))
        raise ValueError(f"seed {wrong:.40} cannot be sent: it is a whole number below 2**63") from None


def rewards(numbers: Sequence[float]) -> bytes:
    return struct.pack(f"<{len(numbers)}d", *numbers)


def rewards_in(section: Section) -> tuple[float, ...]:
    """One for each row. MessageError if one is not finite: whoever learned from it would know nothing any more."""
    numbers: tuple[float, ...] = struct.unpack(f"<{len(section.marks)}d", section.numbers)
    for number in numbers:
        if not math.isfinite(number):
            raise MessageError("bad-reward", f"the reward is {number}")
    return numbers
