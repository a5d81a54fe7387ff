"""Ctrl-C and its kin: when they may come, and when they must wait."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

# What asks a program to end. The last is Windows' own.
ENDS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


def interruptible() -> None:
    """Whatever asks us to end, `kill` and a closed terminal too, is a KeyboardInterrupt, so that we clear up."""
    for name in ENDS:
        # One that is ignored was ignored on purpose: nohup does so.
        if hasattr(signal, name) and signal.getsignal(getattr(signal, name)) != signal.SIG_IGN:
            signal.signal(getattr(signal, name), signal.default_int_handler)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """A second Ctrl-C does not stop the clearing up, which ends by itself."""
    with handling(signal.SIG_IGN):
        yield


@contextmanager
def later() -> Iterator[None]:
    """A Ctrl-C inside is raised at the end: in the middle of starting a program it would leave one unknown behind."""
    came: list[int] = []
    # A handler, and not SIG_IGN, which the program would inherit.
    with handling(lambda number, _: came.append(number)):
        yield
    if came:
        raise KeyboardInterrupt


@contextmanager
def handling(how: Callable[[int, FrameType | None], None] | signal.Handlers) -> Iterator[None]:
    """Inside, what asks us to end is handled like this; what is ignored stays so. Only the main thread may say that."""
    found = {}
    if threading.current_thread() is threading.main_thread():
        for name in ENDS:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) not in (signal.SIG_IGN, None):
                found[number] = signal.signal(number, how)
    try:
        yield
    finally:
        for number, handler in found.items():
            signal.signal(number, handler)
