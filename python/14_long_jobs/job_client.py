"""Lesson 14, the job's client: starts a job or comes back to it, watches and cancels it. The twin of JobClient.cs.

    with closing(JobClient(context, "tcp://127.0.0.1:5564", new_id())) as client:
        for news in client.watch(client.goal("picture", 100)):                    or: client.ask("status")
            print(news.kind, news.values)                                         client.cancel() in between

Again and again it asks the same: a goal that is there is only watched. So it makes no difference what was lost,
and who was started again. What comes is the newest state; the last message is the result.
Take home: this file, with messages.py of lesson 05.
"""

import sys
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import zmq

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import LIMIT, Message, MessageError, read, take

# Seconds. The server tells what is new for five after it was asked.
AGAIN = 1.0


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
        patience: float = 1,
        tries: int = 10,
        report: Callable[[str], object] = print,
    ) -> None:
        self.context, self.endpoint, self.job, self.patience, self.tries = context, endpoint, job, patience, tries
        self.report, self.request, self.socket = report, self.ask("status"), self.connect()

    def goal(self, kind: str, count: int, text: str = "") -> Message:
        return self.ask("goal", kind=kind, count=count, text=text)

    def ask(self, verb: str, **values: str | int) -> Message:
        return Message(verb, values={"job": self.job, **values})

    def watch(self, request: Message) -> Iterator[Message]:
        """What is new about the job, up to its result. MessageError if it is rejected, TimeoutError without a word."""
        self.request, silent, seq, since = request, 0, -1, time.monotonic()
        while True:
            self.send(self.request)
            # Twice within its patience: work that has nothing to say for so long is no server that is away.
            again = time.monotonic() + min(AGAIN, self.patience / 2)
            while time.monotonic() < again:
                for news in self.arrived():
                    since, silent = time.monotonic(), 0
                    # What is not newer was told already: the answer to the same question.
                    if news.kind == "forgotten" or take(news.values, "seq", int) > seq:
                        seq = news.values.get("seq", seq)
                        yield news
                    if news.kind in ("result", "forgotten"):
                        return
            if time.monotonic() < since + self.patience:
                continue
            silent += 1
            if silent == self.tries:
                why = f"no word of it from {self.endpoint} in {silent} tries of {self.patience:g} s"
                raise TimeoutError(f"{why}; is the server running? Its id is {self.job}")
            # A new socket helps, whatever was wrong with this one.
            self.report(f"no word within {self.patience:g} s; try {silent + 1} of {self.tries}")
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
            self.report(f"dropped: {error}")
            return
        if news.kind == "rejected":
            raise MessageError(take(news.values, "code", str), take(news.values, "text", str))
        if news.values.get("job") == self.job:
            yield news

    def send(self, request: Message) -> None:
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
