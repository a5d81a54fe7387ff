"""Lesson 11, merging: a value goes into the observations where a locator says.

    observations = {"car": {"speed": np.zeros(2, np.float32), "seen": ["a bus"]}}
    appended = set()                                             for each message a new one
    merge(observations, parse("car@.speed(0) = $[1]"), [3, 4], appended)    speed: [4, 0]
    merge(observations, parse("car@.seen[]"), "a tree", appended)           seen: ["a tree"]; the first one clears it
    merge(observations, parse("car@.seen[]"), "a dog", appended)            seen: ["a tree", "a dog"]

What is there says of which kind a value must be, such as float32. It is cast to that, but never to another number. An
observation that was given out is not changed: another one takes its place. Whether the whole fits its space, the space
can say. It needs numpy.
"""

from functools import reduce
from typing import Any

import numpy as np
from locator import Locator
from mapping import APPEND, LocatorError, Path, quoted, spelled

# Items, of whatever kind, that are looked at one by one.
MOST = 50_000
NUMBERS = (bool, int, float, np.generic, np.ndarray)
# What indexing and casting raise.
REASONS = (LookupError, TypeError, ValueError, ArithmeticError, AttributeError, RecursionError)


def merge(observations: dict[str, Any], locator: Locator, value: Any, appended: set[str]) -> None:
    """To all places of a locator or, with a LocatorError, to none."""
    new, known = dict(observations), set(appended)
    for mapping in locator.mappings:
        try:
            if not mapping.absolute:
                raise ValueError("it names no agent")
            part = reduce(lambda whole, step: whole[step], mapping.source, value)
            for agent in filter(mapping.names, observations) if mapping.everyone else mapping.agents:
                place = f"{quoted(agent)}@{spelled(mapping.destination)}"
                new[agent] = placed(new[agent], mapping.destination, part, place not in known)
                known.add(place)
        except REASONS as error:
            said = f"there is no {error}" if isinstance(error, KeyError) else str(error)
            raise LocatorError(f"{str(mapping)[:100]}: {' '.join(said.split())[:200]}") from None
    observations.update(new)
    appended |= known


def placed(old: Any, path: Path, value: Any, first: bool) -> Any:
    """A copy of what is there, with the value at the end of the path."""
    if not path:
        return like(old, value)
    step, rest = path[0], path[1:]
    if step is APPEND:
        return one_more(old, value, first)
    if isinstance(old, dict):
        return {**old, step: placed(old[step], rest, value, first)}
    if isinstance(old, np.ndarray):
        array = old.copy()
        array[step] = placed(array[step], rest, value, first)
        return array
    if type(old) not in (list, tuple):
        raise TypeError(f"{type(old).__name__} has no {spelled((step,))}")
    items = list(old)
    items[step] = placed(items[step], rest, value, first)  # type: ignore[index]
    if len(items) != len(old):
        raise ValueError(f"there would be {len(items)} items and not {len(old)}")
    return type(old)(items)


def one_more(old: Any, value: Any, first: bool) -> Any:
    """A sequence of whatever kind, stacked ones too; the first value of a message clears what the last one left."""
    if isinstance(old, np.ndarray):
        item = like(np.empty(old.shape[1:], old.dtype), value)
        return np.concatenate([old[:0] if first else old, item[None]])
    if type(old) not in (list, tuple):
        raise TypeError(f"{type(old).__name__} is no sequence")
    return type(old)([*(() if first else old), like(old[0], value) if old else value])


def like(old: Any, value: Any) -> Any:
    """The value as what is there."""
    if isinstance(old, NUMBERS):
        array = cast(np.asarray(old), value)
        return array if isinstance(old, np.ndarray) else array[()] if isinstance(old, np.generic) else array.item()
    if isinstance(old, str):
        return "" if value is None else str(value)
    if isinstance(old, dict):
        return {**old, **{key: like(old[key], part) for key, part in dict(value).items()}}
    # Not isinstance: the parts of a graph are a named tuple, and it is taken as it is.
    if type(old) not in (list, tuple):
        return value
    if isinstance(value, str | bytes | dict):
        raise TypeError(f"{type(value).__name__} is no {type(old).__name__}")
    if isinstance(value, np.ndarray) and value.shape[:1] > (MOST,):
        # Nobody takes so many one by one.
        return value
    # A sequence can become longer, and its items are of one kind.
    kinds = old if len(old) == len(value) else [*old[:1]] * len(value)
    return type(old)(like(kind, part) for kind, part in zip(kinds, value, strict=True)) if old else type(old)(value)


def cast(old: Any, value: Any) -> Any:
    given = np.asarray(value)
    if given.dtype.kind == "O":
        # Among numbers null is NaN.
        given = given.astype(np.float64)
    if given.dtype.kind not in "biuf":
        raise TypeError(f"{value!r:.40} is no number")
    with np.errstate(over="raise", invalid="raise"):
        array = given.astype(old.dtype)
    # Of numbers with a fraction it is only their precision that may change.
    if (old.dtype.kind != "f" or given.dtype.kind != "f") and not np.array_equal(array, given):
        raise ValueError(f"{value!r:.40} would become another number as {old.dtype}")
    # A single number is the same whether it is a number, or an array of one.
    return array.reshape(old.shape) if array.size == old.size == 1 else array
