"""Lesson 13, properties: numbers by name that both sides have, and each tells the other what it sets.

Bytes: string key, float32 value. The C# side is FloatPropertiesChannel.cs.
"""

import uuid

from netmq_example.side_channel.side_channel import (
    IncomingMessage,
    OutgoingMessage,
    SideChannel,
    UnitySideChannelException,
)

# What the other side may make this one keep: so many, with names of so many characters.
MOST, LONGEST = 10_000, 1_000


class FloatPropertiesChannel(SideChannel):
    def __init__(self, channel_id: uuid.UUID | None = None) -> None:
        super().__init__(channel_id or uuid.UUID("60ccf7d0-4f7e-11ea-b238-784f4387d1f7"))
        self.properties: dict[str, float] = {}

    def on_message_received(self, msg: IncomingMessage) -> None:
        key = msg.read_string()
        if len(key) > LONGEST or (len(self.properties) >= MOST and key not in self.properties):
            raise UnitySideChannelException(f"at most {MOST} properties, with names of at most {LONGEST} characters")
        self.properties[key] = msg.read_float32()

    def set_property(self, key: str, value: float) -> None:
        msg = OutgoingMessage()
        msg.write_string(key)
        msg.write_float32(value)
        self.queue_message_to_send(msg)
        self.properties[key] = value

    def get_property(self, key: str) -> float | None:
        return self.properties.get(key)

    def list_properties(self) -> list[str]:
        return list(self.properties)

    def get_property_dict_copy(self) -> dict[str, float]:
        return dict(self.properties)
