"""Values from a scene become an observation by a plan, which is made once for each form of them.

    sight = Sight("car", space)
    sight.read(form, numbers)           MessageError says what does not fit, and where
    seen = sight.again()                what is seen, fresh each time: its user may change what he gets
    table = table_of("car", space, form)                    None, if that takes more than columns
    batch = table.read(numbers of many rows, how many)

A row has locators and what stands there now (trees.py, write_pairs); `@` is the agent whose row it is. Its form, which
is the row without its numbers, stays the same from step to step. So it is looked at once where each number goes, and
whether it fits its space there; a step then copies numbers. What is more than a key and its value, such as a place in
an array or one more item of a sequence, is merged at each step (merge.py).

What a row does not write stays as it was. It needs gymnasium and numpy.
"""

import contextlib
import copy
import functools
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.spaces import Space

from netmq_example.envs.merge import MOST_ITEMS, fitted, merge
from netmq_example.locator import Locator, LocatorError, Mapping, Path, parse, quoted, spelled
from netmq_example.messages import DTYPES, MessageError
from netmq_example.wire import trees
from netmq_example.wire.batches import empty
from netmq_example.wire.space_bytes import codec_of
from netmq_example.wire.spaces import Codec
from netmq_example.wire.trees import REASONS, Reader, made_of

# Each is read once. A scene has few; one that sends ever new ones fills no memory.
scope_of: Callable[[str], Locator] = functools.lru_cache(10_000)(lambda name: parse(f"{quoted(name)}@"))
known: Callable[[str, str], Locator] = functools.lru_cache(10_000)(lambda text, name: parse(text, "", scope_of(name)))


class Sight:
    """The observation of one agent, read from each row."""

    def __init__(self, name: str, space: Space[Any]) -> None:
        self.name = name
        self.space = space
        self.where = f"{quoted(name)}@"
        self.plan_for = trees.kept(functools.partial(planned, name, space))
        self.forget()

    def forget(self) -> None:
        """An episode begins: nothing was seen yet."""
        # The observation that was given out last is made of these: of a plan and its numbers, or of what was merged.
        self.plan: Plan | None = None
        self.form = b""
        self.numbers: Any = b""
        # The observation that was read last, until somebody takes it.
        self.fresh: Any = None
        self.old = fitted(self.space, empty(self.space, self.where), self.where)

    def read(self, form: bytes, numbers: Any) -> None:
        self.fresh = None
        plan = self.plan_for(form)
        self.form = form
        if plan:
            if plan is not self.plan and plan.stays:
                self.old = self.again()
            # What does not fit may still be merged, such as a number into a text; or else that says what is wrong.
            with contextlib.suppress(MessageError, *REASONS):
                self.fresh = plan.read(numbers, self.old)
                self.plan = plan
                self.numbers = numbers
                return
        self.old = fitted(self.space, self.merged(form, numbers), self.where)
        self.plan = None

    def again(self) -> Any:
        if self.fresh is not None:
            seen, self.fresh = self.fresh, None
            return seen
        return self.plan.read(self.numbers, self.old) if self.plan else fitted(self.space, self.old, self.where)

    def merged(self, form: bytes, numbers: Any) -> Any:
        observations = {self.name: self.again() if self.plan else self.old}
        appended: set[str] = set()
        at = 0
        try:
            for text, part in trees.pairs_of(form):
                value, at = trees.reader(part)(numbers, at)
                mappings = tuple(
                    replace(one, everyone=False, agents=(self.name,)) for one in mappings_for(self.name, text)
                )
                merge(observations, Locator(text, mappings), value, appended)
        except LocatorError as error:
            raise MessageError("bad-observation", str(error)) from None
        except MessageError:
            raise
        except REASONS as error:
            raise MessageError("bad-observation", f"it is cut short: {error!s:.80}") from None
        if at != len(numbers):
            raise MessageError("bad-observation", "more follows what was seen")
        return observations[self.name]

    def warn(self) -> None:
        """Name what nothing of the last row writes. It may come later, from a sensor that is disabled now."""
        if not self.form:
            return
        pairs = trees.pairs_of(self.form)
        paths = [one.destination for text, _ in pairs for one in mappings_for(self.name, text)]
        for path in unwritten(self.space, paths):
            place = f"{self.where}{spelled(path)}"
            warnings.warn(f"nothing writes {place}: is there such a member in C#? It stays as it is", stacklevel=2)


class Plan:
    def __init__(self, steps: list[Reader], places: Any) -> None:
        self.steps = steps
        # The number of a step, or a dict of places by key, or None: it stays as it was.
        self.places = places
        self.stays = has_none(places)

    def read(self, numbers: Any, old: Any) -> Any:
        values, at = trees.in_turn(self.steps, numbers, 0)
        if at != len(numbers):
            raise ValueError("more follows what was seen")
        return put(self.places, values, old)


def has_none(places: Any) -> bool:
    return any(map(has_none, places.values())) if isinstance(places, dict) else places is None


def put(places: Any, values: list[Any], old: Any) -> Any:
    if isinstance(places, dict):
        return {key: put(place, values, None if old is None else old[key]) for key, place in places.items()}
    return copy.deepcopy(old) if places is None else values[places]


def planned(name: str, space: Space[Any], form: bytes) -> Plan | None:
    """None where values must be merged."""
    targets = targets_of(name, space, form)
    try:
        steps: list[Any] = [fitter(target, part) for target, part in (targets or {}).values()]
    except ValueError as error:
        raise trees.bad(error) from None
    return None if targets is None or None in steps else Plan(steps, places_of(space, list(targets)))


def targets_of(name: str, space: Space[Any], form: bytes) -> dict[Path, tuple[Space[Any], Any]] | None:
    """Where each value goes: the part of the space, and the form; None if that is more than to a key."""
    targets: dict[Path, tuple[Space[Any], Any]] = {}
    for text, part in trees.pairs_of(form):
        mappings = mappings_for(name, text)
        path = mappings[0].destination if len(mappings) == 1 else (0,)
        target = at_keys(space, path)
        if target is None or mappings[0].source or overlaps(path, targets):
            return None
        targets[path] = target, part
    return targets


def mappings_for(name: str, text: str) -> list[Mapping]:
    try:
        mappings = known(text, name).mappings
    except LocatorError as error:
        raise MessageError("bad-observation", f"{text[:100]}: {error}") from None
    return [one for one in mappings if one.names(name)]


@dataclass
class Table:
    """Many rows of one form, whose values go to keys: each key is a column of their bytes."""

    size: int
    places: Any
    columns: list[tuple[Codec, int]]

    def read(self, values: Any, count: int) -> Any:
        """A batch. MessageError: it is not in the space; the sight of each agent says where."""
        if len(values) != count * self.size:
            raise MessageError("not-in-space", f"{len(values)} bytes are not {count} times {self.size}")
        block = np.frombuffer(values, np.uint8).reshape(count, self.size)
        return put(self.places, [codec.read_block(block, at) for codec, at in self.columns], None)


def table_of(name: str, space: Space[Any], form: bytes) -> Table | None:
    """None where rows take more than columns."""
    columns: list[tuple[Codec, int]] = []
    at = 0
    targets = targets_of(name, space, form) or {}
    for target, part in targets.values():
        if part != form_in(target) or not codec_of(target).size:
            return None
        codec = codec_of(target)
        columns.append((codec, at))
        at += codec.size
    places = places_of(space, list(targets))
    return None if has_none(places) or not columns else Table(at, places, columns)


def unwritten(space: Space[Any], paths: list[Path], at: Path = ()) -> Iterator[Path]:
    """Keys, also of dicts in dicts, in which nothing arrives. Where a part of something arrives, something does."""
    if not any(path[: len(at)] == at for path in paths):
        yield at
    elif isinstance(space, spaces.Dict) and at not in paths:
        for key, part in space.items():
            yield from unwritten(part, paths, (*at, key))


def at_keys(space: Space[Any], path: Path) -> Space[Any] | None:
    """The part of a space to which only keys lead."""
    part: Any = space
    for key in path:
        if not isinstance(part, spaces.Dict) or not isinstance(key, str) or key not in part.spaces:
            return None
        part = part[key]
    return part  # type: ignore[no-any-return]


def overlaps(path: Path, others: Iterable[Path]) -> bool:
    return any(path[: len(other)] == other or other[: len(path)] == path for other in others)


def places_of(space: Any, paths: list[Path], at: Path = ()) -> Any:
    if at in paths:
        return paths.index(at)
    if not any(path[: len(at)] == at for path in paths):
        return None
    return {key: places_of(part, paths, (*at, key)) for key, part in space.items()}


def fitter(space: Space[Any], form: Any) -> Reader | None:
    """Reads something of this form as something of the space, or fails; None: it must be merged."""
    match space, form:
        case spaces.Dict(), {"dict": dict(parts)}:
            if parts.keys() != space.spaces.keys():
                return None
            each: list[Any] = [fitter(space[key], part) for key, part in parts.items()]
            # In the order of the space.
            order = [(key, list(parts).index(key)) for key in space]
            return None if None in each else made_of(each, lambda values: {key: values[at] for key, at in order})
        case spaces.Dict(), _:
            return None
        case spaces.Sequence(stack=False), list() if len(form) <= MOST_ITEMS:
            items: list[Any] = [fitter(space.feature_space, part) for part in form]
            return None if None in items else made_of(items, tuple)
        case _, str() if form == form_in(space):
            return codec_of(space).read
    # Of another dtype, or one number for an array of one.
    plain = trees.reader(form)

    def read(numbers: Any, at: int) -> tuple[Any, int]:
        value, at = plain(numbers, at)
        return fitted(space, value, ""), at

    return read


def form_in(space: Space[Any]) -> Any:
    """The form of whatever is in a space, or in a part of it; None where it is not always the same."""
    match space:
        case spaces.Discrete() if space.dtype == np.int64:
            return "int64"
        case spaces.Text():
            return "text"
        case spaces.Box() | spaces.MultiDiscrete() if space.dtype.name in DTYPES:
            return f"{space.dtype}[{','.join(map(str, space.shape))}]"
        case spaces.Dict():
            parts = {key: form_in(part) for key, part in space.items()}
            return None if None in parts.values() else {"dict": parts}
        case spaces.Tuple():
            items = [form_in(part) for part in space]
            return None if None in items else items
    return None
