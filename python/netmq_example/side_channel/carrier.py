"""Lesson 13, the client's carrier: exchanges with a server, at any time, over a DEALER socket. In C#:
SideChannelCarrier.cs.

Lesson 13, one simulator as the carrier knows it: its channels, and what is on the way from it and to it.

Lesson 13, the carrier: exchanges with every simulator that comes, at any time, over a ROUTER socket.

An exchange is one frame, and either side sends one whenever it has something to say. An empty one says "I am here",
and is answered. Each simulator has its own channels, which `welcome` makes.
"""

import contextlib
import struct
import time
from collections import deque
from collections.abc import Callable, Iterator

import zmq

from netmq_example.side_channel.side_channel import LARGEST_EXCHANGE, UnitySideChannelException
from netmq_example.side_channel.side_channel_manager import SideChannelManager

# A part of an exchange, in bytes: it ends with the message that makes it so large.
PART = 65_536
# What may wait of one that sends faster than this side reads.
MOST_UNREAD = 4 * LARGEST_EXCHANGE


class Peer:
    def __init__(self, manager: SideChannelManager) -> None:
        self.manager = manager
        self.unread, self.unsent = deque[bytes](), deque[bytes]()
        # It has said "I am here", and has to be told something; and when it said anything.
        self.greeted, self.heard = False, 0.0

    def take_in(self, exchange: bytes) -> bool:
        """False if that is too much."""
        self.unread += parts(exchange)
        return sum(map(len, self.unread)) <= MOST_UNREAD

    def deliver(self, report: Callable[[str], None]) -> None:
        """What it has sent, a part in each turn of the server: nobody waits for all that another one has to say."""
        size = 0
        while self.unread and size < PART:
            size += len(self.unread[0])
            try:
                self.manager.process_side_channel_message(self.unread.popleft())
            except UnitySideChannelException as error:
                report(str(error))


def parts(exchange: bytes) -> Iterator[bytes]:
    """Several smaller exchanges in place of a large one, which would take its time."""
    begin = end = 0
    while len(exchange) - end >= 20:
        (length,) = struct.unpack_from("<i", exchange, end + 16)
        if not 0 <= length <= len(exchange) - end - 20:
            break
        end += 20 + length
        if end - begin >= PART:
            yield exchange[begin:end]
            begin = end
    if begin < len(exchange):
        yield exchange[begin:]


# So many are known. One that was silent for so many seconds is forgotten for another, and is welcomed again when it
# speaks.
MOST_PEERS, ALIVE = 64, 3.0
# What may wait for one that does not read.
MOST_UNSENT = 4 * LARGEST_EXCHANGE


class Carrier:
    def __init__(
        self, socket: zmq.Socket[bytes], welcome: Callable[[], SideChannelManager], report: Callable[[str], None]
    ) -> None:
        self.socket, self.welcome, self.report = socket, welcome, report
        # Else what a ROUTER cannot send is dropped without a word.
        socket.router_mandatory = True
        self.peers: dict[bytes, Peer] = {}

    def serve(self) -> None:
        while True:
            self.exchange()

    def exchange(self) -> None:
        """Waits for an exchange, as long as the socket's timeout is; then sends what is queued."""
        size, wait = 0, zmq.NOBLOCK if any(peer.unread for peer in self.peers.values()) else 0
        with contextlib.suppress(zmq.Again):
            # Not until there are no more: what is queued has its turn, too.
            for _ in range(100):
                client, *frames = self.socket.recv_multipart(wait)
                self.take_in(client, frames)
                size, wait = size + sum(map(len, frames)), zmq.NOBLOCK
                if size > LARGEST_EXCHANGE:
                    break
        for peer in self.peers.values():
            peer.deliver(self.report)
        self.send()

    def take_in(self, client: bytes, frames: list[bytes]) -> None:
        first = next(iter(self.peers), b"")
        if client not in self.peers and len(self.peers) == MOST_PEERS:
            if time.monotonic() < self.peers[first].heard + ALIVE:
                self.report(f"{MOST_PEERS} simulators are here: one more is not answered")
                return
            del self.peers[first]
        peer = self.peers.pop(client, None) or Peer(self.welcome())
        # Taken out and put in again it is the last one: the first one is who was silent for longest.
        self.peers[client], peer.heard = peer, time.monotonic()
        if len(frames) != 1:
            self.report(f"an exchange is one frame, not {len(frames)}")
        elif not frames[0]:
            peer.greeted = True
        elif not peer.take_in(frames[0]):
            self.report("a simulator sends faster than this side reads, and was forgotten")
            del self.peers[client]

    def send(self) -> None:
        """What is queued for each; call it whenever you have queued something."""
        for client, peer in list(self.peers.items()):
            while data := peer.manager.generate_side_channel_messages():
                peer.unsent.append(bytes(data))
            if peer.greeted and not peer.unsent:
                peer.unsent.append(b"")
            peer.greeted = False
            try:
                while peer.unsent:
                    self.socket.send_multipart([client, peer.unsent[0]], zmq.NOBLOCK)
                    peer.unsent.popleft()
            except zmq.Again:
                if sum(map(len, peer.unsent)) <= MOST_UNSENT:
                    continue
                self.report("a simulator does not read what is sent, and was forgotten")
                del self.peers[client]
            except zmq.ZMQError:
                # It is gone.
                del self.peers[client]


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
