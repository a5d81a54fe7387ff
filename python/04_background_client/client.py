"""Lesson 04, the client in Python: a game that asks once a frame. It prints the same lines as the one in C#.

    python python/04_background_client/client.py              ten times hello, one a frame
    python python/04_background_client/client.py --naive      lets each frame wait, to see the frames stop

Start the server with `--slow-on 3`, or stop it while the client runs: the frames go on, as the last lines say.
How it works, and the bytes: background_client.py.
"""

import argparse
import contextlib
import re
import sys
import time
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from netmq_example.background_client import BackgroundClient

ENDPOINT = "tcp://127.0.0.1:5554"


def play(client: BackgroundClient, options: argparse.Namespace) -> None:
    """What a game does: frame after frame. Each one runs what came back, and asks once."""
    replies, errors = list[str](), list[str]()
    asked, frames, longest, shown = 0, 0, 0.0, ""
    while len(replies) < options.count and not errors:
        began = time.monotonic()
        state, error = client.status
        if error != shown and state != "Lost":
            print(f"trouble: {(shown := error)}", flush=True)
        known = len(replies)
        client.poll()
        for i, reply in enumerate(replies[known:], known + 1):
            print(f"{i}: sent {options.text}, received {printable(reply)}", flush=True)
        asked += asked < options.count and client.request(options.text, replies.append, errors.append)
        while options.naive and len(replies) < asked and not errors:
            client.poll()
        time.sleep(1 / 60)
        frames, longest = frames + 1, max(longest, time.monotonic() - began)
    print(f"frames: {frames}, the longest took {longest * 1000:.0f} ms")
    if errors:
        sys.exit(f"gave up: {errors[0]}")
    print(f"done: {len(replies)} replies")


# From here on all clients of this kit are the same, but for their own options.


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


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
    parser = argparse.ArgumentParser(description="Says hello once a frame, and never waits for world.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--count", type=int, default=10, help="how many requests")
    parser.add_argument("--text", default="hello", help="what to ask: 'hello' or 'echo TEXT'")
    parser.add_argument("--timeout", type=float, default=1.0, help="seconds to wait for each reply")
    parser.add_argument("--tries", type=int, default=20, help="how often to send a request before giving up")
    parser.add_argument("--naive", action="store_true", help="let each frame wait for its reply")
    options = parser.parse_args()
    if options.count < 0 or options.tries < 1 or not 0 < options.timeout < 86400:
        parser.error("--count takes a whole number from 0, --tries 1 or more, --timeout seconds, more than 0")
    print(f"asking {options.endpoint}", flush=True)
    with contextlib.closing(BackgroundClient(options.endpoint, options.timeout, options.tries)) as client:
        play(client, options)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
