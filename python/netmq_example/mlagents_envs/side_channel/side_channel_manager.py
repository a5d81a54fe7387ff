"""Packs what all channels have queued into one exchange, and hands out what has come in one.

    manager = SideChannelManager([StringLogChannel(), EnvironmentParametersChannel()])
    socket.send(manager.generate_side_channel_messages())
    manager.process_side_channel_message(socket.recv())

An exchange is any number of messages, one after the other; none at all is an exchange, too. It is what ML-Agents sends:

    16 bytes    the channel's id, a UUID with its first three groups little-endian: bytes_le, as C#'s ToByteArray
    4 bytes     how long the message is, int32, little-endian
    ...         the message, which only its channel understands

In C# it is SideChannelManager.cs.
"""

import logging
import struct
import traceback
import uuid
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from netmq_example import arguments, check
from netmq_example.mlagents_envs.exception import UnityException, UnitySideChannelException
from netmq_example.mlagents_envs.side_channel.side_channel import LARGEST_EXCHANGE_BYTES, Channel, IncomingMessage

# Limits for messages to channels that are not registered yet.
MOST_KEPT = 100
LARGEST_KEPT_BYTES = 65_536

# A channel that was made by ML-Agents' own package has these.
FOREIGN = ("channel_id", "message_queue", "on_message_received")

log = logging.getLogger("netmq_example.envs")


class Foreign(Channel):
    """Stands in for a channel of another package."""

    def __init__(self, channel: Any) -> None:
        self.channel = channel
        queued = channel.message_queue
        super().__init__(channel.channel_id)
        self.message_queue = queued

    @property
    def message_queue(self) -> list[bytes]:
        queued: list[bytes] = self.channel.message_queue
        return queued

    @message_queue.setter
    def message_queue(self, queued: list[bytes]) -> None:
        self.channel.message_queue = queued

    def process_message(self, message: bytes) -> None:
        self.channel.on_message_received(IncomingMessage(message))


class SideChannelManager:
    """The channels of one exchange. A message that could not be delivered yet is logged, unless `report` takes it."""

    def __init__(
        self, side_channels: Sequence[Any] | None = None, report: Callable[[str], object] = log.warning
    ) -> None:
        # By the bytes on the wire: to make a UUID of each message's would take longer than the rest.
        self.channels: dict[bytes, Channel] = {}
        self.unknown: list[tuple[bytes, bytes]] = []
        # Whether it was said that those of this channel are dropped.
        self.dropped: set[bytes] = set()
        self.report = arguments.function("report", report)
        for channel in check.instance("side_channels", [] if side_channels is None else side_channels, list, tuple):
            self.register_side_channel(channel)

    @property
    def _side_channels_dict(self) -> dict[uuid.UUID, Any]:
        """The channels by their ids, as ML-Agents' has them; programs look into it."""
        return {one.channel_id: one.channel if isinstance(one, Foreign) else one for one in self.channels.values()}

    def register_side_channel(self, channel: Any) -> None:
        """At any time: what came for it before is delivered now."""
        if not isinstance(channel, Channel) and all(hasattr(channel, name) for name in FOREIGN):
            channel = Foreign(channel)
        channel_id = check.instance("channel", channel, Channel).channel_id.bytes_le
        if channel_id in self.channels:
            raise UnitySideChannelException(f"channel {channel.channel_id} is registered already: give each its own id")
        self.channels[channel_id] = channel
        channel.report = self.report
        early = [message for known, message in self.unknown if known == channel_id]
        self.unknown = [kept for kept in self.unknown if kept[0] != channel_id]
        self.dropped.discard(channel_id)
        for message in early:
            self._deliver(channel, message)

    def generate_side_channel_messages(self, unsent: bytes = b"") -> bytearray:
        """The queued messages of all channels, after `unsent`: by order of registration, then of queueing.
        A message that would make it too large stays queued for the next exchange.
        """
        data = bytearray(arguments.data("unsent", unsent))
        for channel_id, channel in self.channels.items():
            if channel.dropped:
                self.report(f"channel {channel.channel_id}: {channel.dropped} messages were dropped")
            channel.dropped = 0
            count = 0
            for message in channel.message_queue:
                if len(data) + 20 + len(message) > LARGEST_EXCHANGE_BYTES:
                    break
                data += channel_id + struct.pack("<i", len(message)) + message
                count += 1
            channel.take(count)
        return data

    def process_side_channel_message(self, data: bytes) -> None:
        """Each message to its channel. UnitySideChannelException when the last one is cut: those before it are done."""
        data = arguments.data("data", data)
        offset = 0
        while offset < len(data):
            if len(data) - offset < 20:
                raise UnitySideChannelException(f"an exchange that ends with {len(data) - offset} bytes of a header")
            channel_id = data[offset : offset + 16]
            (length,) = struct.unpack_from("<i", data, offset + 16)
            offset += 20
            if not 0 <= length <= len(data) - offset:
                here = f"{length} bytes, of which {len(data) - offset} are there"
                raise UnitySideChannelException(f"a message to channel {uuid.UUID(bytes_le=channel_id)} of {here}")
            message = data[offset : offset + length]
            offset += length
            if channel := self.channels.get(channel_id):
                self._deliver(channel, message)
            else:
                self._keep(channel_id, message)

    def take_in(self, data: bytes) -> None:
        """The same for an exchange that came with a step: what is cut is a line of `report`."""
        try:
            self.process_side_channel_message(data)
        except UnitySideChannelException as error:
            self.report(str(error))

    def _deliver(self, channel: Channel, message: bytes) -> None:
        """An error in one channel leaves the others alone."""
        try:
            channel.process_message(message)
        except UnityException as error:
            self.report(f"channel {channel.channel_id}: {error}")
        except Exception as error:
            calls = traceback.extract_tb(error.__traceback__)[1:]
            where = ", ".join(f"{Path(call.filename).name}:{call.lineno}" for call in calls[-4:]) or "called wrongly"
            self.report(f"channel {channel.channel_id}: its handler raised {error!r:.200} ({where})")

    def _keep(self, channel_id: bytes, message: bytes) -> None:
        name = uuid.UUID(bytes_le=channel_id)
        if len(self.unknown) == MOST_KEPT or len(message) > LARGEST_KEPT_BYTES:
            if channel_id not in self.dropped:
                cure = "pass this channel in side_channels, such as a StatsSideChannel for a StatsRecorder"
                self.report(f"unknown channel {name}: too much is kept, and what comes now is dropped; {cure}")
            self.dropped.add(channel_id)
            return
        if channel_id not in [known for known, _ in self.unknown]:
            self.report(f"unknown channel {name}: kept until it is registered")
        self.unknown.append((channel_id, message))
