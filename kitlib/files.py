"""Files that are written whole or not at all, and by one process at a time."""

import hashlib
import os
import shutil
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from kitlib.lessons import KitError

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl


def put(path: Path, data: bytes) -> None:
    """Write one: beside it first, and so on the same disk, where a full disk or a Ctrl-C leaves the old one whole."""
    new = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        new.write_bytes(data)
        replace(new, path)
    finally:
        new.unlink(missing_ok=True)


def keep(path: Path, text: str) -> None:
    """Write a note to ourselves: without it the next run only asks again."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        put(path, text.encode())


def news(folder: Path, files: Mapping[str, bytes], known: Mapping[str, str], otherwise: str) -> dict[str, bytes]:
    """Those that are not there yet as they are; a KitError if one is neither so nor as it is `known`.

    `otherwise` says what it is then; without these words it may be anything.
    """
    there = {name: digest((folder / name).read_bytes()) for name in files if (folder / name).exists()}
    found = {name: data for name, data in files.items() if there.get(name) != digest(data)}
    changed = [name for name in found if name in there and there[name] != known.get(name)]
    if changed and otherwise:
        more = f" (and {len(changed) - 1} more)" if len(changed) > 1 else ""
        raise KitError(f"{changed[0]}{more} {otherwise}: nothing was copied; --force overwrites it")
    return found


def place(folder: Path, files: dict[str, bytes]) -> None:
    """Write files by their names in a folder: what can fail fails before the first is moved to its place."""
    # In that folder, and so on the same disk. Not by tempfile, whose folders on Windows are for one account alone, and
    # so would be the files that are moved out of it.
    stage = folder / f".netmqexample-{os.getpid()}"
    try:
        stage.mkdir()
        for number, data in enumerate(files.values()):
            (stage / str(number)).write_bytes(data)
        for name in files:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
        for number, name in enumerate(files):
            replace(stage / str(number), folder / name)
    finally:
        shutil.rmtree(stage, ignore_errors=True)


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Waits until no other process is inside. The system lets go of the lock when a process ends, however it ends."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as file:
        while True:
            try:
                if sys.platform == "win32":
                    msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
                else:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except OSError:
                # Not a wait without a limit in the system, because there Ctrl-C would not be heard on Windows.
                time.sleep(0.1)
        yield


def replace(source: Path, target: Path) -> None:
    """Move a file, which gets the permissions of the old one: of these Git shows one.

    On Windows a virus scanner or Unity's importer may have the old one open for a moment.
    """
    with suppress(FileNotFoundError):
        shutil.copymode(target, source)
    for wait in (0.2, 0.2, 0.0):
        try:
            os.replace(source, target)
            return
        except PermissionError:
            if not wait:
                raise
            time.sleep(wait)


def digest(data: bytes) -> str:
    """Git may have changed the ends of the lines, which is no change."""
    return hashlib.sha256(data.replace(b"\r\n", b"\n")).hexdigest()
