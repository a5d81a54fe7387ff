"""Lesson 17, the trainer's way to the hub: a socket for lesson 10's vector environment, which stays as it is.

    with FleetSocket("tcp://127.0.0.1:5567", "CartPole", 16) as socket:
        envs = gymnasium.make_vec("NetMQExample/CartPole-v0", 16, socket=socket, timeout=60)      after: import vector

That environment expects a bound ROUTER socket, to which a simulator comes. Here a DEALER socket goes to the hub, says
`join` {name, areas}, and looks like one: what it receives is of a peer named `hub`.
Where there are keys, `prepare` is what lesson 15's secure_requester.py has: ClientKeys(folder).apply.
And for that environment vector.py, remote_areas.py and infos.py
of lesson 10, with environment.py, connection.py, simulators.py, launched.py and spaces.py of lesson 09.
"""

import re
import time
from collections.abc import Callable
from typing import Any

import zmq

from netmq_example.messages import LIMIT, Message, read, take

PEER = b"hub"
# Whoever asks, asks again each second: who has said nothing for so long waits for a simulator, and says so to the hub.
SILENCE = 2.0


class FleetSocket:
    """`prepare` gets each new socket before it connects."""

    # What the environment says of a peer to which nothing can be sent.
    gone = "the hub is gone"

    def __init__(self, endpoint: str, name: str, areas: int, prepare: Callable[[Any], object] | None = None) -> None:
        port = re.fullmatch(r"tcp://[\w.-]+:(\d{1,5})", endpoint, re.ASCII)
        if not port or not 0 < int(port[1]) < 65536:
            raise ValueError(f"bad endpoint '{endpoint}': write it like tcp://127.0.0.1:5567, port 1 to 65535")
        self.endpoint, self.join = endpoint, Message("join", 0, {"name": name, "areas": areas})
        self.context, self.prepare = zmq.Context(), prepare
        self.socket = self.context.socket(zmq.DEALER)
        # When it has said something; and what is known of the hub, which the environment gives up with.
        self.said, self.waits, self.told = 0.0, True, "is the hub running?"

    def recv_multipart(self) -> list[bytes]:
        if time.monotonic() > self.said + SILENCE:
            self.open()
        frames = self.socket.recv_multipart()
        if self.waits:
            message = read(frames)
            if message.kind == "alive":
                self.said = time.monotonic()
                self.tell(message)
                raise zmq.Again
            if message.kind == "hello":
                self.say(f"the hub has given this trainer {self.join.values['areas']} simulators")
        return [PEER, *frames]

    def send_multipart(self, frames: list[Any], flags: int = 0) -> None:
        self.said, self.waits = time.monotonic(), False
        self.socket.send_multipart(frames[1:], flags)

    def tell(self, alive: Message) -> None:
        """What is missing, whenever that has changed."""
        here, taken = take(alive.values, "simulators", int), take(alive.values, "taken", int)
        name, areas = self.join.values["name"], self.join.values["areas"]
        self.say(f"the hub has {here} simulators of '{name}', of which {taken} are taken: {areas} are needed")

    def say(self, text: str) -> None:
        if text != self.told:
            self.told = text
            print(text, flush=True)

    def open(self) -> None:
        """A new socket each time: one that was refused once never tries again."""
        if not self.waits:
            self.say(f"asking the hub at {self.endpoint} anew")
        elif self.said:
            keys = ", and is this trainer's key on its list" if self.prepare else ", without keys"
            self.say(f"no answer from a hub at {self.endpoint}: is it there{keys}?")
        self.waits = True
        self.socket.close()
        self.socket = self.context.socket(zmq.DEALER)
        # Nothing can be sent while there is no connection: so it is known whether there is one.
        self.socket.linger, self.socket.maxmsgsize, self.socket.immediate = 500, 4 * LIMIT, True
        self.socket.rcvtimeo = self.socket.sndtimeo = 200
        # A pulled cable is noticed within three seconds.
        self.socket.heartbeat_ivl, self.socket.heartbeat_timeout = 500, 2500
        if self.prepare:
            self.prepare(self.socket)
        self.socket.connect(self.endpoint)
        self.said = time.monotonic()
        self.socket.send_multipart(self.join.frames())

    def getsockopt_string(self, option: int) -> str:
        return self.endpoint

    def close(self) -> None:
        self.context.destroy()

    def __enter__(self) -> "FleetSocket":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
