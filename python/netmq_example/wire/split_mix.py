"""SplitMix64: numbers drawn by chance, the same in every language for the same seed.

    rng = draws(7)
    rng()                    0.3898297483912715, at least 0 and less than 1; next(rng) is the same

The generator is that of Steele, Lea and Flood, *Fast splittable pseudorandom number generators*, 2014; a number is the
upper 53 bits of what it gives. In C# it is RandomGenerator. It needs only Python.
"""

from collections.abc import Iterator

from netmq_example import check

MASK = 2**64 - 1


class Draws(Iterator[float]):
    """Numbers without an end."""

    def __init__(self, state: int) -> None:
        self.state = state

    def __next__(self) -> float:
        self.state = (self.state + 0x9E3779B97F4A7C15) & MASK
        bits = ((self.state ^ (self.state >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        bits = ((bits ^ (bits >> 27)) * 0x94D049BB133111EB) & MASK
        return ((bits ^ (bits >> 31)) >> 11) / 2**53

    __call__ = __next__


def draws(seed: int) -> Draws:
    """Those of a seed. A negative one is taken as the 64 bits that C# has for it."""
    return Draws(check.count("seed", seed, least=-(2**63), most=MASK))
