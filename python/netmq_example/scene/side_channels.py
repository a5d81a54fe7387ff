"""A simulator whose resets and steps carry side channels; in C# it is SideChannelSimulator.cs.

    parameters, stats = EnvironmentParameters(), StatsRecorder()
    simulator = SideChannelSimulator(SceneSimulator(scene), SideChannelManager([parameters, stats]))
    EnvironmentClient(endpoint, timeout=20).run(simulator)

What the training sets before a step is there in that step, and what the world records in it comes with its state.
envs/side_channels.py is the training's end, and records.py says where the exchange stands.
"""

from netmq_example import check
from netmq_example.messages import Message
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.scene.simulator import SimulatorBase, SimulatorDecorator
from netmq_example.wire.records import Record


class SideChannelSimulator(SimulatorDecorator):
    def __init__(self, simulator: SimulatorBase, manager: SideChannelManager) -> None:
        super().__init__(simulator)
        self.manager = check.instance("manager", manager, SideChannelManager)

    def describe(self) -> Message:
        hello = super().describe()
        hello.values["channels"] = True
        return hello

    def do(self, request: Record) -> Record:
        if request.exchange is not None:
            self.manager.take_in(request.exchange)
        state = super().do(request)
        if request.exchange is not None:
            state.exchange = bytes(self.manager.generate_side_channel_messages())
        return state
