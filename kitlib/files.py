"""Files that are written whole or not at all."""

from __future__ import annotations

import hashlib
import os
import shutil
import time
from pathlib import Path


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


def replace(source: Path, target: Path) -> None:
    """Move a file; on Windows a virus scanner or Unity's importer may have the old one open for a moment."""
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
