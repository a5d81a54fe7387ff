"""Lesson 17, upkeep: some times a second the hub looks at who is silent, gone or late, and who may begin.

Whoever is silent is told the last message once more: a simulator does nothing twice, and answers with what it has kept
(lesson 09). So one rule is retry, heartbeat and the way to learn of a death, because ROUTER says when a peer is gone.

Lesson 17, the hub: whoever comes is a simulator or a trainer, and the hub brings their episodes together.

    hub = Hub(socket, options, print)
    hub.take(peer, frames)      what a ROUTER socket received
    tick(hub)                   of upkeep.py, some times a second

A simulator says `hello` {name, build, dt, observation, action}, as in lesson 09, and gets `welcome` {silence}; a
trainer says `join` {name, areas}, and gets the hello of a simulator with so many areas, as in lesson 10, once so many
are there.
"""

import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

import zmq

from netmq_example.fleet.batch import Member, Refused, accept, fits
from netmq_example.fleet.trainers import Trainer
from netmq_example.messages import Message, MessageError, read, take


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


# Seconds of silence until the last message is sent again, and until a simulator without an answer is given up.
AGAIN, DEAF = 0.5, 60.0
# So many simulators may be lost at one request: what ends each of them must not go round.
LOST = 10


def tick(hub: Hub) -> None:
    """Called often; it does its work some times a second."""
    if (now := time.monotonic()) < hub.ticked + 0.1:
        return
    hub.ticked = now
    wanted = {trainer.name for trainer in hub.trainers.values()}
    here = wanted | {member.name for member in hub.members.values()}
    hub.hellos = {name: hello for name, hello in hub.hellos.items() if name in here}
    for peer, member in list(hub.members.items()):
        if member.there and now > max(member.heard, member.told) + AGAIN:
            member.tell()
        if member.name in wanted:
            # It may be needed yet: to begin at all, or when another one dies.
            member.wanted = now
        idle = member.free() and now > max(member.free_since, member.wanted) + hub.options.idle
        if not member.there:
            hub.lose(peer, "its connection is")
        elif idle or now > member.heard + DEAF:
            hub.send(peer, Message("close", member.last.id + 1))
            hub.lose(peer, f"nothing to do for {hub.options.idle:g} s" if idle else f"no answer for {DEAF:g} s")
    for peer, trainer in list(hub.trainers.items()):
        if trainer.there:
            # First: until then nobody knows what is missing.
            serve(hub, trainer, now)
            if now > trainer.told + AGAIN:
                # Its hello, until it asks for something: that may have gone to a connection that is no more.
                trainer.tell(trainer.kept if trainer.request.kind == "join" else Message("alive"))
        if not trainer.there:
            trainer.release()
            del hub.trainers[peer]
    hub.lease()


def serve(hub: Hub, trainer: Trainer, now: float) -> None:
    """It may begin when there is a simulator for each of its areas; and what is late is asked for elsewhere, too."""
    members = sum(member.name == trainer.name for member in hub.members.values())
    taken = sum(other.areas for other in hub.trainers.values() if other.admitted and other.name == trainer.name)
    if not trainer.admitted and trainer.areas <= members - taken:
        hello = hub.hellos[trainer.name]
        trainer.admitted = True
        trainer.answer(Message("hello", 0, {**hello.values, "areas": trainer.areas}, hello.arrays))
    elif not trainer.admitted:
        trainer.kept = Message("alive", 0, {"simulators": members, "taken": taken})
    for episode in trainer.under_way():
        if episode.lost >= LOST:
            where = f"request {episode.lost_at + 1} of an episode"
            trainer.give_up(f"{LOST} simulators, one after the other, were lost at {where}: see what they say")
            return
        if not episode.runs and now > episode.since + hub.options.timeout:
            text = f"no simulator for an episode within {hub.options.timeout:g} s: {members} are here, start more"
            trainer.give_up(text)
            return
        late = len(episode.runs) == 1 and episode.runs[0].busy and now > episode.runs[0].asked + hub.options.late
        if late and (free := hub.free(trainer.name)):
            hub.count["asked elsewhere"] += 1
            free.lease(episode)
