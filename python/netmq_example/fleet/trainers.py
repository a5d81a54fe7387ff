"""Trainers as the hub sees them: N areas, which are stepped together, each an episode of its own.

    trainer = Trainer("CartPole", 2, send, count, room)  send(message) is False if the trainer is gone
    trainer.take(request)                                reset, step, render or close, for all areas
    trainer.under_way()                                  the episodes whose answers are still to come

A trainer's one message for all its areas is split into one for each, and their answers are joined. To a trainer the
hub is lesson 10's simulator with many areas, and to a simulator it is lesson 09's environment: what the messages hold
is described there.
"""

import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

from netmq_example.fleet.members import MOST_AREAS, Episode, size_of
from netmq_example.messages import LIMIT, Message, MessageError
from netmq_example.wire.records import ANSWERS, ASKS, EACH, HEAD, NOTHING, RESET, STEP, Record

# An episode is kept, so that it can be played again, and so it must end.
MOST_STEPS = 100_000


class Trainer:
    """Its request, until all areas have answered it, and its last answer."""

    def __init__(
        self, name: str, areas: int, send: Callable[[Any], bool], count: Counter[str], room: Callable[[], int]
    ) -> None:
        """`room` is how many bytes its episodes may take."""
        if not 0 < areas <= MOST_AREAS:
            raise MessageError("bad-areas", f"a trainer has 1 to {MOST_AREAS} areas, not {areas}")
        self.name = name
        self.areas = areas
        self.send = send
        self.count = count
        self.room = room
        # The size of its episodes in bytes.
        self.size = 0
        self.episodes: list[Episode | None] = [None] * areas
        self.request: Any = Message("join")
        self.kept: Any = Message("alive")
        # The areas whose answers are still to come.
        self.left: set[int] = set()
        # Whether it has got simulators, and when it was sent anything.
        self.admitted = False
        self.there = True
        self.sent = time.monotonic()

    def take(self, request: Any) -> None:
        """A new request is split among the areas. One that comes again gets its answer again, if there is one."""
        if request.id <= self.request.id:
            if not self.left:
                self.reply(self.kept)
            return
        if request.kind == "close":
            self.release()
            self.answer(Message("closed", request.id))
            # Its simulators are for others, also while it stays connected.
            self.there = False
            return
        if self.left:
            # Nothing else changes: the answer to the one under way is still to come.
            error = MessageError("one-at-a-time", f"request {self.request.id} is under way: wait for its answer")
            self.reply(Message.refusal(error, request.id))
            return
        self.request = request
        try:
            parts = {area: part for area, part in enumerate(split(request, self.areas)) if part}
            check_parts(self.episodes, parts)
            self.size = self.size_with(parts)
        except MessageError as error:
            self.refuse(error)
            return
        self.left = set(parts)
        for area, part in parts.items():
            episode = self.episodes[area]
            if episode and not begins(part):
                episode.ask(part)
                continue
            if episode:
                episode.release()
            self.count["episodes"] += 1
            # A row and an info, in a message with those of all areas.
            self.episodes[area] = Episode(part, partial(self.ready, area), (LIMIT - HEAD.size) // self.areas - EACH)
        if not parts:
            self.ready(0)

    def size_with(self, parts: dict[int, Any]) -> int:
        """MessageError if there is no room for these requests: an episode is kept until the next one begins."""
        here = {area: episode.size for area, episode in enumerate(self.episodes) if episode}
        for area, part in parts.items():
            here[area] = size_of(part) + (0 if begins(part) else here[area])
        size = sum(here.values())
        if size > self.room():
            cure = "end them sooner (max_episode_steps), or train with fewer areas"
            raise MessageError("too-much", f"the hub keeps episodes until they end, and has no more room: {cure}")
        return size

    def under_way(self) -> list[Episode]:
        """Those whose answers are still to come."""
        return [episode for area in self.left if (episode := self.episodes[area])]

    def ready(self, area: int) -> None:
        """An area has answered. After the last one the trainer gets all of it."""
        self.left.discard(area)
        if self.left:
            return
        episodes = [episode for episode in self.episodes if episode]
        answers = [episode.answer for episode in episodes]
        for episode in episodes:
            # It is sent once: the next request may be for others.
            episode.answer = None
        errors = [answer.values for answer in answers if answer and answer.kind == "error"]
        if errors:
            for area, episode in enumerate(episodes):
                if not episode.seen:
                    # An episode that began with an error is none.
                    episode.release()
                    self.episodes[area] = None
            self.refuse(MessageError(str(errors[0].get("code")), str(errors[0].get("text"))))
        else:
            self.answer(joined(self.request, answers, [episode.seen for episode in episodes]))

    def refuse(self, error: MessageError) -> None:
        self.left.clear()
        self.answer(Message.refusal(error, self.request.id))

    def give_up(self, text: str) -> None:
        self.release()
        self.refuse(MessageError("no-simulator", text))

    def answer(self, answer: Any) -> None:
        self.kept = answer
        self.reply(answer)

    def reply(self, message: Any) -> None:
        self.sent = time.monotonic()
        self.there = self.send(message)

    def release(self) -> None:
        """It is gone, or has closed: its simulators are for others."""
        for episode in filter(None, self.episodes):
            episode.release()
        self.episodes = [None] * self.areas
        self.size = 0
        self.left = set()


def begins(part: Any) -> bool:
    return isinstance(part, Record) and part.flags[0] == RESET


def check_parts(episodes: list[Episode | None], parts: dict[int, Any]) -> None:
    """MessageError before anything is begun: half a step would be none."""
    for area, episode in enumerate(episodes):
        part = parts.get(area)
        if not episode and not begins(part):
            raise MessageError("no-episode", f"area {area} was never reset")
        if episode and isinstance(part, Record) and part.flags[0] == STEP and len(episode.requests) > MOST_STEPS:
            raise MessageError("too-long", f"an episode has at most {MOST_STEPS} steps: set max_episode_steps")


def split(request: Any, count: int) -> list[Any]:
    """The request for each area, if there is one."""
    if isinstance(request, Message):
        if request.kind == "render" and not request.arrays:
            return [Message("render") for _ in range(count)]
        raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of reset, step, render, close")
    if len(request.flags) != count:
        cure = f"make_vec(…, num_envs={count}), and register a vector_entry_point"
        raise MessageError("wrong-areas", f"{count} simulators were asked for, and not {len(request.flags)}: {cure}")
    if request.exchange is not None:
        cure = "give them a connection of their own, as lesson 13's Carrier"
        raise MessageError("no-side-channels", f"the hub hands none on: {cure}")
    options = bytes(request.options)
    parts: list[Any] = []
    for area, (order, row) in enumerate(zip(request.flags, request.rows, strict=True)):
        seed = bytes(request.numbers[8 * area : 8 * area + 8])
        # It is kept, and so it must not keep the whole request.
        part = Record(ASKS, 0, seed, [order], [bytes(row)], options=options if order == RESET else b"")
        parts.append(part if order != NOTHING else None)
    return parts


def joined(request: Any, answers: list[Any], seen: list[bytes]) -> Any:
    """One answer for all. Of an area that was not asked there is what it saw last."""
    if isinstance(request, Message):
        return Message("picture", request.id, {}, [answer.arrays[0] for answer in answers])
    numbers = b"".join(bytes(answer.numbers) if answer else bytes(8) for answer in answers)
    flags = [answer.flags[0] if answer else 0 for answer in answers]
    infos = [answer.infos[0] if answer else b"" for answer in answers]
    return Record(ANSWERS, request.id, numbers, flags, seen, infos)
