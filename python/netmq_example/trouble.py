"""Trouble: a server loads this only when there is some, and a client also for its retries.

    report = Trouble(log.warning)
    report("unknown channel")                      logs: trouble: unknown channel (and 300 more)

Many messages that are wrong must not fill a disk, so a mistake is a line a second at most. The servers of lessons 09 to
11 report by it, and so do lesson 13's managers and carriers. In C# it is Trouble in SideChannelManager.cs.
"""

import logging
import os
import signal
import socket
import threading
import time
import traceback
from collections.abc import Callable

from netmq_example import console
from netmq_example.errors import Misfit

PAUSE_SECONDS = 1.0
# So long a name server may take, in seconds; the system itself might wait for half a minute.
LOOK_UP_SECONDS = 3.0
log = logging.getLogger("netmq_example.server")


def ends_program(error: BaseException) -> bool:
    """Whether it is none of a peer's business: SystemExit or Ctrl-C on the main thread. Another thread would end alone,
    and nobody would hear of it.
    """
    return not isinstance(error, Exception) and threading.current_thread() is threading.main_thread()


def shown(error: BaseException) -> str:
    try:
        return repr(error)
    except Exception:
        return type(error).__name__


class Trouble:
    def __init__(self, show: Callable[[str], object]) -> None:
        self.show = show
        self.silent_until = 0.0
        self.left_out = 0

    def __call__(self, line: str) -> None:
        if time.monotonic() < self.silent_until:
            self.left_out += 1
            return
        more = f" (and {self.left_out} more)" if self.left_out else ""
        self.show(f"trouble: {line}{more}")
        self.silent_until = time.monotonic() + PAUSE_SECONDS
        self.left_out = 0


# Each mistake that was made, by its place in the code. Each has its own line a second.
again: dict[tuple[object, ...], Trouble] = {}


def told(error: BaseException) -> str:
    """The reply to a request that an exception has ended, which is also logged.

    With its traceback the first time; then it is a line a second at most, since a client may go on asking.
    """
    if ends_program(error):
        raise error
    places = [(frame.f_code.co_filename, line) for frame, line in traceback.walk_tb(error.__traceback__)]
    # Two servers of one program may fail in the same place, and come there on different ways.
    mistake = (type(error), *places[:4], places[-1])
    first = mistake not in again
    report = again.setdefault(mistake, Trouble(log.error))
    text = str(error) if isinstance(error, Misfit) else shown(error)
    if first and not isinstance(error, Misfit):
        log.error("a mistake in answer", exc_info=error)
    else:
        report(text)
    return f"error: {console.printable(text, LONGEST_MISTAKE)}"


# In characters. A longer reply than the limit would be dropped by the client, with the connection.
LONGEST_MISTAKE = 1000


def cure(endpoint: str, otherwise: str) -> str:
    """Says where to look when nothing came: at the host's name, if that is unknown. libzmq itself never says so."""
    unknown = unknown_host(endpoint)
    return f"{unknown}: is it spelt so, and is the network there?" if unknown else otherwise


def unknown_host(endpoint: str) -> str:
    """The line about a host that has no address. An empty text: it has one, or no name server says anything."""
    scheme, _, place = endpoint.partition("://")
    host = place.rpartition(":")[0]
    unknown: list[str] = []

    def look_up() -> None:
        try:
            socket.getaddrinfo(host, None)
        except (OSError, UnicodeError):
            unknown.append(f"unknown host '{host}'")

    if scheme not in ("beacon", "ipc", "inproc"):
        thread = threading.Thread(target=look_up, daemon=True, name="netmq_example look-up")
        thread.start()
        thread.join(LOOK_UP_SECONDS)
    return "".join(unknown)


def tried(count: int) -> str:
    return "1 try" if count == 1 else f"{count} tries"


def longer(first: float, tries: int) -> float:
    """How long to wait after so many tries in vain: each time twice as long, up to 8 times the first.

    A new connection takes several round trips. On a slow line only a longer wait ever succeeds.
    """
    return first * 2.0 ** min(tries, 3)


def at_eof() -> None:
    """Ctrl-C, as soon as nobody can write to standard input: who started this program closed it, or is gone."""
    try:
        while os.read(0, 4096):
            pass
    except OSError:
        # There is none.
        pass
    console.later(signal.SIGINT)
