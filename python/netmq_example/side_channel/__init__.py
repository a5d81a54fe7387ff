"""Side channels with the module and class names of mlagents_envs.side_channel, and with its bytes.

A channel that was written for ML-Agents works here after one word of its imports is replaced:

    from netmq_example.side_channel import IncomingMessage, OutgoingMessage, SideChannel
    from netmq_example.side_channel.side_channel_manager import SideChannelManager

ML-Agents has one more name, DefaultTrainingAnalyticsSideChannel: its trainers report to Unity's analytics with it.
"""

from typing import TYPE_CHECKING

from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.side_channel.carrier import Carrier, ClientCarrier
    from netmq_example.side_channel.engine_configuration_channel import EngineConfig, EngineConfigurationChannel
    from netmq_example.side_channel.environment_parameters_channel import EnvironmentParametersChannel
    from netmq_example.side_channel.float_properties_channel import FloatPropertiesChannel
    from netmq_example.side_channel.incoming_message import IncomingMessage
    from netmq_example.side_channel.outgoing_message import OutgoingMessage
    from netmq_example.side_channel.raw_bytes_channel import RawBytesChannel
    from netmq_example.side_channel.side_channel import SideChannel
    from netmq_example.side_channel.side_channel_manager import SideChannelManager
    from netmq_example.side_channel.stats_side_channel import StatsAggregationMethod, StatsSideChannel
    from netmq_example.side_channel.unity_channels import EngineSettings, EnvironmentParameters, StatsRecorder

__all__ = [
    "Carrier",
    "ClientCarrier",
    "EngineConfig",
    "EngineConfigurationChannel",
    "EngineSettings",
    "EnvironmentParameters",
    "EnvironmentParametersChannel",
    "FloatPropertiesChannel",
    "IncomingMessage",
    "OutgoingMessage",
    "RawBytesChannel",
    "SideChannel",
    "SideChannelManager",
    "StatsAggregationMethod",
    "StatsRecorder",
    "StatsSideChannel",
]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {
        "carrier": "Carrier ClientCarrier",
        "engine_configuration_channel": "EngineConfig EngineConfigurationChannel",
        "environment_parameters_channel": "EnvironmentParametersChannel",
        "float_properties_channel": "FloatPropertiesChannel",
        "incoming_message": "IncomingMessage",
        "outgoing_message": "OutgoingMessage",
        "raw_bytes_channel": "RawBytesChannel",
        "side_channel": "SideChannel",
        "side_channel_manager": "SideChannelManager",
        "stats_side_channel": "StatsAggregationMethod StatsSideChannel",
        "unity_channels": "EngineSettings EnvironmentParameters StatsRecorder",
    }
    __getattr__, __dir__ = door(__name__, ROOMS)
