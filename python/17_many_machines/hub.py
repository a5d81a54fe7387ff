"""Lesson 17, the hub: whoever comes is a simulator or a trainer, and the hub brings their episodes together.

    hub = Hub(socket, options, print)
    hub.take(peer, frames)      what a ROUTER socket received
    tick(hub)                   of upkeep.py, some times a second

A simulator says `hello` {name, build, dt, observation, action}, as in lesson 09, and gets `welcome` {silence}; a
trainer says `join` {name, areas}, and gets the hello of a simulator with so many areas, as in lesson 10, once so many
are there.
"""

import sys
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import zmq

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from batch import Refused, accept, fits
from episode import Member
from messages import Message, MessageError, read, take
from trainers import Trainer


class Hub:
    """`options` are server.py's: build, late, timeout, idle; `say` takes a line about what happens."""

    def __init__(self, socket: zmq.Socket[bytes], options: Any, say: Callable[[str], object]) -> None:
        self.socket, self.options, self.say, self.ticked = socket, options, say, 0.0
        self.members, self.trainers = dict[bytes, Member](), dict[bytes, Trainer]()
        # One of each name that is here: the others have the same spaces.
        self.hellos = dict[str, Message]()
        self.count = Counter[str]()

    def take(self, peer: bytes, frames: list[Any]) -> None:
        self.count["messages"] += 1
        try:
            message = read(frames)
            if member := self.members.get(peer):
                if member.hears(message):
                    self.answered(peer, member, message)
                return
            if message.kind == "hello":
                self.welcome(peer, message)
            elif message.kind == "join":
                self.join(peer, message)
            elif (trainer := self.trainers.get(peer)) and trainer.admitted:
                trainer.take(message)
            elif message.kind not in ("closed", "error"):
                raise MessageError("unknown-peer", "say hello or join, and wait for the answer", message.id)
        except MessageError as error:
            if isinstance(error, Refused):
                self.say(f"refused: {error}")
            self.send(peer, Message("error", error.id, {"code": error.code, "text": error.text}))
        self.lease()

    def answered(self, peer: bytes, member: Member, answer: Message) -> None:
        if not fits(answer, member.last.kind, self.hellos[member.name]):
            self.lose(peer, "its answer is not what it has announced")
        else:
            if member.episode and member.episode.differs(member.done, answer):
                self.say(f"simulator {member.number} goes another way than the one before it: use one build everywhere")
            member.take(answer)
        # In the middle of an episode nobody has to be looked for.
        if member.free() or peer not in self.members:
            self.lease()

    def welcome(self, peer: bytes, hello: Message) -> None:
        name = take(hello.values, "name", str)
        accept(hello, self.options.build, self.hellos.get(name))
        self.hellos[name] = hello
        self.count["came"] += 1
        self.members[peer] = Member(self.count["came"], name, partial(self.send, peer))

    def join(self, peer: bytes, message: Message) -> None:
        name, areas = take(message.values, "name", str), take(message.values, "areas", int)
        if old := self.trainers.pop(peer, None):
            old.release()
        self.trainers[peer] = Trainer(name, areas, partial(self.send, peer), self.count)

    def lease(self) -> None:
        """A simulator for each episode that has none."""
        for trainer in self.trainers.values():
            for episode in trainer.under_way():
                if not episode.runs and (free := self.free(trainer.name)):
                    self.count["begun anew"] += episode.leased
                    free.lease(episode)

    def free(self, name: str) -> Member | None:
        """The one that has been free for longest."""
        able = (member for member in self.members.values() if member.name == name and member.free())
        return min(able, key=lambda member: member.free_since, default=None)

    def lose(self, peer: bytes, why: str) -> None:
        member = self.members.pop(peer)
        if episode := member.episode:
            episode.lost_by(member)
        self.say(f"simulator {member.number} is gone: {why}")

    def send(self, peer: bytes, message: Message) -> bool:
        """False if it is gone, or takes nothing any more."""
        self.count["messages"] += 1
        try:
            self.socket.send_multipart([peer, *message.frames()], zmq.NOBLOCK)
        except zmq.ZMQError:
            return False
        return True
