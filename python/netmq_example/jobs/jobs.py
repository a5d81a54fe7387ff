"""Lesson 14, the verbs: what a client may say about a job, and what it is answered.

    for client, news in exchange(jobs, socket): ...             one turn of the server, and what it has to send
    answer(jobs, client, frames)                                the reply, and what it sets off, is in jobs.outbox

    goal       begins the job, unless there is one with this id already
    cancel     asks for its end; after the end it changes nothing
    status     only asks
    forget     after the end: its result is deleted; its id stays known for 24 hours, so that a late goal begins nothing
Each is answered with where the job stands, or with why not, `rejected`.

Lesson 14, one job that has not ended: its goal, and the newest message about it.

    accepted  ->  feedback, feedback, …  ->  result          whose status is succeeded, canceled or aborted
                             canceling   ->  result

Lesson 14, the jobs: the rules by which each ends exactly once.

The client makes the id. The same goal again is the same job, and is answered with where it stands: so a lost answer, a
new connection, a second client that watches and a restart of either side are all one case. What is told is in the
journal before, and of a job with a result nothing else is ever told.
"""

import re
import sqlite3
import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field

import zmq

from netmq_example.jobs.journal import Journal
from netmq_example.jobs.work import KINDS
from netmq_example.jobs.workers import Workers
from netmq_example.messages import Message, MessageError, read, take


@dataclass
class Job:
    goal: Message
    news: Message
    # Who is told what is new, and until when.
    watchers: dict[bytes, float] = field(default_factory=dict)
    # When a worker that is deaf to cancel has had time enough, and how often one died.
    kill_at: float = 0
    deaths: int = 0

    @property
    def begun(self) -> bool:
        """It may have done something."""
        return self.news.kind != "accepted" or self.news.values["position"] == 0

    def canceling(self) -> Message:
        facts = {"done": 0, "total": self.goal.values["count"], "text": ""}
        return Message("canceling", values=facts | self.news.values, arrays=self.news.arrays)

    def result(self, status: str, why: str = "") -> Message:
        """Its end, as far as it is."""
        facts = self.canceling().values
        return Message("result", values=facts | {"status": status, "text": why}, arrays=self.news.arrays)


# Seconds for which a client is told what is new after it asked: for one that is gone or stuck nothing piles up.
WATCH = 5.0
# So often a job may take its process with it.
DEATHS = 3


class Jobs:
    """`add` and `cancel` jobs, then let a `turn` be taken; what is to be sent is then in `outbox`."""

    def __init__(self, journal: Journal, size: int, queue: int, grace: float) -> None:
        self.journal, self.workers, self.queue, self.grace = journal, Workers(size), queue, grace
        self.live: dict[str, Job] = {}
        self.waiting = deque[str]()
        # What happened and is not in the journal yet.
        self.pending: dict[str, Message] = {}
        self.outbox: list[tuple[bytes, Message]] = []
        for goal, news in reversed(journal.open()):
            self.live[id := goal.values["job"]] = Job(goal, news)
            self.interrupted(id, "the server was restarted")

    def add(self, goal: Message) -> bool:
        """False if it could not be written down."""
        news = Message("accepted", values={"job": goal.values["job"], "seq": 0, "position": len(self.waiting) + 1})
        if not self.journal.add(goal, news):
            return False
        self.live[goal.values["job"]] = Job(goal, news)
        self.waiting.append(goal.values["job"])
        self.start()
        return True

    def start(self) -> None:
        """What waits, as far as there are workers."""
        while self.waiting and self.workers.ready():
            job = self.live[id := self.waiting[0]]
            # It may do something from now on: that is in the journal before.
            if job.news.kind == "accepted" and not self.tell({id: Message("accepted", values={"position": 0})}):
                return
            self.waiting.popleft()
            done = job.news.values.get("done", 0)
            goal = Message("goal", values=job.goal.values | {"done": done}, arrays=job.news.arrays)
            process = self.workers.start(goal)
            print(f"job {id:.8}: {goal.values['kind']} from {done}, in process {process}", flush=True)

    def cancel(self, id: str) -> bool:
        """Ask for its end. False if that could not be written down."""
        job = self.live[id]
        # It has a result, which is only not written down yet: too late.
        if job.news.kind == "canceling" or self.pending.get(id, job.news).kind == "result":
            return True
        if not self.tell({id: job.result("canceled") if id in self.waiting else job.canceling()}):
            return False
        self.pending.pop(id, None)
        if id in self.live:
            self.workers.cancel(id)
            job.kill_at = time.monotonic() + self.grace
        return True

    def turn(self) -> None:
        """What the workers said, and who waited for it."""
        for id, message in self.workers.news().items():
            if not message:
                self.live[id].deaths += 1
                self.interrupted(id, "its worker died")
            elif message.kind == "result" or self.live[id].news.kind != "canceling":
                self.pending[id] = message
        for id in self.workers.busy:
            if 0 < self.live[id].kill_at < time.monotonic():
                self.workers.kill(id)
        if self.pending and self.tell(self.pending):
            self.pending = {}
        self.start()

    def interrupted(self, id: str, why: str) -> None:
        """Neither a result nor more feedback will come. With a checkpoint it goes on from there."""
        job = self.live[id]
        kind = KINDS.get(job.goal.values["kind"])
        if job.news.kind == "canceling":
            self.pending[id] = job.result("canceled", "it did not listen, and was killed" if job.kill_at else why)
        elif not kind:
            self.pending[id] = job.result("aborted", "the server does not know this kind of work any more")
        elif not job.begun or (kind.has_checkpoint and job.deaths < DEATHS):
            self.waiting.appendleft(id)
        else:
            self.pending[id] = job.result("aborted", why)

    def tell(self, news: dict[str, Message]) -> bool:
        """Write it down, then tell those who watch. False if it could not be written down."""
        for id, message in news.items():
            message.values |= {"job": id, "seq": self.live[id].news.values["seq"] + 1}
        if not self.journal.save([*news.values()]):
            return False
        now = time.monotonic()
        for id, message in news.items():
            job, facts = self.live[id], message.values
            job.news = message
            job.watchers = {client: until for client, until in job.watchers.items() if until > now}
            self.outbox += [(client, message) for client in job.watchers]
            if message.kind == "result":
                print(f"job {id:.8}: {facts['status']} at {facts['done']} of {facts['total']}", flush=True)
                del self.live[id]
                if id in self.waiting:
                    self.waiting.remove(id)
        return True


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
