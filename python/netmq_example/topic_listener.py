"""Lesson 03, the listener to copy in Python: the C# version is TopicListener.cs. client.py is its command line.

Bytes: UTF-8 text, one frame, which begins with its topic.
"""

import contextlib
import time

import zmq


class TopicListener:
    """Every message that begins with a topic. What was sent before the publisher knew of this listener is lost."""

    def __init__(self, socket: zmq.Socket[bytes], endpoint: str, topic: str) -> None:
        """The socket is a new SUB socket, which the caller closes."""
        self.socket, self.endpoint, self.topic, self.heard = socket, endpoint, topic, False
        # A peer that announces more than the largest message is disconnected before it is in memory.
        # It waits in slices: on Windows Ctrl-C does not interrupt a longer wait.
        socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, 65_536, 200
        # A laptop that sleeps tells nobody: a silent publisher is asked every 5 s, and one that does not answer in 5
        # more gets a new connection.
        socket.heartbeat_ivl = 5000
        socket.subscribe(topic.encode(errors="replace"))
        socket.connect(endpoint)

    def receive(self, timeout: float) -> str:
        """Wait for the next message; TimeoutError if none comes."""
        start = time.monotonic()
        renew = 2.0
        while True:
            with contextlib.suppress(zmq.Again):
                frames = self.socket.recv_multipart()
                self.heard = True
                return frames[0].decode(errors="replace")
            waited = time.monotonic() - start
            if waited >= timeout:
                why = f"is the server running, with topic '{self.topic}'?"
                raise TimeoutError(f"nothing from {self.endpoint} within {timeout:g} s; {why}")
            if not self.heard and waited >= renew:
                # Where another program had the port before, libzmq connects no more. On a far line it takes its time.
                self.socket.disconnect(self.endpoint)
                self.socket.connect(self.endpoint)
                renew *= 3

    def newest(self, timeout: float) -> str:
        """Wait for a message, then take all that wait behind it: only the last one counts."""
        message = self.receive(timeout)
        with contextlib.suppress(zmq.Again):
            # The limit is for a publisher that sends faster than this loop takes.
            for _ in range(10_000):
                message = self.socket.recv_multipart(zmq.NOBLOCK)[0].decode(errors="replace")
        return message
