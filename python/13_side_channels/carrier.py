"""Lesson 13, the carrier: exchanges with every simulator that comes, at any time, over a ROUTER socket.

An exchange is one frame, and either side sends one whenever it has something to say. An empty one says "I am here",
and is answered. Each simulator has its own channels, which `welcome` makes.
Take home: this file, side_channel_manager.py, side_channel.py and side_channel_messages.py.
"""

import contextlib
from collections import deque
from collections.abc import Callable

import zmq
from side_channel import LARGEST_EXCHANGE, UnitySideChannelException
from side_channel_manager import SideChannelManager

# So many are known; of more, the one that was silent for longest is forgotten, and welcomed again when it speaks.
MOST_PEERS = 64
# What may wait for one that does not read.
MOST_UNSENT = 4 * LARGEST_EXCHANGE


class Peer:
    def __init__(self, manager: SideChannelManager) -> None:
        self.manager = manager
        self.unsent: deque[bytes] = deque()
        # It has said "I am here", and has to be told something.
        self.greeted = False


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
        with contextlib.suppress(zmq.Again):
            self.take_in(*self.socket.recv_multipart())
            # Not until there are no more: what is queued has its turn, too.
            for _ in range(100):
                self.take_in(*self.socket.recv_multipart(zmq.NOBLOCK))
        self.send()

    def take_in(self, client: bytes, *frames: bytes) -> None:
        peer = self.peers.pop(client, None) or Peer(self.welcome())
        # Taken out and put in again it is the last one: the first one is who was silent for longest.
        self.peers[client] = peer
        if len(self.peers) > MOST_PEERS:
            del self.peers[next(iter(self.peers))]
        if len(frames) != 1:
            self.report(f"an exchange is one frame, not {len(frames)}")
        elif not frames[0]:
            peer.greeted = True
        else:
            try:
                peer.manager.process_side_channel_message(frames[0])
            except UnitySideChannelException as error:
                self.report(str(error))

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
