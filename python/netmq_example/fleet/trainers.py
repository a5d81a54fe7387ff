"""Trainers as the hub sees them: N areas, which are stepped together, each an episode of its own.

    trainer = Trainer("CartPole", 2, send, count, room)  send(frames) is False if the trainer is gone
    trainer.take(request)                                a step, a message or close, for all areas
    trainer.under_way()                                  the episodes whose answers are still to come

A trainer's one request for all its areas is split into one for each, and their answers are joined. To a trainer the hub
is one scene with an agent in each area, or with one area the scene that is there, whoever acts in it. To a simulator it
is an environment, which never asks for more than an episode can be played again with.
"""

import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

from netmq_example.fleet import pieces
from netmq_example.fleet.exchange import Exchange, Playing
from netmq_example.fleet.members import MOST_AREAS, Episode, Part, size_of
from netmq_example.messages import Message, MessageError
from netmq_example.wire import trees
from netmq_example.wire.records import Record

# An episode is kept, so that it can be played again, and so it must end.
MOST_STEPS = 100_000


class Trainer:
    """Its request, until all areas have answered it, and its last answer."""

    def __init__(
        self, name: str, areas: int, send: Callable[[list[Any]], bool], count: Counter[str], room: Callable[[], int]
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
        self.exchange: Exchange | None = None
        # The answer to its last request, in frames.
        self.kept: list[Any] = []
        # Its settings by side channels, and the agents that play, where it has one scene.
        self.parameters: dict[bytes, bytes] = {}
        # The first agent of its scenes.
        self.agent = ""
        self.playing = Playing()
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
            self.answer(Message("closed", request.id).frames())
            # Its simulators are for others, also while it stays connected.
            self.there = False
            return
        if self.left:
            # Nothing else changes: the answer to the one under way is still to come.
            error = MessageError("one-at-a-time", f"request {self.request.id} is under way: wait for its answer")
            self.reply(Message.refusal(error, request.id).frames())
            return
        self.request, self.exchange = request, None
        try:
            if isinstance(request, Record):
                if not self.episodes[0]:
                    self.playing = Playing()
                self.exchange = Exchange(request, self.areas, self.parameters, self.playing)
            parts = self.exchange.parts if self.exchange else self.words(request)
            self.check(parts)
            self.size = self.size_with(parts)
        except MessageError as error:
            self.refuse(error)
            return
        if self.exchange:
            self.parameters = self.exchange.parameters
        self.left = set(parts)
        for area, part in parts.items():
            self.ask(area, part)
        if not parts:
            self.finish()

    def ask(self, area: int, part: Any) -> None:
        episode = self.episodes[area]
        if episode and not begins(part):
            episode.ask(part)
            return
        if episode:
            episode.release()
        self.count["episodes"] += 1
        self.episodes[area] = Episode(part, partial(self.ready, area))

    def words(self, request: Message) -> dict[int, Any]:
        if request.kind == "render" and not request.arrays:
            return dict.fromkeys(range(self.areas), Message("render"))
        if request.kind != "info":
            raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of render, info, close")
        tree = pieces.taken(request.arrays[0].data) if request.arrays else None
        if not isinstance(tree, list) or len(tree) != 2:
            raise MessageError("bad-info", "an info is a list: for whom it is, and what")
        name = pieces.text_in(tree[0])
        if self.areas == 1 or not name:
            return dict.fromkeys(range(self.areas), Message("info", 0, {}, request.arrays))
        # To a trainer of several scenes their agents have numbers.
        number = name.rpartition("_")[2]
        if not number.isdecimal() or int(number) >= self.areas:
            raise MessageError("no-agent", f"no agent is named {name!a:.40}")
        return {int(number): Message("info", 0, {}, [trees.array_of(trees.write([self.agent, tree[1]]))])}

    def check(self, parts: dict[int, Any]) -> None:
        """MessageError before anything is begun: half a step would be none."""
        for area, part in parts.items():
            episode = self.episodes[area]
            if not episode and not begins(part):
                raise MessageError("no-episode", f"area {area} was never reset")
            if episode and not begins(part) and len(episode.requests) > MOST_STEPS:
                cure = "set max_episode_steps, and reset all agents at once"
                raise MessageError("too-long", f"an episode has at most {MOST_STEPS} steps: {cure}")

    def size_with(self, parts: dict[int, Any]) -> int:
        """MessageError if there is no room for these requests: an episode is kept until the next one begins."""
        here = {area: episode.size for area, episode in enumerate(self.episodes) if episode}
        for area, part in parts.items():
            here[area] = size_of(part) + (0 if begins(part) else here[area])
        size = sum(here.values()) + (len(self.exchange.after) if self.exchange else 0)
        if size > self.room():
            cure = "end them sooner (max_episode_steps), or train with fewer areas"
            raise MessageError("too-much", f"the hub keeps episodes until they end, and has no more room: {cure}")
        return size

    def under_way(self) -> list[Episode]:
        return [episode for area in self.left if (episode := self.episodes[area])]

    def ready(self, area: int) -> None:
        """An area has answered. After the last one the trainer gets all of it."""
        episode = self.episodes[area]
        if self.exchange and episode and isinstance(episode.answer, Record):
            if part := self.exchange.again(area, episode.answer):
                self.ask(area, part)
                return
            if self.areas == 1 and (part := self.exchange.anew(episode.answer)):
                self.count["episodes"] += 1
                episode.anew(part)
        self.left.discard(area)
        if not self.left:
            self.finish()

    def finish(self) -> None:
        answers = {area: episode.answer for area, episode in enumerate(self.episodes) if episode and episode.answer}
        for area in answers:
            # It is sent once: the next request may be for others.
            self.episodes[area].answer = None  # type: ignore[union-attr]
        errors = [answer.values for answer in answers.values() if answer.kind == "error"]
        if errors:
            for area, episode in enumerate(self.episodes):
                if episode and episode.seen is None:
                    # An episode that began with an error is none.
                    episode.release()
                    self.episodes[area] = None
            self.refuse(MessageError(str(errors[0].get("code")), str(errors[0].get("text"))))
            return
        try:
            self.answer(self.joined(answers).frames())
        except MessageError as error:
            if self.exchange:
                # The worlds have gone on, and nobody has seen them: the episodes are over.
                self.release()
            self.refuse(error)

    def joined(self, answers: dict[int, Any]) -> Any:
        if self.exchange:
            return self.exchange.joined(answers)
        arrays = [array for answer in answers.values() for array in answer.arrays]
        if self.request.kind == "info":
            return Message("told", self.request.id)
        if self.areas > 1 and len(arrays) != self.areas:
            raise MessageError("no-picture", f"{len(arrays)} pictures are not one of each of {self.areas} areas")
        return Message("picture", self.request.id, {}, arrays)

    def refuse(self, error: MessageError) -> None:
        self.left.clear()
        self.answer(Message.refusal(error, self.request.id).frames())

    def give_up(self, text: str) -> None:
        self.release()
        self.refuse(MessageError("no-simulator", text))

    def answer(self, frames: list[Any]) -> None:
        self.kept = frames
        self.reply(frames)

    def reply(self, frames: list[Any]) -> None:
        self.sent = time.monotonic()
        self.there = self.send(frames)

    def release(self) -> None:
        """It is gone, or has closed: its simulators are for others."""
        for episode in filter(None, self.episodes):
            episode.release()
        self.episodes = [None] * self.areas
        self.size = 0
        self.left = set()


def begins(part: Any) -> bool:
    return isinstance(part, Part) and part.begins
