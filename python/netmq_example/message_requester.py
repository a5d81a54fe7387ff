"""A client for messages of messages.py: it asks and waits. In C# it is MessageRequester.cs.

with MessageRequester("tcp://127.0.0.1:5555") as requester:
    reply = requester.request(Message("frame", 1, {"bottom_up": True}, [Array.of(picture)]))
    print(reply.values)
"""

import logging
import math
import time

import zmq

from netmq_example import arguments, check
from netmq_example.beacon import BeaconSearch
from netmq_example.errors import Closed, Timeout
from netmq_example.lazy_pirate import PAUSE_SECONDS
from netmq_example.messages import LIMIT, Message
from netmq_example.one_process import Keys, OneProcess, one_at_a_time
from netmq_example.program import SLICE_MS, Context, Socket, limit
from netmq_example.trouble import longer, tried

log = logging.getLogger("netmq_example.client")


class MessageRequester(OneProcess):
    """Asks over one REQ socket at a time, on any thread, but on one at a time."""

    def __init__(
        self,
        endpoint: str,
        *,
        timeout: float = 2.5,
        tries: int = 1,
        keys: Keys | None = None,
        context: Context | None = None,
    ) -> None:
        """The first try waits `timeout` seconds for its reply, and each one after it twice as long, up to 8 times.

        With more than one of the `tries` the server may do it more than once.
        """
        self.endpoint = check.endpoint(endpoint, "tcp://127.0.0.1:5555", beacon=True)
        self.search = BeaconSearch(endpoint)
        self.timeout = check.seconds("timeout", timeout)
        self.tries = check.count("tries", tries)
        self.keys = arguments.keys(keys)
        self.context: Context = arguments.context(context)
        self.socket: Socket | None = None
        self.closed = False

    @one_at_a_time
    def request(self, request: Message) -> Message:
        """The reply. Refused: the server says why there is none. MessageError: request or reply is no message.

        Timeout: no try was answered, but it may be done. Closed: it was closed before.
        """
        if self.closed:
            raise Closed("this requester is closed: make a new one")
        arguments.not_closed("context", self.context)
        frames = check.instance("request", request, Message).frames()
        for attempt in range(1, self.tries + 1):
            timeout = longer(self.timeout, attempt - 1)
            received = self.exchange(frames, time.monotonic() + timeout)
            if received:
                return Message.read_reply(received)
            trouble = f"no reply within {timeout:g} s"
            if attempt < self.tries:
                log.warning("%s: %s; try %d of %d", request.kind, trouble, attempt + 1, self.tries)
        cure = self.search.cure(f"is the server running, or its reply over {LIMIT >> 20} MB?")
        raise Timeout(f"{tried(self.tries)} to ask {self.endpoint}, the last: {trouble}; {cure}")

    def exchange(self, frames: list[bytes], end: float) -> list[zmq.Frame]:
        """One try: the frames that came back, if any."""
        received: list[zmq.Frame] = []
        try:
            if not self.socket:
                self.connect(end)
            if self.socket:
                # Without waiting: after a peer that broke the protocol there may be no connection to send on.
                self.socket.send_multipart(frames, zmq.NOBLOCK, copy=False)
                while not received and (left := end - time.monotonic()) > 0:
                    if self.socket.poll(min(SLICE_MS, math.ceil(left * 1000))):
                        received = self.socket.recv_multipart(zmq.NOBLOCK, copy=False)
        except zmq.Again:
            pass
        finally:
            # A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
            if not received:
                self.close_socket()
        if not received and (left := end - time.monotonic()) > 0:
            time.sleep(min(PAUSE_SECONDS, left))
        return received

    def connect(self, end: float) -> None:
        where = self.search.find(max(0.0, end - time.monotonic()))
        if where:
            self.socket = self.context.socket(zmq.REQ)
            # Above LIMIT a reply is refused by name. Above four times as much libzmq takes no more of it and hangs up.
            limit(self.socket, 4 * LIMIT)
            if self.keys:
                self.keys.apply(self.socket)
            self.socket.connect(where)

    def close_socket(self) -> None:
        if self.socket:
            self.socket.close()
        self.socket = None

    def close(self) -> None:
        """Close the socket. Twice is once."""
        self.closed = True
        self.close_socket()
        self.search.close()
