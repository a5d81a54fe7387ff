"""Lesson 07, what the server knows: the state, the next message, and the snapshot that stands for all before it.

Bytes: as in server.py.
"""

import math
import secrets


class Publisher:
    """A cube that goes round in circles, and the state that its messages add up to."""

    def __init__(self) -> None:
        # Numbers begin anew with each start. By the run, number 5 of now differs from number 5 of then.
        self.run, self.number = secrets.token_hex(4), 0
        # The checksum stands for any state to which each message adds: one lost or taken twice, and it is another.
        self.message, self.checksum = "", 0

    def step(self) -> str:
        """The next message, counted in."""
        self.number += 1
        angle = self.number / 60
        place = (2 * math.cos(angle), 0, 2 * math.sin(angle), 0, math.sin(-angle / 2), 0, math.cos(angle / 2))
        self.message = f"pose/ {self.run} {self.number} " + " ".join(f"{value:.4f}" for value in place)
        self.checksum = (31 * self.checksum + sum(self.message.encode())) % 2**32
        return self.message

    def snapshot(self, request: bytes) -> str:
        """What a subscriber needs to go on with the next message, as if it had heard every one before."""
        if request != b"pose/":
            return f"error: expected pose/, got {request[:40]!r}"
        print(f"snapshot at {self.number}, checksum {self.checksum}", flush=True)
        return f"{self.checksum} {self.message}"
