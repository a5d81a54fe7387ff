"""Lesson 16, trouble for a message: dropped, a second late, passed on twice, or its connection cut.

Planned for message N when the tap starts, or asked for in the page for the next one.
"""

import threading
from dataclasses import dataclass, field

FATES = ("drop", "delay", "double", "cut")


@dataclass
class Trouble:
    """Messages are counted from 1, both ways together; `way` is up, to the server, down, or empty for both."""

    planned: dict[int, str] = field(default_factory=dict)
    asked: str = ""
    way: str = ""
    # Each message is late by so many seconds: slow enough for an eye.
    slow: float = 0
    number: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)

    def ask(self, fate: str, way: str) -> None:
        """For the next message; nothing takes the wish back."""
        with self.lock:
            self.asked, self.way = fate, way

    def state(self) -> dict[str, str | float]:
        return {"asked": self.asked, "slow": self.slow}

    def of_next(self, way: str) -> str:
        with self.lock:
            self.number += 1
            if self.asked and self.way in ("", way):
                fate, self.asked = self.asked, ""
                return fate
            return self.planned.get(self.number, "")
