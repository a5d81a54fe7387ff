"""A person sees whole lines behind the name of their speaker, with colours on a terminal only."""

import errno
import os
import re
import shlex
import sys
import threading
from pathlib import Path
from typing import TextIO

SCREEN = threading.Lock()
COLOURS = {"server": "36", "client": "33", "kit": "32", "tap": "35", "error": "31"}


def open_streams() -> None:
    """Without a console, or with `>&-`, what is printed goes nowhere; and so it does of a program that we start."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            # It takes the closed one's number, by which a program that we start finds it.
            number = os.open(os.devnull, os.O_RDWR)
            os.set_inheritable(number, True)
            setattr(sys, name, os.fdopen(number, mode, encoding="utf-8"))


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

        # Its usual mode, which is 1 and 2, and besides that of a virtual terminal.
        return bool(ctypes.windll.kernel32.SetConsoleMode(msvcrt.get_osfhandle(stream.fileno()), 1 | 2 | 4))
    return False


def show(speaker: str, line: str) -> None:
    """One line behind the name of its speaker, whole even when two speak at once."""
    with SCREEN:
        try:
            print(coloured(f"{speaker:6} |", speaker), line, flush=True)
        except OSError as error:
            nobody_reads()
            if error.errno == errno.ENOSPC:
                print(f"kit    | {error}; free some space: what follows is not written", file=sys.stderr)


def nobody_reads() -> None:
    """Nobody takes our output any more, as in `kit.py run 1 | head`: go on without a word."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def say(text: str) -> None:
    show("kit", text)


def command(*words: str | Path) -> str:
    """A line for the terminal. To PowerShell what begins with a quotation mark is a text, unless & comes first."""
    texts = [str(word) for word in words]
    if os.name != "nt":
        return shlex.join(texts)
    if any(re.search("[$`]", text) for text in texts):
        inside = "' '".join(text.replace("'", "''") for text in texts)
        return f"& '{inside}'   (in PowerShell)"
    line = " ".join(text if re.fullmatch(r"[\w.:\\/+=-]+", text) else f'"{text}"' for text in texts)
    return f"& {line}   (in a command prompt without the &)" if line.startswith('"') else line
