"""A client that keeps many requests under way, and gets each reply as soon as it is ready.

    with ManyRequester("tcp://127.0.0.1:5556") as requester:
        for number, reply, error in requester.request_many(["echo one", "sleep 1", "echo two"]):
            print(number, reply or error)

Bytes: UTF-8 text, two frames each way, [id][text], at most 65,536 bytes each. Each request has an id that nobody else's
has, NUMBER-NAME, and a retry carries the same. The server is a ROUTER: a REP takes no message without REQ's empty
frame. In C# it is ManyRequester.cs.
"""

import time
import uuid
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import zmq

from netmq_example import arguments, check
from netmq_example.errors import Error, MessageError, Timeout
from netmq_example.former import positional
from netmq_example.lazy_pirate import refused
from netmq_example.one_process import Keys, one_at_a_time
from netmq_example.program import LARGEST_BYTES, Context, text_of
from netmq_example.requester import Client
from netmq_example.trouble import cure, longer, tried

# The deadlines are checked this often. Shorter would cost more. Longer, and Ctrl-C would have to wait on Windows.
SLICE_SECONDS = 0.05
# So many waiting messages are read at a time.
MOST_MESSAGES = 1000


class Outcome(NamedTuple):
    """The outcome of a request, which is the first one where `number` is 1.

    `reply` is the text as it came. `error` is None, or says why there is no reply; for one that begins with `error:`
    it is Refused.
    """

    number: int
    reply: str
    error: Error | None


@dataclass
class Pending:
    """A request under way: its try, when that was sent, and for how many seconds it may take."""

    number: int
    text: bytes
    timeout: float
    attempt: int = 1
    sent: float = 0


class ManyRequester(Client):
    """Keeps up to `window` requests under way over one DEALER socket at a time. Use it on one thread."""

    @positional("context", "endpoint", "window", "timeout", "tries", "report")
    def __init__(
        self,
        endpoint: str,
        *,
        window: int = 64,
        timeout: float = 2.5,
        tries: int = 3,
        keys: Keys | None = None,
        context: Context | None = None,
    ) -> None:
        """The first try waits `timeout` seconds for its reply, and each one after it twice as long, up to 8 times.

        Each retry is logged as a warning. Without a context it takes pyzmq's own, zmq.Context.instance().
        """
        super().__init__(endpoint, "tcp://127.0.0.1:5556", timeout, tries, keys, context, beacon=False)
        self.window = check.count("window", window)
        # What is under way, by its id.
        self.pending: dict[bytes, Pending] = {}
        self.name = uuid.uuid4().hex.encode()
        self.last_id = 0
        self.connect()

    def connect(self) -> None:
        self.socket = self.prepared(zmq.DEALER)
        self.socket.rcvtimeo = int(SLICE_SECONDS * 1000)
        # The window is the limit of what is under way; no second one is needed.
        self.socket.sndhwm = 0
        try:
            self.socket.connect(self.endpoint)
        except zmq.ZMQError:
            self.close()
            raise
        self.heard = time.monotonic()

    def close(self) -> None:
        """Close the socket. Twice is once."""
        self.socket.close()

    def request_many(self, texts: Iterable[str]) -> Iterator[Outcome]:
        """The outcome of each request, in order of arrival.

        It takes the next text when there is room for it, so `texts` may be endless; but what makes them must not wait:
        no reply is read meanwhile.
        """
        arguments.not_closed("this requester", self.socket)
        if isinstance(texts, str) or not isinstance(texts, Iterable):
            raise TypeError(f"texts takes a list of texts, not {texts!r:.40}")
        return self.outcomes(texts)

    @one_at_a_time
    def outcomes(self, texts: Iterable[str]) -> Iterator[Outcome]:
        self.pending.clear()
        # Outcomes that the caller does not have yet: how long it takes for one is not the server's time.
        outcomes: deque[Outcome] = deque()
        upcoming = enumerate(texts, 1)
        next_look = time.monotonic() + SLICE_SECONDS
        while True:
            while len(self.pending) + len(outcomes) < self.window:
                number, text = next(upcoming, (0, ""))
                if not number:
                    break
                encoded = check.instance("texts", text, str).encode(errors="replace")
                # The server would disconnect a client that sends it, and all that is under way would be lost.
                if len(encoded) > LARGEST_BYTES:
                    why = f"not sent: {len(encoded)} bytes, and the limit is {LARGEST_BYTES}"
                    yield Outcome(number, "", MessageError(why))
                    continue
                self.last_id += 1
                self.send(b"%d-%b" % (self.last_id, self.name), Pending(number, encoded, self.timeout))
            if not self.pending and not outcomes:
                return
            outcomes += self.arrived(not outcomes)
            if time.monotonic() >= next_look:
                outcomes += self.overdue()
                next_look = time.monotonic() + SLICE_SECONDS
            if outcomes:
                yield outcomes.popleft()

    def arrived(self, wait: bool) -> Iterator[Outcome]:
        """The replies that are there; the first one may be waited for."""
        flags = 0 if wait else zmq.NOBLOCK
        # A server may send faster than this loop takes.
        for _ in range(MOST_MESSAGES):
            try:
                frames = self.socket.recv_multipart(flags)
            except zmq.Again:
                return
            flags = zmq.NOBLOCK
            self.heard = time.monotonic()
            entry = self.pending.get(frames[0])
            # One for a request that is not pending is late or a second one: dropped.
            if len(frames) != 2 or not entry:
                continue
            # So is a refusal, until the last try: such a request is asked again when its timeout is over.
            if frames[1].startswith(b"error: busy") and entry.attempt < self.tries:
                continue
            del self.pending[frames[0]]
            reply = text_of(frames[1])
            yield Outcome(entry.number, reply, refused(reply))

    def overdue(self) -> Iterator[Outcome]:
        """A request that waits for too long is sent again with its old id, or given up."""
        now = time.monotonic()
        late = {key: entry for key, entry in self.pending.items() if entry.sent + entry.timeout <= now}
        question = "is the server running, slow, or its reply over 64 KB?"
        if any(self.heard <= entry.sent for entry in late.values()):
            # Nothing was received since then, neither for it nor for others: a new socket helps, whatever is wrong.
            self.close()
            self.connect()
            # All that was under way on it is lost. To send it again before its timeout is over is not another try.
            for request_id in self.pending.keys() - late:
                self.send(request_id, self.pending[request_id])
            if any(entry.attempt == self.tries for entry in late.values()):
                question = cure(self.endpoint, question)
        for request_id, entry in late.items():
            within = f"{entry.timeout:g} s"
            if entry.attempt == self.tries:
                del self.pending[request_id]
                why = f"no reply in {tried(self.tries)} of up to {within}; {question}"
                yield Outcome(entry.number, "", Timeout(why))
                continue
            entry.timeout = longer(self.timeout, entry.attempt)
            entry.attempt += 1
            self.report(f"{entry.number}: no reply within {within}; try {entry.attempt} of {self.tries}")
            self.send(request_id, entry)

    def send(self, request_id: bytes, entry: Pending) -> None:
        self.pending[request_id] = entry
        entry.sent = time.monotonic()
        try:
            self.socket.send_multipart([request_id, entry.text], zmq.NOBLOCK)
        except zmq.Again:
            # After a peer that broke the protocol there is nothing to send on. Then the next try has a new socket.
            pass
