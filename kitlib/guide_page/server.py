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
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, suppress
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from socketserver import ThreadingTCPServer
from typing import Any
from urllib.parse import parse_qs, urlsplit

from kitlib.commands.run import open_in_browser
from kitlib.docs import guide
from kitlib.files import put
from kitlib.guide_page import answers, pages, runs
from kitlib.lessons import ROOT, KitError, find, read_json
from kitlib.programs import MOST_LINES, heard
from kitlib.signals import uninterrupted
from kitlib.terminal import say

HTML, PLAIN, JSON = "text/html; charset=utf-8", "text/plain; charset=utf-8", "application/json"
Verdict = Callable[[Sequence[str]], Mapping[str, str | bool]]
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


class Guide(ThreadingTCPServer):
    """The server, and the runs that end with it.

    An HTTPServer would ask for this machine's name, which takes seconds on macOS, and share its port on Windows.
    """

    def __init__(self, folder: Path, leave: Path | None, answers: bool = True) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.folder, self.leave, self.answers = folder, leave, answers
        self.port, self.base = self.server_address[1], f"/{secrets.token_urlsafe(16)}/"
        self.stopping = False
        # 0: the lessons' own ports are for this guide.
        self.number = 1 + secrets.randbelow(9_999)

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
        if host not in (f"127.0.0.1:{self.server.port}", f"localhost:{self.server.port}"):
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
        if path not in pages.known() and name != "class":
            return self.answer(PLAIN, "the guide has no such page", 404)
        if path.suffix in TYPES:
            return self.answer(TYPES[path.suffix], path.read_bytes())
        done = read_json(self.server.folder / answers.TICKS)
        if name == "class":
            title, body = pages.class_list(self.server.folder, base, done)
        else:
            title, body = pages.page(path, base, function, self.server.answers)
        return self.answer(HTML, pages.whole(title, body, base, done))

    def do_POST(self) -> None:
        does = {"run": self.run, "own": self.own, "edit": self.edit, "tick": self.tick}
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
        """The reader's copy of a lesson's server, and where to change it; first saved if there is a text.

        What was saved elsewhere since the page loaded it is kept, and sent as `newer`.
        """
        lesson = find(wish["lesson"])
        path = answers.own_server(self.server.folder, lesson.key)
        if wish.get("again"):
            put(path, (lesson.python / "server.py").read_bytes())
        text = path.read_text(encoding="utf-8")
        newer = "text" in wish and text != wish["was"]
        if "text" in wish and not newer:
            text = str(wish["text"])
            put(path, text.encode())
        # From 1 on: where Python has stopped, or else where the reader begins.
        error, line = answers.mistake(path)
        at = line or text.count("\n", 0, text.rfind("Your own")) + 2
        found = {"path": str(path), "text": text, "at": at, "error": error, "newer": newer}
        self.answer(JSON, json.dumps(found))

    def tick(self, wish: dict[str, Any]) -> None:
        answers.tick(self.server.folder, find(wish["lesson"]).key, "ticked" if wish["done"] else "")
        self.answer(JSON, "{}")

    def run(self, wish: dict[str, Any]) -> None:
        """A command of a block of a page, with the reader's values."""
        page, step = (ROOT / wish["page"]).resolve(), int(wish["step"])
        blocks = list(guide.blocks(page))[int(wish["block"]) :] if page in guide.pages() else []
        steps = runs.steps(blocks[0], wish["values"]) if blocks else []
        if not 0 <= step < len(steps):
            raise KitError("this page has no such command: load it anew")
        words, shown = steps[step], runs.filled(blocks[0], wish["values"]).splitlines()[step]
        origin = f"http://{self.headers['Host']}" if wish["watch"] or "--watch" in words else ""
        arranged = runs.arranged(words, origin, self.server.leave, self.server.number)
        self.play(shown, ROOT, [arranged], lambda lines: guide.verdict(page, words, lines))

    def own(self, wish: dict[str, Any]) -> None:
        """The reader's own server with a client of these options, or with each that its exercise wants."""
        lesson, folder = find(wish["lesson"]), self.server.folder
        path, exercise = answers.own_server(folder, lesson.key), answers.exercises().get(lesson.key)
        check = exercise.check if exercise and wish["check"] else []
        options = check or [str(wish["options"])]
        if not all(each.isprintable() and not runs.ELSEWHERE.search(each) for each in options):
            raise KitError("here a client takes its own options alone, such as --count 3")
        words = ["run", str(path), *runs.apart(lesson, secrets.randbelow(10_000)), "--client", "python"]
        words += ["--folder", str(path.parent), *([] if check else ["--reload"])]
        shown = "; ".join(f'python3 kit.py run {path} --options="{each}"' for each in options)
        steps = [[*words, f"--options={each}"] for each in options]
        self.play(
            shown, path.parent, steps, lambda lines: exercise.verdict(folder, lines) if exercise and check else {}
        )

    def play(self, shown: str, folder: Path, steps: list[list[str]], verdict: Verdict) -> None:
        """Run commands one after the other while the page listens, and tell what they print and a verdict on it."""
        # A page that is busy may read slowly.
        self.connection.settimeout(10)
        self.answer("application/x-ndjson", None)
        self.tell({"command": shown})
        lines: deque[str] = deque(maxlen=MOST_LINES)
        for words in steps:
            with closing(heard([sys.executable, str(ROOT / "kit.py"), *words], folder, self.listens)) as said:
                for line in said:
                    lines.append(line)
                    self.tell(runs.spoken(words[0], line))
                    if line == runs.STAYS:
                        self.tell(verdict(lines))
        self.tell(verdict(lines))

    def tell(self, news: Mapping[str, str | bool]) -> None:
        self.wfile.write(f"{json.dumps(news)}\n".encode())

    def listens(self) -> bool:
        # The browser sends nothing more: what can be read is the end of the connection, by Stop or a closed tab.
        there, _, _ = select.select([self.connection], [], [], 0)
        return not self.server.stopping and not (there and not self.connection.recv(1, socket.MSG_PEEK))


def serve(folder: Path, leave: Path | None, answers: bool) -> int:
    """Until Ctrl-C. The programs of the pages leave their files in `leave`, or else where `kit.py run` has them."""
    server = Guide(folder, leave, answers)
    address = f"http://127.0.0.1:{server.port}{server.base}"
    say(f"your answers are kept in {folder}")
    say(f"{'opening' if open_in_browser(address) else 'open'} {address} in a browser; Ctrl-C ends it")
    # A shell's & has Ctrl-C ignored, also by all programs that are started here, which end by it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with socket.socket(type=socket.SOCK_DGRAM) as first, suppress(KeyboardInterrupt):
        with suppress(OSError):
            first.bind(("127.0.0.1", runs.FIRST))
            server.number = 0
        server.serve_forever(0.2)
    with uninterrupted():
        server.stopping = True
        server.server_close()
    return 0
