"""A client that asks again until it is answered: the lazy pirate of ZeroMQ's guide, https://zguide.zeromq.org.

    with zmq.Context() as context, contextlib.closing(LazyPirate(context, "tcp://127.0.0.1:5552")) as pirate:
        print(pirate.request("add 1"))

Bytes: UTF-8 text, two frames each way, [id][text], at most 65,536 bytes each. Every retry of a request carries the same
id, by which the server knows what it has done already (journal.py). In C# it is LazyPirateRequester.cs.
"""

import threading
import time
import uuid
from collections.abc import Callable

import zmq

from netmq_example import check
from netmq_example.beacon import BeaconSearch
from netmq_example.errors import GaveUp, longer, tried
from netmq_example.one_process import OneProcess, one_at_a_time
from netmq_example.program import Context, Socket, encoded, limit, printable, text_of

# The longest wait in one piece, in milliseconds: between two of them stop() is noticed and, on Windows, Ctrl-C.
SLICE_MS = 50
# Before a request is sent again after a wrong reply: without it, 5 tries are over in a millisecond.
PAUSE_SECONDS = 0.25


class LazyPirate(OneProcess):
    """Asks over one REQ socket at a time. Use it on one thread; only stop() may be called on any."""

    def __init__(
        self,
        context: Context,
        endpoint: str,
        timeout: float = 0.5,
        tries: int = 5,
        report: Callable[[str], object] = print,
    ) -> None:
        """The first try waits `timeout` seconds for its reply, and each one after it twice as long, up to 8 times.

        `report` is called with a line before each retry.
        """
        self.context = check.not_closed("context", check.blocking("context", context, zmq.Context))
        self.endpoint = check.endpoint(endpoint, "tcp://127.0.0.1:5552", beacon=True)
        self.search = BeaconSearch(endpoint)
        self.timeout = check.seconds("timeout", timeout)
        self.tries = check.count("tries", tries)
        self.report = check.function("report", report)
        # An id must never come twice, whoever else asks and however often this program starts: hence the uuid.
        self.name = uuid.uuid4().hex
        self.number = 0
        self.socket: Socket | None = None
        self.stopped = threading.Event()

    @one_at_a_time
    def request(self, text: str) -> str:
        """The reply. TimeoutError: no try was answered, but it may be done. GaveUp: it is too long, or was stopped."""
        if not self.stopped.is_set():
            check.not_closed("context", self.context)
        self.number += 1
        try:
            request = [f"{self.number}-{self.name}".encode(), encoded(check.instance("text", text, str))]
        except ValueError as error:
            raise GaveUp(str(error)) from None
        attempt = 1
        while not self.stopped.is_set():
            timeout = longer(self.timeout, attempt - 1)
            frames = self.exchange(request, timeout)
            if is_reply(frames, request):
                return text_of(frames[1])
            if self.stopped.is_set():
                break
            trouble = f"{'nobody answers to this name' if self.search.vain else 'no reply'} within {timeout:g} s"
            if frames:
                seen = printable(" ".join(map(text_of, frames)))
                trouble = f"dropped a reply to another request ({seen})"
            if attempt == self.tries:
                cure = self.search.cure("is the right server running, the line slow, or the reply over 64 KB?")
                raise TimeoutError(
                    f"{tried(self.tries)} to ask {self.endpoint}, the last: {trouble}; "
                    f"{cure} '{text}' may have been done or not"
                )
            attempt += 1
            self.report(f"{self.number}: {trouble}; try {attempt} of {self.tries}")
        raise GaveUp("the client was disposed")

    def exchange(self, request: list[bytes], timeout: float) -> list[bytes]:
        """One try: the frames that came back, if any."""
        end = time.monotonic() + timeout
        frames: list[bytes] = []
        try:
            socket = self.connected(end)
            # Without waiting: after a peer that broke the protocol there may be no connection to send on.
            socket.send_multipart(request, zmq.NOBLOCK)
            left = timeout
            while left > 0 and not self.stopped.is_set() and not socket.poll(min(SLICE_MS, int(left * 1000) + 1)):
                left = end - time.monotonic()
            frames = socket.recv_multipart(zmq.NOBLOCK)
        except zmq.Again:
            pass
        finally:
            # A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
            if not is_reply(frames, request):
                self.close_socket()
        if not is_reply(frames, request) and time.monotonic() < end:
            self.stopped.wait(PAUSE_SECONDS)
        return frames

    def connected(self, end: float) -> Socket:
        """zmq.Again if it is not known by then where the server is."""
        if not self.socket:
            while not (where := self.search.look(SLICE_MS / 1000)):
                if self.stopped.is_set() or time.monotonic() > end:
                    raise zmq.Again
            self.socket = self.context.socket(zmq.REQ)
            limit(self.socket)
            self.socket.connect(where)
        return self.socket

    def close_socket(self) -> None:
        if self.socket:
            self.socket.close()
        self.socket = None

    def stop(self) -> None:
        """End the request under way, and every later one, by GaveUp."""
        self.stopped.set()

    def close(self) -> None:
        self.stop()
        self.close_socket()
        self.search.close()


def is_reply(frames: list[bytes], request: list[bytes]) -> bool:
    return len(frames) == 2 and frames[0] == request[0]
