"""Application 20, the client in Python: runs BodyListener of body_listener.py, and prints the lines of the C# twin.

    python python/20_body_tracking/client.py                  150 poses of person 0, one in 25 is printed
    python python/20_body_tracking/client.py --person 1       the other one
    python python/20_body_tracking/client.py --hand left      a hand, of a server with --camera and --hands
    python python/20_body_tracking/client.py --work 0.1       too slow: what it skips is not waited for

Bytes: as in server.py. To copy: body_listener.py.
"""

import argparse
import re
import sys
import time
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.body.listener import LANDMARKS, BodyListener, BodyPose

ENDPOINT = "tcp://127.0.0.1:5570"
# MediaPipe's numbers.
RIGHT_KNEE, INDEX_FINGER = (24, 26, 28), (5, 6, 7)


def seen(pose: BodyPose, behind: float) -> str:
    if not pose.landmarks:
        return f"pose {pose.number}, nobody is there"
    name, joint = ("right knee", RIGHT_KNEE) if len(pose.landmarks) == LANDMARKS["pose"] else ("finger", INDEX_FINGER)
    return f"pose {pose.number}, {name} {pose.angle(*joint):.0f} degrees, {1000 * behind:.0f} ms late"


def listen(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    topic = f"hand/{options.hand}/" if options.hand else f"pose/{options.person}/"
    who = f"{options.hand} hand" if options.hand else f"person {options.person}"
    print(f"listening to '{topic}' from {options.endpoint}", flush=True)
    listener = BodyListener(socket, options.endpoint, topic)
    i = 0
    while i < options.count or not options.count:
        pose = listener.receive(options.timeout)
        if listener.restarted:
            print(f"{who}: the server was started again", flush=True)
        if options.every and i % options.every == 0:
            print(f"{who}: {seen(pose, listener.behind)}", flush=True)
        i += 1
        time.sleep(options.work)
    print(f"done: {options.count} poses, {listener.skipped} skipped")


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
    parser = argparse.ArgumentParser(description="Listens to the poses of a person.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--person", type=int, default=0, help="which one; they count from 0")
    parser.add_argument("--hand", choices=["left", "right"], help="a hand, and no person")
    parser.add_argument("--count", type=int, default=150, help="end after so many poses; 0: never")
    parser.add_argument("--every", type=int, default=25, help="print one in so many; 0: none")
    parser.add_argument("--timeout", type=float, default=5, help="seconds to wait for each pose")
    parser.add_argument("--work", type=float, default=0, help="seconds that each pose takes: a slow client")
    options = parser.parse_args()
    numbers = (options.person, options.count, options.every, options.timeout, options.work)
    if not all(0 <= number < 2**31 for number in numbers):
        parser.error("--person, --count, --every, --timeout and --work take numbers from 0 on")
    with zmq.Context() as context, context.socket(zmq.SUB) as socket:
        try:
            listen(socket, options)
        except TimeoutError as error:
            sys.exit(f"gave up: {error}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
