"""Lesson 02, the client in Python: it prints the same lines as the one in C#.

    python python/02_lazy_pirate/client.py                     ten times `add 1`, each with the balance it is answered
    python python/02_lazy_pirate/client.py --text balance      only asks

How it retries, and the bytes: lazy_pirate.py.
"""

import argparse
import contextlib
import functools
import re
import sys
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.lazy_pirate import LazyPirate

ENDPOINT = "tcp://127.0.0.1:5552"


def ask(pirate: LazyPirate, options: argparse.Namespace) -> None:
    for i in range(1, options.count + 1):
        print(f"{i}: sent {options.text}, received {printable(pirate.request(options.text))}", flush=True)
    print(f"done: {options.count} replies")


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
    parser = argparse.ArgumentParser(description="Adds to the server's account, and asks again until it is answered.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--count", type=int, default=10, help="how many requests")
    parser.add_argument("--text", default="add 1", help="what to ask: 'add 1' or 'balance'")
    parser.add_argument("--timeout", type=float, default=0.5, help="seconds to wait, for the first try")
    parser.add_argument("--tries", type=int, default=5, help="how often to send a request before giving up")
    options = parser.parse_args()
    if options.count < 0 or options.tries < 1 or not 0 < options.timeout < 86400:
        parser.error("--count takes a whole number from 0, --tries 1 or more, --timeout seconds, more than 0")
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context:
        say = functools.partial(print, flush=True)
        pirate = LazyPirate(context, options.endpoint, options.timeout, options.tries, say)
        with contextlib.closing(pirate):
            try:
                ask(pirate, options)
            except TimeoutError as error:
                sys.exit(f"gave up: {error}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
