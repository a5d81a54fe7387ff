"""What a person sees: progress lines, colours on a terminal only, and commands that say when they fail."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

SCREEN = threading.Lock()
COLOURS = {"server": "36", "client": "33", "kit": "32", "error": "31"}


def coloured(text: str, colour: str) -> str:
    """The text in the colour of its speaker, unless it goes to a file or NO_COLOR asks for none."""
    if not sys.stdout.isatty() or os.environ.get("NO_COLOR"):
        return text
    return f"\033[{COLOURS[colour]}m{text}\033[0m"


def show(speaker: str, line: str) -> None:
    """One line behind the name of its speaker, whole even when two speak at once."""
    with SCREEN:
        print(coloured(f"{speaker:6} |", speaker), line, flush=True)


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
    try:
        done = subprocess.run(
            words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=limit,
            env={**os.environ, **(env or {})},
            cwd=cwd,
            text=True,
            encoding="utf-8",
            errors="replace",
        )
    except FileNotFoundError:
        return Result(127, f"{words[0]}: not found")
    except PermissionError as error:
        return Result(126, str(error))
    except subprocess.TimeoutExpired:
        return Result(124, f"{Path(words[0]).name} did not end within {limit:.0f} s")
    return Result(done.returncode, done.stdout)


def step(what: str, command: Sequence[str | Path], limit: float, env: Mapping[str, str] | None = None) -> Result:
    """A long step: says what it does before it starts, and how long it took."""
    say(f"{what} …")
    start = time.monotonic()
    result = quietly(command, limit, env)
    if result.ok:
        say(f"{what}: done in {time.monotonic() - start:.0f} s")
    return result
