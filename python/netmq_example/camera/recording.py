"""Lesson 08, what was recorded: reads a folder of recording.py back. What cannot be read is said, and left out.

Lesson 08, a recording: one drive in a folder of its own.

    IMG/center_000120.jpg      a picture for each camera; what came as JPEG is kept to the byte
    driving_log.csv            the seven columns of Udacity's simulator, speed in miles per hour
    metadata.csv               all that is known about each picture, also for Hugging Face's imagefolder

A picture is written before the rows about it: when the program is killed, at most the last one is lost. The columns
`answered_throttle` and so on are what was answered to this very picture.
It needs numpy and Pillow.

Lesson 08, the recorder: keeps each drive in a new folder, so that one can learn from it. It deletes nothing.

What is in such a folder stands in recording.py. Two cars at once get a folder each.
It needs numpy and Pillow.
"""

import contextlib
import errno
import math
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from netmq_example.camera.pictures import decode, encode, pictures
from netmq_example.messages import Message, MessageError

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


# Drives at a time, and seconds without a picture after which one is over.
MOST, OVER = 64, 10.0


class Recorder:
    """Keeps what was asked and answered, until it cannot any more: then it says so, and the car drives on."""

    def __init__(self, folder: Path | None) -> None:
        self.folder, self.drives, self.full = folder, dict[Any, Recording](), False

    def add(self, frame: Message, action: Message) -> None:
        """Keep a picture and what was answered to it, unless that was an error."""
        if not self.folder or action.kind != "action":
            return
        try:
            seen = pictures(frame)
            drive = self.drive(frame, self.folder, *next(iter(seen.values())).shape[:2])
            if drive:
                drive.add(frame, action, seen)
                if drive.count % 100 == 0:
                    print(f"recorded {drive.count} pictures to {drive.folder}", flush=True)
        except (OSError, ValueError) as error:
            self.folder = None
            print(f"trouble: recording has stopped, the car drives on: {error}", flush=True)

    def drive(self, frame: Message, folder: Path, height: int, width: int) -> Recording | None:
        """The folder of a drive; when its cameras or their size change, it gets another one."""
        cameras = frame.values["cameras"]
        kind = frame.values["run"], cameras, height, width
        if kind not in self.drives:
            # Only what has been over for a time makes room.
            old = min(self.drives, key=lambda kind: self.drives[kind].used, default=None)
            if len(self.drives) == MOST and time.monotonic() - self.drives[old].used < OVER:
                if not self.full:
                    print(
                        f"trouble: {MOST} cars are recorded already; others are not, as long as these drive", flush=True
                    )
                self.full = True
                return None
            if len(self.drives) == MOST:
                del self.drives[old]
            self.drives[kind], self.full = Recording(folder, cameras), False
            print(f"recording to {self.drives[kind].folder.resolve()}: {cameras}, {width} x {height}", flush=True)
        return self.drives[kind]


NUMBERS = ("sim_time", "wall_time", "throttle", "brake", "steer", "speed")


def recorded(folder: Path) -> Iterator[tuple[int, dict[str, Any], dict[str, bytes], dict[str, Any]]]:
    """Each line's number, its values, and each camera's JPEG file and its pixels; OSError if there is none."""
    found = False
    # A byte that is no text makes one cell bad, and not the whole file.
    with (folder / "metadata.csv").open(encoding="utf-8-sig", errors="replace") as table:
        columns = table.readline().rstrip("\n").split(",")
        for number, line in enumerate(table, 2):
            try:
                cells = dict(zip(columns, line.rstrip("\n").split(","), strict=True))
                kept = files(folder, cells)
                # One that was cut off is found here.
                yield number, values(cells), kept, {name: decode(file) for name, file in kept.items()}
                found = True
            except (OSError, ValueError, KeyError, MessageError) as error:
                print(f"trouble: line {number} of metadata.csv is left out: {error!s:.100}", flush=True)
    if not found:
        raise FileNotFoundError(2, "no picture in it can be read")


def values(cells: dict[str, str]) -> dict[str, Any]:
    numbers = {name: float(cells[name]) for name in (*NUMBERS, *ANSWERED)}
    if not all(map(math.isfinite, numbers.values())):
        raise ValueError("a number in it is not finite")
    return {"frame": int(cells["frame"]), "manual": cells["manual"] == "True", **numbers}


def files(folder: Path, cells: dict[str, str]) -> dict[str, bytes]:
    """By the cameras' names, in their order."""
    found = {}
    for column, name in cells.items():
        if column.endswith("file_name"):
            path = folder / name
            if not path.is_file():
                raise FileNotFoundError(f"there is no picture {name}")
            found[column.removesuffix("file_name").rstrip("_") or "center"] = path.read_bytes()
    return found
