"""Lesson 08, a recording: one drive in a folder of its own.

    IMG/center_000120.jpg      a picture for each camera; what came as JPEG is kept to the byte
    driving_log.csv            the seven columns of Udacity's simulator, speed in miles per hour
    metadata.csv               all that is known about each picture, also for Hugging Face's imagefolder

A picture is written before the rows about it: when the program is killed, at most the last one is lost. The columns
`answered_throttle` and so on are what was answered to this very picture.
It needs numpy and Pillow.
"""

import contextlib
import errno
import os
import sys
import time
from pathlib import Path
from typing import Any

from pictures import encode

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Message

UDACITY = ("center", "left", "right", "steering", "throttle", "brake", "speed")
# As they were in force when the picture was taken, and what was answered to it.
KNOWN = ("frame", "sim_time", "wall_time", "throttle", "brake", "steer", "speed", "manual", "encoding")
ANSWERED = ("throttle", "brake", "steer")
METADATA = (*KNOWN, "width", "height", *(f"answered_{name}" for name in ANSWERED))
MILES_PER_HOUR = 3600 / 1609.344


class Table:
    """A csv file. What was added since the last `keep` can be undone: a full disk leaves no half rows."""

    def __init__(self, path: Path, columns: tuple[str, ...]) -> None:
        # Exclusive: what is there already is never written over. Without a buffer a row is in the file at once.
        self.file, self.end = path.open("xb", buffering=0), 0
        self.add(columns)
        self.keep()

    def add(self, row: tuple[Any, ...]) -> None:
        line = (",".join(map(str, row)) + "\n").encode()
        if self.file.write(line) != len(line):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def keep(self) -> None:
        self.end = self.file.tell()

    def undo(self) -> None:
        self.file.seek(self.file.truncate(self.end))


class Recording:
    """One drive: pictures of the same cameras, in one size."""

    def __init__(self, folder: Path, cameras: str) -> None:
        self.folder, self.count, self.used = new_folder(folder), 0, time.monotonic()
        (self.folder / "IMG").mkdir()
        files = tuple(f"{name}_file_name" for name in cameras.split(",")) if "," in cameras else ("file_name",)
        self.tables = (
            Table(self.folder / "metadata.csv", files + METADATA),
            Table(self.folder / "driving_log.csv", UDACITY),
        )

    def add(self, frame: Message, action: Message, seen: dict[str, Any]) -> None:
        """All of it or nothing, whatever happens in between."""
        self.used = time.monotonic()
        values, (metadata, log) = frame.values, self.tables
        height, width, _ = next(iter(seen.values())).shape
        paths = {name: f"IMG/{name}_{frame.id:06}.jpg" for name in seen}
        if any((self.folder / path).exists() for path in paths.values()):
            # It was sent again.
            return
        known = (*(values[name] for name in KNOWN), width, height, *(action.values[name] for name in ANSWERED))
        try:
            for array, (name, path) in zip(frame.arrays, paths.items(), strict=True):
                file = bytes(array.data) if values["encoding"] == "jpeg" else encode(seen[name])
                (self.folder / path).write_bytes(file)
            metadata.add((*paths.values(), *known))
            driven = values["steer"], values["throttle"], values["brake"], values["speed"] * MILES_PER_HOUR
            log.add((*(paths.get(name, "") for name in UDACITY[:3]), *driven))
        except BaseException:
            for undo in (metadata.undo, log.undo, *((self.folder / path).unlink for path in paths.values())):
                with contextlib.suppress(OSError):
                    undo()
            raise
        metadata.keep()
        log.keep()
        self.count += 1


def new_folder(parent: Path) -> Path:
    """The one after the last that is there; another program may take it first."""
    parent.mkdir(parents=True, exist_ok=True)
    number = max((int(path.name[4:]) for path in parent.glob("run_*") if path.name[4:].isdecimal()), default=0)
    while True:
        number += 1
        with contextlib.suppress(FileExistsError):
            (folder := parent / f"run_{number:04}").mkdir()
            return folder
