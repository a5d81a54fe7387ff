"""Lesson 16, the client in Python: lesson 01's Hello, through the gateway. It prints the same lines.

    python python/16_web_gateway/client.py                     by WebSocket
    python python/16_web_gateway/client.py --socketio          the same by Socket.IO

server.py describes the bytes.
"""

import argparse
import asyncio
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_options
from netmq_example.extras import importing
from netmq_example.program import printable, run, whole

with importing("aiohttp and python-socketio; kit.py run 16 installs them", stopped="stopped"):
    from netmq_example.web.requester import WebSocketRequester
    from netmq_example.web.socketio_requester import SocketIORequester


async def talk(options: argparse.Namespace) -> None:
    kind = SocketIORequester if options.socketio else WebSocketRequester
    async with kind(options.endpoint, "hello", token=options.token, timeout=options.timeout) as requester:
        for i in range(1, options.count + 1):
            reply = await requester.request(options.text)
            print(f"{i}: sent {options.text}, received {printable(' '.join(reply))}", flush=True)


def main() -> None:
    parser = client_options(
        "Says Hello through the gateway, and waits for World.", "http://127.0.0.1:5566", timeout=2.5
    )
    parser.add_argument("--count", type=whole, default=10, help="how many times to ask")
    parser.add_argument("--text", default="Hello", help="what to say")
    parser.add_argument("--socketio", action="store_true", help="by Socket.IO in place of plain WebSocket")
    parser.add_argument("--token", default="", help="the word that the gateway was given as --token")
    options = parser.parse_args()
    print(f"asking {options.endpoint}", flush=True)
    asyncio.run(talk(options))
    print(f"done: {options.count} replies")


if __name__ == "__main__":
    run(main, stopped="stopped")
