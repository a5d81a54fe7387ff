"""How fast the game's time passes, and how it is drawn. From Python to Unity.

    engine = EngineConfigurationChannel()
    engine.set_configuration_parameters(time_scale=2.0, target_frame_rate=60)

Bytes: one message for each setting: its number as int32, then int32 width and height, or float32 time scale, or one
int32. In C# it is EngineConfigurationChannel.cs.
"""

import uuid
from enum import IntEnum
from typing import NamedTuple

from netmq_example import arguments, check
from netmq_example.mlagents_envs.exception import UnityCommunicationException, UnitySideChannelException
from netmq_example.mlagents_envs.side_channel.incoming_message import FLOAT32, INT32
from netmq_example.mlagents_envs.side_channel.outgoing_message import packed
from netmq_example.mlagents_envs.side_channel.side_channel import IncomingMessage, OutgoingMessage, SideChannel

# ML-Agents has 1 to 100, which is all that Unity's editor takes: faster than that, a game only stands still.
LEAST_TIME_SCALE, MOST_TIME_SCALE = 1.0, 100.0
# Pixels, the largest texture of most graphics cards.
MOST_PIXELS = 16_384


class EngineConfig(NamedTuple):
    width: int | None
    height: int | None
    quality_level: int | None
    time_scale: float | None
    target_frame_rate: int | None
    capture_frame_rate: int | None

    @staticmethod
    def default_config() -> "EngineConfig":
        """ML-Agents trains with these: a small window, 20 times as fast."""
        return EngineConfig(80, 80, 1, 20.0, -1, 60)


class EngineConfigurationChannel(SideChannel):
    class ConfigurationType(IntEnum):
        SCREEN_RESOLUTION = 0
        QUALITY_LEVEL = 1
        TIME_SCALE = 2
        TARGET_FRAME_RATE = 3
        CAPTURE_FRAME_RATE = 4

    def __init__(self) -> None:
        super().__init__(uuid.UUID("e951342c-4f7e-11ea-b238-784f4387d1f7"))

    def on_message_received(self, msg: IncomingMessage) -> None:
        raise UnityCommunicationException("engine settings came from Unity, which is to receive them")

    def set_configuration_parameters(
        self,
        width: int | None = None,
        height: int | None = None,
        quality_level: int | None = None,
        time_scale: float | None = None,
        target_frame_rate: int | None = None,
        capture_frame_rate: int | None = None,
    ) -> None:
        if (width is None) != (height is None):
            raise UnitySideChannelException("width and height are one setting: give both, or neither")
        self._queue(self.ConfigurationType.SCREEN_RESOLUTION, width=width, height=height)
        self._queue(self.ConfigurationType.QUALITY_LEVEL, quality_level=quality_level)
        self._queue(self.ConfigurationType.TIME_SCALE, time_scale=time_scale)
        self._queue(self.ConfigurationType.TARGET_FRAME_RATE, target_frame_rate=target_frame_rate)
        self._queue(self.ConfigurationType.CAPTURE_FRAME_RATE, capture_frame_rate=capture_frame_rate)

    def set_configuration(self, config: EngineConfig) -> None:
        self.set_configuration_parameters(**check.instance("config", config, EngineConfig)._asdict())

    def _queue(self, kind: ConfigurationType, **values: float | None) -> None:
        msg = OutgoingMessage()
        msg.write_int32(kind)
        for name, value in values.items():
            if value is None:
                return
            if name == "time_scale":
                arguments.number(name, value, 0, MOST_TIME_SCALE)
            number = FLOAT32 if kind == self.ConfigurationType.TIME_SCALE else INT32
            msg.buffer += packed(number, name, value)
        self.queue_message_to_send(msg)
