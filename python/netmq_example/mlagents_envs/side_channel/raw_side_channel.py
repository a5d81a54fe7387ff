"""Channels as ML-Agents had them early in 2020, when a message was bytes and nothing else.

    class Log(SideChannel):
        def on_message_received(self, data: bytes) -> None:
            print(data.decode("ascii"))

The exchange is the same, and such a channel talks to any other; only a text had no length in front of it then.
"""

from abc import abstractmethod

from netmq_example.mlagents_envs.side_channel.side_channel import Channel

__all__ = ["SideChannel"]


class SideChannel(Channel):
    @abstractmethod
    def on_message_received(self, data: bytes) -> None:
        """A message of the other side's channel with the same id."""

    def process_message(self, message: bytes) -> None:
        self.on_message_received(message)

    def queue_message_to_send(self, data: bytes | bytearray) -> None:
        self.queue_bytes(data)
