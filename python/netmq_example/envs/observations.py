"""What the agents of one kind see: the rows of an answer, as observations and as batches of them.

    seen = observations_of(space, kind)
    seen.take(section, begins={3})                  the newest of each; the episode of agent 3 has just begun
    seen.batch()                                    of all agents, as Gymnasium batches them
    seen.one(3)                                     of one

Whatever is returned is fresh: its user may change it. An agent of whom nothing came keeps what it saw last.
"""

import contextlib
from collections.abc import Collection
from typing import Any

import numpy as np
from gymnasium.spaces import Space

from netmq_example.envs.kinds import Kind
from netmq_example.envs.merge import empty
from netmq_example.envs.plan import Sight, Table, table_of
from netmq_example.messages import MessageError
from netmq_example.wire import trees
from netmq_example.wire.records import ANSWERS, FORM, SEEN, Section
from netmq_example.wire.space_bytes import Bytes, together
from netmq_example.wire.spaces import Numbers

NOBODY: frozenset[int] = frozenset()


def observations_of(space: Space[Any], kind: Kind) -> "Rows | Sights":
    """An agent in code sends what is in the space, one with attributes locators and values."""
    return Sights(space, kind.agents) if kind.located else Rows(space, len(kind.agents))


def all_seen(section: Section, count: int) -> bool:
    return len(section.marks) == count and not section.who and min(section.marks) >= SEEN


class Rows:
    """Observations that are in a space which both sides know."""

    def __init__(self, space: Space[Any], count: int) -> None:
        self.space = space
        self.count = count
        self.bytes = Bytes(space)
        # One array alone, as most have, is taken with fewer calls of numpy.
        self.array = self.bytes.codec if isinstance(self.bytes.codec, Numbers) and self.bytes.size else None
        # All of them one after the other, or else one by one.
        self.block: Any = None
        self.rows: list[Any] = [None] * count

    def take(self, section: Section, begins: Collection[int] = NOBODY) -> None:
        if self.bytes.size and all_seen(section, self.count):
            if len(section.values) != self.count * self.bytes.size:
                raise MessageError("not-in-space", f"{len(section.values)} bytes are not {self.count} of {self.space}")
            self.block = section.values
            return
        self.part()
        for agent, row in zip(section.whose(), section.rows(ANSWERS), strict=True):
            if row is not None:
                self.rows[agent] = row

    def part(self) -> None:
        if self.block is not None:
            size = self.bytes.size
            self.rows = [self.block[at : at + size] for at in range(0, len(self.block), size)]
            self.block = None

    def batch(self) -> Any:
        whole = self.block is None and self.bytes.size and None not in self.rows
        if whole and {*map(len, self.rows)} == {self.bytes.size}:
            self.block = memoryview(b"".join(self.rows))
        if self.block is None:
            return together(self.space, [self.one(agent) for agent in range(self.count)])
        if self.array:
            items: Any = np.ndarray((self.count, *self.array.shape), self.array.dtype, self.block).copy()
            self.array.check(items)
            return items
        block = np.frombuffer(self.block, np.uint8).reshape(self.count, self.bytes.size)
        return self.bytes.codec.read_block(block, 0)

    def one(self, agent: int) -> Any:
        if self.block is not None:
            at = agent * self.bytes.size
            return self.bytes.read(self.block[at : at + self.bytes.size])
        row = self.rows[agent]
        return empty(self.space, "") if row is None else self.bytes.read(row)


class Sights:
    """Observations that come as locators and values."""

    def __init__(self, space: Space[Any], agents: tuple[str, ...]) -> None:
        self.space = space
        self.sights = [Sight(agent, space) for agent in agents]
        self.tables: dict[bytes, Table | None] = {}
        # The newest values of all, where they go to their places at once. The sights do not know of them yet.
        self.table: Table | None = None
        self.form = b""
        self.values: Any = b""
        # What was read last, until somebody takes it.
        self.fresh: Any = None

    def take(self, section: Section, begins: Collection[int] = NOBODY) -> None:
        if section.columns & FORM and all_seen(section, len(self.sights)):
            table = self.table_for(section.form)
            # What does not fit is told by the sight that reads it.
            with contextlib.suppress(MessageError):
                if table:
                    self.fresh = table.read(section.values, len(self.sights))
                    self.table = table
                    self.form = section.form
                    self.values = section.values
                    return
        self.sync()
        for agent, row in zip(section.whose(), section.rows(ANSWERS), strict=True):
            if agent in begins:
                self.sights[agent].forget()
            if row is not None:
                self.sights[agent].read(*((section.form, row) if section.columns & FORM else trees.parted(row)))

    def use(self, agents: dict[int, str], spaces: dict[str, Space[Any]]) -> None:
        """Each with a space of its own."""
        self.sights = [
            Sight(sight.name, spaces[agents[at]] if at in agents else self.space)
            for at, sight in enumerate(self.sights)
        ]

    def table_for(self, form: bytes) -> Table | None:
        if form not in self.tables:
            if len(self.tables) >= trees.MOST_KEPT:
                self.tables.clear()
            self.tables[form] = table_of(self.sights[0].name, self.space, form)
        return self.tables[form]

    def sync(self) -> None:
        """Tell the sights what came last."""
        if self.table:
            self.table = None
            size = len(self.values) // len(self.sights)
            for at, sight in enumerate(self.sights):
                sight.forget()
                sight.read(self.form, self.values[at * size : (at + 1) * size])

    def batch(self) -> Any:
        if self.table:
            seen, self.fresh = self.fresh, None
            return self.table.read(self.values, len(self.sights)) if seen is None else seen
        return together(self.space, [sight.again() for sight in self.sights])

    def one(self, agent: int) -> Any:
        self.sync()
        return self.sights[agent].again()

    def warn(self, agent: int) -> None:
        """Name what nothing of its last row writes."""
        self.sync()
        self.sights[agent].warn()
