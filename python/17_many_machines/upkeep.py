"""Lesson 17, upkeep: some times a second the hub looks at who is silent, gone or late, and who may begin.

Whoever is silent is told the last message once more: a simulator does nothing twice, and answers with what it has kept
(lesson 09). So one rule is retry, heartbeat and the way to learn of a death, because ROUTER says when a peer is gone.
"""

import time

from hub import Hub
from messages import Message
from trainers import Trainer

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
