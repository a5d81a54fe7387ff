"""Lesson 08, the recorder: keeps each drive in a new folder, so that one can learn from it. It deletes nothing.

What is in such a folder stands in recording.py. Two cars at once get a folder each.
It needs numpy and Pillow.
"""

import sys
import time
from pathlib import Path
from typing import Any

from pictures import pictures
from recording import Recording

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Message

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
