"""Lesson 08, the recorder: keeps each drive in a new folder, so that one can learn from it. It deletes nothing.

What is in such a folder stands in recording.py. Two cars at once get a folder each.
Take home: this file, recording.py, pictures.py, and messages.py of lesson 05. It needs numpy and Pillow.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from pictures import encode, pictures
from recording import Recording

# messages.py is lesson 05's. At home it lies beside this file.
sys.path.append(str(Path(__file__).parent / "../05_messages"))
from messages import Message

# Drives at a time; the one that began first is over then.
MOST = 8


class Recorder:
    """Keeps what was asked and answered, until it cannot any more: then it says so, and the car drives on."""

    def __init__(self, folder: Path | None) -> None:
        self.folder, self.drives = folder, dict[Any, Recording]()
        if folder:
            # Pillow loads its parts at the first picture, and that takes long enough to make actions old.
            encode(np.zeros((8, 8, 3), np.uint8))

    def add(self, frame: Message, action: Message) -> None:
        """Keep a picture and what was answered to it, unless that was an error."""
        if not self.folder or action.kind != "action":
            return
        try:
            seen = pictures(frame)
            drive = self.drive(frame, *next(iter(seen.values())).shape[:2])
            # A picture that was sent again is there already.
            if frame.id > drive.last:
                drive.add(frame, action, seen)
                if drive.count % 100 == 0:
                    print(f"recorded {drive.count} pictures to {drive.folder}", flush=True)
        except (OSError, ValueError) as error:
            self.folder = None
            print(f"trouble: recording has stopped, the car drives on: {error}", flush=True)

    def drive(self, frame: Message, height: int, width: int) -> Recording:
        """The folder of a drive; when its cameras or their size change, it gets another one."""
        cameras = frame.values["cameras"]
        kind = frame.values["run"], cameras, height, width
        if kind not in self.drives and self.folder:
            if len(self.drives) == MOST:
                del self.drives[next(iter(self.drives))]
            self.drives[kind] = Recording(self.folder, cameras)
            print(f"recording to {self.drives[kind].folder}: {cameras}, {width} x {height}", flush=True)
        return self.drives[kind]
