"""The trainer's way to the hub: a socket for lesson 10's vector environment, which stays as it is.

    import netmq_example.envs
    with FleetSocket("tcp://127.0.0.1:5567", "CartPole", 16) as fleet:
        envs = gymnasium.make_vec("NetMQExample/CartPole-v0", 16, fleet=fleet, timeout=60)

With one area it is the way to a whole scene, for any environment. That expects a bound ROUTER socket, to which
a simulator comes. Here a DEALER socket goes to the hub, says `join` {name, areas}, and looks like one: what it receives
is of a peer named `hub`.
With keys `prepare` is lesson 15's ClientKeys(folder).apply.
"""

import logging
import time
from collections.abc import Callable
from typing import Any

import zmq

from netmq_example import arguments, check
from netmq_example.envs.common import OtherSide
from netmq_example.finalizers import finalizer
from netmq_example.messages import LIMIT, Message, MessageError, take
from netmq_example.one_process import OneProcess
from netmq_example.program import limit
from netmq_example.trouble import longer
from netmq_example.wire.records import is_record

PEER = b"hub"
# The environment asks again each second. If it is silent for longer, it waits for a simulator, and tells the hub. So
# long waits the first of several tries, too.
SILENCE_SECONDS = 2.0

log = logging.getLogger("netmq_example.envs")


class FleetSocket(OneProcess, OtherSide):
    """`prepare` gets each new socket before it connects. Use it on one thread, that of its environment."""

    how_to_start = ""
    gone = "the hub is gone"
    # The hub reads each of them.
    longest_pause = 1.0

    def __init__(self, endpoint: str, name: str, areas: int, *, prepare: Callable[[Any], object] | None = None) -> None:
        self.endpoint = check.endpoint(endpoint, "tcp://127.0.0.1:5567")
        self.name = arguments.text("name", name)
        self.areas = check.count("areas", areas, most=1024)
        self.prepare: Callable[[Any], object] | None = check.instance("prepare", prepare, Callable, type(None))
        self.join = Message("join", 0, {"name": self.name, "areas": self.areas})
        self.context = zmq.Context()
        self.new_socket()
        # When something was sent, and whether it still waits for simulators.
        self.sent = 0.0
        self.waits = True
        # Whether `join` is to be sent, and how many sockets in a row had no answer.
        self.joins = False
        self.tries = 0
        self.missing = 0
        self.state = "is the hub running?"

    def recv_multipart(self) -> list[bytes]:
        self.check_process()
        if time.monotonic() > self.sent + longer(SILENCE_SECONDS, max(0, self.tries - 1)):
            self.open()
        if self.joins:
            self.socket.send_multipart(self.join.frames())
            self.joins = False
        frames = self.socket.recv_multipart()
        self.tries = 0
        if is_record(frames):
            self.report_lost(0)
        else:
            message = Message.read(frames)
            if message.kind == "error" and self.waits and (code := str(message.values.get("code"))) != "unknown-peer":
                # Of what it has asked for there is none.
                raise MessageError(code, str(message.values.get("text")))
            if message.kind == "alive":
                # The environment has no use for it, and to answer it would be taken for a request.
                if self.waits:
                    self.sent = time.monotonic()
                    here, taken = (take(message.values, key, int) for key in ("simulators", "taken"))
                    there = f"the hub has {here} simulators of '{self.name}', of which {taken} are taken"
                    self.report(f"{there}: {self.areas} are needed")
                else:
                    self.report_lost(take({"missing": 0} | message.values, "missing", int))
                raise zmq.Again
            if message.kind == "hello":
                self.report(f"the hub has given this trainer {self.areas} simulators", logging.INFO)
        return [PEER, *frames]

    def send_multipart(self, frames: list[Any], flags: int = 0) -> None:
        self.sent = time.monotonic()
        self.waits = False
        try:
            self.socket.send_multipart(frames[1:], flags)
        except zmq.Again:
            # There is no connection: to the environment, a peer that is gone.
            raise zmq.ZMQError(zmq.EHOSTUNREACH) from None

    def report_lost(self, missing: int) -> None:
        """Which episodes wait for a simulator, in place of one that was lost: whenever there are more or fewer."""
        if missing > self.missing:
            log.warning("%s of %s episodes wait for a simulator: start one, if none comes", missing, self.areas)
        elif self.missing and not missing:
            log.info("each episode has a simulator again")
        self.missing = missing

    def report(self, text: str, level: int = logging.WARNING) -> None:
        if text != self.state:
            self.state = text
            log.log(level, text)

    def open(self) -> None:
        """A new socket each time: one that was refused once never tries again."""
        if not self.waits:
            self.report(f"asking the hub at {self.endpoint} anew")
        elif self.sent:
            keys = ", and is this trainer's key on its list" if self.prepare else ", without keys"
            self.report(f"no answer from a hub at {self.endpoint}: is it there{keys}?")
        self.waits = True
        self.end()
        self.new_socket()
        # Nothing can be sent while there is no connection: so it is known whether there is one.
        self.socket.immediate = True
        limit(self.socket, 4 * LIMIT)
        self.socket.linger = 500
        self.socket.rcvtimeo = self.socket.sndtimeo = 200
        # A pulled cable is noticed within three seconds.
        self.socket.heartbeat_ivl = 500
        self.socket.heartbeat_timeout = 2500
        if self.prepare:
            self.prepare(self.socket)
        self.socket.connect(self.endpoint)
        self.sent = time.monotonic()
        self.tries += 1
        self.joins = True

    def new_socket(self) -> None:
        self.socket = self.context.socket(zmq.DEALER)
        # Forgotten in a cycle of references, the context may be the first to go, and would wait for its open socket.
        self.end = finalizer(self, self.socket.close)

    def getsockopt_string(self, option: int) -> str:
        return self.endpoint

    def close(self) -> None:
        """Leave the hub. Twice is once."""
        self.context.destroy()
