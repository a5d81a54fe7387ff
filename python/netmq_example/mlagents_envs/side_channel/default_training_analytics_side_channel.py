"""Unity's analytics: what a trainer would tell them. Here nothing is sent.

In ML-Agents every environment has this channel.
"""

import uuid

from netmq_example.mlagents_envs.exception import UnityCommunicationException
from netmq_example.mlagents_envs.side_channel.side_channel import IncomingMessage, SideChannel


class DefaultTrainingAnalyticsSideChannel(SideChannel):
    CHANNEL_ID = uuid.UUID("b664a4a9-d86f-5a5f-95cb-e8353a7e8356")

    def __init__(self) -> None:
        super().__init__(self.CHANNEL_ID)

    def on_message_received(self, msg: IncomingMessage) -> None:
        raise UnityCommunicationException("analytics came from Unity, which is to receive them")

    def environment_initialized(self) -> None:
        """Nothing is sent."""
