"""Values from a scene become observations: each one is written where its locator says, and must fit its space.

    observations = {"car": empty(space, "'car'@")}                     what is there before anything was seen (wire)
    appended = set()                                                   for each message a new one
    merge(observations, parse("car@.speed(0) = $[1]"), [3, 4], appended)       speed: [4, 0]
    merge(observations, parse("car@.seen[]"), "a tree", appended)              seen: ["a tree"]; the first one clears it
    merge(observations, parse("car@.seen[]"), "a dog", appended)               seen: ["a tree", "a dog"]
    fitted(space, observations["car"], "'car'@")                       a fresh copy, in the space's own dtypes

What is there says of which kind a value must be, such as float32. It is cast to that, but never to another number. An
observation that was given out is not changed: another one takes its place. LocatorError says that a value cannot be
written, MessageError that the whole does not fit, and where:

    'car'@['speed']: float32 [3] … is not in Box(0.0, 1.0, (2,), float32)

It takes all of Gymnasium's fundamental and composite spaces; ValueError says where another one is. It needs gymnasium
and numpy.
"""

from collections.abc import Iterable
from contextlib import suppress
from functools import reduce
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.spaces import GraphInstance, Space
from gymnasium.vector.utils import batch_space, iterate

from netmq_example.json_text import DEEPEST
from netmq_example.locator import APPEND, Locator, LocatorError, Path, Step, quoted, spelled
from netmq_example.messages import MessageError
from netmq_example.wire.batches import together
from netmq_example.wire.spaces import exactly, no_place

# So many items of a sequence, of whatever kind, are looked at one by one. A stack of numbers may be longer.
MOST_ITEMS = 50_000
NUMBERS = (bool, int, float, np.generic, np.ndarray)
# Indexing and casting raise these.
REASONS = (LookupError, TypeError, ValueError, ArithmeticError, AttributeError)


class Chosen(tuple[Any, ...]):
    """A value of a OneOf: its number, and the value itself. Another one is of another kind, so it is taken whole."""

    __slots__ = ()


def merge(observations: dict[str, Any], locator: Locator, value: Any, appended: set[str]) -> None:
    """To all places of a locator or, with a LocatorError, to none. `appended` are the sequences that were cleared."""
    if not isinstance(locator, Locator):
        raise TypeError(f"locator takes a Locator, as parse returns it, not {locator!r:.40}")
    new = dict(observations)
    known = set(appended)
    for mapping in locator.mappings:
        try:
            if not mapping.absolute:
                raise ValueError("it names no agent")
            if len(mapping.destination) > DEEPEST:
                raise ValueError(f"it has more than {DEEPEST} steps")
            part = reduce(part_of, mapping.source, value)
            for agent in filter(mapping.names, observations) if mapping.everyone else mapping.agents:
                place = f"{quoted(agent)}@{spelled(mapping.destination)}"
                new[agent] = placed(new[agent], mapping.destination, part, place not in known)
                known.add(place)
        except MessageError:
            raise
        except REASONS as error:
            why = f"there is no {error}" if isinstance(error, KeyError) else str(error)
            raise LocatorError(f"{str(mapping)[:100]}: {' '.join(why.split())[:200]}") from None
    observations.update(new)
    appended |= known


def part_of(whole: Any, step: Step) -> Any:
    if isinstance(step, tuple) and not isinstance(whole, np.ndarray | np.generic):
        raise TypeError(f"{type(whole).__name__} has no {spelled((step,))}")
    return whole[step]


def placed(old: Any, path: Path, value: Any, first: bool) -> Any:
    if not path:
        return like(old, value)
    step = path[0]
    rest = path[1:]
    if step is APPEND:
        return one_more(old, value, first)
    if isinstance(old, dict):
        return {**old, step: placed(old[step], rest, value, first)}
    if isinstance(old, np.ndarray):
        array = old.copy()
        array[step] = placed(array[step], rest, value, first)
        return array
    if type(old) not in (list, tuple, Chosen) or isinstance(step, tuple):
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
    if isinstance(old, dict) and first:
        # A stack of dicts, or what fits nowhere.
        return (value,)
    if type(old) not in (list, tuple):
        raise TypeError(f"{type(old).__name__} is no sequence")
    item = like(old[0], value) if old else value
    return type(old)([item] if first else [*old, item])


def like(old: Any, value: Any) -> Any:
    if isinstance(old, NUMBERS):
        array = cast(np.asarray(old), value)
        if isinstance(old, np.ndarray):
            return array
        return array[()] if isinstance(old, np.generic) else array.item()
    if isinstance(old, str):
        return "" if value is None else str(value)
    if isinstance(old, dict) and isinstance(value, dict):
        return {**old, **{key: like(old[key], part) for key, part in value.items()}}
    # Not isinstance: the parts of a graph are a named tuple, and it is taken as it is.
    if type(old) not in (list, tuple):
        return value
    if isinstance(value, str | bytes | dict):
        raise TypeError(f"{type(value).__name__} is no {type(old).__name__}")
    if isinstance(value, np.ndarray) and value.shape[:1] > (MOST_ITEMS,):
        # Too many to be taken one by one.
        return value
    if not old:
        return type(old)(value)
    # A sequence can become longer, and its items are of one kind.
    kinds = old if len(old) == len(value) else [old[0]] * len(value)
    return type(old)(like(kind, part) for kind, part in zip(kinds, value, strict=True))


def cast(old: Any, value: Any) -> Any:
    """A copy of the value with the dtype of an array; ArithmeticError says that it would become another number."""
    array = np.array(exactly(value, old.dtype))
    # A single number is the same whether it is a number, or an array of one.
    return array.reshape(old.shape) if array.size == old.size == 1 else array


def fitted(space: Space[Any], value: Any, where: str) -> Any:
    """The value as something of its space: a fresh copy, cast to the space's dtype. MessageError names what is not."""
    fit: Any = value
    match space:
        case spaces.Dict() if isinstance(value, dict) and value.keys() == space.keys():
            return {key: fitted(part, value[key], where + spelled((key,))) for key, part in space.items()}
        case spaces.Tuple() if isinstance(value, list | tuple) and len(value) == len(space):
            return tuple(fitted(part, value[at], f"{where}[{at}]") for at, part in enumerate(space))
        case spaces.Sequence() if isinstance(value, Iterable) and not isinstance(value, str | dict):
            return sequence(space, value, where)
        # A dict of stacked arrays is a stack as well.
        case spaces.Sequence(stack=True, feature_space=spaces.Dict()) if isinstance(value, dict):
            return sequence(space, value, where)
        case spaces.OneOf() if isinstance(value, list | tuple) and len(value) == 2:
            which = fitted(spaces.Discrete(len(space.spaces)), value[0], f"{where}[0]")
            return Chosen((which, fitted(space.spaces[which], value[1], f"{where}[1]")))
        case spaces.Graph() if isinstance(value, GraphInstance):
            fit = graph(space, value, where)
        case spaces.Text() if isinstance(value, str):
            pass
        case spaces.Dict() | spaces.Tuple() | spaces.Sequence() | spaces.Graph() | spaces.Text() | spaces.OneOf():
            raise misfit(space, value, where)
        case spaces.Space():
            try:
                fit = cast(np.empty(space.shape or (), space.dtype), value)
            except REASONS:
                raise misfit(space, value, where) from None
            if isinstance(space, spaces.Discrete):
                fit = fit[()]
        case _:
            raise no_place(space, f"{where}: ")
    if fit not in space:
        raise misfit(space, value, where)
    return fit


def sequence(space: spaces.Sequence, value: Any, where: str) -> Any:
    """All its items at once where they are numbers: one by one they would take twenty times as long."""
    feature: Any = space.feature_space
    try:
        items = iterate(space.stacked_feature_space, value) if isinstance(value, dict) else value
        items = items if isinstance(items, np.ndarray) else list(items)
        count = len(items)
    except REASONS:
        raise misfit(space, value, where) from None
    numbers = None
    if count and isinstance(feature, spaces.Box | spaces.Discrete | spaces.MultiBinary | spaces.MultiDiscrete):
        with suppress(*REASONS):
            array = cast(np.empty(0, feature.dtype), items)
            # The shape first: a space of so many items may be larger than the memory.
            if array.shape == (count, *(feature.shape or ())) and array in batch_space(feature, count):
                numbers = array
    if space.stack and numbers is not None:
        return numbers
    if count > MOST_ITEMS:
        most = f"at most {MOST_ITEMS}, or a stack of numbers that fit"
        raise MessageError("too-many", f"{where}: {count} items, but {most}")
    if numbers is not None:
        return tuple(numbers[at] if isinstance(feature, spaces.Discrete) else numbers[at, ...] for at in range(count))
    # Or one of them is wrong, and this says which.
    parts = tuple(fitted(feature, item, f"{where}[{at}]") for at, item in enumerate(items))
    return together(feature, list(parts)) if space.stack else parts


def graph(space: spaces.Graph, value: GraphInstance, where: str) -> GraphInstance:
    def stack(part: Space[Any] | None, items: Any, name: str) -> Any:
        if items is None or part is None:
            return None
        return fitted(spaces.Sequence(part, stack=True), items, f"{where}.{name}")

    try:
        links = None if value.edge_links is None else cast(np.empty(0, np.int32), value.edge_links)
    except REASONS:
        raise misfit(space, value, where) from None
    nodes = stack(space.node_space, value.nodes, "nodes")
    return GraphInstance(nodes, stack(space.edge_space, value.edges, "edges"), links)


def misfit(space: Space[Any], value: Any, where: str) -> MessageError:
    shown = f"{value.dtype} {list(value.shape)}" if isinstance(value, np.ndarray) else type(value).__name__
    return MessageError("not-in-space", f"{where}: {shown} {' '.join(repr(value).split())[:60]} is not in {space}")
