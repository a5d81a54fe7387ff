"""Lesson 13, what the server does with what it hears: prints it, and says that it has seen a round."""

import functools

from netmq_example.mlagents_envs.side_channel import IncomingMessage
from netmq_example.mlagents_envs.side_channel.float_properties_channel import FloatPropertiesChannel
from netmq_example.mlagents_envs.side_channel.stats_side_channel import StatsSideChannel
from netmq_example.trouble import Trouble


class PrintedStats(StatsSideChannel):
    def on_message_received(self, msg: IncomingMessage) -> None:
        super().on_message_received(msg)
        for key, values in self.get_and_reset_stats().items():
            for value, method in values:
                print(f"stats: {key!r:.40} {value:.4f} {method.name.lower()}", flush=True)


class SeenRounds(FloatPropertiesChannel):
    """The simulator sets `round` and hears that this was seen; a `seen` of 0 says only that somebody is here."""

    def __init__(self) -> None:
        super().__init__()
        self.set_property("seen", 0.0)

    def on_message_received(self, msg: IncomingMessage) -> None:
        super().on_message_received(msg)
        self.set_property("seen", self.get_property("round") or 0.0)


report = Trouble(functools.partial(print, flush=True))
