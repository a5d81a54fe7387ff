"""Simulators on many machines, trainers, and the hub between them. Simulators and trainers need gymnasium."""

from typing import TYPE_CHECKING

from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.fleet.hub import Hub
    from netmq_example.fleet.simulator import FleetSimulator
    from netmq_example.fleet.trainer import FleetSocket

__all__ = ["FleetSimulator", "FleetSocket", "Hub"]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {"hub": "Hub", "simulator": "FleetSimulator", "trainer": "FleetSocket"}
    __getattr__, __dir__ = door(__name__, ROOMS)
