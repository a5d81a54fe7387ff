"""Trainers as the hub sees them: N areas, which are stepped together, each an episode of its own.

    trainer = Trainer("CartPole", 2, send, count)        send(message) is False if the trainer is gone
    trainer.take(request)                                reset, step, render or close, for all areas
    trainer.under_way()                                  the episodes whose answers are still to come

A trainer's one message for all its areas is split into one for each, and their answers are joined. To a trainer the
hub is lesson 10's simulator with many areas, and to a simulator it is lesson 09's environment: what the messages hold
is described there.
"""

import math
import struct
import time
from collections import Counter
from collections.abc import Callable
from functools import partial

from netmq_example.fleet.members import Episode
from netmq_example.messages import DTYPES, ENCODER, Array, Message, MessageError

# An episode is kept, so that it can be played again, and so it must end.
MOST_STEPS = 100_000
MOST_AREAS = 1024
VERDICTS = {"reward", "terminated", "truncated"}


class Trainer:
    """Its request, until all areas have answered it, and its last answer."""

    def __init__(self, name: str, areas: int, send: Callable[[Message], bool], count: Counter[str]) -> None:
        if not 0 < areas <= MOST_AREAS:
            raise MessageError("bad-areas", f"a trainer has 1 to {MOST_AREAS} areas, not {areas}")
        self.name = name
        self.areas = areas
        self.send = send
        self.count = count
        self.episodes: list[Episode | None] = [None] * areas
        self.request = Message("join")
        self.kept = Message("alive")
        # The areas whose answers are still to come.
        self.left: set[int] = set()
        # Whether it has got simulators, and when it was sent anything.
        self.admitted = False
        self.there = True
        self.sent = time.monotonic()

    def take(self, request: Message) -> None:
        """A new request is split among the areas. One that comes again gets its answer again, if there is one."""
        if request.id <= self.request.id:
            if not self.left:
                self.reply(self.kept)
            return
        self.request = request
        if request.kind == "close":
            self.release()
            self.answer(Message("closed", request.id))
            # Its simulators are for others, also while it stays connected.
            self.there = False
            return
        try:
            parts = {area: part for area, part in enumerate(split(request, self.areas)) if part}
            check_parts(self.episodes, parts)
        except MessageError as error:
            self.refuse(error)
            return
        self.left = set(parts)
        for area, part in parts.items():
            episode = self.episodes[area]
            if episode and part.kind != "reset":
                episode.ask(part)
                continue
            if episode:
                episode.release()
            self.count["episodes"] += 1
            self.episodes[area] = Episode(part, partial(self.ready, area))

    def under_way(self) -> list[Episode]:
        """Those whose answers are still to come."""
        return [episode for area in self.left if (episode := self.episodes[area])]

    def ready(self, area: int) -> None:
        """An area has answered. After the last one the trainer gets all of it."""
        self.left.discard(area)
        if self.left:
            return
        episodes = [episode for episode in self.episodes if episode]
        answers = [episode.answer or Message("none") for episode in episodes]
        for episode in episodes:
            # It is sent once: the next request may be for others.
            episode.answer = None
        errors = [answer.values for answer in answers if answer.kind == "error"]
        if errors:
            for area, episode in enumerate(episodes):
                if not episode.seen:
                    # What was begun wrongly is none.
                    episode.release()
                    self.episodes[area] = None
            self.refuse(MessageError(str(errors[0].get("code")), str(errors[0].get("text"))))
        else:
            seen = [episode.seen[0] for episode in episodes]
            self.answer(joined(self.request.kind, self.request.id, answers, seen))

    def refuse(self, error: MessageError) -> None:
        self.left.clear()
        self.answer(Message("error", self.request.id, {"code": error.code, "text": error.text}))

    def give_up(self, text: str) -> None:
        self.release()
        self.refuse(MessageError("no-simulator", text))

    def answer(self, answer: Message) -> None:
        self.kept = answer
        self.reply(answer)

    def reply(self, message: Message) -> None:
        self.sent = time.monotonic()
        self.there = self.send(message)

    def release(self) -> None:
        """It is gone, or has closed: its simulators are for others."""
        for episode in filter(None, self.episodes):
            episode.release()
        self.episodes = [None] * self.areas
        self.left = set()


def check_parts(episodes: list[Episode | None], parts: dict[int, Message]) -> None:
    """MessageError before anything is begun: half a step would be none."""
    for area, episode in enumerate(episodes):
        part = parts.get(area)
        if not episode and (not part or part.kind != "reset"):
            raise MessageError("no-episode", f"area {area} was never reset")
        if episode and part and part.kind == "step" and len(episode.requests) > MOST_STEPS:
            raise MessageError("too-long", f"an episode has at most {MOST_STEPS} steps: set max_episode_steps")


def split(request: Message, count: int) -> list[Message | None]:
    """What each area is asked, if anything."""
    arrays = list(request.arrays)
    areas = range(count)
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
    mask = bytes(arrays[0].data)
    seeds = struct.unpack(f"<{count}q", arrays[1].data)
    values = request.values if request.kind == "reset" else {}
    resets = [Message("reset", 0, {**values, "seed": seed}, arrays[2:]) for seed in seeds]
    return [resets[area] if mask[area] else steps[area] for area in areas]


def rows(array: Array | None, count: int) -> list[Array]:
    """One for each area, of the same memory."""
    if not array or array.shape[:1] != (count,):
        raise MessageError("wrong-areas", f"actions are not one row for each of {count} areas")
    size = math.prod(array.shape[1:]) * DTYPES[array.dtype]
    view = memoryview(array.data).cast("B")
    return [Array(array.dtype, array.shape[1:], bytes(view[i * size : i * size + size])) for i in range(count)]


def joined(kind: str, id: int, answers: list[Message], seen: list[Array]) -> Message:
    """One answer for all. Of an area that was not asked for it the answer is empty."""
    if kind == "render":
        return Message("picture", id, {}, [answer.arrays[0] for answer in answers])
    infos = []
    rewards = []
    flags = [bytearray(), bytearray()]
    for area, answer in enumerate(answers):
        rewards.append(float(answer.values.get("reward", 0)))
        for flag, name in zip(flags, ("terminated", "truncated"), strict=True):
            flag.append(bool(answer.values.get(name)))
        info = {name: value for name, value in answer.values.items() if name not in VERDICTS}
        if info:
            infos.append((area, info))
    count = len(answers)
    first = seen[0]
    arrays = [
        Array(first.dtype, (count, *first.shape), b"".join(bytes(array.data) for array in seen)),
        Array("float64", (count,), struct.pack(f"<{count}d", *rewards)),
        *(Array("uint8", (count,), bytes(flag)) for flag in flags),
    ]
    return Message("state", id, {"infos": ENCODER.encode(infos)}, arrays)
