"""Lesson 07, the client in Python: runs PoseSubscriber of pose_subscriber.py, and prints the lines of the C# twin.

    python python/07_catch_up/client.py                    follow 300 poses, and notice each one missed
    python python/07_catch_up/client.py --work 0.001       a slow one: give the server --interval 0
    python python/07_catch_up/client.py --until 1000       end at the pose of this number

Bytes: as in server.py. To copy: pose_subscriber.py.
"""

import argparse
import re
import sys
import time
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.pose_stream import PoseSubscriber

ENDPOINT = "tcp://127.0.0.1:5557"


def follow(subscriber: PoseSubscriber, options: argparse.Namespace) -> None:
    end = time.monotonic() + options.seconds
    run, number = "", 0
    while subscriber.received < options.count and time.monotonic() < end:
        news = subscriber.receive(options.timeout)
        run, number, position, _ = subscriber.pose
        if news and options.every and subscriber.received % options.every == 0:
            print(f"{number}: at", *(f"{value:.4f}" for value in position), flush=True)
        if number >= options.until > 0:
            break
        time.sleep(options.work)
    print(
        f"done: received {subscriber.received}, missed {subscriber.missed}; "
        f"run {run} at {number}, checksum {subscriber.checksum}"
    )


# From here on all clients of this kit are the same, but for their own options.


def endpoint(text: str) -> str:
    """libzmq itself takes port 99999 and an unknown host without a word, and waits."""
    parts = re.fullmatch(r"tcp://([\w.-]+):(\d{1,5})", text, re.ASCII)
    if not parts or not 0 < int(parts[2]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': unknown host '{parts[1]}'; check it") from None
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Follows a pose, and knows of each one it missed.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the publisher")
    parser.add_argument("--snapshots", type=endpoint, help="where it gives them; if left out, the port 100 higher")
    parser.add_argument("--count", type=int, default=300, help="end after so many poses")
    parser.add_argument("--until", type=int, default=0, help="or at the pose of this number; 0: at none")
    parser.add_argument("--seconds", type=float, default=60, help="or after this time")
    parser.add_argument("--every", type=int, default=60, help="print one pose in so many; 0: none")
    parser.add_argument("--timeout", type=float, default=5, help="seconds to wait for a snapshot")
    parser.add_argument("--work", type=float, default=0, help="seconds that each pose takes: a slow subscriber")
    options = parser.parse_args()
    if not all(0 <= value < 2**31 for value in vars(options).values() if isinstance(value, int | float)):
        parser.error("--count, --until, --seconds, --every, --timeout and --work take numbers from 0 on")
    host, port = options.endpoint.rsplit(":", 1)
    snapshots = options.snapshots or f"{host}:{int(port) + 100}"
    if int(port) + 100 > 65535 and not options.snapshots:
        parser.error(f"bad endpoint '{snapshots}': port 1 to 65535; say where the --snapshots are")
    print(f"following {options.endpoint}, snapshots from {snapshots}", flush=True)
    with zmq.Context() as context, context.socket(zmq.SUB) as stream:
        # A peer that announces more than the largest message is disconnected before it is in memory.
        stream.linger, stream.maxmsgsize = 0, 65_536
        try:
            follow(PoseSubscriber(stream, options.endpoint, snapshots, print), options)
        except TimeoutError as error:
            sys.exit(f"gave up: {error}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
