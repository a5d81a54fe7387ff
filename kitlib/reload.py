"""`server N --reload` starts a program anew when one of its Python files is saved, and
when a signal has ended it, as an assertion of libzmq's does.
"""

import subprocess
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from kitlib.programs import GOODBYE, end, spawn
from kitlib.terminal import say

# Seconds between two looks at the files.
INTERVAL = 0.3
# A program's own exit codes: done, a mistake, wrong usage. Every other one is a signal's, or Windows' own.
BY_ITSELF = (0, 1, 2)
Files = dict[Path, tuple[int, int]]


def run_reloading(command: Sequence[str], folders: Sequence[Path]) -> int:
    """Run it until Ctrl-C. Where a saved file has a mistake, it ends by itself, and the next save starts it again."""
    process: subprocess.Popen[bytes] | None = None
    try:
        while True:
            seen = files(folders)
            process = spawn(command)
            why = wait_for_reason(folders, seen, process)
            # Only now: it holds the port until it has ended.
            end(process)
            say(f"{why}: starting anew")
    except KeyboardInterrupt:
        return 130
    finally:
        if process:
            # It has a group of its own, and would go on if who ends us lost patience first.
            end(process, GOODBYE / 2)


def wait_for_reason(folders: Sequence[Path], seen: Files, process: subprocess.Popen[bytes]) -> str:
    """That it was killed, or the names of the files that are not what was seen, once nobody writes them any more."""
    told = False
    before = seen
    while True:
        if process.poll() not in (None, *BY_ITSELF):
            # So a server that is killed at each start leaves the machine some time.
            time.sleep(INTERVAL)
            return "the server was killed"
        if process.poll() is not None and not told:
            told = True
            say("the server has ended; the next save starts it again, Ctrl-C ends this")
        time.sleep(INTERVAL)
        now = files(folders)
        # Many an editor writes in two steps, or writes another file and renames it.
        if now != seen and now == before:
            return f"{', '.join(sorted({path.name for path, _ in now.items() ^ seen.items()}))} saved"
        before = now


def files(folders: Sequence[Path]) -> Files:
    """The Python files of these folders, with the time of the last change and the size of each."""
    found: Files = {}
    # Not what lies below: a reader's own may be a home folder.
    for path in (path for folder in folders for path in [*folder.glob("*.py"), *folder.glob("*/*.py")]):
        # It may have been renamed a moment ago, be a link to nowhere, or somebody else's.
        with suppress(OSError):
            status = path.stat()
            found[path] = (status.st_mtime_ns, status.st_size)
    return found
