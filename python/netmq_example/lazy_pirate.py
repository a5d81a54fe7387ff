"""Lesson 02, the lazy pirate itself: retries until it gets a reply. In C#: LazyPirateRequester.cs.

    with zmq.Context() as context, contextlib.closing(LazyPirate(context, "tcp://127.0.0.1:5552")) as pirate:
        print(pirate.request("add 1"))

Bytes: UTF-8 text, two frames each way: [id][text]; every retry of a request carries the same id, by which the server
knows that it has done it already.
"""

import time
import uuid
from collections.abc import Callable

import zmq

# Seconds before a request is sent again after a wrong reply: without them, 5 tries are over in a millisecond.
PAUSE = 0.25


class LazyPirate:
    """Asks at most `tries` times: waits `timeout` seconds for the reply, then twice as long, up to 8 times."""

    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        endpoint: str,
        timeout: float = 0.5,
        tries: int = 5,
        report: Callable[[str], object] = print,
    ) -> None:
        self.context, self.endpoint, self.timeout, self.tries = context, endpoint, timeout, tries
        self.report = report
        # An id must never come twice, whoever else asks and however often this program starts: hence the uuid.
        self.name, self.number = uuid.uuid4().hex, 0
        self.socket = self.connect()

    def request(self, text: str) -> str:
        """The reply to a request. TimeoutError when no try is answered: it may have been done all the same."""
        self.number += 1
        request = [f"{self.number}-{self.name}".encode(), text.encode(errors="replace")]
        for attempt in range(1, self.tries + 1):
            # A new connection takes several round trips. On a slow line only a longer wait ever succeeds.
            timeout = self.timeout * min(2 ** (attempt - 1), 8)
            frames = self.exchange(request, timeout)
            if len(frames) == 2 and frames[0] == request[0]:
                return frames[1].decode(errors="replace")
            trouble = f"no reply within {timeout:g} s"
            if frames:
                seen = b" ".join(frames)[:200].decode(errors="replace")
                # A terminal gets no control characters.
                seen = "".join(c if c.isprintable() else "?" for c in seen)
                trouble = f"dropped a reply to another request ({seen})"
            # A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
            self.close()
            self.socket = self.connect()
            if attempt < self.tries:
                self.report(f"{self.number}: {trouble}; try {attempt + 1} of {self.tries}")
        raise TimeoutError(
            f"{self.tries} tries to ask {self.endpoint}, the last: {trouble}; "
            f"is the right server running, or the line slow? '{text}' may have been done or not"
        )

    def exchange(self, request: list[bytes], timeout: float) -> list[bytes]:
        """One try: the frames that came back, if any."""
        end, frames = time.monotonic() + timeout, list[bytes]()
        try:
            # Without waiting: after a peer that broke the protocol there may be no connection to send on.
            self.socket.send_multipart(request, zmq.NOBLOCK)
            # In slices, because on Windows Ctrl-C does not interrupt a longer wait.
            while (left := end - time.monotonic()) > 0 and not self.socket.poll(min(200, int(left * 1000) + 1)):
                pass
            frames = self.socket.recv_multipart(zmq.NOBLOCK)
        except zmq.Again:
            pass
        if frames[:1] != request[:1] and time.monotonic() < end:
            time.sleep(PAUSE)
        return frames

    def connect(self) -> zmq.Socket[bytes]:
        socket = self.context.socket(zmq.REQ)
        # A request that nobody fetched is dropped with its socket; waiting for its delivery could take for ever.
        # A peer that announces more than the largest message is disconnected before it is in memory.
        socket.linger, socket.maxmsgsize = 0, 65_536
        socket.connect(self.endpoint)
        return socket

    def close(self) -> None:
        self.socket.close()
