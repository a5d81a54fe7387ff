"""What a person sees: progress lines, colours on a terminal only, and commands that say when they fail."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, TextIO

# What asks a program to end. The last is Windows' own.
ENDS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
SCREEN = threading.Lock()
# In a pipe Windows would use another encoding, and Python would keep the lines back.
READABLE = {"PYTHONUNBUFFERED": "1", "PYTHONUTF8": "1", "PYTHONIOENCODING": "utf-8"}
# Ctrl-C for a program and all that it starts is a signal for its group. Windows calls the group's signal Ctrl-Break.
GROUP: dict[str, Any] = {"start_new_session": True}
if sys.platform == "win32":
    GROUP = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
COLOURS = {"server": "36", "client": "33", "kit": "32", "error": "31"}


def coloured(text: str, colour: str, stream: TextIO | None = None) -> str:
    """The text in the colour of its speaker, where the stream (or else stdout) is a terminal that shows colours."""
    return f"\033[{COLOURS[colour]}m{text}\033[0m" if shows_colours(stream or sys.stdout) else text


def shows_colours(stream: TextIO) -> bool:
    """False for a file and for a pipe, where NO_COLOR asks for none, and on a terminal that would print rubbish."""
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb" or not stream.isatty():
        return False
    return sys.platform != "win32" or windows_console(stream)


def windows_console(stream: TextIO) -> bool:
    """Windows shows colours only when it is asked to, and a console older than Windows 10 refuses."""
    if sys.platform == "win32":
        import ctypes
        import msvcrt

        handle, mode = msvcrt.get_osfhandle(stream.fileno()), ctypes.c_ulong()
        kernel = ctypes.windll.kernel32
        virtual_terminal = 4
        if kernel.GetConsoleMode(handle, ctypes.byref(mode)):
            return bool(kernel.SetConsoleMode(handle, mode.value | virtual_terminal))
    return False


def show(speaker: str, line: str) -> None:
    """One line behind the name of its speaker, whole even when two speak at once."""
    with SCREEN:
        try:
            print(coloured(f"{speaker:6} |", speaker), line, flush=True)
        except BrokenPipeError:
            nobody_reads()


def nobody_reads() -> None:
    """Who reads our output has gone, as in `kit.py run 1 | head`: go on without a word."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def say(text: str) -> None:
    """One line of kit.py itself."""
    show("kit", text)


class Result:
    """How a command ended: its exit code and everything it printed."""

    def __init__(self, code: int, output: str) -> None:
        self.code = code
        self.output = output

    @property
    def ok(self) -> bool:
        return self.code == 0

    def first(self, *words: str) -> str:
        """The first printed line with one of the words, or the last line."""
        lines = [line.strip() for line in self.output.splitlines() if line.strip()]
        return next(
            (line for line in lines if any(word in line for word in words)), lines[-1] if lines else "no output"
        )


def quietly(
    command: Sequence[str | Path], limit: float, env: Mapping[str, str] | None = None, cwd: Path | None = None
) -> Result:
    """Run a command to its end without showing it; one that takes longer than `limit` seconds is ended."""
    words = [str(word) for word in command]
    process = None
    try:
        with later():
            process = spawn(words, env, cwd, shown=False)
        output, _ = process.communicate(timeout=limit)
    except FileNotFoundError:
        return Result(127, f"{words[0]}: not found")
    except OSError as error:
        # It may not be run, or is no program at all.
        return Result(126, str(error))
    except BaseException as error:
        if process:
            end(process)
        if not isinstance(error, subprocess.TimeoutExpired):
            raise
        return Result(124, f"{Path(words[0]).name} did not end within {limit:.0f} s")
    return Result(process.returncode, output.decode("utf-8", "replace").replace("\r\n", "\n"))


def spawn(
    words: Sequence[str], env: Mapping[str, str] | None = None, cwd: Path | None = None, shown: bool = True
) -> subprocess.Popen[bytes]:
    """Start a program that `end` can end with all that it starts: dotnet and pip start others."""
    return subprocess.Popen(
        words,
        env={**os.environ, **READABLE, **(env or {})},
        cwd=cwd,
        stdin=None if shown else subprocess.DEVNULL,
        stdout=None if shown else subprocess.PIPE,
        stderr=None if shown else subprocess.STDOUT,
        **GROUP,
    )


def wait(process: subprocess.Popen[Any]) -> int:
    """The exit code of a program; in slices, because on Windows a wait without a limit is deaf to Ctrl-C."""
    while True:
        try:
            return process.wait(0.2)
        except subprocess.TimeoutExpired:
            pass


def end(process: subprocess.Popen[bytes], limit: float = 5.0) -> None:
    """Pass Ctrl-C on to a program of `spawn`, wait for it to clear up, and end what is left of it and its own."""
    with uninterrupted():
        signal_all(process, "SIGINT")
        try:
            process.wait(limit)
        except subprocess.TimeoutExpired:
            pass
        signal_all(process, "SIGKILL")
        process.kill()
        process.wait()


def signal_all(process: subprocess.Popen[bytes], name: str) -> None:
    """Signal a program of `spawn` and all that it started."""
    if sys.platform != "win32":
        try:
            os.killpg(process.pid, getattr(signal, name))
        except (ProcessLookupError, PermissionError):
            pass
    elif process.poll() is None:
        if name == "SIGINT":
            ask_to_end(process)
        else:
            command = ["taskkill", "/T", "/F", "/PID", str(process.pid)]
            subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def ask_to_end(process: subprocess.Popen[Any]) -> None:
    """Ask a program to end: SIGTERM; on Windows Ctrl-Break, for which it needs the flags of GROUP."""
    if sys.platform != "win32":
        process.terminate()
    elif process.poll() is None:
        try:
            process.send_signal(signal.CTRL_BREAK_EVENT)
        except OSError:
            # There is no console to send it through.
            process.terminate()


def interruptible() -> None:
    """Whatever asks us to end, `kill` and a closed terminal too, is a KeyboardInterrupt, so that we clear up."""
    for name in ENDS:
        # One that is ignored was ignored on purpose: nohup does so.
        if hasattr(signal, name) and signal.getsignal(getattr(signal, name)) != signal.SIG_IGN:
            signal.signal(getattr(signal, name), signal.default_int_handler)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """A second Ctrl-C does not stop the clearing up, which ends by itself."""
    with handling(signal.SIG_IGN):
        yield


@contextmanager
def later() -> Iterator[None]:
    """A Ctrl-C inside is raised at the end: in the middle of starting a program it would leave one unknown behind."""
    came: list[int] = []
    # A handler, and not SIG_IGN, which the program would inherit.
    with handling(lambda number, _: came.append(number)):
        yield
    if came:
        raise KeyboardInterrupt


@contextmanager
def handling(how: Callable[[int, FrameType | None], None] | signal.Handlers) -> Iterator[None]:
    """Inside, what asks us to end is handled like this; what is ignored stays so. Only the main thread may say that."""
    found = {}
    if threading.current_thread() is threading.main_thread():
        for name in ENDS:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) not in (signal.SIG_IGN, None):
                found[number] = signal.signal(number, how)
    try:
        yield
    finally:
        for number, handler in found.items():
            signal.signal(number, handler)


def step(what: str, command: Sequence[str | Path], limit: float, env: Mapping[str, str] | None = None) -> Result:
    """A long step: says what it does before it starts, and how long it took."""
    say(f"{what} …")
    start = time.monotonic()
    result = quietly(command, limit, env)
    if result.ok:
        say(f"{what}: done in {time.monotonic() - start:.0f} s")
    return result
