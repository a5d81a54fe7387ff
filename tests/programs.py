"""Programs as a user starts them: what they print is read line by line, and every wait has a limit."""

from __future__ import annotations

import contextlib
import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import uuid
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from kitlib import programs
from kitlib.lessons import KitError

ROOT = Path(__file__).resolve().parent.parent
# How long a broken program is waited for.
LIMIT = programs.TIMEOUT
# For a client, or a gateway, that is to have its answer: a busy machine may take longer than the seconds that it waits.
PATIENT = ("--timeout", "60")


def free_port() -> int:
    """A port of this machine that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


HELD: deque[socket.socket] = deque()


def steady_port() -> int:
    """A free port outside the range from which the system takes those of outgoing connections.

    While no server listens on a port of that range, a client that tries it may be given the same port as its own, and
    is then connected to itself.
    """
    for port in random.sample(range(20_000, 30_000), 100):
        with contextlib.suppress(OSError):
            hold(port)
            return port
    raise AssertionError("no free port")


def elsewhere(script: str) -> str:
    """A script of a page that is written for the kit's folder, to be run in another one."""
    script = script.replace('"kit.py"', repr(str(ROOT / "kit.py")))
    return re.sub(r'"python(?=["/])', f'"{(ROOT / "python").as_posix()}', script)


def steady_endpoint() -> str:
    return f"tcp://127.0.0.1:{steady_port()}"


def hold(port: int) -> None:
    """Keep it for this test's server; OSError if anybody has it, in another process too.

    On Linux a server, which sets SO_REUSEADDR, may listen beside a socket that has it as well and does not listen.
    """
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", port))
        if sys.platform == "linux":
            # Only now: of two who set it before they bind, each would be given the port.
            holder.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            HELD.append(holder.dup())
    if len(HELD) > 50:
        HELD.popleft().close()


# Another /etc/hosts for one program and what it starts.
HOSTS = """
import os, subprocess, sys
subprocess.run(["mount", "--bind", sys.argv[1], "/etc/hosts"], check=True)
os.execvp(sys.argv[2], sys.argv[2:])
"""


class MovingName:
    """The name "robot", whose address changes under the programs that `before` stands before, if that works here."""

    def __init__(self, folder: Path, address: str = "127.0.0.2") -> None:
        self.hosts = folder / "hosts"
        self.before = ["unshare", "-rm", sys.executable, "-c", HOSTS, str(self.hosts)]
        self.move(address)
        if not shutil.which("unshare") or subprocess.run([*self.before, "true"], capture_output=True).returncode:
            pytest.skip("a name cannot be moved here: there is no unshare, or it may not mount")

    def move(self, address: str) -> None:
        """The same file, since that is what was mounted."""
        self.hosts.write_text(f"127.0.0.1 localhost\n{address} robot\n", encoding="utf-8")

    def vanish(self) -> None:
        self.hosts.write_text("127.0.0.1 localhost\n", encoding="utf-8")


def leaves_nothing_to_collect(cost: str) -> bool:
    """By the line of FrameCost: no frame makes garbage. On a busy machine a queue grows now and then."""
    frames, dirty = map(int, re.search(r"(\d+) frames: .* bytes allocated in (\d+) frames$", cost).groups())
    return dirty <= max(2, frames // 50)


def two_ports() -> str:
    """An endpoint whose neighbour, 100 higher, is free as well: lesson 07 has two."""
    while True:
        port = steady_port()
        with contextlib.suppress(OSError):
            hold(port + 100)
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

    def gone(self) -> bool:
        """Whether all of them end soon: what was killed is gone when the system has had time for it."""
        deadline = time.monotonic() + LIMIT
        while self.processes() and time.monotonic() < deadline:
            time.sleep(0.02)
        return self.processes() == {}


def finished(words: Sequence[str | Path], timeout: float = LIMIT, **more: Any) -> subprocess.CompletedProcess[str]:
    """A program that has run to its end, and what it printed."""
    return subprocess.run(words, capture_output=True, text=True, timeout=timeout, **more)


# Runs a program once for each line, which is a list of it and its words, as if it were started anew.
EACH_RUN = """
import contextlib, io, json, runpy, sys
path = [*sys.path]
for line in sys.stdin:
    said = io.TextIOWrapper(io.BytesIO(), encoding="utf-8")
    sys.argv[:], sys.path[:] = json.loads(line), path
    code = 0
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            runpy.run_path(sys.argv[0], run_name="__main__")
        except SystemExit as end:
            if isinstance(end.code, str):
                print(end.code)
            code = 1 if isinstance(end.code, str) else end.code or 0
        except BaseException as error:
            print(f"Traceback: {error!r}")
            code = 1
        said.flush()
    text = said.buffer.getvalue()
    end = b"" if text.endswith(b"\\n") or not text else b"\\n"
    sys.stdout.buffer.write(text + end + b"ended %d\\n" % code)
    sys.stdout.flush()
"""


class Run(NamedTuple):
    """A program that has run to its end."""

    code: int
    lines: list[str]


class InTurn:
    """A process in which programs run one after the other, each as if it were started anew: call it with the words.

    It is for runs that end by themselves, such as those with wrong words: to start Python and import ZeroMQ, or to
    start .NET, takes longer than many of them together.
    """

    def __init__(self, command: Sequence[str | Path], folder: Path = ROOT) -> None:
        self.command, self.folder = command, folder
        self.begin()

    def begin(self) -> None:
        self.process = subprocess.Popen(
            self.command,
            cwd=self.folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env={**os.environ, **programs.READABLE},
        )

    def __enter__(self) -> InTurn:
        return self

    def __call__(self, *words: str | Path) -> Run:
        if self.process.poll() is not None:
            self.begin()
        self.process.stdin.write(json.dumps([*map(str, words)]).encode() + b"\n")
        self.process.stdin.flush()
        limit = threading.Timer(LIMIT, self.process.kill)
        limit.start()
        said: list[str] = []
        for line in self.process.stdout:
            if match := re.fullmatch(rb"ended (\d+)\r?\n", line):
                limit.cancel()
                return Run(int(match[1]), said)
            said.append(line.decode(errors="replace").rstrip("\r\n"))
        raise AssertionError("\n".join([f"no end of {words}", *said]))

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.communicate()


def python_in_turn(folder: Path) -> InTurn:
    """For Python programs of this folder; the first word of each run is the program."""
    # A program finds what lies beside it.
    return InTurn([sys.executable, "-c", EACH_RUN], folder)


def python_runs(program: str | Path, runs: Sequence[Sequence[str]]) -> list[Run]:
    """Run a Python program once for each of these lists of words, one after the other in one process."""
    with python_in_turn((ROOT / program).parent) as run:
        return [run(ROOT / program, *words) for words in runs]


class Program(programs.Program):
    """A running program in a test, which fails with all that was printed."""

    @property
    def output(self) -> str:
        return "\n".join(self.lines)

    def wait_for(self, pattern: str, limit: float = LIMIT, start: int = 0) -> re.Match[str]:
        try:
            return super().wait_for(pattern, limit, start)
        except KitError as error:
            raise AssertionError(f"no line matched {pattern!r}: {error}; printed:\n{self.output}") from None

    def wait(self, limit: float = LIMIT) -> int:
        """The exit code, once everything it printed is in `lines`."""
        try:
            code = self.process.wait(limit)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError(f"still running after {limit:g} s: {self.command}; printed:\n{self.output}") from None
        self.reader.join(limit)
        return code

    def stop(self, how: signal.Signals = signal.SIGTERM, limit: float = LIMIT) -> int:
        """Ask it to end, as Ctrl-C (SIGINT) or a process manager (SIGTERM) would.

        Windows has neither for another program: there it is Ctrl-Break, which servers take for Ctrl-C, and so end
        with the same code; a program that does not ends with 0xC000013A.
        """
        if sys.platform == "win32":
            programs.ask_to_end(self.process)
        else:
            self.process.send_signal(how)
        return self.wait(limit)

    def kill(self) -> None:
        """End it without asking: SIGKILL."""
        self.process.kill()
        self.process.wait()
        self.reader.join(LIMIT)


def places(server: Program) -> dict[str, str]:
    """All endpoints where a server listens: {"listening": …, "snapshots": …}."""
    return dict(re.findall(r"^(\w+) on ((?:tcp|http)://\S+)$", server.output, re.MULTILINE))
