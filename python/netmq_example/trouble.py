"""Mistakes, in a line a second at most: many messages that are wrong must not fill a disk.

    report = Trouble(log.warning)
    report("unknown channel")                      logs: trouble: unknown channel (and 300 more)

The servers of lessons 09 to 11 report by it, and so do lesson 13's managers and carriers. In C# it is Trouble.cs.
"""

import logging
import threading
import time
import traceback
from collections.abc import Callable

from netmq_example.console import printable
from netmq_example.errors import Misfit

PAUSE_SECONDS = 1.0
log = logging.getLogger("netmq_example.server")


def ends_program(error: BaseException) -> bool:
    """Whether it is none of a peer's business: SystemExit or Ctrl-C on the main thread. Another thread would end alone,
    and nobody would hear of it.
    """
    return not isinstance(error, Exception) and threading.current_thread() is threading.main_thread()


def shown(error: BaseException) -> str:
    """Its repr, if it has one."""
    try:
        return repr(error)
    except Exception:
        return type(error).__name__


class Trouble:
    def __init__(self, show: Callable[[str], object]) -> None:
        self.show = show
        self.silent_until = 0.0
        self.left_out = 0

    def __call__(self, line: str) -> None:
        if time.monotonic() < self.silent_until:
            self.left_out += 1
            return
        more = f" (and {self.left_out} more)" if self.left_out else ""
        self.show(f"trouble: {line}{more}")
        self.silent_until = time.monotonic() + PAUSE_SECONDS
        self.left_out = 0


# Each mistake that was made, by its place in the code. Each has its own line a second.
again: dict[tuple[object, ...], Trouble] = {}


def told(error: BaseException) -> str:
    """The reply to a request that an exception has ended, which is also logged.

    With its traceback the first time; then it is a line a second at most, since a client may go on asking.
    """
    if ends_program(error):
        raise error
    places = [(frame.f_code.co_filename, line) for frame, line in traceback.walk_tb(error.__traceback__)]
    # Two servers of one program may fail in the same place, and come there on different ways.
    mistake = (type(error), *places[:4], places[-1])
    first = mistake not in again
    report = again.setdefault(mistake, Trouble(log.error))
    text = str(error) if isinstance(error, Misfit) else shown(error)
    if first and not isinstance(error, Misfit):
        log.error("a mistake in answer", exc_info=error)
    else:
        report(text)
    return f"error: {printable(text, LONGEST_MISTAKE)}"


# In characters. A longer reply than the limit would be dropped by the client, with the connection.
LONGEST_MISTAKE = 1000
