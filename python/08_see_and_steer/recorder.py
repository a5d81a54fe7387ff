"""Lesson 08, the recorder: keeps each drive in a new folder, so that one can learn from it. It deletes nothing.

    runs/run_0001/IMG/center_000120.jpg      a picture for each camera; what came as JPEG is kept to the byte
    runs/run_0001/driving_log.csv            the seven columns of Udacity's simulator, speed in miles per hour
    runs/run_0001/metadata.csv               all that is known about each picture, also for Hugging Face's imagefolder

A picture is written before the rows about it: when the program is killed, at most the last one is lost.
Take home: this file and pictures.py, with messages.py of lesson 05. It needs numpy and Pillow.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Message
from pictures import encode, pictures

UDACITY = ("center", "left", "right", "steering", "throttle", "brake", "speed")
# As they were in force when the picture was taken, and what was answered to it.
KNOWN = ("frame", "sim_time", "wall_time", "throttle", "brake", "steer", "speed", "manual", "encoding")
ANSWERED = ("throttle", "brake", "steer")
MILES_PER_HOUR = 3600 / 1609.344
# Drives at a time; the one that began first is over then.
MOST = 8


class Table:
    """A csv file, to which a row is added whole or not at all."""

    def __init__(self, path: Path, columns: tuple[str, ...]) -> None:
        # Exclusive: what is there already is never written over.
        self.file = path.open("xb", buffering=0)
        self.add(columns)

    def add(self, row: tuple[Any, ...]) -> None:
        before, line = self.file.tell(), (",".join(map(str, row)) + "\n").encode()
        try:
            if self.file.write(line) != len(line):
                raise OSError("No space left on device")
        except OSError:
            self.file.truncate(before)
            raise


class Recording:
    """One drive."""

    def __init__(self, folder: Path, cameras: str) -> None:
        self.folder, self.cameras, self.count = folder, cameras, 0
        (folder / "IMG").mkdir(parents=True)
        names = cameras.split(",")
        files = ("file_name",) if len(names) == 1 else tuple(f"{name}_file_name" for name in names)
        self.metadata = Table(folder / "metadata.csv", (*files, *KNOWN, *(f"answered_{name}" for name in ANSWERED)))
        self.log = Table(folder / "driving_log.csv", UDACITY)

    def add(self, frame: Message, action: Message) -> None:
        values, files = frame.values, {}
        if values["encoding"] == "jpeg":
            found = {name: bytes(array.data) for name, array in zip(self.cameras.split(","), frame.arrays, strict=True)}
        else:
            found = {name: encode(picture) for name, picture in pictures(frame).items()}
        for name, file in found.items():
            files[name] = f"IMG/{name}_{values['frame']:06}.jpg"
            write(self.folder / files[name], file)
        known = [values[name] for name in KNOWN] + [action.values[name] for name in ANSWERED]
        self.metadata.add((*files.values(), *known))
        sides = (files.get(name, "") for name in UDACITY[:3])
        speed = values["speed"] * MILES_PER_HOUR
        self.log.add((*sides, values["steer"], values["throttle"], values["brake"], speed))
        self.count += 1


class Recorder:
    """Keeps what was asked and answered, until it cannot any more: then it says so, and the car drives on."""

    def __init__(self, folder: Path | None) -> None:
        self.folder, self.drives = folder, dict[str, Recording]()
        if folder:
            # Pillow loads its parts at the first picture, and that takes long enough to make actions old.
            encode(np.zeros((8, 8, 3), np.uint8))

    def add(self, frame: Message, action: Message) -> None:
        """Keep a picture and what was answered to it, unless that was an error."""
        if not self.folder or action.kind != "action":
            return
        try:
            drive = self.drive(frame, self.folder)
            if drive.cameras == frame.values["cameras"]:
                drive.add(frame, action)
                if drive.count % 100 == 0:
                    print(f"recorded {drive.count} pictures to {drive.folder}", flush=True)
        except OSError as error:
            self.folder = None
            print(f"trouble: recording has stopped, the car drives on: {error}", flush=True)

    def drive(self, frame: Message, folder: Path) -> Recording:
        run = str(frame.values["run"])
        if run not in self.drives:
            if len(self.drives) == MOST:
                del self.drives[next(iter(self.drives))]
            last = max((int(path.name[4:]) for path in folder.glob("run_[0-9]*")), default=0)
            self.drives[run] = Recording(folder / f"run_{last + 1:04}", frame.values["cameras"])
            print(f"recording to {self.drives[run].folder}", flush=True)
        return self.drives[run]


def write(path: Path, content: bytes) -> None:
    """Whole or not at all."""
    part = path.with_suffix(".part")
    try:
        part.write_bytes(content)
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)
        raise
