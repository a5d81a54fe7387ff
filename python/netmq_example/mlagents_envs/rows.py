"""Observations of the agents of a kind by Python's clock, as float32 arrays: rows of one size are a block.

It needs gymnasium and numpy.
"""

from typing import Any

import numpy as np
from gymnasium.spaces import Space

from netmq_example.envs.kinds import Kind
from netmq_example.envs.observations import NOBODY, observations_of
from netmq_example.messages import MessageError
from netmq_example.mlagents_envs.plain import Seen
from netmq_example.wire import records
from netmq_example.wire.batches import together
from netmq_example.wire.records import Section


def rows_of(kind: Kind, space: Space[Any], plain: Seen) -> Any:
    return Located(kind, space, plain) if kind.located else Blocks(kind, plain)


class Blocks:
    """Rows of agents in code: a number of bytes, which the space says."""

    def __init__(self, kind: Kind, plain: Seen) -> None:
        self.plain = plain
        self.all_seen = bytes([records.SEEN]) * len(kind.agents)
        self.fields = [f"{at}" for at in range(len(plain.leaves))]
        # The items stand one after the other, as a dtype without padding has them.
        parts = [(field, leaf.dtype, leaf.shape) for field, (_, leaf) in zip(self.fields, plain.leaves, strict=True)]
        self.row = np.dtype(parts)
        self.rows: Any = np.zeros(len(kind.agents), self.row)

    def take(self, section: Section, begins: bool, ended: Any) -> list[Any]:
        """The parts of all rows; those of whom nothing came keep what they saw last."""
        rows = self.read(section)
        if len(rows) != len(self.rows):
            seen = np.frombuffer(section.marks, np.uint8) & records.SEEN > 0
            self.rows = self.rows.copy()
            self.rows[seen] = rows
        else:
            self.rows = rows
        return [self.rows[field] for field in self.fields]

    def last(self, section: Section) -> list[Any]:
        """The parts of those that have ended."""
        rows = self.read(section)
        return [rows[field] for field in self.fields]

    def read(self, section: Section) -> Any:
        count = len(section.values) // self.row.itemsize if self.row.itemsize else 0
        if count * self.row.itemsize != len(section.values) or count > len(section.marks):
            raise MessageError("not-in-space", f"{len(section.values)} bytes are no rows of {self.row.itemsize}")
        # An empty buffer has no rows to numpy, but an error.
        return np.frombuffer(section.values, self.row) if count else np.zeros(0, self.row)


class Located:
    """Rows of agents with attributes: locators and values."""

    def __init__(self, kind: Kind, space: Space[Any], plain: Seen) -> None:
        self.kind = kind
        self.space = space
        self.plain = plain
        self.seen = observations_of(space, kind)

    def take(self, section: Section, begins: bool, ended: Any) -> list[Any]:
        everybody: Any = range(len(self.kind.agents))
        self.seen.take(section, everybody if begins else NOBODY if ended is None else {*ended.tolist()})
        return self.plain.parts(self.seen.batch())

    def last(self, section: Section) -> list[Any]:
        sights = observations_of(self.space, self.kind)
        sights.take(section)
        return self.plain.parts(together(self.space, [sights.one(row) for row in section.whose()]))
