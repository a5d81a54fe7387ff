"""Lesson 08, see and steer: every picture has a number, and every action names the picture that it answers.

    python python/08_see_and_steer/server.py                     prints: listening on tcp://127.0.0.1:5558
    python python/08_see_and_steer/client.py                     or: dotnet run --project csharp-console -- 8
    python python/08_see_and_steer/server.py --record runs       keeps each drive in a folder of its own there
    python python/08_see_and_steer/server.py --model steering.npz          drives by what train.py has learned

Bytes: messages of lesson 05. A request of kind `frame` has as values its number `frame`, `run` (another text for each
drive), `manual` (true while a person drives), `sim_time` and `wall_time` (seconds), `throttle` (-1, backwards, to 1),
`brake` (0 to 1) and `steer` (-1, left, to 1, right) as they were in force when the picture was taken, `speed` (m/s,
backwards below 0), `cameras`, `encoding`, `bottom_up` and those of your own; netmq_example/camera/pictures.py says what
its arrays are. The reply is of kind `action`: `frame`, `throttle`, `brake`, `steer` and those of your own.
Trouble on command: `--delay 0.2` is a slow driver.
"""

import functools
import sys
import time
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.extras import importing
from netmq_example.large import receive_frames, send_frames
from netmq_example.program import listening, run, seconds, server_options

with importing("numpy: pip install numpy, or let kit.py run 8 do it"):
    from driver import as_action, follow_road, main_camera
    from train import load

    from netmq_example.camera.pictures import pictures
    from netmq_example.camera.recording import Recorder
    from netmq_example.messages import LIMIT, Message, message_reply


def drive(pictures: dict[str, Any], telemetry: dict[str, Any]) -> Any:
    """Your own model goes here. Each picture is uint8 [height, width, 3], and read-only: draw into a copy of it. It
    returns throttle, brake and steer.
    """
    return follow_road(main_camera(pictures), telemetry["speed"])


def answer(driver: Any, frame: Message) -> Message:
    """The action names its picture."""
    action = as_action(driver(pictures(frame), dict(frame.values)))
    return Message("action", frame.id, {**action, "frame": frame.id})


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5558")
    parser.add_argument("--delay", type=seconds, default=0, help="seconds to think about each picture")
    parser.add_argument("--record", type=Path, help="a folder, to which each drive is recorded")
    parser.add_argument("--model", type=load, default=drive, help="drive by what train.py has learned: steering.npz")
    options = parser.parse_args()
    recorder = Recorder(options.record)
    answered = functools.partial(answer, options.model)
    with listening(zmq.REP, options, largest=4 * LIMIT) as socket:
        while True:
            request = receive_frames(socket)
            frame, action, parts = message_reply(answered, request, "error-in-driver")
            # Even a sleep of 0 takes as long as the whole reply.
            if options.delay:
                time.sleep(options.delay)
            send_frames(socket, parts)
            # Afterwards: a picture that is written makes no action older.
            recorder.add(frame, action)


if __name__ == "__main__":
    run(main)
