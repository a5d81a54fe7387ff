"""The jobs of a server: each ends exactly once, whatever is lost and whichever side is started again.

    jobs = Jobs("long_jobs.sqlite3", {"count": Kind(count, most=10_000)}, workers=2)
    with closing(jobs):
        while True:
            jobs.exchange(socket)                               with its clients, for 0.1 s at most; it is a ROUTER

A client makes the job's id, and sends one of:

    goal       begins the job, unless there is one with this id already
    cancel     asks for its end; after the end it changes nothing
    status     only asks
    forget     after the end: its result is deleted; its id stays known for 24 hours, so that a late goal begins nothing

The server answers with the job's state, or with `rejected` and the reason:

    accepted  ->  feedback, feedback, …  ->  result          whose status is succeeded, canceled or aborted
                             canceling   ->  result

The same goal again is the same job. So a lost answer, a new connection, a second client that watches and a restart of
either side are all one case. The journal knows of every message before a client does.
"""

import contextlib
import logging
import sqlite3
import time
from collections import deque
from dataclasses import dataclass, field

import zmq

from netmq_example import check
from netmq_example.jobs.client import job_id
from netmq_example.jobs.journal import Journal, Place
from netmq_example.jobs.workers import Workers
from netmq_example.messages import Message, MessageError, take
from netmq_example.work import Kind

# For which a client is told what is new after it asked: for one that is gone or stuck nothing piles up.
WATCH_SECONDS = 5.0
# So often a job may take its process with it.
MOST_DEATHS = 3
# Of a goal's text.
MOST_CHARACTERS = 1000
log = logging.getLogger("netmq_example.jobs")
NOT_WRITTEN = MessageError("journal", "the server cannot write its journal now; try again later")


@dataclass
class Job:
    """One that has not ended: its goal, and the newest message about it."""

    goal: Message
    news: Message
    # The clients that are told what is new, and until when.
    watchers: dict[bytes, float] = field(default_factory=dict)
    # When a worker that ignores a cancel has had time enough, and how often one died.
    kill_at: float = 0
    deaths: int = 0

    @property
    def done(self) -> int:
        return int(self.news.values.get("done", 0))

    @property
    def begun(self) -> bool:
        return self.news.kind != "accepted" or self.news.values["position"] == 0

    def canceling(self) -> Message:
        facts = {"done": 0, "total": self.goal.values["count"], "text": ""}
        return Message("canceling", values=facts | self.news.values, arrays=self.news.arrays)

    def result(self, status: str, why: str = "") -> Message:
        """Its end, as far as it is."""
        facts = self.canceling().values
        return Message("result", values=facts | {"status": status, "text": why}, arrays=self.news.arrays)


class Jobs:
    """`answer` what clients send, then take a `turn`, which returns what is to be sent. `live` has what has not ended.

    At most `queue` jobs wait for a worker. One that ignores a cancel is killed after `grace` seconds. Use it on one
    thread.
    """

    def __init__(
        self, journal: Journal | Place, kinds: dict[str, Kind], workers: int = 2, queue: int = 100, grace: float = 2
    ) -> None:
        self.journal = journal if isinstance(journal, Journal) else Journal(journal)
        self.kinds = kinds
        self.queue = check.count("queue", queue)
        self.grace = check.seconds("grace", grace, zero=True)
        self.workers = Workers(workers, kinds)
        self.live: dict[str, Job] = {}
        self.waiting = deque[str]()
        # News that is not in the journal yet.
        self.pending: dict[str, Message] = {}
        self.outbox: list[tuple[bytes, Message]] = []
        for goal, news in reversed(self.journal.open()):
            id = goal.values["job"]
            self.live[id] = Job(goal, news)
            self.interrupted(id, "the server was restarted")

    def close(self) -> None:
        """End the workers at once. Another server may have the journal from now on."""
        self.workers.close()
        self.journal.close()

    # Messages of clients

    def exchange(self, socket: zmq.Socket[bytes]) -> None:
        """Receive some of what clients have sent, and send them what there is to tell."""
        # A wait with a limit: on Windows Ctrl-C is heard only between two waits, and a worker's time may be over.
        zmq.select([socket, self.workers.wake_socket], [], [], 0.1)
        with contextlib.suppress(zmq.Again):
            # Not until there are no more: the workers have their turn, too.
            for _ in range(100):
                client, *frames = socket.recv_multipart(zmq.NOBLOCK)
                self.answer(client, frames)
        for client, news in self.turn():
            # This never waits: ROUTER drops what is for a client that has gone, or does not read: it asks again.
            socket.send_multipart([client, *news.frames()])

    def answer(self, client: bytes, frames: list[bytes]) -> None:
        """The next turn returns the reply."""
        request = Message("")
        try:
            request = Message.read(frames)
            reply = self.do(request)
        except MessageError as error:
            # A longer text is no id, and written anew it might not fit in a header any more.
            job = str(request.values.get("job", ""))[:64]
            reply = Message("rejected", values={"job": job, "code": error.code, "text": error.text})
        self.outbox.append((client, reply))
        if reply.kind != "rejected" and reply.values["job"] in self.live:
            self.live[reply.values["job"]].watchers[client] = time.monotonic() + WATCH_SECONDS

    def do(self, request: Message) -> Message:
        """Where the job stands; MessageError says why there is no answer."""
        id = take(request.values, "job", str)
        try:
            job_id("job", id)
        except ValueError:
            raise MessageError("bad-job", "'job' must have 1 to 64 letters, digits or -") from None
        if request.kind == "goal":
            self.begin(id, request)
        elif request.kind == "cancel":
            if id in self.live and not self.cancel(id):
                raise NOT_WRITTEN
        elif request.kind == "forget":
            if id in self.live:
                raise MessageError("not-ended", "cancel it first")
            if not self.journal.save([Message("forgotten", values={"job": id})]):
                raise NOT_WRITTEN
        elif request.kind != "status":
            raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of goal, cancel, status, forget")
        known = self.find(id)
        if not known:
            raise MessageError("unknown-job", "there is no such job; was it given to another server, or is it too old?")
        news = known[1]
        if news.kind == "accepted" and id in self.waiting:
            # It has moved up since.
            return Message("accepted", values=news.values | {"position": self.waiting.index(id) + 1})
        return news

    def begin(self, id: str, request: Message) -> None:
        """Begin a job, unless it is there already."""
        known = self.find(id)
        goal = self.read_goal(id, request)
        if known:
            if known[0].values != goal.values:
                raise MessageError("other-goal", "this id belongs to a job with another goal")
            return
        if len(self.waiting) >= self.queue and not self.workers.idle:
            raise MessageError("queue-full", f"{self.queue} jobs wait already; try again later")
        news = Message("accepted", values={"job": id, "seq": 0, "position": len(self.waiting) + 1})
        if not self.journal.add(goal, news):
            raise NOT_WRITTEN
        self.live[id] = Job(goal, news)
        self.waiting.append(id)
        self.start()

    def read_goal(self, id: str, request: Message) -> Message:
        kind, count = take(request.values, "kind", str), take(request.values, "count", int)
        if kind not in self.kinds or not 1 <= count <= self.kinds[kind].most:
            kinds = ", ".join(f"{name} up to {kind.most}" for name, kind in self.kinds.items())
            raise MessageError("bad-goal", f"{kind!a:.40} with count {count} is none of: {kinds}")
        text = take({"text": ""} | request.values, "text", str)
        if len(text) > MOST_CHARACTERS:
            raise MessageError("bad-goal", f"'text' has {len(text)} characters; the most are {MOST_CHARACTERS}")
        return Message("goal", values={"job": id, "kind": kind, "count": count, "text": text})

    def find(self, id: str) -> tuple[Message, Message] | None:
        """A job's goal and the newest message about it, of one that has ended from the journal."""
        if job := self.live.get(id):
            return job.goal, job.news
        try:
            return self.journal.find(id)
        except sqlite3.Error as error:
            raise MessageError("journal", str(error)) from None

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

    # Messages of workers

    def turn(self) -> list[tuple[bytes, Message]]:
        """Take in what workers have done, and start what waits. Returns what is to be sent, and to which client."""
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
        outbox = self.outbox
        self.outbox = []
        return outbox

    def start(self) -> None:
        """Start what waits, as far as there are workers."""
        while self.waiting and self.workers.ready():
            id = self.waiting[0]
            job = self.live[id]
            # It may do something from now on: that is in the journal before.
            if job.news.kind == "accepted" and not self.tell({id: Message("accepted", values={"position": 0})}):
                return
            self.waiting.popleft()
            goal = Message("goal", values=job.goal.values | {"done": job.done}, arrays=job.news.arrays)
            process = self.workers.start(goal)
            log.info("job %.8s: %s from %s, in process %s", id, goal.values["kind"], job.done, process)

    def interrupted(self, id: str, why: str) -> None:
        """Neither a result nor more feedback will come. With a checkpoint it goes on from there."""
        job = self.live[id]
        kind = self.kinds.get(job.goal.values["kind"])
        if job.news.kind == "canceling":
            self.pending[id] = job.result("canceled", "it did not listen, and was killed" if job.kill_at else why)
        elif not kind or not 1 <= job.goal.values["count"] <= kind.most:
            self.pending[id] = job.result("aborted", "the server does not know this kind of work any more")
        elif not job.begun or (kind.has_checkpoint and job.deaths < MOST_DEATHS):
            self.waiting.appendleft(id)
        else:
            self.pending[id] = job.result("aborted", why)

    def tell(self, news: dict[str, Message]) -> bool:
        """Write it down, then tell the clients that watch. False if it could not be written down."""
        for id, message in news.items():
            message.values |= {"job": id, "seq": self.live[id].news.values["seq"] + 1}
        if not self.journal.save([*news.values()]):
            return False
        now = time.monotonic()
        for id, message in news.items():
            job = self.live[id]
            job.news = message
            job.watchers = {client: until for client, until in job.watchers.items() if until > now}
            self.outbox += [(client, message) for client in job.watchers]
            if message.kind == "result":
                facts = message.values
                log.info("job %.8s: %s at %s of %s", id, facts["status"], facts["done"], facts["total"])
                del self.live[id]
                if id in self.waiting:
                    self.waiting.remove(id)
        return True
