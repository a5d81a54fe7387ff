"""ZeroMQ's bytes: whole messages out of what goes over TCP (ZMTP 3, rfc.zeromq.org/spec/23).

    buffer += source.recv(65536)
    while piece := take(buffer, largest=300 << 20):          the messages and commands that are whole by now
        print(piece.frames)

A connection begins with a greeting of 64 bytes each way. Then come frames: a byte of flags (1 more follow, 2 long,
4 command), the size in one byte or, of a long one, in eight, and the body. Commands are ZeroMQ's own: READY says what
kind of socket this is, PING and PONG are heartbeats. NotZeroMQ is raised for everything else.
This file only reads: each piece keeps the very bytes it came from, so that they can be passed on unchanged.
"""

from dataclasses import dataclass

GREETING = 64
MORE, LONG, COMMAND = 1, 2, 4


class NotZeroMQ(Exception):
    """Bytes of something else, or of an older ZeroMQ."""


@dataclass(slots=True)
class Piece:
    """A message, or a command. Its frames are cut out only when somebody looks at them."""

    raw: bytes
    bounds: list[slice]
    command: bool

    @property
    def frames(self) -> list[bytes]:
        return [self.raw[each] for each in self.bounds]

    @property
    def name(self) -> bytes:
        """Of a command, whose body begins with the length of its name: READY, PING, SUBSCRIBE."""
        body = self.frames[0]
        return body[1 : 1 + body[0]] if self.command and body else b""


def mechanism(greeting: bytes) -> str:
    """NULL where everybody may come in, or how it is decided who may: CURVE, PLAIN."""
    if len(greeting) != GREETING or greeting[0] != 0xFF or greeting[10] < 3:
        raise NotZeroMQ("this is no ZeroMQ, or one older than version 4")
    return greeting[12:32].rstrip(b"\0").decode("ascii", "replace")


def take(buffer: bytearray, largest: int) -> Piece | None:
    """The first piece of the buffer, which loses it; None while a part of it has not come."""
    bounds = []
    at = 0
    flags = MORE
    while flags & MORE:
        if len(buffer) < at + 2:
            return None
        flags = buffer[at]
        start = at + (9 if flags & LONG else 2)
        at = start + int.from_bytes(buffer[at + 1 : start], "big")
        if flags > MORE + LONG + COMMAND or at > largest:
            raise NotZeroMQ(f"no frame of ZeroMQ, or a message of more than {largest:,} bytes")
        if len(buffer) < at:
            return None
        bounds.append(slice(start, at))
    raw = bytes(memoryview(buffer)[:at])
    del buffer[:at]
    return Piece(raw, bounds, bool(flags & COMMAND))


def socket_type(ready: bytes) -> str:
    """The socket type in a READY command: REQ, ROUTER. Each property is a name and a value, with their lengths."""
    at = 1 + ready[0]
    while at < len(ready):
        start = at + 1 + ready[at] + 4
        name = ready[at + 1 : start - 4]
        end = start + int.from_bytes(ready[start - 4 : start], "big")
        if name.lower() == b"socket-type":
            return ready[start:end].decode("ascii", "replace")
        at = end
    return "?"
