"""What went wrong, in a line a second at most: many messages that are wrong must not fill a disk.

    report = Trouble(log.warning)
    report("unknown channel")                      logs: trouble: unknown channel (and 300 more)

The servers of lessons 09 to 11 report by it, and so do lesson 13's managers and carriers. In C# it is Trouble.cs.
"""

import threading
import time
from collections.abc import Callable

from netmq_example import check

PAUSE_SECONDS = 1.0


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
        self.show = check.function("show", show)
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
