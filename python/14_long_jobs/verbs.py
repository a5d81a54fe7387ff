"""Lesson 14, the verbs: what a client may say about a job, and what it is answered.

    for client, news in exchange(jobs, socket): ...             one turn of the server, and what it has to send
    answer(jobs, client, frames)                                the reply, and what it sets off, is in jobs.outbox

    goal       begins the job, unless there is one with this id already
    cancel     asks for its end; after the end it changes nothing
    status     only asks
    forget     after the end: its result is deleted; its id stays known for 24 hours, so that a late goal begins nothing
Each is answered with where the job stands, or with why not, `rejected`.
"""

import re
import sqlite3
import time
from collections.abc import Iterator
from contextlib import suppress

import zmq
from jobs import WATCH, Jobs
from messages import Message, MessageError, read, take
from work import KINDS

# So many messages are read before the workers have their turn, and so long may a goal's text be.
MOST, LONGEST = 100, 1000
NOT_WRITTEN = MessageError("journal", "the server cannot write its journal now; try again later")


def exchange(jobs: Jobs, socket: zmq.Socket[bytes]) -> Iterator[tuple[bytes, Message]]:
    # A wait with a limit: on Windows Ctrl-C does not interrupt a longer one, and a deaf worker has its time.
    zmq.select([socket, jobs.workers.bell], [], [], 0.1)
    with suppress(zmq.Again):
        for _ in range(MOST):
            client, *frames = socket.recv_multipart(zmq.NOBLOCK)
            answer(jobs, client, frames)
    jobs.turn()
    yield from jobs.outbox
    jobs.outbox.clear()


def answer(jobs: Jobs, client: bytes, frames: list[bytes]) -> None:
    request = Message("")
    try:
        request = read(frames)
        reply = do(jobs, request)
    except MessageError as error:
        job = request.values.get("job", "")
        reply = Message("rejected", values={"job": job, "code": error.code, "text": error.text})
    jobs.outbox.append((client, reply))
    # From here on it is told what is new, for a while.
    if reply.kind != "rejected" and (job := jobs.live.get(reply.values["job"])):
        job.watchers[client] = time.monotonic() + WATCH


def do(jobs: Jobs, request: Message) -> Message:
    """Where the job stands; MessageError says why there is no answer."""
    id = take(request.values, "job", str)
    if not re.fullmatch("[0-9A-Za-z][0-9A-Za-z-]{0,63}", id):
        raise MessageError("bad-job", "'job' must have 1 to 64 letters, digits or -")
    if request.kind not in ("goal", "cancel", "status", "forget"):
        raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of goal, cancel, status, forget")
    if request.kind == "goal":
        known, goal = find(jobs, id), read_goal(id, request)
        if known and known[0].values != goal.values:
            raise MessageError("other-goal", "this id belongs to a job with another goal")
        if not known and len(jobs.waiting) >= jobs.queue and not jobs.workers.idle:
            raise MessageError("queue-full", f"{jobs.queue} jobs wait already; try again later")
        if not known and not jobs.add(goal):
            raise NOT_WRITTEN
    if request.kind == "cancel" and id in jobs.live and not jobs.cancel(id):
        raise NOT_WRITTEN
    if request.kind == "forget" and id in jobs.live:
        raise MessageError("not-ended", "cancel it first")
    if request.kind == "forget" and not jobs.journal.save([Message("forgotten", values={"job": id})]):
        raise NOT_WRITTEN
    if not (known := find(jobs, id)):
        raise MessageError("unknown-job", "there is no such job; was it given to another server, or is it too old?")
    news = known[1]
    if news.kind == "accepted" and id in jobs.waiting:
        # It has moved up since.
        return Message("accepted", values=news.values | {"position": jobs.waiting.index(id) + 1})
    return news


def read_goal(id: str, request: Message) -> Message:
    kind, count = take(request.values, "kind", str), take(request.values, "count", int)
    if kind not in KINDS or not 1 <= count <= KINDS[kind].most:
        kinds = ", ".join(f"{name} up to {KINDS[name].most}" for name in KINDS)
        raise MessageError("bad-goal", f"{kind!a:.40} with count {count} is none of: {kinds}")
    text = take({"text": ""} | request.values, "text", str)
    if len(text) > LONGEST:
        raise MessageError("bad-goal", f"'text' has {len(text)} characters; the most are {LONGEST}")
    return Message("goal", values={"job": id, "kind": kind, "count": count, "text": text})


def find(jobs: Jobs, id: str) -> tuple[Message, Message] | None:
    """Its goal and the newest message about it, of one that has ended from the journal."""
    if job := jobs.live.get(id):
        return job.goal, job.news
    try:
        return jobs.journal.find(id)
    except sqlite3.Error as error:
        raise MessageError("journal", str(error)) from None
