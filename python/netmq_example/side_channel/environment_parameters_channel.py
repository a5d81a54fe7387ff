"""Lesson 13, parameters: numbers by name for a scene, or how to draw them by chance. From Python to Unity.

Bytes: string key, int32 type; type 0 is followed by a float32, type 1 by int32 seed, int32 kind of sampler and what
that takes. The C# side is EnvironmentParameters.cs, and Samplers.cs draws.
"""

import uuid
from enum import IntEnum

from netmq_example.side_channel.side_channel import (
    IncomingMessage,
    OutgoingMessage,
    SideChannel,
    UnitySideChannelException,
)


class EnvironmentParametersChannel(SideChannel):
    class EnvironmentDataTypes(IntEnum):
        FLOAT = 0
        SAMPLER = 1

    class SamplerTypes(IntEnum):
        UNIFORM = 0
        GAUSSIAN = 1
        MULTIRANGEUNIFORM = 2

    def __init__(self) -> None:
        super().__init__(uuid.UUID("534c891e-810f-11ea-a9d0-822485860400"))

    def on_message_received(self, msg: IncomingMessage) -> None:
        raise UnitySideChannelException("parameters came from Unity, which is to receive them")

    def set_float_parameter(self, key: str, value: float) -> None:
        msg = self._begin(key, self.EnvironmentDataTypes.FLOAT)
        msg.write_float32(value)
        self.queue_message_to_send(msg)

    def set_uniform_sampler_parameters(self, key: str, min_value: float, max_value: float, seed: int) -> None:
        msg = self._begin_sampler(key, seed, self.SamplerTypes.UNIFORM)
        msg.write_float32(min_value)
        msg.write_float32(max_value)
        self.queue_message_to_send(msg)

    def set_gaussian_sampler_parameters(self, key: str, mean: float, st_dev: float, seed: int) -> None:
        msg = self._begin_sampler(key, seed, self.SamplerTypes.GAUSSIAN)
        msg.write_float32(mean)
        msg.write_float32(st_dev)
        self.queue_message_to_send(msg)

    def set_multirangeuniform_sampler_parameters(
        self, key: str, intervals: list[tuple[float, float]], seed: int
    ) -> None:
        msg = self._begin_sampler(key, seed, self.SamplerTypes.MULTIRANGEUNIFORM)
        msg.write_float32_list([bound for interval in intervals for bound in interval])
        self.queue_message_to_send(msg)

    @staticmethod
    def _begin(key: str, kind: int) -> OutgoingMessage:
        msg = OutgoingMessage()
        msg.write_string(key)
        msg.write_int32(kind)
        return msg

    def _begin_sampler(self, key: str, seed: int, kind: int) -> OutgoingMessage:
        msg = self._begin(key, self.EnvironmentDataTypes.SAMPLER)
        msg.write_int32(seed)
        msg.write_int32(kind)
        return msg
