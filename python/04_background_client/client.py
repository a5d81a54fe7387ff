"""Lesson 04, the client in Python: a game that asks once a frame. It prints the same lines as the one in C#.

    python python/04_background_client/client.py              ten times hello, one a frame
    python python/04_background_client/client.py --naive      lets each frame wait, to see the frames stop

Start the server with `--slow-on 3`, or stop it while the client runs: the frames go on, as the last lines say.
How it works, and the bytes: background_client.py and lazy_pirate.py.
"""

import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import at_least_one, client_options
from netmq_example.background_client import BackgroundClient, ClientState
from netmq_example.errors import Error
from netmq_example.program import printable, run, whole


def play(client: BackgroundClient, text: str, count: int, naive: bool) -> None:
    """A game does the same: frame after frame. Each one runs what came back, and asks once; none of them waits."""
    replies: list[str] = []
    errors: list[str] = []
    frame_seconds: list[float] = []
    shown = ""
    while len(replies) < count and not errors:
        began = time.monotonic()
        state, trouble = client.status
        if trouble != shown and state != ClientState.LOST:
            print(f"trouble: {trouble}", flush=True)
            shown = trouble
        known = len(replies)
        client.poll()
        for i, reply in enumerate(replies[known:], known + 1):
            print(f"{i}: sent {text}, received {printable(reply)}", flush=True)
        if len(replies) + client.under_way < count:
            client.request(text, replies.append, errors.append)
        while naive and client.under_way and not errors:
            client.poll()
        time.sleep(1 / 60)
        frame_seconds.append(time.monotonic() - began)
    print(f"frames: {len(frame_seconds)}, the longest took {max(frame_seconds, default=0) * 1000:.0f} ms")
    if errors:
        raise Error(errors[0])
    print(f"done: {len(replies)} replies")


def main() -> None:
    parser = client_options("Says hello once a frame, and never waits.", "tcp://127.0.0.1:5554", timeout=1, beacon=True)
    parser.add_argument("--count", type=whole, default=10, help="how many requests")
    parser.add_argument("--text", default="hello", help="what to ask: 'hello' or 'echo TEXT'")
    parser.add_argument("--tries", type=at_least_one, default=20, help="how often to send a request before giving up")
    parser.add_argument("--naive", action="store_true", help="let each frame wait for its reply")
    options = parser.parse_args()
    print(f"asking {options.endpoint}", flush=True)
    with BackgroundClient(options.endpoint, timeout=options.timeout, tries=options.tries) as client:
        play(client, options.text, options.count, options.naive)


if __name__ == "__main__":
    run(main, stopped="stopped")
