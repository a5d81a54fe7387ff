"""Actions of the agents of one kind, as the rows of a request.

    actions = Actions(space, kind)
    section = Section(kind.at, seeds, marks)
    actions.put_batch(section, batch)               those of all agents, as Gymnasium batches them
    actions.put(section, [action])                  one for each that steps

The side that has declared a space checks what is said in it. So what C# has declared is looked at here for its shape
and dtype alone: the simulator refuses the rest before anything moves.
"""

import contextlib
import functools
import importlib
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.error import CustomSpaceError
from gymnasium.spaces import Space
from gymnasium.vector.utils import batch_space, iterate

from netmq_example.envs.kinds import Kind
from netmq_example.json_text import ENCODER
from netmq_example.messages import MessageError
from netmq_example.wire import trees
from netmq_example.wire.records import FORM, Section
from netmq_example.wire.sections import with_sizes
from netmq_example.wire.space_bytes import Bytes
from netmq_example.wire.spaces import REASONS, Numbers, shown

# So far outside of its limits an action may be, in steps of its dtype: rounding did it.
ULPS = 4


class Actions:
    """`checks`: here, and not by the simulator."""

    def __init__(self, space: Space[Any], kind: Kind, checks: bool = False) -> None:
        self.space = space
        self.count = len(kind.agents)
        self.name = kind.name
        self.values = kind.action is None
        self.checks = checks or self.values
        self.bytes = Bytes(space)
        # By name: it is for those who have attributes.
        self.plan: Any = importlib.import_module("netmq_example.envs.plan") if self.values else None
        # As values they have a form. Where it is always the same, and of one size, it is said once for all rows.
        form = self.plan.form_in(space) if self.plan and self.bytes.size else None
        self.form = b"" if form is None else ENCODER.encode(form).encode()
        codec = self.bytes.codec
        # One array alone, as most have, is put with fewer calls of numpy.
        self.array = codec if isinstance(codec, Numbers) and codec.size and not self.values else None
        self.blocks = bool(self.bytes.size) and (bool(self.form) or not self.values)

    @functools.cached_property
    def batch(self) -> Space[Any]:
        return batch_space(self.space, self.count)

    def put(self, section: Section, actions: Sequence[Any]) -> None:
        """As they are: whether they are in the space, `checked` says. ValueError names one that cannot be there."""
        try:
            rows = [self.row(action) for action in actions]
        except REASONS as error:
            wrong = next((action for action in actions if action not in self.space), actions[0])
            raise self.refused(self.space, wrong, error) from None
        self.say_form(section)
        with_sizes(section, rows)

    def row(self, action: Any) -> bytes:
        if self.values and not self.form:
            return trees.write(self.plan.fitted(self.space, action, f"action of {self.name}"))
        return self.bytes.write(action)

    def put_batch(self, section: Section, batch: Any, steps: Any = None) -> None:
        """`steps` says which agents step, all of them without it."""
        if self.checks:
            batch = self.checked(self.batch, batch)
        if self.array:
            array = np.asarray(batch)
            if array.dtype == self.array.dtype and array.shape == (self.count, *self.array.shape):
                section.values = (array if steps is None else array[steps]).tobytes()
                return
        try:
            if self.blocks:
                blocks: list[Any] = []
                self.bytes.codec.write_block(self.count, batch, blocks)
                block = blocks[0] if len(blocks) == 1 else np.concatenate(blocks, axis=1)
                self.say_form(section)
                section.values = (block if steps is None else block[steps]).tobytes()
                return
            rows = [self.row(action) for action in iterate(self.batch, batch)]
        except (*REASONS, CustomSpaceError) as error:
            raise self.refused(self.batch, batch, error) from None
        if len(rows) != self.count:
            raise self.refused(self.batch, batch)
        self.say_form(section)
        with_sizes(section, rows if steps is None else [row for row, step in zip(rows, steps, strict=True) if step])

    def say_form(self, section: Section) -> None:
        if self.values and self.form:
            section.columns |= FORM
            section.form = self.form

    def checked(self, space: Space[Any], action: Any) -> Any:
        """The action, or what it was before it was rounded."""
        if action in space:
            return action
        near = nearest(space, action)
        if near is None and self.plan and space is not self.batch:
            # A number for an array of one, and whatever else loses nothing.
            with contextlib.suppress(MessageError):
                return self.plan.fitted(space, action, "action")
        if near is None:
            raise self.refused(space, action)
        return near

    def refused(self, space: Space[Any], action: Any, error: Exception | None = None) -> Exception:
        if isinstance(error, MessageError) and action in space:
            return error
        # One agent's own space is a copy.
        words = "action {} is" if space == self.space else "actions {} are"
        place, part, wrong = misplaced(space, action)
        return ValueError(f"{words.format(place + shown(wrong))} not in {shown(part)}")

    def asked(self, ask: Callable[[Any], Any], space: Space[Any], action: Any) -> Any:
        """`ask(action)`, and once more if the simulator refuses what rounding alone has taken out of the space."""
        try:
            return ask(action)
        except MessageError as error:
            if error.code != "not-in-space" or self.checks or action in space:
                raise
            near = nearest(space, action)
            if near is None:
                raise self.refused(space, action) from None
        return ask(near)


def misplaced(space: Any, action: Any, place: str = "") -> tuple[str, Any, Any]:
    """Where in an action it is that does not fit, its space, and what stands there."""
    for key, part, item in parts_in(space, action) or ():
        if item not in part:
            return misplaced(part, item, f"{place}[{key!r}]")
    return f"{place}: " if place else "", space, action


def parts_in(space: Any, action: Any) -> list[tuple[Any, Any, Any]] | None:
    """Keys, each with its space and what is done there; None where the action has other ones, or there are none."""
    if isinstance(space, spaces.Dict) and isinstance(action, dict) and action.keys() == space.spaces.keys():
        return [(key, space[key], item) for key, item in action.items()]
    if isinstance(space, spaces.Tuple) and isinstance(action, tuple | list) and len(action) == len(space):
        return [(at, part, action[at]) for at, part in enumerate(space)]
    return None


def nearest(space: Any, action: Any) -> Any:
    """What is in the space, and no more than rounding away; else None."""
    match space:
        case spaces.Box() if space.dtype.kind == "f":
            try:
                given = np.asarray(action)
                if given.shape != space.shape or given.dtype.kind not in "biuf":
                    return None
                limited = np.clip(given.astype(space.dtype), space.low, space.high)
                # A float32 may be as far from a limit of float64 as it is exact.
                coarse = np.float32 if given.dtype == np.float32 else space.dtype
                far = np.abs(given - limited) > ULPS * np.spacing(np.abs(limited).astype(coarse))
            except REASONS:
                return None
            # NaN is near nothing.
            return None if far.any() or np.isnan(limited).any() else limited
        case spaces.Dict() | spaces.Tuple():
            parts = parts_in(space, action)
            near = {key: nearest(part, item) for key, part, item in parts or ()}
            if parts is None or any(one is None for one in near.values()):
                return None
            return near if isinstance(space, spaces.Dict) else tuple(near.values())
    return action if action in space else None
