"""Side channels in the resets and steps of an environment, as ML-Agents has them.

    env = gymnasium.make("NetMQExample/CartPole-v0")
    parameters, stats = EnvironmentParametersChannel(), StatsSideChannel()
    carry(env, SideChannelManager([parameters, stats]))
    parameters.set_float_parameter("gravity", 1.62)
    env.reset()                                                            is a reset that knows of it

What is set before a step is there in that step, and what the simulator records in it comes with its state. The
simulator is in a SideChannelSimulator, of C# or of scene/side_channels.py; records.py says where the exchange
stands.
"""

from collections.abc import Callable
from typing import Any

from netmq_example import arguments, check
from netmq_example.errors import Lost
from netmq_example.messages import MessageError
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.wire.records import Record

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
    if isinstance(getattr(asking.ask, "__self__", None), StepCarrier):
        raise ValueError(f"{type(env).__name__} carries channels already: give all of them to one manager")
    asking.ask = StepCarrier(asking.ask, manager).ask


class StepCarrier:
    """Stands in front of an environment's `ask`."""

    def __init__(self, asked: Callable[[Any], Any], manager: SideChannelManager) -> None:
        self.asked = arguments.function("asked", asked)
        self.manager = check.instance("manager", manager, SideChannelManager)
        self.unsent = b""

    def ask(self, request: Any) -> Any:
        if not isinstance(request, Record):
            return self.asked(request)
        request.exchange = bytes(self.manager.generate_side_channel_messages(self.unsent))
        self.unsent = b""
        try:
            state = self.asked(request)
        except Lost:
            # It may have been lost. The next simulator gets it.
            self.unsent = request.exchange
            raise
        if state.exchange is None:
            raise MessageError("no-side-channels", CURE)
        self.manager.take_in(state.exchange)
        return state
