"""A simulator of the scene's clock in Python, for tests without .NET: a world whose agents ask and end by a script.

    arena = Arena(Walker("Ball", period=5, length=12), Walker("Goal", branches=(3, 2), group=4))
    EnvironmentClient(endpoint).run(ArenaSimulator(arena))
    python -m tests.lessons.scene_clock --endpoint tcp://…          two of Ball, and a Goal of team 1

A walker earns 1 at each tick and sees [its id, the ticks of its episode, the first float and the first whole number of
its action]; with `picture` also one of 2 x 3 grey pixels. It ends after `length` ticks.
"""

from __future__ import annotations

import struct
import sys
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from netmq_example.messages import Message
from netmq_example.scene.client import EnvironmentClient
from netmq_example.scene.simulator import SimulatorBase
from netmq_example.wire import records, trees
from netmq_example.wire.records import Record, Section, bad

VECTOR = {"name": "VectorSensor_size4", "shape": [4], "dtype": "float32", "type": 0, "properties": [1]}
EYE = {"name": "Eye", "shape": [1, 2, 3], "dtype": "uint8", "type": 1, "properties": [1, 2, 2]}


@dataclass(eq=False)
class Walker:
    behavior: str
    team: int = 0
    floats: int = 2
    branches: tuple[int, ...] = ()
    period: int = 1
    length: int = 0
    interrupted: bool = False
    group: int = 0
    group_reward: float = 0.0
    # The forbidden choices, counted over all branches.
    forbidden: tuple[int, ...] = ()
    picture: bool = False
    # It is in the scene from this tick on, and up to that one.
    comes: int = 0
    leaves: int = 10**9
    id: int = -1
    time: int = 0
    earned: float = 0.0
    action: Any = ((0.0, 0.0), (0,))
    done: list[Any] = field(default_factory=list)

    def described(self):
        sensors = [VECTOR, EYE] if self.picture else [VECTOR]
        return {
            "name": self.behavior,
            "team": self.team,
            "continuous": self.floats,
            "branches": list(self.branches),
            "sensors": sensors,
        }

    def seen(self):
        floats, numbers = self.action
        seen = struct.pack("<4f", self.id, self.time, *floats[:1] or (0,), *numbers[:1] or (0,))
        return seen + bytes([0, 51, 102, 153, 204, 255]) * self.picture

    def begin(self):
        self.time, self.action = 0, ((0.0,) * self.floats, (0,) * len(self.branches))


@dataclass
class Row:
    """A row as it was when it was kept."""

    walker: Walker
    mark: int
    earned: float = 0.0
    seen: bytes = b""

    def __post_init__(self):
        self.earned, self.walker.earned = self.walker.earned, 0.0
        self.seen = self.walker.seen()


class Arena:
    def __init__(self, *walkers, name="Arena"):
        self.name = name
        self.walkers = walkers
        self.ticks, self.ids = 0, 0
        self.known: list[tuple[str, int]] = []
        self.ended: list[Row] = []
        self.asking: list[Walker] = []
        self.resets: list[dict[str, Any]] = []

    def here(self):
        return [one for one in self.walkers if one.comes <= self.ticks < one.leaves]

    def reset(self, options):
        self.resets.append(options)
        self.ended = []
        for walker in self.here():
            walker.begin()
        return self.advance()

    def go_on(self, actions):
        """Actions by behavior, for those who have asked."""
        for number, rows in actions.items():
            asked = [one for one in self.asking if self.number(one) == number]
            if len(rows) != len(asked):
                raise bad(f"{len(rows)} actions for {len(asked)} agents")
            for walker, action in zip(asked, rows, strict=True):
                walker.action = action
        for walker in self.asking:
            if self.number(walker) not in actions:
                walker.action = ((0.0,) * walker.floats, (0,) * len(walker.branches))
        self.tick()
        return self.advance()

    def tick(self):
        before = self.here()
        for walker in before:
            walker.done.append(walker.action)
            walker.earned += 1
            walker.time += 1
            if walker.time == walker.length:
                self.ended.append(Row(walker, records.TRUNCATED if walker.interrupted else records.TERMINATED))
                walker.begin()
        self.ticks += 1
        for walker in before:
            if walker not in self.here():
                self.ended = [row for row in self.ended if row.walker is not walker]
                self.ended.append(Row(walker, records.TERMINATED))

    def advance(self):
        """The rows of the next exchange: of those that have ended, and of those that ask."""
        while True:
            for walker in self.here():
                if walker.id < 0:
                    walker.id, self.ids = self.ids, self.ids + 1
                    walker.begin()
            self.asking = [one for one in self.here() if self.ticks % one.period == 0]
            if self.asking or self.ended:
                ended, self.ended = self.ended, []
                return ended, [Row(walker, records.WANTS) for walker in self.asking]
            self.tick()

    def number(self, walker):
        key = (walker.behavior, walker.team)
        if key not in self.known:
            self.known.append(key)
        return self.known.index(key)


class ArenaSimulator(SimulatorBase):
    """`channels` is a SideChannelManager; without one it answers no exchange of side channels."""

    def __init__(self, arena, channels=None):
        super().__init__(arena.name)
        self.arena, self.channels = arena, channels

    def describe(self):
        self.arena.known, self.arena.ids = [], 0
        for walker in self.arena.walkers:
            walker.id = -1
        values = {"name": self.name, "dt": 0.02, "record": 2, "clock": "scene", "channels": bool(self.channels)}
        return Message("hello", 0, values, [trees.array_of(trees.write({"kinds": []}))])

    def do(self, request):
        if not request.bits & records.SCENE_CLOCK:
            raise bad("this scene goes by its own clock")
        if self.channels:
            self.channels.take_in(request.exchange)
        known = len(self.arena.known)
        if request.bits & records.ANEW:
            ended, asking = self.arena.reset(trees.read(request.said) if request.said else {})
        else:
            ended, asking = self.arena.go_on({section.kind: [*self.actions(section)] for section in request.sections})
        sections = [self.section(rows, records.ENDED) for rows in self.by_number(ended)]
        sections += [self.section(rows, 0) for rows in self.by_number(asking)]
        new = [self.walkers_of(number)[0].described() for number in range(known, len(self.arena.known))]
        said = trees.write({"kinds": new}) if new else b""
        exchange = bytes(self.channels.generate_side_channel_messages()) if self.channels else None
        return Record(records.ANSWERS, request.id, sections, records.SCENE_CLOCK, said, exchange)

    def say(self, request):
        raise bad(f"a scene of this clock knows no {request.kind}")

    def walkers_of(self, number):
        return [one for one in self.arena.walkers if (one.behavior, one.team) == self.arena.known[number]]

    def by_number(self, rows):
        found: dict[int, list[Row]] = {}
        for row in rows:
            found.setdefault(self.arena.number(row.walker), []).append(row)
        return found.values()

    def actions(self, section):
        walker = self.walkers_of(section.kind)[0]
        size = 4 * walker.floats
        for at in range(len(section.marks)):
            assert len(section.values) == len(section.marks) * (size + 4 * len(walker.branches))
            row = bytes(section.values[at * (size + 4 * len(walker.branches)) :])
            floats = struct.unpack_from(f"<{walker.floats}f", row)
            yield floats, struct.unpack_from(f"<{len(walker.branches)}i", row, size)

    def section(self, rows, columns):
        walkers = [row.walker for row in rows]
        section = Section(
            self.arena.number(walkers[0]),
            struct.pack(f"<{len(rows)}d", *(row.earned for row in rows)),
            bytes(row.mark | records.SEEN for row in rows),
            columns=columns | records.IDS,
            ids=np.array([one.id for one in walkers], np.int32).tobytes(),
            values=b"".join(row.seen for row in rows),
        )
        if any(one.group for one in walkers):
            section.columns |= records.GROUPS
            groups = np.array([one.group for one in walkers], np.int32).tobytes()
            section.groups = groups + np.array([one.group_reward for one in walkers], np.float32).tobytes()
        if not columns and any(one.forbidden for one in walkers):
            section.columns |= records.MASKS
            choices = range(sum(walkers[0].branches))
            section.masks = b"".join(bytes(at in one.forbidden for at in choices) for one in walkers)
        return section


if __name__ == "__main__":
    walkers = [Walker("Ball", length=7), Walker("Ball"), Walker("Goal", team=1, floats=1, branches=(3, 2))]
    EnvironmentClient(sys.argv[sys.argv.index("--endpoint") + 1], timeout=10).run(ArenaSimulator(Arena(*walkers)))
