"""The game that films.py films: one at a time, at the other end of a ROUTER socket.

    game = Game(bound("tcp://127.0.0.1:5562"), lost=lambda: print("gone"))
    while True:
        message = game.receive()            None for a moment without one; afterwards game.views are those of the game

A game sends `hello` with its views. One that is gone is noticed within a second, because a ROUTER socket can say that
it has no way to a peer. Another one is refused until then. The messages are in films.py.
"""

import math
import re
import time
from collections.abc import Callable
from typing import Any

import zmq

from netmq_example import check, one_connection
from netmq_example.messages import LIMIT, Message, MessageError, take

ENDPOINT = "tcp://127.0.0.1:5562"
# After so much silence it is asked whether it is there.
SILENCE_SECONDS = 1.0
# A view's name becomes the name of a file.
NAME = re.compile(r"[A-Za-z0-9_ -]{1,40}")
# Each may become a file that is open.
MOST_VIEWS = 64


def side(name: str, value: Any) -> int:
    """A rule as in check.py: a width or height in pixels. 0, or gymize's -1, is the largest that the game allows."""
    if check.is_number(value) and int(value) == value and -1 <= value < 2**31:
        return max(0, int(value))
    raise ValueError(f"{name} takes pixels, or 0 or -1 for as many as the game allows, not {value!r:.40}")


def bound(endpoint: str) -> zmq.Socket[bytes]:
    cure = "close() the Films that have it, or end the other program, or take another port here and in the game"
    return one_connection.bound(endpoint, ENDPOINT, cure)


class Game:
    """Make it anywhere; after that it belongs to one thread. `lost` is called when the game is gone."""

    def __init__(self, socket: zmq.Socket[bytes], lost: Callable[[], None]) -> None:
        self.socket = socket
        self.lost = lost
        # To send to a peer that is gone is then an error, and not silence.
        socket.router_mandatory = True
        self.endpoint = socket.getsockopt_string(zmq.LAST_ENDPOINT)
        self.peer = b""
        # When its last message came.
        self.heard = 0.0
        # How many games came so far, and the views of the one that is there, with their largest width and height.
        self.count = 0
        self.views: dict[str, tuple[int, int]] = {}

    def receive(self) -> Message | None:
        """The next message of the game; None if nothing came for a moment, or nothing that matters."""
        if not self.socket.poll(5):
            if self.peer and time.monotonic() > self.heard + SILENCE_SECONDS:
                self.heard = time.monotonic()
                if not self.send("alive"):
                    self.forget()
            return None
        identity, *frames = self.socket.recv_multipart(copy=False)
        peer = identity.bytes
        try:
            message = Message.read(frames)
            if message.kind == "hello":
                self.greet(peer, message)
            elif peer == self.peer:
                self.heard = time.monotonic()
                return message
            else:
                raise MessageError("unknown-peer", "say hello again", message.id)
        except MessageError as error:
            self.refuse(peer, error)
        return None

    def greet(self, peer: bytes, hello: Message) -> None:
        if self.peer and self.send("alive"):
            raise MessageError("busy", "there is a game already: one at a time")
        names = take(hello.values, "views", str).split(",")
        forms = [(array.dtype, array.shape) for array in hello.arrays[:1]]
        if forms != [("int32", (len(names), 2))] or not all(map(NAME.fullmatch, names)):
            raise MessageError("bad-views", "a hello has 'views', names of letters and digits, and their sizes [n, 2]")
        sizes = hello.arrays[0].numpy().tolist()
        views = {name: (width, height) for name, (width, height) in zip(names, sizes, strict=True)}
        if len(names) > MOST_VIEWS:
            raise MessageError("bad-views", f"a game has at most {MOST_VIEWS} views, not {len(names)}")
        if len(views) < len(names) or not all(min(one) > 0 and 3 * math.prod(one) <= LIMIT for one in views.values()):
            raise MessageError("bad-views", "each view has a name of its own, and pictures that a message can hold")
        self.forget()
        self.peer = peer
        self.views = views
        self.heard = time.monotonic()
        self.count += 1
        # Sent last: by then it can be filmed. One that is gone already is forgotten with the first silence.
        self.send("welcome", hello.id)

    def forget(self) -> None:
        self.peer = b""
        self.views = {}
        self.lost()

    def send(self, kind: str, id: int = 0, values: dict[str, Any] | None = None, peer: bytes = b"") -> bool:
        """False if there is no way to it any more."""
        frames = Message(kind, id, values or {}).frames()
        # A game hangs up on what it cannot read: MessageError says so before it is sent.
        Message.read(frames)
        try:
            self.socket.send_multipart([peer or self.peer, *frames], zmq.NOBLOCK)
        except zmq.ZMQError:
            # Its earlier messages are still received; with the first silence it is forgotten.
            self.heard = -math.inf
            return False
        return True

    def refuse(self, peer: bytes, error: MessageError) -> None:
        self.send("error", error.id, {"code": error.code, "text": error.text}, peer)
