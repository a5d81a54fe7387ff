"""Lesson 13, side channels: many small conversations share one exchange, and none knows the others.

    python python/13_side_channels/server.py        prints: listening on tcp://127.0.0.1:5563
    python python/13_side_channels/client.py        or: dotnet run --project csharp-console -- 13

Bytes: an exchange is one frame, as ML-Agents packs its side channels: side_channel_manager.py has the layout. A
simulator says "I am here" with an empty one, and is sent the settings and parameters of `welcome`.
Trouble on command, by a client: `--trouble unknown`, `--trouble cut`, `--trouble throw`.
"""

import sys
import uuid
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq
from trainer import PrintedStats, SeenRounds, report

from netmq_example.mlagents_envs.carrier import Carrier
from netmq_example.mlagents_envs.side_channel import IncomingMessage, OutgoingMessage, SideChannel
from netmq_example.mlagents_envs.side_channel.engine_configuration_channel import EngineConfigurationChannel
from netmq_example.mlagents_envs.side_channel.environment_parameters_channel import EnvironmentParametersChannel
from netmq_example.mlagents_envs.side_channel.side_channel import LARGEST_EXCHANGE_BYTES
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.program import listening, run, server_options


class StringLogChannel(SideChannel):
    """A channel of your own: lines for Unity's log, and Unity's errors for this one."""

    def __init__(self) -> None:
        super().__init__(uuid.UUID("621f0a70-4f87-11ea-a6bf-784f4387d1f7"))

    def on_message_received(self, msg: IncomingMessage) -> None:
        print(f"From Unity : {msg.read_string()!r:.200}", flush=True)

    def send_string(self, data: str) -> None:
        msg = OutgoingMessage()
        msg.write_string(data)
        self.queue_message_to_send(msg)


def welcome() -> SideChannelManager:
    """The channels for a simulator that has just come, and what it is sent at once."""
    log, engine, parameters = StringLogChannel(), EngineConfigurationChannel(), EnvironmentParametersChannel()
    log.send_string("Hello")
    engine.set_configuration_parameters(time_scale=2.0, target_frame_rate=60)
    parameters.set_float_parameter("gravity", 9.81)
    parameters.set_uniform_sampler_parameters("mass", 0.5, 2.5, seed=1)
    parameters.set_gaussian_sampler_parameters("wind", 0.0, 3.0, seed=2)
    parameters.set_multirangeuniform_sampler_parameters("light", [(0.1, 0.3), (0.7, 1.0)], seed=3)
    return SideChannelManager([log, engine, parameters, PrintedStats(), SeenRounds()], report)


def main() -> None:
    options = server_options(__doc__, "tcp://127.0.0.1:5563").parse_args()
    with listening(zmq.ROUTER, options, LARGEST_EXCHANGE_BYTES) as socket:
        carrier = Carrier(socket, welcome, report)
        while True:
            # Takes what has come to its channels, and sends what channels have queued.
            carrier.exchange()


if __name__ == "__main__":
    run(main)
