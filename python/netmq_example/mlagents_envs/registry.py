"""Environments by their names, as in mlagents_envs.registry.

    default_registry.register(LocalRegistryEntry("3DBall", file_name="Builds/3DBall"))
    env = default_registry["3DBall"].make(no_graphics=True)

There are those that you register: ML-Agents' own builds cannot be downloaded any more.
"""

from dataclasses import KW_ONLY, dataclass
from typing import Any

CURE = "register(LocalRegistryEntry(identifier, file_name=path)), of netmq_example.mlagents_envs.registry"


@dataclass
class LocalRegistryEntry:
    """A build on this machine, or a simulator's script. ML-Agents has no such entry: any object with `identifier` and
    `make` is one as well.
    """

    identifier: str
    expected_reward: float | None = None
    description: str | None = None
    _: KW_ONLY
    file_name: str
    additional_args: tuple[str, ...] = ()

    def make(self, **kwargs: Any) -> Any:
        from netmq_example.mlagents_envs.environment import UnityEnvironment

        words = [*(kwargs.pop("additional_args", None) or ()), *self.additional_args]
        return UnityEnvironment(**{**kwargs, "file_name": self.file_name}, additional_args=words)


class UnityEnvRegistry(dict[str, Any]):
    """The entries by their identifiers; of two with the same one the newer stays."""

    def register(self, new_entry: Any) -> None:
        self[new_entry.identifier] = new_entry

    def register_from_yaml(self, path_to_yaml: str) -> None:
        raise NotImplementedError(f"{path_to_yaml} lists builds to download, and this kit downloads none: {CURE}")

    def __missing__(self, identifier: str) -> Any:
        why = "ML-Agents' own builds cannot be downloaded any more"
        raise KeyError(f"no environment {identifier!r} is registered, and {why}: {CURE}")


default_registry = UnityEnvRegistry()
