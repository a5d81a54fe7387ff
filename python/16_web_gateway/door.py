"""Lesson 16, the door: which browser may come in, and how much of it.

A browser lets every page connect to every WebSocket, also the page of a stranger to a gateway of this machine. All
that the browser does about it is to say whose page it is, as Origin: whoever does not look lets all of them in. Other
programs than browsers say what they like. Whom the Origin cannot keep out a token does.
"""

import contextlib
import hmac
import os
from collections.abc import Awaitable, Callable, Iterator

from aiohttp import web

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
