"""Application 20, body tracking: your body moves the avatar; lesson 03's stream with a topic for each person.

    python python/20_body_tracking/server.py             prints: listening on tcp://127.0.0.1:5570
    python python/20_body_tracking/client.py             or: dotnet run --project csharp-console -- 20
    python python/20_body_tracking/server.py --camera    the persons in front of your webcam, see netmq_example/body
    python python/20_body_tracking/server.py --camera walk.mp4    those in a film; or rtsp://…, a camera in the network

Bytes: UTF-8 text, one frame: `pose/PERSON/ NUMBER SECONDS`, and then `x y z visibility` for each of the 33 landmarks
that MediaPipe numbers: in metres from the middle of the hips, x to the right of the picture, y down, z away from the
camera, with a decimal point. PERSON counts from 0, NUMBER from 1 at each start of the server, SECONDS with the
computer's clock that nobody sets. A pose without landmarks means that nobody is there.
`hand/left/` and `hand/right/` have 21 landmarks, in metres from the middle of the hand.
Trouble on command: a client with `--work 0.1` is too slow; stop this server while a client listens, and start it
again.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq
from walker import persons

from netmq_example.body.camera import device, watch
from netmq_example.body.people import Hands, Landmark, People, Pictures, SourceError, as_text, begun, play, read
from netmq_example.program import encoded, listening, option, run, server_options

MODEL = Path("pose_landmarker_lite.task")
# Listeners send only subscriptions, and those are short.
LARGEST_BYTES = 1000


def pose(topic: str, number: int, seconds: float, landmarks: list[Landmark]) -> str:
    """One frame, because CONFLATE keeps the newest one. A person who left has a pose without landmarks."""
    return " ".join([f"{topic}/ {number} {seconds:.3f}", *as_text(landmarks)])


def recording(text: str) -> Pictures:
    return option(lambda _, path: read(path), text, Path)


def source(options: argparse.Namespace) -> Iterator[tuple[People, Hands]]:
    if options.camera is not None:
        return watch(options.camera, options.model or MODEL, options.persons, options.hands)
    if options.hands or options.model:
        raise SourceError("--model and --hands need --camera: they are for its pictures")
    return play(options.recording or persons())


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5570")
    parser.add_argument("--recording", type=recording, help="a file of yours; if left out, two persons are made up")
    parser.add_argument("--camera", type=device, nargs="?", const=0, help="a webcam, 0 is the first; a film; a stream")
    parser.add_argument("--model", type=Path, help=f"for --camera; if left out, {MODEL}")
    parser.add_argument("--persons", type=int, choices=range(1, 10), default=2, help="for --camera: how many at most")
    parser.add_argument("--hands", type=Path, help="for --camera: a model, to look for hands too")
    options = parser.parse_args()
    try:
        # A webcam and its models take longer than a client waits: this server is ready when there is a picture.
        pictures = begun(source(options))
        with listening(zmq.PUB, options, LARGEST_BYTES) as socket:
            for number, (people, hands) in enumerate(pictures, 1):
                bodies = {f"pose/{person}": body for person, body in enumerate(people)}
                for topic, landmarks in (bodies | hands).items():
                    # This never waits: a listener that is not there yet, or is too slow, does not get it.
                    socket.send(encoded(pose(topic, number, time.monotonic(), landmarks)))
            print("the film is over", flush=True)
    except SourceError as error:
        sys.exit(f"no poses: {error}")


if __name__ == "__main__":
    run(main)
