"""The arrows of the tap's picture: the newest messages, numbered, as many as fit; and a recording of them.

    arrows = Arrows()
    arrows.add(1, "up", piece)           connection 1, a message to the server
    arrows.after(0, 40)                  at most 40 of the newest
    recording(arrows, "Lesson 02")       an HTML file that shows them again

To add a message costs little; what it looks like in a page is worked out when a page asks. The oldest go first. A page
that cannot follow gets the newest, and the numbers tell it what it has missed.

A recording is the tap's page with the messages inside, one file that opens without a server. It holds the messages of
peers as letters and digits only (gzip, base64), so none of them can become a part of the page.
"""

import base64
import gzip
import json
import threading
import time
from collections import Counter, deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from netmq_example.tap.zmtp import NotZeroMQ, Piece

# So many arrows, and bytes of all their messages together, are kept.
MOST_ARROWS = 2000
MOST_BYTES = 32 * 1024 * 1024
# All connections together hold so many bytes that are not passed on yet: two of the largest.
MOST_HELD = 600 * 1024 * 1024
# How much of each frame a page gets at first, and when somebody opens the arrow.
PREVIEW_BYTES = 1024
WHOLE_BYTES = 4 * 1024 * 1024

HTML = Path(__file__).with_name("tap.html")
# Between these two in the page is the recording.
BEGIN, END = '<script type="text/plain" id="recording">', "</script>"


@dataclass(slots=True)
class Arrow:
    """One message or command on its way `up` to the server or `down`; or, without a piece, what happened otherwise."""

    number: int
    seconds: float
    link: int
    way: str
    piece: Piece | None
    text: str

    def as_json(self, most: int = PREVIEW_BYTES) -> dict[str, Any]:
        """For a page, with at most so many bytes of each frame."""
        frames = self.piece.frames if self.piece else []
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
    """The newest ones. Each direction of each connection adds on a thread of its own."""

    def __init__(self) -> None:
        self.kept: deque[Arrow] = deque()
        self.number = 0
        self.bytes = 0
        # Messages and bytes in each direction since the beginning: the page makes rates of them.
        self.totals = Counter({"up": 0, "down": 0, "up bytes": 0, "down bytes": 0})
        self.began = 0.0
        self.held = 0
        self.lock = threading.Lock()

    def hold(self, size: int) -> None:
        """So many bytes more, or fewer, are not passed on yet; NotZeroMQ if that is too much."""
        with self.lock:
            self.held += size
            if size > 0 and self.held > MOST_HELD:
                raise NotZeroMQ(f"what waits here to be passed on is more than {MOST_HELD:,} bytes")

    def add(self, link: int, way: str, piece: Piece | None, text: str = "") -> None:
        """`way` is up, down, or empty for what has no direction; `text` is what became of it."""
        with self.lock:
            last = self.kept[-1] if self.kept else None
            if last and not piece and not last.piece and (last.way, last.text) == (way, text):
                # A client that tries again and again where no server is makes no flood of lines.
                return
            now = time.perf_counter()
            if not self.began:
                self.began = now
            self.number += 1
            self.kept.append(Arrow(self.number, now - self.began, link, way, piece, text))
            if piece:
                self.bytes += len(piece.raw)
                self.totals[way] += 1
                self.totals[f"{way} bytes"] += len(piece.raw)
            while len(self.kept) > MOST_ARROWS or (self.bytes > MOST_BYTES and len(self.kept) > 1):
                gone = self.kept.popleft().piece
                if gone:
                    self.bytes -= len(gone.raw)

    def after(self, number: int, most: int) -> list[Arrow]:
        """The newest that came after this one, at most so many."""
        with self.lock:
            new = min(self.number - number, most, len(self.kept))
            return [self.kept[i] for i in range(len(self.kept) - new, len(self.kept))]

    def find(self, number: int) -> Arrow | None:
        with self.lock:
            place = number - self.number + len(self.kept) - 1
            return self.kept[place] if 0 <= place < len(self.kept) else None


def recording(arrows: Arrows, title: str) -> str:
    kept = [each.as_json(WHOLE_BYTES) for each in arrows.after(0, arrows.number)]
    data = json.dumps({"title": title, "totals": arrows.totals, "arrows": kept}).encode()
    packed = base64.b64encode(gzip.compress(data, mtime=0)).decode()
    return HTML.read_text(encoding="utf-8").replace(BEGIN + END, BEGIN + packed + END)
