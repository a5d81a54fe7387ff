"""Lesson 03, publish-subscribe: one speaks, many listen; only the newest counts.

    python python/03_publish_subscribe/server.py   prints: listening on tcp://127.0.0.1:5553
    python python/03_publish_subscribe/client.py   or: dotnet run --project csharp-console -- 3

Bytes: UTF-8 text, one frame, which begins with its topic. `pose/ NUMBER x y z qx qy qz qw`: where a cube is, in Unity's
metres and axes, with a decimal point; NUMBER counts from 1. `news/ TEXT` and `newsflash/ TEXT` now and then.
Trouble on command: `--interval 0` publishes faster than a client with `--work 0.001` listens.
"""

import itertools
import math
import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.program import encoded, listening, run, seconds, server_options

# Listeners send nothing but subscriptions, and those are short.
LARGEST_BYTES = 1000


def pose(steps: int) -> str:
    """Your own state goes here: this is a place on a circle of 2 m, one radian in 60 steps, facing forward."""
    angle = steps / 60
    place = (2 * math.cos(angle), 0, 2 * math.sin(angle), 0, math.sin(-angle / 2), 0, math.cos(angle / 2))
    return f"pose/ {steps} " + " ".join(f"{value:.4f}" for value in place)


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5553")
    parser.add_argument("--interval", type=seconds, default=1 / 60, help="seconds between two poses; 0 is a flood")
    options = parser.parse_args()
    with listening(zmq.PUB, options, LARGEST_BYTES) as socket:
        for steps in itertools.count(1):
            # Sending never waits. A listener that is late or too slow misses the message, and nobody notices.
            socket.send(encoded(pose(steps)))
            if steps % 60 == 0:
                socket.send_string(f"news/ the cube has made {steps} steps")
            if steps % 180 == 0:
                socket.send_string(f"newsflash/ it has made {steps} already")
            # Your own topic goes here.
            if options.interval:
                time.sleep(options.interval)


if __name__ == "__main__":
    run(main)
