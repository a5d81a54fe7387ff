"""Lesson 09, the connection: one simulator at a time, and every request is done exactly once.

Each request has an id that counts. One that stays without an answer is sent again with the same id, and the simulator
answers a repeated id with what it has kept: so a retry never steps twice. A simulator that is gone is noticed within
a second, because a ROUTER socket can say that it has no way to a peer.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import zmq

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Array, Message, MessageError, read

# Seconds after which a request is sent again.
AGAIN = 1.0
# What Gymnasium's requests are answered with. Other lessons have others.
ANSWERS = {"reset": "state", "step": "state", "render": "picture"}


class Lost(ConnectionError):
    """The simulator is gone, or has not answered for too long."""


class Connection:
    """A bound ROUTER socket. It waits in slices of its receive timeout: on Windows Ctrl-C interrupts no longer wait."""

    def __init__(self, socket: zmq.Socket[bytes], timeout: float) -> None:
        self.socket, self.timeout, self.endpoint = socket, timeout, socket.getsockopt_string(zmq.LAST_ENDPOINT)
        # To send to a peer that is gone is then an error, and not silence.
        socket.router_mandatory = True
        self.peer, self.id, self.closed = b"", 0, False

    def wait(self, limit: float, accept: Callable[[Message], None], ended: Callable[[], int | None]) -> None:
        """Wait for a simulator's hello, until its program has ended. What `accept` raises, it is told as well."""
        self.peer, end = b"", time.monotonic() + limit
        while not self.peer:
            peer, hello = self.receive()
            if hello and hello.kind == "hello":
                try:
                    accept(hello)
                except MessageError as error:
                    self.refuse(peer, error)
                    raise
                # One that has said hello and is gone already is none.
                self.peer = peer if self.send(peer, "welcome", hello.id) else b""
            elif hello:
                # It was given up, and has not noticed.
                self.refuse(peer, MessageError("unknown-peer", "say hello again"))
            if not self.peer and (code := ended()) is not None:
                raise TimeoutError(f"the launched simulator ended with code {code}, and never came to {self.endpoint}")
            if not self.peer and time.monotonic() > end:
                why = getattr(self.socket, "told", "is it running?")
                raise TimeoutError(f"no simulator came to {self.endpoint} within {limit:g} s; {why}")

    def ask(self, kind: str, values: dict[str, Any], arrays: list[Array]) -> Message:
        """The answer to a request; MessageError is the simulator's refusal, or says what is wrong with its answer."""
        if self.closed:
            raise ValueError("this environment is closed")
        self.id += 1
        end, why = time.monotonic() + self.timeout, f"no answer to {kind} within {self.timeout:g} s"
        while time.monotonic() < end:
            if not self.peer or not self.send(self.peer, kind, self.id, values, arrays):
                why = getattr(self.socket, "gone", "the simulator is gone")
                break
            if answer := self.answer(min(end, time.monotonic() + AGAIN)):
                if answer.kind == "error":
                    code, text = (str(answer.values.get(name, "not said")) for name in ("code", "text"))
                    # Lesson 17's hub knows nobody when it has been started anew.
                    raise Lost("the hub is new") if code == "unknown-peer" else MessageError(code[:40], text[:200])
                if answer.kind != ANSWERS.get(kind, answer.kind):
                    raise MessageError("wrong-kind", f"{answer.kind!a:.40} is no answer to {kind}")
                return answer
        self.peer = b""
        raise Lost(why)

    def answer(self, end: float) -> Message | None:
        while time.monotonic() < end:
            peer, message = self.receive()
            # Another id is an answer that came twice, or too late: its request is over.
            if message and peer == self.peer and message.id == self.id:
                return message
            if message and peer != self.peer:
                self.refuse(peer, MessageError("busy", "this environment has its simulator: one at a time"))
        return None

    def receive(self) -> tuple[bytes, Message | None]:
        """Who sent something, and the message: none if nothing came, or nothing that is a message."""
        try:
            peer, *frames = self.socket.recv_multipart()
        except zmq.Again:
            return b"", None
        try:
            return peer, read(frames)
        except MessageError as error:
            self.refuse(peer, error)
            if peer == self.peer:
                raise
            return peer, None

    def refuse(self, peer: bytes, error: MessageError) -> None:
        self.send(peer, "error", error.id, {"code": error.code, "text": error.text})

    def send(self, peer: bytes, kind: str, id: int, values: Any = None, arrays: Any = None) -> bool:
        """False if the peer is gone, or takes nothing any more."""
        try:
            self.socket.send_multipart([peer, *Message(kind, id, values or {}, arrays or []).frames()], zmq.NOBLOCK)
        except zmq.ZMQError:
            return False
        return True
