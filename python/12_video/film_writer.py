"""Lesson 12, the film writer: pictures become a film one by one, each shown as long as it was seen.

    film = open_film(Path("drive.gif"))      or .png, .webp; with ffmpeg on the machine .mp4
    film.add(picture, 0.04)                  uint8 [height, width, 3], and the second at which it was seen
    film.close(5.0)                          when the last picture was over

The file is whole after each picture: a kill leaves a film that plays, and so does a full disk. A file that is there
already is never written over.
They need numpy and Pillow.
"""

import errno
import os
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from film_formats import Format, Gif, Png, WebP
from mp4_film import Mp4Film
from PIL import Image

FORMATS: dict[str, type[Format]] = {".gif": Gif, ".png": Png, ".apng": Png, ".webp": WebP}


class Film(Protocol):
    frames: int

    def add(self, picture: Any, time: float) -> None: ...

    def close(self, time: float) -> None: ...


def check_new(path: Path) -> None:
    if path.suffix.lower() not in (*FORMATS, ".mp4"):
        raise ValueError(f"'{path}' is no film: its name must end in {', '.join(FORMATS)} or .mp4")
    if path.exists():
        raise ValueError(f"'{path}' is there already, and nothing is written over: give another name")


def open_film(path: Path, fps: float = 25) -> Film:
    """A new file; ValueError and OSError say why there can be none.

    Only MP4 has a constant rate, `fps`: there pictures are repeated.
    """
    check_new(path)
    if path.suffix.lower() == ".mp4":
        return Mp4Film(path, fps)
    return PictureFilm(path, FORMATS[path.suffix.lower()]())


class PictureFilm:
    """A film of one of Pillow's formats."""

    def __init__(self, path: Path, format: Format) -> None:
        # Exclusive, and without a buffer: what is written is in the file at once.
        self.path, self.format, self.file = path, format, path.open("xb", buffering=0)
        self.frames, self.began, self.time, self.body = 0, 0.0, 0.0, b""
        # Where the last picture begins, and where the film ends.
        self.at = self.end = 0

    def add(self, picture: Any, time: float) -> None:
        image = Image.fromarray(np.ascontiguousarray(picture))
        if not self.frames:
            self.began = self.time = time
            start = self.format.head(image.size)
        else:
            start = self.last(time)
        body = self.format.encode(image)
        # How long it will be seen nobody knows yet.
        shown = self.format.frame(body, self.frames, 0)
        self.write(start + shown + self.format.tail)
        self.at, self.time, self.body, self.frames = self.at + len(start), time, body, self.frames + 1
        self.update()

    def close(self, time: float) -> None:
        if self.file.closed:
            return
        with self.file:
            if self.frames:
                self.write(self.last(time) + self.format.tail)
        if not self.frames:
            # Not a film, and it was made here.
            self.path.unlink()

    def last(self, until: float) -> bytes:
        """The last picture again, now with its time. Rounded from the beginning on, so that errors do not add up."""
        begin, end = (round((time - self.began) * self.format.ticks) for time in (self.time, until))
        return self.format.frame(self.body, self.frames - 1, min(max(0, end - begin), self.format.most))

    def write(self, data: bytes) -> None:
        """From the last picture on; all of it or nothing."""
        try:
            self.file.seek(self.at)
            if self.file.write(data) != len(data):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError:
            self.file.seek(max(0, self.end - len(self.format.tail)))
            self.file.write(self.format.tail)
            self.file.truncate(self.end)
            raise
        self.end = self.at + len(data)

    def update(self) -> None:
        """What stands in the head and grows."""
        place, data = self.format.grown(self.frames, self.end)
        self.file.seek(place)
        self.file.write(data)
