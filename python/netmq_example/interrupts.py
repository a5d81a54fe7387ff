"""Ctrl-C, and what else asks a program to end, raised as KeyboardInterrupt, but not where that would do harm.

Python calls a handler between any two steps of the main thread. What it raises while pyzmq makes a socket leaves one
that nobody closes, for which the end of its context then waits for ever. What it raises in a callback of the
interpreter's own is dropped, and the program goes on. What it raises in a write of ours has the line written twice. So
there the signal comes again a moment later.
"""

import _thread
import contextlib
import os
import signal
import sys
import threading
from pathlib import Path
from types import FrameType

import zmq

from netmq_example import console

AGAIN_SECONDS = 0.01
PYZMQ = str(Path(zmq.__file__).parent)


def listen(*signals: int) -> None:
    """From now on these end the program. In another thread they stay the business of the main one."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number in signals:
        signal.signal(number, interrupt)


def interrupt(number: int, frame: FrameType | None) -> None:
    """The handler; `frame` is what it interrupts."""
    if frame and (is_dropped(frame) or is_within(frame)):
        later(number)
    else:
        raise KeyboardInterrupt


def later(number: int) -> None:
    # At the end of the interpreter no thread can be started any more; and the program ends.
    with contextlib.suppress(RuntimeError):
        threading.Timer(AGAIN_SECONDS, again, [number]).start()


def again(number: int) -> None:
    # A signal of the system's ends a wait too. On Windows there is none, and the programs' waits are short.
    if sys.platform == "win32":
        _thread.interrupt_main(number)
    else:
        signal.pthread_kill(threading.main_thread().ident or 0, number)


def at_eof() -> None:
    """Ctrl-C, as soon as nobody can write to standard input: who started this program closed it, or is gone."""
    try:
        while os.read(0, 4096):
            pass
    except OSError:
        # There is none.
        pass
    again(signal.SIGINT)


def is_dropped(frame: FrameType) -> bool:
    """Whether nobody would hear of an exception: in a destructor, or where the import system tidies up."""
    return frame.f_code.co_name == "__del__" or frame.f_code.co_qualname.startswith("_get_module_lock")


def is_within(frame: FrameType | None) -> bool:
    """Whether pyzmq is making a context or a socket, or a line is being written."""
    while frame:
        code = frame.f_code
        if code.co_filename.startswith(PYZMQ) and code.co_name in ("socket", "__init__", "__new__"):
            return True
        if code is console.Lines.write.__code__:
            return True
        frame = frame.f_back
    return False
