"""Lesson 16, the client in Python: lesson 01's Hello, through the gateway. It prints the same lines.

    python python/16_web_gateway/client.py                     by WebSocket
    python python/16_web_gateway/client.py --socketio          the same by Socket.IO

The bytes are said in server.py.
"""

import argparse
import asyncio
import re
import sys
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

try:
    from netmq_example.web.requester import WebSocketRequester
    from netmq_example.web.socketio_requester import SocketIORequester
except ImportError as error:
    sys.exit(f"{error}: this lesson needs aiohttp and python-socketio; kit.py run 16 installs them")
except KeyboardInterrupt:
    # They take half a second.
    sys.exit("stopped")

ENDPOINT = "http://127.0.0.1:5566"


async def talk(options: argparse.Namespace) -> None:
    kind = SocketIORequester if options.socketio else WebSocketRequester
    async with kind(options.endpoint, "hello", options.token, options.timeout) as requester:
        for i in range(1, options.count + 1):
            reply = await requester.request(options.text)
            print(f"{i}: sent {options.text}, received {printable(' '.join(reply))}", flush=True)


def address(text: str) -> str:
    """A gateway is found as a page is."""
    parts = re.fullmatch(r"http://([\w.-]+):(\d{1,5})", text, re.ASCII)
    if not parts or not 0 < int(parts[2]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': unknown host '{parts[1]}'; check it") from None
    return text


# From here on all clients of this kit are the same, but for their own options.


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Says Hello through the gateway, and waits for World.")
    parser.add_argument("--endpoint", type=address, default=ENDPOINT, help="the gateway")
    parser.add_argument("--count", type=int, default=10, help="how many times to ask")
    parser.add_argument("--text", default="Hello", help="what to say")
    parser.add_argument("--timeout", type=float, default=2.5, help="seconds to wait for each reply")
    parser.add_argument("--socketio", action="store_true", help="by Socket.IO in place of plain WebSocket")
    parser.add_argument("--token", default="", help="the word that the gateway was given as --token")
    options = parser.parse_args()
    if options.count < 0 or not 0 < options.timeout < 86400:
        parser.error("--count takes a whole number from 0, --timeout seconds, more than 0")
    print(f"asking {options.endpoint}", flush=True)
    try:
        asyncio.run(talk(options))
    except (TimeoutError, PermissionError) as error:
        sys.exit(f"gave up: {printable(str(error))}")
    print(f"done: {options.count} replies")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
