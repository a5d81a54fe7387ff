"""Serves the guide to the browser of this machine, until Ctrl-C.

It listens on the loopback alone, and every address begins with a token that only the reader's terminal has shown. A
page of a stranger's does not know it, and would be refused by its Origin, or by a Host that leads here by a trick.
"""

import hmac
import json
import re
import secrets
import select
import signal
import socket
import sys
from collections.abc import Callable
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from kitlib.commands.run import open_in_browser
from kitlib.docs import guide
from kitlib.files import put
from kitlib.guide_page import answers, pages, runs
from kitlib.lessons import ROOT, KitError, find
from kitlib.signals import uninterrupted
from kitlib.terminal import say

HTML, PLAIN, JSON = "text/html; charset=utf-8", "text/plain; charset=utf-8", "application/json"
TYPES = {".svg": "image/svg+xml", ".png": "image/png", ".gif": "image/gif"}
TYPES |= {".css": "text/css", ".js": "text/javascript"}
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:;"
    " connect-src 'self'; frame-src http://127.0.0.1:*; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}


class Guide(ThreadingHTTPServer):
    """The server, and the runs that end with it."""

    # Its end waits for them.
    daemon_threads = False

    def __init__(self, folder: Path, leave: Path | None) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.folder, self.leave, self.base = folder, leave, f"/{secrets.token_urlsafe(16)}/"
        self.stopping = False

    def handle_error(self, *about: Any) -> None:
        """A browser that has closed a tab is no mistake."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(*about)


class Handler(BaseHTTPRequestHandler):
    server: Guide
    # Seconds. A connection that a browser opens in advance asks nothing, and is waited for at the end.
    timeout = 2

    def log_message(self, *_: Any) -> None:
        """The terminal is for what a reader must see."""

    def refusal(self) -> str:
        """Why this request has no place here; an empty text if it has one."""
        host = self.headers.get("Host", "")
        if host not in (f"127.0.0.1:{self.server.server_port}", f"localhost:{self.server.server_port}"):
            return "only for this machine: open it by 127.0.0.1"
        # With each POST a browser names the page that sends it.
        if self.headers.get("Origin", "" if self.command == "POST" else f"http://{host}") != f"http://{host}":
            return "only for the pages of this guide"
        if not hmac.compare_digest(self.path[: len(self.server.base)].encode(), self.server.base.encode()):
            return "open the address that `kit.py guide` has printed"
        return ""

    def answer(self, kind: str, text: str | bytes | None, code: int = 200, **more: str) -> None:
        """Without a text, what follows is written line by line."""
        self.send_response(code)
        for name, value in {**HEADERS, "Content-Type": kind, **more}.items():
            self.send_header(name, value)
        self.end_headers()
        if text is not None:
            self.wfile.write(text if isinstance(text, bytes) else text.encode())

    def do_GET(self) -> None:
        if why := self.refusal():
            return self.answer(PLAIN, why, 403)
        base, address = self.server.base, urlsplit(self.path)
        name, function = address.path.removeprefix(base), parse_qs(address.query).get("name", [""])[0]
        path = (ROOT / name).resolve()
        if not name:
            return self.answer(PLAIN, "", 302, Location=f"{base}docs/guide/start_here.md")
        if name == "search.json":
            return self.answer(JSON, pages.search())
        if name == "class":
            return self.answer(HTML, pages.class_list(self.server.folder, base))
        if path not in pages.known():
            return self.answer(PLAIN, "the guide has no such page", 404)
        if path.suffix in TYPES:
            return self.answer(TYPES[path.suffix], path.read_bytes())
        return self.answer(HTML, pages.page(path, base, function))

    def do_POST(self) -> None:
        does = {"run": self.run, "try": self.attempt, "edit": self.edit, "tick": self.tick}
        action = does.get(self.path.removeprefix(self.server.base))
        # Less than a megabyte.
        size = re.fullmatch(r"[0-9]{1,6}", self.headers.get("Content-Length", ""))
        if (why := self.refusal()) or not action or not size:
            return self.answer(PLAIN, why or "the guide does nothing of that: load the page anew", 403)
        try:
            action(json.loads(self.rfile.read(int(size[0]))))
        except (KitError, OSError) as error:
            self.answer(PLAIN, str(error), 400)
        except UnicodeError as error:
            self.answer(PLAIN, f"this is not UTF-8 ({error}): save it as UTF-8 in your editor", 400)
        except (ValueError, LookupError, TypeError, AttributeError) as error:
            self.answer(PLAIN, f"the guide does not understand the page ({error}): load it anew", 400)
        return None

    def edit(self, wish: dict[str, Any]) -> None:
        """The reader's copy of a lesson's server, first saved if there is a text, and where to change it."""
        path = answers.own_server(self.server.folder, find(wish["lesson"]).key)
        if "text" in wish:
            put(path, str(wish["text"]).encode())
        text = path.read_text(encoding="utf-8")
        at = max(0, text.rfind("\ndef ", 0, max(text.find("Your own"), 0)) + 1)
        self.answer(JSON, json.dumps({"path": str(path), "text": text, "at": at, "error": answers.mistake(path)}))

    def tick(self, wish: dict[str, Any]) -> None:
        answers.tick(self.server.folder, find(wish["lesson"]).key, "ticked" if wish["done"] else "")
        self.answer(JSON, "{}")

    def run(self, wish: dict[str, Any]) -> None:
        """A block of a page, with the reader's values."""
        page = (ROOT / wish["page"]).resolve()
        blocks = list(guide.blocks(page)) if page in guide.pages() else []
        steps = [each for block in blocks[int(wish["block"]) :][:1] for each in runs.steps(block, wish["values"])]
        if not steps:
            raise KitError("this page has no such command: load it anew")
        origin = f"http://{self.headers['Host']}" if wish["watch"] or "--watch" in steps[0] else ""
        arranged = [runs.arranged(words, origin, self.server.leave) for words in steps]
        self.play(arranged, ROOT, lambda play: play.tell({"verdict": runs.verdict(page, steps[-1], play.lines)}))

    def attempt(self, wish: dict[str, Any]) -> None:
        """The reader's own server and a client; or, to check an exercise, the client that this takes."""
        lesson, folder = find(wish["lesson"]), self.server.folder
        path, check = answers.own_server(folder, lesson.key), answers.exercises()[lesson.key] if wish["check"] else None
        server = ["server", str(path), *([] if check else ["--reload"]), "--", *runs.place(lesson)]
        client = ["client", lesson.key, "--client", "python", "--folder", str(path.parent)]

        def done(play: runs.Play) -> None:
            if check and (missing := check.missing(play.code, play.lines)):
                play.tell({"verdict": missing})
            elif check:
                answers.tick(folder, lesson.key, "checked")
                play.tell({"verdict": "done", "passed": True})

        self.play([server, *([*client, *each] for each in (check.check if check else [[]]))], path.parent, done)

    def play(self, steps: list[list[str]], folder: Path, done: Callable[[runs.Play], None]) -> None:
        def send(news: list[dict[str, Any]]) -> None:
            self.wfile.write("".join(f"{json.dumps(each)}\n" for each in news).encode())

        def listens() -> bool:
            # The browser sends nothing more: what can be read is the end of the connection, by Stop or a closed tab.
            there, _, _ = select.select([self.connection], [], [], 0)
            return not self.server.stopping and not (there and not self.connection.recv(1, socket.MSG_PEEK))

        # A page that is busy may read slowly.
        self.connection.settimeout(10)
        self.answer("application/x-ndjson", None)
        runs.Play(steps, folder, send, done).all(listens)


def serve(folder: Path, leave: Path | None) -> int:
    """Until Ctrl-C. The programs of the pages leave their files in `leave`, or else where `kit.py run` has them."""
    server = Guide(folder, leave)
    address = f"http://127.0.0.1:{server.server_port}{server.base}"
    say(f"your answers are kept in {folder}")
    say(f"{'opening' if open_in_browser(address) else 'open'} {address} in a browser; Ctrl-C ends it")
    # A shell's & has Ctrl-C ignored, also by all programs that are started here, which end by it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with suppress(KeyboardInterrupt):
        server.serve_forever(0.2)
    with uninterrupted():
        server.stopping = True
        server.server_close()
    return 0
