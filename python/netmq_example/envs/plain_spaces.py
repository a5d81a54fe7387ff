"""Spaces as most libraries take them: an array or one dict of arrays is seen, and one array is done.

    env = PlainSpaces(gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", …))
    plain = Plain(observation_space, action_space)
    plain.look(seen), plain.choose(action)                  of one agent; plain.look(batch, 16) of 16 at once

A space that is plain already stays as it is. Of any other one:

    what is seen becomes a dict of arrays. A part of a part has both keys, as last_push, and no key has a point. Of a
    sequence the first 8 items are seen, and zeros in place of those that are not there. Choices count from 0. Texts,
    graphs and OneOf are left out.
    what is done becomes one array from -1 to 1. A number of a box goes from its lowest to its highest; of a discrete
    space there is a number for each choice, and the largest one is done. Choices alone stay choices, from 0.

It needs gymnasium and numpy.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.spaces import Space
from gymnasium.utils import RecordConstructorArgs

from netmq_example.wire.batches import unstacked

# How many items of a sequence are seen.
MOST_ITEMS = 8
CHOICES = (spaces.Discrete, spaces.MultiDiscrete, spaces.MultiBinary)
ARRAYS = (spaces.Box, *CHOICES)

# Takes a part out of the whole; the shape is () of one agent, and of a batch how many there are.
Look = Callable[[Any, tuple[int, ...]], Any]


class PlainSpaces(gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """One environment, whose spaces are plain."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        RecordConstructorArgs.__init__(self)
        super().__init__(env)
        self.plain = Plain(env.observation_space, env.action_space)
        self.observation_space = self.plain.observation_space
        self.action_space = self.plain.action_space

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        seen, info = self.env.reset(seed=seed, options=options)
        return self.plain.look(seen), info

    def step(self, action: Any) -> Any:
        seen, *rest = self.env.step(self.plain.choose(action))
        return self.plain.look(seen), *rest


class Plain:
    """Both ways between spaces and plain ones."""

    def __init__(self, seen: Space[Any], done: Space[Any]) -> None:
        self.seen = seen
        self.done = done
        self.observation_space = seen
        # The look of each part of an observation, or of the only one; none where the space stays.
        self.looks: dict[str, Look] = {}
        self.only: Look | None = None
        flat = isinstance(seen, spaces.Dict) and all(
            key and "." not in key and is_plain(part) for key, part in seen.items()
        )
        if not flat and not is_plain(seen):
            self.use(list(parts_of(seen, "", lambda value, _: value)))
        self.action_space = plain_action(done)

    def __reduce__(self) -> Any:
        return Plain, (self.seen, self.done)

    def use(self, parts: list[tuple[str, Space[Any], Look]]) -> None:
        if not parts:
            raise ValueError(f"nothing is left of {self.seen}: texts, graphs and OneOf are left out")
        if not isinstance(self.seen, spaces.Dict | spaces.Tuple) and not parts[0][0]:
            ((_, self.observation_space, self.only),) = parts
            return
        known: dict[str, Space[Any]] = {}
        for key, space, look in parts:
            # torch takes no module without a name, and two may have one by now, as "a.b" and "a_b".
            key = key or "seen"
            while key in known:
                key += "_"
            known[key] = space
            self.looks[key] = look
        self.observation_space = spaces.Dict(known)

    def look(self, seen: Any, count: int | None = None) -> Any:
        """Of one agent, or of so many in a batch."""
        many = () if count is None else (count,)
        if self.only:
            return self.only(seen, many)
        return {key: look(seen, many) for key, look in self.looks.items()} if self.looks else seen

    def choose(self, action: Any) -> Any:
        """Of one agent, or of all in a batch."""
        if self.action_space is self.done:
            return action
        action = np.asarray(action)
        if not isinstance(self.done, CHOICES):
            return chosen(self.done, np.clip(action.astype(np.float64), -1, 1))
        plain: Any = self.action_space
        done: Any = self.done
        shape = action.shape[: action.ndim - len(plain.shape)] + done.shape
        return (action.reshape(shape) + getattr(done, "start", 0)).astype(done.dtype)[()]


def is_plain(space: Any) -> bool:
    if isinstance(space, spaces.Box):
        return len(space.shape) > 0
    dimensions = 0 if isinstance(space, spaces.Discrete) else 1
    return (
        isinstance(space, CHOICES) and len(space.shape or ()) == dimensions and not np.any(getattr(space, "start", 0))
    )


def plain_array(space: Any) -> Any:
    """The same numbers in a row; choices count from 0."""
    match space:
        case _ if is_plain(space):
            return space
        case spaces.Box():
            return spaces.Box(space.low.reshape(1), space.high.reshape(1), dtype=space.dtype.type)
        case spaces.Discrete():
            return spaces.Discrete(int(space.n))
        case spaces.MultiDiscrete():
            return spaces.MultiDiscrete(space.nvec.ravel())
        case spaces.MultiBinary():
            return spaces.MultiBinary(int(np.prod(space.shape)))


def parts_of(space: Space[Any], key: str, look: Look) -> Iterator[tuple[str, Space[Any], Look]]:
    """Keys, each with its space, and what takes it out of the whole."""
    match space:
        case spaces.Dict():
            for name, part in space.items():
                yield from parts_of(part, joined(key, str(name)), part_of(look, name))
        case spaces.Tuple():
            for at, part in enumerate(space):
                yield from parts_of(part, joined(key, str(at)), part_of(look, at))
        case spaces.Sequence():
            for name, part, of_item in parts_of(space.feature_space, key, lambda item, _: item):
                room = room_for(part)
                yield name, room, items_of(space, room, look, of_item)
        case _ if isinstance(space, ARRAYS):
            plain = plain_array(space)
            yield key, plain, look if plain is space else array_of(space, plain, look)


def joined(key: str, name: str) -> str:
    # torch takes no point in the name of a module.
    name = name.replace(".", "_")
    return f"{key}_{name}" if key else name


def part_of(look: Look, key: str | int) -> Look:
    return lambda seen, many: look(seen, many)[key]


def array_of(space: Any, plain: Any, look: Look) -> Look:
    start = getattr(space, "start", 0)
    return lambda seen, many: (look(seen, many) - start).reshape(many + plain.shape).astype(plain.dtype)[()]


def room_for(part: Any) -> Any:
    """For the first items of a sequence."""
    match part:
        case spaces.Box():
            shape = (MOST_ITEMS, *part.shape)
            low, high = (np.broadcast_to(limit, shape) for limit in (part.low, part.high))
            return spaces.Box(np.minimum(0, low), np.maximum(0, high), dtype=part.dtype.type)
        case spaces.Discrete() | spaces.MultiDiscrete():
            return spaces.MultiDiscrete(np.tile(part.n if isinstance(part, spaces.Discrete) else part.nvec, MOST_ITEMS))
    return spaces.MultiBinary(MOST_ITEMS * part.shape[0])


def items_of(space: Any, room: Any, look: Look, of_item: Look) -> Look:
    def filled(items: Any) -> Any:
        array = np.zeros(room.shape, room.dtype)
        items = unstacked(space.feature_space, items) if space.stack else items
        rows = array.reshape(MOST_ITEMS, -1)
        for at, item in enumerate(list(items)[:MOST_ITEMS]):
            rows[at] = np.ravel(of_item(item, ()))
        return array

    return lambda seen, many: np.stack([*map(filled, look(seen, many))]) if many else filled(look(seen, many))


def plain_action(done: Any) -> Any:
    if isinstance(done, CHOICES):
        return plain_array(done)
    if isinstance(done, spaces.Box) and is_plain(done) and done.dtype.kind == "f":
        return done
    return spaces.Box(-1, 1, (numbers_of(done),), np.float32)


def numbers_of(space: Space[Any]) -> int:
    """How many numbers what is done takes."""
    match space:
        case spaces.Dict():
            return sum(map(numbers_of, space.values()))
        case spaces.Tuple():
            return sum(map(numbers_of, space))
        case spaces.Box() | spaces.MultiBinary():
            return int(np.prod(space.shape))
        case spaces.Discrete():
            return int(space.n)
        case spaces.MultiDiscrete():
            return int(space.nvec.sum())
    raise ValueError(f"no array says what is done in {space}")


def chosen(space: Any, numbers: Any) -> Any:
    """The actions that these numbers are: the last axis has those of one agent."""
    many = numbers.shape[:-1]
    match space:
        case spaces.Dict():
            each = parted(numbers, map(numbers_of, space.values()))
            return {key: chosen(part, some) for (key, part), some in zip(space.items(), each, strict=True)}
        case spaces.Tuple():
            each = parted(numbers, map(numbers_of, space))
            return tuple(chosen(part, some) for part, some in zip(space, each, strict=True))
        case spaces.Discrete():
            return (space.start + np.argmax(numbers, axis=-1)).astype(space.dtype)
        case spaces.MultiDiscrete():
            most = [np.argmax(some, axis=-1) for some in parted(numbers, space.nvec.flat)]
            return (space.start + np.stack(most, axis=-1).reshape(many + space.shape)).astype(space.dtype)
        case spaces.MultiBinary():
            return (numbers > 0).reshape(many + space.shape).astype(space.dtype)
    low, high = space.low.astype(np.float64), space.high.astype(np.float64)
    numbers = numbers.reshape(many + space.shape)
    if space.is_bounded():
        numbers = low + (numbers + 1) / 2 * (high - low)
    if space.dtype.kind != "f":
        numbers = np.rint(numbers)
    # As a float32 it may be a little more than its highest.
    return np.clip(numbers, low, high).astype(space.dtype).clip(space.low, space.high)


def parted(numbers: Any, counts: Iterable[int]) -> list[Any]:
    return np.split(numbers, np.cumsum([*counts])[:-1], axis=-1)
