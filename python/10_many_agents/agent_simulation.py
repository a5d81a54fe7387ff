"""Lesson 10, a world of several agents, and nothing else: no network and no clock. In C#: AgentSimulation.cs.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any

from gymnasium.spaces import Space
from infos import InfoQueue


class AgentSimulation(ABC):
    """Your own game derives from it. `agents` are their names with what each sees and what it does."""

    name: str
    dt: float
    agents: dict[str, tuple[Space[Any], Space[Any]]]

    def __init__(self) -> None:
        self.infos = InfoQueue()

    @abstractmethod
    def reset(self, chance: Iterator[float], options: dict[str, Any]) -> None:
        """Begin an episode, in which all agents live."""

    @abstractmethod
    def apply(self, actions: dict[str, Any]) -> None:
        """Do what the agents that live want, for `dt` seconds."""

    @abstractmethod
    def observe(self, agent: str) -> Any:
        """What it sees now."""

    @abstractmethod
    def judge(self, agent: str) -> dict[str, Any]:
        """The values reward, terminated and truncated, and any others for its info."""

    def on_info(self, agent: str, info: dict[str, Any]) -> None:  # noqa: B027, whoever wants to hear overrides it.
        """Python has said something to an agent, or to the environment: ""."""

    def render(self) -> Any:
        """A picture, uint8 [height, width, 3], the highest row first."""
        raise NotImplementedError(f"{self.name} draws no pictures")
