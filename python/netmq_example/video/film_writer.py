"""Pictures become a film one by one, each shown as long as it was seen.

    film = open_film("drive.gif")            or .png, .webp; with ffmpeg on the machine .mp4
    film.add(picture, 0.04)                  uint8 [height, width, 3], [height, width, 4] or grey [height, width], and
                                             the second at which it was seen
    film.close(5.0)                          when the last picture was over

The file is whole after each picture: a kill leaves a film that plays, and so does a full disk. A file that exists is
never written over, and a film without a picture leaves none.

An MP4 has a constant rate, so a picture is repeated for as long as it was seen: its time is right to one picture of the
film. One that was seen for less than that may be left out, but not the last one. ffmpeg writes it in fragments of a
second, and ends the file when this program is gone.

ValueError says what is no film and no picture, OSError what cannot be written. It needs numpy and Pillow.
"""

import contextlib
import errno
import math
import os
import shutil
import subprocess
import tempfile
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from netmq_example.extras import without

try:
    import numpy as np
    from PIL import Image
except ImportError as error:
    raise without(error) from None

from netmq_example import check
from netmq_example.video.film_formats import FORMATS, Format

# Seconds that ffmpeg may take over one picture, and then over the end of the file.
PICTURE_SECONDS = 10.0
END_SECONDS = 30.0
# H.264 and most of its viewers want an even number of rows and columns, and colours at half the size.
EVEN_SIDES = "pad=ceil(iw/2)*2:ceil(ih/2)*2,format=yuv420p"


def open_film(path: str | os.PathLike[str], fps: float = 25) -> "Film":
    """A new file. Only an MP4 has a constant rate, `fps`; in the others each picture has its own time."""
    new = new_path("path", path)
    if not (check.is_number(fps) and 0 < fps <= 1000):
        raise ValueError(f"fps takes pictures a second, more than 0 and at most 1000, not {fps!r:.40}")
    if new.suffix.lower() == ".mp4":
        return Mp4Film(new, float(fps))
    return PictureFilm(new, FORMATS[new.suffix.lower()]())


def film_path(name: str, value: Any) -> Path:
    """A rule as in check.py: what it ends in is a film's."""
    if not isinstance(value, str | os.PathLike):
        raise ValueError(f"{name} takes the name of a file, not {value!r:.40}")
    path = Path(value)
    if path.suffix.lower() not in (*FORMATS, ".mp4"):
        raise ValueError(f"'{path}' is no film: its name must end in {', '.join(FORMATS)} or .mp4")
    return path


def new_path(name: str, value: Any) -> Path:
    """A rule as in check.py: the path of a film that does not exist yet."""
    path = film_path(name, value)
    if path.exists():
        raise ValueError(f"'{path}' is there already, and nothing is written over: give another name")
    return path


class Film(ABC):
    """What open_film returns. `frames` is how many pictures it has."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.frames = 0
        self.shape: tuple[int, ...] = ()
        # When the first picture was seen.
        self.began = 0.0

    def add(self, picture: Any, time: float) -> None:
        """The next picture, uint8 [height, width, 3], [height, width, 4] or grey [height, width], and the second at
        which it was seen.
        """
        pixels = rgb(picture)
        if self.frames and pixels.shape != self.shape:
            raise ValueError(f"picture takes the size of the first one, {[*self.shape]}, not {[*pixels.shape]}")
        seen = moment(time)
        if not self.frames:
            self.began = seen
            self.shape = pixels.shape
        self.write_picture(pixels, seen)
        self.frames += 1

    def close(self, time: float) -> None:
        """The last picture was over at this second."""
        self.write_end(moment(time))

    @abstractmethod
    def write_picture(self, pixels: Any, time: float) -> None: ...

    @abstractmethod
    def write_end(self, time: float) -> None: ...


def rgb(picture: Any) -> Any:
    """Its red, green and blue; ValueError if it is no picture."""
    pixels = np.asarray(picture)
    if pixels.dtype != np.uint8 or pixels.shape[2:] not in ((3,), (4,), ()) or pixels.ndim < 2 or not pixels.size:
        forms = "uint8 [height, width, 3], [height, width, 4] or grey [height, width]"
        raise ValueError(f"picture takes {forms}, not {pixels.dtype} {[*pixels.shape]}")
    grey = pixels.ndim == 2
    return np.repeat(pixels[:, :, None], 3, axis=2) if grey else np.ascontiguousarray(pixels[:, :, :3])


def nearest(seconds: float, rate: float) -> int:
    """In ticks, of which there are `rate` to a second."""
    # The middle goes down, also after a rounding error. Up, the last of 60 pictures a second in 30 would be one too
    # many; and by round(), to even numbers, some would be seen twice and others never.
    return math.ceil(seconds * rate - 0.5 - 1e-6)


def moment(time: Any) -> float:
    if check.is_number(time):
        return float(time)
    raise ValueError(f"time takes a number of seconds, not {time!r:.40}")


class PictureFilm(Film):
    """A film in one of Pillow's formats.

    How long a picture is seen is known when the next one comes: it is written at once, and then again with its time.
    """

    def __init__(self, path: Path, format: Format) -> None:
        super().__init__(path)
        self.format = format
        # Exclusive, and without a buffer: what is written is in the file at once.
        self.file = path.open("xb", buffering=0)
        # The last picture, and when it was seen.
        self.body = b""
        self.time = 0.0
        # Where the last picture begins, and where the film ends.
        self.at = 0
        self.end = 0

    def write_picture(self, pixels: Any, time: float) -> None:
        image = Image.fromarray(pixels)
        before = self.last_picture(time) if self.frames else self.format.head(image.size)
        body = self.format.encode(image)
        self.write(before + self.format.frame(body, self.frames, 0) + self.format.tail)
        self.at += len(before)
        self.body = body
        self.time = time
        place, data = self.format.grown(self.frames + 1, self.end)
        self.file.seek(place)
        self.file.write(data)

    def write_end(self, time: float) -> None:
        if self.file.closed:
            return
        with self.file:
            if self.frames:
                self.write(self.last_picture(time) + self.format.tail)
        if not self.frames:
            # Not a film, and it was made here.
            self.path.unlink()

    def last_picture(self, until: float) -> bytes:
        """The last picture with its time. Rounded from the beginning on, so that errors do not add up."""
        begin = nearest(self.time - self.began, self.format.ticks)
        end = nearest(until - self.began, self.format.ticks)
        return self.format.frame(self.body, self.frames - 1, min(max(0, end - begin), self.format.most_ticks))

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


class Mp4Film(Film):
    """A film that ffmpeg makes, in a process of its own."""

    def __init__(self, path: Path, fps: float) -> None:
        if not shutil.which("ffmpeg"):
            cure = "install it, or let the film end in .gif, .png or .webp"
            raise OSError(f"an MP4 needs ffmpeg, which is not here: {cure}")
        super().__init__(path)
        # So it is known that it can be written, and that nothing is written over.
        path.open("xb").close()
        self.fps = fps
        self.process: subprocess.Popen[bytes] | None = None
        # The last picture, how many ffmpeg has got with the repeated ones, and whether it has not got that one yet.
        self.last = b""
        self.written = 0
        self.unseen = False
        self.errors = tempfile.TemporaryFile()  # noqa: SIM115, it lives as long as ffmpeg.

    def write_picture(self, pixels: Any, time: float) -> None:
        if not self.process:
            self.process = self.start(*pixels.shape[:2])
        self.repeat_last(time)
        self.last = pixels.tobytes()
        self.unseen = True

    def write_end(self, time: float) -> None:
        if not self.process:
            self.path.unlink(missing_ok=True)
            return
        try:
            self.repeat_last(time)
            self.repeat(self.unseen)
        finally:
            # What is not written yet is written now.
            with contextlib.suppress(OSError), self.limited(PICTURE_SECONDS):
                self.process.stdin.close()  # type: ignore[union-attr]
            with self.limited(END_SECONDS):
                self.process.wait()
        if self.process.returncode:
            raise OSError(self.why())

    def start(self, height: int, width: int) -> subprocess.Popen[bytes]:
        raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{self.fps:g}", "-i", "-"]
        whole = ["-bf", "0", "-g", str(max(1, round(self.fps))), "-movflags", "frag_keyframe+empty_moov"]
        film = ["-vf", EVEN_SIDES, *whole, "-f", "mp4", str(self.path)]
        command = ["ffmpeg", "-nostdin", "-loglevel", "error", "-y", *raw, *film]
        # In a session of its own: Ctrl-C is for this program, which then ends the film.
        return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=self.errors, start_new_session=True)

    def repeat_last(self, until: float) -> None:
        """The last picture, up to the one that is seen at that time."""
        wanted = nearest(until - self.began, self.fps) if self.last else 0
        self.repeat(wanted - self.written)

    def repeat(self, times: int) -> None:
        for _ in range(times):
            try:
                with self.limited(PICTURE_SECONDS):
                    self.process.stdin.write(self.last)  # type: ignore[union-attr]
            except OSError:
                raise OSError(self.why()) from None
            self.written += 1
            self.unseen = False

    @contextlib.contextmanager
    def limited(self, seconds: float) -> Iterator[None]:
        """A process that reads nothing would be waited for without end: it is killed after so many seconds."""
        timer = threading.Timer(seconds, self.kill, [seconds])
        timer.name = "netmq_example ffmpeg"
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def kill(self, seconds: float) -> None:
        self.errors.write(f"killed, because it did nothing for {seconds:g} s\n".encode())
        self.process.kill()  # type: ignore[union-attr]

    def why(self) -> str:
        self.errors.seek(0)
        lines = self.errors.read().decode(errors="replace").split("\n")
        return f"ffmpeg has ended: {next(filter(None, lines), 'it does not say why')[:200]}"
