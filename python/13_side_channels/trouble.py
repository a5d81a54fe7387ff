"""Lesson 13, trouble: what went wrong, in a line a second at the most.

report = Trouble(print)
report("unknown channel")                                       trouble: unknown channel (and 300 more)
"""

import time
from collections.abc import Callable


class Trouble:
    """Many messages that are wrong must not fill a disk."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self.say, self.silent_until, self.unsaid = say, 0.0, 0

    def __call__(self, line: str) -> None:
        if time.monotonic() < self.silent_until:
            self.unsaid += 1
            return
        self.say(f"trouble: {line}" + f" (and {self.unsaid} more)" * (self.unsaid > 0))
        self.silent_until, self.unsaid = time.monotonic() + 1, 0
