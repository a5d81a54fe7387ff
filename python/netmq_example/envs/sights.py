"""Observations of agents with attributes: rows of locators and values. Those in code are in observations.py.

It needs gymnasium and numpy.
"""

import contextlib
import functools
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from gymnasium.spaces import Space

from netmq_example.envs.observations import NOBODY, all_seen
from netmq_example.envs.plan import Sight, Table, table_of
from netmq_example.messages import MessageError
from netmq_example.wire import trees
from netmq_example.wire.batches import together
from netmq_example.wire.records import ANSWERS, FORM, Section


class Sights:
    """Observations that come as locators and values."""

    def __init__(self, space: Space[Any], agents: tuple[str, ...], spaces: Mapping[str, Space[Any]]) -> None:
        self.space = space
        self.sights = [Sight(agent, spaces.get(agent, space)) for agent in agents]
        self.table_for = trees.kept(functools.partial(table_of, agents[0], space))
        # The newest values of all, where they go to their places at once. The sights do not know of them yet.
        self.table: Table | None = None
        self.form = b""
        self.values: Any = b""
        # The observation that was read last, until somebody takes it.
        self.fresh: Any = None
        self.warned = False

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

    def warn(self, agents: Iterable[int]) -> None:
        """Once, name what nothing of their last rows writes."""
        if not self.warned:
            self.warned = True
            self.sync()
            for agent in agents:
                self.sights[agent].warn()
