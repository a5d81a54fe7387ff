"""Lesson 14, progress: what to say of a message about a job, and a bar on a terminal.

    progress = Progress()
    progress.show("job 4f2a93bc: 40 of 100", 0.4)              a bar; where no terminal is, a line at each tenth
    progress.show("job 4f2a93bc: canceling")                   a line of its own

Lesson 14, news: what a message about a job has to have, so that whoever gets it may rely on it.

    check(news)                         MessageError says what is missing, or is not what it should be

The C# side is JobNews.cs.

Lesson 14, the job's client: starts a job or comes back to it, watches and cancels it. In C#: JobClient.cs.

    with closing(JobClient(context, "tcp://127.0.0.1:5564", new_id())) as client:
        for news in client.watch(client.goal("picture", 100)):                    or: client.ask("status")
            print(news.kind, news.values)                                         client.cancel() in between

Again and again it asks the same: a goal that is there is only watched. So it makes no difference what was lost,
and who was started again. What comes is the newest state; the last message is the result.
"""

import sys
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import suppress

import zmq

from netmq_example.messages import LIMIT, Message, MessageError, read, take

STATUSES = ("succeeded", "canceled", "aborted")
# What a message about a job has, besides the job.
STATE = {"seq": int, "done": int, "total": int, "text": str}
NEWS: dict[str, dict[str, type]] = {
    "accepted": {"seq": int, "position": int},
    "feedback": STATE,
    "canceling": STATE,
    "result": {**STATE, "status": str},
    "forgotten": {},
}


def check(news: Message) -> None:
    """What a message about a job must have; MessageError says what it has not."""
    if news.kind not in NEWS:
        raise MessageError("unknown-kind", f"kind {news.kind!a:.40} is none of {', '.join(NEWS)}")
    for name, kind in NEWS[news.kind].items():
        take(news.values, name, kind)
    if news.kind == "result" and news.values["status"] not in STATUSES:
        status = news.values["status"]
        raise MessageError("bad-status", f"status {status!a:.40} is none of {', '.join(STATUSES)}")


# Seconds. The server tells what is new for five after it was asked.
AGAIN = 1.0
ENDS = ("result", "forgotten")


def new_id() -> str:
    """An id must never come twice, whoever else makes one: hence the uuid."""
    return uuid.uuid4().hex


class JobClient:
    """One job, over one DEALER socket at a time. Use it on one thread."""

    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        endpoint: str,
        job: str,
        timeout: float = 1,
        tries: int = 10,
        report: Callable[[str], object] = print,
    ) -> None:
        self.context, self.endpoint, self.job, self.timeout, self.tries = context, endpoint, job, timeout, tries
        self.report, self.request, self.socket, self.dropped = report, self.ask("status"), self.connect(), False

    def goal(self, kind: str, count: int, text: str = "") -> Message:
        return self.ask("goal", kind=kind, count=count, text=text)

    def ask(self, verb: str, **values: str | int) -> Message:
        return Message(verb, values={"job": self.job, **values})

    def watch(self, request: Message) -> Iterator[Message]:
        """What is new about the job, up to its result. MessageError if it is rejected or was forgotten, TimeoutError
        without a word."""
        self.request, silent, seq, since = request, 0, -1, time.monotonic()
        while True:
            self.send(self.request)
            # Twice within its timeout: work that has nothing to say for so long is no server that is away.
            again = time.monotonic() + min(AGAIN, self.timeout / 2)
            while time.monotonic() < again:
                for news in self.arrived():
                    since, silent = time.monotonic(), 0
                    # The same number was told already: the answer to the same question. A lower one is new, too: the
                    # server has begun the job once more, with another journal.
                    if news.kind in ENDS or news.values["seq"] != seq:
                        seq = news.values.get("seq", seq)
                        yield news
                    if news.kind in ENDS:
                        return
            if time.monotonic() < since + self.timeout:
                continue
            silent += 1
            if silent == self.tries:
                why = f"no word of it from {self.endpoint} in {silent} tries of {self.timeout:g} s"
                raise TimeoutError(f"{why}; is the server running? Its id is {self.job}")
            # A new socket helps, whatever was wrong with this one.
            self.report(f"no word within {self.timeout:g} s; try {silent + 1} of {self.tries}")
            self.close()
            self.socket, since = self.connect(), time.monotonic()

    def cancel(self) -> None:
        """Ask for the job's end. It may come too late: the result says what it became."""
        self.request = self.ask("cancel")
        self.send(self.request)

    def arrived(self) -> Iterator[Message]:
        """The next message about this job, if one comes soon."""
        try:
            news = read(self.socket.recv_multipart())
        except zmq.Again:
            return
        except MessageError as error:
            # One line for each time that it asks: many that are wrong must not fill a disk.
            if not self.dropped:
                self.report(f"dropped: {error}")
            self.dropped = True
            return
        if news.kind == "rejected":
            raise MessageError(take(news.values, "code", str), take(news.values, "text", str))
        if news.values.get("job") == self.job:
            check(news)
            if news.kind == "forgotten" and self.request.kind != "forget":
                raise MessageError("forgotten", "its result was deleted; begin a job with a new id")
            yield news

    def send(self, request: Message) -> None:
        self.dropped = False
        # Without waiting: after a peer that broke the protocol there may be no connection to send on.
        with suppress(zmq.Again):
            self.socket.send_multipart(request.frames(), zmq.NOBLOCK)

    def connect(self) -> zmq.Socket[bytes]:
        socket = self.context.socket(zmq.DEALER)
        # A request that nobody fetched is dropped with its socket; waiting for its delivery could take for ever.
        # A peer that announces more than the largest message is disconnected before it is in memory.
        socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, LIMIT, 20
        socket.connect(self.endpoint)
        return socket

    def close(self) -> None:
        self.socket.close()


WIDTH = 30


def words(news: Message) -> str:
    """In words; job_client.py has looked whether it is whole."""
    if news.kind == "accepted":
        position = news.values["position"]
        return "accepted" + (f", number {position} of those that wait" if position else "")
    if news.kind not in ("feedback", "result"):
        return news.kind
    text, place = news.values["text"], f"{news.values['done']} of {news.values['total']}"
    return (f"{news.values['status']} at {place}" if news.kind == "result" else place) + (f", {text}" if text else "")


def share(news: Message) -> float | None:
    """How much of it is done; only feedback moves the bar."""
    if news.kind != "feedback":
        return None
    return float(min(max(news.values["done"] / max(news.values["total"], 1), 0.0), 1.0))


class Progress:
    def __init__(self) -> None:
        self.tenth, self.bar = -1, sys.stdout.isatty()

    def show(self, line: str, share: float | None = None) -> None:
        if not self.bar:
            if share is None or int(share * 10) != self.tenth:
                print(line, flush=True)
        elif share is None:
            # Over the bar, of which nothing is left.
            print(f"\r{line}\x1b[K", flush=True)
        else:
            bar = "#" * int(share * WIDTH)
            print(f"\r[{bar:{WIDTH}}] {line}\x1b[K", end="", flush=True)
        self.tenth = -1 if share is None else int(share * 10)
