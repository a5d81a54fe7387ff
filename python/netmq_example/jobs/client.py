"""The job's client: starts a job or comes back to it, watches it and cancels it.

    with JobClient("tcp://127.0.0.1:5564") as client:
        for news in client.watch(client.goal("picture", 100)):                    client.cancel() in between
            print(news.kind, news.values)

    with JobClient("tcp://127.0.0.1:5564", job=job) as client:                   comes back to the job with this id
        for news in client.watch(client.ask("status")): ...

The client repeats its request, and the server begins no job twice. So lost messages and restarts of either side do no
harm. The news is the newest state, as a message of `accepted`, `feedback` or `canceling`; the last one is the `result`.
In C# it is JobClient.cs, and JobNews.cs.
"""

import re
import time
import uuid
from collections.abc import Iterator
from typing import Any

import zmq

from netmq_example import arguments, check
from netmq_example.errors import Refused, Timeout
from netmq_example.former import positional
from netmq_example.messages import LIMIT, Message, MessageError, take
from netmq_example.one_process import one_at_a_time
from netmq_example.program import Context, Socket
from netmq_example.requester import Client
from netmq_example.trouble import longer, tried

STATUSES = ("succeeded", "canceled", "aborted")
# The values of a message about a job, besides the job.
STATE = {"seq": int, "done": int, "total": int, "text": str}
NEWS: dict[str, dict[str, type]] = {
    "accepted": {"seq": int, "position": int},
    "feedback": STATE,
    "canceling": STATE,
    "result": {**STATE, "status": str},
    "forgotten": {},
}
ENDS = ("result", "forgotten")
# The server tells a client what is new for five seconds after it asked.
ASK_AGAIN_SECONDS = 1.0
# On Windows Ctrl-C is heard only between two waits.
SLICE_MS = 20


def job_id(name: str, value: Any) -> str:
    if isinstance(value, str) and re.fullmatch("[0-9A-Za-z][0-9A-Za-z-]{0,63}", value):
        return value
    raise ValueError(f"{name} takes the id of a job, 1 to 64 letters, digits or -, not {value!r:.40}")


def check_news(news: Message) -> None:
    """MessageError unless it is a whole message about a job."""
    if news.kind not in NEWS:
        raise MessageError("unknown-kind", f"kind {news.kind!a:.40} is none of {', '.join(NEWS)}")
    for name, kind in NEWS[news.kind].items():
        if take(news.values, name, kind) and kind is int and news.values[name] < 0:
            raise MessageError("bad-value", f"'{name}' must be 0 or more")
    status = news.values.get("status")
    if news.kind == "result" and status not in STATUSES:
        raise MessageError("bad-status", f"status {status!a:.40} is none of {', '.join(STATUSES)}")


class JobClient(Client):
    """One job, over one DEALER socket at a time. Use it on one thread."""

    largest = LIMIT

    @positional("context", "endpoint", "job", "timeout", "tries", "report")
    def __init__(
        self,
        endpoint: str,
        *,
        job: str | None = None,
        timeout: float = 1.0,
        tries: int = 5,
        context: Context | None = None,
    ) -> None:
        """Without the id of a job it makes a new one.

        The first of at most `tries` tries waits `timeout` seconds for news, and each one after it twice as long, up to
        8 times. Each retry is logged as a warning.
        """
        super().__init__(endpoint, "tcp://127.0.0.1:5564", timeout, tries, context=context)
        # An id must never come twice, whichever program makes one: hence the uuid.
        self.job = uuid.uuid4().hex if job is None else job_id("job", job)
        self.request = self.ask("status")
        # The fault in a message of this try.
        self.dropped = ""
        # The socket's endpoint, as soon as it is known where the server is.
        self.where = ""
        self.socket = self.open()

    def goal(self, kind: str, count: int, text: str = "") -> Message:
        """The request that begins the job, for `watch`."""
        kind = check.instance("kind", kind, str)
        text = check.instance("text", text, str)
        return self.ask("goal", kind=kind, count=check.count("count", count), text=text)

    def ask(self, verb: str, **values: str | int) -> Message:
        """Another request about the job, for `watch`: `status` or `forget`."""
        return Message(arguments.text("verb", verb), values={"job": self.job, **values})

    @one_at_a_time
    def watch(self, request: Message) -> Iterator[Message]:
        """The news of the job, up to its result.

        Timeout if nothing comes in all tries; Refused if the server rejects the job or has forgotten it; MessageError
        if it sends something else than news.
        """
        self.request = check.instance("request", request, Message)
        seq = -1
        silent_tries = 0
        heard_at = time.monotonic()
        while True:
            repeated = False
            self.send(self.request)
            # Twice within its timeout: work that has nothing to say for so long is no server that is away.
            ask_again_at = time.monotonic() + min(ASK_AGAIN_SECONDS, self.timeout / 2)
            while time.monotonic() < ask_again_at:
                news = self.receive()
                if not news:
                    continue
                # The same number was told already: the answer to the same question. A lower one is new, too: the
                # server has begun the job once more, with another journal.
                if news.kind not in ENDS and news.values["seq"] == seq:
                    repeated = True
                    continue
                seq = news.values.get("seq", seq)
                yield news
                if news.kind in ENDS:
                    return
                silent_tries = 0
                # How long the caller takes for it is no silence of the server's.
                heard_at = time.monotonic()
            # Where its newer words cannot be read, to repeat the old ones is no news.
            if repeated and not self.dropped:
                silent_tries = 0
                heard_at = time.monotonic()
            timeout = longer(self.timeout, silent_tries)
            if time.monotonic() < heard_at + timeout:
                continue
            silent_tries += 1
            if silent_tries == self.tries:
                why = f"no word of it from {self.endpoint} in {tried(self.tries)} of up to {timeout:g} s"
                raise Timeout(
                    f"{why}; {self.dropped or self.search.cure('is the server running?')} Its id is {self.job}"
                )
            self.report(f"no word within {timeout:g} s; try {silent_tries + 1} of {self.tries}")
            # A new socket helps, whatever was wrong with this one.
            self.socket.close()
            self.socket = self.open()
            self.dropped = ""
            heard_at = time.monotonic()

    def cancel(self) -> None:
        """Ask for the job's end. It may come too late: the result says what it became."""
        self.request = self.ask("cancel")
        self.send(self.request)

    def receive(self) -> Message | None:
        """The next message about this job, if one comes soon."""
        try:
            news = Message.read(self.socket.recv_multipart())
        except zmq.Again:
            return None
        except MessageError as error:
            # One line for each try: many that are wrong must not fill a disk.
            if not self.dropped:
                self.report(f"dropped: {error}")
            self.dropped = f"{error}: are both sides of one release?"
            return None
        return self.checked(news)

    def checked(self, news: Message) -> Message | None:
        """The message, if it is about this job and is whole. Refused or MessageError: there is no job to be watched."""
        if news.kind == "rejected":
            raise Refused(take(news.values, "code", str), take(news.values, "text", str))
        if news.values.get("job") != self.job:
            return None
        check_news(news)
        if news.kind == "forgotten" and self.request.kind != "forget":
            raise Refused("forgotten", "its result was deleted; begin a job with a new id")
        return news

    def send(self, request: Message) -> None:
        self.check_process()
        if not self.where:
            self.where = self.search.find(SLICE_MS / 1000)
            if self.where:
                self.socket.connect(self.where)
        try:
            self.socket.send_multipart(request.frames(), zmq.NOBLOCK)
        except zmq.Again:
            # After a peer that broke the protocol, or before a beacon answers, there is no connection to send on. It is
            # asked again anyway.
            pass

    def open(self) -> Socket:
        socket = self.prepared(zmq.DEALER)
        socket.rcvtimeo = SLICE_MS
        self.where = ""
        return socket

    def close(self) -> None:
        """The job goes on without this client. Twice is once."""
        self.socket.close()
        self.search.close()
