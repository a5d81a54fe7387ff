"""What the kit raises about the other side or the network. A wrong argument stays a ValueError or a TypeError.

    Error
      Timeout         is a TimeoutError       nothing came in time; it may have been done
      Refused         code, text, id          the other side answered with an error
      MessageError    is a ValueError         bytes, or a Message, that break the standard on this side
      Closed                                  closed meanwhile, by this program
      Lost            is a ConnectionError    the other side was there and is gone
      ListenError     is an OSError           a server cannot have its port

All of them can be pickled. A program that ends by one prints its text, and its exit code is 1.
"""

import shlex
import subprocess
import sys
import warnings
from typing import TYPE_CHECKING, Any


class Error(Exception):
    """What the kit raises about the other side or the network; its text names cause and cure."""


class Timeout(Error, TimeoutError):
    """Nothing came in time. What was asked may have been done or not."""


class Closed(Error):
    """This program closed or stopped it meanwhile."""


class Lost(Error, ConnectionError):
    """The other side was there and is gone."""


class ListenError(Error, OSError):
    """A server cannot listen where it should: most often another one has the port."""

    # An OSError's own text begins with its number.
    def __str__(self) -> str:
        return str(self.strerror)


class Coded(Error):
    """An error with a code for programs, a text for people, and the id of a message, 0 where it has none."""

    code: str
    text: str
    id: int

    def __init__(self, code: str, text: str = "", id: int = 0) -> None:
        whole = f"{code}: {text}" if text else str(code)
        if not text:
            # Pickle and AsyncVectorEnv, which bring an error from another process, have one argument for it.
            code, _, text = whole.partition(": ")
            if text and " " in code:
                # It is a sentence, and has no code of its own.
                code, text = "error", whole
        super().__init__(whole)
        self.code, self.text, self.id = code, text, id


class Refused(Coded):
    """The other side answered with an error: its `code`, its `text`, and the `id` of the request."""


class MessageError(Coded, ValueError):
    """Bytes or a Message that break the standard: a `code`, a `text`, and the message's `id` where it has one."""


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


# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        if name == "GaveUp":
            warnings.warn("GaveUp is netmq_example.Error now, and ends", DeprecationWarning, stacklevel=2)
            return Error
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
