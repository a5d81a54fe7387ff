"""The entries of a registry, as in mlagents_envs.registry.base_registry_entry, and one for a build of your own."""

from dataclasses import dataclass, field
from typing import Any

__all__ = ["BaseRegistryEntry", "LocalRegistryEntry"]


@dataclass
class BaseRegistryEntry:
    """Derive from it and write `make`."""

    identifier: str
    expected_reward: float | None = None
    description: str | None = None

    def make(self, **kwargs: Any) -> Any:
        """A UnityEnvironment."""
        raise NotImplementedError(f"{type(self).__name__} of {self.identifier!r} has no make")


@dataclass
class LocalRegistryEntry(BaseRegistryEntry):
    """A build on this machine, or a simulator's script. ML-Agents has no such entry."""

    file_name: str = field(kw_only=True)
    additional_args: list[str] = field(default_factory=list, kw_only=True)

    def make(self, **kwargs: Any) -> Any:
        """A UnityEnvironment by these words, but for file_name."""
        from netmq_example.mlagents_envs.environment import UnityEnvironment

        words = [*(kwargs.pop("additional_args", None) or ()), *self.additional_args]
        return UnityEnvironment(**{**kwargs, "file_name": self.file_name}, additional_args=words)
