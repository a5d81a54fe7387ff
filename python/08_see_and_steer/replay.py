"""Lesson 08, a replay: sends a recording as if it were Unity, so that one can work on a driver without one.

    python python/08_see_and_steer/replay.py runs/run_0001                 as fast as the server answers
    python python/08_see_and_steer/replay.py runs/run_0001 --fps 50        as fast as it was driven
    python python/08_see_and_steer/replay.py runs/run_0001 --compare       says which actions have changed

A picture that came as a JPEG file is the same to the byte, and the same driver gives the same action to the bit.
A raw picture has become JPEG in the recording, which changes an action's last digits.
"""

import argparse
import sys
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example import arguments
from netmq_example.asking import client_options
from netmq_example.errors import Timeout
from netmq_example.extras import importing
from netmq_example.program import option, run

with importing("numpy: pip install numpy, or let kit.py run 8 do it", stopped="stopped"):
    from netmq_example.camera.client import Action, DriverClient
    from netmq_example.camera.recording import recorded
    from netmq_example.messages import Array, Message


def frames(folder: Path) -> Iterator[tuple[int, Message, Action]]:
    """Each line's number, what was sent and what was answered."""
    run_name = f"replay {uuid.uuid4().hex[:8]}"
    for row in recorded(folder):
        then = row.answered
        values = row.values | {"run": run_name, "cameras": ",".join(row.files), "encoding": "jpeg", "bottom_up": False}
        arrays = [Array("uint8", (len(file),), file) for file in row.files.values()]
        message = Message("frame", values["frame"], values, arrays)
        yield row.number, message, Action(message.id, then["throttle"], then["brake"], then["steer"])


def replay(client: DriverClient, options: argparse.Namespace) -> str:
    """Sends all of it. Returns what is to be said at the end."""
    begin = time.monotonic()
    asked = answered = others = 0
    most = 0.0
    for line, message, then in frames(options.recording):
        if options.fps:
            time.sleep(max(0.0, begin + asked / options.fps - time.monotonic()))
        asked += 1
        client.send(message)
        now = client.receive()
        if now is None:
            continue
        answered += 1
        apart = max(abs(now.throttle - then.throttle), abs(now.brake - then.brake), abs(now.steer - then.steer))
        if apart:
            others += 1
            most = max(most, apart)
        if options.compare and apart and others <= 10:
            print(f"line {line}, frame {now.frame}: steer {now.steer!r}, then {then.steer!r}", flush=True)
    compared = f"; {others} differ from the recorded ones, by at most {most:g}" if options.compare else ""
    return f"done: {answered} of {asked} pictures have an action{compared}"


def pictures_a_second(text: str) -> float:
    """A number from 0 on."""
    return option(lambda name, value: arguments.number(name, value, 0, 100_000), text, float)


def main() -> None:
    parser = client_options("Sends a recording as if it were Unity.", "tcp://127.0.0.1:5558", timeout=1)
    parser.add_argument("recording", type=Path, help="a recorded drive, such as runs/run_0001")
    parser.add_argument(
        "--fps", type=pictures_a_second, default=0, help="pictures a second; 0: as fast as answers come"
    )
    parser.add_argument("--compare", action="store_true", help="compare the actions with the recorded ones")
    options = parser.parse_args()
    print(f"asking {options.endpoint}", flush=True)
    with DriverClient(options.endpoint, timeout=options.timeout, tries=3) as client:
        try:
            print(replay(client, options))
        except Timeout:
            # It is an OSError, and none of the recording's.
            raise
        except OSError as error:
            cure = "server.py --record runs makes recordings"
            sys.exit(f"no replay of {options.recording} to {options.endpoint}: {error}; {cure}")


if __name__ == "__main__":
    run(main, stopped="stopped")
