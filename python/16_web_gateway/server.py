"""Lesson 16, the web gateway: one ZeroMQ socket for each browser, to the servers of the lessons before, unchanged.

    python python/01_request_reply/server.py       behind the gateway; and 03 and 04, if the page is to show them
    python python/16_web_gateway/server.py         prints: listening on http://127.0.0.1:5566, the page for a browser
    python python/16_web_gateway/client.py         or: dotnet run --project csharp-console -- 16

Bytes: a WebSocket at /ws/NAME has a ZeroMQ socket of its own to the server of that NAME. Each message is a JSON list of
texts, one for each frame: ["Hello"] is answered with ["World"], or with {"error": why}. A binary message, for what is
no text, is answered with a binary one: each frame behind its length, 4 bytes, little-endian. A publisher is asked for a
topic, ["pose/"], and answers with the newest message; [] is: nothing new yet, ask again.
Socket.IO, at its usual path: emit(NAME, ...frames, callback), and the callback gets the frames of the answer.
Trouble on command: Ctrl-C, here or in a server behind, and a new start: the page says so, and goes on.
"""

import argparse
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_endpoint, positive_seconds
from netmq_example.extras import importing
from netmq_example.program import Options, run, server_endpoint
from netmq_example.security.requester import client_keys

with importing("aiohttp and python-socketio; kit.py run 16 installs them"):
    from aiohttp import web
    from until_killed import run_until_killed

    from netmq_example.web import socketio, websocket
    from netmq_example.web.browser_socket import BrowserSocket, Listener, Requester, for_browsers
    from netmq_example.web.door import Door

# By kit.py run: the servers of these lessons stand behind it, each named by the option that says where it listens.
RUN = {"scheme": "http", "behind": {"--hello": 1, "--background": 4, "--poses": 3}}
# Your own servers go here. A browser asks for a name: it must never choose an address of the network behind.
SERVERS = {"hello": "tcp://127.0.0.1:5551", "background": "tcp://127.0.0.1:5554"}
PUBLISHERS = {"poses": "tcp://127.0.0.1:5553", "pictures": "tcp://127.0.0.1:5555"}


async def serve(options: argparse.Namespace) -> None:
    """The page, WebSocket and Socket.IO on one port, and behind it one ZeroMQ socket for each browser."""
    context = for_browsers(options.keys)

    def opened(name: str) -> BrowserSocket:
        """The ZeroMQ socket of one browser. It is closed when that browser leaves."""
        kind = Requester if name in SERVERS else Listener
        return kind(context, getattr(options, name), options.timeout)

    async def show(request: web.Request) -> web.StreamResponse:
        # In a frame of another page its clicks could be stolen.
        headers = {"Content-Security-Policy": "frame-ancestors 'none'"}
        return web.FileResponse(Path(__file__).with_name("page.html"), headers=headers)

    door = Door(options.origin, options.token)
    app = web.Application(middlewares=[door.look])
    app.router.add_get("/", show)
    for way in websocket, socketio:
        way.attach(app, door, [*SERVERS, *PUBLISHERS], opened)
    await door.open(app, options.endpoint)


def main() -> None:
    parser = Options(description=(__doc__ or "").partition("\n")[0])
    here = "http://127.0.0.1:5566"
    parser.add_argument("--endpoint", type=server_endpoint(here), default=here, help="port 0 takes a free one")
    parser.add_argument("--origin", action="append", default=[], help="a page that may come in: http://localhost:80")
    parser.add_argument("--token", default="", help="a word that a client must know to come in")
    parser.add_argument("--keys", type=client_keys, metavar="DIR", help="lesson 15's, for servers that want them")
    parser.add_argument("--timeout", type=positive_seconds, default=1, help="seconds to wait for what is behind")
    for name, endpoint in (SERVERS | PUBLISHERS).items():
        parser.add_argument(f"--{name}", type=client_endpoint(endpoint), default=endpoint, help=f"default: {endpoint}")
    options = parser.parse_args()
    run_until_killed(serve(options))


if __name__ == "__main__":
    run(main)
