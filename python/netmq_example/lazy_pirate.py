"""A client that asks again until it is answered: the lazy pirate of ZeroMQ's guide, https://zguide.zeromq.org.

    with LazyPirate("tcp://127.0.0.1:5552") as pirate:
        print(pirate.request("add 1"))

Bytes: UTF-8 text, two frames each way, [id][text], at most 65,536 bytes each. Every retry of a request carries the same
id, by which the server knows what it has done already (journal.py). In C# it is LazyPirateRequester.cs.
"""

import logging
import math
import threading
import time
import uuid
from collections.abc import Callable

import zmq

from netmq_example import arguments, check
from netmq_example.beacon import BeaconSearch
from netmq_example.console import printable
from netmq_example.errors import Closed, Refused, Timeout
from netmq_example.former import positional
from netmq_example.one_process import Keys, OneProcess, one_at_a_time
from netmq_example.program import Context, Socket, encoded, limit, text_of
from netmq_example.trouble import LOOK_UP_SECONDS, longer, tried

# The longest wait in one piece, in milliseconds: between two of them stop() is noticed and, on Windows, Ctrl-C.
SLICE_MS = 50
# Before a request is sent again after a wrong reply: without it, 5 tries are over in a millisecond.
PAUSE_SECONDS = 0.25

log = logging.getLogger("netmq_example.client")


class LazyPirate(OneProcess):
    """Asks over one REQ socket at a time, on any thread, but on one at a time; stop() at any time."""

    @positional("context", "endpoint", "timeout", "tries", "report")
    def __init__(
        self,
        endpoint: str,
        *,
        timeout: float = 0.5,
        tries: int = 5,
        keys: Keys | None = None,
        context: Context | None = None,
    ) -> None:
        """The first try waits `timeout` seconds for its reply, and each one after it twice as long, up to 8 times.

        Each retry is logged as a warning. Without a context it takes pyzmq's own, zmq.Context.instance().
        """
        self.endpoint = check.endpoint(endpoint, "tcp://127.0.0.1:5552", beacon=True)
        self.search = BeaconSearch(endpoint)
        self.timeout = check.seconds("timeout", timeout)
        self.tries = check.count("tries", tries)
        self.keys = arguments.keys(keys)
        self.context = arguments.context(context)
        self.report = log.warning
        # An id must never come twice, whoever else asks and however often this program starts: hence the uuid.
        self.name = uuid.uuid4().hex
        self.number = 0
        self.socket: Socket | None = None
        self.stopped = threading.Event()

    def request(self, text: str, *, within: float | None = None) -> str:
        """The reply, as it came: one that begins with `error:` is a reply, too.

        All tries together take at most `within` seconds. Timeout: no try was answered, but it may be done.
        MessageError: it is too long. Closed: stop() or close() ended it.
        """
        end = time.monotonic() + (math.inf if within is None else check.seconds("within", within))
        return self.request_until(text, lambda: end)

    @one_at_a_time
    def request_until(self, text: str, until: Callable[[], float]) -> str:
        """The same until a time of time.monotonic() that may come nearer meanwhile."""
        began = time.monotonic()
        if not self.stopped.is_set():
            arguments.not_closed("context", self.context)
        self.number += 1
        request = [f"{self.number}-{self.name}".encode(), encoded(text)]
        attempt = 1
        while not self.stopped.is_set():
            timeout = max(0.0, min(longer(self.timeout, attempt - 1), until() - time.monotonic()))
            frames = self.exchange(request, timeout, until)
            if is_reply(frames, request):
                log.debug("%s: %s", self.endpoint, frames)
                return text_of(frames[1])
            if self.stopped.is_set():
                break
            trouble = f"{'nobody answers to this name' if self.search.vain else 'no reply'} within {timeout:.3g} s"
            if frames:
                seen = printable(" ".join(map(text_of, frames)))
                trouble = f"dropped a reply to another request ({seen})"
            if attempt == self.tries or time.monotonic() >= until():
                cure = "is the right server running, the line slow, or the reply over 64 KB?"
                # To look up a name takes its time, which is none of whoever waits for less.
                if self.search.name or until() - began >= LOOK_UP_SECONDS:
                    cure = self.search.cure(cure)
                whole = until() - began
                within = f" within {round(whole, 2):g} s" if 0 < whole < math.inf else ""
                raise Timeout(
                    f"{tried(attempt)}{within} to ask {self.endpoint}, the last: {trouble}; "
                    f"{cure} '{text}' may have been done or not"
                )
            attempt += 1
            self.report(f"{self.number}: {trouble}; try {attempt} of {self.tries}")
        raise Closed("the client was closed")

    def exchange(self, request: list[bytes], timeout: float, until: Callable[[], float]) -> list[bytes]:
        """One try: the frames that came back, if any."""
        end = time.monotonic() + timeout
        frames: list[bytes] = []
        try:
            socket = self.connected(end)
            # Without waiting: after a peer that broke the protocol there may be no connection to send on.
            socket.send_multipart(request, zmq.NOBLOCK)
            left = timeout
            while left > 0 and not self.stopped.is_set() and not socket.poll(min(SLICE_MS, int(left * 1000) + 1)):
                left = min(end, until()) - time.monotonic()
            frames = socket.recv_multipart(zmq.NOBLOCK)
        except zmq.Again:
            pass
        finally:
            # A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
            if not is_reply(frames, request):
                self.close_socket()
        if not is_reply(frames, request) and time.monotonic() < min(end, until()):
            self.stopped.wait(PAUSE_SECONDS)
        return frames

    def connected(self, end: float) -> Socket:
        """zmq.Again if it is not known by then where the server is."""
        if not self.socket:
            while not (where := self.search.find(SLICE_MS / 1000)):
                if self.stopped.is_set() or time.monotonic() > end:
                    raise zmq.Again
            self.socket = self.context.socket(zmq.REQ)
            limit(self.socket)
            if self.keys:
                self.keys.apply(self.socket)
            self.socket.connect(where)
        return self.socket

    def close_socket(self) -> None:
        if self.socket:
            self.socket.close()
        self.socket = None

    def stop(self) -> None:
        """On any thread: end the request under way, and every later one, by Closed."""
        self.stopped.set()

    def close(self) -> None:
        """Close the socket, on the thread that asks. Twice is once."""
        self.stop()
        self.close_socket()
        self.search.close()


def refused(reply: str) -> Refused | None:
    """The error in a text of the lessons' servers that begins with `error:`, or None for another text."""
    return Refused("error", reply[6:].strip()) if reply.startswith("error:") else None


def is_reply(frames: list[bytes], request: list[bytes]) -> bool:
    return len(frames) == 2 and frames[0] == request[0]
