"""Lesson 17, the hub: whoever comes is a simulator or a trainer, and the hub brings their episodes together.

    hub = Hub(send, version="1")
    hub.take(peer, frames)      what a ROUTER socket received
    tick(hub)                   of upkeep.py, some times a second

A simulator says `hello` {name, version, dt, observation, action}, as in lesson 09, and gets `welcome`; a trainer says
`join` {name, areas}, and gets the hello of a simulator with so many areas, as in lesson 10, once so many are there.
Take home: this file, upkeep.py, trainers.py, episode.py and batch.py, with messages.py of lesson 05.
"""

import sys
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from batch import fits, form
from episode import Member
from messages import Message, MessageError, read, take
from trainers import Trainer

class Hub:
    """`late` is after how many seconds an answer is asked for elsewhere too, `patience` how long an episode waits for
    a simulator, `idle` after how long one without work is sent home, or 0."""

    def __init__(self, send: Callable[[bytes, Message], bool], options: Any, say: Callable[[str], object]) -> None:
        self.send, self.options, self.say = send, options, say
        self.members, self.trainers = dict[bytes, Member](), dict[bytes, Trainer]()
        self.hellos, self.count = dict[str, Message](), Counter[str]()

    def take(self, peer: bytes, frames: list[Any]) -> None:
        self.count["messages"] += 1
        try:
            message = read(frames)
            if (member := self.members.get(peer)) and message.kind != "state":
                member.take(message)
            elif member and fits(message, form(self.hellos[member.name])):
                member.take(message)
            elif member:
                self.lose(peer, "its observation is not what it has announced")
            elif message.kind == "hello":
                self.welcome(peer, message)
            elif message.kind == "join":
                self.join(peer, message)
            elif trainer := self.trainers.get(peer):
                trainer.take(message)
            elif message.kind not in ("closed", "error"):
                raise MessageError("unknown-peer", "say hello again", message.id)
        except MessageError as error:
            self.send(peer, Message("error", error.id, {"code": error.code, "text": error.text}))
        self.serve()

    def welcome(self, peer: bytes, hello: Message) -> None:
        name, version = take(hello.values, "name", str), hello.values.get("version", "1")
        try:
            if version != self.options.version:
                text = f"{name!a:.40} of version {version!a:.20}, this hub takes {self.options.version!a:.20}"
                raise MessageError("other-version", f"{text}: use one build everywhere")
            if form(self.hellos.setdefault(name, hello)) != form(hello):
                raise MessageError("other-spaces", f"{name!a:.40} has another dt here, or other spaces")
        except MessageError as error:
            self.say(f"refused: {error}")
            raise
        self.count["came"] += 1
        self.members[peer] = Member(self.count["came"], name, partial(self.send, peer))

    def join(self, peer: bytes, message: Message) -> None:
        name, areas = take(message.values, "name", str), take(message.values, "areas", int)
        if old := self.trainers.pop(peer, None):
            old.release()
        self.trainers[peer] = Trainer(name, areas, partial(self.send, peer), self.count)

    def serve(self) -> None:
        """A simulator for each episode that has none."""
        for trainer in self.trainers.values():
            for episode in trainer.under_way():
                if not episode.runs and (free := self.free(trainer.name)):
                    self.count["begun anew"] += len(episode.requests) > 1
                    free.lease(episode)

    def free(self, name: str) -> Member | None:
        """The one that has been free for longest."""
        able = (member for member in self.members.values() if member.name == name and member.free())
        return min(able, key=lambda member: member.free_since, default=None)

    def lose(self, peer: bytes, why: str) -> None:
        member = self.members.pop(peer)
        self.count["gone"] += 1
        if episode := member.episode:
            episode.runs.remove(member)
        self.say(f"simulator {member.number} is gone: {why}")
