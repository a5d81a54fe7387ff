"""Numbers by name for a scene, or how the scene is to draw them by chance. From Python to Unity.

    parameters = EnvironmentParametersChannel()
    parameters.set_float_parameter("gravity", 9.81)
    parameters.set_uniform_sampler_parameters("mass", 0.5, 2.5, seed=1)

Bytes: string key, int32 type; type 0 is followed by a float32, type 1 by int32 seed, int32 kind of sampler and what
that takes. In C# it is EnvironmentParameters.cs, and Samplers.cs draws.
"""

import uuid
from collections.abc import Sequence
from enum import IntEnum

from netmq_example import arguments
from netmq_example.mlagents_envs.exception import UnityCommunicationException
from netmq_example.mlagents_envs.side_channel.incoming_message import FLOAT32, INT32
from netmq_example.mlagents_envs.side_channel.outgoing_message import packed
from netmq_example.mlagents_envs.side_channel.side_channel import IncomingMessage, OutgoingMessage, SideChannel


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
        raise UnityCommunicationException("parameters came from Unity, which is to receive them")

    def set_float_parameter(self, key: str, value: float) -> None:
        msg = self._begin(key, self.EnvironmentDataTypes.FLOAT)
        self._queue(msg, value=value)

    def set_uniform_sampler_parameters(self, key: str, min_value: float, max_value: float, seed: int) -> None:
        msg = self._begin_sampler(key, seed, self.SamplerTypes.UNIFORM)
        self._queue(msg, min_value=min_value, max_value=max_value)

    def set_gaussian_sampler_parameters(self, key: str, mean: float, st_dev: float, seed: int) -> None:
        msg = self._begin_sampler(key, seed, self.SamplerTypes.GAUSSIAN)
        self._queue(msg, mean=mean, st_dev=st_dev)

    def set_multirangeuniform_sampler_parameters(
        self, key: str, intervals: Sequence[tuple[float, float]], seed: int
    ) -> None:
        msg = self._begin_sampler(key, seed, self.SamplerTypes.MULTIRANGEUNIFORM)
        try:
            msg.write_float32_list([bound for low, high in intervals for bound in (low, high)])
        except (TypeError, ValueError):
            takes = "pairs of a lower and a higher number"
            raise ValueError(f"intervals takes {takes}, not {intervals!r:.40}") from None
        self.queue_message_to_send(msg)

    def _begin(self, key: str, kind: int) -> OutgoingMessage:
        msg = OutgoingMessage()
        msg.write_string(arguments.text("key", key))
        msg.write_int32(kind)
        return msg

    def _begin_sampler(self, key: str, seed: int, kind: int) -> OutgoingMessage:
        msg = self._begin(key, self.EnvironmentDataTypes.SAMPLER)
        msg.buffer += packed(INT32, "seed", seed)
        msg.write_int32(kind)
        return msg

    def _queue(self, msg: OutgoingMessage, **values: float) -> None:
        for name, value in values.items():
            msg.buffer += packed(FLOAT32, name, value)
        self.queue_message_to_send(msg)
