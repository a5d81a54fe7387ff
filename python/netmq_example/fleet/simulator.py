"""Lesson 17, the simulator: lesson 09's, which also says of which build it is. In C#: FleetSimulator.cs.

An episode that was begun elsewhere is done again here, and must go the same way. So the hub takes simulators of one
build only; write another one wherever yours computes differently.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import zmq

# In its own lesson's folder; at home they lie beside this file.
sys.path += [
    str(Path(__file__).resolve().parents[1] / name) for name in ("05_messages", "09_environment", "15_security")
]
from netmq_example.fleet.beacon import find
from netmq_example.messages import Message
from netmq_example.security.requester import ClientKeys
from netmq_example.simulation.simulation import Simulation
from netmq_example.simulation.simulator import Simulator


class FleetSimulator(Simulator):
    """Trouble on command: it ends instead of one more step than `crash_after`, and takes `delay` seconds for each."""

    def __init__(self, simulation: Simulation, build: str, crash_after: int = 0, delay: float = 0) -> None:
        super().__init__(simulation)
        self.build, self.crash_after, self.delay = build, crash_after, delay

    def describe(self) -> Message:
        hello = super().describe()
        hello.values["build"] = self.build
        return hello

    def do(self, request: Message) -> Message:
        if request.kind == "step":
            if 0 < self.crash_after <= self.steps:
                print(f"crash after {self.steps} steps, as told", flush=True)
                os._exit(1)
            time.sleep(self.delay)
        return super().do(request)


def way_to_hub(options: argparse.Namespace) -> tuple[str, Callable[[zmq.Socket[bytes]], object] | None]:
    """Its endpoint, which may have to be found, and what gives a socket its keys, if there are any."""
    keys = ClientKeys(Path(options.keys)) if options.keys else None
    place = find(options.find, keys.server if keys else b"", options.timeout) if options.find else options.endpoint
    return place, keys.apply if keys else None
