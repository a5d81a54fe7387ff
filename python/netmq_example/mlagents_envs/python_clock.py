"""Python's clock, that of lessons 09 to 11: at each step all agents of the scene act, and whoever ends begins anew.

An agent's id is its number among all agents of the scene, and another one that comes in its place has a new id. What is
done and seen in Gymnasium's spaces are floats and whole numbers here, and a float32 array for each array in them. It
needs gymnasium and numpy.
"""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from netmq_example.envs import kinds
from netmq_example.envs.actions import Actions
from netmq_example.envs.episodes import Episodes
from netmq_example.envs.observations import NOBODY, observations_of
from netmq_example.envs.remote import MASK, info_in
from netmq_example.messages import Message, MessageError, take
from netmq_example.mlagents_envs import plain, scene_clock
from netmq_example.mlagents_envs.base_env import (
    ActionTuple,
    BehaviorMapping,
    BehaviorSpec,
    DecisionSteps,
    TerminalSteps,
)
from netmq_example.wire import batches, records
from netmq_example.wire.records import Record, Section
from netmq_example.wire.sections import rewards_in


class PythonClock:
    """`given` are the spaces of agents whose scene says none, `limit` is how many steps an episode has, or 0."""

    def __init__(self, seed: int, channels_first: bool, limit: int, given: tuple[Any, Any]) -> None:
        self.seed = seed
        self.limit = limit
        self.channels_first = channels_first
        self.given = given
        self.specs = BehaviorMapping()
        self.turns: dict[str, Sequence[Any]] = {}
        self.scene: kinds.SceneHello | None = None
        self.behaviors: list[Behavior] = []

    def connected(self, hello: Message) -> None:
        scene = kinds.same_scene(kinds.read_hello(hello, take(hello.values, "name", str)), self.scene)
        if not self.scene:
            count = len(scene.agents)
            new_ids = itertools.count(count)
            try:
                self.behaviors = [Behavior(kind, self.given, self.channels_first, new_ids) for kind in scene.kinds]
            except ValueError as error:
                raise error if isinstance(error, MessageError) else MessageError("wrong-scene", str(error)) from None
            if len(scene.kinds) == 1:
                self.behaviors[0].name = f"{scene.name}?team=0"
            self.specs.update({behavior.name: behavior.spec for behavior in self.behaviors})
            self.episodes = Episodes(count, self.limit)
            self.episodes.plant(self.seed % 2**32, np.ones(count, bool))
            self.seeds = self.episodes.next.tobytes()
        self.scene = scene
        # The agents that are not in the scene, and those that have stepped last; None for none, and for all.
        self.away: Any = None
        self.stepping: Any = None

    def reset(self, ask: scene_clock.Ask) -> None:
        sections = [self.section(one, bytes([records.RESET]) * one.count) for one in self.behaviors]
        answer = ask(Record(records.ASKS, 0, sections))
        self.episodes.begun(range(self.episodes.count))
        self.read(answer, begins=True)

    def section(self, behavior: "Behavior", marks: bytes) -> Section:
        return Section(behavior.kind.at, self.seeds[8 * behavior.rows.start : 8 * behavior.rows.stop], marks)

    def step(self, ask: scene_clock.Ask, actions: Mapping[str, ActionTuple]) -> None:
        """ValueError names an action that is not in its space: nothing has moved then."""
        done = [one.batch(actions.get(one.name)) for one in self.behaviors]
        try:
            answer = ask(self.request(done))
        except MessageError as error:
            if error.code != "not-in-space":
                raise
            # Rounding may have taken it out of there.
            pairs = zip(self.behaviors, done, strict=True)
            answer = ask(self.request([one.actions.checked(one.actions.batch, each) for one, each in pairs]))
        if self.stepping is not None:
            self.episodes.draw(np.flatnonzero(~self.stepping))
        if self.limit or self.stepping is not None:
            self.episodes.stepped(self.stepping)
        self.read(answer, begins=False)

    def request(self, done: list[Any]) -> Record:
        marks, self.stepping = self.episodes.orders(None, self.away)
        sections = []
        for behavior, batch in zip(self.behaviors, done, strict=True):
            section = self.section(behavior, marks[behavior.rows] if marks else behavior.everybody)
            steps = None if self.stepping is None else self.stepping[behavior.rows]
            behavior.actions.put_batch(section, batch, steps)
            sections.append(section)
        return Record(records.ASKS, 0, sections, records.AUTORESET)

    def read(self, answer: Record, begins: bool) -> None:
        turns: dict[str, Sequence[Any]] = {}
        # By fewer calls of numpy, which is slow right after a wait.
        ends = {one.kind: one for one in answer.sections[len(self.behaviors) :] if one.columns & records.ENDED}
        for behavior, section in zip(self.behaviors, answer.sections, strict=False):
            last = ends.get(section.kind)
            turns[behavior.name] = behavior.turn(section, last, begins)
            if last:
                self.episodes.begun([behavior.kind.first + row for row in last.whose()])
        absent = any(behavior.absent for behavior in self.behaviors)
        self.away = np.concatenate([behavior.away for behavior in self.behaviors]) if absent else None
        self.turns = turns
        if begins or ends or self.stepping is not None:
            # Of the episodes that begin next.
            self.seeds = self.episodes.next.tobytes()


class Behavior:
    """The agents of one kind. MessageError says what ML-Agents has nothing for."""

    def __init__(self, kind: kinds.Kind, given: tuple[Any, Any], channels_first: bool, new_ids: Any) -> None:
        self.name = f"{kind.name}?team=0"
        self.kind = kind
        self.new_ids = new_ids
        self.count = len(kind.agents)
        self.rows = slice(kind.first, kind.first + self.count)
        self.everybody = bytes([records.STEP]) * self.count
        self.ids = np.arange(kind.first, kind.first + self.count, dtype=np.int32)
        # The last marks say which rows have no agent in the scene, whether there are any, and which have one.
        self.marks = bytes([records.SEEN]) * self.count
        self.away = np.zeros(self.count, bool)
        self.absent = False
        self.here: Any = slice(None)
        action = kinds.agreed(kind, "action", None if kind.action else given[1])
        self.actions = Actions(action, kind)
        self.nothing = batches.together(action, [batches.empty(action, kind.name)] * self.count)
        self.done = plain.Done(action)
        self.space = kinds.agreed(kind, "observation", None if kind.observation else given[0])
        self.rows_seen = observations_of(self.space, kind)
        self.seen = plain.Seen(self.space, sum(self.done.spec.discrete_branches), channels_first)
        self.spec = BehaviorSpec(self.seen.specs, self.done.spec)
        self.none_ended = TerminalSteps.empty(self.spec)

    def batch(self, action: ActionTuple | None) -> Any:
        """Actions of all rows, as Gymnasium batches them. Without them it is zeros, or what is nearest to them."""
        if action is None:
            return self.nothing
        if self.absent:
            given, action = action, self.done.spec.empty_action(self.count)
            action.continuous[self.here], action.discrete[self.here] = given.continuous, given.discrete
        return self.done.batch(action.continuous, action.discrete)

    def turn(self, section: Section, last: Section | None, begins: bool) -> tuple[DecisionSteps, TerminalSteps]:
        over = {*last.whose()} if last else NOBODY
        self.rows_seen.take(section, range(self.count) if begins else over)
        left, came = ([], []) if section.marks == self.marks else self.changed(section.marks)
        left = [] if begins else [row for row in left if row not in over]
        ended = self.ended(section, last, left) if last or left else self.none_ended
        # Another one in its place has an id of its own.
        for row in came:
            self.ids[row] = next(self.new_ids)
        batch = self.rows_seen.batch()
        seen = self.seen.split(batch)
        masks = self.masks(section, batch) if self.done.spec.discrete_branches else None
        ids, rewards = self.ids.copy(), np.array(rewards_in(section), np.float32)
        if self.absent:
            seen, ids, rewards = [part[self.here] for part in seen], ids[self.here], rewards[self.here]
        return DecisionSteps(seen, rewards, ids, masks, *scene_clock.no_groups(len(ids))), ended

    def changed(self, marks: bytes) -> tuple[list[int], list[int]]:
        """The rows whose agent has left, and those where one has come."""
        before, self.away = self.away, np.frombuffer(marks, np.uint8) & records.ABSENT > 0
        self.marks = marks
        self.absent = bool(self.away.any())
        self.here = np.flatnonzero(~self.away) if self.absent else slice(None)
        return np.flatnonzero(self.away & ~before).tolist(), np.flatnonzero(before & ~self.away).tolist()

    def masks(self, section: Section, batch: Any) -> list[Any]:
        """In ML-Agents True is forbidden, in Gymnasium 0."""
        branches = self.done.spec.discrete_branches
        size = sum(branches)
        if not (self.seen.masked or section.table):
            return [*scene_clock.all_allowed(len(self.ids[self.here]), branches)]
        block = np.zeros((self.count, size), bool)
        if self.seen.masked:
            block = batch[MASK].reshape(-1, size) == 0
        for row, data in section.each_info() if section.table else ():
            info = info_in(data)
            if MASK in info:
                allowed = np.concatenate([np.ravel(part) for part in info[MASK]], axis=None)
                if len(allowed) != size:
                    why = f"a mask of {self.name} has {size} choices, not {allowed!s:.80}"
                    raise MessageError("bad-info", why)
                block[row] = allowed == 0
        return scene_clock.branches_of(block[self.here], branches)

    def ended(self, section: Section, last: Section | None, left: list[int]) -> TerminalSteps:
        """Those that have ended, and behind them those that have left, as they were seen last."""
        who = [*last.whose()] if last else []
        if who and max(who) >= self.count:
            raise MessageError("bad-record", f"agent {max(who)} of {self.count} cannot have ended")
        rows = observations_of(self.space, self.kind)
        if last:
            rows.take(last)
        seen = [rows.one(row) for row in who] + [self.rows_seen.one(row) for row in left]
        rewards = [*(rewards_in(last) if last else ()), *(rewards_in(section)[row] for row in left)]
        # An end in the last step is no interruption; whoever leaves is interrupted, or has ended.
        ends = records.TERMINATED | records.TRUNCATED
        cut = [mark & ends == records.TRUNCATED for mark in (last.marks if last else b"")]
        cut += [not section.marks[row] & records.TERMINATED for row in left]
        batch = self.seen.split(batches.together(self.space, seen))
        groups = scene_clock.no_groups(len(cut))
        return TerminalSteps(batch, np.array(rewards, np.float32), np.array(cut), self.ids[who + left], *groups)
