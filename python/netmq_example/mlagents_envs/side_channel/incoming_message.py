"""A message of a side channel as it came: its values are read in the order in which they were written.

    msg = IncomingMessage(data)
    name, score = msg.read_string(), msg.read_float32()

Values stand one after the other, little-endian, without a name, a type or a gap: bool 1 byte; int32 and float32 4; a
string its length as int32, then its ASCII; a list its count as int32, then its float32s. A value that is not there at
all, because the message is over, is the default; one that is cut raises UnitySideChannelException.
In C# it is SideChannelMessages.cs.
"""

import struct
from typing import Any

from netmq_example import arguments, check
from netmq_example.mlagents_envs.exception import UnitySideChannelException

# Both halves of ML-Agents make zeros of a list's items that are missing. More than so many would only fill the memory.
MOST_MISSING = 65_536

BOOL = struct.Struct("?")
INT32 = struct.Struct("<i")
FLOAT32 = struct.Struct("<f")


class IncomingMessage:
    """`offset` is where in the bytes the first value begins."""

    def __init__(self, buffer: bytes, offset: int = 0) -> None:
        self.buffer = arguments.data("buffer", buffer)
        self.offset = check.count("offset", offset, least=0)

    def read_bool(self, default_value: bool = False) -> bool:
        return bool(self._read(BOOL, default_value))

    def read_int32(self, default_value: int = 0) -> int:
        return self._read(INT32, default_value)  # type: ignore[no-any-return]

    def read_float32(self, default_value: float = 0.0) -> float:
        return self._read(FLOAT32, default_value)  # type: ignore[no-any-return]

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
