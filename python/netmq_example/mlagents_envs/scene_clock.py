"""The scene's clock: it says in each answer who wants an action and who has ended, and which behaviors are new.

wire/records.py has the columns. It needs numpy.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from netmq_example.messages import Message, MessageError, take
from netmq_example.mlagents_envs.clock import PICTURE, Clock, Turn, as_picture, branches_of, channels_last, rewards_of
from netmq_example.mlagents_envs.specs import (
    ActionSpec,
    ActionTuple,
    BehaviorSpec,
    DimensionProperty,
    ObservationSpec,
    ObservationType,
)
from netmq_example.mlagents_envs.steps import DecisionSteps, TerminalSteps
from netmq_example.wire import records, trees
from netmq_example.wire.records import Record, Section, bad


class SceneClock(Clock):
    def __init__(self, seed: int, channels_first: bool) -> None:
        super().__init__()
        self.seed = seed
        self.channels_first = channels_first
        # By number, which counts on as long as this simulator is here.
        self.behaviors: list[Behavior] = []
        self.begun = False

    def connected(self, hello: Message) -> None:
        self.behaviors = []
        self.turns = {}
        self.begun = False

    def reset(self) -> Record:
        # A simulator takes its seed once.
        said = b"" if self.begun else trees.write({"seed": self.seed})
        return Record(records.ASKS, 0, [], records.SCENE_CLOCK | records.ANEW, said, b"")

    def step(self, actions: Mapping[str, ActionTuple]) -> Record:
        sections = []
        for number, behavior in enumerate(self.behaviors):
            decisions = self.turns[behavior.name].decisions
            if behavior.name in actions and decisions is not None and (count := len(decisions)):
                values = behavior.written(actions[behavior.name])
                sections.append(Section(number, bytes(8 * count), bytes([records.STEP]) * count, values=values))
        return Record(records.ASKS, 0, sections, records.SCENE_CLOCK, b"", b"")

    def read(self, answer: Record, begins: bool) -> None:
        if not answer.bits & records.SCENE_CLOCK:
            raise MessageError("wrong-clock", "the answer is none of the scene's clock")
        if answer.said:
            self.add(trees.read(answer.said))
        turns = {behavior.name: Turn() for behavior in self.behaviors}
        for section in answer.sections:
            if section.kind >= len(self.behaviors):
                raise MessageError("wrong-agents", f"there is no behavior {section.kind} of {len(self.behaviors)}")
            behavior = self.behaviors[section.kind]
            turn = turns[behavior.name]
            if section.columns & records.ENDED:
                turn.ended = behavior.ended(section)
            else:
                turn.decisions = behavior.decisions(section)
        self.turns = turns
        self.begun = True

    def add(self, said: Any) -> None:
        """The behaviors that are new. Another simulator has the same ones as the one before it."""
        for described in take(said if isinstance(said, dict) else {}, "kinds", list):
            behavior = Behavior(described, self.channels_first)
            name = behavior.name
            if name in [other.name for other in self.behaviors]:
                raise MessageError("bad-kind", f"the behavior {name!a:.80} came twice")
            if self.specs.setdefault(name, behavior.spec) != behavior.spec:
                was = f"{self.specs[name]!s:.200}"
                raise MessageError("other-spaces", f"{name!a:.80} was {was}, and is {behavior.spec!s:.200}")
            self.behaviors.append(behavior)


class Behavior:
    """The rows of a behavior, as the scene describes them."""

    def __init__(self, described: Any, channels_first: bool) -> None:
        if not isinstance(described, dict):
            raise MessageError("bad-kind", f"a behavior is a dict, not {described!a:.40}")
        self.name = f"{take(described, 'name', str)}?team={take(described, 'team', int)}"
        floats = take(described, "continuous", int)
        branches = tuple(take(described, "branches", list))
        sensors = take(described, "sensors", list)
        try:
            specs = [sensor(one) for one in sensors]
            self.row = np.dtype([(f"{at}", one["dtype"], tuple(one["shape"])) for at, one in enumerate(sensors)])
            self.action = np.dtype([("floats", np.float32, (floats,)), ("branches", np.int32, (len(branches),))])
            self.choices = sum(branches)
        except (TypeError, ValueError, KeyError) as error:
            raise MessageError("bad-kind", f"{self.name!a:.80} cannot be read: {error!s:.100}") from None
        self.fields = [(f"{at}", one["dtype"] == "uint8") for at, one in enumerate(sensors)]
        self.turned = [not channels_first and spec.dimension_property == PICTURE for spec in specs]
        specs = [channels_last(spec) if turned else spec for spec, turned in zip(specs, self.turned, strict=True)]
        self.spec = BehaviorSpec(specs, ActionSpec(floats, branches))

    def written(self, action: ActionTuple) -> bytes:
        rows = np.empty(len(action.continuous), self.action)
        rows["floats"] = action.continuous
        rows["branches"] = action.discrete
        return rows.tobytes()

    def decisions(self, section: Section) -> DecisionSteps:
        ids, groups, group_rewards = self.who(section)
        masks = None
        if self.choices:
            count = len(section.marks)
            block = np.zeros((count, self.choices), bool)
            if section.columns & records.MASKS:
                if len(section.masks) != block.size:
                    raise bad(f"masks of {self.name!a:.80} have {self.choices} choices")
                block = np.frombuffer(section.masks, np.uint8).reshape(block.shape) > 0
            masks = branches_of(block, self.spec.action_spec.discrete_branches)
        return DecisionSteps(self.seen(section), rewards_of(section), ids, masks, groups, group_rewards)

    def ended(self, section: Section) -> TerminalSteps:
        ids, groups, group_rewards = self.who(section)
        cut = np.frombuffer(section.marks, np.uint8) & records.TRUNCATED > 0
        return TerminalSteps(self.seen(section), rewards_of(section), cut, ids, groups, group_rewards)

    def who(self, section: Section) -> tuple[Any, Any, Any]:
        """Ids, groups and their rewards."""
        count = len(section.marks)
        if not section.columns & records.IDS:
            raise bad("agents of the scene's clock have ids")
        ids = np.frombuffer(section.ids, np.int32).copy()
        if not section.columns & records.GROUPS:
            return ids, np.zeros(count, np.int32), np.zeros(count, np.float32)
        groups = np.frombuffer(section.groups, np.int32, count).copy()
        return ids, groups, np.frombuffer(section.groups, np.float32, count, 4 * count).copy()

    def seen(self, section: Section) -> list[Any]:
        if len(section.values) != len(section.marks) * self.row.itemsize:
            raise MessageError("not-in-space", f"{len(section.values)} bytes are not those that {self.name!a:.80} sees")
        if not self.fields:
            return []
        rows = np.frombuffer(section.values, self.row)
        seen = [as_picture(rows[field]) if is_bytes else rows[field].copy() for field, is_bytes in self.fields]
        return [np.moveaxis(one, 1, -1) if turned else one for one, turned in zip(seen, self.turned, strict=True)]


def sensor(described: Any) -> ObservationSpec:
    shape = tuple(described["shape"])
    if described["dtype"] not in ("float32", "uint8") or not shape or min(shape) < 0:
        raise ValueError(f"{described!a:.100} is no sensor")
    properties = tuple(DimensionProperty(flag) for flag in described["properties"])
    if len(properties) != len(shape):
        raise ValueError(f"{described!a:.100} has not a property for each dimension")
    return ObservationSpec(shape, properties, ObservationType(described["type"]), str(described["name"]))
