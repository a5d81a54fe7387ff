"""Lesson 06, the client in Python: many requests under way, printed as their replies arrive.

    python python/06_many_in_flight/client.py                   a slow request does not hold up the others
    python python/06_many_in_flight/client.py --window 1        one after the other, as in lesson 01

Bytes: UTF-8 text, two frames each way: [id][text]; the id is a number in digits, and a retry carries the same.
"""

import argparse
import itertools
import re
import sys
from contextlib import closing
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.many_requester import ManyRequester

ENDPOINT = "tcp://127.0.0.1:5556"


def ask(requester: ManyRequester, texts: list[str], count: int) -> int:
    """Print each reply when it comes. Returns how many requests have none."""
    failures = 0
    for number, reply, failure in requester.request_many(itertools.islice(itertools.cycle(texts), count)):
        failures += bool(failure)
        outcome = f"gave up: {failure}" if failure else f"received {printable(reply)}"
        print(f"{number}: sent {printable(texts[(number - 1) % len(texts)])}, {outcome}", flush=True)
    print(f"done: {count - failures} replies", flush=True)
    return failures


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
    parser = argparse.ArgumentParser(description="Asks without waiting for each answer.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--count", type=int, default=6, help="how many requests")
    text = "sleep 0.8|echo one|sleep 0.5|echo two|sleep 0.2|echo three"
    parser.add_argument("--text", default=text, help="requests to repeat, with | between")
    parser.add_argument("--window", type=int, default=4, help="how many requests may be under way")
    parser.add_argument("--timeout", type=float, default=2.5, help="seconds to wait, for the first try")
    parser.add_argument("--tries", type=int, default=3, help="how often to send a request before giving up")
    options = parser.parse_args()
    if options.count < 0 or not 0 < options.timeout < 86400:
        parser.error("--count takes a whole number from 0, --timeout seconds, more than 0")
    if options.window < 1 or options.tries < 1:
        parser.error("--window and --tries take a whole number, 1 or more")
    print(f"asking {options.endpoint}, {options.window} in flight", flush=True)
    limits = options.window, options.timeout, options.tries
    with (
        zmq.Context() as context,
        closing(ManyRequester(context, options.endpoint, *limits, lambda line: print(line, flush=True))) as requester,
    ):
        failures = ask(requester, options.text.split("|"), options.count)
    if failures:
        where = f"{options.count} requests to {options.endpoint}"
        sys.exit(f"gave up: {failures} of {where} have no reply; see above")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
