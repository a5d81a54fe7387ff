"""Lesson 06, the requester in Python: the twin of ManyRequester.cs.

    requester = ManyRequester(context, "tcp://127.0.0.1:5556", window=64, patience=2, tries=3, report=print)
    for number, reply, failure in requester.request_many(["echo one", "sleep 1", "echo two"]): ...

Take home: this file. The server is server.py, and its header says what the bytes are.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import zmq

# How often the limits are looked at: short enough to be exact, long enough to cost nothing.
SLICE = 0.05
# A socket that met the wrong server does not try again, so after so many seconds without a connection a new one does.
RENEW = 3
# No reply has more than two frames. One with more than this many is not read to its end.
MOST_FRAMES = 1000


@dataclass
class Pending:
    number: int
    text: str
    deadline: float
    tries: int = 1
    busy: bool = False


class ManyRequester:
    """Keeps up to `window` requests under way over one DEALER socket. Use it on one thread."""

    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        endpoint: str,
        window: int,
        patience: float,
        tries: int,
        report: Callable[[str], None],
    ) -> None:
        self.window, self.patience, self.tries, self.report = window, patience, tries, report
        self.context, self.endpoint = context, endpoint
        self.pending: dict[bytes, Pending] = {}
        self.last_id = 0
        self.open()

    def open(self) -> None:
        self.connected, self.lonely_since = False, time.monotonic()
        self.socket = self.context.socket(zmq.DEALER)
        # A request that nobody fetched is dropped at the end; waiting for its delivery could take for ever.
        self.socket.linger = 0
        # Asks a silent server every 0.5 s whether it is there, and takes it for dead when 1 s brings no answer.
        self.socket.heartbeat_ivl, self.socket.heartbeat_timeout = 500, 1000
        # The socket can send only while a server is there; so whether it can, says whether the server is there.
        self.socket.immediate = 1
        # The window is the limit of what is under way. A second limit would look like a server that is gone.
        self.socket.sndhwm = 0
        # libzmq hangs up on who sends a larger frame.
        self.socket.maxmsgsize = 65_536
        self.socket.connect(self.endpoint)

    def close(self) -> None:
        self.socket.close()

    def renew(self) -> None:
        if self.connected:
            self.report("lost the server")
        self.close()
        self.open()

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
            if self.socket.poll(int(SLICE * 1000)):
                yield from self.arrived()
            if time.monotonic() >= look:
                self.watch_connection()
                yield from self.overdue()
                look = time.monotonic() + SLICE

    def arrived(self) -> Iterator[tuple[int, str, str]]:
        """Every reply that is there by now. One for a request that is not pending is late or a second one: dropped."""
        for _ in range(len(self.pending)):
            try:
                frames = [self.socket.recv(zmq.NOBLOCK)]
                while self.socket.getsockopt(zmq.RCVMORE) and len(frames) < MOST_FRAMES:
                    frames.append(self.socket.recv(zmq.NOBLOCK))
            except zmq.Again:
                return
            if len(frames) == MOST_FRAMES:
                # The rest of it goes with the socket.
                self.renew()
                return
            entry = self.pending.get(frames[0]) if len(frames) == 2 else None
            if entry and frames[1].startswith(b"error: busy"):
                # Refused, so it is not done: it is asked again when its patience is over.
                entry.busy = True
            elif entry:
                del self.pending[frames[0]]
                yield entry.number, frames[1].decode(errors="replace"), ""

    def watch_connection(self) -> None:
        connected = bool(self.socket.poll(0, zmq.POLLOUT))
        if connected != self.connected:
            self.connected, self.lonely_since = connected, time.monotonic()
            self.report("connected" if connected else "lost the server")
            # What the last connection took along is sent again with its old id, and what had none for the first time.
            for request_id in self.pending if connected else ():
                self.send(request_id)
        elif not connected and time.monotonic() > self.lonely_since + RENEW:
            self.renew()

    def overdue(self) -> Iterator[tuple[int, str, str]]:
        now = time.monotonic()
        for request_id, entry in [item for item in self.pending.items() if item[1].deadline <= now]:
            if entry.tries == self.tries:
                del self.pending[request_id]
                cause = "is busy" if entry.busy else "is there, and slow" if self.connected else "is not there"
                yield entry.number, "", f"no reply in {self.tries} tries of {self.patience:g} s; the server {cause}"
            else:
                entry.tries, entry.busy, entry.deadline = entry.tries + 1, False, now + self.patience
                self.report(f"{entry.number}: no reply within {self.patience:g} s; try {entry.tries} of {self.tries}")
                self.send(request_id)

    def send(self, request_id: bytes) -> None:
        # Without a server it waits for the next connection, or for the next try.
        if self.connected:
            try:
                self.socket.send_multipart([request_id, self.pending[request_id].text.encode()], zmq.NOBLOCK)
            except zmq.Again:
                pass
