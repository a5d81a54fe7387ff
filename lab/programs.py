"""The performance lab's programs: servers and clients, each side on its own processor cores, asked a line at a time."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from kitlib.lessons import ROOT, KitError
from kitlib.terminal import READABLE

# Nothing in the lab takes as long; a program that does is ended, so that a run always ends.
LIMIT = 90.0
# What macOS gives at the most; the lab needs some three thousand.
ENOUGH_FILES = 10_240
PINS = hasattr(os, "sched_setaffinity")


def halves() -> tuple[set[int], set[int]]:
    """The cores for the clients and those for the servers: half of them each."""
    cores = sorted(os.sched_getaffinity(0)) if PINS else []
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


class Process:
    """A program of the lab."""

    def __init__(self, command: list[str], cores: set[int]) -> None:
        self.name = " ".join(Path(word).name for word in command[:3])
        self.errors = tempfile.TemporaryFile()  # noqa: SIM115
        with on(cores):
            self.process = subprocess.Popen(
                command,
                cwd=ROOT,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self.errors,
                text=True,
                encoding="utf-8",
                env={**os.environ, **READABLE},
                preexec_fn=many_files if os.name == "posix" else None,
            )

    def line(self) -> str:
        """Its next line, or KitError if it ends or says nothing for too long."""
        assert self.process.stdout
        late = threading.Event()

        def too_late() -> None:
            late.set()
            self.process.kill()

        watch = threading.Timer(LIMIT, too_late)
        watch.start()
        try:
            text = self.process.stdout.readline()
        finally:
            watch.cancel()
        if not text:
            how = f"was silent for {LIMIT:.0f} s" if late.is_set() else "ended"
            raise KitError(f"{self.name} {how}{self.last_words()}")
        return text.strip()

    def last_words(self) -> str:
        """The last line of what it wrote to stderr, where it says why it ended."""
        self.process.wait()
        self.errors.seek(0)
        lines = self.errors.read().decode("utf-8", "replace").split("\n")
        return next((f": {line.strip()}" for line in reversed(lines) if line.strip()), "")

    def spent(self) -> Spent:
        """What it has used so far; nan where the system does not say it exactly (Linux does)."""
        pid, sleeps = self.process.pid, dict[str, int]()
        try:
            for task in Path(f"/proc/{pid}/task").iterdir():
                found = re.search(r"^voluntary_ctxt_switches:\s+(\d+)", (task / "status").read_text(), re.MULTILINE)
                sleeps[task.name] = int(found[1]) if found else 0
            # The clock of another process, as clock_getcpuclockid(3) numbers it; threads that have ended count too.
            return Spent(time.clock_gettime(~pid << 3 | 2) * 1e6, sleeps)
        except (OSError, AttributeError):
            return Spent(math.nan, sleeps)

    def end(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe:
                try:
                    pipe.close()
                except BrokenPipeError:
                    # A line for it that it did not live to read.
                    pass
        self.errors.close()


def many_files() -> None:
    """A thousand clients need a thousand sockets, and many systems allow a program fewer files to begin with."""
    import resource

    now, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    # macOS says that there is no limit, and refuses to be asked for that.
    wanted = ENOUGH_FILES if most == resource.RLIM_INFINITY else min(most, ENOUGH_FILES)
    if now == resource.RLIM_INFINITY or now >= wanted:
        return
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, most))
    except (ValueError, OSError):
        pass


class Server(Process):
    """A server; `endpoint` is what its ready line says."""

    def __init__(self, python: Path, script: Path, options: list[str], cores: set[int]) -> None:
        super().__init__([str(python), str(script), *options], cores)
        found: list[str] = []
        try:
            while not found or not found[-1].startswith("listening"):
                found.append(self.line())
        except KitError:
            self.end()
            raise
        addresses = [found[-1], *found[:-1]]
        self.endpoint = ",".join(match[0] for line in addresses if (match := re.search(r"tcp://\S+", line)))


class Client(Process):
    """A client program, which does what a line says and answers with a line of JSON."""

    def ask(self, line: str) -> dict[str, Any]:
        """Its answer; what it prints before is under `said`."""
        assert self.process.stdin
        try:
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()
        except OSError:
            raise KitError(f"{self.name} ended{self.last_words()}") from None
        said = []
        while not (text := self.line()).startswith("{"):
            if text.startswith("failed: "):
                raise KitError(text)
            said.append(text)
        return {**json.loads(text), "said": said}
