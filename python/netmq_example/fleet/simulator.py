"""A simulator of the fleet: any of lessons 09 and 11, which also says of which build it is. In C#: FleetSimulator.cs.

    client = EnvironmentClient("tcp://127.0.0.1:5567", timeout=30)
    client.run(FleetSimulator(Simulator(CartPole()), build="1"))

An episode that was begun elsewhere is played again here, and must go the same way. So the hub takes simulators of one
build only; write another one wherever yours computes differently.
"""

import os
import time

from netmq_example import check
from netmq_example.messages import Message
from netmq_example.records import STEP, Record
from netmq_example.simulation.simulator import SimulatorBase


class FleetSimulator(SimulatorBase):
    """Trouble on command: it ends instead of one more step than `crash_after`, and takes `delay` seconds for each."""

    def __init__(self, simulator: SimulatorBase, build: str = "1", crash_after: int = 0, delay: float = 0) -> None:
        super().__init__(check.instance("simulator", simulator, SimulatorBase).name)
        self.simulator = simulator
        self.build: str = check.instance("build", build, str)
        self.crash_after = check.count("crash_after", crash_after, least=0)
        self.delay = check.seconds_or_none("delay", delay)

    def describe(self) -> Message:
        hello = self.simulator.describe()
        hello.values["build"] = self.build
        return hello

    def say(self, request: Message) -> Message:
        return self.simulator.say(request)

    def do(self, request: Record) -> Record:
        if STEP in request.marks:
            if 0 < self.crash_after <= self.steps:
                print(f"crash after {self.steps} steps, as told", flush=True)
                os._exit(1)
            time.sleep(self.delay)
        state = self.simulator.do(request)
        self.episodes = self.simulator.episodes
        self.steps = self.simulator.steps
        return state
