"""Lesson 08, see and steer: every picture has a number, and every action names the picture that it answers.

    python python/08_see_and_steer/server.py                     prints: listening on tcp://127.0.0.1:5558
    python python/08_see_and_steer/client.py                     or: dotnet run --project csharp-console -- 8
    python python/08_see_and_steer/server.py --record runs       keeps each drive in a folder of its own there
    python python/08_see_and_steer/server.py --model steering.npz          drives by what train.py has learned

Bytes: messages of lesson 05. A request of kind `frame` has as values its number `frame`, `run` (another text for each
drive), `manual` (true while a person drives), `sim_time` and `wall_time` (seconds), `throttle`, `brake` (0 to 1) and
`steer` (-1, left, to 1, right) as they were in force when the picture was taken, `speed` (m/s), `cameras`, `encoding`
and `bottom_up`; pictures.py says what its arrays are. The reply is of kind `action`: `frame`, `throttle`, `brake`,
`steer`.
Trouble on command: `--delay 0.2` is a slow driver.
"""

import argparse
import contextlib
import re
import signal
import sys
import time
import traceback
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq
from driver import follow_road, main_camera
from train import load

from netmq_example.camera.pictures import pictures
from netmq_example.camera.recording import Recorder
from netmq_example.messages import LIMIT, Message, MessageError, read

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5558", zmq.REP, 4 * LIMIT


def drive(picture: Any, speed: float) -> tuple[float, float, float]:
    """Your own model goes here: throttle, brake and steer for a picture, uint8 [height, width, 3], and a speed, m/s."""
    return follow_road(picture, speed)


def answer(frame: Message, driver: Any) -> Message:
    """What the middle camera sees, or the left one of two, decides. The action names its picture."""
    seen = pictures(frame)
    throttle, brake, steer = driver(main_camera(seen), float(frame.values["speed"]))
    action = {"throttle": float(throttle), "brake": float(brake), "steer": float(steer)}
    return Message("action", frame.id, {"frame": frame.id, **action})


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    recorder = Recorder(options.record)
    while True:
        # It waits in slices: on Windows Ctrl-C does not interrupt a longer wait.
        with contextlib.suppress(zmq.Again):
            frame, reply, parts = reply_to(socket.recv_multipart(copy=False), options.model)
            # To sleep for no time takes as long as the whole reply.
            if options.delay:
                time.sleep(options.delay)
            socket.send_multipart(parts)
            # Afterwards: a picture that is written makes no action older.
            recorder.add(frame, reply)


def reply_to(frames: list[zmq.Frame], driver: Any) -> tuple[Message, Message, list[Any]]:
    """What is wrong is told to whoever asked, and the server serves on."""
    frame = Message("")
    try:
        frame = read(frames)
        reply = answer(frame, driver)
        # What cannot be written, such as NaN, is found out here.
        return frame, reply, reply.frames()
    except Exception as error:
        if not isinstance(error, MessageError):
            # A mistake in a driver: its place is for whoever writes it.
            traceback.print_exc()
            error = MessageError("error-in-driver", repr(error))
        reply = Message("error", error.id or frame.id, {"code": error.code, "text": error.text})
        return frame, reply, reply.frames()


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--delay", type=seconds, default=0, help="seconds to think about each picture")
    parser.add_argument("--record", type=Path, help="a folder, to which each drive is recorded")
    parser.add_argument("--model", type=load, default=drive, help="drive by what train.py has learned: steering.npz")


# From here on all servers of this kit are the same, as far as they need it.


def seconds(text: str) -> float:
    if not 0 <= float(text) < 86_400:
        raise ValueError
    return float(text)


def endpoint(text: str) -> str:
    """libzmq itself would listen on port 99999 - 65536, and for everybody, without a word."""
    port = re.fullmatch(r"tcp://[\w.*-]+:(\*|\d{1,5})", text, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 0 to 65535")
    # Options are read one after the other, and this one may come first.
    told = any(word.startswith(("--keys", "--open-to-anyone")) for word in sys.argv)
    if not told and not re.match(r"tcp://(localhost|127\.[\d.]+):", text):
        raise argparse.ArgumentTypeError(f"'{text}' lets anyone in: lesson 15 has keys, --open-to-anyone has none")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="port 0 takes a free one")
    parser.add_argument("--open-to-anyone", action="store_true", help="also from other machines, without keys")
    add_options(parser)
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does; on Windows that is SIGBREAK.
    signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
    with zmq.Context() as context, context.socket(SOCKET) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        # Who announces more than the largest message is disconnected before it is in memory.
        socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, LARGEST, 200
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            cure = "try --endpoint tcp://127.0.0.1:0, which takes a free port"
            sys.exit(f"cannot listen on {options.endpoint}: {zmq.strerror(error.errno or 0)}; {cure}")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
