"""Lesson 08, a replay: sends a recording as if it were Unity, so that one can work on a driver without one.

    python python/08_see_and_steer/replay.py runs/run_0001                 as fast as the server answers
    python python/08_see_and_steer/replay.py runs/run_0001 --fps 50        as fast as it was driven
    python python/08_see_and_steer/replay.py runs/run_0001 --compare       says which actions have changed

What was recorded from JPEG files is the same to the byte, and the same driver then gives the same actions to the bit.
What was recorded from raw pictures has become JPEG on the way, which changes an action's last digits.
"""

import argparse
import re
import sys
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.camera.client import Action, DriverClient, GaveUp
from netmq_example.camera.recording import ANSWERED, recorded
from netmq_example.messages import Array, Message

ENDPOINT = "tcp://127.0.0.1:5558"


def frames(folder: Path) -> Iterator[tuple[int, Message, Action]]:
    """Each line's number, what was sent and what was answered."""
    run = f"replay {uuid.uuid4().hex[:8]}"
    for line, values, files, _ in recorded(folder):
        then = Action(values["frame"], *(values.pop(name) for name in ANSWERED))
        values |= {"run": run, "cameras": ",".join(files), "encoding": "jpeg", "bottom_up": False}
        arrays = [Array("uint8", (len(file),), file) for file in files.values()]
        yield line, Message("frame", values["frame"], values, arrays), then


def replay(client: DriverClient, options: argparse.Namespace) -> str:
    """Sends all of it. Returns what is to be said at the end."""
    begin, asked, answered, others, most = time.monotonic(), 0, 0, 0, 0.0
    for line, message, then in frames(options.recording):
        if options.fps:
            time.sleep(max(0.0, begin + asked / options.fps - time.monotonic()))
        asked += 1
        client.send(message)
        now = client.receive(0, patient=True)
        if now is None:
            continue
        answered += 1
        apart = max(abs(now.throttle - then.throttle), abs(now.brake - then.brake), abs(now.steer - then.steer))
        others, most = others + (apart > 0), max(most, apart)
        if options.compare and apart and others <= 10:
            print(f"line {line}, frame {now.frame}: steer {now.steer!r}, then {then.steer!r}", flush=True)
    compared = f"; {others} differ from the recorded ones, by at most {most:g}" if options.compare else ""
    return f"done: {answered} of {asked} pictures have an action{compared}"


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Sends a recording as if it were Unity.")
    parser.add_argument("recording", type=Path, help="a folder of recorder.py, such as runs/run_0001")
    parser.add_argument("--endpoint", default=ENDPOINT, help="the server")
    parser.add_argument("--fps", type=float, default=0, help="pictures a second; 0: as fast as the server answers")
    parser.add_argument("--timeout", type=float, default=1, help="seconds to wait for each action")
    parser.add_argument("--compare", action="store_true", help="compare the actions with the recorded ones")
    options = parser.parse_args()
    if not 0 <= options.fps < 100_000 or not 0 < options.timeout < 86400:
        parser.error("--fps takes a number from 0, --timeout seconds, more than 0")
    port = re.fullmatch(r"tcp://[\w.-]+:(\d{1,5})", options.endpoint, re.ASCII)
    if not port or not 0 < int(port[1]) < 65536:
        parser.error(f"bad endpoint '{options.endpoint}': write it like {ENDPOINT}, port 1 to 65535")
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context:
        client = DriverClient(context, options.endpoint, options.timeout, 3, print)
        try:
            print(replay(client, options))
        except GaveUp as error:
            sys.exit(f"gave up: {error}")
        except (OSError, zmq.ZMQError) as error:
            sys.exit(f"no replay of {options.recording} to {options.endpoint}: {error}")
        finally:
            client.close()


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
