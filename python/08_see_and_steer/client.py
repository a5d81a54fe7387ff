"""Lesson 08, the client in Python. In C# it is CameraSender.cs, which prints the same lines.

    python python/08_see_and_steer/client.py                 500 actions: ten seconds on the road
    python python/08_see_and_steer/client.py --lockstep      the world waits for each action
    python python/08_see_and_steer/client.py --drive         arrow keys or W A S D take over, Enter gives back
    python python/08_see_and_steer/client.py --jpeg          JPEG files; needs Pillow

Bytes: as in server.py.
"""

import math
import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.extras import importing
from netmq_example.program import run, show

with importing("numpy: pip install numpy, or let kit.py run 8 do it", stopped="stopped"):
    from drive import Drive, drive_options
    from keyboard import Keyboard

    from netmq_example.camera.client import DriverClient
    from netmq_example.worlds.road import STEP_SECONDS


def see_and_steer(drive: Drive, client: DriverClient, keyboard: Keyboard, count: int, lockstep: bool) -> int:
    """Until enough actions came. Returns how many pictures were not sent."""
    skipped = 0
    began = time.monotonic()
    while drive.actions < count:
        # A picture is sent when the last one was answered. Of those in between, only the newest is wanted.
        if client.asked:
            skipped += 1
        else:
            client.send(drive.message())
        if not lockstep:
            drive.step()
        keyboard.look(drive)
        due = began + drive.frame * STEP_SECONDS
        action = client.receive(math.inf if lockstep else due)
        if client.asked:
            continue
        drive.apply(action)
        if lockstep:
            drive.step()
        else:
            time.sleep(max(0, due - time.monotonic()))
    return skipped


def main() -> None:
    options = drive_options("tcp://127.0.0.1:5558")
    print(f"asking {options.endpoint}", flush=True)
    drive = Drive(options, show)
    client = DriverClient(options.endpoint, timeout=options.timeout, tries=options.tries)
    with client, Keyboard(options.drive) as keyboard:
        skipped = see_and_steer(drive, client, keyboard, options.count, options.lockstep)
    print(f"done: {drive.actions} actions, {skipped} pictures skipped")


if __name__ == "__main__":
    run(main, stopped="stopped")
