"""A simulator of the fleet: lesson 09's, which also says of which build it is. In C#: FleetSimulator.cs.

    client = EnvironmentClient("tcp://127.0.0.1:5567", timeout=30)
    client.run(FleetSimulator(CartPole(), build="1"))

An episode that was begun elsewhere is played again here, and must go the same way. So the hub takes simulators of one
build only; write another one wherever yours computes differently.
"""

import os
import time

from netmq_example import check
from netmq_example.messages import Message
from netmq_example.simulation.simulation import Simulation
from netmq_example.simulation.simulator import Simulator


class FleetSimulator(Simulator):
    """Trouble on command: it ends instead of one more step than `crash_after`, and takes `delay` seconds for each."""

    def __init__(self, simulation: Simulation, build: str = "1", crash_after: int = 0, delay: float = 0) -> None:
        super().__init__(simulation)
        self.build: str = check.instance("build", build, str)
        self.crash_after = check.count("crash_after", crash_after, least=0)
        self.delay = check.seconds_or_none("delay", delay)

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
