"""Lesson 08, the client in Python: the terminal twin of CameraSender.cs, and it prints the same lines.

    python python/08_see_and_steer/client.py                 500 actions: ten seconds on the road
    python python/08_see_and_steer/client.py --lockstep      the world waits for each action
    python python/08_see_and_steer/client.py --drive         arrow keys take over, Enter gives back
    python python/08_see_and_steer/client.py --jpeg          JPEG files; needs Pillow

Bytes: as in server.py.
"""

import argparse
import re
import sys
import time
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq
from drive import Drive
from keyboard import Keyboard

from netmq_example.camera.client import DriverClient, GaveUp
from netmq_example.worlds.road_car import CAMERAS, STEP, DrawnCamera, Road

ENDPOINT = "tcp://127.0.0.1:5558"


def see_and_steer(drive: Drive, client: DriverClient, keyboard: Keyboard, options: argparse.Namespace) -> int:
    """Until enough actions came. Returns how many pictures were not sent."""
    camera, skipped, began = DrawnCamera(drive.road), 0, time.monotonic()
    while drive.actions < options.count:
        # A picture is sent when the last one was answered. Of those in between, only the newest is wanted.
        if client.asked:
            skipped += 1
        else:
            pictures = [camera.draw(drive.car, drive.frame, right) for right in CAMERAS[options.cameras]]
            client.send(drive.message(options.cameras, pictures, options.jpeg))
        if not options.lockstep:
            drive.step()
        keyboard.look(drive)
        due = began + drive.frame * STEP
        action = client.receive(due, options.lockstep)
        if client.asked:
            continue
        drive.apply(action)
        if options.lockstep:
            drive.step()
        else:
            time.sleep(max(0, due - time.monotonic()))
    return skipped


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
    parser = argparse.ArgumentParser(description="Drives a car by what Python sees.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--count", type=int, default=500, help="end after so many actions")
    parser.add_argument("--every", type=int, default=50, help="print one action in so many; 0: none")
    parser.add_argument("--timeout", type=float, default=1, help="seconds to wait for each action")
    parser.add_argument("--tries", type=int, default=20, help="pictures in a row that may stay without an action")
    parser.add_argument("--cameras", choices=CAMERAS, default="center", metavar="NAMES", help=" or ".join(CAMERAS))
    parser.add_argument("--start", type=int, default=0, help="the point of the road to begin at")
    parser.add_argument("--lockstep", action="store_true", help="the world waits for each action")
    parser.add_argument("--drive", action="store_true", help="arrow keys take over, Enter gives back")
    parser.add_argument("--jpeg", action="store_true", help="send JPEG files instead of raw bytes")
    options = parser.parse_args()
    if min(options.count, options.every, options.start, options.tries - 1) < 0 or not 0 < options.timeout < 86400:
        parser.error("--count, --every and --start take whole numbers from 0, --tries from 1, --timeout seconds")
    if options.drive and not sys.stdin.isatty():
        parser.error("--drive needs a keyboard: start it in a terminal")
    print(f"asking {options.endpoint}", flush=True)
    drive = Drive(Road(), options.start, print, options.every, options.lockstep)
    with zmq.Context() as context, Keyboard(options.drive) as keyboard:
        client = DriverClient(context, options.endpoint, options.timeout, options.tries, print)
        try:
            skipped = see_and_steer(drive, client, keyboard, options)
        except GaveUp as error:
            sys.exit(f"gave up: {error}")
        finally:
            client.close()
    print(f"done: {drive.actions} actions, {skipped} pictures skipped")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
