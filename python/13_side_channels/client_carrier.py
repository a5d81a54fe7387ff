"""Lesson 13, the client's carrier: exchanges with a server, at any time, over a DEALER socket. In C#:
SideChannelCarrier.cs.
"""

import contextlib
import time
from collections import deque
from collections.abc import Callable

import zmq

# So long nothing is said before an empty exchange says "I am here"; the server answers, if it is there.
SILENCE = 1.0


class ClientCarrier:
    """With `report` a server that is silent for longer than `timeout` is a line, and it goes on trying."""

    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        endpoint: str,
        timeout: float,
        largest: int,
        report: Callable[[str], object] | None = None,
    ) -> None:
        self.context, self.endpoint, self.timeout, self.largest = context, endpoint, timeout, largest
        self.report, self.away = report, False
        self.unsent: deque[bytes] = deque()
        self.heard = time.monotonic()
        self.open()

    def open(self) -> None:
        """A connection that was refused may never be tried again. So each try has a new socket."""
        self.socket = self.context.socket(zmq.DEALER)
        self.socket.linger, self.socket.sndtimeo, self.socket.maxmsgsize = 0, 0, self.largest
        self.socket.connect(self.endpoint)
        self.answered, self.said = False, 0.0

    @property
    def full(self) -> bool:
        """Whether an exchange waits for a server that is away. Pack none then: their channels keep the messages, and of
        too many drop the oldest."""
        return bool(self.unsent)

    def exchange(self, data: bytes, wait: float) -> list[bytes]:
        """Sends an exchange, unless it is empty, and gives those that have come; waits so many seconds for the first.

        TimeoutError when the server was silent for too long, and there is no `report`.
        """
        if data:
            self.unsent.append(data)
        now = time.monotonic()
        with contextlib.suppress(zmq.Again):
            if now - self.said >= SILENCE:
                if self.said and not self.answered:
                    self.socket.close()
                    self.open()
                self.socket.send(b"")
                self.said = now
            # Before its first answer a socket may be replaced, and what was sent on it is lost.
            while self.answered and self.unsent:
                self.socket.send(self.unsent[0])
                self.unsent.popleft()
        received = self.receive(wait)
        if received:
            self.heard, self.answered, self.away = time.monotonic(), True, False
        elif time.monotonic() - self.heard > self.timeout and not self.away:
            why = f"no word from {self.endpoint} within {self.timeout:g} s; is the server running?"
            if not self.report:
                raise TimeoutError(why)
            self.away = True
            self.report(f"{why} It is tried again and again")
        return received

    def receive(self, wait: float) -> list[bytes]:
        received: list[bytes] = []
        if self.socket.poll(round(wait * 1000)):
            with contextlib.suppress(zmq.Again):
                for _ in range(100):
                    frames = self.socket.recv_multipart(zmq.NOBLOCK)
                    # Several frames are no exchange.
                    received += frames if len(frames) == 1 else []
        return received
