"""Lesson 17, many machines: simulators come to the hub, and the hub never looks for them.

    python python/17_many_machines/server.py              prints: listening on tcp://127.0.0.1:5567
    dotnet run --project csharp-console -- 17             a simulator; or: python python/17_many_machines/client.py
    python python/17_many_machines/train.py --areas 2     a trainer, which begins when two simulators are there

From other machines, with lesson 15's keys; client.py --find 5567 --keys keys finds it in its network:
    python python/17_many_machines/server.py --endpoint tcp://0.0.0.0:5567 --keys keys --announce 255.255.255.255:5567

A simulator without work is sent home 15 seconds after the last trainer has left; see --idle.
Bytes: messages of lesson 05; simulators speak as in lesson 09, trainers as in 10: see hub.py.
Trouble on command: client.py --crash-after 200, --delay 8, --build 2; or Ctrl-Z, or pull the cable.
What kit.py run starts as well, so that there are three simulators, one of which dies:
    Also started: client.py
    Also started: client.py --crash-after 200
    Also started: train.py --areas 2 --episodes 100
"""

import argparse
import contextlib
import re
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq
from hub_options import keys_for, place, receive, seconds

from netmq_example.fleet.beacon import Beacon
from netmq_example.fleet.board import Board
from netmq_example.fleet.hub import Hub, tick
from netmq_example.messages import LIMIT

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5567", zmq.ROUTER, 4 * LIMIT


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    board, allowed = Board(), options.allowed
    hub, where = Hub(socket, options, board.say), socket.getsockopt_string(zmq.LAST_ENDPOINT)
    beacon = Beacon(options.announce, where, allowed.public if allowed else b"")
    while True:
        if socket.poll(50):
            peer, frames = receive(socket, allowed)
            if frames:
                hub.take(peer, frames)
        tick(hub)
        board.show(hub)
        beacon.tell()


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--build", default="1", help="the one that simulators must be of")
    parser.add_argument("--late", type=seconds, default=5, help="seconds until an answer is asked for elsewhere, too")
    parser.add_argument("--timeout", type=seconds, default=30, help="seconds that an episode waits for a simulator")
    parser.add_argument("--idle", type=seconds, default=15, help="seconds until one without work is sent home")
    parser.add_argument("--announce", type=place, metavar="IP:PORT", help="where to tell of it by UDP")
    parser.add_argument("--keys", metavar="DIR", help="lesson 15's, for the hub and whom it lets in")


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
        # A silent peer is asked every 0.5 s whether it is there, and cut off when 2.5 s bring no answer. Both engines
        # answer on a thread of their own: a busy program is not a dead one. To send to a peer that is gone is an error.
        socket.heartbeat_ivl, socket.heartbeat_timeout, socket.router_mandatory = 500, 2500, True
        options.allowed = keys_for(context, socket, options.keys)
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
