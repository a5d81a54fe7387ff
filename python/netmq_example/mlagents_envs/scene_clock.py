"""The scene's clock: it says in each answer who wants an action and who has ended, and which behaviors are new.

A clock decides when an agent has its turn: environment.py steps by this one, or by Python's. `specs` and `turns` are by
behavior. wire/records.py has the columns. It needs numpy.
"""

import functools
import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from netmq_example.messages import Message, MessageError, take
from netmq_example.mlagents_envs import base_env
from netmq_example.mlagents_envs.base_env import ActionTuple, DecisionSteps, DimensionProperty, TerminalSteps
from netmq_example.wire import records, trees
from netmq_example.wire.records import Record, Section, bad
from netmq_example.wire.sections import rewards_in

Ask = Callable[[Record], Record]

EQUIVARIANT = DimensionProperty.TRANSLATIONAL_EQUIVARIANCE
# Of a picture [channels, height, width].
PICTURE = (DimensionProperty.NONE, EQUIVARIANT, EQUIVARIANT)


class SceneClock:
    def __init__(self, seed: int, channels_first: bool, limit: int, given: tuple[Any, Any]) -> None:
        if limit or given != (None, None):
            cure = "its agents have Max Step and spaces of their own in the scene"
            raise MessageError("scene-clock", f"max_episode_steps and spaces are for Python's clock: {cure}")
        self.seed = seed
        self.channels_first = channels_first
        self.specs = base_env.BehaviorMapping()

    def connected(self, hello: Message) -> None:
        """Take a simulator, the first one or another; MessageError says why it is refused."""
        if hello.values.get("clock") != "scene":
            raise MessageError("other-clock", "the simulator before this one had the scene's clock: start that again")
        # By number, which counts on as long as this simulator is here.
        self.behaviors: list[Any] = []

    @property
    def turns(self) -> dict[str, Sequence[Any]]:
        return {behavior.name: behavior.turn for behavior in self.behaviors}

    def reset(self, ask: Ask) -> None:
        self.read(ask(self.anew()))

    def anew(self, exchange: Any = b"") -> Record:
        # A simulator takes its seed once.
        said = b"" if self.behaviors else trees.write({"seed": self.seed})
        return Record(records.ASKS, 0, [], records.SCENE_CLOCK | records.ANEW, said, exchange)

    def step(self, ask: Ask, actions: Mapping[str, ActionTuple]) -> None:
        """Actions by behavior; where there are none, it is zeros."""
        sections = []
        for number, behavior in enumerate(self.behaviors):
            action = actions.get(behavior.name)
            if action is not None:
                count, values = len(action.continuous), behavior.written(action)
                sections.append(Section(number, bytes(8 * count), bytes([records.STEP]) * count, values=values))
        self.read(ask(Record(records.ASKS, 0, sections, records.SCENE_CLOCK, b"", b"")))

    def read(self, answer: Record) -> None:
        if not answer.bits & records.SCENE_CLOCK:
            raise MessageError("wrong-clock", "the answer is none of the scene's clock")
        for described in take(trees.read(answer.said), "kinds", list) if answer.said else ():
            self.add(described)
        for behavior in self.behaviors:
            behavior.begin()
        for section in answer.sections:
            if section.kind >= len(self.behaviors):
                raise MessageError("wrong-agents", f"there is no behavior {section.kind} of {len(self.behaviors)}")
            self.behaviors[section.kind].take(section)

    def add(self, described: Any) -> None:
        """A behavior that is new. Another simulator has the same ones as the one before it."""
        behavior = self.made(described)
        name = behavior.name
        if name in [other.name for other in self.behaviors]:
            raise MessageError("bad-kind", f"the behavior {name!a:.80} came twice")
        if self.specs.setdefault(name, behavior.spec) != behavior.spec:
            was = f"{self.specs[name]!s:.200}"
            raise MessageError("other-spaces", f"{name!a:.80} was {was}, and is {behavior.spec!s:.200}")
        self.behaviors.append(behavior)

    def made(self, described: Any) -> Any:
        return Behavior(described, self.channels_first)


class Behavior:
    """The rows of a behavior, as the scene describes them. `turn` are its decisions and its ends in the last step."""

    def __init__(self, described: Any, channels_first: bool) -> None:
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
        except (TypeError, ValueError, KeyError) as error:
            raise MessageError("bad-kind", f"{self.name!a:.80} cannot be read: {error!s:.100}") from None
        self.choices = sum(branches)
        self.pictures = [one["dtype"] == "uint8" for one in sensors]
        self.turned = [not channels_first and spec.dimension_property == PICTURE for spec in specs]
        specs = [channels_last(spec) if turned else spec for spec, turned in zip(specs, self.turned, strict=True)]
        self.spec = base_env.BehaviorSpec(specs, base_env.ActionSpec(floats, branches))
        self.nobody = DecisionSteps.empty(self.spec), TerminalSteps.empty(self.spec)

    def written(self, action: ActionTuple) -> bytes:
        rows = np.empty(len(action.continuous), self.action)
        rows["floats"] = action.continuous
        rows["branches"] = action.discrete
        return rows.tobytes()

    def begin(self) -> None:
        self.turn: list[Any] = [*self.nobody]

    def take(self, section: Section) -> None:
        count = len(section.marks)
        if not section.columns & records.IDS:
            raise bad("agents of the scene's clock have ids")
        ids = np.frombuffer(section.ids, np.int32).copy()
        groups = no_groups(count)
        if section.columns & records.GROUPS:
            columns = np.frombuffer(section.groups, np.int32).reshape(2, count).copy()
            groups = columns[0], columns[1].view(np.float32)
        seen, rewards = self.seen(section), np.array(rewards_in(section), np.float32)
        if section.columns & records.ENDED:
            cut = np.frombuffer(section.marks, np.uint8) & records.TRUNCATED > 0
            self.turn[1] = TerminalSteps(seen, rewards, cut, ids, *groups)
        else:
            self.turn[0] = DecisionSteps(seen, rewards, ids, self.masks(section), *groups)

    def masks(self, section: Section) -> list[Any] | None:
        count, choices = len(section.marks), self.choices
        branches = self.spec.action_spec.discrete_branches
        if not section.columns & records.MASKS:
            return [*all_allowed(count, branches)] if choices else None
        if len(section.masks) != count * choices:
            raise bad(f"masks of {self.name!a:.80} have {choices} choices")
        block = np.frombuffer(section.masks, np.uint8).reshape(count, choices) > 0
        return branches_of(block, branches) if choices else None

    def seen(self, section: Section) -> list[Any]:
        if len(section.values) != len(section.marks) * self.row.itemsize:
            raise MessageError("not-in-space", f"{len(section.values)} bytes are not those that {self.name!a:.80} sees")
        # Of no sensors numpy reads no rows.
        rows: Any = np.frombuffer(section.values, self.row) if self.pictures else None
        seen = []
        for at, (is_picture, turned) in enumerate(zip(self.pictures, self.turned, strict=True)):
            part = as_picture(rows[f"{at}"]) if is_picture else rows[f"{at}"].copy()
            seen.append(np.moveaxis(part, 1, -1) if turned else part)
        return seen


def sensor(described: Any) -> base_env.ObservationSpec:
    shape = tuple(described["shape"])
    properties = tuple(DimensionProperty(flag) for flag in described["properties"])
    if described["dtype"] not in ("float32", "uint8") or not shape or len(properties) != len(shape):
        raise ValueError(f"{described!a:.100} is no sensor")
    kind = base_env.ObservationType(described["type"])
    return base_env.ObservationSpec(shape, properties, kind, str(described["name"]))


def frozen(array: Any) -> Any:
    array.flags.writeable = False
    return array


# Each step has these, and numpy is slow right after a wait.
@functools.cache
def no_groups(count: int) -> tuple[Any, Any]:
    return frozen(np.zeros(count, np.int32)), frozen(np.zeros(count, np.float32))


@functools.cache
def all_allowed(count: int, branches: tuple[int, ...]) -> list[Any]:
    return branches_of(frozen(np.zeros((count, sum(branches)), bool)), branches)


def branches_of(block: Any, branches: tuple[int, ...]) -> list[Any]:
    """A mask for each branch, of all masks side by side."""
    ends = itertools.accumulate(branches)
    return [block[:, end - choices : end] for choices, end in zip(branches, ends, strict=True)]


def as_picture(part: Any) -> Any:
    return np.true_divide(part, np.float32(255), dtype=np.float32, order="C")


def channels_last(spec: base_env.ObservationSpec) -> base_env.ObservationSpec:
    """As ML-Agents had pictures before 2024."""
    first, *rest = spec.shape
    channels, *others = spec.dimension_property
    return spec._replace(shape=(*rest, first), dimension_property=(*others, channels))
