"""Lesson 13, Unity's halves in Python: the channels of a simulation that is written in Python, as client.py.

What ML-Agents has in C# alone: settings and parameters are received, statistics are sent.
"""

import math
from collections.abc import Callable

from engine_configuration_channel import EngineConfigurationChannel
from environment_parameters_channel import EnvironmentParametersChannel
from samplers import Sampler, gaussian, multi_range_uniform, uniform
from side_channel import IncomingMessage, OutgoingMessage, UnitySideChannelException
from stats_side_channel import StatsAggregationMethod, StatsSideChannel


def describe(name: str, values: tuple[float, ...]) -> str:
    """A setting in words: `engine: time scale 2.0`."""
    return f"engine: {name} " + " x ".join(
        f"{value:.1f}" if isinstance(value, float) else f"{value}" for value in values
    )


class EngineSettings(EngineConfigurationChannel):
    """Hands each setting to `apply`, with its name and what it is to be."""

    def __init__(self, apply: Callable[[str, tuple[float, ...]], None]) -> None:
        super().__init__()
        self.apply = apply

    def on_message_received(self, msg: IncomingMessage) -> None:
        kind = msg.read_int32()
        if kind not in list(self.ConfigurationType):
            raise UnitySideChannelException(f"engine settings are 0 to 4, not {kind}: are both sides of one release?")
        values: tuple[float, ...]
        if kind == self.ConfigurationType.SCREEN_RESOLUTION:
            values = (msg.read_int32(), msg.read_int32())
            if min(values) <= 0:
                raise UnitySideChannelException(f"a screen of {values[0]} x {values[1]}")
        elif kind == self.ConfigurationType.TIME_SCALE:
            scale = msg.read_float32()
            if not math.isfinite(scale):
                raise UnitySideChannelException("a time scale that is no number")
            # As Unity's half does: no slower than time is.
            values = (max(scale, 1.0),)
        else:
            values = (msg.read_int32(),)
        self.apply(self.ConfigurationType(kind).name.lower().replace("_", " "), values)


class EnvironmentParameters(EnvironmentParametersChannel):
    """The parameters that came, each a number or a sampler."""

    def __init__(self) -> None:
        super().__init__()
        self.parameters: dict[str, Sampler] = {}
        self.callbacks: dict[str, Callable[[float], None]] = {}

    def get_with_default(self, key: str, default_value: float) -> float:
        """Of a sampler each call draws another number."""
        return self.parameters[key]() if key in self.parameters else default_value

    def register_callback(self, key: str, action: Callable[[float], None]) -> None:
        """One for each key, called when a number comes for it, and not for a sampler."""
        self.callbacks[key] = action

    def keys(self) -> list[str]:
        return list(self.parameters)

    def on_message_received(self, msg: IncomingMessage) -> None:
        key, kind = msg.read_string(), msg.read_int32()
        if kind == self.EnvironmentDataTypes.SAMPLER:
            self.parameters[key] = self.sampler(msg)
        elif kind == self.EnvironmentDataTypes.FLOAT:
            value = msg.read_float32()
            self.parameters[key] = lambda: value
            if key in self.callbacks:
                self.callbacks[key](value)
        else:
            raise UnitySideChannelException(
                f"parameters are of type 0 or 1, not {kind}: are both sides of one release?"
            )

    def sampler(self, msg: IncomingMessage) -> Sampler:
        seed, kind = msg.read_int32(), msg.read_int32()
        if kind == self.SamplerTypes.MULTIRANGEUNIFORM:
            return multi_range_uniform(msg.read_float32_list(), seed)
        if kind not in list(self.SamplerTypes):
            raise UnitySideChannelException(f"samplers are 0 to 2, not {kind}: are both sides of one release?")
        first, second = msg.read_float32(), msg.read_float32()
        return uniform(first, second, seed) if kind == self.SamplerTypes.UNIFORM else gaussian(first, second, seed)


class StatsRecorder(StatsSideChannel):
    """Sends what the trainer is to show."""

    def on_message_received(self, msg: IncomingMessage) -> None:
        raise UnitySideChannelException("statistics came from Python, which is to receive them")

    def add(
        self, key: str, value: float, aggregation_method: StatsAggregationMethod = StatsAggregationMethod.AVERAGE
    ) -> None:
        msg = OutgoingMessage()
        msg.write_string(key)
        msg.write_float32(value)
        msg.write_int32(aggregation_method)
        self.queue_message_to_send(msg)
