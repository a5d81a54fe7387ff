"""Side channels with the module and class names of mlagents_envs.side_channel, and with its bytes.

A channel that was written for ML-Agents works here after one word of its imports is replaced:

    from netmq_example.mlagents_envs.side_channel import IncomingMessage, OutgoingMessage, SideChannel
    from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
"""

from netmq_example.mlagents_envs.side_channel.default_training_analytics_side_channel import (
    DefaultTrainingAnalyticsSideChannel,
)
from netmq_example.mlagents_envs.side_channel.engine_configuration_channel import (
    EngineConfig,
    EngineConfigurationChannel,
)
from netmq_example.mlagents_envs.side_channel.environment_parameters_channel import EnvironmentParametersChannel
from netmq_example.mlagents_envs.side_channel.float_properties_channel import FloatPropertiesChannel
from netmq_example.mlagents_envs.side_channel.incoming_message import IncomingMessage
from netmq_example.mlagents_envs.side_channel.outgoing_message import OutgoingMessage
from netmq_example.mlagents_envs.side_channel.raw_bytes_channel import RawBytesChannel
from netmq_example.mlagents_envs.side_channel.side_channel import SideChannel
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.mlagents_envs.side_channel.stats_side_channel import StatsAggregationMethod, StatsSideChannel

__all__ = [
    "DefaultTrainingAnalyticsSideChannel",
    "EngineConfig",
    "EngineConfigurationChannel",
    "EnvironmentParametersChannel",
    "FloatPropertiesChannel",
    "IncomingMessage",
    "OutgoingMessage",
    "RawBytesChannel",
    "SideChannel",
    "SideChannelManager",
    "StatsAggregationMethod",
    "StatsSideChannel",
]
