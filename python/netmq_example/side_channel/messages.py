"""Lesson 13, messages: the values in one message of a side channel, as ML-Agents lays them out.

Values stand one after the other, little-endian, without a name, a type or a gap: whoever reads has to know the order.
A value that is not there at all, because the message is over, is the default.
Bytes: bool 1; int32 and float32 4; a string its length as int32, then its ASCII; a list its count as int32, then its
float32s. The C# side is SideChannelMessages.cs.
"""

import struct
from typing import Any

# Both halves of ML-Agents make zeros of a list's items that are missing. More than so many would only fill the memory.
MOST_MISSING = 65_536


BOOL, INT32, FLOAT32 = struct.Struct("?"), struct.Struct("<i"), struct.Struct("<f")


class UnitySideChannelException(Exception):
    """What is wrong with a message, a channel or a setting."""


class IncomingMessage:
    """Read its values in the order in which they were written."""

    def __init__(self, buffer: bytes, offset: int = 0) -> None:
        self.buffer, self.offset = bytes(buffer), offset

    def read_bool(self, default_value: bool = False) -> bool:
        return bool(self._read(BOOL, default_value))

    def read_int32(self, default_value: int = 0) -> int:
        return int(self._read(INT32, default_value))

    def read_float32(self, default_value: float = 0.0) -> float:
        return float(self._read(FLOAT32, default_value))

    def read_float32_list(self, default_value: list[float] | None = None) -> list[float]:
        if self._left() <= 0:
            return [] if default_value is None else default_value
        count = self._length()
        if count - self._left() // 4 > MOST_MISSING:
            raise UnitySideChannelException(f"a list of {count} items, of which {self._left()} bytes are there")
        return [self.read_float32() for _ in range(count)]

    def read_string(self, default_value: str = "") -> str:
        if self._left() <= 0:
            return default_value
        length = self._length()
        data = self.buffer[self.offset : self.offset + length]
        self.offset += length
        try:
            # ASCII, or what write_string wrote with utf8=True.
            return data.decode()
        except UnicodeDecodeError:
            raise UnitySideChannelException("a text that is neither ASCII nor UTF-8") from None

    def get_raw_bytes(self) -> bytearray:
        """The whole message, however much of it was read."""
        return bytearray(self.buffer)

    def _left(self) -> int:
        return len(self.buffer) - self.offset

    def _length(self) -> int:
        length = self.read_int32()
        if length < 0:
            raise UnitySideChannelException(f"a length of {length}")
        return length

    def _read(self, kind: struct.Struct, default_value: Any) -> Any:
        if self._left() <= 0:
            return default_value
        if self._left() < kind.size:
            raise UnitySideChannelException(f"a number of which only {self._left()} bytes are there")
        self.offset += kind.size
        return kind.unpack_from(self.buffer, self.offset - kind.size)[0]


class OutgoingMessage:
    """Write its values in the order in which they will be read."""

    def __init__(self) -> None:
        self.buffer = bytearray()

    def write_bool(self, b: bool) -> None:
        self.buffer += BOOL.pack(b)

    def write_int32(self, i: int) -> None:
        self.buffer += INT32.pack(i)

    def write_float32(self, f: float) -> None:
        self.buffer += FLOAT32.pack(f)

    def write_float32_list(self, float_list: list[float]) -> None:
        # At once: when one of them is no number, nothing is written.
        self.buffer += struct.pack(f"<i{len(float_list)}f", len(float_list), *float_list)

    def write_string(self, s: str, utf8: bool = False) -> None:
        if not utf8 and not s.isascii():
            raise UnitySideChannelException("text that is not ASCII: write it with utf8=True")
        data = s.encode(errors="replace")
        self.buffer += INT32.pack(len(data)) + data

    def set_raw_bytes(self, buffer: bytes | bytearray) -> None:
        """The whole message, in place of what was written."""
        self.buffer = bytearray(buffer)
