"""Side channels with the module and class names of mlagents_envs.side_channel, and with its bytes.

A channel that was written for ML-Agents works here after one word of its imports is replaced:

    from netmq_example.side_channel import IncomingMessage, OutgoingMessage, SideChannel
    from netmq_example.side_channel.side_channel_manager import SideChannelManager

ML-Agents has one more name, DefaultTrainingAnalyticsSideChannel: its trainers report to Unity's analytics with it.
"""

from netmq_example.side_channel.incoming_message import IncomingMessage
from netmq_example.side_channel.outgoing_message import OutgoingMessage
from netmq_example.side_channel.side_channel import SideChannel

__all__ = ["IncomingMessage", "OutgoingMessage", "SideChannel"]
