"""Lesson 14, the jobs: the rules by which each ends exactly once.

The client makes the id. The same goal again is the same job, and is answered with where it stands: so a lost answer, a
new connection, a second client that watches and a restart of either side are all one case. What is told is in the
journal before, and of a job with a result nothing else is ever told.
"""

import time
from collections import deque

from job import Job
from job_journal import Journal
from messages import Message
from work import KINDS
from workers import Workers

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
