"""Lesson 17, the batch: a trainer's one message for all its areas, split into one for each, and their answers joined.

To a trainer the hub is lesson 10's simulator with many areas, and to a simulator it is lesson 09's environment. What
the messages hold, is said there: areas.py, simulator.py.

Lesson 17, an episode: what was asked of it so far, and so it belongs to no simulator.

A seed and the actions after it make an episode. The hub keeps both, and gives them to another simulator when the first
one dies, or is late: the trainer never notices. That holds for simulators that compute alike, which is why the hub
takes those of one version only.
"""

import math
import struct
import time
from collections.abc import Callable
from typing import Any

from netmq_example.messages import DTYPES, ENCODER, Array, Message, MessageError

# An episode is kept, so that it can be done again, and so it must end.
LONGEST = 100_000


class Episode:
    """Of one area: its requests so far, the reset first, and the answer to the last one when there is one."""

    def __init__(self, reset: Message, ready: Callable[[], object]) -> None:
        self.requests, self.ready, self.runs = [reset], ready, list["Member"]()
        self.answer: Message | None = None
        # `lost`: how many simulators in a row, each when it had done `lost_at` requests.
        self.leased, self.lost, self.lost_at, self.seen = False, 0, 0, list[Array]()
        # Of its last request, or of the loss of who was to answer it.
        self.since = time.monotonic()

    def ask(self, request: Message) -> None:
        self.requests.append(request)
        self.answer, self.since = None, time.monotonic()
        for run in self.runs:
            run.go_on()

    def answered(self, by: "Member", answer: Message) -> None:
        """The first answer counts; whoever else was asked is free again once it has answered too."""
        for run in self.runs:
            run.episode = self if run is by else None
        self.runs, self.answer, self.lost = [by], answer, 0
        if answer.kind == "state":
            self.seen = answer.arrays
        elif len(self.requests) > 1:
            # A picture, or a refusal: the world has not changed.
            self.requests.pop()
            by.done -= 1
        self.ready()

    def differs(self, done: int, answer: Message) -> bool:
        """Whether who does it again, and has come to what was seen last, sees something else."""
        again = done + 2 == len(self.requests)
        return again and [bytes(array.data) for array in answer.arrays] != [bytes(array.data) for array in self.seen]

    def lost_by(self, run: "Member") -> None:
        self.runs.remove(run)
        run.episode, self.since = None, time.monotonic()
        # Simulators that die by chance do so anywhere, also while they do the episode again.
        self.lost, self.lost_at = self.lost + 1 if run.done == self.lost_at else 1, run.done

    def release(self) -> None:
        for run in self.runs:
            run.episode = None
        self.runs = []


class Member:
    """A simulator of the fleet. One request at a time is under way, and an episode takes all of it."""

    def __init__(self, number: int, name: str, send: Callable[[Message], bool]) -> None:
        self.number, self.name, self.send = number, name, send
        self.episode: Episode | None = None
        # How many of its episode's requests it has done, and whether one is under way. The hub is never silent for
        # three seconds: one that is was started anew, and knows nothing of who was there before, since ZeroMQ can have
        # connected again so quickly that nobody noticed. So a simulator says hello again then.
        self.done, self.busy, self.last = 0, False, Message("welcome", 0, {"silence": 3.0})
        self.heard = self.told = self.asked = self.free_since = self.wanted = time.monotonic()
        self.there = send(self.last)

    def free(self) -> bool:
        return self.there and not self.episode and not self.busy

    def lease(self, episode: Episode) -> None:
        self.episode, self.done = episode, 0
        episode.runs.append(self)
        episode.leased = True
        self.go_on()

    def go_on(self) -> None:
        """The next request of its episode. A new simulator does all of them again, one after the other."""
        if self.episode and not self.busy and self.done < len(self.episode.requests):
            request = self.episode.requests[self.done]
            self.last = Message(request.kind, self.last.id + 1, request.values, request.arrays)
            self.busy, self.asked = True, time.monotonic()
            self.tell()

    def silence(self) -> float:
        return time.monotonic() - self.heard

    def tell(self) -> None:
        """The last request, or welcome, perhaps once more."""
        self.told, self.there = time.monotonic(), self.send(self.last)

    def hears(self, answer: Message) -> bool:
        """Another id is one that came twice: it says no more than that the simulator is there."""
        self.heard = time.monotonic()
        return self.busy and answer.id == self.last.id

    def take(self, answer: Message) -> None:
        self.busy, self.free_since = False, self.heard
        if self.episode:
            self.done += 1
            if self.done == len(self.episode.requests):
                self.episode.answered(self, answer)
            self.go_on()


def check(episodes: list[Episode | None], parts: dict[int, Message]) -> None:
    """Before anything is begun: half a step would be none."""
    for area, episode in enumerate(episodes):
        part = parts.get(area)
        if not episode and (not part or part.kind != "reset"):
            raise MessageError("no-episode", f"area {area} was never reset")
        if episode and part and part.kind == "step" and len(episode.requests) > LONGEST:
            raise MessageError("too-long", f"an episode has at most {LONGEST} steps: set max_episode_steps")


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
