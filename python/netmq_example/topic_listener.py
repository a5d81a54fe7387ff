"""A listener to whatever is published under a topic: each message, or only the newest.

    with TopicListener("tcp://127.0.0.1:5553", "pose/") as listener:
        for text in listener:
            print(text)

Bytes: UTF-8 text, which begins with its topic. Of a message of several frames the text is that of all, with a blank
between them; receive_frames() hands them over apart, as bytes. In C# it is TopicListener.cs.
"""

import threading
import time
from collections.abc import Iterator

import zmq

from netmq_example import arguments, check
from netmq_example.beacon import BeaconSearch
from netmq_example.errors import Closed, Timeout
from netmq_example.former import positional
from netmq_example.one_process import Keys, OneProcess
from netmq_example.program import LARGEST_BYTES, SLICE_MS, Context, Socket, limit, text_of
from netmq_example.trouble import LOOK_UP_SECONDS

# A silent publisher, such as a laptop that sleeps, is asked so often, and gets a new connection, for which libzmq looks
# its name up again, if it does not answer for so long. The two together are less than the 5 s a client waits.
HEARTBEAT_MS = 1000
HEARTBEAT_TIMEOUT_MS = 2500
# The first connection is made anew after so long without a message; on a far line it takes its time.
RENEW_SECONDS = 2.0
# So many messages newest() takes at most: a publisher may send faster than its loop takes.
MOST_MESSAGES = 10_000


class TopicListener(OneProcess):
    """Every message that begins with a topic. Messages from before the publisher knew of this listener are lost.

    Use it on one thread; only stop() may be called on any.
    """

    @positional("socket", "endpoint", "topic")
    def __init__(
        self,
        endpoint: str,
        topic: str = "",
        *,
        timeout: float = 5.0,
        high_watermark: int = 1000,
        largest: int = LARGEST_BYTES,
        socket: Socket | None = None,
        keys: Keys | None = None,
        context: Context | None = None,
    ) -> None:
        """An empty topic means every message. It waits `timeout` seconds for one, and `high_watermark` messages may
        wait here. It hangs up on a frame of more than `largest` bytes. A SUB socket with options of your own goes in as
        `socket`, and is closed by you.
        """
        self.endpoint = check.endpoint(endpoint, "tcp://127.0.0.1:5553", beacon=True)
        self.topic = check.instance("topic", topic, str)
        self.timeout = check.seconds("timeout", timeout, zero=True)
        high_watermark = check.count("high_watermark", high_watermark, least=0)
        self.largest = check.count("largest", largest)
        self.keys = arguments.keys(keys)
        self.own_socket = socket is None
        if socket is None:
            socket = arguments.context(context).socket(zmq.SUB)
            socket.rcvhwm = high_watermark
        self.socket: Socket = arguments.not_closed("socket", arguments.blocking("socket", socket, zmq.Socket))
        if socket.type != zmq.SUB:
            raise ValueError("socket takes a SUB socket")
        if self.keys:
            self.keys.apply(socket)
        self.stopped = threading.Event()
        self.search = BeaconSearch(endpoint)
        # The address that it is connected to, and whether it looks for a new one.
        self.where = ""
        self.looking = True
        self.heard = False
        limit(socket, self.largest)
        socket.rcvtimeo = SLICE_MS
        socket.heartbeat_ivl = HEARTBEAT_MS
        socket.heartbeat_timeout = HEARTBEAT_TIMEOUT_MS
        socket.subscribe(topic.encode(errors="replace"))
        self.find_server()

    def __iter__(self) -> Iterator[str]:
        """The text of each message until stop() or close(). Timeout if none comes."""
        while not self.stopped.is_set():
            try:
                text = self.receive()
            except Closed:
                return
            yield text

    def receive(self, timeout: float | None = None) -> str:
        """The text of the next message. Timeout if none comes within so many seconds, or the listener's own."""
        return " ".join(map(text_of, self.receive_frames(timeout)))

    def receive_frames(self, timeout: float | None = None) -> list[bytes]:
        """The same with its frames as they came, such as a topic and a picture."""
        self.check_process()
        timeout = self.timeout if timeout is None else check.seconds("timeout", timeout, zero=True)
        arguments.not_closed("this listener's socket", self.socket)
        start = time.monotonic()
        renew = RENEW_SECONDS
        while True:
            if self.stopped.is_set():
                raise Closed("the listener was stopped")
            if self.looking:
                self.find_server()
            try:
                frames = self.socket.recv_multipart()
                self.heard = True
                return frames
            except zmq.Again:
                waited = time.monotonic() - start
            if waited >= timeout:
                why = f"is the server running, with topic '{self.topic}', or a message over {self.largest >> 10} KB?"
                # A look-up takes its time, which is none of whoever waits for less.
                if self.search.name or timeout >= LOOK_UP_SECONDS:
                    why = self.search.cure(why)
                raise Timeout(f"nothing from {self.endpoint} within {timeout:g} s; {why}")
            if waited >= renew and (self.search.name or not self.heard):
                self.looking = True
                renew *= 3

    def find_server(self) -> None:
        """Connect to where the publisher is. It does not wait for that: whoever receives comes again."""
        where = self.search.find(0)
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

    def newest(self, timeout: float | None = None) -> str:
        """Wait for a message, then take all that are queued behind it: only the last one counts."""
        frames = self.receive_frames(timeout)
        try:
            for _ in range(MOST_MESSAGES):
                frames = self.socket.recv_multipart(zmq.NOBLOCK)
        except zmq.Again:
            pass
        return " ".join(map(text_of, frames))

    def stop(self) -> None:
        """On any thread: end the receive under way, and every later one, by Closed."""
        self.stopped.set()

    def close(self) -> None:
        """Close the socket, unless it was the caller's. Twice is once."""
        self.stop()
        self.search.close()
        if self.own_socket:
            self.socket.close()
