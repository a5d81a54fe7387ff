"""The board: the hub's state in lines, which it logs.

board = Board()
hub = Hub(socket, report=board.report)
board.show(hub)                    often: it says something once a second
"""

import logging
import time

from netmq_example.fleet.hub import Hub

# So many lines a second are logged.
MOST_LINES = 200

log = logging.getLogger("netmq_example.server")


class Board:
    """Where simulators and trainers are seen to come."""

    def __init__(self) -> None:
        # Lines that were reported since the state was looked at.
        self.lines = 0
        self.last_line = ""
        self.shown = time.monotonic()
        self.printed = "0 0 0 0 begun anew, 0 asked elsewhere"

    def report(self, line: str) -> None:
        """Log a line. Strangers who come by the thousand make no flood of lines."""
        if line == self.last_line:
            # A peer that is refused tries again some times a second.
            return
        self.last_line = line
        self.lines += 1
        if self.lines <= MOST_LINES:
            log.info(line)

    def show(self, hub: Hub) -> None:
        """Once a second what has changed, but for the numbers that always grow."""
        now = time.monotonic()
        if now < self.shown + 1:
            return
        self.shown = now
        count = hub.count
        if self.lines > MOST_LINES:
            log.info("%s lines more", self.lines - MOST_LINES)
        self.lines = 0
        free = sum(member.free() for member in hub.members.values())
        at_work = sum(any(trainer.episodes) for trainer in hub.trainers.values())
        people = f"{len(hub.members)} simulators, {free} free, {len(hub.trainers)} trainers, {at_work} at work"
        trouble = f"{count['begun anew']} begun anew, {count['asked elsewhere']} asked elsewhere"
        state = f"{len(hub.members)} {len(hub.trainers)} {at_work} {trouble}"
        if state != self.printed:
            self.printed = state
            log.info("%s, %s episodes, %s", people, count["episodes"], trouble)
