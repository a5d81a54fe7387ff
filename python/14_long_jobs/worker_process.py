"""Lesson 14, a worker's process: how it is started, so that it can be told to stop, be killed, and end with the server.
"""

import multiprocessing
import signal
import sys
from multiprocessing import resource_tracker
from multiprocessing.reduction import ForkingPickler

from work import KINDS
from worker import labour

# A new process, not a copy of this one: a copy made while a thread holds a lock would wait for that lock for ever.
SPAWN = multiprocessing.get_context("spawn")


def check_kinds() -> None:
    """Each is handed to a new process, which has to find it by the name of its module."""
    for name, kind in KINDS.items():
        try:
            ForkingPickler.dumps(kind)
        except Exception:
            cure = "make it a function of a module, or functools.partial of one"
            sys.exit(f"kind {name!r} cannot be handed to a worker: {cure}")


class Worker:
    """A process, and the pipe to it."""

    def __init__(self) -> None:
        self.pipe, theirs = SPAWN.Pipe()
        self.process = SPAWN.Process(target=labour, args=(theirs, KINDS), daemon=True)
        self.begin()
        self.doomed = False
        # Only the process itself has that end now, so that its death ends every wait at this one.
        theirs.close()

    def begin(self) -> None:
        """Ctrl-C in a terminal reaches it too, and before it can say that it ignores it. So it inherits that."""
        if not hasattr(signal, "pthread_sigmask"):
            return self.process.start()
        # What is started with the first process, and ends the holding back.
        resource_tracker.ensure_running()
        before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
        try:
            self.process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
