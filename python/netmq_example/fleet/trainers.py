"""Lesson 17, a trainer as the hub sees it: N areas, which are stepped together, each an episode of its own."""

import time
from collections import Counter
from collections.abc import Callable
from functools import partial

from netmq_example.fleet.batch import Episode, check, joined, split
from netmq_example.messages import Message, MessageError


class Trainer:
    """Its request, until all areas have answered it, and what it was answered last."""

    def __init__(self, name: str, areas: int, send: Callable[[Message], bool], count: Counter[str]) -> None:
        if not 0 < areas <= 1024:
            raise MessageError("bad-areas", f"a trainer has 1 to 1024 areas, not {areas}")
        self.name, self.areas, self.send, self.count = name, areas, send, count
        self.episodes: list[Episode | None] = [None] * areas
        # `left`: the areas whose answers are still to come.
        self.request, self.kept, self.left = Message("join"), Message("alive"), set[int]()
        # Whether it was told of simulators; and when it was told anything.
        self.admitted, self.there, self.told = False, True, time.monotonic()

    def take(self, request: Message) -> None:
        """A new request is split among the areas. One that comes again gets its answer again, if there is one."""
        if request.id <= self.request.id:
            if not self.left:
                self.tell(self.kept)
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
            check(self.episodes, parts)
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
            # It is told once: the next request may be for others.
            episode.answer = None
        if errors := [answer.values for answer in answers if answer.kind == "error"]:
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
        self.tell(answer)

    def tell(self, message: Message) -> None:
        self.told, self.there = time.monotonic(), self.send(message)

    def release(self) -> None:
        """It is gone, or has closed: nobody works for it any more."""
        for episode in filter(None, self.episodes):
            episode.release()
        self.episodes, self.left = [None] * self.areas, set()
