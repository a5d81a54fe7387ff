"""Lesson 16, the door: which browser may come in, and how much of it.

A browser lets every page connect to every WebSocket, also the page of a stranger to a gateway of this machine. All
that the browser does about it is to say whose page it is, as Origin: whoever does not look lets all of them in. Other
programs than browsers say what they like. Whom the Origin cannot keep out a token does.
Take home: this file.
"""

import argparse
import contextlib
import hmac
import logging
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from aiohttp import web
from aiohttp.http import HttpProcessingError

LOOPBACK = ("127.0.0.1", "localhost")
# How many browsers may be here at the same time. Python waits for at most 512 sockets on Windows, and each has two.
MOST = 200 if os.name == "nt" else 1000


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


async def listen(app: web.Application, endpoint: str, token: str) -> tuple[str, int]:
    """The host and the port at which this gateway is now."""
    host, port = endpoint.removeprefix("http://").rsplit(":", 1)
    # Our own mistakes it may print; not the noise of a stranger who does not speak HTTP.
    logging.getLogger("aiohttp.server").addFilter(our_own)
    runner = web.AppRunner(app, access_log=None)
    await runner.setup()
    try:
        if host not in LOOPBACK and not token:
            raise OSError(None, "everybody in the network could come in; give --token, a word that they must know")
        await web.TCPSite(runner, host, int(port.replace("*", "0"))).start()
    except OSError as error:
        why = os.strerror(error.errno) if error.errno and error.errno > 0 else error.strerror
        sys.exit(f"cannot listen on {endpoint}: {why}; try --endpoint http://127.0.0.1:0, which takes a free port")
    port = runner.addresses[0][1]
    print(f"listening on http://{host}:{port}", flush=True)
    return host, port


def our_own(said: logging.LogRecord) -> bool:
    """Strangers speak no HTTP, leave in the midst of a word, or send Engine.IO's empty packet."""
    error = said.exc_info[1] if said.exc_info else None
    return not isinstance(error, HttpProcessingError | ConnectionError) and "empty packet" not in str(error)


def address(text: str) -> str:
    """Where browsers come to."""
    port = re.fullmatch(r"http://[\w*-]{1,63}(?:\.[\w-]{1,63})*:(\*|\d{1,5})", text, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like http://127.0.0.1:5566, port 0 to 65535")
    return text


def behind(text: str) -> str:
    """A server behind the gateway; libzmq itself takes port 99999 without a word, and waits."""
    port = re.fullmatch(r"tcp://[\w.-]+:(\d{1,5})", text, re.ASCII)
    if not port or not 0 < int(port[1]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5551")
    return text


def keys(folder: str) -> Any:
    """Lesson 15's ClientKeys: a gateway is one client, whoever comes through it."""
    # In its own lesson's folder; at home it lies beside this file.
    sys.path.append(str(Path(__file__).resolve().parents[1] / "15_security"))
    from secure_requester import ClientKeys

    try:
        return ClientKeys(Path(folder))
    except (ValueError, OSError) as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def seconds(text: str) -> float:
    if not 0.001 <= float(text) < 86_400:
        raise ValueError
    return float(text)
