"""Lesson 15, the client in Python: it prints the same lines as the one in C#.

    python python/15_security/client.py                     ten times Hello, each with the reply
    python python/15_security/client.py --stranger          with a key that nobody has enrolled
    python python/15_security/client.py --plain             without keys
    python python/15_security/client.py --server-key=KEY    for a server of another key, which is not this one

How it notices that it is refused, and the bytes: secure_requester.py.
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

from netmq_example.security.requester import ClientKeys, SecureRequester

ENDPOINT = "tcp://127.0.0.1:5565"


def ask(requester: SecureRequester, count: int) -> None:
    for i in range(1, count + 1):
        print(f"{i}: sent Hello, received {printable(requester.request('Hello'))}", flush=True)
    print(f"done: {count} replies")


def own_keys(options: argparse.Namespace) -> ClientKeys | None:
    """From its folder, where it makes itself a pair if there is none."""
    if options.plain:
        return None
    keys = ClientKeys(options.keys, options.server_key)
    if options.stranger:
        keys.public, keys.secret = zmq.curve_keypair()
    return keys


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
    parser = argparse.ArgumentParser(description="Says hello to a server that knows its clients by their keys.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--count", type=int, default=10, help="how many requests")
    parser.add_argument("--timeout", type=float, default=1.0, help="seconds to wait for each reply")
    parser.add_argument("--tries", type=int, default=3, help="how often to send a request before giving up")
    parser.add_argument("--keys", type=Path, default="keys", metavar="DIR", help="server.key and this client's pair")
    # To be given with an equals sign: a key may begin with a dash.
    parser.add_argument("--server-key", default="", metavar="KEY", help="in place of that in server.key")
    parser.add_argument("--stranger", action="store_true", help="a new key, which nobody has enrolled")
    parser.add_argument("--plain", action="store_true", help="no keys at all")
    options = parser.parse_args()
    if options.count < 0 or options.tries < 1 or not 0 < options.timeout < 86400:
        parser.error("--count takes a whole number from 0, --tries 1 or more, --timeout seconds, more than 0")
    try:
        keys = own_keys(options)
    except (ValueError, OSError) as error:
        parser.error(str(error))
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context:
        say = functools.partial(print, flush=True)
        requester = SecureRequester(context, options.endpoint, keys, options.timeout, options.tries, say)
        with contextlib.closing(requester):
            try:
                ask(requester, options.count)
            except TimeoutError as error:
                sys.exit(f"gave up: {error}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
