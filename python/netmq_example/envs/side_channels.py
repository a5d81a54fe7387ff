"""Lesson 13 on lesson 09's steps: one exchange each way in every reset and step, as ML-Agents has it.

    env = gymnasium.make("NetMQExample/CartPole-v0")
    carry(env, SideChannelManager([parameters, stats]))
    parameters.set_float_parameter("gravity", 1.62)
    env.reset()                                                            is a reset that knows of it
    client.run(SideChannelSimulator(Simulator(world), manager))            in the simulator, if that is in Python

So what is set before a step is there in that step, and what the simulator records in it comes with its state.
Bytes: lesson 09's, with the value side_channel, true, and the exchange as one more array, the last one, uint8. The C#
side is SideChannelSimulator.cs.
falling_ball.py has both sides in one file.
They need gymnasium.
"""

from collections.abc import Callable
from typing import Any

from netmq_example.envs.connection import Lost
from netmq_example.messages import Array, Message, MessageError
from netmq_example.side_channel.side_channel import UnitySideChannelException
from netmq_example.side_channel.side_channel_manager import SideChannelManager
from netmq_example.simulation.simulator import SimulatorBase

CURE = "is the simulator in a SideChannelSimulator?"


def carry(env: Any, manager: SideChannelManager) -> None:
    """From now on the steps of this environment of lesson 09, 10 or 11 carry these channels."""
    env = env.unwrapped
    # Lesson 09's environment has its simulators itself, the others in a part of it; lesson 10's part asks by itself.
    owner = next((part for part in (env, *vars(env).values()) if hasattr(part, "simulators")), None)
    if not owner:
        raise TypeError(f"{type(env).__name__} is not of lessons 09 to 11: carry where each environment of it is made")
    asking = owner if "ask" in vars(owner) else owner.simulators.connection
    asking.ask = StepCarrier(asking.ask, manager).ask


def receive(manager: SideChannelManager, message: Message) -> bool:
    """Take an exchange out of a message and deliver it. False if there is none."""
    if message.values.pop("side_channel", False) is not True or not message.arrays:
        return False
    try:
        manager.process_side_channel_message(bytes(message.arrays.pop().data))
    except UnitySideChannelException as error:
        manager.report(str(error))
    return True


class StepCarrier:
    """Stands in front of an environment's `ask`."""

    def __init__(self, asked: Callable[..., Message], manager: SideChannelManager) -> None:
        self.asked, self.manager, self.unsent, self.known = asked, manager, b"", False

    def ask(self, kind: str, values: dict[str, Any], arrays: list[Array]) -> Message:
        if kind not in ("reset", "step"):
            return self.asked(kind, values, arrays)
        data, self.unsent = bytes(self.manager.generate_side_channel_messages(self.unsent)), b""
        exchange = Array("uint8", (len(data),), data)
        try:
            state = self.asked(kind, values | {"side_channel": True}, [*arrays, exchange])
        except Lost:
            # Nobody knows whether it came. The next simulator is told.
            self.unsent = data
            raise
        except MessageError as error:
            # It may have taken the exchange for something of its own.
            raise error if self.known else MessageError(error.code, f"{error.text}; {CURE}") from None
        if not receive(self.manager, state):
            raise MessageError("no-side-channels", CURE)
        self.known = True
        return state


class SideChannelSimulator(SimulatorBase):
    """Around a simulator, whose requests and answers then carry side channels."""

    def __init__(self, simulator: SimulatorBase, manager: SideChannelManager) -> None:
        super().__init__(simulator.name)
        self.simulator, self.manager = simulator, manager

    def describe(self) -> Message:
        return self.simulator.describe()

    def do(self, request: Message) -> Message:
        carried = receive(self.manager, request)
        state = self.simulator.do(request)
        self.episodes, self.steps = self.simulator.episodes, self.simulator.steps
        if carried:
            data = bytes(self.manager.generate_side_channel_messages())
            state.values["side_channel"] = True
            state.arrays.append(Array("uint8", (len(data),), data))
        return state
