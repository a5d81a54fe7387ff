"""Lesson 13, the client in Python: a simulation with side channels. In C# it is SideChannelRounds.cs.

    python python/13_side_channels/client.py                       draws parameters, and records statistics
    python python/13_side_channels/client.py --trouble unknown     sends to a channel that the server has not
    python python/13_side_channels/client.py --trouble cut         sends a message without its end
    python python/13_side_channels/client.py --trouble throw       has a handler that throws

Bytes: as in server.py.
"""

import contextlib
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq
from rounds import TROUBLES, Rounds

from netmq_example.asking import client_options
from netmq_example.mlagents_envs.carrier import ClientCarrier
from netmq_example.program import run, show, whole


def main() -> None:
    parser = client_options("A simulation with side channels.", "tcp://127.0.0.1:5563", timeout=5)
    parser.add_argument("--count", type=whole, default=5, help="how many rounds")
    parser.add_argument("--trouble", choices=TROUBLES, default="none", help="what goes wrong, and only once")
    options = parser.parse_args()
    print(f"asking {options.endpoint}", flush=True)
    rounds = Rounds(options.count, options.trouble, 2 * options.timeout, show)
    with (
        zmq.Context() as context,
        # It has a DEALER socket, and a new one for each try to connect.
        contextlib.closing(ClientCarrier(context, options.endpoint, options.timeout)) as carrier,
    ):
        data = b""
        # Each side sends at once what it has to say, and waits for no step of the other.
        while not rounds.done:
            received = carrier.exchange(data, wait=0.01)
            data = rounds.exchange(received)
    print(f"done: {options.count} rounds")


if __name__ == "__main__":
    run(main, stopped="stopped")
