"""A scene by its own clock, for classes that go by Python's: a step of theirs is one decision of all its agents.

    decisions = Decisions(simulators)           from now on simulators.ask asks by it
    scene = decisions.begin(hello)              its agents, which a first reset brings

The scene goes on until its agents decide, and the answer is that of a scene by Python's clock. Agents that end begin
anew by themselves: a reset of all of them begins once more, and one of those that are over hands out what has begun.
MessageError says so where not all decide at the same time. The scene has its seed once, which is 0.

What may be done stands in infos, as `action_mask`, once a scene has masked anything. It needs gymnasium and numpy.
"""

import warnings
from collections import OrderedDict
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces

from netmq_example.envs.kinds import Kind, SceneHello
from netmq_example.envs.remote import MASK
from netmq_example.messages import Message, MessageError, take
from netmq_example.mlagents_envs import scene_clock
from netmq_example.mlagents_envs.envs.env_helpers import action_space
from netmq_example.wire import records, trees
from netmq_example.wire.records import Record, Section, bad
from netmq_example.wire.sections import rewards, rewards_in, with_infos

CURE = "take UnityEnvironment of netmq_example.mlagents_envs.environment"
PYTHONS = "real_time and max_episode_steps are for Python's clock: this scene steps by its own, with Max Step"


@dataclass(eq=False, slots=True)
class Row:
    """An agent's place: the newest that was seen there, and its first end in this step: mark, reward, and what was
    seen."""

    seen: Any = b""
    reward: float = 0.0
    mask: Any = b""
    ended: Any = None
    here: bool = False
    new: bool = False
    # Whether its episode is over; None where nobody asks for this agent.
    over: bool | None = None


class Team(scene_clock.Behavior):
    """The agents of a behavior. Those of team 0 are called by its name alone."""

    def __init__(self, described: Any) -> None:
        super().__init__(described, channels_first=True)
        self.name = self.name.removesuffix("?team=0")
        self.rows: list[Row] = []
        self.ids: dict[int, Row] = {}
        self.complete = False
        self.masked = False
        floats, branches = self.spec.action_spec
        self.given = np.dtype([("floats", np.float32, (floats,)), ("branches", np.int64, (len(branches),))])

    def begin(self) -> None:
        self.asking: list[Row] = []

    def take(self, section: Section) -> None:
        size, count = self.row.itemsize, len(section.marks)
        if len(section.ids) != 4 * count or len(section.values) != size * count:
            raise bad(f"{count} rows of {self.name!a:.80} have {len(section.values)} bytes, and ids of their own")
        self.masked |= section.columns & records.MASKS > 0
        each = zip(section.ids.cast("i"), section.marks, rewards_in(section), strict=True)
        for at, (agent, mark, reward) in enumerate(each):
            row = self.ids.get(agent) or self.found(agent)
            seen = section.values[at * size : (at + 1) * size]
            if section.columns & records.ENDED:
                row.ended = row.ended or (mark, reward, seen)
                continue
            row.seen, row.reward = seen, reward
            row.mask = section.masks[at * self.choices : (at + 1) * self.choices]
            self.asking.append(row)

    def found(self, agent: int) -> Row:
        """The place of an agent that has come: in the end one that another one has left."""
        taken = {*self.ids.values()}
        row = next((row for row in self.rows if row not in taken), None)
        if row is None:
            if self.complete:
                raise not_together(self.name)
            row = Row()
            self.rows.append(row)
        self.ids[agent] = row
        return row

    def decided(self) -> None:
        asking = {*self.asking}
        for row in self.rows:
            if row.here and row not in asking and not row.ended:
                raise not_together(self.name)
            row.new = not row.here and row in asking
            row.here = row in asking
        if len(asking) < len(self.rows):
            # An agent that has left never comes again by this id.
            self.ids = {agent: row for agent, row in self.ids.items() if row.here}

    def kind(self, at: int, first: int) -> Kind:
        self.complete = True
        count = len(self.rows)
        names = [f"{self.name}_{number}" for number in range(count)] if count > 1 else [self.name]
        seen: dict[str, Any] = OrderedDict()
        for spec, is_picture in zip(self.spec.observation_specs, self.pictures, strict=True):
            low, high, dtype = (0, 255, np.uint8) if is_picture else (-np.inf, np.inf, np.float32)
            name = f"{spec.name}_{len(seen)}" if spec.name in seen else spec.name
            seen[name] = spaces.Box(low, high, spec.shape, dtype)
        action = action_space(spaces, self.spec.action_spec)
        if not seen or not action:
            raise MessageError("no-spaces", f"the agents of {self.name!a:.80} see nothing, or do nothing: {CURE}")
        observation = spaces.Dict(seen) if len(seen) > 1 else next(iter(seen.values()))
        return Kind(at, self.name, tuple(names), first, 1, observation, action, located=False)

    def actions(self, asked: Section) -> Section:
        """Of all that decide: of whom none was given, it is zeros."""
        given = dict(zip(self.rows, asked.rows(records.ASKS), strict=True))
        values = b"".join(given[row] or bytes(self.given.itemsize) for row in self.asking)
        if self.choices:
            rows: Any = np.frombuffer(values, self.given)
            values = rows.astype(self.action).tobytes()
        count = len(self.asking)
        return Section(asked.kind, bytes(8 * count), bytes([records.STEP]) * count, values=values)

    def section(self, asked: Section, autoreset: bool) -> tuple[Section, Section | None]:
        """What is now; and with autoreset those that have ended, if there are any."""
        now, ended = [], {}
        for at, (order, row) in enumerate(zip(asked.marks, self.rows, strict=True)):
            # Rewards before its first decision belong to no step of an episode.
            earned = 0.0 if order == records.RESET else row.reward
            seen = (records.SEEN, earned, row.seen) if row.here else (records.ABSENT, 0.0, b"")
            if order == records.NOTHING:
                seen = (records.SEEN | records.NEW, 0.0, row.seen) if row.new else (records.NOTHING, 0.0, b"")
            elif order == records.STEP and row.ended:
                if autoreset:
                    ended[at] = row.ended
                else:
                    seen = row.ended
                    row.over = True
            now.append(seen)
        section = section_of(asked.kind, now)
        if self.masked:
            with_infos(section, {at: self.said(row) for at, row in enumerate(self.rows) if now[at][0] & records.SEEN})
        if not ended:
            return section, None
        who = memoryview(np.array([*ended], np.uint32).tobytes())
        return section, section_of(asked.kind, [*ended.values()], columns=records.ENDED | records.WHO, who=who)

    def said(self, row: Row) -> bytes:
        """In ML-Agents True is forbidden, in Gymnasium 0."""
        forbidden = np.frombuffer(row.mask, np.uint8) if len(row.mask) else np.zeros(self.choices, np.uint8)
        allowed = [1 - part[0] for part in scene_clock.branches_of(forbidden[None], self.spec.action_spec[1])]
        return trees.write({MASK: allowed[0] if len(allowed) == 1 else allowed})


def section_of(kind: int, rows: list[Any], **columns: Any) -> Section:
    marks, earned, seen = zip(*rows, strict=True)
    return Section(kind, rewards(earned), bytes(marks), values=b"".join(seen), **columns)


def not_together(name: str) -> MessageError:
    why = f"the agents of {name!a:.80} do not all decide at the same time, or have come later"
    return MessageError("scene-clock", f"{why}: {CURE}")


class Decisions(scene_clock.SceneClock):
    """Stands in front of the `ask` of Simulators."""

    def __init__(self, simulators: Any) -> None:
        super().__init__(seed=0, channels_first=True, limit=0, given=(None, None))
        self.asked = simulators.ask
        simulators.ask = self.ask
        # Side channels have said this in the step.
        self.heard = b""

    def begin(self, hello: Message) -> SceneHello:
        """A first reset. It brings the behaviors, and all agents that decide in it."""
        self.connected(hello)
        self.go_on(self.anew())
        kinds: list[Kind] = []
        for team in self.behaviors:
            kinds.append(team.kind(len(kinds), sum(len(kind.agents) for kind in kinds)))
        return SceneHello(take(hello.values, "name", str), take(hello.values, "dt", float), tuple(kinds), True)

    def made(self, described: Any) -> Team:
        team = Team(described)
        if self.behaviors and self.behaviors[0].complete:
            raise not_together(team.name)
        return team

    def ask(self, request: Any) -> Any:
        if not isinstance(request, Record):
            return self.asked(request)
        if request.bits & records.REAL_TIME or request.has(records.LAST):
            raise MessageError("scene-clock", PYTHONS)
        if request.said:
            warnings.warn("options of a reset do not reach a scene that steps by its own clock", stacklevel=2)
        sections = request.sections
        orders = [pair for one in sections for pair in zip(self.behaviors[one.kind].rows, one.marks, strict=True)]
        steps = request.has(records.STEP)
        autoreset = bool(request.bits & records.AUTORESET)
        # Agents that are not to begin anew, within their episodes.
        others = any(order == records.NOTHING and row.over is False for row, order in orders)
        if others and not steps and any(order == records.RESET and row.over is False for row, order in orders):
            raise MessageError("scene-clock", "an agent within its episode begins anew with all others: reset all")
        for row, order in orders:
            if order != records.NOTHING:
                row.over = False
        self.heard = b""
        if steps:
            acting = [self.behaviors[one.kind].actions(one) for one in sections if self.behaviors[one.kind].asking]
            exchange = request.exchange or b""
            self.go_on(Record(records.ASKS, 0, acting, records.SCENE_CLOCK, b"", exchange), ends=not autoreset)
        elif not others:
            self.go_on(self.anew(request.exchange or b""))
        told = [self.behaviors[one.kind].section(one, autoreset) for one in sections]
        answer = [now for now, _ in told] + [ended for _, ended in told if ended]
        return Record(records.ANSWERS, request.id, answer, exchange=self.heard)

    def go_on(self, request: Record, ends: bool = False) -> None:
        """Until the agents decide. With `ends` no later than when all of them have ended: they begin by a reset."""
        rows = [row for team in self.behaviors for row in team.rows]
        for row in rows:
            row.ended = None
        while not self.decide(self.asked(request)):
            if ends and all(row.over or row.ended for row in rows if row.over is not None):
                return
            request = Record(records.ASKS, 0, [], records.SCENE_CLOCK, exchange=b"")
        for team in self.behaviors:
            team.decided()

    def decide(self, answer: Record) -> bool:
        self.heard += bytes(answer.exchange or b"")
        self.read(answer)
        return any(team.asking for team in self.behaviors)
