"""A simulator of the fleet: any of lessons 09 to 11, which also says of which build it is. In C#: FleetSimulator.cs.

    client = EnvironmentClient("tcp://127.0.0.1:5567", timeout=30)
    client.run(FleetSimulator(SceneSimulator(Scene("CartPole", [CartPole()])), build="1"))

An episode that was begun elsewhere is played again here, and must go the same way. So the hub takes simulators of one
build only; write another one wherever yours computes differently.
"""

from netmq_example import check
from netmq_example.messages import Message
from netmq_example.scene.simulator import SimulatorBase, SimulatorDecorator


class FleetSimulator(SimulatorDecorator):
    def __init__(self, simulator: SimulatorBase, *, build: str = "1") -> None:
        super().__init__(simulator)
        self.build: str = check.instance("build", build, str)

    def describe(self) -> Message:
        hello = super().describe()
        hello.values["build"] = self.build
        return hello
