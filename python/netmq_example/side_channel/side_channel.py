"""Lesson 13, side channels: many small conversations share one exchange, and none knows the others.

Derive from SideChannel for each conversation. The names are ML-Agents': a channel class that was written for it works
here, and talks to the one that it was written for. The C# side is SideChannel.cs.
"""

import uuid
from abc import ABC, abstractmethod
from collections.abc import Callable

from netmq_example.side_channel.messages import IncomingMessage, OutgoingMessage, UnitySideChannelException

__all__ = ["Channel", "IncomingMessage", "OutgoingMessage", "SideChannel", "UnitySideChannelException"]

# An exchange is at most this large, with the 20 bytes in front of each message.
LARGEST_EXCHANGE = 16 * 1024 * 1024
# What a channel keeps while nobody takes its messages: so many, with so many bytes together.
MOST_QUEUED, MOST_BYTES = 100_000, 4 * LARGEST_EXCHANGE


class Channel(ABC):
    """What the manager knows of a conversation: its id, what it has to say, and that it takes bytes."""

    def __init__(self, channel_id: uuid.UUID) -> None:
        self._channel_id = channel_id
        self.message_queue: list[bytes] = []
        self.size = self.dropped = 0
        # The manager's, once it is registered.
        self.report: Callable[[str], None] = print

    @property
    def channel_id(self) -> uuid.UUID:
        return self._channel_id

    @abstractmethod
    def process_message(self, message: bytes) -> None: ...

    def queue_bytes(self, data: bytes | bytearray) -> None:
        if len(data) > LARGEST_EXCHANGE - 20:
            raise UnitySideChannelException(f"a message of {len(data)} bytes is too large: send it in parts")
        # A copy: who writes on in the message does not change what was queued.
        self.message_queue.append(bytes(data))
        self.size += len(data)
        if len(self.message_queue) > MOST_QUEUED or self.size > MOST_BYTES:
            if not self.dropped:
                self.report(f"channel {self.channel_id}: nobody takes its messages, the oldest are dropped")
            self.dropped += len(self.take((len(self.message_queue) + 1) // 2))

    def take(self, count: int) -> list[bytes]:
        """The oldest, which are then no longer queued."""
        taken, self.message_queue = self.message_queue[:count], self.message_queue[count:]
        self.size = sum(map(len, self.message_queue))
        return taken


class SideChannel(Channel):
    """One conversation. Give it an id that no other has: uuid.uuid4() makes one."""

    @abstractmethod
    def on_message_received(self, msg: IncomingMessage) -> None:
        """A message of the other side's channel with the same id."""

    def queue_message_to_send(self, msg: OutgoingMessage) -> None:
        """It leaves with the next exchange."""
        self.queue_bytes(msg.buffer)

    def process_message(self, message: bytes) -> None:
        self.on_message_received(IncomingMessage(message))
