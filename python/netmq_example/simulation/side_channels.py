"""A simulator whose resets and steps carry side channels; in C# it is SideChannelSimulator.cs.

    parameters, stats = EnvironmentParameters(), StatsRecorder()
    simulator = SideChannelSimulator(Simulator(world), SideChannelManager([parameters, stats]))
    EnvironmentClient(endpoint, timeout=20).run(simulator)

What the training sets before a step is there in that step, and what the world records in it comes with its state.
envs/side_channels.py is the training's end, and side_channel/step_messages.py says what the bytes are.
"""

from netmq_example import check
from netmq_example.messages import Message
from netmq_example.side_channel import step_messages
from netmq_example.side_channel.side_channel_manager import SideChannelManager
from netmq_example.simulation.simulator import SimulatorBase


class SideChannelSimulator(SimulatorBase):
    """Around any simulator."""

    def __init__(self, simulator: SimulatorBase, manager: SideChannelManager) -> None:
        super().__init__(check.instance("simulator", simulator, SimulatorBase).name)
        self.simulator = simulator
        self.manager = check.instance("manager", manager, SideChannelManager)

    def describe(self) -> Message:
        return self.simulator.describe()

    def do(self, request: Message) -> Message:
        carried = step_messages.deliver(request, self.manager)
        state = self.simulator.do(request)
        self.episodes = self.simulator.episodes
        self.steps = self.simulator.steps
        if carried:
            step_messages.add(state, bytes(self.manager.generate_side_channel_messages()))
        return state
