"""Programs as a user starts them: what they print is read line by line, and every wait has a limit."""

from __future__ import annotations

import contextlib
import os
import random
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Sequence
from pathlib import Path

import pytest

from kitlib.terminal import GROUP, READABLE, ask_to_end

ROOT = Path(__file__).resolve().parent.parent
# Generous, since it only decides how long a broken program is waited for.
LIMIT = 60.0


def free_port() -> int:
    """A port of this machine that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def steady_port() -> int:
    """A free port outside the range from which the system takes those of outgoing connections.

    While no server listens on a port of that range, a client that tries it may be given the same port as its own, and
    is then connected to itself.
    """
    for port in random.sample(range(20_000, 30_000), 100):
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port
    raise AssertionError("no free port")


def two_ports() -> str:
    """An endpoint whose neighbour, 100 higher, is free as well: lesson 03 has two."""
    while True:
        port = steady_port()
        with contextlib.suppress(OSError), socket.create_server(("127.0.0.1", port + 100)):
            return f"tcp://127.0.0.1:{port}"


finds_processes = pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="finds processes in /proc")


class Mark:
    """A word in the environment by which a program and all that it starts are found, and nothing of other people's."""

    def __init__(self) -> None:
        self.environment = {"KIT_TEST_MARK": str(uuid.uuid4())}

    def processes(self) -> dict[int, str]:
        """The number and the command of each process that has the mark."""
        found = {}
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                if self.environment["KIT_TEST_MARK"].encode() in (folder / "environ").read_bytes():
                    found[int(folder.name)] = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode()
            except OSError:
                pass
        return found


class Program:
    """A running process. `lines` grows as it prints, stdout and stderr together."""

    def __init__(self, command: Sequence[str | Path], *, stdin: int = subprocess.DEVNULL, **environment: str) -> None:
        self.command = [str(word) for word in command]
        self.lines: list[str] = []
        self._news = threading.Condition()
        self.process = subprocess.Popen(
            self.command,
            cwd=ROOT,
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            errors="replace",
            env={**os.environ, **READABLE, **environment},
            **(GROUP if sys.platform == "win32" else {}),
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout
        for line in self.process.stdout:
            with self._news:
                self.lines.append(line.rstrip("\r\n"))
                self._news.notify_all()
        with self._news:
            self._news.notify_all()

    @property
    def output(self) -> str:
        return "\n".join(self.lines)

    def wait_for(self, pattern: str, limit: float = LIMIT, start: int = 0) -> re.Match[str]:
        """The first match of a regular expression in a line from number `start` on; fails after `limit` seconds."""
        deadline = time.monotonic() + limit
        with self._news:
            while True:
                for line in self.lines[start:]:
                    if match := re.search(pattern, line):
                        return match
                if not self._reader.is_alive():
                    raise AssertionError(f"it ended before a line matched {pattern!r}; printed:\n{self.output}")
                if time.monotonic() >= deadline:
                    raise AssertionError(f"no line matched {pattern!r} in {limit:g} s; printed:\n{self.output}")
                # Short, because a program that ends between the look and the wait says nothing any more.
                self._news.wait(0.2)

    def wait(self, limit: float = LIMIT) -> int:
        """The exit code, once everything it printed is in `lines`."""
        try:
            code = self.process.wait(limit)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError(f"still running after {limit:g} s: {self.command}; printed:\n{self.output}") from None
        self._reader.join(limit)
        return code

    def stop(self, how: signal.Signals = signal.SIGTERM, limit: float = LIMIT) -> int:
        """Ask it to end, as Ctrl-C (SIGINT) or a process manager (SIGTERM) would.

        Windows has neither for another program: there it is Ctrl-Break, which servers take for Ctrl-C, and so end
        with the same code; a program that does not ends with 0xC000013A.
        """
        if sys.platform == "win32":
            ask_to_end(self.process)
        else:
            self.process.send_signal(how)
        return self.wait(limit)

    def kill(self) -> None:
        """End it without asking: SIGKILL."""
        self.process.kill()
        self.process.wait()
        self._reader.join(LIMIT)
