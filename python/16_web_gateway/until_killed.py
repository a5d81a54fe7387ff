"""Lesson 16, the gateway's end: at once, whatever is under way, and without the noise of strangers until then."""

import asyncio
import logging
import os
import signal
import sys
import threading
import traceback
from collections.abc import Coroutine
from typing import Any

from aiohttp.http import HttpProcessingError


def run_until_killed(serve: Coroutine[Any, Any, None]) -> None:
    """Ctrl-C and SIGTERM end the process here and now, with code 0.

    A KeyboardInterrupt may be caught within Socket.IO, and its tasks are not cancelled for ten seconds and more.
    """
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        # As it should be.
        pass
    else:
        serve.close()
        sys.exit("a loop runs here already, as in a notebook: start this as a program of its own, subprocess.Popen")
    # A thread leaves the end to the main one.
    if threading.current_thread() is threading.main_thread():
        for each in (signal.SIGINT, getattr(signal, "SIGBREAK", signal.SIGTERM)):
            signal.signal(each, lambda *_: os._exit(0))
    # Our own mistakes may be printed; not the noise of a stranger who does not speak HTTP.
    # Until 3.9 aiohttp pings also a browser that is gone, in a task of its own, of which asyncio tells.
    for name in ("aiohttp.server", "asyncio"):
        logging.getLogger(name).addFilter(is_our_own)
    # ZeroMQ's sockets are no files of Windows' own event loop.
    with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:
        try:
            runner.run(serve)
        except ValueError as error:
            # An endpoint whose host is none.
            print(error, file=sys.stderr)
            sys.exit(2)


def is_our_own(record: logging.LogRecord) -> bool:
    """Strangers speak no HTTP, leave in the middle of a word, or send packets that are none to Engine.IO."""
    error = record.exc_info[1] if record.exc_info else None
    calls = [frame.f_globals["__name__"] for frame, _ in traceback.walk_tb(error.__traceback__)] if error else [""]
    noise = calls[-1].startswith("engineio.") or "Transport is closing" in str(error)
    return not noise and not isinstance(error, HttpProcessingError | ConnectionError)
