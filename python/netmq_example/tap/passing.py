"""Passing on: two TCP connections, and whole messages from one to the other, or what faults make of them.

    faults = Faults(planned={3: "drop"})                     message 3 is not passed on
    link = Link(1, arrows, faults)                            the first client that came
    link.run(client, "127.0.0.1", 5552)                        until one side closes; on a thread of its own

One thread for each direction of each connection: it receives, shows, sends, and waits where the receiver does not
read, so that backpressure reaches the sender. A message that is late makes those behind it late, as on a real line.
A message can be dropped, a second late, passed on twice, or its connection cut: message N, planned when the tap starts,
or the next one, when the page asks for it.
"""

import contextlib
import socket
import threading
import time
from dataclasses import dataclass, field

from netmq_example.tap.arrows import Arrows
from netmq_example.tap.zmtp import GREETING, NotZeroMQ, Piece, mechanism, socket_type, take

FAULTS = ("drop", "delay", "double", "cut")
# A longer message than any lesson has, which would fill the memory.
LARGEST_BYTES = 300 * 1024 * 1024
DELAY_SECONDS = 1.0
# Heartbeats come each second, and READY is shown as what it says: the types of both sockets.
UNSEEN = (b"PING", b"PONG", b"READY")


@dataclass
class Faults:
    """Messages are counted from 1, both ways together; `way` is up, to the server, down, or empty for both."""

    planned: dict[int, str] = field(default_factory=dict)
    asked: str = ""
    way: str = ""
    # Each message is late by so many seconds: slow enough for an eye.
    slow: float = 0
    number: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)

    def ask(self, fault: str, way: str) -> None:
        """For the next message that goes this way. An empty fault takes the wish back."""
        if fault not in ("", *FAULTS) or way not in ("", "up", "down"):
            raise ValueError(f"fault is one of {', '.join(FAULTS)}, and way up or down, not {fault!r:.40}, {way!r:.40}")
        with self.lock:
            self.asked = fault
            self.way = way

    def state(self) -> dict[str, str | float]:
        return {"asked": self.asked, "slow": self.slow}

    def of_next(self, way: str) -> str:
        with self.lock:
            self.number += 1
            if self.asked and self.way in ("", way):
                fault = self.asked
                self.asked = ""
                return fault
            return self.planned.get(self.number, "")


@dataclass
class Link:
    """One client's connection and ours to the server."""

    number: int
    arrows: Arrows
    faults: Faults
    types: dict[str, str] = field(default_factory=dict)

    def run(self, client: socket.socket, host: str, port: int) -> None:
        with client:
            try:
                server = socket.create_connection((host, port), timeout=2)
            except (OSError, UnicodeError):
                # The client connects again, as it does where nobody listens.
                self.arrows.add(self.number, "", None, f"no server at {host}:{port}")
                return
            with server:
                for each in (client, server):
                    each.settimeout(None)
                    # Otherwise a small message may wait for the next one.
                    each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                name = f"netmq_example tap {self.number}"
                down = threading.Thread(target=self.pass_on, args=(server, client, "down"), daemon=True, name=name)
                down.start()
                self.pass_on(client, server, "up")
                down.join()
        self.arrows.add(self.number, "", None, "closed")

    def pass_on(self, source: socket.socket, target: socket.socket, way: str) -> None:
        """Until one side closes. Then the other one learns of it, and may still send what it has to send."""
        how = socket.SHUT_RDWR
        held = 0
        try:
            self.greet(source, target, way)
            buffer = bytearray()
            while chunk := source.recv(65536):
                held += len(chunk)
                self.arrows.hold(len(chunk))
                buffer += chunk
                while piece := take(buffer, LARGEST_BYTES):
                    self.pass_piece(piece, target, way)
                    held -= len(piece.raw)
                    self.arrows.hold(-len(piece.raw))
            how = socket.SHUT_WR
        except NotZeroMQ as error:
            self.arrows.add(self.number, way, None, f"closed by the tap: {error}")
        except OSError:
            # One of them is gone, or was cut.
            pass
        self.arrows.hold(-held)
        for each in (source, target):
            if each is target or how == socket.SHUT_RDWR:
                with contextlib.suppress(OSError):
                    each.shutdown(how)

    def greet(self, source: socket.socket, target: socket.socket, way: str) -> None:
        """Each side sends its half only when it has a part of the other's: so this is passed on as it comes."""
        greeting = b""
        while len(greeting) < GREETING and (part := source.recv(GREETING - len(greeting))):
            target.sendall(part)
            greeting += part
        if way == "up" and greeting and (kind := mechanism(greeting)) != "NULL":
            self.arrows.add(self.number, "", None, f"opened: {kind}")

    def pass_piece(self, piece: Piece, target: socket.socket, way: str) -> None:
        """Here the message is in our hands."""
        fault = ""
        if piece.command:
            self.see_command(piece, way)
        else:
            fault = self.faults.of_next(way)
            self.arrows.add(self.number, way, piece, fault)
            late = self.faults.slow
            if fault == "delay":
                late += DELAY_SECONDS
            if late:
                time.sleep(late)
        if fault == "cut":
            raise ConnectionAbortedError
        if fault != "drop":
            target.sendall(piece.raw)
        if fault == "double":
            target.sendall(piece.raw)

    def see_command(self, piece: Piece, way: str) -> None:
        if piece.name == b"READY" and len(self.types) < 2:
            self.types[way] = socket_type(piece.frames[0])
            if len(self.types) == 2:
                self.arrows.add(self.number, "", None, f"opened: {self.types['up']} to {self.types['down']}")
        elif piece.name not in UNSEEN:
            self.arrows.add(self.number, way, piece)
