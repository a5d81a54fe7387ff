"""Application 20, body tracking: your body moves the avatar; lesson 03's stream with a topic for each person.

    python python/20_body_tracking/server.py             prints: listening on tcp://127.0.0.1:5570
    python python/20_body_tracking/client.py             or: dotnet run --project csharp-console -- 20
    python python/20_body_tracking/server.py --camera    the persons in front of your webcam, see camera.py

Bytes: UTF-8 text, one frame: `pose/PERSON/ NUMBER SECONDS`, and then `x y z visibility` for each of the 33 landmarks
that MediaPipe numbers: in metres from the middle of the hips, x to the right of the picture, y down, z away from the
camera, with a decimal point. PERSON counts from 0, NUMBER from 1 at each start of the server, SECONDS with the
computer's clock that nobody sets. Where no landmarks follow, nobody is there. `hand/left/` and `hand/right/` have 21,
from the middle of the hand.
Trouble on command: a client with `--work 0.1` is too slow; stop this server while a client listens, and start it
again.
"""

import argparse
import contextlib
import re
import signal
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.body.camera import watch
from netmq_example.body.people import Landmark, Pictures, SourceError, play, read

# What listeners send are subscriptions, and those are short.
ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5570", zmq.PUB, 1000
MODEL = Path("pose_landmarker_lite.task")


def pose(topic: str, number: int, seconds: float, landmarks: list[Landmark]) -> str:
    """One frame: so CONFLATE can keep the newest, and a person who left is told from a server that is gone."""
    # Millimetres: a webcam does not know more.
    numbers = [f"{value:.3f}" for landmark in landmarks for value in landmark]
    return " ".join([f"{topic}/ {number} {seconds:.3f}", *numbers])


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """Send never waits: whoever is not there yet, or listens too slowly, does not get it."""
    try:
        if options.camera is not None:
            source = watch(options.camera, options.model or MODEL, options.persons, options.hands)
        elif options.hands or options.model:
            raise SourceError("--model and --hands need --camera: without it a recording is played")
        else:
            source = play(options.recording)
        for number, (people, hands) in enumerate(source, 1):
            for topic, landmarks in [*((f"pose/{i}", body) for i, body in enumerate(people)), *hands.items()]:
                socket.send_string(pose(topic, number, time.monotonic(), landmarks))
    except SourceError as error:
        sys.exit(f"no poses: {error}")


def recording(text: str) -> Pictures:
    try:
        return read(Path(text))
    except SourceError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def add_options(parser: argparse.ArgumentParser) -> None:
    walk = str(Path(__file__).with_name("walk.csv"))
    parser.add_argument("--recording", type=recording, default=walk, help="the persons; if left out, walk.csv")
    parser.add_argument("--camera", type=int, nargs="?", const=0, help="a webcam instead; 0 is the first one")
    parser.add_argument("--model", type=Path, help=f"for --camera; if left out, {MODEL}")
    parser.add_argument("--persons", type=int, choices=range(1, 10), default=2, help="for --camera: how many at most")
    parser.add_argument("--hands", type=Path, help="for --camera: a model, to look for hands too")


# From here on all servers of this kit are the same, as far as they need it.


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
