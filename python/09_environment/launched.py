"""Lesson 09, a launched simulator: found by its path, and ended with all that it has started.

It needs only Python.
"""

import contextlib
import glob
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence


def game(path: str) -> str:
    """The program that is meant by a build's path: each system has an ending, or a folder, of its own for it."""
    if program := shutil.which(path):
        return os.path.abspath(program)
    ending = {"win32": ".exe", "darwin": ".app/Contents/MacOS/*"}.get(sys.platform, ".x86_64")
    for way in (glob.escape(path), glob.escape(path) + ending):
        for found in filter(os.path.isfile, sorted(glob.glob(way))):
            # What was unpacked from an archive may have forgotten that it is a program.
            if not os.access(found, os.X_OK):
                os.chmod(found, 0o755)
            return os.path.abspath(found)
    raise FileNotFoundError(f"no game at {path}: there is neither this file nor {path}{ending}")


def start(words: Sequence[str]) -> subprocess.Popen[bytes]:
    """In a session of its own, so that all of it can be ended; Ctrl-C is then for Python alone, which ends it."""
    return subprocess.Popen(words, start_new_session=True)


def end(process: subprocess.Popen[bytes]) -> None:
    """Let it end by itself for a moment, then end what is left: the simulator may be a child, as of `dotnet run`."""
    try:
        process.wait(2)
    except subprocess.TimeoutExpired:
        pass
    finally:
        if sys.platform == "win32":
            subprocess.run(["taskkill", "/T", "/F", "/PID", str(process.pid)], capture_output=True, check=False)
        else:
            # Nobody may be left.
            with contextlib.suppress(OSError):
                os.killpg(process.pid, signal.SIGKILL)
        process.wait()
