"""The hub: a simulator or a trainer comes to it, and it brings their episodes together.

    hub = Hub(socket, build="1", late=5, timeout=30, idle=15)               a bound ROUTER socket
    hub.take(peer, frames)                                                  what the socket received
    hub.tick()                                                              often: it does its work some times a second

A simulator says `hello` {name, build, dt, …}, as in lesson 09, and gets `welcome` {silence}; a trainer says `join`
{name, areas}, and gets the hello of a scene with so many agents, once so many simulators are there; one
area is a whole scene. What rows, options and infos mean is between those two: the hub hands them on as they are.

A peer that is silent gets its last message once more: a simulator does nothing twice, and answers with what it has kept
(lesson 09). So one rule is retry, heartbeat and the way to learn of a death, because ROUTER says when a peer is gone.
"""

import logging
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

from netmq_example import arguments, check
from netmq_example.fleet import pieces
from netmq_example.fleet.members import Member, NotTaken, accept, fits, kinds_in, offer, size_of
from netmq_example.fleet.trainers import Trainer
from netmq_example.messages import Message, MessageError, take
from netmq_example.one_connection import sent
from netmq_example.program import Socket
from netmq_example.wire import records

TICK_SECONDS = 0.1
# After so much silence the hub sends its last message again.
RESEND_SECONDS = 0.5
# The hub then gives up a simulator that is connected and does not answer.
UNANSWERED_SECONDS = 60.0
# Between two ticks so much time passes only where the hub itself is stopped.
ASLEEP_SECONDS = 5.0
# So many simulators may be lost at one request: a deadly one must not end the whole fleet.
MOST_LOST = 10
# The bytes that the hub keeps: a hello of each name, and the episodes of one trainer and of all.
MOST_HELLO_BYTES = 256 * 1024 * 1024
MOST_EPISODE_BYTES = 256 * 1024 * 1024
MOST_BYTES = 4 * MOST_EPISODE_BYTES

log = logging.getLogger("netmq_example.server")


class Hub:
    """All that have come, by their addresses: `members` are simulators, and `trainers`. Use it on one thread."""

    def __init__(
        self,
        socket: Socket,
        *,
        build: str = "1",
        late: float = 5.0,
        timeout: float = 30.0,
        idle: float = 15.0,
        report: Callable[[str], object] = log.info,
    ) -> None:
        """A line about what happens is logged, unless `report` takes it. Of the seconds

        late       is when an answer is asked for elsewhere, too,
        timeout    how long an episode waits for a simulator,
        idle       when a simulator without work is sent home.
        """
        if not hasattr(socket, "send_multipart"):
            raise TypeError(f"socket takes a bound ROUTER socket, not {socket!r:.40}")
        self.socket = socket
        # To send to a peer that is gone is an error.
        socket.router_mandatory = True
        self.report = arguments.function("report", report)
        self.build: str = check.instance("build", build, str)
        self.late = check.seconds("late", late)
        self.timeout = check.seconds("timeout", timeout)
        self.idle = check.seconds("idle", idle)
        self.members: dict[bytes, Member] = {}
        self.trainers: dict[bytes, Trainer] = {}
        # One of each name that is here: the others have the same spaces.
        self.hellos: dict[str, Message] = {}
        self.count = Counter[str]()
        self.ticked = 0.0

    def take(self, peer: bytes, frames: list[Any]) -> None:
        try:
            member = self.members.get(peer)
            message: Any = records.read_frames(records.ANSWERS if member else records.ASKS, frames)
            if member:
                if member.hears(message):
                    self.answered(peer, member, message)
                return
            if message.kind == "hello":
                self.welcome(peer, message)
            elif message.kind == "join":
                self.join(peer, message)
            elif peer in self.trainers and self.trainers[peer].admitted:
                self.trainers[peer].take(message)
            elif message.kind not in ("closed", "error"):
                raise MessageError("unknown-peer", "say hello or join, and wait for the answer", message.id)
        except MessageError as error:
            if isinstance(error, NotTaken):
                self.report(f"refused: {error}")
            sent(self.socket, peer, Message.refusal(error).frames())
        self.lease()

    def answered(self, peer: bytes, member: Member, answer: Any) -> None:
        if not fits(answer, member.asking):
            self.lose(peer, "its answer is not what it has announced")
        else:
            if member.episode and member.episode.differs(member.done, answer):
                which = f"simulator {member.number}"
                self.report(f"{which} goes another way than the one before it: use one build everywhere")
            member.take(answer)
        # In the middle of an episode no other simulator is needed.
        if member.free() or peer not in self.members:
            self.lease()

    def welcome(self, peer: bytes, hello: Message) -> None:
        name = take(hello.values, "name", str)
        accept(hello, self.build, self.hellos.get(name))
        others = (size_of(other) for each, other in self.hellos.items() if each != name)
        if sum(others) + size_of(hello) > MOST_HELLO_BYTES:
            raise NotTaken("too-many-worlds", "the hellos that are here fill the hub's room for them; try again later")
        self.hellos[name] = hello
        self.count["came"] += 1
        self.members[peer] = Member(self.count["came"], name, partial(sent, self.socket, peer))

    def join(self, peer: bytes, message: Message) -> None:
        name = take(message.values, "name", str)
        areas = take(message.values, "areas", int)
        if peer in self.trainers:
            self.trainers.pop(peer).release()
        send = partial(sent, self.socket, peer)
        self.trainers[peer] = Trainer(name, areas, send, self.count, partial(self.room, peer))

    def room(self, peer: bytes) -> int:
        others = sum(trainer.size for each, trainer in self.trainers.items() if each != peer)
        return min(MOST_EPISODE_BYTES, MOST_BYTES - others)

    def lease(self) -> None:
        """A simulator for each episode that has none."""
        for trainer in self.trainers.values():
            for episode in trainer.under_way():
                if episode.runs:
                    continue
                free = self.free(trainer.name)
                if not free:
                    # All of them want one of the same name: to look again for each would take the hub's time.
                    break
                if episode.leased:
                    self.count["begun anew"] += 1
                free.lease(episode)

    def free(self, name: str) -> Member | None:
        """The one that has been free for longest."""
        able = (member for member in self.members.values() if member.name == name and member.free())
        return min(able, key=lambda member: member.free_since, default=None)

    def lose(self, peer: bytes, why: str) -> None:
        member = self.members.pop(peer)
        if member.episode:
            member.episode.lost_by(member)
        self.report(f"simulator {member.number} is gone: {why}")

    def tick(self) -> None:
        """Look at what is silent, gone or late, and at what may begin."""
        now = time.monotonic()
        if now < self.ticked + TICK_SECONDS:
            return
        if now > self.ticked + ASLEEP_SECONDS:
            # This program was stopped, or its machine asleep: nobody else was silent.
            for member in self.members.values():
                member.heard = member.wanted = now
        self.ticked = now
        wanted = {trainer.name for trainer in self.trainers.values()}
        here = wanted | {member.name for member in self.members.values()}
        self.hellos = {name: hello for name, hello in self.hellos.items() if name in here}
        for peer, member in list(self.members.items()):
            if member.name in wanted:
                # It may be needed yet: to begin at all, or when another one dies.
                member.wanted = now
            self.look_after_member(peer, member, now)
        for peer, trainer in list(self.trainers.items()):
            if trainer.there:
                self.look_after_trainer(trainer, now)
            if not trainer.there:
                trainer.release()
                del self.trainers[peer]
        self.lease()

    def look_after_member(self, peer: bytes, member: Member, now: float) -> None:
        if member.there and now > max(member.heard, member.sent) + RESEND_SECONDS:
            member.send_last()
        idle = member.free() and now > max(member.free_since, member.wanted) + self.idle
        if not member.there:
            self.lose(peer, "its connection is")
        elif idle or now > member.heard + UNANSWERED_SECONDS:
            sent(self.socket, peer, Message("close", member.id + 1).frames())
            why = f"nothing to do for {self.idle:g} s" if idle else f"no answer for {UNANSWERED_SECONDS:g} s"
            self.lose(peer, why)

    def look_after_trainer(self, trainer: Trainer, now: float) -> None:
        # First: until then nobody knows what is missing.
        if not trainer.admitted:
            self.admit(trainer)
        self.look_after_episodes(trainer, now)
        if now > trainer.sent + RESEND_SECONDS:
            missing = sum(not episode.runs for episode in trainer.under_way())
            # Its hello, until it asks for something: that may have gone to a connection that is no more.
            joins = trainer.request.kind == "join"
            trainer.reply(trainer.kept if joins else Message("alive", 0, {"missing": missing}).frames())

    def admit(self, trainer: Trainer) -> None:
        """It may begin when there is a simulator for each of its areas."""
        members = self.members_of(trainer.name)
        taken = sum(other.areas for other in self.trainers.values() if other.admitted and other.name == trainer.name)
        if trainer.areas <= members - taken:
            try:
                trainer.answer(offer(self.hellos[trainer.name], trainer.areas).frames())
                trainer.agent = pieces.text_in(kinds_in(self.hellos[trainer.name])[0]["agents"][0])
                trainer.admitted = True
            except MessageError as error:
                trainer.refuse(error)
                trainer.there = False
        else:
            trainer.kept = Message("alive", 0, {"simulators": members, "taken": taken}).frames()

    def members_of(self, name: str) -> int:
        return sum(member.name == name for member in self.members.values())

    def look_after_episodes(self, trainer: Trainer, now: float) -> None:
        """What is late is asked for elsewhere, too; what no simulator can do is given up."""
        for episode in trainer.under_way():
            if episode.lost >= MOST_LOST:
                where = f"request {episode.lost_at + 1} of an episode"
                trainer.give_up(f"{MOST_LOST} simulators, one after the other, were lost at {where}: see what they say")
                return
            if not episode.runs and now > episode.since + self.timeout:
                here = f"{self.members_of(trainer.name)} are here, start more"
                trainer.give_up(f"no simulator for an episode within {self.timeout:g} s: {here}")
                return
            late = len(episode.runs) == 1 and episode.runs[0].busy and now > episode.runs[0].asked + self.late
            if late and (free := self.free(trainer.name)):
                self.count["asked elsewhere"] += 1
                free.lease(episode)
