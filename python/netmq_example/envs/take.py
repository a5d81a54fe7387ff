"""The pictures that an environment has taken of one view, one a step, and the film that they become.

    take = Take()
    take.add(picture)                               uint8 [height, width, 3]
    take.film(Path("front.mp4"), fps=10)            its whole path; in place of a path None, an MP4 in bytes
                                                    or, where av has no H.264, a WebM

It needs numpy, and Pillow and av where a film is made.
"""

import importlib
import math
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np


class Take:
    """The pictures of a view, in a file without a name: those of a long film would fill the memory."""

    def __init__(self) -> None:
        self.file = tempfile.TemporaryFile()  # noqa: SIM115, close does it.
        self.shapes: list[tuple[int, ...]] = []

    def add(self, pixels: Any) -> None:
        self.file.seek(0, os.SEEK_END)
        self.file.write(pixels.tobytes())
        self.shapes.append(pixels.shape)

    def pictures(self) -> Iterator[Any]:
        self.file.seek(0)
        for shape in self.shapes:
            yield np.frombuffer(self.file.read(math.prod(shape)), np.uint8).reshape(shape).copy()

    def taken(self) -> list[Any]:
        """Each picture is given once, as Gymnasium has it."""
        pictures = list(self.pictures())
        self.clear()
        return pictures

    def film(self, path: Path | None, fps: float) -> Any:
        """The whole path of the file, or without a path its bytes. OSError: av is missing."""
        if not path:
            with tempfile.TemporaryDirectory() as folder:
                made = Path(folder) / f"film{film_writer().usual_ending()}"
                self.write(made, fps)
                return made.read_bytes()
        # Beside what it replaces, and so on the same disk: a film that fails leaves what was there under its name.
        made = path.with_name(f".{os.getpid()}-{path.name}")
        made.unlink(missing_ok=True)
        try:
            self.write(made, fps)
            os.replace(made, path)
        finally:
            made.unlink(missing_ok=True)
        return os.path.abspath(path)

    def write(self, path: Path, fps: float) -> None:
        film = film_writer().open_film(path, fps)
        try:
            for number, pixels in enumerate(self.pictures()):
                film.add(pixels, number / fps)
        finally:
            film.close(len(self.shapes) / fps)

    def clear(self) -> None:
        self.file.truncate(0)
        self.shapes = []


def film_writer() -> Any:
    """Lesson 12's, whose Pillow nobody needs who makes no film."""
    return importlib.import_module("netmq_example.video.film_writer")
