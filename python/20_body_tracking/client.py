"""Application 20, the client in Python: it prints the same lines as the one in C#.

    python python/20_body_tracking/client.py                  150 poses of person 0, one in 25 is printed
    python python/20_body_tracking/client.py --person 1       the other one
    python python/20_body_tracking/client.py --hand left      a hand, of a server with --camera and --hands
    python python/20_body_tracking/client.py --work 0.1       too slow: what it skips is not waited for

Bytes: as in server.py.
"""

import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_options
from netmq_example.body.listener import LANDMARKS, BodyListener, BodyPose
from netmq_example.program import run, seconds, whole

# MediaPipe's numbers of three landmarks, which make an angle.
RIGHT_KNEE = (24, 26, 28)
INDEX_FINGER = (5, 6, 7)


def seen(pose: BodyPose, behind: float) -> str:
    if not pose.landmarks:
        return f"pose {pose.number}, nobody is there"
    if len(pose.landmarks) == LANDMARKS["pose"]:
        limb = f"right knee {pose.angle(*RIGHT_KNEE):.0f} degrees"
    else:
        limb = f"finger {pose.angle(*INDEX_FINGER):.0f} degrees"
    return f"pose {pose.number}, {limb}, {1000 * behind:.0f} ms late"


def main() -> None:
    parser = client_options("Listens to the poses of a person.", "tcp://127.0.0.1:5570", timeout=5, beacon=True)
    parser.add_argument("--person", type=whole, default=0, help="which one; they count from 0")
    parser.add_argument("--hand", choices=["left", "right"], help="a hand, and no person")
    parser.add_argument("--count", type=whole, default=150, help="end after so many poses; 0: never")
    parser.add_argument("--every", type=whole, default=25, help="print one in so many; 0: none")
    parser.add_argument("--work", type=seconds, default=0, help="seconds that each pose takes: a slow client")
    options = parser.parse_args()
    topic = f"hand/{options.hand}/" if options.hand else f"pose/{options.person}/"
    who = f"{options.hand} hand" if options.hand else f"person {options.person}"
    print(f"listening to '{topic}' from {options.endpoint}", flush=True)
    with BodyListener(options.endpoint, topic) as listener:
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


if __name__ == "__main__":
    run(main, stopped="stopped")
