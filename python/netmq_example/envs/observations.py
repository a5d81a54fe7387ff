"""Observations of the agents of one kind: the rows of an answer, one by one and as batches.

    seen = observations_of(space, kind)
    seen.take(section, begins={3})                  the newest of each; the episode of agent 3 has just begun
    seen.batch()                                    of all agents, as Gymnasium batches them
    seen.one(3)                                     of one

Whatever is returned is fresh: its user may change it. An agent of whom nothing came keeps what it saw last.
"""

import importlib
from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Space

from netmq_example.envs.kinds import Kind
from netmq_example.messages import MessageError
from netmq_example.wire.batches import empty, together
from netmq_example.wire.records import ANSWERS, SEEN, Section
from netmq_example.wire.space_bytes import Bytes
from netmq_example.wire.spaces import Numbers

NOBODY: frozenset[int] = frozenset()


def observations_of(space: Space[Any], kind: Kind, spaces: Mapping[str, Space[Any]] | None = None) -> Any:
    """An agent in code sends what is in the space, one with attributes locators and values: sights.py reads them, where
    each agent may have a space of its own.
    """
    if not kind.located:
        return Rows(space, len(kind.agents))
    try:
        # By name: a copy of a lesson whose agents have no attributes goes without.
        return importlib.import_module("netmq_example.envs.sights").Sights(space, kind.agents, spaces or {})
    except ModuleNotFoundError as error:
        raise MessageError(
            "no-attributes", f"agents with attributes need {error.name}, which this copy lacks"
        ) from None


def all_seen(section: Section, count: int) -> bool:
    return len(section.marks) == count and not section.who and min(section.marks) >= SEEN


class Rows:
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

    def warn(self, agents: Iterable[int]) -> None:
        """An observation in code is always whole."""
