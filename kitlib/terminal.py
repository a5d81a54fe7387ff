"""What a person sees: whole lines behind the name of their speaker, with colours on a terminal only."""

from __future__ import annotations

import os
import sys
import threading
from typing import TextIO

SCREEN = threading.Lock()
COLOURS = {"server": "36", "client": "33", "kit": "32", "tap": "35", "error": "31"}


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
