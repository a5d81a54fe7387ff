"""Lesson 09, a simulation: what a world needs, so that an environment can be made of it. In C#: Simulation.cs.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any

from gymnasium.spaces import Space


class Simulation(ABC):
    """Your own derives from it. `dt` is how many seconds one step takes, `size` how many numbers its state has."""

    name: str
    dt: float
    size: int
    observation: Space[Any]
    action: Space[Any]

    @abstractmethod
    def reset(self, chance: Iterator[float], options: dict[str, Any], state: list[float]) -> None:
        """Begin an episode: by chance, or in a state if one is given: `size` numbers."""

    @abstractmethod
    def apply(self, action: Any) -> None:
        """Do it, for `dt` seconds."""

    @abstractmethod
    def observe(self) -> Any:
        """What is seen now: something of the space `observation`."""

    @abstractmethod
    def judge(self) -> dict[str, Any]:
        """The values reward, terminated and truncated, and any others for `info`."""

    def render(self) -> Any:
        """A picture, uint8 [height, width, 3], the highest row first."""
        raise NotImplementedError(f"{self.name} draws no pictures")


def draws(seed: int) -> Iterator[float]:
    """Numbers from 0 to 1, the same in every language: SplitMix64 (Steele, Lea and Flood, 2014)."""
    mask = 2**64 - 1
    while True:
        seed = seed + 0x9E3779B97F4A7C15 & mask
        bits = (seed ^ seed >> 30) * 0xBF58476D1CE4E5B9 & mask
        bits = (bits ^ bits >> 27) * 0x94D049BB133111EB & mask
        yield ((bits ^ bits >> 31) >> 11) / 2**53
