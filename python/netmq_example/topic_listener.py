"""A listener to whatever is published under a topic: each message, or only the newest.

    with zmq.Context() as context, context.socket(zmq.SUB) as socket:
        listener = TopicListener(socket, "tcp://127.0.0.1:5553", "pose/")
        print(listener.receive(timeout=5))

Bytes: UTF-8 text, which begins with its topic. Of a message of several frames the text is that of all, with a blank
between them; receive_frames() hands them over apart, as bytes. In C# it is TopicListener.cs.
"""

import time

import zmq

from netmq_example import check
from netmq_example.beacon import LOOK_UP_SECONDS, BeaconSearch
from netmq_example.program import SLICE_MS, Socket, limit, text_of

# A silent publisher, such as a laptop that sleeps, is asked so often, and gets a new connection, for which libzmq looks
# its name up again, if it does not answer for so long. The two together are less than the 5 s a client waits.
HEARTBEAT_MS = 1000
HEARTBEAT_TIMEOUT_MS = 2500
# The first connection is made anew after so long without a message; on a far line it takes its time.
RENEW_SECONDS = 2.0
# So many messages newest() takes at most: a publisher may send faster than its loop takes.
MOST_MESSAGES = 10_000


class TopicListener:
    """Every message that begins with a topic. Messages from before the publisher knew of this listener are lost."""

    def __init__(self, socket: Socket, endpoint: str, topic: str) -> None:
        """The socket is a new SUB socket, which the caller closes; an empty topic means every message."""
        self.socket = check.not_closed("socket", check.blocking("socket", socket, zmq.Socket))
        if socket.type != zmq.SUB:
            raise ValueError("socket takes a SUB socket")
        self.endpoint = check.endpoint(endpoint, "tcp://127.0.0.1:5553", beacon=True)
        self.search = BeaconSearch(endpoint)
        # The address that it is connected to, and whether it looks for a new one.
        self.where = ""
        self.looking = True
        self.topic = check.instance("topic", topic, str)
        self.heard = False
        limit(socket)
        socket.rcvtimeo = SLICE_MS
        socket.heartbeat_ivl = HEARTBEAT_MS
        socket.heartbeat_timeout = HEARTBEAT_TIMEOUT_MS
        socket.subscribe(topic.encode(errors="replace"))
        self.look()

    def receive(self, timeout: float) -> str:
        """Wait so many seconds for the next message, and hand over its text; TimeoutError if none comes."""
        return " ".join(map(text_of, self.receive_frames(timeout)))

    def receive_frames(self, timeout: float) -> list[bytes]:
        """The same with its frames as they came, such as a topic and a picture."""
        timeout = check.seconds_or_none("timeout", timeout)
        check.not_closed("this listener's socket", self.socket)
        start = time.monotonic()
        renew = RENEW_SECONDS
        while True:
            if self.looking:
                self.look()
            try:
                frames = self.socket.recv_multipart()
                self.heard = True
                return frames
            except zmq.Again:
                waited = time.monotonic() - start
            if waited >= timeout:
                why = f"is the server running, with topic '{self.topic}', or a message over 64 KB?"
                # A look-up takes its time, which is none of whoever waits for less.
                if self.search.name or timeout >= LOOK_UP_SECONDS:
                    why = self.search.cure(why)
                raise TimeoutError(f"nothing from {self.endpoint} within {timeout:g} s; {why}")
            if waited >= renew and (self.search.name or not self.heard):
                self.looking = True
                renew *= 3

    def look(self) -> None:
        """Connect to where the publisher is. It does not wait for that: whoever receives comes again."""
        where = self.search.look(0)
        if not where:
            return
        self.looking = False
        if self.where == where and self.heard:
            return
        if self.where:
            # Also to the same place: where another program had the port before, libzmq connects no more.
            self.socket.disconnect(self.where)
        self.socket.connect(where)
        self.where = where

    def newest(self, timeout: float) -> str:
        """Wait for a message, then take all that are queued behind it: only the last one counts."""
        frames = self.receive_frames(timeout)
        try:
            for _ in range(MOST_MESSAGES):
                frames = self.socket.recv_multipart(zmq.NOBLOCK)
        except zmq.Again:
            pass
        return " ".join(map(text_of, frames))
