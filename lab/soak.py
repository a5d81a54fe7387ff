"""Do programs that run for long keep their size? python3 -m lab.soak --minutes 60

Servers and C# clients of lessons 03, 04, 06, 08, 10 and 16, all at once, until the time is over. Prints the memory of
each program (its resident set) in the second and in the last quarter of the time, and how many lines it printed. Names
a program that grew by more than a tenth and by more than 4 MB, and a lesson that was silent in the last quarter; then
the exit code is 1. Linux alone says another program's memory so.
"""

from __future__ import annotations

import argparse
import re
import signal
import statistics
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from kitlib.commands.run import client_command, server_command
from kitlib.lessons import KitError, find
from kitlib.programs import Program
from kitlib.setup import python_setup

# For ever, as far as an hour goes, on a machine that may do something else. Lesson 10's client plays until its server
# has enough.
ENDLESS = ("--count", "1000000000", "--timeout", "60")
CLIENTS = {"3": ENDLESS, "4": ENDLESS, "6": ENDLESS, "8": ENDLESS, "10": (), "16": ENDLESS}
FOREVER = """
import sys
sys.path.insert(0, sys.argv.pop(1))
import server
server.GAMES = sys.maxsize
server.run(server.main)
"""
SAMPLES = 60


class Soaked:
    """A program, its memory in kilobytes and the lines it has printed, for each sample."""

    def __init__(self, name: str, command: list[str]) -> None:
        self.name, self.program = name, Program(command)
        self.kilobytes, self.printed = list[int](), list[int]()

    def sample(self) -> None:
        # What it has printed is not kept: this program is to keep its size as well.
        self.printed.append(len(self.program.lines))
        last = self.program.lines[-1] if self.program.lines else "no line"
        del self.program.lines[: self.printed[-1]]
        status = Path(f"/proc/{self.program.process.pid}/status").read_text(encoding="utf-8")
        resident = re.search(r"^VmRSS:\s+(\d+) kB", status, re.MULTILINE)
        if not resident:
            raise KitError(f"{self.name} has ended with exit code {self.program.process.wait()}: {last}")
        self.kilobytes.append(int(resident[1]))

    def row(self) -> str:
        """Its row of the table, with what is wrong at the end."""
        quarter = len(self.kilobytes) // 4
        before = statistics.median(self.kilobytes[quarter : 2 * quarter]) / 1000
        now = statistics.median(self.kilobytes[-quarter:]) / 1000
        grows = "  GROWS" if now > before * 1.1 and now > before + 4 else ""
        return f"{self.name:13} {before:8.1f} MB {now:9.1f} MB {sum(self.printed):14,}{grows}"

    def silent(self) -> bool:
        return not sum(self.printed[-len(self.printed) // 4 :])


def started(number: str, words: tuple[str, ...], python: Path) -> Iterator[Soaked]:
    """A lesson's programs, one after the other: what is behind its server, the server, and its client."""
    lesson, given = find(number), list[str]()
    for option, other in lesson.behind:
        hidden = Soaked(f"{number} {option[2:]}", [*server_command(other, python), "--endpoint", other.anywhere])
        yield hidden
        given += [option, hidden.program.endpoints()["endpoint"]]
    command = server_command(lesson, python) if number != "10" else [str(python), "-c", FOREVER, str(lesson.python)]
    server = Soaked(f"{number} server", [*command, "--endpoint", lesson.anywhere, *given])
    yield server
    to = [word for name, address in server.program.endpoints().items() for word in (f"--{name}", address)]
    yield Soaked(f"{number} client", [*client_command("csharp", lesson, python), *to, *words])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60, help="how long")
    options = parser.parse_args()
    # SIGTERM ends it as Ctrl-C does, and its programs with it.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    python = python_setup.interpreter(*(find(number).key for number in CLIENTS))
    running: list[Soaked] = []
    try:
        for number, words in CLIENTS.items():
            for each in started(number, words, python):
                running.append(each)
        for _ in range(SAMPLES):
            time.sleep(options.minutes)
            for each in running:
                each.sample()
    finally:
        for each in reversed(running):
            each.program.end()
    rows = [each.row() for each in running]
    heard = {each.name.split()[0] for each in running if not each.silent()}
    print(f"{'':13} {'2nd quarter':>11} {'last quarter':>12} {'lines printed':>14}", *rows, sep="\n")
    for number in CLIENTS.keys() - heard:
        print(f"lesson {number} has been SILENT at the end")
    return int(heard != CLIENTS.keys() or any(row.endswith("GROWS") for row in rows))


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (KitError, OSError) as error:
        sys.exit(str(error))
    except KeyboardInterrupt:
        sys.exit("stopped")
