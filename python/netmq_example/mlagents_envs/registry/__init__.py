"""Environments by their names, as in mlagents_envs.registry.

    default_registry.register(LocalRegistryEntry("3DBall", file_name="Builds/3DBall"))
    env = default_registry["3DBall"].make(no_graphics=True)

There are those that you register: ML-Agents' own builds cannot be downloaded any more.
"""

from netmq_example.mlagents_envs.registry.base_registry_entry import BaseRegistryEntry, LocalRegistryEntry
from netmq_example.mlagents_envs.registry.unity_env_registry import UnityEnvRegistry, default_registry

__all__ = ["BaseRegistryEntry", "LocalRegistryEntry", "UnityEnvRegistry", "default_registry"]
