"""Lesson 13, the carrier: exchanges with every simulator that comes, at any time, over a ROUTER socket.

An exchange is one frame, and either side sends one whenever it has something to say. An empty one says "I am here",
and is answered. Each simulator has its own channels, which `welcome` makes.
"""

import contextlib
import time
from collections.abc import Callable

import zmq
from peer import Peer
from side_channel import LARGEST_EXCHANGE
from side_channel_manager import SideChannelManager

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
