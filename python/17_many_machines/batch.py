"""Lesson 17, the batch: a trainer's one message for all its areas, split into one for each, and their answers joined.

To a trainer the hub is lesson 10's simulator with many areas, and to a simulator it is lesson 09's environment. What
the messages hold, is said there: areas.py, simulator.py.
"""

import math
import struct
import sys
from pathlib import Path
from typing import Any

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import DTYPES, ENCODER, Array, Message, MessageError

VERDICTS = {"reward", "terminated", "truncated"}


def split(request: Message, count: int) -> list[Message | None]:
    """What each area is asked, if anything."""
    arrays, areas = list(request.arrays), range(count)
    if request.kind == "render" and not arrays:
        return [Message("render") for _ in areas]
    if request.kind not in ("reset", "step"):
        raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of reset, step, render, close")
    steps: list[Message | None] = [None for _ in areas]
    if request.kind == "step":
        steps = [Message("step", arrays=[row]) for row in rows(arrays.pop(0) if arrays else None, count)]
        if not arrays:
            return steps
    if len(arrays) not in (2, 3) or [(array.dtype, array.shape) for array in arrays[:2]] != [
        ("uint8", (count,)),
        ("int64", (count,)),
    ]:
        raise MessageError("no-mask", f"a reset has mask uint8 [{count}], seeds int64 [{count}], and perhaps a state")
    mask, seeds = bytes(arrays[0].data), struct.unpack(f"<{count}q", arrays[1].data)
    values, state = request.values if request.kind == "reset" else {}, arrays[2:]
    resets = [Message("reset", 0, {**values, "seed": seed}, state) for seed in seeds]
    return [resets[area] if mask[area] else steps[area] for area in areas]


def rows(array: Array | None, count: int) -> list[Array]:
    """One for each area, of the same memory."""
    if not array or array.shape[:1] != (count,):
        raise MessageError("wrong-areas", f"actions are not one row for each of {count} areas")
    size, view = math.prod(array.shape[1:]) * DTYPES[array.dtype], memoryview(array.data).cast("B")
    return [Array(array.dtype, array.shape[1:], bytes(view[i * size : i * size + size])) for i in range(count)]


def joined(kind: str, id: int, answers: list[Message], seen: list[Array]) -> Message:
    """One answer for all. Of an area that was not asked for it the answer is empty."""
    if kind == "render":
        return Message("picture", id, {}, [answer.arrays[0] for answer in answers])
    infos, rewards, flags = [], [], [bytearray(), bytearray()]
    for area, answer in enumerate(answers):
        rewards.append(float(answer.values.get("reward", 0)))
        for flag, name in zip(flags, ("terminated", "truncated"), strict=True):
            flag.append(bool(answer.values.get(name)))
        if info := {name: value for name, value in answer.values.items() if name not in VERDICTS}:
            infos.append((area, info))
    count, first = len(answers), seen[0]
    arrays = [
        Array(first.dtype, (count, *first.shape), b"".join(bytes(array.data) for array in seen)),
        Array("float64", (count,), struct.pack(f"<{count}d", *rewards)),
        *(Array("uint8", (count,), bytes(flag)) for flag in flags),
    ]
    return Message("state", id, {"infos": ENCODER.encode(infos)}, arrays)


def form(hello: Message) -> tuple[Any, ...]:
    """What all simulators of one name must have alike: dt, and the spaces."""
    spaces = [(array.dtype, tuple(array.shape), bytes(array.data)) for array in hello.arrays]
    return *(hello.values.get(name) for name in ("dt", "observation", "action")), *spaces


def fits(answer: Message, kind: str, hello: Message) -> bool:
    """Whether it answers this kind of request, as the hello has announced it. A discrete observation is a number."""
    if kind == "render" or answer.kind == "error":
        return answer.kind == "error" or (answer.kind == "picture" and len(answer.arrays) == 1)
    box = hello.values.get("observation") == "box"
    expected = (hello.arrays[0].dtype, hello.arrays[0].shape) if box else ("int64", ())
    seen = [(array.dtype, array.shape) for array in answer.arrays] == [expected]
    return answer.kind == "state" and seen and type(answer.values.get("reward", 0)) in (int, float)


class Refused(MessageError):
    """A simulator that the hub does not take; the hub says so as well."""


def accept(hello: Message, build: str, hello_here: Message | None) -> None:
    """Of this build, and like those of its name that are here; Refused says why it is refused."""
    if not hello.arrays:
        raise Refused("no-spaces", "a hello has the arrays of its spaces")
    if "areas" in hello.values:
        raise Refused("areas-here", "a simulator of the hub is one world, and not many areas")
    name, other = hello.values["name"], hello.values.get("build", "1")
    if other != build:
        text = f"{name!a:.40} of build {other!a:.20}, this hub takes {build!a:.20}"
        raise Refused("other-build", f"{text}: use one build everywhere")
    if hello_here and form(hello_here) != form(hello):
        raise Refused("other-spaces", f"{name!a:.40} has another dt here, or other spaces")
