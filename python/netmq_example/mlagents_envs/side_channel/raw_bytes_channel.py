"""Messages of bytes, such as pictures, to which you give a meaning yourself. Both ways.

    pictures = RawBytesChannel(uuid.UUID("00112233-4455-6677-8899-aabbccddeeff"))
    pictures.send_raw_data(b"...")
    for picture in pictures.get_and_clear_received_messages(): ...

In C# it is RawBytesChannel.cs.
"""

import uuid

from netmq_example.mlagents_envs.side_channel.side_channel import IncomingMessage, OutgoingMessage, SideChannel


class RawBytesChannel(SideChannel):
    def __init__(self, channel_id: uuid.UUID) -> None:
        super().__init__(channel_id)
        self.received: list[bytes] = []

    def on_message_received(self, msg: IncomingMessage) -> None:
        self.received.append(bytes(msg.get_raw_bytes()))

    def get_and_clear_received_messages(self) -> list[bytes]:
        received = self.received
        self.received = []
        return received

    def send_raw_data(self, data: bytes | bytearray) -> None:
        msg = OutgoingMessage()
        msg.set_raw_bytes(data)
        self.queue_message_to_send(msg)
