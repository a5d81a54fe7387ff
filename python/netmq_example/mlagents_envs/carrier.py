"""Carries side channels at any time, beside any steps: Carrier for Python's end, ClientCarrier for a simulator's.

    carrier = Carrier(socket, lambda: SideChannelManager([StringLogChannel()]))              a bound ROUTER socket
    while True:
        carrier.exchange()

    carrier = ClientCarrier(context, "tcp://127.0.0.1:5563", timeout=5)                      a DEALER socket of its own
    for data in carrier.exchange(bytes(manager.generate_side_channel_messages()), wait=0.01):
        manager.process_side_channel_message(data)

An exchange is one frame, and either side sends one whenever it has something to say. An empty one says "I am here", and
is answered with one. Each simulator has its own channels, which `welcome` makes. The client's end is in C#
SideChannelCarrier.cs.
"""

import logging
import struct
import time
from collections import deque
from collections.abc import Callable, Iterator

import zmq

from netmq_example import arguments, check
from netmq_example.errors import Timeout
from netmq_example.mlagents_envs.exception import UnitySideChannelException
from netmq_example.mlagents_envs.side_channel.side_channel import LARGEST_EXCHANGE_BYTES
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.one_process import OneProcess
from netmq_example.program import limit
from netmq_example.trouble import cure, longer

__all__ = ["Carrier", "ClientCarrier"]

# Messages that are read before the queued ones are sent.
MOST_AT_ONCE = 100
# A part of an exchange: it ends with the message that makes it so large.
PART_BYTES = 65_536
# The backlog of a simulator that sends faster than this side reads, and of one that does not read.
MOST_UNREAD_BYTES = 4 * LARGEST_EXCHANGE_BYTES
MOST_UNSENT_BYTES = 4 * LARGEST_EXCHANGE_BYTES
# When this many simulators are here, another one replaces one that was silent for so long, which is welcomed again when
# it speaks.
MOST_PEERS = 64
ALIVE_SECONDS = 3.0
# A client sends "I am here" this often, and the server answers.
ALIVE_INTERVAL_SECONDS = 1.0
# Its first try to connect: the second, of twice as long, is over before five seconds are.
TRY_SECONDS = 1.5

log = logging.getLogger("netmq_example.envs")


class Peer:
    """One simulator as the server knows it: its channels, and what is on the way from it and to it."""

    def __init__(self, manager: SideChannelManager) -> None:
        self.manager = manager
        self.unread = deque[bytes]()
        self.unsent = deque[bytes]()
        # It has said "I am here" and is to be answered.
        self.greeted = False
        self.heard_at = 0.0

    def take_in(self, exchange: bytes) -> bool:
        """False if that is too much."""
        self.unread += parts(exchange)
        return sum(map(len, self.unread)) <= MOST_UNREAD_BYTES

    def deliver(self, report: Callable[[str], object]) -> None:
        """A part in each turn of the server: nobody waits for all that another simulator has to say."""
        size = 0
        while self.unread and size < PART_BYTES:
            exchange = self.unread.popleft()
            size += len(exchange)
            try:
                self.manager.process_side_channel_message(exchange)
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
        if end - begin >= PART_BYTES:
            yield exchange[begin:end]
            begin = end
    if begin < len(exchange):
        yield exchange[begin:]


class Carrier:
    """Trouble is logged, unless `report` takes it. Use it on one thread."""

    def __init__(
        self,
        socket: zmq.Socket[bytes],
        welcome: Callable[[], SideChannelManager],
        report: Callable[[str], object] = log.warning,
    ) -> None:
        self.socket = arguments.blocking("socket", socket, zmq.Socket)
        self.welcome = arguments.function("welcome", welcome)
        self.report = arguments.function("report", report)
        # Without it a ROUTER drops what it cannot send, and says nothing.
        socket.router_mandatory = True
        # The one that was silent for longest comes first.
        self.peers: dict[bytes, Peer] = {}

    def exchange(self) -> None:
        """Wait for an exchange, as long as the socket's timeout is; then send what is queued."""
        size = 0
        wait = zmq.NOBLOCK if any(peer.unread for peer in self.peers.values()) else 0
        for _ in range(MOST_AT_ONCE):
            try:
                client, *frames = self.socket.recv_multipart(wait)
            except zmq.Again:
                break
            self.take_in(client, frames)
            size += sum(map(len, frames))
            if size > LARGEST_EXCHANGE_BYTES:
                break
            wait = zmq.NOBLOCK
        for peer in self.peers.values():
            peer.deliver(self.report)
        self.send()

    def take_in(self, client: bytes, frames: list[bytes]) -> None:
        if client not in self.peers and len(self.peers) == MOST_PEERS:
            first = next(iter(self.peers))
            if time.monotonic() < self.peers[first].heard_at + ALIVE_SECONDS:
                self.report(f"{MOST_PEERS} simulators are here: one more is not answered")
                return
            del self.peers[first]
        # Taken out and put in again it is the last one.
        peer = self.peers.pop(client, None) or Peer(self.welcome())
        self.peers[client] = peer
        peer.heard_at = time.monotonic()
        if len(frames) != 1:
            self.report(f"an exchange is one frame, not {len(frames)}")
        elif not frames[0]:
            peer.greeted = True
        elif not peer.take_in(frames[0]):
            self.report("a simulator sends faster than this side reads, and was forgotten")
            del self.peers[client]

    def send(self) -> None:
        """Send what is queued for each, without waiting; call it whenever you have queued something."""
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
                if sum(map(len, peer.unsent)) > MOST_UNSENT_BYTES:
                    self.report("a simulator does not read what is sent, and was forgotten")
                    del self.peers[client]
            except zmq.ZMQError:
                # It is gone.
                del self.peers[client]


class ClientCarrier(OneProcess):
    """With `report` a server that is silent for longer than `timeout` seconds is a line, and it goes on trying."""

    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        endpoint: str,
        timeout: float = 5,
        report: Callable[[str], object] | None = None,
    ) -> None:
        self.context = arguments.blocking("context", context, zmq.Context)
        self.endpoint = check.endpoint(endpoint, "tcp://127.0.0.1:5563")
        self.timeout = check.seconds("timeout", timeout)
        self.report = report if report is None else arguments.function("report", report)
        self.away = False
        self.unsent = deque[bytes]()
        # For how long the server is silent, and until when that was looked at.
        self.silent = 0.0
        self.looked_at = time.monotonic()
        self.tries = 0
        self.open()

    def open(self) -> None:
        """A connection that was refused may never be tried again. So each try has a new socket."""
        self.socket = self.context.socket(zmq.DEALER)
        limit(self.socket, LARGEST_EXCHANGE_BYTES)
        self.socket.sndtimeo = 0
        # A frozen server closes no connection. After 3 s without an answer libzmq does, and looks the name up again.
        self.socket.heartbeat_ivl, self.socket.heartbeat_timeout = 500, 2500
        self.socket.connect(self.endpoint)
        self.answered = False
        self.greeted_at = 0.0

    def close(self) -> None:
        self.socket.close()

    @property
    def full(self) -> bool:
        """Whether an exchange waits for a server that is away. Pack none then: their channels keep the messages, and of
        too many drop the oldest."""
        return bool(self.unsent)

    def exchange(self, data: bytes, wait: float) -> list[bytes]:
        """Send an exchange, unless it is empty, and return those that have come; wait so many seconds for the first.

        Timeout when the server was silent for too long, and there is no `report`.
        """
        wait = check.seconds("wait", wait, zero=True)
        if exchange := arguments.data("data", data):
            self.unsent.append(exchange)
        self.send()
        received = self.receive(wait)
        now = time.monotonic()
        # A longer gap is no silence of the server's: this program slept, perhaps with the server.
        self.silent += min(now - self.looked_at, wait + ALIVE_INTERVAL_SECONDS)
        self.looked_at = now
        if received:
            self.silent = 0.0
            self.answered = True
            self.away = False
        elif self.silent > self.timeout and not self.away:
            question = cure(self.endpoint, "is the server running?")
            why = f"no word from {self.endpoint} within {self.timeout:g} s; {question}"
            if not self.report:
                raise Timeout(why)
            self.away = True
            self.report(f"{why} It is tried again and again")
        return received

    def send(self) -> None:
        self.check_process()
        now = time.monotonic()
        try:
            silence = ALIVE_INTERVAL_SECONDS if self.answered else longer(TRY_SECONDS, self.tries)
            if now - self.greeted_at >= silence:
                if self.greeted_at and not self.answered:
                    self.tries += 1
                    self.close()
                    self.open()
                self.socket.send(b"")
                self.greeted_at = now
            # Before its first answer a socket may be replaced, and what was sent on it is lost.
            while self.answered and self.unsent:
                self.socket.send(self.unsent[0])
                self.unsent.popleft()
        except zmq.Again:
            # It is sent in one of the next exchanges.
            pass

    def receive(self, wait: float) -> list[bytes]:
        received: list[bytes] = []
        if self.socket.poll(round(wait * 1000)):
            for _ in range(MOST_AT_ONCE):
                try:
                    frames = self.socket.recv_multipart(zmq.NOBLOCK)
                except zmq.Again:
                    break
                # Several frames are no exchange.
                if len(frames) == 1:
                    received += frames
        return received
