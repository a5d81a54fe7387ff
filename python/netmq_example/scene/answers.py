"""A simulator's messages: its hello, its answers to resets and steps, pictures, and refusals."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from netmq_example import arguments
from netmq_example.messages import Array, Message, MessageError
from netmq_example.wire import trees
from netmq_example.wire.records import ANSWERS, TERMINATED, TRUNCATED, Record, rewards
from netmq_example.wire.spaces import exactly, write_dict


def hello_of(name: str, dt: float, spaces: dict[str, Any]) -> Message:
    """Its one array describes the spaces, as a value (trees.py)."""
    data = trees.write(spaces)
    return Message("hello", 0, {"name": name, "dt": arguments.number("dt", dt, least=0)}, [trees.array_of(data)])


def unknown(request: Message, known: str) -> MessageError:
    return MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of reset, step, {known}, close")


def picture_of(request: Message, pictures: list[Any]) -> Message:
    try:
        arrays = [exactly(picture, np.dtype(np.uint8)) for picture in pictures]
    except (ArithmeticError, TypeError) as error:
        raise MessageError("bad-picture", f"a picture is uint8 [height, width, 3]: {error!s:.100}") from None
    return Message("picture", request.id, {}, [Array("uint8", one.shape, one.tobytes()) for one in arrays])


def options_in(request: Record) -> dict[str, Any]:
    """Those of a reset."""
    options = trees.read(request.options) if request.options else {}
    if type(options) is not dict:
        raise MessageError("bad-options", f"options are a dict, not {type(options).__name__}")
    return options


def answer_to(
    request: Record, names: Sequence[str], outcomes: list[dict[str, Any]], rows: list[bytes], options: bytes = b""
) -> Record:
    """`outcomes` has the reward and the ends of each that has stepped; whatever else is in it is its info."""
    numbers = []
    flags = []
    infos = []
    for name, one in zip(names, outcomes, strict=True):
        info = dict(one)
        numbers.append(reward_of(name, info.pop("reward", 0.0)))
        ended = TERMINATED if info.pop("terminated", False) else 0
        flags.append(ended | (TRUNCATED if info.pop("truncated", False) else 0))
        infos.append(write_dict(info, "info") if info else b"")
    return Record(ANSWERS, request.id, rewards(numbers), flags, rows, infos, options)


def reward_of(name: str, reward: Any) -> float:
    """Any number, also one of numpy's."""
    try:
        # An array of one number is a number to an old numpy, and none to a new one.
        if np.ndim(reward):
            raise TypeError
        number = float(reward)
    except (TypeError, ValueError):
        raise MessageError("bad-reward", f"the reward of {name} is {reward!r:.40}, which is no number") from None
    if not math.isfinite(number):
        raise MessageError("bad-reward", f"the reward of {name} is {number}")
    return number
