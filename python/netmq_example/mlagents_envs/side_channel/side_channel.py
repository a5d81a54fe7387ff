"""One of many small conversations that share one exchange and know nothing of each other.

    class Weather(SideChannel):
        def __init__(self) -> None:
            super().__init__(uuid.UUID("8d4c1c4e-3c0a-4a5e-9d5b-6f0f6f3c2b11"))    uuid.uuid4() makes one of your own

        def on_message_received(self, msg: IncomingMessage) -> None:
            print(msg.read_string())

The names are ML-Agents', so a channel that was written for it works here, and talks to its other half in C#.
In C# it is SideChannel.cs.
"""

import logging
import uuid
from abc import ABC, abstractmethod
from collections.abc import Callable

from netmq_example import arguments, check
from netmq_example.mlagents_envs.exception import UnitySideChannelException
from netmq_example.mlagents_envs.side_channel.incoming_message import IncomingMessage
from netmq_example.mlagents_envs.side_channel.outgoing_message import OutgoingMessage

__all__ = ["Channel", "IncomingMessage", "OutgoingMessage", "SideChannel"]

# An exchange is at most this large, with the 20 bytes in front of each message.
LARGEST_EXCHANGE_BYTES = 16 * 1024 * 1024
# A channel keeps so much while no reader takes its messages.
MOST_QUEUED = 100_000
MOST_QUEUED_BYTES = 4 * LARGEST_EXCHANGE_BYTES

log = logging.getLogger("netmq_example.envs")


class Channel(ABC):
    """A channel as the manager sees it: an id, queued messages, and a method that takes bytes."""

    def __init__(self, channel_id: uuid.UUID) -> None:
        self._channel_id = check.instance("channel_id", channel_id, uuid.UUID)
        self.message_queue: list[bytes] = []
        self.queued_bytes = 0
        self.dropped = 0
        # The manager's, once it is registered.
        self.report: Callable[[str], object] = log.warning

    @property
    def channel_id(self) -> uuid.UUID:
        return self._channel_id

    @abstractmethod
    def process_message(self, message: bytes) -> None: ...

    def queue_bytes(self, data: bytes | bytearray) -> None:
        # A copy: writing on in the message does not change what was queued.
        message = arguments.data("data", data)
        if len(message) > LARGEST_EXCHANGE_BYTES - 20:
            raise UnitySideChannelException(f"a message of {len(message)} bytes is too large: send it in parts")
        self.message_queue.append(message)
        self.queued_bytes += len(message)
        if len(self.message_queue) > MOST_QUEUED or self.queued_bytes > MOST_QUEUED_BYTES:
            if not self.dropped:
                self.report(f"channel {self.channel_id}: nobody takes its messages, the oldest are dropped")
            self.dropped += len(self.take((len(self.message_queue) + 1) // 2))

    def take(self, count: int) -> list[bytes]:
        """The oldest messages, which are then no longer queued."""
        taken = self.message_queue[:count]
        self.message_queue = self.message_queue[count:]
        self.queued_bytes = sum(map(len, self.message_queue))
        return taken


class SideChannel(Channel):
    """Derive from it, with an id that no other channel has."""

    @abstractmethod
    def on_message_received(self, msg: IncomingMessage) -> None:
        """A message of the other side's channel with the same id."""

    def queue_message_to_send(self, msg: OutgoingMessage) -> None:
        """It leaves with the next exchange."""
        self.queue_bytes(check.instance("msg", msg, OutgoingMessage).buffer)

    def process_message(self, message: bytes) -> None:
        self.on_message_received(IncomingMessage(message))
