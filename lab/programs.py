"""The performance lab's programs: servers and clients, each side on its own processor cores, asked a line at a time."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from kitlib import programs
from kitlib.lessons import KitError

# Nothing in the lab takes as long; a program that does is ended, so that a run always ends.
LIMIT = 90.0


def halves() -> tuple[set[int], set[int]]:
    """The cores for the clients and those for the servers: half of them each. Not every system can say so."""
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    middle = len(cores) // 2
    return (set(cores[:middle]), set(cores[middle:])) if middle else (set(cores), set(cores))


@contextmanager
def on(cores: set[int]) -> Iterator[None]:
    """What is started inside runs on these cores only, with all its threads; without cores, anywhere."""
    if not cores:
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cores)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


class Spent(NamedTuple):
    """Processor time in microseconds, and how often each thread went to sleep because it had to wait."""

    microseconds: float
    sleeps: dict[str, int]

    def since(self, before: Spent) -> tuple[float, float]:
        """Microseconds and sleeps since then; the sleeps of a thread that has ended meanwhile are lost."""
        slept = sum(count - before.sleeps.get(thread, 0) for thread, count in self.sleeps.items())
        return self.microseconds - before.microseconds, slept if self.sleeps else math.nan


class Program(programs.Program):
    """A program of the lab."""

    def __init__(self, command: list[str], cores: set[int], stdin: int = subprocess.DEVNULL) -> None:
        with on(cores):
            super().__init__(command, stdin=stdin)

    def spent(self) -> Spent:
        """Its use so far; nan where the system does not say it exactly (Linux does)."""
        pid, sleeps = self.process.pid, dict[str, int]()
        try:
            for task in Path(f"/proc/{pid}/task").iterdir():
                found = re.search(r"^voluntary_ctxt_switches:\s+(\d+)", (task / "status").read_text(), re.MULTILINE)
                sleeps[task.name] = int(found[1]) if found else 0
            # The clock of another process, as clock_getcpuclockid(3) numbers it; threads that have ended count too.
            return Spent(time.clock_gettime(~pid << 3 | 2) * 1e6, sleeps)
        except (OSError, AttributeError):
            return Spent(math.nan, sleeps)


class Server(Program):
    """A server; `endpoint` is what its ready line says."""

    def __init__(self, python: Path, script: Path, options: list[str], cores: set[int]) -> None:
        super().__init__([str(python), str(script), *options], cores)
        try:
            self.endpoint = self.endpoints()["endpoint"]
        except KitError:
            self.end()
            raise


class Client(Program):
    """A client program, which does what a line says and answers with a line of JSON."""

    def __init__(self, command: list[str], cores: set[int]) -> None:
        super().__init__(command, cores, stdin=subprocess.PIPE)

    def ask(self, line: str) -> dict[str, Any]:
        """Its answer; what it prints before is under `said`."""
        assert self.process.stdin
        # It says nothing unasked; and an answer with every wait is long.
        self.lines.clear()
        try:
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()
        except OSError:
            # It has ended, and the next lines say why.
            pass
        try:
            answer = self.wait_for(r"^(\{|failed: )", LIMIT).string
        except KitError:
            # So that it is started anew when it is next needed.
            self.end()
            raise
        if answer.startswith("failed: "):
            raise KitError(answer)
        return {**json.loads(answer), "said": self.lines[:-1]}
