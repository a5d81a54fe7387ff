"""Other programs: one whose lines are read, one that has this terminal, and commands that run to their end."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from subprocess import DEVNULL, PIPE, STDOUT, Popen, TimeoutExpired
from typing import Any

from kitlib.lessons import ROOT, KitError
from kitlib.signals import uninterrupted
from kitlib.terminal import say

# In a pipe Windows would use another encoding, and Python would keep the lines back.
READABLE = {"PYTHONUNBUFFERED": "1", "PYTHONUTF8": "1", "PYTHONIOENCODING": "utf-8"}
# Ctrl-C for a program and all that it starts is a signal for its group. Windows calls the group's signal Ctrl-Break.
GROUP: dict[str, Any] = {"start_new_session": True}
if sys.platform == "win32":
    GROUP = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
# Generous, since it only decides how long a broken program is waited for.
TIMEOUT = 120.0
# A program is asked to end, and waited for this long. One that has heard the terminal's Ctrl-C is not asked that soon.
GOODBYE, MOMENT = 5.0, 1.0
# In bytes; what is longer is given in parts.
LONGEST_LINE = 4000
# Of a program that prints without end the last ones are kept.
MOST_LINES = 20_000
Command = Sequence[str | Path]
Environment = Mapping[str, str] | None


class Program:
    """A running program. `lines` are its last ones, stdout and stderr together; `heard` gets each line."""

    def __init__(
        self,
        command: Sequence[str | Path],
        *,
        folder: Path = ROOT,
        stdin: int | None = DEVNULL,
        heard: Callable[[str], None] | None = None,
        **environment: str,
    ) -> None:
        self.command = [str(word) for word in command]
        self.name = " ".join(Path(word).name for word in self.command[:3])
        self.lines: list[str] = []
        self._heard = heard
        self.ended = False
        self._news = threading.Condition()
        self.process = Popen(
            self.command,
            cwd=folder,
            stdin=stdin,
            stdout=PIPE,
            stderr=STDOUT,
            encoding="utf-8",
            errors="replace",
            env={**os.environ, **READABLE, **environment},
            # In our own group elsewhere: there the terminal's Ctrl-C reaches it too.
            **(GROUP if sys.platform == "win32" else {}),
        )
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self) -> None:
        assert self.process.stdout
        with self.process.stdout:
            for line in self.process.stdout:
                text = line.rstrip("\r\n")
                if self._heard:
                    self._heard(text)
                with self._news:
                    self.lines.append(text)
                    del self.lines[:-MOST_LINES]
                    self._news.notify_all()
        with self._news:
            self.ended = True
            self._news.notify_all()

    def wait_for(self, pattern: str, limit: float = TIMEOUT, start: int = 0) -> re.Match[str]:
        """The first match of a regular expression in a line from number `start` on, or KitError."""
        deadline = time.monotonic() + limit
        with self._news:
            while True:
                for line in self.lines[start:]:
                    if match := re.search(pattern, line):
                        return match
                if self.ended:
                    last = next((line.strip() for line in reversed(self.lines) if line.strip()), "none")
                    raise KitError(f"{self.name} ended; its last line: {last}")
                if not self._news.wait(deadline - time.monotonic()) and time.monotonic() >= deadline:
                    raise KitError(f"{self.name} was silent for {limit:g} s; is the machine busy?")

    def endpoints(self) -> dict[str, str]:
        """Where the server listens, by its ready line and by those before it, such as `snapshots on E2`."""
        self.wait_for(r"^listening on (tcp|http)://\S+$")
        said = [match for line in self.lines if (match := re.match(r"(\w+) on ((?:tcp|http)://\S+)$", line))]
        found = {match[1]: match[2] for match in said}
        return {"endpoint": found.pop("listening"), **found}

    def end(self, moment: float = 0) -> None:
        """End it if it still runs after so many seconds, and read its last lines."""
        stop(self.process, moment)
        self.reader.join(GOODBYE)
        if self.process.stdin:
            # It may not have lived to read the last line.
            with suppress(BrokenPipeError):
                self.process.stdin.close()


def run_in_terminal(command: Sequence[str | Path], folder: Path = ROOT) -> int:
    process = Popen(command, cwd=folder, env={**os.environ, **READABLE})
    try:
        return wait(process, Path(command[1]).name)
    except KeyboardInterrupt:
        return 130
    finally:
        with uninterrupted():
            stop(process, MOMENT)


def stop(process: Popen[Any], moment: float = 0) -> None:
    """Ask a program to end that still runs after so many seconds; what does not listen is ended all the same."""
    try:
        process.wait(moment)
    except TimeoutExpired:
        ask_to_end(process)
        try:
            process.wait(GOODBYE)
        except TimeoutExpired:
            process.kill()
            process.wait()


@dataclass
class Result:
    """How a command ended: its exit code and everything it printed."""

    code: int
    output: str

    @property
    def ok(self) -> bool:
        return self.code == 0

    def first(self, *words: str) -> str:
        """The first printed line with one of the words, or the one that names what was raised, or the last."""
        lines = [line.strip() for line in self.output.splitlines() if line.strip()] or ["no output"]
        if any("Traceback (most recent call last)" in line for line in lines):
            return lines[-1]
        # .NET names it before the stack, and Python after.
        return next((line for line in lines if any(word in line for word in (*words, "Exception"))), lines[-1])


def quietly(command: Command, limit: float, env: Environment = None, cwd: Path | None = None) -> Result:
    """Run a command to its end without showing it; one that takes longer than `limit` seconds is ended."""
    words = [str(word) for word in command]
    try:
        process = spawn(words, cwd, env, stdin=DEVNULL, stdout=PIPE, stderr=STDOUT)
    except OSError as error:
        # It is not there, may not be run, or is no program at all.
        return Result(127, str(error))
    try:
        output, _ = process.communicate(timeout=limit)
    except BaseException as error:
        end(process)
        if isinstance(error, TimeoutExpired):
            return Result(124, f"{Path(words[0]).name} did not end within {limit:.0f} s")
        raise
    return Result(process.returncode, output.decode("utf-8", "replace").replace("\r\n", "\n"))


def spawn(words: Sequence[str], cwd: Path | None = None, env: Environment = None, **streams: Any) -> Popen[bytes]:
    """Start a program that `end` can end with all that it starts: dotnet and pip start others."""
    return Popen(words, env={**os.environ, **READABLE, **(env or {})}, cwd=cwd, **GROUP, **streams)


def heard(words: Sequence[str], cwd: Path, listens: Callable[[], bool]) -> Generator[str, None, None]:
    """Start a program, and give its lines as they come, until it ends or nobody listens; then it is ended."""
    process = spawn(words, cwd, stdin=DEVNULL, stdout=PIPE, stderr=STDOUT)

    def watch() -> None:
        while process.poll() is None:
            if not listens():
                end(process)
            time.sleep(0.1)

    threading.Thread(target=watch, daemon=True).start()
    try:
        while line := process.stdout.readline(LONGEST_LINE) if process.stdout else b"":
            yield line.decode("utf-8", "replace").rstrip("\r\n")
    finally:
        end(process)


def wait(process: Popen[Any], name: str) -> int:
    """The exit code of a program; in slices, because on Windows a wait without a limit is deaf to Ctrl-C."""
    while (code := process.poll()) is None:
        time.sleep(0.05)
    if code >= 0:
        return code
    if code != -signal.SIGINT:
        # A killed program has no last line, and a shell speaks only of the programs that it started itself.
        memory = "; is the memory full?" if code == -9 else ""
        say(f"{name} was ended by signal {-code} ({signal.strsignal(-code)}){memory}")
    # As shells count it.
    return 128 - code


def end(process: Popen[bytes], limit: float = GOODBYE) -> None:
    """Pass Ctrl-C on to a program of `spawn`, wait for it to clear up, and end what is left of it and its own."""
    with uninterrupted():
        signal_all(process, "SIGINT")
        with suppress(TimeoutExpired):
            process.wait(limit)
        signal_all(process, "SIGKILL")
        process.kill()
        process.wait()


def signal_all(process: Popen[bytes], name: str) -> None:
    if sys.platform != "win32":
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, getattr(signal, name))
    elif name == "SIGINT":
        ask_to_end(process)
    else:
        subprocess.run(["taskkill", "/T", "/F", "/PID", str(process.pid)], stdout=DEVNULL, stderr=DEVNULL)


def ask_to_end(process: Popen[Any]) -> None:
    """Ask a program to end: SIGTERM; on Windows Ctrl-Break, for which it needs the flags of GROUP."""
    if sys.platform != "win32":
        process.terminate()
    elif process.poll() is None:
        try:
            process.send_signal(signal.CTRL_BREAK_EVENT)
        except OSError:
            # There is no console to send it through.
            process.terminate()


def step(what: str, command: Command, limit: float, env: Environment = None, cwd: Path | None = None) -> Result:
    """A long step: says what it does before it starts, and how long it took."""
    say(f"{what} …")
    start = time.monotonic()
    result = quietly(command, limit, env, cwd)
    if result.ok:
        say(f"{what}: done in {time.monotonic() - start:.0f} s")
    return result
