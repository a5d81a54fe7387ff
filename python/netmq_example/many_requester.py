"""Lesson 06, the requester in Python: the C# version is ManyRequester.cs.

    requester = ManyRequester(context, "tcp://127.0.0.1:5556", window=64, timeout=2, tries=3, report=print)
    for number, reply, failure in requester.request_many(["echo one", "sleep 1", "echo two"]): ...

The server is server.py, and its header says what the bytes are.
"""

import contextlib
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import zmq

# How often the deadlines are looked at. Shorter would cost more; longer, and Ctrl-C would have to wait on Windows.
SLICE = 0.05
# The bytes of the largest request and reply. The server disconnects whoever sends more, with all that is under way.
LARGEST = 65_536


@dataclass
class Pending:
    number: int
    text: bytes
    timeout: float
    tries: int = 1
    sent: float = 0


@dataclass
class ManyRequester:
    """Keeps up to `window` requests under way over one DEALER socket at a time. Use it on one thread.

    Timeout is for the first try; each one after it waits twice as long, up to 8 times.
    """

    context: zmq.Context[zmq.Socket[bytes]]
    endpoint: str
    window: int
    timeout: float
    tries: int
    report: Callable[[str], None]

    def __post_init__(self) -> None:
        self.pending: dict[bytes, Pending] = {}
        self.last_id = 0
        self.open()

    def open(self) -> None:
        self.socket = self.context.socket(zmq.DEALER)
        # A request that nobody fetched is dropped at the end; waiting for its delivery could take for ever.
        # A peer that announces more than the largest message is disconnected before it is in memory.
        self.socket.linger, self.socket.maxmsgsize, self.socket.rcvtimeo = 0, LARGEST, int(SLICE * 1000)
        # The window is the limit of what is under way; no second one is needed.
        self.socket.sndhwm = 0
        self.socket.connect(self.endpoint)
        self.heard = time.monotonic()

    def close(self) -> None:
        self.socket.close()

    def request_many(self, texts: Iterable[str]) -> Iterator[tuple[int, str, str]]:
        """Each request's number from 1 on, with its reply or the reason why there is none, in order of arrival.

        It takes the next text when there is room for it, so `texts` may be endless; but whatever makes them must not
        wait: no reply is read meanwhile.
        """
        self.pending.clear()
        upcoming = enumerate((text.encode(errors="replace") for text in texts), 1)
        look = time.monotonic() + SLICE
        while True:
            while len(self.pending) < self.window and (following := next(upcoming, None)):
                if len(following[1]) > LARGEST:
                    yield following[0], "", f"not sent: {len(following[1])} bytes, and the limit is {LARGEST}"
                    continue
                self.last_id += 1
                self.send(b"%d" % self.last_id, Pending(*following, self.timeout))
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
            self.heard, entry = time.monotonic(), self.pending.get(frames[0])
            # One for a request that is not pending is late or a second one: dropped. So is a refusal, until the last
            # try: such a request is asked again when its timeout is over.
            if len(frames) == 2 and entry and (entry.tries == self.tries or not frames[1].startswith(b"error: busy")):
                del self.pending[frames[0]]
                yield entry.number, frames[1].decode(errors="replace"), ""

    def overdue(self) -> Iterator[tuple[int, str, str]]:
        """Whatever waits for too long is sent again with its old id, or given up."""
        late = {key: entry for key, entry in self.pending.items() if entry.sent + entry.timeout <= time.monotonic()}
        if any(self.heard <= entry.sent for entry in late.values()):
            # Not a word since then, neither to it nor to others: a new socket helps, whatever is wrong with this one.
            self.close()
            self.open()
            # What was under way on it is lost. To send it again before its timeout is over is not another try.
            for request_id in self.pending.keys() - late:
                self.send(request_id, self.pending[request_id])
        for request_id, entry in late.items():
            limit = f"{entry.timeout:g} s"
            if entry.tries == self.tries:
                del self.pending[request_id]
                why = f"no reply in {self.tries} tries of up to {limit}; is the server running, or slow?"
                yield entry.number, "", why
            else:
                # A new connection takes several round trips. On a slow line only a longer wait ever succeeds.
                entry.tries, entry.timeout = entry.tries + 1, min(2 * entry.timeout, 8 * self.timeout)
                self.report(f"{entry.number}: no reply within {limit}; try {entry.tries} of {self.tries}")
                self.send(request_id, entry)

    def send(self, request_id: bytes, entry: Pending) -> None:
        self.pending[request_id] = entry
        entry.sent = time.monotonic()
        # After a peer that broke the protocol there is nothing to send on. Then the next try has a new socket.
        with contextlib.suppress(zmq.Again):
            self.socket.send_multipart([request_id, entry.text], zmq.NOBLOCK)
