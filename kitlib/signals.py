"""Ctrl-C and its kin: what they are here, and when they must wait."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

# These ask a program to end. The last is Windows' own.
ENDS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


def interruptible() -> None:
    """Each signal that asks us to end is a KeyboardInterrupt, so that we clear up: also a closed terminal."""
    for name in ENDS:
        # One that is ignored was ignored on purpose: nohup does so.
        if hasattr(signal, name) and signal.getsignal(getattr(signal, name)) != signal.SIG_IGN:
            signal.signal(getattr(signal, name), signal.default_int_handler)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """A second Ctrl-C does not stop the clearing up, which ends by itself."""
    # Only the main thread may say what a signal does.
    may = threading.current_thread() is threading.main_thread()
    numbers = [getattr(signal, name) for name in ENDS if may and hasattr(signal, name)]
    before = {number: signal.signal(number, signal.SIG_IGN) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            # None is one that Python did not set.
            signal.signal(number, handler or signal.SIG_DFL)
