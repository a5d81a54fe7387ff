"""The board: the hub's state, a table that renews itself on a terminal, and lines in a file or a pipe.

board = Board()
hub = Hub(socket, board.report)
board.show(hub)                    often: it shows something once a second
"""

import os
import shutil
import sys
import time

from netmq_example.fleet.hub import Hub

# So many simulators have a row, if the terminal is that high.
MOST_ROWS = 15
# And so many lines a second are printed.
MOST_LINES = 200


class Board:
    """Where simulators and trainers are seen to come, and what each simulator does."""

    def __init__(self) -> None:
        self.terminal = sys.stdout.isatty()
        # Rows of the table that is on the terminal, and lines that were reported since it was shown.
        self.drawn = 0
        self.lines = 0
        self.last_line = ""
        self.shown = time.monotonic()
        self.messages = 0
        self.printed = "0 0 0 0 begun anew, 0 asked elsewhere"
        if self.terminal and os.name == "nt":
            # Windows takes the signs that move the cursor only after this.
            os.system("")

    def report(self, line: str) -> None:
        """A line for good, above the table. Strangers who come by the thousand make no flood of lines."""
        if line == self.last_line:
            # A peer that is refused tries again some times a second.
            return
        self.last_line = line
        self.lines += 1
        if self.lines <= MOST_LINES:
            print(f"{self.erased()}{line}", flush=True)

    def show(self, hub: Hub) -> None:
        """Once a second; in a file only what has changed but for the numbers that always grow."""
        since = time.monotonic() - self.shown
        if since < 1:
            return
        self.shown += since
        count = hub.count
        rate = (count["messages"] - self.messages) / since
        self.messages = count["messages"]
        if self.lines > MOST_LINES:
            print(f"{self.erased()}{self.lines - MOST_LINES} lines more", flush=True)
        self.lines = 0
        free = sum(member.free() for member in hub.members.values())
        at_work = sum(any(trainer.episodes) for trainer in hub.trainers.values())
        people = f"{len(hub.members)} simulators, {free} free, {len(hub.trainers)} trainers, {at_work} at work"
        trouble = f"{count['begun anew']} begun anew, {count['asked elsewhere']} asked elsewhere"
        state = f"{len(hub.members)} {len(hub.trainers)} {at_work} {trouble}"
        if self.terminal:
            # Two rows: a terminal may have no more than 80 columns.
            self.draw([f"{people}, {count['episodes']} episodes", f"{trouble}, {rate:,.0f} messages/s", *rows_of(hub)])
        elif state != self.printed:
            self.printed = state
            print(f"{people}, {count['episodes']} episodes, {trouble}", flush=True)

    def draw(self, rows: list[str]) -> None:
        # A row that is cut is one row: a longer one would be two, and not all of them taken off again.
        width, height = shutil.get_terminal_size()
        rows = [row[: width - 1] for row in rows[: height - 1]]
        print(self.erased() + "\n".join(rows), flush=True)
        self.drawn = len(rows)

    def erased(self) -> str:
        """What takes the table off the terminal."""
        lines = self.drawn
        self.drawn = 0
        return f"\x1b[{lines}F\x1b[J" if lines else ""


def rows_of(hub: Hub) -> list[str]:
    rows = []
    # In ASCII: a row is cut by its letters, and a terminal takes some of the others for two columns.
    for member in list(hub.members.values())[:MOST_ROWS]:
        doing = f"step {member.done} of an episode" if member.episode else "free"
        rows.append(f"  simulator {member.number}: {member.name[:20]!a}, {doing}, heard {member.silence():.1f} s ago")
    if len(hub.members) > MOST_ROWS:
        rows.append(f"  and {len(hub.members) - MOST_ROWS} more")
    return rows
