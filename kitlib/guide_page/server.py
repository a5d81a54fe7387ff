"""Serves the guide to the browser of this machine, until Ctrl-C.

It listens on the loopback alone, and every address begins with a token that only the reader's terminal has shown. A
page of a stranger's does not know it, and would be refused by its Origin, or by a Host that leads here by a trick.
"""

import argparse
import hmac
import json
import secrets
import select
import socket
import sys
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit

from kitlib.commands import guarded
from kitlib.commands.run import open_in_browser
from kitlib.guide_page import answers, pages, runs
from kitlib.lessons import ROOT, KitError, find
from kitlib.terminal import say

START = "docs/guide/start_here.md"
HTML, PLAIN, JSON = "text/html; charset=utf-8", "text/plain; charset=utf-8", "application/json"
TYPES = {".svg": "image/svg+xml", ".png": "image/png", ".gif": "image/gif"}
MOST_BYTES = 1_000_000
# So long a run that was told to end is waited for, at the end of the server.
LAST_SECONDS = 20
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self';"
    " connect-src 'self'; frame-src http://127.0.0.1:*; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class Guide(ThreadingHTTPServer):
    """The server, and the runs that end with it."""

    daemon_threads = True

    def __init__(self, options: argparse.Namespace) -> None:
        super().__init__(("127.0.0.1", options.port), Handler)
        self.folder: Path = options.folder
        self.leave: Path | None = options.leave
        self.port = int(self.server_address[1])
        self.base = f"/{secrets.token_urlsafe(16)}/"
        self.stopping = threading.Event()
        self.playing: set[threading.Thread] = set()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that has closed a tab is no mistake."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)

    def end(self) -> None:
        self.stopping.set()
        for thread in list(self.playing):
            thread.join(LAST_SECONDS)
        self.server_close()


class Handler(BaseHTTPRequestHandler):
    server: Guide
    # A connection that a browser has opened in advance asks nothing.
    timeout = 30

    def log_message(self, *_: Any) -> None:
        """The terminal is for what a reader must see."""

    def refusal(self) -> str:
        """Why this request has no place here; an empty text if it has one."""
        hosts = [f"{name}:{self.server.port}" for name in ("127.0.0.1", "localhost")]
        host = self.headers.get("Host", "")
        if host not in hosts:
            return f"only for this machine: open it by {hosts[0]}"
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
        name, asked = unquote(address.path).removeprefix(base), dict(parse_qs(address.query))
        path = (ROOT / name).resolve()
        if not name:
            return self.answer(PLAIN, "", 302, Location=base + START)
        if name == "page.css":
            return self.answer("text/css; charset=utf-8", pages.style())
        if name == "page.js":
            return self.answer("text/javascript; charset=utf-8", (pages.HERE / name).read_bytes())
        if name == "search.json":
            return self.answer(JSON, pages.search())
        if name == "class":
            return self.answer(HTML, pages.whole("Class list", answers.class_list(self.server.folder), base))
        if path not in pages.known():
            return self.answer(PLAIN, "the guide has no such page", 404)
        if path.suffix in TYPES:
            return self.answer(TYPES[path.suffix], path.read_bytes())
        return self.answer(HTML, pages.page(path, base, asked.get("name", [""])[0]))

    def do_POST(self) -> None:
        does = {"run": self.run, "hints": self.hints, "try": self.attempt, "edit": self.edit, "tick": self.tick}
        size = int(self.headers.get("Content-Length") or 0)
        action = does.get(self.path.removeprefix(self.server.base))
        if why := self.refusal() or ("it is too long, or nothing that the guide does" * (size > MOST_BYTES or not action)):
            return self.answer(PLAIN, why, 403)
        try:
            wish = json.loads(self.rfile.read(size))
            if action and (told := action(wish)) is not None:
                self.answer(JSON, json.dumps(told))
        except KitError as error:
            self.answer(PLAIN, str(error), 400)
        return None

    def edit(self, wish: dict[str, Any]) -> dict[str, object]:
        """The reader's copy of a lesson's server; first saved, if there is a text."""
        path = answers.own_server(self.server.folder, find(str(wish["lesson"])).key)
        error = answers.saved(path, str(wish["text"])) if "text" in wish else ""
        return {**answers.opened(path), "error": error}

    def tick(self, wish: dict[str, Any]) -> dict[str, object]:
        answers.tick(self.server.folder, find(str(wish["lesson"])).key, answers.BY_HAND if wish["done"] else "")
        return {}

    def hints(self, wish: dict[str, Any]) -> dict[str, str]:
        return runs.hints(runs.block_of((ROOT / str(wish["page"])).resolve(), int(wish["block"])))

    def run(self, wish: dict[str, Any]) -> None:
        """A block of a page, with the reader's values."""
        page = (ROOT / str(wish["page"])).resolve()
        values = {str(place): str(value) for place, value in dict(wish["values"]).items()}
        steps = runs.steps(runs.block_of(page, int(wish["block"])), values)
        watch = wish["watch"] or "--watch" in steps[0]
        origin = f"http://{self.headers['Host']}" if watch else ""
        arranged = [runs.arranged(words, origin, self.server.leave) for words in steps]
        play = self.play(ROOT)
        self.perform(play, arranged, lambda: play.tell({"verdict": runs.verdict(page, steps[-1], play.lines)}))

    def attempt(self, wish: dict[str, Any]) -> None:
        """The reader's own server and a client; or, to check an exercise, the client that this takes."""
        lesson = find(str(wish["lesson"]))
        path, exercise = answers.own_server(self.server.folder, lesson.key), answers.exercise(lesson.key)
        check = exercise if wish["check"] else None
        endpoint = ["--endpoint", lesson.anywhere] if runs.taken(lesson.port) else []
        server = ["server", str(path), *([] if check else ["--reload"]), "--", *endpoint]
        client = ["client", lesson.key, "--client", "python", "--folder", str(path.parent)]
        play = self.play(path.parent)

        def done() -> None:
            if check:
                passed = check.passed(play.code, play.lines)
                if passed:
                    answers.tick(self.server.folder, lesson.key, answers.CHECKED)
                play.tell({"passed": passed, "verdict": "done" if passed else f"not yet: {check.text}"})

        self.perform(play, [server, [*client, *(check.check if check else [])]], done)

    def play(self, folder: Path) -> runs.Play:
        def tell(news: dict[str, Any]) -> None:
            self.wfile.write(f"{json.dumps(news)}\n".encode())

        def listens() -> bool:
            # The browser sends nothing more: what can be read is the end of the connection, by Stop or a closed tab.
            there, _, _ = select.select([self.connection], [], [], 0)
            return not self.server.stopping.is_set() and not (there and not self.connection.recv(1, socket.MSG_PEEK))

        return runs.Play(tell, listens, folder)

    def perform(self, play: runs.Play, steps: list[list[str]], done: Any) -> None:
        self.answer("application/x-ndjson", None)
        thread = threading.current_thread()
        self.server.playing.add(thread)
        try:
            play.all(steps, done)
        finally:
            self.server.playing.discard(thread)


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--leave", type=Path)
    parser.add_argument("--port", type=int, default=0)
    options = parser.parse_args()
    try:
        server = Guide(options)
    except OSError as error:
        raise KitError(f"cannot listen on port {options.port}: {error.strerror}; --port 0 takes a free one") from None
    say(f"your answers are kept in {options.folder}")
    address = f"http://127.0.0.1:{server.port}{server.base}"
    say(f"{'opening' if open_in_browser(address) else 'open'} {address} in a browser; Ctrl-C ends it")
    try:
        server.serve_forever(0.2)
    except KeyboardInterrupt:
        pass
    finally:
        server.end()
    return 0


if __name__ == "__main__":
    sys.exit(guarded(main))
