"""Python's clock, that of lessons 09 to 11: at each step all agents of the scene act, and whoever ends begins anew.

An agent's id is its number among all agents of the scene, and another one that comes in its place has a new id. It
needs gymnasium and numpy.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Space

from netmq_example.envs.actions import Actions, nearest
from netmq_example.envs.episodes import Episodes
from netmq_example.envs.kinds import Kind, SceneHello, agreed, read_hello, same_scene
from netmq_example.envs.remote import MASK, info_in
from netmq_example.messages import Message, MessageError, take
from netmq_example.mlagents_envs.clock import Clock, Turn, branches_of, rewards_of
from netmq_example.mlagents_envs.plain import Done, Seen
from netmq_example.mlagents_envs.rows import rows_of
from netmq_example.mlagents_envs.specs import ActionTuple, BehaviorSpec
from netmq_example.mlagents_envs.steps import DecisionSteps, TerminalSteps
from netmq_example.wire import records
from netmq_example.wire.batches import empty, together
from netmq_example.wire.records import Record, Section

NewIds = Callable[[int], Any]
Spaces = tuple[Space[Any] | None, Space[Any] | None]


class PythonClock(Clock):
    """`given` are the spaces of agents whose scene says none, `limit` is how many steps an episode has, or 0."""

    def __init__(self, seed: int, limit: int, channels_first: bool, given: Spaces) -> None:
        super().__init__()
        self.seed = seed
        self.limit = limit
        self.channels_first = channels_first
        self.given = given
        self.scene: SceneHello | None = None
        self.behaviors: list[Behavior] = []

    def connected(self, hello: Message) -> None:
        scene = same_scene(read_hello(hello, take(hello.values, "name", str)), self.scene)
        if not self.scene:
            try:
                # Agents that are all of one kind are called as their scene.
                names = [scene.name] if len(scene.kinds) == 1 else [kind.name for kind in scene.kinds]
                self.behaviors = [
                    Behavior(f"{name}?team=0", kind, self.given, self.channels_first)
                    for name, kind in zip(names, scene.kinds, strict=True)
                ]
            except ValueError as error:
                raise error if isinstance(error, MessageError) else MessageError("wrong-scene", str(error)) from None
            self.specs.update({behavior.name: behavior.spec for behavior in self.behaviors})
            self.episodes = Episodes(len(scene.agents), self.limit)
            self.episodes.plant(self.seed % 2**32, np.ones(len(scene.agents), bool))
            self.next_id = len(scene.agents)
        self.scene = scene
        self.away: Any = None
        self.stepping: Any = None

    def reset(self) -> Record:
        orders = {behavior: bytes([records.RESET]) * behavior.count for behavior in self.behaviors}
        return Record(records.ASKS, 0, [self.section(*each) for each in orders.items()])

    def section(self, behavior: "Behavior", marks: bytes) -> Section:
        kind = behavior.kind
        return Section(kind.at, self.episodes.next[behavior.rows].tobytes(), marks)

    def step(self, actions: Mapping[str, ActionTuple]) -> Record:
        return self.stepped({one.name: one.batch(actions.get(one.name)) for one in self.behaviors})

    def stepped(self, batches: Mapping[str, Any]) -> Record:
        marks, self.stepping = self.episodes.orders(None, self.away)
        self.batches = batches
        sections = []
        for behavior in self.behaviors:
            section = self.section(behavior, marks[behavior.rows] if marks else behavior.everybody)
            steps = None if self.stepping is None else self.stepping[behavior.rows]
            behavior.actions.put_batch(section, batches[behavior.name], steps)
            sections.append(section)
        return Record(records.ASKS, 0, sections, records.AUTORESET)

    def limited(self) -> Record | None:
        pairs = {one.name: (one.actions, self.batches[one.name]) for one in self.behaviors}
        if all(batch in actions.batch for actions, batch in pairs.values()):
            return None
        near = {name: nearest(actions.batch, batch) for name, (actions, batch) in pairs.items()}
        for name, (actions, batch) in pairs.items():
            if near[name] is None:
                raise ValueError(str(actions.refused(actions.batch, batch)))
        return self.stepped(near)

    def read(self, answer: Record, begins: bool) -> None:
        episodes = self.episodes
        if begins:
            episodes.begun(range(episodes.count))
        elif self.stepping is not None:
            episodes.draw(np.flatnonzero(~self.stepping))
        if not begins and (episodes.limit or self.stepping is not None):
            episodes.stepped(self.stepping)
        count = len(self.behaviors)
        last = {one.kind: one for one in answer.sections[count:] if one.columns & records.ENDED}
        turns = {}
        for behavior, section in zip(self.behaviors, answer.sections, strict=False):
            ended = last.get(section.kind)
            turns[behavior.name] = behavior.turn(section, ended, begins, self.new_ids)
            if ended:
                episodes.begun([behavior.kind.first + row for row in ended.whose()])
        self.turns = turns
        self.away = None
        if any(behavior.away is not None for behavior in self.behaviors):
            self.away = np.concatenate([behavior.is_away() for behavior in self.behaviors])

    def new_ids(self, count: int) -> Any:
        self.next_id += count
        return np.arange(self.next_id - count, self.next_id, dtype=np.int32)


class Behavior:
    """The agents of one kind."""

    def __init__(self, name: str, kind: Kind, given: Spaces, channels_first: bool) -> None:
        self.kind = kind
        self.name = name
        self.count = len(kind.agents)
        self.rows = slice(kind.first, kind.first + self.count)
        observation = agreed(kind, "observation", None if kind.observation else given[0])
        action = agreed(kind, "action", None if kind.action else given[1])
        self.done = Done(action)
        self.plain = Seen(observation, self.done.spec, channels_first)
        self.spec = BehaviorSpec(self.plain.specs, self.done.spec)
        self.actions = Actions(action, kind)
        self.seen = rows_of(kind, observation, self.plain)
        self.nothing = together(action, [empty(action, name)] * self.count)
        self.everybody = bytes([records.STEP]) * self.count
        self.all_seen = bytes([records.SEEN]) * self.count
        self.choices = sum(self.done.spec.discrete_branches)
        self.ids = np.arange(kind.first, kind.first + self.count, dtype=np.int32)
        # The rows whose agent is not in the scene, None for none, and those of the DecisionSteps, None for all.
        self.away: Any = None
        self.here: Any = None

    def batch(self, action: ActionTuple | None) -> Any:
        """Actions of all rows. Without them it is zeros, or what is nearest to them."""
        if action is None:
            return self.nothing
        if self.here is not None:
            given, action = action, self.done.spec.empty_action(self.count)
            action.continuous[self.here] = given.continuous
            action.discrete[self.here] = given.discrete
        return self.done.batch(action.continuous, action.discrete)

    def turn(self, section: Section, last: Section | None, begins: bool, new_ids: NewIds) -> Turn:
        who, ended = None, None
        if last:
            who = np.asarray(last.whose())
            ended = self.ended(last, who)
        parts = self.seen.take(section, begins, who)
        seen = self.plain.split(parts)
        rewards = rewards_of(section)
        masks = self.masks(section, parts) if self.choices else None
        if section.marks != self.all_seen or self.away is not None:
            left = self.changed(np.frombuffer(section.marks, np.uint8), new_ids)
            known = [] if ended is None else ended.agent_id.tolist()
            rows = [row for row in np.flatnonzero(left).tolist() if not begins and self.ids[row] not in known]
            if rows:
                cut = np.frombuffer(section.marks, np.uint8)[rows] & records.TERMINATED == 0
                gone = terminal([part[rows] for part in seen], rewards[rows], cut, self.ids[rows])
                ended = gone if ended is None else both(ended, gone)
        if self.here is None:
            return Turn(decisions(seen, rewards, self.ids.copy(), masks), ended)
        some = masks and [mask[self.here] for mask in masks]
        here = [part[self.here] for part in seen]
        return Turn(decisions(here, rewards[self.here], self.ids[self.here], some), ended)

    def is_away(self) -> Any:
        return np.zeros(self.count, bool) if self.away is None else self.away

    def changed(self, marks: Any, new_ids: NewIds) -> Any:
        """The rows whose agent has left just now. Another one in its place has an id of its own."""
        before = self.is_away()
        away = marks & records.ABSENT > 0
        back = before & ~away
        if back.any():
            self.ids[back] = new_ids(int(back.sum()))
        self.away = away if away.any() else None
        self.here = None if self.away is None else np.flatnonzero(~away)
        return away & ~before

    def masks(self, section: Section, parts: list[Any]) -> list[Any] | None:
        """In ML-Agents True is forbidden, in Gymnasium 0."""
        block = self.plain.allowed(parts) == 0 if self.plain.masks else np.zeros((self.count, self.choices), bool)
        for row, data in section.each_info() if section.table else ():
            info = info_in(data)
            if MASK in info:
                allowed = np.concatenate([np.ravel(part) for part in info[MASK]], axis=None)
                if allowed.shape != (self.choices,):
                    raise MessageError(
                        "bad-info", f"a mask of {self.name} has {self.choices} choices, not {allowed!s:.80}"
                    )
                block[row] = allowed == 0
        return branches_of(block, self.done.spec.discrete_branches)

    def ended(self, section: Section, who: Any) -> TerminalSteps:
        if int(who.max()) >= self.count:
            raise MessageError("bad-record", f"agent {who.max()} of {self.count} cannot have ended")
        seen = self.plain.split(self.seen.last(section))
        marks = np.frombuffer(section.marks, np.uint8)
        # An end in the last step is no interruption.
        cut = marks & (records.TERMINATED | records.TRUNCATED) == records.TRUNCATED
        return terminal(seen, rewards_of(section), cut, self.ids[who])


def decisions(seen: list[Any], rewards: Any, ids: Any, masks: list[Any] | None) -> DecisionSteps:
    count = len(ids)
    return DecisionSteps(seen, rewards, ids, masks, np.zeros(count, np.int32), np.zeros(count, np.float32))


def terminal(seen: list[Any], rewards: Any, cut: Any, ids: Any) -> TerminalSteps:
    count = len(ids)
    return TerminalSteps(seen, rewards, cut, ids, np.zeros(count, np.int32), np.zeros(count, np.float32))


def both(one: TerminalSteps, other: TerminalSteps) -> TerminalSteps:
    seen = [np.concatenate(parts) for parts in zip(one.obs, other.obs, strict=True)]
    rewards, cut = np.append(one.reward, other.reward), np.append(one.interrupted, other.interrupted)
    return terminal(seen, rewards, cut, np.append(one.agent_id, other.agent_id))
