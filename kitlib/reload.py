"""What stands behind `server N --reload`: a program that is started anew when one of its Python files is saved."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Sequence
from pathlib import Path

from kitlib.programs import end, spawn
from kitlib.terminal import say

# Seconds between two looks at the files.
INTERVAL = 0.3
Files = dict[Path, tuple[int, int]]


def run_reloading(command: Sequence[str], folders: Sequence[Path]) -> int:
    """Run it until Ctrl-C. Where a saved file has a mistake, it ends, and the next save starts it again."""
    process: subprocess.Popen[bytes] | None = None
    try:
        while True:
            seen = files(folders)
            process = spawn(command)
            names = wait_for_save(folders, seen, process)
            # Only now: it holds the port until it has ended.
            end(process)
            say(f"{', '.join(names)} saved: starting anew")
    except KeyboardInterrupt:
        return 130
    finally:
        if process:
            end(process)


def wait_for_save(folders: Sequence[Path], seen: Files, process: subprocess.Popen[bytes]) -> list[str]:
    """The names of the files that are not what was seen, once nobody writes them any more."""
    told = False
    before = seen
    while True:
        if process.poll() is not None and not told:
            told = True
            say("the server has ended; the next save starts it again, Ctrl-C ends this")
        time.sleep(INTERVAL)
        now = files(folders)
        # Many an editor writes in two steps, or writes another file and renames it.
        if now != seen and now == before:
            return sorted({path.name for path, _ in now.items() ^ seen.items()})
        before = now


def files(folders: Sequence[Path]) -> Files:
    """The Python files of these folders, with the time of the last change and the size of each."""
    found: Files = {}
    # Not what lies below: a reader's own may be a home folder.
    for path in (path for folder in folders for path in [*folder.glob("*.py"), *folder.glob("*/*.py")]):
        try:
            status = path.stat()
        except OSError:
            # It was renamed a moment ago, is a link to nowhere, or somebody else's.
            continue
        found[path] = (status.st_mtime_ns, status.st_size)
    return found
