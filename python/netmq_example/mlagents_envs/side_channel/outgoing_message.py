"""A message of a side channel that is to be sent: its values are written in the order in which they will be read.

    msg = OutgoingMessage()
    msg.write_string("score")
    msg.write_float32(12.5)
    channel.queue_message_to_send(msg)

The bytes are in incoming_message.py. In C# it is SideChannelMessages.cs.
"""

import struct
from collections.abc import Sequence
from typing import Any

from netmq_example import arguments, check
from netmq_example.mlagents_envs.exception import UnitySideChannelException
from netmq_example.mlagents_envs.side_channel.incoming_message import BOOL, FLOAT32, INT32

TAKES = {INT32: "a whole number from -2**31 to 2**31 - 1", FLOAT32: "a number, NaN and infinity as well"}


def packed(kind: struct.Struct, name: str, value: Any) -> bytes:
    """One number's bytes; ValueError names the parameter whose value is none."""
    try:
        return kind.pack(value)
    except (struct.error, OverflowError, TypeError):
        raise ValueError(f"{name} takes {TAKES[kind]}, not {value!r:.40}") from None


class OutgoingMessage:
    def __init__(self) -> None:
        self.buffer = bytearray()

    def write_bool(self, b: bool) -> None:
        # Everything else is true or false in Python as well, but as a value of a message it is a mistake.
        if b not in (True, False):
            raise ValueError(f"b takes True or False, not {b!r:.40}")
        self.buffer += BOOL.pack(b)

    def write_int32(self, i: int) -> None:
        self.buffer += packed(INT32, "i", i)

    def write_float32(self, f: float) -> None:
        self.buffer += packed(FLOAT32, "f", f)

    def write_float32_list(self, float_list: Sequence[float]) -> None:
        try:
            data = struct.pack(f"<i{len(float_list)}f", len(float_list), *float_list)
        except (struct.error, OverflowError, TypeError):
            raise ValueError(f"float_list takes a list of numbers, not {float_list!r:.40}") from None
        self.buffer += data

    def write_string(self, s: str, utf8: bool = False) -> None:
        if not utf8 and not check.instance("s", s, str).isascii():
            raise UnitySideChannelException("text that is not ASCII: write it with utf8=True")
        data = check.instance("s", s, str).encode(errors="replace")
        self.buffer += INT32.pack(len(data)) + data

    def set_raw_bytes(self, buffer: bytes | bytearray) -> None:
        """The whole message, in place of what was written."""
        self.buffer = bytearray(arguments.data("buffer", buffer))
