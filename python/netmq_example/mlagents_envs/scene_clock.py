"""The scene's clock: it says in each answer who wants an action and who has ended, and which behaviors are new.

A clock decides when an agent has its turn: environment.py steps by this one, or by Python's. `specs` and `turns` are by
behavior. wire/records.py has the columns. It needs numpy.
"""

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from netmq_example.messages import Message, MessageError, take
from netmq_example.mlagents_envs import base_env
from netmq_example.mlagents_envs.base_env import ActionTuple, DecisionSteps, DimensionProperty, TerminalSteps
from netmq_example.wire import records, trees
from netmq_example.wire.records import Record, Section, bad
from netmq_example.wire.sections import rewards_in

Ask = Callable[[Record], Record]
# None: of nobody.
Turn = tuple[DecisionSteps | None, TerminalSteps | None]

EQUIVARIANT = DimensionProperty.TRANSLATIONAL_EQUIVARIANCE
# Of a picture [channels, height, width].
PICTURE = (DimensionProperty.NONE, EQUIVARIANT, EQUIVARIANT)
# So few rewards Python reads faster than numpy, which is slow right after a wait.
FEW = 32


class SceneClock:
    def __init__(self, seed: int, channels_first: bool, limit: int, given: tuple[Any, Any]) -> None:
        if limit or given != (None, None):
            cure = "its agents have Max Step and spaces of their own in the scene"
            raise MessageError("scene-clock", f"max_episode_steps and spaces are for Python's clock: {cure}")
        self.seed = seed
        self.channels_first = channels_first
        self.specs = base_env.BehaviorMapping()
        self.turns: dict[str, Turn] = {}
        # By number, which counts on as long as this simulator is here.
        self.behaviors: list[Behavior] = []
        self.begun = False

    def connected(self, hello: Message) -> None:
        """Take a simulator, the first one or another; MessageError says why it is refused."""
        if hello.values.get("clock") != "scene":
            raise MessageError("other-clock", "the simulator before this one had the scene's clock: start that again")
        self.behaviors = []
        self.turns = {}
        self.begun = False

    def reset(self, ask: Ask) -> None:
        # A simulator takes its seed once.
        said = b"" if self.begun else trees.write({"seed": self.seed})
        self.read(ask(Record(records.ASKS, 0, [], records.SCENE_CLOCK | records.ANEW, said, b"")))

    def step(self, ask: Ask, actions: Mapping[str, ActionTuple]) -> None:
        """Actions by behavior; where there are none, it is zeros."""
        sections = []
        for number, behavior in enumerate(self.behaviors):
            action = actions.get(behavior.name)
            if action is not None and (count := len(action.continuous)):
                values = behavior.written(action)
                sections.append(Section(number, bytes(8 * count), bytes([records.STEP]) * count, values=values))
        self.read(ask(Record(records.ASKS, 0, sections, records.SCENE_CLOCK, b"", b"")))

    def read(self, answer: Record) -> None:
        if not answer.bits & records.SCENE_CLOCK:
            raise MessageError("wrong-clock", "the answer is none of the scene's clock")
        if answer.said:
            self.add(trees.read(answer.said))
        turns: dict[str, Turn] = {}
        for section in answer.sections:
            if section.kind >= len(self.behaviors):
                raise MessageError("wrong-agents", f"there is no behavior {section.kind} of {len(self.behaviors)}")
            behavior = self.behaviors[section.kind]
            now, ended = turns.get(behavior.name, (None, None))
            if section.columns & records.ENDED:
                ended = behavior.ended(section)
            else:
                now = behavior.decisions(section)
            turns[behavior.name] = now, ended
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
            if any(type(size) is not int or size < 1 for size in branches):
                raise ValueError(f"a branch has at least one choice, not {branches}")
            self.choices = sum(branches)
        except (TypeError, ValueError, KeyError) as error:
            raise MessageError("bad-kind", f"{self.name!a:.80} cannot be read: {error!s:.100}") from None
        self.pictures = [one["dtype"] == "uint8" for one in sensors]
        # One array of floats alone, as most have, is read with fewer calls of numpy.
        self.vector = specs[0].shape if self.pictures == [False] else ()
        self.turned = [not channels_first and spec.dimension_property == PICTURE for spec in specs]
        specs = [channels_last(spec) if turned else spec for spec, turned in zip(specs, self.turned, strict=True)]
        self.spec = base_env.BehaviorSpec(specs, base_env.ActionSpec(floats, branches))

    def written(self, action: ActionTuple) -> bytes:
        if not self.choices:
            return np.asarray(action.continuous, np.float32).tobytes()
        rows = np.empty(len(action.continuous), self.action)
        rows["floats"] = action.continuous
        rows["branches"] = action.discrete
        return rows.tobytes()

    def decisions(self, section: Section) -> DecisionSteps:
        masks, count = None, len(section.marks)
        if self.choices:
            block = all_allowed(count, self.choices)
            if section.columns & records.MASKS:
                if len(section.masks) != count * self.choices:
                    raise bad(f"masks of {self.name!a:.80} have {self.choices} choices")
                block = np.frombuffer(section.masks, np.uint8).reshape(count, self.choices) > 0
            masks = branches_of(block, self.spec.action_spec.discrete_branches)
        ids, groups, group_rewards = self.who(section)
        return DecisionSteps(self.seen(section), rewards_of(section), ids, masks, groups, group_rewards)

    def ended(self, section: Section) -> TerminalSteps:
        cut = np.frombuffer(section.marks, np.uint8) & records.TRUNCATED > 0
        ids, groups, group_rewards = self.who(section)
        return TerminalSteps(self.seen(section), rewards_of(section), cut, ids, groups, group_rewards)

    def who(self, section: Section) -> tuple[Any, Any, Any]:
        """Ids, groups and their rewards."""
        count = len(section.marks)
        if not section.columns & records.IDS:
            raise bad("agents of the scene's clock have ids")
        ids = np.frombuffer(section.ids, np.int32).copy()
        if not section.columns & records.GROUPS:
            return ids, *no_groups(count)
        groups = np.frombuffer(section.groups, np.int32, count).copy()
        return ids, groups, np.frombuffer(section.groups, np.float32, count, 4 * count).copy()

    def seen(self, section: Section) -> list[Any]:
        if len(section.values) != len(section.marks) * self.row.itemsize:
            raise MessageError("not-in-space", f"{len(section.values)} bytes are not those that {self.name!a:.80} sees")
        if self.vector:
            return [np.ndarray((len(section.marks), *self.vector), np.float32, section.values).copy()]
        # Of no sensors numpy reads no rows.
        rows: Any = np.frombuffer(section.values, self.row) if self.pictures else None
        seen = []
        for at, (is_picture, turned) in enumerate(zip(self.pictures, self.turned, strict=True)):
            part = rows[f"{at}"]
            part = as_picture(part) if is_picture else part.copy()
            seen.append(np.moveaxis(part, 1, -1) if turned else part)
        return seen


def sensor(described: Any) -> base_env.ObservationSpec:
    shape = tuple(described["shape"])
    if described["dtype"] not in ("float32", "uint8") or not shape or min(shape) < 0:
        raise ValueError(f"{described!a:.100} is no sensor")
    properties = tuple(DimensionProperty(flag) for flag in described["properties"])
    if len(properties) != len(shape):
        raise ValueError(f"{described!a:.100} has not a property for each dimension")
    kind = base_env.ObservationType(described["type"])
    return base_env.ObservationSpec(shape, properties, kind, str(described["name"]))


def rewards_of(section: Section) -> Any:
    if len(section.marks) < FEW:
        return np.array(rewards_in(section), np.float32)
    rewards = np.frombuffer(section.numbers, np.float64).astype(np.float32)
    if not math.isfinite(rewards.sum()):
        raise MessageError("bad-reward", f"the rewards are {rewards!s:.80}")
    return rewards


@functools.cache
def no_groups(count: int) -> tuple[Any, Any]:
    """Groups, and their rewards. They are everybody's, so that nobody may write into them."""
    groups, rewards = np.zeros(count, np.int32), np.zeros(count, np.float32)
    groups.flags.writeable = rewards.flags.writeable = False
    return groups, rewards


@functools.cache
def all_allowed(count: int, choices: int) -> Any:
    """A mask that is everybody's as well."""
    block = np.zeros((count, choices), bool)
    block.flags.writeable = False
    return block


def branches_of(block: Any, branches: tuple[int, ...]) -> list[Any]:
    """A mask for each branch, of all masks side by side."""
    if len(branches) == 1:
        return [block]
    masks = []
    at = 0
    for choices in branches:
        masks.append(block[:, at : at + choices])
        at += choices
    return masks


def as_picture(part: Any) -> Any:
    """Bytes as numbers from 0 to 1."""
    return np.true_divide(part, np.float32(255), dtype=np.float32, order="C")


def channels_last(spec: base_env.ObservationSpec) -> base_env.ObservationSpec:
    """As ML-Agents had pictures before 2024."""
    first, *rest = spec.shape
    channels, *others = spec.dimension_property
    return spec._replace(shape=(*rest, first), dimension_property=(*others, channels))
