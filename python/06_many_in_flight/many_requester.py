"""Lesson 06, the requester in Python: the twin of ManyRequester.cs.

    requester = ManyRequester(context, "tcp://127.0.0.1:5556", window=64, patience=2, tries=3, report=print)
    for number, reply, failure in requester.request_many(["echo one", "sleep 1", "echo two"]): ...

Take home: this file. The server is server.py, and its header says what the bytes are.
"""

import contextlib
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import zmq

# How often the deadlines are looked at. Shorter would cost more; longer, and Ctrl-C would have to wait on Windows.
SLICE = 0.05


@dataclass
class Pending:
    number: int
    text: str
    deadline: float
    tries: int = 1


class ManyRequester:
    """Keeps up to `window` requests under way over one DEALER socket at a time. Use it on one thread."""

    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        endpoint: str,
        window: int,
        patience: float,
        tries: int,
        report: Callable[[str], None],
    ) -> None:
        self.context, self.endpoint, self.report = context, endpoint, report
        self.window, self.patience, self.tries = window, patience, tries
        self.pending: dict[bytes, Pending] = {}
        self.last_id = 0
        self.open()

    def open(self) -> None:
        self.socket = self.context.socket(zmq.DEALER)
        # A request that nobody fetched is dropped at the end; waiting for its delivery could take for ever.
        # A peer that announces more than the largest message is disconnected before it is in memory.
        self.socket.linger, self.socket.maxmsgsize, self.socket.rcvtimeo = 0, 65_536, int(SLICE * 1000)
        # The window is the limit of what is under way; no second one is needed.
        self.socket.sndhwm = 0
        self.socket.connect(self.endpoint)
        self.heard = time.monotonic()

    def close(self) -> None:
        self.socket.close()

    def request_many(self, texts: Iterable[str]) -> Iterator[tuple[int, str, str]]:
        """Each request's number from 1 on, with its reply or the reason why there is none, in order of arrival.

        It takes the next text when there is room for it, so `texts` may be endless: whoever makes them has to wait.
        """
        self.pending.clear()
        upcoming = enumerate(texts, 1)
        look = time.monotonic() + SLICE
        while True:
            while len(self.pending) < self.window and (following := next(upcoming, None)):
                self.last_id += 1
                request_id = b"%d" % self.last_id
                self.pending[request_id] = Pending(*following, time.monotonic() + self.patience)
                self.send(request_id)
            if not self.pending:
                return
            yield from self.arrived()
            if time.monotonic() >= look:
                yield from self.overdue()
                look = time.monotonic() + SLICE

    def arrived(self) -> Iterator[tuple[int, str, str]]:
        """The next reply, if one comes in time."""
        with contextlib.suppress(zmq.Again):
            frames = self.socket.recv_multipart()
            self.heard = time.monotonic()
            # One for a request that is not pending is late or a second one: dropped.
            if len(frames) == 2 and (entry := self.pending.pop(frames[0], None)):
                yield entry.number, frames[1].decode(errors="replace"), ""

    def overdue(self) -> Iterator[tuple[int, str, str]]:
        """Whatever waits for too long is sent again with its old id, or given up."""
        now = time.monotonic()
        late = [request_id for request_id, entry in self.pending.items() if entry.deadline <= now]
        if late and self.heard + self.patience <= now:
            # Not a word, neither to these requests nor to others: a new socket helps, whatever is wrong with this one.
            self.close()
            self.open()
            # What was under way on it is lost.
            late = list(self.pending)
        for request_id in late:
            entry = self.pending[request_id]
            limit = f"{self.patience:g} s"
            if entry.tries == self.tries:
                del self.pending[request_id]
                why = f"no reply in {self.tries} tries of {limit}; is the server running, or slow?"
                yield entry.number, "", why
            else:
                entry.tries, entry.deadline = entry.tries + 1, now + self.patience
                self.report(f"{entry.number}: no reply within {limit}; try {entry.tries} of {self.tries}")
                self.send(request_id)

    def send(self, request_id: bytes) -> None:
        text = self.pending[request_id].text.encode(errors="replace")
        # After a peer that broke the protocol there is nothing to send on. Then the next try has a new socket.
        with contextlib.suppress(zmq.Again):
            self.socket.send_multipart([request_id, text], zmq.NOBLOCK)
