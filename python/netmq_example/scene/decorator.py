"""A simulator around another one, which adds to what that says; in C# it is in SimulatorBase.cs."""

from netmq_example import check
from netmq_example.messages import Message
from netmq_example.scene.simulator import SimulatorBase
from netmq_example.wire.records import Record


class SimulatorDecorator(SimulatorBase):
    """Around any simulator: a class of its own changes the hello, or the resets and steps."""

    def __init__(self, simulator: SimulatorBase) -> None:
        super().__init__(check.instance("simulator", simulator, SimulatorBase).name)
        self.simulator = simulator

    def describe(self) -> Message:
        return self.simulator.describe()

    def say(self, request: Message) -> Message:
        return self.simulator.say(request)

    def do(self, request: Record) -> Record:
        state = self.simulator.do(request)
        self.episodes = self.simulator.episodes
        self.steps = self.simulator.steps
        return state
