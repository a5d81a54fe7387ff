"""A program and its terminal: the lines that it prints, and Ctrl-C.

    sys.stdout = unhindered(sys.stdout)
    listen(signal.SIGINT)

A server goes on whatever becomes of its lines: a full disk, a pipe that is closed, and one that nobody reads cost
lines, and never the server.

Ctrl-C is raised as KeyboardInterrupt, but not where that would do harm. Python calls a handler between any two steps of
the main thread. An exception there while pyzmq makes a socket leaves one that nobody closes, for which the end of its
context then waits for ever. In a callback, and where pyzmq frees a frame, it is dropped, and nothing ends. In a write
of ours it has the line written twice. So there the signal comes again a moment later.
"""

import _thread
import contextlib
import functools
import io
import logging
import os
import select
import signal
import stat
import sys
import threading
import traceback
from pathlib import Path
from types import FrameType
from typing import Any

import zmq

PYZMQ = str(Path(zmq.__file__).parent)
MAKERS = ("socket", "__init__", "__new__", "__del__")


class Lines(io.FileIO):
    """A server prints by it. A pipe that nobody reads would soon hold the server up for ever."""

    wait_seconds = 0.5
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
        _, room, _ = select.select([], [self], [], self.wait_seconds)
        # Once it was waited for in vain, the next lines do not wait.
        self.wait_seconds = Lines.wait_seconds if room else 0
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
    """A peer's text, fit for one line of a terminal: no control characters, and so many characters at most."""
    return "".join(c if c.isprintable() else "?" for c in text[:most]) + ("…" if len(text) > most else "")


def show(text: str) -> None:
    """Print a line at once, also into a pipe, and whatever a peer has put into it."""
    # In one piece with its end: another thread may print as well.
    print(f"{printable(text, most=1000)}\n", end="", flush=True)


class LogLines(logging.Handler):
    """The package's log as a program's own lines; a mistake in the user's code with its traceback."""

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


def listen(*signals: int) -> None:
    """From now on these end the program. In another thread they stay the business of the main one."""
    if threading.current_thread() is threading.main_thread():
        # Of pytest, or a program of yours, it stays their own.
        sys.unraisablehook = unheard if sys.unraisablehook is sys.__unraisablehook__ else sys.unraisablehook
        for number in signals:
            signal.signal(number, interrupt)


def interrupt(number: int, frame: FrameType | None) -> None:
    """The handler; `frame` is what it interrupts."""
    if frame and is_within(frame):
        later(number)
    else:
        raise KeyboardInterrupt


def later(number: int) -> None:
    # A signal of the system's ends a wait too. On Windows there is none, and the programs' waits are short.
    send = _thread.interrupt_main
    if sys.platform != "win32":
        send = functools.partial(signal.pthread_kill, threading.main_thread().ident or 0)
    # At the end of the interpreter no thread can be started any more; and the program ends.
    with contextlib.suppress(RuntimeError):
        threading.Timer(0.01, send, [number]).start()


def unheard(told: "sys.UnraisableHookArgs") -> None:
    """An exception that nobody can catch: pyzmq lets a signal in while it frees a frame."""
    if told.exc_type is KeyboardInterrupt:
        later(signal.SIGINT)
    else:
        sys.__unraisablehook__(told)


def is_within(frame: FrameType) -> bool:
    """Whether pyzmq is making a context or a socket, or ends one, or a line is being written."""
    codes = [each.f_code for each, _ in traceback.walk_stack(frame)]
    write = Lines.write.__code__
    return any(code is write or (code.co_filename.startswith(PYZMQ) and code.co_name in MAKERS) for code in codes)
