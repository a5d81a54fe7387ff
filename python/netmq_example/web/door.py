"""The gateway's door: where it listens, which browsers may come in, and which connections it closes.

    async def serve():
        door = Door(origins=["http://localhost:8000"], token="word")
        app = web.Application(middlewares=[door.look])
        await door.open(app, "http://127.0.0.1:5566")            logs: listening on http://127.0.0.1:5566

A browser lets every page connect to every WebSocket, also the page of a stranger to a gateway of this machine. All
that the browser does about it is to name the page, as Origin: a server that does not look lets all of them in. Other
programs than browsers name what they like, and need a token to keep them out.

To connect costs a stranger nothing, and each connection is one of the open files that a system allows: thousands of
them keep all others out. So a request must be there, and be whole, in time.
"""

import asyncio
import contextlib
import errno
import hmac
import logging
import os
import time
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

from aiohttp import web

from netmq_example import arguments, check
from netmq_example.program import IN_USE, cannot_listen, more_files

LOOPBACK = ("127.0.0.1", "localhost")
EVERYWHERE = ("0.0.0.0", "*")
# How many browsers may be here at the same time. Python waits for at most 512 sockets on Windows, and each has two.
MOST_BROWSERS = 200 if os.name == "nt" else 1000
# So many pages of strangers are named: no stranger floods the log.
MOST_NAMED = 20
# Until a request must be there, and how long a connection may rest after an answer.
SILENT_SECONDS = 10
REST_SECONDS = 75
EXAMPLE = "http://127.0.0.1:5566"

log = logging.getLogger("netmq_example.server")


class Door:
    """Which browsers may come in, and how many are here."""

    def __init__(self, origins: list[str], token: str) -> None:
        """`origins` are pages from elsewhere that may come in; without a word as `token` nobody needs one."""
        self.origins = [arguments.text("each origin", origin) for origin in check.instance("origins", origins, list)]
        self.token: str = check.instance("token", token, str)
        self.inside = 0
        self.number = 0
        self.everywhere = False
        self.named: set[str] = set()

    async def open(self, app: web.Application, endpoint: str) -> None:
        """Listen, for ever. The gateway's own page may come in, by the names that this machine has for itself."""
        more_files()
        host, port = await listen(app, endpoint, self.token)
        names = LOOPBACK if host in LOOPBACK else (host,)
        self.origins += [f"http://{name}:{port}" for name in names]
        self.everywhere = host in EVERYWHERE
        while True:
            # In slices: on Windows Ctrl-C does not interrupt a longer wait.
            await asyncio.sleep(0.2)

    @web.middleware
    async def look(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        """Refuse the pages of strangers, and clients that would be refused without a word, before all else."""
        why = self.unfit(request)
        if not why:
            return await handler(request)
        if why not in self.named and len(self.named) < MOST_NAMED:
            self.named.add(why)
            log.warning("refused: %s", why)
        return refused(403, why)

    def unfit(self, request: web.Request) -> str:
        """Why a request has no place here; an empty text if it has one."""
        origin = request.headers.get("Origin")
        # There this machine has more names than it knows: its own page comes from the one that it asks for. So would
        # a page of a stranger who gives this machine's number to a name of his own; he does not know the token.
        own_page = f"http://{request.host}" if self.everywhere else None
        if origin is not None and origin not in (own_page, *self.origins):
            return f"the page of {origin[:80]!r} may not come in; if it is yours, start with --origin and its address"
        if request.path == "/socket.io/" and request.query.get("EIO") in ("1", "2", "3"):
            return "a client of Socket.IO 2 or older may not come in: version 3 or later is needed (EIO=4)"
        return ""

    def refusal(self, token: object) -> str:
        """Why this token does not let in; an empty text if it does."""
        # Compared in the same time wherever they differ: a token cannot be found out letter by letter.
        if not hmac.compare_digest(str(token or "").encode(errors="replace"), self.token.encode(errors="replace")):
            return "the token is missing or wrong; it is what the gateway was given as --token"
        return ""

    def full(self) -> str:
        """Why even a browser with the token has to wait; an empty text if it need not."""
        return f"{MOST_BROWSERS} browsers are here already; try again later" if self.inside >= MOST_BROWSERS else ""

    @contextlib.contextmanager
    def entered(self, how: str) -> Iterator[None]:
        """For as long as a browser is here."""
        self.inside += 1
        self.number += 1
        number = self.number
        log.info("browser %s came by %s", number, how)
        try:
            yield
        finally:
            self.inside -= 1
            log.info("browser %s left", number)


def refused(status: int, why: str) -> web.Response:
    """With the header without which a browser keeps the reason from a page that is not the gateway's own."""
    return web.Response(status=status, text=why, headers={"Access-Control-Allow-Origin": "*"})


class Silence:
    """Closes connections that ask nothing, or half of something. It knows the last request of each."""

    watching: asyncio.Task[None]

    def __init__(self) -> None:
        self.asked: dict[object, web.Request] = {}

    @web.middleware
    async def hear(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        """Its head is there. Its body may still be on its way."""
        self.asked[request.protocol] = request
        return await handler(request)

    async def watch(self, server: web.Server) -> None:
        """Once a second, so that a thousand strangers at once are one line."""
        since: dict[web.RequestHandler, float] = {}
        while True:
            now = time.monotonic()
            here = server.connections
            self.asked = {each: self.asked[each] for each in here if each in self.asked}
            whole = {each for each, request in self.asked.items() if request.content.is_eof()}
            since = {each: since.get(each, now) for each in here if each.transport and each not in whole}
            silent = [each for each, then in since.items() if now - then > SILENT_SECONDS]
            for each in silent:
                each.force_close()
            if silent:
                log.warning("let go, since they asked nothing within %s s: %s", SILENT_SECONDS, len(silent))
            await asyncio.sleep(1)


async def close_strangers(sockets: dict[str, Any], inside: Callable[[], set[str]]) -> None:
    """Closes the connections of Socket.IO that answer its pings, and never ask to come in."""
    before: set[str] = set()
    while True:
        outside = set(sockets) - inside()
        silent = before & outside
        if silent:
            log.warning("let go, since they did not ask to come in within %s s: %s", SILENT_SECONDS, len(silent))
        for name in silent:
            socket = sockets.pop(name)
            await socket.close(wait=False, abort=True)
            # It ends what writes to a WebSocket, and so, from python-engineio 4.6 on, the WebSocket.
            await socket.queue.put(None)
        before = outside
        await asyncio.sleep(SILENT_SECONDS)


async def listen(app: web.Application, endpoint: str, token: str) -> tuple[str, int]:
    """The host and the port at which this gateway is now. ListenError: it cannot; ValueError: no such host."""
    host, _, port = check.endpoint(endpoint, EXAMPLE, lowest_port=0).removeprefix("http://").rpartition(":")
    silence = Silence()
    # Before the door: a connection that is refused has asked.
    app.middlewares.insert(0, silence.hear)
    # A request that unpacks to a thousand times its size would be unpacked before it is asked who sent it.
    runner = web.AppRunner(app, access_log=None, keepalive_timeout=REST_SECONDS, auto_decompress=False)
    await runner.setup()
    assert runner.server
    try:
        if host not in LOOPBACK and not token:
            raise OSError(None, "everybody in the network could come in; give --token, a word that they must know")
        await web.TCPSite(runner, host, int(port.replace("*", "0"))).start()
    except UnicodeError:
        # A part of a host's name has 63 characters at most.
        raise ValueError(f"bad endpoint '{endpoint}': write it like {EXAMPLE}") from None
    except OSError as error:
        why = os.strerror(error.errno) if error.errno and error.errno > 0 else error.strerror
        cure = "try --endpoint http://127.0.0.1:0, which takes a free port"
        if error.errno == errno.EADDRINUSE:
            cure = f"{IN_USE}, or {cure}"
        raise cannot_listen(endpoint, error, cure, why) from None
    silence.watching = asyncio.create_task(silence.watch(runner.server))
    bound = runner.addresses[0][1]
    log.info("listening on http://%s:%s", host, bound)
    return host, bound
