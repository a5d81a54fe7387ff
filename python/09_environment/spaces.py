"""Lesson 09, the spaces: what a simulator says of what it sees and takes, as Gymnasium's spaces.

A hello names the kinds, `box` or `discrete`, as the values `observation` and `action`. Its arrays are the rest: of a
box the lowest and the highest numbers, whose dtype and shape are those of the box; of a discrete one how many there
are, an int64. An observation or an action is then one array. What is not in its space is refused.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import logger
from gymnasium.spaces import Box, Discrete, Space

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import EXACT, Array, Message, MessageError, read, take


def space_of(kind: str, arrays: list[Array]) -> Space[Any]:
    """The space of this kind; what belongs to it is taken from the beginning of `arrays`."""
    if kind not in ("box", "discrete"):
        raise MessageError("unknown-space", f"space {kind!a:.40} is none of box, discrete")
    try:
        if kind == "discrete":
            return Discrete(int(arrays.pop(0).numpy()))
        low, high = arrays.pop(0).numpy(), arrays.pop(0).numpy()
        return Box(low, high, dtype=low.dtype.type)
    except (LookupError, ValueError, TypeError, ArithmeticError, AssertionError) as error:
        raise MessageError("bad-space", f"its arrays make no {kind}: {error!s:.80}") from None


def offered(hello: Message, name: str, before: list[Space[Any]] | None) -> list[Space[Any]]:
    """What a simulator of this name sees and takes; MessageError says why its hello is refused."""
    if (found := take(hello.values, "name", str)) != name:
        raise MessageError("wrong-name", f"this environment is {name}, the simulator's is {found!a:.40}")
    arrays = list(hello.arrays)
    spaces = [space_of(take(hello.values, which, str), arrays) for which in ("observation", "action")]
    if before and spaces != before:
        raise MessageError("other-spaces", f"the simulator before this one had {before}, not {spaces}")
    return spaces


def described(space: Space[Any]) -> tuple[str, list[Array]]:
    """The other way round: a space's kind, and its arrays."""
    if isinstance(space, Discrete) and space.start == 0:
        return "discrete", [to_array(space.n, np.int64)]
    if isinstance(space, Box):
        return "box", [to_array(space.low, space.dtype), to_array(space.high, space.dtype)]
    raise MessageError("unknown-space", f"{space!s:.40} is none of Box, Discrete from 0")


def to_array(items: Any, dtype: Any) -> Array:
    items = np.asarray(items, dtype)
    return Array(str(items.dtype), items.shape, items.tobytes())


def from_array(space: Space[Any], arrays: list[Array]) -> Any:
    """The one array as something of this space, fresh and writable: what was received goes with its message."""
    if len(arrays) != 1:
        raise MessageError("not-in-space", f"{len(arrays)} arrays are not one of {space}")
    # [()] makes a number of an array without dimensions, and changes no other.
    items = arrays[0].numpy().copy()[()]
    if (items.dtype, items.shape) != (space.dtype, space.shape) or items not in space:
        numbers = " ".join(f"{items.tolist()!r:.200}".split())
        raise MessageError("not-in-space", f"{items.dtype} {items.shape} {numbers} is not in {shown(space)}")
    return items


def picture(arrays: list[Array]) -> Any:
    """The one array as a picture, uint8 [height, width, 3]."""
    if [(array.dtype, array.shape[2:]) for array in arrays] != [("uint8", (3,))]:
        forms = [(array.dtype, array.shape) for array in arrays]
        raise MessageError("no-picture", f"{forms!s:.80} is not one array uint8 [height, width, 3]")
    return arrays[0].numpy().copy()


def drawn(mode: Any) -> Any:
    """The render mode, if there are pictures in it."""
    if mode not in (None, "rgb_array"):
        raise ValueError(f"render_mode takes 'rgb_array' or None, not {mode!r:.40}; lesson 12 makes films")
    return mode


def gives_pictures(mode: Any) -> bool:
    """Whether render has pictures to give; where it has none it says so, as Gymnasium's own environments do."""
    if mode is None:
        logger.warn('render gives no picture: make the environment with render_mode="rgb_array"')
    return mode is not None


def shown(items: Any) -> str:
    """In one line, with the dtype of an array, which numpy's own text often leaves out."""
    dtype = f"{items.dtype} " if isinstance(items, np.ndarray) else ""
    return dtype + " ".join(f"{items!r:.200}".split())


def sendable(options: Any, **own: int) -> tuple[dict[str, Any], list[Array]]:
    """What reset sends: the options, beside values of its own, and the option `state` as an array.

    ValueError names what no simulator could read, before anything is sent.
    """
    options = {} if options is None else options
    if not isinstance(options, Mapping) or "seed" in options:
        raise ValueError(f"options must be a dict, without seed, which is reset's own: {options!r:.80}")
    values = {**options, **own}
    try:
        state = [to_array(values.pop("state"), np.float64)] if "state" in values else []
    except (ValueError, TypeError) as error:
        raise ValueError(f"state cannot be sent: {error!s:.80}") from None
    # One by one, and then together.
    for some in *({name: value} for name, value in values.items()), values:
        try:
            read(Message("reset", EXACT - 1, some).frames())
        except (ValueError, TypeError, RecursionError, MessageError) as error:
            raise ValueError(f"{', '.join(map(str, some)):.40} cannot be sent: {error!s:.200}") from None
    return values, state
