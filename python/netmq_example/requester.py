"""The clients that ask have this in common: where their server is, how often they try, and a new socket for each try
after one in vain.

A connection of ZeroMQ's that was refused, or a REQ socket that waits for its reply, is no use for another try.
"""

import logging
import math
import threading
import time
from collections.abc import Callable
from typing import Any

import zmq

from netmq_example import arguments, check
from netmq_example.beacon import BeaconSearch
from netmq_example.errors import Closed, Timeout
from netmq_example.one_process import Keys, OneProcess
from netmq_example.program import LARGEST_BYTES, Context, Socket, limit
from netmq_example.trouble import longer, tried

# The longest wait in one piece, in milliseconds: between two of them stop() is noticed and, on Windows, Ctrl-C.
SLICE_MS = 50
# Before a request is sent again after a wrong reply: without it, 5 tries are over in a millisecond.
PAUSE_SECONDS = 0.25

log = logging.getLogger("netmq_example.client")


class Client(OneProcess):
    """Where its server is, how often it tries and how long at first, and its keys."""

    # Of a reply, in bytes.
    largest = LARGEST_BYTES

    def __init__(
        self,
        endpoint: str,
        example: str,
        timeout: float,
        tries: int,
        keys: Keys | None = None,
        context: Context | None = None,
        beacon: bool = True,
    ) -> None:
        self.endpoint = check.endpoint(endpoint, example, beacon=beacon)
        self.search = BeaconSearch(endpoint)
        self.timeout = check.seconds("timeout", timeout)
        self.tries = check.count("tries", tries)
        self.keys = arguments.keys(keys)
        self.context: Context = arguments.context(context)
        self.report: Callable[[str], object] = log.warning
        self.socket: Any = None

    def prepared(self, kind: int) -> Socket:
        socket = self.context.socket(kind)
        limit(socket, self.largest)
        if self.keys:
            self.keys.apply(socket)
        return socket

    def close_socket(self) -> None:
        if self.socket:
            self.socket.close()
        self.socket = None

    def close(self) -> None:
        """Close the socket, on the thread that asks. Twice is once."""
        self.close_socket()
        self.search.close()


class Requester(Client):
    """Asks over one REQ socket at a time, on any thread, but on one at a time; stop() at any time."""

    # Whether frames are copied into bytes.
    copies = True

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.stopped = threading.Event()

    def connected(self, end: float) -> Any:
        """zmq.Again if it is not known by then where the server is."""
        if not self.socket:
            while not (where := self.search.find(SLICE_MS / 1000)):
                if self.stopped.is_set() or time.monotonic() > end:
                    raise zmq.Again
            self.socket = self.prepared(zmq.REQ)
            self.socket.connect(where)
        return self.socket

    def ask(self, request: list[Any], name: object, largest: str) -> list[Any]:
        """The frames of the reply. Timeout: no try was answered, but it may be done. Closed: it was closed before."""
        arguments.not_closed("context", self.context)
        for attempt in range(1, self.tries + 1):
            if self.stopped.is_set():
                raise Closed("this requester is closed: make a new one")
            timeout = longer(self.timeout, attempt - 1)
            if frames := self.exchange(request, timeout):
                return frames
            trouble = self.trouble(timeout)
            if attempt < self.tries:
                self.report(f"{name}: {trouble}; try {attempt + 1} of {self.tries}")
        cure = self.cure(f"is the server running, or its reply over {largest}?")
        raise Timeout(f"{tried(self.tries)} to ask {self.endpoint}, the last: {trouble}; {cure}")

    def trouble(self, timeout: float) -> str:
        return f"{'nobody answers to this name' if self.search.vain else 'no reply'} within {round(timeout, 3):g} s"

    def cure(self, question: str) -> str:
        return self.search.cure(question)

    def exchange(
        self, request: list[bytes], timeout: float, until: Callable[[], float] = lambda: math.inf
    ) -> list[Any]:
        """One try: the frames that came back, if any, within so many seconds, and until a time of time.monotonic()."""
        end = time.monotonic() + timeout
        left = timeout
        frames: list[Any] = []
        try:
            socket = self.connected(end)
            # Without waiting: after a peer that broke the protocol there may be no connection to send on.
            socket.send_multipart(request, zmq.NOBLOCK, copy=self.copies)
            while left > 0 and not self.stopped.is_set() and not socket.poll(min(SLICE_MS, int(left * 1000) + 1)):
                left = 0 if self.is_dead() else min(end, until()) - time.monotonic()
            frames = socket.recv_multipart(zmq.NOBLOCK, copy=self.copies)
        except zmq.Again:
            pass
        finally:
            # A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
            if not self.is_reply(frames, request):
                self.close_socket()
        if not self.socket and time.monotonic() < min(end, until()):
            self.stopped.wait(PAUSE_SECONDS)
        return frames

    def is_reply(self, frames: list[Any], request: list[bytes]) -> bool:
        return bool(frames)

    def is_dead(self) -> bool:
        """Whether nothing will come over this socket any more."""
        return False

    def stop(self) -> None:
        """On any thread: end the request under way, and every later one, by Closed."""
        self.stopped.set()

    def close(self) -> None:
        self.stop()
        super().close()
