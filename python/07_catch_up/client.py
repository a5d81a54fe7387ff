"""Lesson 07, the client in Python. In C# it is CatchUpFollower.cs, which prints the same lines.

    python python/07_catch_up/client.py                    follow 300 poses, and notice each one missed
    python python/07_catch_up/client.py --work 0.001       a slow one: give the server --interval 0
    python python/07_catch_up/client.py --until 1000       end at the pose of this number

Bytes: as in server.py.
"""

import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_endpoint, client_options, wrong_usage
from netmq_example.pose_stream import PoseSubscriber
from netmq_example.program import run, seconds, whole


def main() -> None:
    parser = client_options("Follows a pose, and knows of each one it missed.", "tcp://127.0.0.1:5557", timeout=5)
    parser.add_argument("--snapshots", type=client_endpoint("tcp://127.0.0.1:5657"), help="default: port 100 higher")
    parser.add_argument("--count", type=whole, default=300, help="end after so many poses")
    parser.add_argument("--until", type=whole, default=0, help="or at the pose of this number; 0: at none")
    parser.add_argument("--seconds", type=seconds, default=60, help="or after this time")
    parser.add_argument("--every", type=whole, default=60, help="print one pose in so many; 0: none")
    parser.add_argument("--work", type=seconds, default=0, help="seconds that each pose takes: a slow subscriber")
    options = parser.parse_args()
    with wrong_usage(parser, after="; give --snapshots"):
        poses = PoseSubscriber(options.endpoint, snapshots=options.snapshots or "", timeout=options.timeout)
    with poses:
        print(f"following {options.endpoint}, snapshots from {poses.snapshots}", flush=True)
        end = time.monotonic() + options.seconds
        while poses.received < options.count and time.monotonic() < end:
            # The next pose of the stream. After one that is missing, a snapshot.
            news = poses.receive()
            if news and options.every and poses.received % options.every == 0:
                print(f"{poses.pose.number}: at", *(f"{value:.4f}" for value in poses.pose.position), flush=True)
            if 0 < options.until <= poses.pose.number:
                break
            time.sleep(options.work)
    pose = poses.pose
    done = f"received {poses.received}, missed {poses.missed}; run {pose.run} at {pose.number}"
    print(f"done: {done}, checksum {poses.checksum}")


if __name__ == "__main__":
    run(main, stopped="stopped")
