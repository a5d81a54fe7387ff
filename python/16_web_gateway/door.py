"""Lesson 16, the door: which browser may come in, and how much of it.

A browser lets every page connect to every WebSocket, also the page of a stranger to a gateway of this machine. All
that the browser does about it is to say whose page it is, as Origin: whoever does not look lets all of them in. Other
programs than browsers say what they like. Whom the Origin cannot keep out a token does.
Take home: this file.
"""

import hmac
from collections.abc import Iterator
from contextlib import contextmanager

LOOPBACK = ("127.0.0.1", "localhost")
# How many browsers may be here at the same time.
MOST = 1000


class Door:
    """Counts who is inside."""

    def __init__(self, origins: list[str], token: str) -> None:
        self.origins, self.token = origins, token
        self.inside = self.number = 0

    def open_at(self, host: str, port: int) -> None:
        """The gateway's own page may always come in, by the names that this machine has for itself."""
        names = LOOPBACK if host in LOOPBACK else (host,)
        self.origins += [f"http://{name}:{port}" for name in names]

    def refusal(self, origin: str | None, token: object) -> str:
        """Why not; nothing for those who may."""
        if origin is not None and origin not in self.origins:
            return f"the page of {origin[:80]!r} may not come in; if it is yours, start with --origin and its address"
        # Compared in the same time wherever they differ: a token cannot be found out letter by letter.
        if not hmac.compare_digest(str(token or "").encode(), self.token.encode()):
            return "the token is missing or wrong; it is what the gateway was given as --token"
        return f"{MOST} browsers are here already" if self.inside >= MOST else ""

    @contextmanager
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
