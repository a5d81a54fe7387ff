"""Side channels in the resets and steps of an environment, as ML-Agents has them.

    env = gymnasium.make("NetMQExample/CartPole-v0")
    parameters, stats = EnvironmentParametersChannel(), StatsSideChannel()
    carry(env, SideChannelManager([parameters, stats]))
    parameters.set_float_parameter("gravity", 1.62)
    env.reset()                                                            is a reset that knows of it

What is set before a step is there in that step, and what the simulator records in it comes with its state. The
simulator is in a SideChannelSimulator, of C# or of simulation/side_channels.py; side_channel/step_messages.py says what
the bytes are.
"""

from collections.abc import Callable
from typing import Any

from netmq_example import check
from netmq_example.envs.connection import Lost
from netmq_example.messages import Array, Message, MessageError
from netmq_example.side_channel import step_messages
from netmq_example.side_channel.side_channel_manager import SideChannelManager

CURE = "is the simulator in a SideChannelSimulator?"


def carry(env: Any, manager: SideChannelManager) -> None:
    """From now on the steps of this environment, of a vector of areas or of one with agents carry these channels."""
    env = getattr(env, "unwrapped", env)
    # ZmqEnv has its simulators itself, the others in a part of them; the part of a vector of areas asks by itself.
    owner = next((part for part in (env, *getattr(env, "__dict__", {}).values()) if hasattr(part, "simulators")), None)
    if not owner:
        raise TypeError(f"{type(env).__name__} is not of lessons 09 to 11: carry where each environment of it is made")
    check.instance("manager", manager, SideChannelManager)
    asking = owner if "ask" in vars(owner) else owner.simulators.connection
    asking.ask = StepCarrier(asking.ask, manager).ask


class StepCarrier:
    """Stands in front of an environment's `ask`."""

    def __init__(self, asked: Callable[..., Message], manager: SideChannelManager) -> None:
        self.asked = check.function("asked", asked)
        self.manager = check.instance("manager", manager, SideChannelManager)
        self.unsent = b""
        # Whether the simulator has answered with side channels before.
        self.known = False

    def ask(self, kind: str, values: dict[str, Any], arrays: list[Array]) -> Message:
        if kind not in ("reset", "step"):
            return self.asked(kind, values, arrays)
        exchange = bytes(self.manager.generate_side_channel_messages(self.unsent))
        self.unsent = b""
        request = Message(kind, values=dict(values), arrays=list(arrays))
        step_messages.add(request, exchange)
        try:
            state = self.asked(kind, request.values, request.arrays)
        except Lost:
            # Nobody knows whether it came. The next simulator is told.
            self.unsent = exchange
            raise
        except MessageError as error:
            # It may have taken the exchange for something of its own.
            raise error if self.known else MessageError(error.code, f"{error.text}; {CURE}") from None
        if not step_messages.deliver(state, self.manager):
            raise MessageError("no-side-channels", CURE)
        self.known = True
        return state
