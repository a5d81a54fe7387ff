"""Lesson 17, many machines: simulators come to the hub, and the hub never looks for them.

    python python/17_many_machines/server.py              prints: listening on tcp://127.0.0.1:5567
    dotnet run --project csharp-console -- 17             a simulator; or: python python/17_many_machines/client.py
    python python/17_many_machines/train.py --areas 2     a trainer, which begins when two simulators are there

From other machines, with lesson 15's keys; client.py --endpoint beacon://hub:5567 --keys keys finds it in its network:
    python python/17_many_machines/server.py --endpoint tcp://0.0.0.0:5567 --keys keys --beacon hub

A simulator without work is sent home 15 seconds after the last trainer has left; see --idle.
Bytes: messages of lesson 05; simulators speak as in lesson 09, trainers as in 10: see netmq_example/fleet/hub.py.
Trouble on command: client.py --crash-after 200, --delay 8, --build 2; or Ctrl-Z, or pull the cable.
"""

import sys
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.asking import positive_seconds
from netmq_example.extras import importing
from netmq_example.messages import LIMIT
from netmq_example.program import Context, Socket, listening, run, server_options
from netmq_example.security.allow_list import keys_for

with importing("numpy: pip install numpy, or let kit.py run 17 do it"):
    from netmq_example.fleet.board import Board
    from netmq_example.fleet.hub import Hub

# By kit.py run: with these there are three simulators, one of which dies, and a trainer.
RUN = {"also": ["client.py", "client.py --crash-after 200", "train.py --areas 2 --episodes 100"]}


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5567")
    parser.add_argument("--build", default="1", help="the one that simulators must be of")
    parser.add_argument("--late", type=positive_seconds, default=5, help="seconds until another one is asked as well")
    parser.add_argument("--timeout", type=positive_seconds, default=30, help="seconds an episode waits for a simulator")
    parser.add_argument("--idle", type=positive_seconds, default=15, help="seconds until one without work is sent home")
    parser.add_argument("--keys", metavar="DIR", help="lesson 15's, for the hub and the peers that it lets in")
    options = parser.parse_args()
    # An empty folder, as of a variable that is not set, is a mistake, and opens nothing.
    allowed = None if options.keys is None else keys_for(options.keys)

    def prepare(context: Context, socket: Socket) -> None:
        # A silent peer is asked every 0.5 s whether it is there, and cut off when 2.5 s bring no answer. ZeroMQ answers
        # on a thread of its own: a busy program is not a dead one.
        socket.heartbeat_ivl, socket.heartbeat_timeout = 500, 2500
        # A message may be large, and one that was dropped is sent again.
        socket.sndhwm = 2
        if allowed:
            allowed.answer(context)
            allowed.guard(socket)

    with listening(zmq.ROUTER, options, 4 * LIMIT, prepare) as socket:
        board = Board()
        times = {"late": options.late, "timeout": options.timeout, "idle": options.idle}
        hub = Hub(socket, build=options.build, report=board.report, **times)
        # It waits no longer for a message.
        socket.rcvtimeo = 50
        while True:
            try:
                # Only a frame knows who sent it; bytes are faster.
                message: list[Any] = socket.recv_multipart(0, copy=not allowed)
                # Asked with each message: the handshake of a revoked key may have been long ago.
                if not allowed or allowed.name_of(message[-1]):
                    # A peer says hello or join, or answers a request.
                    hub.take(bytes(message[0]), message[1:])
            except zmq.Again:
                pass
            # A silent peer gets its message again, and an episode without a simulator gets the next free one.
            hub.tick()
            board.show(hub)


if __name__ == "__main__":
    run(main)
