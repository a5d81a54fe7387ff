"""Python's clock, that of lessons 09 to 11: at each step all agents of the scene act, and whoever ends begins anew.

An agent's id is its number among all agents of the scene, and another one that comes in its place has a new id. What is
done and seen in Gymnasium's spaces are floats and whole numbers here, and a float32 array for each array in them. It
needs gymnasium and numpy.
"""

import itertools
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Space

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

Spaces = tuple[Space[Any] | None, Space[Any] | None]


class PythonClock:
    """`given` are the spaces of agents whose scene says none, `limit` is how many steps an episode has, or 0."""

    def __init__(self, seed: int, channels_first: bool, limit: int, given: Spaces) -> None:
        self.seed = seed
        self.limit = limit
        self.channels_first = channels_first
        self.given = given
        self.specs = BehaviorMapping()
        self.turns: dict[str, scene_clock.Turn] = {}
        self.scene: kinds.SceneHello | None = None
        self.behaviors: list[Behavior] = []

    def connected(self, hello: Message) -> None:
        scene = kinds.same_scene(kinds.read_hello(hello, take(hello.values, "name", str)), self.scene)
        if not self.scene:
            count = len(scene.agents)
            new_ids = itertools.count(count)
            try:
                for kind in scene.kinds:
                    # Agents that are all of one kind are called as their scene.
                    name = f"{scene.name if len(scene.kinds) == 1 else kind.name}?team=0"
                    self.behaviors.append(Behavior(name, kind, self.given, self.channels_first, new_ids))
            except ValueError as error:
                raise error if isinstance(error, MessageError) else MessageError("wrong-scene", str(error)) from None
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
        self.read(answer, True)

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
            done = [
                one.actions.checked(one.actions.batch, each) for one, each in zip(self.behaviors, done, strict=True)
            ]
            answer = ask(self.request(done))
        if self.stepping is not None:
            self.episodes.draw(np.flatnonzero(~self.stepping))
        if self.limit or self.stepping is not None:
            self.episodes.stepped(self.stepping)
        self.read(answer, False)

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
        turns = {}
        self.away = None
        more = answer.sections[len(self.behaviors) :]
        ends = {one.kind: one for one in more if one.columns & records.ENDED} if more else {}
        for behavior, section in zip(self.behaviors, answer.sections, strict=False):
            last = ends.get(section.kind)
            turns[behavior.name] = behavior.turn(section, last, begins)
            if last:
                self.episodes.begun([behavior.kind.first + row for row in last.whose()])
            if behavior.here is not None:
                self.away = np.zeros(self.episodes.count, bool) if self.away is None else self.away
                self.away[behavior.rows] = behavior.away
        self.turns = turns
        if begins or ends or self.stepping is not None:
            # Of the episodes that begin next.
            self.seeds = self.episodes.next.tobytes()


class Behavior:
    """The agents of one kind. MessageError says what ML-Agents has nothing for."""

    def __init__(
        self, name: str, kind: kinds.Kind, given: Spaces, channels_first: bool, new_ids: Iterator[int]
    ) -> None:
        self.name = name
        self.kind = kind
        self.new_ids = new_ids
        self.count = len(kind.agents)
        self.rows = slice(kind.first, kind.first + self.count)
        self.everybody = bytes([records.STEP]) * self.count
        self.all_seen = bytes([records.SEEN]) * self.count
        self.ids = frozen(np.arange(kind.first, kind.first + self.count, dtype=np.int32))
        # The rows whose agent is not in the scene, and those of the DecisionSteps, None for all.
        self.away = np.zeros(self.count, bool)
        self.here: Any = None
        action = kinds.agreed(kind, "action", None if kind.action else given[1])
        self.actions = Actions(action, kind)
        self.nothing = batches.together(action, [batches.empty(action, name)] * self.count)
        self.done = plain.Done(action)
        self.branches = self.done.spec.discrete_branches
        self.space = kinds.agreed(kind, "observation", None if kind.observation else given[0])
        self.rows_seen = observations_of(self.space, kind)
        self.seen = plain.Seen(self.space, sum(self.branches), channels_first)
        self.spec = BehaviorSpec(self.seen.specs, self.done.spec)

    def batch(self, action: ActionTuple | None) -> Any:
        """Actions of all rows, as Gymnasium batches them. Without them it is zeros, or what is nearest to them."""
        if action is None:
            return self.nothing
        if self.here is not None:
            given = action
            action = self.done.spec.empty_action(self.count)
            action.continuous[self.here] = given.continuous
            action.discrete[self.here] = given.discrete
        return self.done.batch(action.continuous, action.discrete)

    def turn(self, section: Section, last: Section | None, begins: bool) -> scene_clock.Turn:
        ended = self.ended(last) if last else None
        everybody: Any = range(self.count)
        self.rows_seen.take(section, everybody if begins else {*last.whose()} if last else NOBODY)
        batch = self.rows_seen.batch()
        masks = self.masks(section, batch) if self.branches else None
        seen = self.seen.split(batch)
        rewards = scene_clock.rewards_of(section)
        if section.marks != self.all_seen or self.here is not None:
            marks = np.frombuffer(section.marks, np.uint8)
            away = marks & records.ABSENT > 0
            left = away & ~self.away
            if last:
                left[np.asarray(last.whose())] = False
            if left.any() and not begins:
                cut = marks[left] & records.TERMINATED == 0
                gone = terminal([part[left] for part in seen], rewards[left], cut, self.ids[left])
                ended = both(ended, gone) if ended else gone
            # Another one in its place has an id of its own.
            if (back := self.away & ~away).any():
                ids = self.ids.copy()
                ids[back] = list(itertools.islice(self.new_ids, int(back.sum())))
                self.ids = frozen(ids)
            self.away = away
            self.here = np.flatnonzero(~away) if away.any() else None
        ids = self.ids
        if self.here is not None:
            seen = [part[self.here] for part in seen]
            masks = masks and [mask[self.here] for mask in masks]
            rewards = rewards[self.here]
            ids = ids[self.here]
        return DecisionSteps(seen, rewards, ids, masks, *scene_clock.no_groups(len(ids))), ended

    def masks(self, section: Section, batch: Any) -> list[Any]:
        """In ML-Agents True is forbidden, in Gymnasium 0."""
        size = sum(self.branches)
        block = batch[MASK].reshape(-1, size) == 0 if self.seen.masked else scene_clock.all_allowed(self.count, size)
        for row, data in section.each_info() if section.table else ():
            info = info_in(data)
            if MASK in info:
                block = block if block.flags.writeable else block.copy()
                allowed = np.concatenate([np.ravel(part) for part in info[MASK]], axis=None)
                if len(allowed) != size:
                    why = f"a mask of {self.name} has {size} choices, not {allowed!s:.80}"
                    raise MessageError("bad-info", why)
                block[row] = allowed == 0
        return scene_clock.branches_of(block, self.branches)

    def ended(self, section: Section) -> TerminalSteps:
        who = np.asarray(section.whose())
        if int(who.max()) >= self.count:
            raise MessageError("bad-record", f"agent {who.max()} of {self.count} cannot have ended")
        seen = observations_of(self.space, self.kind)
        seen.take(section)
        batch = batches.together(self.space, [seen.one(row) for row in who.tolist()])
        marks = np.frombuffer(section.marks, np.uint8)
        # An end in the last step is no interruption.
        cut = marks & (records.TERMINATED | records.TRUNCATED) == records.TRUNCATED
        return terminal(self.seen.split(batch), scene_clock.rewards_of(section), cut, self.ids[who])


def frozen(ids: Any) -> Any:
    """All steps have the same ones, so that nobody may write into them."""
    ids.flags.writeable = False
    return ids


def terminal(seen: list[Any], rewards: Any, cut: Any, ids: Any) -> TerminalSteps:
    return TerminalSteps(seen, rewards, cut, ids, *scene_clock.no_groups(len(ids)))


def both(one: TerminalSteps, other: TerminalSteps) -> TerminalSteps:
    seen = [np.concatenate(parts) for parts in zip(one.obs, other.obs, strict=True)]
    rewards, cut = np.append(one.reward, other.reward), np.append(one.interrupted, other.interrupted)
    return terminal(seen, rewards, cut, np.append(one.agent_id, other.agent_id))
