"""Unity's half of ML-Agents' channels, for a simulation that is written in Python: it receives settings and parameters.

    parameters = EnvironmentParameters()
    parameters.get_with_default("gravity", 9.81)
    stats = StatsRecorder()
    stats.add("score", 12.5)

A parameter is a number or a sampler, which draws another number each time, the same for the same seed in Python and
C#. (Unity's own ML-Agents draws with System.Random: other numbers, spread in the same way.) Values are float32.
In C# they are EngineConfigurationChannel.cs, EnvironmentParameters.cs, Samplers.cs and StatsRecorder.cs.
"""

import math
import struct
from collections.abc import Callable
from itertools import islice

from netmq_example import arguments, check
from netmq_example.mlagents_envs.exception import UnitySideChannelException
from netmq_example.mlagents_envs.side_channel.engine_configuration_channel import (
    LEAST_TIME_SCALE,
    MOST_PIXELS,
    MOST_TIME_SCALE,
    EngineConfigurationChannel,
)
from netmq_example.mlagents_envs.side_channel.environment_parameters_channel import EnvironmentParametersChannel
from netmq_example.mlagents_envs.side_channel.incoming_message import FLOAT32
from netmq_example.mlagents_envs.side_channel.outgoing_message import packed
from netmq_example.mlagents_envs.side_channel.side_channel import IncomingMessage, OutgoingMessage
from netmq_example.mlagents_envs.side_channel.stats_side_channel import StatsAggregationMethod, StatsSideChannel
from netmq_example.wire.split_mix import Draws, draws

__all__ = ["EngineSettings", "EnvironmentParameters", "StatsRecorder"]

Sampler = Callable[[], float]


def to_float32(value: float) -> float:
    """Infinity where it is too large, as C# makes of it."""
    try:
        return float(struct.unpack("f", struct.pack("f", value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


def uniform(low: float, high: float, seed: int) -> Sampler:
    rng = drawn(seed, low, high)
    return lambda: to_float32(low + next(rng) * (high - low))


def gaussian(mean: float, st_dev: float, seed: int) -> Sampler:
    """The sum of twelve numbers from 0 to 1 is bell-shaped with deviation 1, and needs no logarithm: those of two
    systems differ in the last bit.
    """
    rng = drawn(seed, mean, st_dev)

    def draw() -> float:
        total = -6.0
        # One by one: sum() of Python 3.12 makes up for what is lost in rounding, and C# does not.
        for number in islice(rng, 12):
            total += number
        return to_float32(mean + st_dev * total)

    return draw


def multi_range_uniform(bounds: list[float], seed: int) -> Sampler:
    """From several intervals, `[low, high, low, high, ...]`: a longer one is hit more often."""
    rng = drawn(seed, *bounds)
    intervals = list(zip(bounds[::2], bounds[1::2], strict=True)) if len(bounds) % 2 == 0 else []
    if not intervals or any(low > high for low, high in intervals):
        raise UnitySideChannelException("ranges are pairs of a lower and a higher number")
    length = 0.0
    for low, high in intervals:
        length += high - low

    def draw() -> float:
        at = next(rng) * length
        for low, high in intervals:
            if at <= high - low:
                break
            at -= high - low
        return to_float32(min(low + at, high))

    return draw


def drawn(seed: int, *numbers: float) -> Draws:
    """For a sampler with these numbers; the seed is an int32, as it is on the wire."""
    if not all(map(check.is_number, numbers)):
        raise UnitySideChannelException("a sampler takes numbers, not NaN or infinity")
    return draws(check.count("seed", seed, least=-(2**31)))


def describe(name: str, values: tuple[float, ...]) -> str:
    """A setting in words: `engine: time scale 2.0`."""
    numbers = (f"{value:.1f}" if isinstance(value, float) else f"{value}" for value in values)
    return f"engine: {name} {' x '.join(numbers)}"


class EngineSettings(EngineConfigurationChannel):
    """Hands each setting to `apply`, with its name and what it is to be."""

    def __init__(self, apply: Callable[[str, tuple[float, ...]], None]) -> None:
        super().__init__()
        self.apply = arguments.function("apply", apply)

    def on_message_received(self, msg: IncomingMessage) -> None:
        kind = msg.read_int32()
        if kind not in list(self.ConfigurationType):
            raise UnitySideChannelException(f"engine settings are 0 to 4, not {kind}: are both sides of one release?")
        values: tuple[float, ...]
        if kind == self.ConfigurationType.SCREEN_RESOLUTION:
            values = (msg.read_int32(), msg.read_int32())
            if min(values) <= 0 or max(values) > MOST_PIXELS:
                raise UnitySideChannelException(f"a screen of {values[0]} x {values[1]}")
        elif kind == self.ConfigurationType.TIME_SCALE:
            scale = msg.read_float32()
            if not math.isfinite(scale):
                raise UnitySideChannelException("a time scale that is no number")
            # As Unity's half does.
            values = (min(max(scale, LEAST_TIME_SCALE), MOST_TIME_SCALE),)
        else:
            values = (msg.read_int32(),)
        name = self.ConfigurationType(kind).name.lower().replace("_", " ")
        # -1 is for as Unity likes.
        if values[0] < (-1 if kind == self.ConfigurationType.TARGET_FRAME_RATE else 0):
            raise UnitySideChannelException(f"a {name} of {values[0]}")
        self.apply(name, values)


class EnvironmentParameters(EnvironmentParametersChannel):
    """The parameters that came, each a number or a sampler."""

    def __init__(self) -> None:
        super().__init__()
        self.parameters: dict[str, Sampler] = {}
        self.callbacks: dict[str, Callable[[float], None]] = {}

    def get_with_default(self, key: str, default_value: float) -> float:
        """Of a sampler each call draws another number."""
        sampler = self.parameters.get(check.instance("key", key, str))
        return sampler() if sampler else default_value

    def register_callback(self, key: str, action: Callable[[float], None]) -> None:
        """One for each key, called when a number comes for it, and not for a sampler."""
        self.callbacks[arguments.text("key", key)] = arguments.function("action", action)

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
    def on_message_received(self, msg: IncomingMessage) -> None:
        raise UnitySideChannelException("statistics came from Python, which is to receive them")

    def add(
        self, key: str, value: float, aggregation_method: StatsAggregationMethod = StatsAggregationMethod.AVERAGE
    ) -> None:
        msg = OutgoingMessage()
        msg.write_string(arguments.text("key", key))
        msg.buffer += packed(FLOAT32, "value", value)
        msg.write_int32(StatsAggregationMethod(aggregation_method))
        self.queue_message_to_send(msg)
