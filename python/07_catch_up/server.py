"""Lesson 07, catch up: a snapshot, then the stream; a client that joins late or loses something catches up.

    python python/07_catch_up/server.py   prints: snapshots on tcp://127.0.0.1:5657
                                                  listening on tcp://127.0.0.1:5557
    python python/07_catch_up/client.py   or: dotnet run --project csharp-console -- 7

Bytes: UTF-8 text, one frame. The stream (PUB): `pose/ RUN NUMBER x y z qx qy qz qw`, as in lesson 03; RUN is new with
each start, NUMBER counts its poses from 1. Snapshots (REP): `pose/` is answered with `CHECKSUM` and the last pose
message, anything else with a text that begins with `error:`.
Trouble on command: start a client late; `--interval 0` and a client with `--work 0.001`; stop this server while a
client follows, and start it again.
"""

import contextlib
import math
import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.asking import wrong_usage
from netmq_example.pose_stream import PosePublisher, snapshots_beside
from netmq_example.program import SLICE_MS, Socket, listening, run, seconds, server_endpoint, server_options, whole


def circle(angle: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Your own state goes here: position and rotation on a circle of 2 m, facing forward."""
    return (2 * math.cos(angle), 0, 2 * math.sin(angle)), (0, math.sin(-angle / 2), 0, math.cos(angle / 2))


def serve(stream: Socket, snapshots: Socket, interval: float, count: int) -> None:
    """Publish and answer on one thread, so that a snapshot is always that of a whole message."""
    publisher = PosePublisher()
    due = time.monotonic()
    while True:
        if time.monotonic() >= due:
            stream.send_string(publisher.step(*circle((publisher.number + 1) / 60)))
            # After a long sleep of the machine one second is made up for, not the whole night.
            due = max(due + interval, time.monotonic() - 1)
            if publisher.number == count:
                print(f"published {count}, checksum {publisher.checksum}", flush=True)
                due = math.inf
        if snapshots.poll(math.ceil(min(SLICE_MS, max(0, 1000 * (due - time.monotonic()))))):
            # The request that poll saw may be a broken one, which the socket drops: then there is none after all.
            with contextlib.suppress(zmq.Again):
                snapshots.send_string(answer(snapshots.recv_multipart(zmq.NOBLOCK), publisher))


def answer(request: list[bytes], publisher: PosePublisher) -> str:
    """The state as it is now: a subscriber that has it goes on with the next message of the stream."""
    if request != [b"pose/"]:
        return f"error: expected pose/, got {b' '.join(request)[:40]!r}"
    return publisher.snapshot()


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5557")
    parser.add_argument("--snapshots", type=server_endpoint("tcp://127.0.0.1:5657"), help="default: port 100 higher")
    parser.add_argument("--interval", type=seconds, default=1 / 60, help="seconds between two poses; 0 is a flood")
    parser.add_argument("--count", type=whole, default=0, help="poses to publish, after that only snapshots; 0: no end")
    options = parser.parse_args()
    with wrong_usage(parser, after="; give --snapshots"):
        second = options.snapshots or snapshots_beside(options.endpoint)
    with (
        # Listeners send subscriptions only, and those are short.
        listening(zmq.PUB, options, largest=1000, word="") as stream,
        listening(zmq.REP, options, endpoint=second, word="snapshots") as snapshots,
    ):
        # Not before both do.
        print(f"listening on {stream.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(stream, snapshots, options.interval, options.count)


if __name__ == "__main__":
    run(main)
