"""What is raised when something will not be done, though nobody waited too long for it: that is a TimeoutError."""

import shlex
import subprocess
import sys


class GaveUp(Exception):
    """It was refused or aborted, and the text says by whom and why. A program prints it and ends with code 1."""


def tried(count: int) -> str:
    """How often, in words."""
    return "1 try" if count == 1 else f"{count} tries"


def longer(first: float, tries: int) -> float:
    """How long to wait after so many tries in vain: each time twice as long, up to 8 times the first.

    A new connection takes several round trips. On a slow line only a longer wait ever succeeds.
    """
    return first * 2.0 ** min(tries, 3)


def pip_install(*words: str) -> str:
    """The command that installs these for the Python that runs this."""
    return shell(sys.executable, "-m", "pip", "install", *words)


def shell(*words: str) -> str:
    """A command as this system's shell takes it."""
    return subprocess.list2cmdline(words) if sys.platform == "win32" else shlex.join(words)
