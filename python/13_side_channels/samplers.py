"""Lesson 13, samplers: numbers drawn by chance, the same for the same seed in Python and C#. In C#: Samplers.cs.

Unity's own are drawn by System.Random, so the same seed gives others there, spread in the same way.
"""

import math
import struct
from collections.abc import Callable, Iterator
from itertools import islice

from side_channel import UnitySideChannelException

Sampler = Callable[[], float]


def draws(seed: int) -> Iterator[float]:
    """Numbers from 0 to 1, the same in every language: SplitMix64 (Steele, Lea and Flood, 2014)."""
    mask = 2**64 - 1
    while True:
        seed = seed + 0x9E3779B97F4A7C15 & mask
        bits = (seed ^ seed >> 30) * 0xBF58476D1CE4E5B9 & mask
        bits = (bits ^ bits >> 27) * 0x94D049BB133111EB & mask
        yield ((bits ^ bits >> 31) >> 11) / 2**53


def to_float32(value: float) -> float:
    """Infinity where it is too large, as C# makes of it."""
    try:
        return float(struct.unpack("f", struct.pack("f", value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


def uniform(low: float, high: float, seed: int) -> Sampler:
    check(low, high)
    chance = draws(seed)
    return lambda: to_float32(low + next(chance) * (high - low))


def gaussian(mean: float, st_dev: float, seed: int) -> Sampler:
    """The sum of twelve numbers from 0 to 1 is bell-shaped with deviation 1, and needs no logarithm: those of two
    systems differ in the last bit.
    """
    check(mean, st_dev)
    chance = draws(seed)

    def draw() -> float:
        total = -6.0
        # One by one: sum() of Python 3.12 makes up for what is lost in rounding, and C# does not.
        for number in islice(chance, 12):
            total += number
        return to_float32(mean + st_dev * total)

    return draw


def multi_range_uniform(bounds: list[float], seed: int) -> Sampler:
    """From several intervals, `[low, high, low, high, ...]`: a longer one is hit more often."""
    check(*bounds)
    intervals = list(zip(bounds[::2], bounds[1::2], strict=True)) if len(bounds) % 2 == 0 else []
    if not intervals or any(low > high for low, high in intervals):
        raise UnitySideChannelException("ranges are pairs of a lower and a higher number")
    length = 0.0
    for low, high in intervals:
        length += high - low
    chance = draws(seed)

    def draw() -> float:
        at = next(chance) * length
        for low, high in intervals:
            if at <= high - low:
                break
            at -= high - low
        return to_float32(min(low + at, high))

    return draw


def check(*numbers: float) -> None:
    if not all(map(math.isfinite, numbers)):
        raise UnitySideChannelException("a sampler takes numbers, not NaN or infinity")
