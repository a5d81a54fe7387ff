"""Lesson 16, the gateway's port: where it listens, and who connects there and says nothing.

To connect costs a stranger nothing, and each connection is one of the open files that a system allows: whoever holds
thousands of them keeps all others out. So a request has a time to be there, and to be whole.

Lesson 16, the door: which browser may come in, and how much of it.

A browser lets every page connect to every WebSocket, also the page of a stranger to a gateway of this machine. All
that the browser does about it is to say whose page it is, as Origin: whoever does not look lets all of them in. Other
programs than browsers say what they like. Whom the Origin cannot keep out a token does.
"""

import asyncio
import contextlib
import hmac
import logging
import os
import sys
import time
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

from aiohttp import web
from aiohttp.http import HttpProcessingError

LOOPBACK, EVERYWHERE = ("127.0.0.1", "localhost"), ("0.0.0.0", "*")
# How many browsers may be here at the same time. Python waits for at most 512 sockets on Windows, and each has two.
MOST = 200 if os.name == "nt" else 1000
# So many pages of strangers are named: no stranger floods the log.
NAMED = 20


class Door:
    """Counts who is inside."""

    def __init__(self, origins: list[str], token: str) -> None:
        self.origins, self.token = origins, token
        self.inside = self.number = 0
        self.everywhere, self.named = False, set[str]()

    def open_at(self, host: str, port: int) -> None:
        """The gateway's own page may always come in, by the names that this machine has for itself."""
        names = LOOPBACK if host in LOOPBACK else (host,)
        self.origins += [f"http://{name}:{port}" for name in names]
        self.everywhere = host in EVERYWHERE

    @web.middleware
    async def look(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        """Before all else: whose page is it?"""
        origin = request.headers.get("Origin")
        # There this machine has more names than it knows: its own page comes from the one that it asks for. So would
        # a page of a stranger who gives this machine's number to a name of his own; he does not know the token.
        own = f"http://{request.host}" if self.everywhere else None
        if origin is None or origin == own or origin in self.origins:
            return await handler(request)
        why = f"the page of {origin[:80]!r} may not come in; if it is yours, start with --origin and its address"
        if why not in self.named and len(self.named) < NAMED:
            self.named.add(why)
            print(f"refused: {why}", flush=True)
        return refused(403, why)

    def refusal(self, token: object) -> str:
        """Why not; nothing for those who may."""
        # Compared in the same time wherever they differ: a token cannot be found out letter by letter.
        if not hmac.compare_digest(str(token or "").encode(errors="replace"), self.token.encode(errors="replace")):
            return "the token is missing or wrong; it is what the gateway was given as --token"
        return ""

    def full(self) -> str:
        """Whoever may come in may have to wait."""
        return f"{MOST} browsers are here already; try again later" if self.inside >= MOST else ""

    @contextlib.contextmanager
    def entered(self, how: str) -> Iterator[None]:
        """For as long as a browser is here."""
        self.inside, self.number = self.inside + 1, self.number + 1
        number = self.number
        print(f"browser {number} came by {how}", flush=True)
        try:
            yield
        finally:
            self.inside -= 1
            print(f"browser {number} left", flush=True)


def refused(status: int, why: str) -> web.Response:
    """With the header without which a browser keeps the reason from a page that is not the gateway's own."""
    return web.Response(status=status, text=why, headers={"Access-Control-Allow-Origin": "*"})


# Seconds until a request must be there, and seconds that a connection may rest after an answer.
SILENT, REST = 10, 75


class Silence:
    """Knows the last request of each connection."""

    watching: asyncio.Task[None]

    def __init__(self) -> None:
        self.asked = dict[object, web.Request]()

    @web.middleware
    async def hear(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        """Its head is there. Its body may still be on its way."""
        self.asked[request.protocol] = request
        return await handler(request)

    async def watch(self, server: web.Server) -> None:
        """Once a second, so that a thousand strangers at once are one line."""
        since = dict[web.RequestHandler, float]()
        while True:
            now, here = time.monotonic(), server.connections
            self.asked = {each: self.asked[each] for each in here if each in self.asked}
            whole = {each for each, request in self.asked.items() if request.content.is_eof()}
            since = {each: since.get(each, now) for each in here if each.transport and each not in whole}
            silent = [each for each, then in since.items() if now - then > SILENT]
            for each in silent:
                each.force_close()
            if silent:
                print(f"let go, since they asked nothing within {SILENT} s: {len(silent)}", flush=True)
            await asyncio.sleep(1)


async def let_go(sockets: dict[str, Any], inside: Callable[[], set[str]]) -> None:
    """Who has opened a connection of Socket.IO's, answers its pings, and never asks to come in."""
    before = set[str]()
    while True:
        outside = set(sockets) - inside()
        for name in before & outside:
            print(f"let go, since it did not ask to come in within {SILENT} s", flush=True)
            socket = sockets.pop(name)
            await socket.close(wait=False, abort=True)
            # It ends what writes to a WebSocket, and so, from python-engineio 4.6 on, the WebSocket.
            await socket.queue.put(None)
        before = outside
        await asyncio.sleep(SILENT)


async def listen(app: web.Application, endpoint: str, token: str) -> tuple[str, int]:
    """The host and the port at which this gateway is now."""
    host, port = endpoint.removeprefix("http://").rsplit(":", 1)
    # Our own mistakes it may print; not the noise of a stranger who does not speak HTTP.
    logging.getLogger("aiohttp.server").addFilter(our_own)
    silence = Silence()
    # Before the door: whoever is refused has asked.
    app.middlewares.insert(0, silence.hear)
    runner = web.AppRunner(app, access_log=None, keepalive_timeout=REST)
    await runner.setup()
    assert runner.server
    try:
        if host not in LOOPBACK and not token:
            raise OSError(None, "everybody in the network could come in; give --token, a word that they must know")
        await web.TCPSite(runner, host, int(port.replace("*", "0"))).start()
    except OSError as error:
        why = os.strerror(error.errno) if error.errno and error.errno > 0 else error.strerror
        sys.exit(f"cannot listen on {endpoint}: {why}; try --endpoint http://127.0.0.1:0, which takes a free port")
    silence.watching = asyncio.create_task(silence.watch(runner.server))
    port = runner.addresses[0][1]
    print(f"listening on http://{host}:{port}", flush=True)
    return host, port


def our_own(said: logging.LogRecord) -> bool:
    """Strangers speak no HTTP, leave in the midst of a word, or send Engine.IO's empty packet."""
    error = said.exc_info[1] if said.exc_info else None
    return not isinstance(error, HttpProcessingError | ConnectionError) and "empty packet" not in str(error)
