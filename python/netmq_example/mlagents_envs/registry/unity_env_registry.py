"""UnityEnvRegistry and default_registry, as in mlagents_envs.registry.unity_env_registry. Nothing is downloaded."""

from collections.abc import Iterator, Mapping

from netmq_example.mlagents_envs.registry.base_registry_entry import BaseRegistryEntry

__all__ = ["UnityEnvRegistry", "default_registry"]

CURE = "register(LocalRegistryEntry(identifier, file_name=path)), of netmq_example.mlagents_envs.registry"


class UnityEnvRegistry(Mapping[str, BaseRegistryEntry]):
    """The entries by their identifiers; of two with the same one the newer stays."""

    def __init__(self) -> None:
        self.entries: dict[str, BaseRegistryEntry] = {}

    def register(self, new_entry: BaseRegistryEntry) -> None:
        self.entries[new_entry.identifier] = new_entry

    def register_from_yaml(self, path_to_yaml: str) -> None:
        raise NotImplementedError(f"{path_to_yaml} lists builds to download, and this kit downloads none: {CURE}")

    def clear(self) -> None:
        self.entries.clear()

    def __getitem__(self, identifier: str) -> BaseRegistryEntry:
        if identifier not in self.entries:
            why = "ML-Agents' own builds cannot be downloaded any more"
            raise KeyError(f"no environment {identifier!r} is registered, and {why}: {CURE}")
        return self.entries[identifier]

    def __len__(self) -> int:
        return len(self.entries)

    def __iter__(self) -> Iterator[str]:
        return iter(self.entries)


default_registry = UnityEnvRegistry()
