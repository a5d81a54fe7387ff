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
Started behind it: --hello 01_request_reply --background 04_background_client --poses 03_publish_subscribe
"""

import argparse
import asyncio
import contextlib
import os
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq.asyncio

try:
    from aiohttp import web
    from gateway_options import address, behind, keys, seconds

    from netmq_example.web import socketio as over_socketio
    from netmq_example.web import websocket as over_websocket
    from netmq_example.web.browser_socket import BrowserSocket, Listener, Requester, more_files
    from netmq_example.web.door import Door, listen
except ImportError as error:
    sys.exit(f"{error}: this lesson needs aiohttp and python-socketio; kit.py run 16 installs them")
except KeyboardInterrupt:
    # They take half a second.
    sys.exit()

ENDPOINT = "http://127.0.0.1:5566"
# Your own servers go here. A browser asks for a name: it must never choose an address of the network behind.
SERVERS = {"hello": "tcp://127.0.0.1:5551", "background": "tcp://127.0.0.1:5554"}
PUBLISHERS = {"poses": "tcp://127.0.0.1:5553", "pictures": "tcp://127.0.0.1:5555"}


async def serve(options: argparse.Namespace) -> None:
    """The page, WebSocket and Socket.IO on one port, and behind it one ZeroMQ socket for each browser."""
    more_files()
    context, door = zmq.asyncio.Context(), Door(options.origin, options.token)
    app = web.Application(middlewares=[door.look])
    if options.keys:
        # What a context is given, each new socket of it has.
        options.keys.apply(context)

    def opened(name: str) -> BrowserSocket:
        kind = Requester if name in SERVERS else Listener
        return kind(context, getattr(options, name), options.timeout)

    async def show(request: web.Request) -> web.StreamResponse:
        return web.FileResponse(Path(__file__).with_name("page.html"))

    app.router.add_get("/", show)
    over_websocket.attach(app, door, [*SERVERS, *PUBLISHERS], opened)
    over_socketio.attach(app, door, [*SERVERS, *PUBLISHERS], opened)
    door.open_at(*await listen(app, options.endpoint, options.token))
    while True:
        # In slices: on Windows Ctrl-C does not interrupt a longer wait.
        await asyncio.sleep(0.2)


# From here on all servers of this kit are the same, as far as they need it.


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=address, default=ENDPOINT, help="port 0 takes a free one")
    parser.add_argument(
        "--origin", action="append", default=[], help="a page that may come in, like http://localhost:80"
    )
    parser.add_argument("--token", default="", help="a word that whoever comes in must know")
    parser.add_argument("--keys", type=keys, metavar="DIR", help="lesson 15's, for servers that know their clients")
    parser.add_argument("--timeout", type=seconds, default=1, help="seconds to wait for what is behind")
    for name, endpoint in (SERVERS | PUBLISHERS).items():
        parser.add_argument(f"--{name}", type=behind, default=endpoint, metavar="ENDPOINT", help=f"default: {endpoint}")
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does. Both at once: a KeyboardInterrupt
    # may be caught within Socket.IO, and its tasks do not let themselves be cancelled for ten seconds and more.
    for each in (signal.SIGINT, getattr(signal, "SIGBREAK", signal.SIGTERM)):
        signal.signal(each, lambda *_: os._exit(0))
    # ZeroMQ's sockets are no files of Windows' own event loop.
    with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:
        runner.run(serve(options))


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
