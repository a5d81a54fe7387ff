"""Side channels in the resets and steps of an environment, as ML-Agents has them.

    env = gymnasium.make("NetMQExample/CartPole-v0")
    parameters, stats = EnvironmentParametersChannel(), StatsSideChannel()
    carry(env, SideChannelManager([parameters, stats]))
    parameters.set_float_parameter("gravity", 1.62)
    env.reset()                                                            is a reset that knows of it

What is set before a step is there in that step, and what the simulator records in it comes with its state. The
simulator is in a SideChannelSimulator, of C# or of scene/side_channels.py; records.py says where the exchange
stands. A scene without side channels goes on without them, and one line says so.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from netmq_example import check
from netmq_example.envs.simulators import Simulators
from netmq_example.errors import Lost
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.wire.records import Record

log = logging.getLogger("netmq_example.envs")

CURE = "is the simulator in a SideChannelSimulator?"


def carry(env: Any, manager: SideChannelManager) -> None:
    """From now on the resets and steps of this environment carry these channels; it may be any of this package."""
    env = getattr(env, "unwrapped", env)
    simulators = getattr(env, "simulators", None)
    if not isinstance(simulators, Simulators):
        raise TypeError(f"{type(env).__name__} is not of this package: carry where each environment of it is made")
    check.instance("manager", manager, SideChannelManager)
    if isinstance(getattr(simulators.ask, "__self__", None), StepCarrier):
        raise ValueError(f"{type(env).__name__} carries channels already: give all of them to one manager")
    simulators.ask = StepCarrier(simulators.ask, manager).ask


@dataclass
class StepCarrier:
    """Stands in front of an environment's `ask`."""

    asked: Callable[[Any], Any]
    manager: SideChannelManager
    unsent: bytes = b""
    told: bool = False

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
        if state.exchange is not None:
            self.manager.take_in(state.exchange)
        elif not self.told:
            self.told = True
            log.warning("no-side-channels: the scene has none, and goes on without; %s", CURE)
        return state
