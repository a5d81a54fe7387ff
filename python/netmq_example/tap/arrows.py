"""Lesson 16, a recording: the tap's page with the messages inside, one file that opens without a server.

What a peer sent is in it as letters and digits only (gzip, base64), so nothing of it can become a part of the page.

Lesson 16, the arrows of the picture: what the tap has seen last, numbered, as much as fits.

Whoever sees a message adds it here, which costs little; what it looks like in a page is worked out when a page asks.
The oldest go first. A page that cannot follow gets the newest, and the numbers tell it what it has missed.
"""

import argparse
import base64
import gzip
import json
import sys
import threading
import time
from collections import Counter, deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from netmq_example.tap.zmtp import Piece

# So many arrows, and bytes of all their messages together, are kept.
MOST, MOST_BYTES = 2000, 32 * 1024 * 1024
# What a page gets of each frame, and when somebody opens the arrow.
PREVIEW, WHOLE = 1024, 4 * 1024 * 1024


@dataclass(slots=True)
class Arrow:
    """One message or command on its way `up` to the server or `down`; or, without a piece, what happened otherwise."""

    number: int
    seconds: float
    link: int
    way: str
    piece: Piece | None
    text: str

    def as_json(self, most: int = PREVIEW) -> dict[str, Any]:
        frames = [self.piece.raw[each] for each in self.piece.bounds] if self.piece else []
        return {
            "number": self.number,
            "seconds": round(self.seconds, 6),
            "link": self.link,
            "way": self.way,
            "command": bool(self.piece and self.piece.command),
            "text": self.text,
            "frames": [[len(frame), base64.b64encode(frame[:most]).decode()] for frame in frames],
        }


class Arrows:
    def __init__(self) -> None:
        self.kept: deque[Arrow] = deque()
        self.number = self.bytes = 0
        # Messages and bytes in each direction since the beginning: the page makes rates of them.
        self.totals = Counter({"up": 0, "down": 0, "up bytes": 0, "down bytes": 0})
        self.began = 0.0
        # Each direction of each connection has a thread of its own.
        self.lock = threading.Lock()

    def add(self, link: int, way: str, piece: Piece | None, text: str = "") -> None:
        with self.lock:
            last = self.kept[-1] if self.kept else None
            if last and not piece and not last.piece and (last.way, last.text) == (way, text):
                # A client that tries again and again where no server is makes no flood of lines.
                return
            now = time.perf_counter()
            self.began = self.began or now
            self.number += 1
            self.kept.append(Arrow(self.number, now - self.began, link, way, piece, text))
            if piece:
                self.bytes += len(piece.raw)
                self.totals[way] += 1
                self.totals[f"{way} bytes"] += len(piece.raw)
            while len(self.kept) > MOST or (self.bytes > MOST_BYTES and len(self.kept) > 1):
                gone = self.kept.popleft().piece
                self.bytes -= len(gone.raw) if gone else 0

    def after(self, number: int, most: int) -> list[Arrow]:
        """The newest that came after this one, at most so many."""
        with self.lock:
            new = min(self.number - number, most, len(self.kept))
            return [self.kept[i] for i in range(len(self.kept) - new, len(self.kept))]

    def find(self, number: int) -> Arrow | None:
        """None if it has gone already."""
        with self.lock:
            place = number - self.number + len(self.kept) - 1
            return self.kept[place] if 0 <= place < len(self.kept) else None


HTML = Path(__file__).with_name("tap.html")
BEGIN, END = '<script type="text/plain" id="recording">', "</script>"


def recording(arrows: Arrows, title: str) -> str:
    kept = [each.as_json(WHOLE) for each in arrows.after(0, arrows.number)]
    data = json.dumps({"title": title, "totals": arrows.totals, "arrows": kept}).encode()
    packed = base64.b64encode(gzip.compress(data, mtime=0)).decode()
    return HTML.read_text(encoding="utf-8").replace(BEGIN + END, BEGIN + packed + END)


def file(text: str) -> Path:
    """For argparse: what cannot be written is told now, and not when all has been seen."""
    try:
        Path(text).touch()
    except (OSError, ValueError) as error:
        raise argparse.ArgumentTypeError(f"cannot write {text!r}: {error}; choose another file") from None
    return Path(text)


def write(path: Path, arrows: Arrows, title: str) -> None:
    try:
        path.write_text(recording(arrows, title), encoding="utf-8", newline="\n")
    except OSError as error:
        sys.exit(f"cannot write {path}: {error.strerror}; no recording")
