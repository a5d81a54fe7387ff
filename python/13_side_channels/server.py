"""Lesson 13, side channels: many small conversations share one exchange, and none knows the others.

    python python/13_side_channels/server.py        prints: listening on tcp://127.0.0.1:5563
    python python/13_side_channels/client.py        or: dotnet run --project csharp-console -- 13

Bytes: an exchange is one frame, as ML-Agents packs its side channels: side_channel_manager.py has the layout. A
simulator says "I am here" with an empty one, and is told the settings and parameters of `welcome`.
Trouble on command, by a client: `--trouble unknown`, `--trouble cut`, `--trouble throw`.
"""

import argparse
import contextlib
import re
import signal
import sys
import uuid
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq
from trainer import PrintedStats, SeenRounds, report

from netmq_example.side_channel.carrier import Carrier
from netmq_example.side_channel.engine_configuration_channel import EngineConfigurationChannel
from netmq_example.side_channel.environment_parameters_channel import EnvironmentParametersChannel
from netmq_example.side_channel.side_channel import LARGEST_EXCHANGE, IncomingMessage, OutgoingMessage, SideChannel
from netmq_example.side_channel.side_channel_manager import SideChannelManager

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5563", zmq.ROUTER, LARGEST_EXCHANGE


class StringLogChannel(SideChannel):
    """A conversation of your own: lines for Unity's log, and Unity's errors for this one."""

    def __init__(self) -> None:
        super().__init__(uuid.UUID("621f0a70-4f87-11ea-a6bf-784f4387d1f7"))

    def on_message_received(self, msg: IncomingMessage) -> None:
        print(f"From Unity : {msg.read_string()!r:.200}", flush=True)

    def send_string(self, data: str) -> None:
        msg = OutgoingMessage()
        msg.write_string(data)
        self.queue_message_to_send(msg)


def welcome() -> SideChannelManager:
    """The channels for a simulator that has just come, and what is said to it at once."""
    log, engine, parameters = StringLogChannel(), EngineConfigurationChannel(), EnvironmentParametersChannel()
    log.send_string("Hello")
    engine.set_configuration_parameters(time_scale=2.0, target_frame_rate=60)
    parameters.set_float_parameter("gravity", 9.81)
    parameters.set_uniform_sampler_parameters("mass", 0.5, 2.5, seed=1)
    parameters.set_gaussian_sampler_parameters("wind", 0.0, 3.0, seed=2)
    parameters.set_multirangeuniform_sampler_parameters("light", [(0.1, 0.3), (0.7, 1.0)], seed=3)
    return SideChannelManager([log, engine, parameters, PrintedStats(), SeenRounds()], report)


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    Carrier(socket, welcome, report).serve()


def add_options(parser: argparse.ArgumentParser) -> None:
    """There are none."""


# From here on all servers of this kit are the same, as far as they need it.


def endpoint(text: str) -> str:
    """libzmq itself would listen on port 99999 - 65536, and for everybody, without a word."""
    port = re.fullmatch(r"tcp://[\w.*-]+:(\*|\d{1,5})", text, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 0 to 65535")
    # Options are read one after the other, and this one may come first.
    told = any(word.startswith(("--keys", "--open-to-anyone")) for word in sys.argv)
    if not told and not re.match(r"tcp://(localhost|127\.[\d.]+):", text):
        raise argparse.ArgumentTypeError(f"'{text}' lets anyone in: lesson 15 has keys, --open-to-anyone has none")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="port 0 takes a free one")
    parser.add_argument("--open-to-anyone", action="store_true", help="also from other machines, without keys")
    add_options(parser)
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does; on Windows that is SIGBREAK.
    signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
    with zmq.Context() as context, context.socket(SOCKET) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        # Who announces more than the largest message is disconnected before it is in memory.
        socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, LARGEST, 200
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            cure = "try --endpoint tcp://127.0.0.1:0, which takes a free port"
            sys.exit(f"cannot listen on {options.endpoint}: {zmq.strerror(error.errno or 0)}; {cure}")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
