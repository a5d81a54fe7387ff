"""Numbers by name that both sides have; each tells the other what it sets.

    properties = FloatPropertiesChannel()
    properties.set_property("difficulty", 0.5)
    properties.get_property("round")                 what Unity has set, or None

Bytes: string key, float32 value. In C# it is FloatPropertiesChannel.cs.
"""

import uuid

from netmq_example import arguments, check
from netmq_example.mlagents_envs.exception import UnitySideChannelException
from netmq_example.mlagents_envs.side_channel.incoming_message import FLOAT32
from netmq_example.mlagents_envs.side_channel.outgoing_message import packed
from netmq_example.mlagents_envs.side_channel.side_channel import IncomingMessage, OutgoingMessage, SideChannel

# Limits for the properties that the other side sends.
MOST_PROPERTIES = 10_000
LONGEST_KEY = 1_000


class FloatPropertiesChannel(SideChannel):
    def __init__(self, channel_id: uuid.UUID | None = None) -> None:
        super().__init__(uuid.UUID("60ccf7d0-4f7e-11ea-b238-784f4387d1f7") if channel_id is None else channel_id)
        self.properties: dict[str, float] = {}

    def on_message_received(self, msg: IncomingMessage) -> None:
        key = msg.read_string()
        if len(key) > LONGEST_KEY or (len(self.properties) >= MOST_PROPERTIES and key not in self.properties):
            most = f"at most {MOST_PROPERTIES} properties, with names of at most {LONGEST_KEY} characters"
            raise UnitySideChannelException(most)
        self.properties[key] = msg.read_float32()

    def set_property(self, key: str, value: float) -> None:
        msg = OutgoingMessage()
        msg.write_string(arguments.text("key", key))
        msg.buffer += packed(FLOAT32, "value", value)
        self.queue_message_to_send(msg)
        self.properties[key] = value

    def get_property(self, key: str) -> float | None:
        return self.properties.get(check.instance("key", key, str))

    def list_properties(self) -> list[str]:
        return list(self.properties)

    def get_property_dict_copy(self) -> dict[str, float]:
        return dict(self.properties)
