"""What a program prints, and where to: a server goes on whatever becomes of that.

    sys.stdout = unhindered(sys.stdout)

A full disk, a pipe that is closed, and one that nobody reads cost lines, and never the server. It needs only Python.
"""

import io
import logging
import os
import select
import stat
import sys
import traceback
from typing import Any


class Lines(io.FileIO):
    """What a server prints. A pipe that nobody reads would soon hold the server up for ever."""

    patience = 0.5
    before: Any = None

    def write(self, data: Any) -> int:
        try:
            # In pieces: where there is room for anything, a pipe has room for so much.
            return super().write(data[:4096]) if self.has_room() else len(data)
        except OSError:
            return len(data)

    def has_room(self) -> bool:
        # On Windows only its reader can keep a pipe from being full.
        if sys.platform == "win32" or not stat.S_ISFIFO(os.fstat(self.fileno()).st_mode):
            return True
        _, room, _ = select.select([], [self], [], self.patience)
        # Once it was waited for in vain, the next lines do not wait.
        self.patience = Lines.patience if room else 0
        return bool(room)


def unhindered(stream: Any) -> Any:
    """The same for Lines; a stream that leads to no file is as it was, such as a notebook's, or none at all."""
    buffer = getattr(stream, "buffer", None)
    raw = getattr(buffer, "raw", buffer)
    if not isinstance(raw, io.FileIO) or raw.closed:
        return stream
    stream.flush()
    file = Lines(raw.fileno(), "w", closefd=False)
    # If nobody had it any more, it would close what this writes to.
    file.before = stream
    lines = io.BufferedWriter(file)
    at_once = stream.line_buffering or stream.write_through
    return io.TextIOWrapper(lines, stream.encoding, stream.errors, line_buffering=at_once)


def printable(text: str, most: int = 200) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, and so many characters at most."""
    return "".join(c if c.isprintable() else "?" for c in text[:most]) + ("…" if len(text) > most else "")


def show(text: str) -> None:
    """Print a line at once, also into a pipe, and whatever a peer has put into it."""
    # In one piece with its end: another thread may print as well.
    print(f"{printable(text, most=1000)}\n", end="", flush=True)


class LogLines(logging.Handler):
    """What the package logs, as a program's own lines; a mistake in the user's code with its traceback."""

    def emit(self, record: logging.LogRecord) -> None:
        if record.exc_info:
            print("".join(traceback.format_exception(record.exc_info[1])), end="", file=sys.stderr, flush=True)
        else:
            show(record.getMessage())


def log_lines() -> None:
    """For a program: the package itself sets no handler, and prints nothing."""
    log = logging.getLogger("netmq_example")
    log.handlers = [each for each in log.handlers if not isinstance(each, LogLines)] + [LogLines()]
    log.setLevel(logging.INFO)
