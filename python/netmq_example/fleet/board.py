"""Lesson 17, the board: the hub's state, a table that renews itself on a terminal, and lines in a file or a pipe."""

import os
import shutil
import sys
import time

from netmq_example.fleet.hub import Hub

# So many simulators have a row, if the terminal is that high; and so many lines a second are printed.
ROWS, LINES = 15, 200


class Board:
    def __init__(self) -> None:
        self.terminal, self.drawn, self.lines, self.last = sys.stdout.isatty(), 0, 0, ""
        self.shown, self.messages = time.monotonic(), 0
        self.said = "0 0 0 0 begun anew, 0 asked elsewhere"
        if self.terminal and os.name == "nt":
            # Windows takes the signs that move the cursor only after this.
            os.system("")

    def say(self, line: str) -> None:
        """A line for good, above the table. Strangers who come by the thousand make no flood of lines."""
        if line == self.last:
            # Whoever is refused tries again some times a second.
            return
        self.last, self.lines = line, self.lines + 1
        if self.lines <= LINES:
            print(f"{self.erased()}{line}", flush=True)

    def show(self, hub: Hub) -> None:
        """Once a second; in a file only what has changed but for the numbers that always grow."""
        if (since := time.monotonic() - self.shown) < 1:
            return
        count = hub.count
        rate, self.messages = (count["messages"] - self.messages) / since, count["messages"]
        self.shown += since
        if self.lines > LINES:
            print(f"{self.erased()}{self.lines - LINES} lines more", flush=True)
        self.lines = 0
        free = sum(member.free() for member in hub.members.values())
        at_work = sum(any(trainer.episodes) for trainer in hub.trainers.values())
        people = f"{len(hub.members)} simulators, {free} free, {len(hub.trainers)} trainers, {at_work} at work"
        trouble = f"{count['begun anew']} begun anew, {count['asked elsewhere']} asked elsewhere"
        if self.terminal:
            # Two rows: a terminal may have no more than 80 columns.
            rows = [f"{people}, {count['episodes']} episodes", f"{trouble}, {rate:,.0f} messages/s", *rows_of(hub)]
            # A row that is cut is one row: a longer one would be two, and not all of them taken off again.
            width, height = shutil.get_terminal_size()
            rows = [row[: width - 1] for row in rows[: height - 1]]
            print(self.erased() + "\n".join(rows), flush=True)
            self.drawn = len(rows)
        elif (now := f"{len(hub.members)} {len(hub.trainers)} {at_work} {trouble}") != self.said:
            self.said = now
            print(f"{people}, {count['episodes']} episodes, {trouble}", flush=True)

    def erased(self) -> str:
        """What takes the table off the terminal."""
        lines, self.drawn = self.drawn, 0
        return f"\x1b[{lines}F\x1b[J" if lines else ""


def rows_of(hub: Hub) -> list[str]:
    rows = []
    for member in list(hub.members.values())[:ROWS]:
        doing = f"step {member.done} of an episode" if member.episode else "free"
        rows.append(f"  simulator {member.number}: {member.name[:20]!r}, {doing}, heard {member.silence():.1f} s ago")
    return rows + [f"  and {len(hub.members) - ROWS} more"] * (len(hub.members) > ROWS)
