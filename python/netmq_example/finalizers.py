"""Finalizers tidy up behind an object that nobody has any more, also in a notebook, where Ctrl-C may come any time.

    close = finalizer(environment, simulators.close)        a weakref.finalize: close() calls it now, and only once

Python calls a finalizer wherever it is, and drops what is raised in it. A KeyboardInterrupt would end it half way, and
nobody would hear of the Ctrl-C. So the signal comes again when it is done. SIGTERM is one more Ctrl-C. It needs pyzmq.
"""

import contextlib
import signal
import threading
import weakref
from collections.abc import Callable, Iterator
from typing import Any

from netmq_example.console import later, listen

# Kill and process managers send it; on Windows it is Ctrl-Break.
TERMINATE = getattr(signal, "SIGBREAK", signal.SIGTERM)


def finalizer(owner: object, function: Callable[..., object], *words: Any) -> "weakref.finalize[..., object]":
    """A weakref.finalize that no Ctrl-C ends half way."""
    return weakref.finalize(owner, undisturbed, function, *words)


def undisturbed(function: Callable[..., object], *words: Any) -> None:
    """Call it. A Ctrl-C, and what else a program here listens to, waits until it has ended."""
    came: list[int] = []
    handlers: dict[int, Any] = {}
    try:
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, TERMINATE):
                if callable(signal.getsignal(number)):
                    handlers[number] = signal.signal(number, lambda number, _: came.append(number))
        function(*words)
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number in set(came):
            later(number)


@contextlib.contextmanager
def ended_by_sigterm() -> Iterator[None]:
    """Without a handler SIGTERM would end the program in the middle, and one that is a container's first not at all."""
    is_free = threading.current_thread() is threading.main_thread() and signal.getsignal(TERMINATE) is signal.SIG_DFL
    try:
        if is_free:
            listen(TERMINATE)
        yield
    finally:
        if is_free:
            signal.signal(TERMINATE, signal.SIG_DFL)
