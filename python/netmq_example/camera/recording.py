"""Recordings of drives: each drive is kept in a new folder, so that one can learn from it, and read back.

    recorder = Recorder("runs")
    recorder.add(frame, action)                     the message with the pictures, and the reply about it
    for row in recorded("runs/run_0001"):
        print(row.number, row.values["steer"], row.pictures["center"].shape)

    runs/run_0001/IMG/center_000120.jpg     a picture for each camera; what came as JPEG is kept to the byte
    runs/run_0001/driving_log.csv           the seven columns of Udacity's simulator, speed in miles per hour
    runs/run_0001/metadata.csv              all that is known about each picture, also for Hugging Face's imagefolder

A picture is written before the rows about it: when the program is killed, at most the last one is lost. The columns
`answered_throttle` and so on are what was answered to this very picture. Values of your own that the first picture and
its action have get columns, too. Nothing is ever deleted or written over, and two cars at once get a folder each. It
needs numpy and Pillow.
"""

import contextlib
import csv
import errno
import io
import logging
import math
import os
import re
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from netmq_example import arguments, check
from netmq_example.camera.pictures import NUMBERS, decode, encode, pictures
from netmq_example.errors import Error
from netmq_example.messages import EXACT, LIMIT, Message, MessageError

# The values of a frame, as they were in force when the picture was taken, and those of the action that answered it.
KNOWN = ("frame", *NUMBERS, "manual", "encoding")
ANSWERED = ("throttle", "brake", "steer")
# Of a picture as well, and in no column of its own.
BESIDE = ("run", "cameras", "bottom_up")
METADATA = (*KNOWN, "width", "height", *(f"answered_{name}" for name in ANSWERED))
UDACITY = ("center", "left", "right", "steering", "throttle", "brake", "speed")
# Of one metre a second.
MILES_PER_HOUR = 3600 / 1609.344
# Drives at a time, and the time without a picture after which one is over.
MOST_DRIVES = 64
OVER_SECONDS = 10.0
# Of the table of a recording.
LARGEST_BYTES = 1024 * 1024 * 1024

log = logging.getLogger("netmq_example.server")


class Recorder:
    """Keeps what was asked and answered, until it cannot any more: then it says so, and the car drives on.

    Use it on one thread.
    """

    def __init__(self, folder: Path | str | None) -> None:
        """Without a folder it keeps nothing. It logs each drive, each 100 pictures, and trouble."""
        self.folder = None if folder is None else arguments.path("folder", folder)
        self.drives: dict[Any, Recording] = {}
        self.full = False

    def add(self, frame: Message, action: Message) -> None:
        """Keep a picture and what was answered to it, unless that was an error."""
        check.instance("frame", frame, Message)
        if not self.folder or check.instance("action", action, Message).kind != "action":
            return
        try:
            seen = pictures(frame)
            drive = self.drive(frame, action, self.folder, *next(iter(seen.values())).shape[:2])
            if drive:
                drive.add(frame, action, seen)
                if drive.count % 100 == 0:
                    log.info("recorded %s pictures to %s", drive.count, drive.folder)
        except (OSError, ValueError, Error) as error:
            self.folder = None
            log.warning("trouble: recording has stopped, the car drives on: %s", error)

    def drive(self, frame: Message, action: Message, folder: Path, height: int, width: int) -> "Recording | None":
        """The folder of a drive; when its cameras or their size change, it gets another one."""
        cameras = frame.values["cameras"]
        kind = frame.values["run"], cameras, height, width
        if kind not in self.drives:
            if len(self.drives) == MOST_DRIVES and not self.make_room():
                return None
            self.drives[kind] = Recording(folder, frame, action)
            self.full = False
            where = self.drives[kind].folder.resolve()
            log.info("recording to %s: %s, %s x %s", where, cameras, width, height)
        return self.drives[kind]

    def make_room(self) -> bool:
        """Only a drive that has been over for a time makes room for another one."""
        oldest = min(self.drives, key=lambda kind: self.drives[kind].used)
        if time.monotonic() - self.drives[oldest].used >= OVER_SECONDS:
            del self.drives[oldest]
            return True
        if not self.full:
            log.warning("trouble: %s cars are recorded already; others are not, as long as these drive", MOST_DRIVES)
        self.full = True
        return False


class Recording:
    """One drive: pictures of the same cameras, in one size. `frame` and `action` are the first ones of it."""

    def __init__(self, folder: Path, frame: Message, action: Message) -> None:
        self.folder = new_folder(folder)
        self.count = 0
        self.left_out: list[str] = []
        self.used = time.monotonic()
        (self.folder / "IMG").mkdir()
        cameras = frame.values["cameras"]
        files = [f"{name}_file_name" for name in cameras.split(",")] if "," in cameras else ["file_name"]
        # Of the user's own: those whose columns are not read as others.
        self.own = [name for name in told(frame, action) if name not in METADATA and not name.endswith("file_name")]
        self.metadata = Table(self.folder / "metadata.csv", [*files, *METADATA, *self.own])
        self.log = Table(self.folder / "driving_log.csv", UDACITY)

    def add(self, frame: Message, action: Message, seen: dict[str, Any]) -> None:
        """All of it or nothing, whatever happens in between."""
        self.used = time.monotonic()
        paths = {name: f"IMG/{name}_{frame.id:06}.jpg" for name in seen}
        if any((self.folder / path).exists() for path in paths.values()):
            # It was sent again.
            return
        try:
            for array, (name, path) in zip(frame.arrays, paths.items(), strict=True):
                file = bytes(array.data) if frame.values["encoding"] == "jpeg" else encode(seen[name])
                (self.folder / path).write_bytes(file)
            height, width, _ = next(iter(seen.values())).shape
            known = [frame.values[name] for name in KNOWN]
            answered = [action.values[name] for name in ANSWERED]
            values = told(frame, action)
            own = [values.get(name, "") for name in self.own]
            self.metadata.add([*paths.values(), *known, width, height, *answered, *own])
            driven = *(values[name] for name in ("steer", "throttle", "brake")), values["speed"] * MILES_PER_HOUR
            self.log.add([*(paths.get(name, "") for name in UDACITY[:3]), *driven])
        except BaseException:
            files = [(self.folder / path).unlink for path in paths.values()]
            for undo in (self.metadata.undo, self.log.undo, *files):
                with contextlib.suppress(OSError):
                    undo()
            raise
        self.metadata.keep()
        self.log.keep()
        self.count += 1
        for name in [*frame.values, *(name for name in values if name not in METADATA)]:
            if name not in (*KNOWN, *BESIDE, *self.own, *self.left_out):
                self.left_out.append(name)
                why = f"it came after the first picture of {self.folder}, or is a column's name"
                log.warning("trouble: %.40a is not recorded: %s", name, why)


def told(frame: Message, action: Message) -> dict[str, Any]:
    """Beside a picture and in answer to it, each by its column's name."""
    answered = {f"answered_{name}": value for name, value in action.values.items() if name != "frame"}
    return {name: value for name, value in frame.values.items() if name not in BESIDE} | answered


class Table:
    """A csv file. Rows added since the last `keep` can be undone, so a full disk leaves no half rows."""

    def __init__(self, path: Path, columns: Iterable[str]) -> None:
        # Exclusive: what is there already is never written over. Without a buffer a row is in the file at once.
        self.file = path.open("xb", buffering=0)
        self.end = 0
        self.add(columns)
        self.keep()

    def add(self, row: Iterable[Any]) -> None:
        text = io.StringIO()
        # A text of the user's own may have commas and quotes, which csv writes as it has to, and more lines than one.
        csv.writer(text, lineterminator="\n").writerow(re.sub(r"[\r\n]", " ", str(cell)) for cell in row)
        line = text.getvalue().encode()
        if self.file.write(line) != len(line):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def keep(self) -> None:
        self.end = self.file.tell()

    def undo(self) -> None:
        self.file.seek(self.file.truncate(self.end))


def new_folder(parent: Path) -> Path:
    """The one after the last that is there; another program may take it first."""
    parent.mkdir(parents=True, exist_ok=True)
    # Not Path.glob: from 3.12 on it finds nothing where it cannot look, and an old number would come again.
    runs = [name[4:] for name in os.listdir(parent) if name.startswith("run_")]
    number = max((int(run) for run in runs if run.isdecimal()), default=0)
    while True:
        number += 1
        folder = parent / f"run_{number:04}"
        with contextlib.suppress(FileExistsError):
            folder.mkdir()
            return folder


class Row(NamedTuple):
    """A line of metadata.csv: its number, what was sent and answered, each camera's JPEG file and its pixels."""

    number: int
    values: dict[str, Any]
    answered: dict[str, Any]
    files: dict[str, bytes]
    pictures: dict[str, Any]


def recorded(folder: Path | str) -> Iterator[Row]:
    """The rows of a recording; OSError if there is none. A row that cannot be read is logged as a warning."""
    folder = arguments.path("folder", folder)
    found = False
    # A byte that is no text makes one cell bad, and not the whole file.
    with arguments.regular_file(folder / "metadata.csv", LARGEST_BYTES).open(
        encoding="utf-8-sig", errors="replace"
    ) as table:
        columns = cells(table.readline())
        for number, line in enumerate(table, 2):
            try:
                row = read_row(folder, number, dict(zip(columns, cells(line), strict=True)))
            except (OSError, ValueError, KeyError, csv.Error, MessageError) as error:
                log.warning("trouble: line %s of metadata.csv is left out: %.100s", number, error)
            else:
                yield row
                found = True
    if not found:
        raise FileNotFoundError(errno.ENOENT, "no picture in it can be read")


def read_row(folder: Path, number: int, cells: dict[str, str]) -> Row:
    values: dict[str, Any] = {name: finite(cells[name]) for name in NUMBERS}
    frame = check.count("frame", int(cells["frame"]), least=0, most=EXACT - 1)
    values |= {"frame": frame, "manual": cells["manual"] == "True"}
    answered: dict[str, Any] = {name: finite(cells[f"answered_{name}"]) for name in ANSWERED}
    for column, cell in cells.items():
        if column not in METADATA and cell and not column.endswith("file_name"):
            where = answered if column.startswith("answered_") else values
            where[column.removeprefix("answered_")] = own(cell)
    kept = files(folder, cells)
    # A file that was cut off is found here.
    return Row(number, values, answered, kept, {name: decode(file) for name, file in kept.items()})


def cells(line: str) -> list[str]:
    return next(csv.reader([line.rstrip("\n")]), [])


def own(cell: str) -> Any:
    """A value of the user's own: true or false, a number, or else a text."""
    if cell in ("True", "False"):
        return cell == "True"
    try:
        return finite(cell)
    except ValueError:
        return cell


def finite(cell: str) -> float:
    if not math.isfinite(float(cell)):
        raise ValueError("a number in it is not finite")
    return float(cell)


def files(folder: Path, cells: dict[str, str]) -> dict[str, bytes]:
    """By the cameras' names, in their order."""
    found = {}
    for column, name in cells.items():
        if column.endswith("file_name"):
            path = folder / name
            try:
                file = arguments.regular_file(path, LIMIT).read_bytes()
            except FileNotFoundError:
                raise FileNotFoundError(f"there is no picture {name}") from None
            found[column.removesuffix("file_name").rstrip("_") or "center"] = file
    return found
