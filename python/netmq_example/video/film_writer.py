"""Pictures become a film one by one, each shown as long as it was seen.

    film = open_film("drive.gif")            or .png, .webp; with PyAV .mp4 and .webm
    film.add(picture, 0.04)                  uint8 [height, width, 3], [height, width, 4] or grey [height, width], and
                                             the second at which it was seen
    film.close(5.0)                          when the last picture was over

The file is whole after each picture: a kill leaves a film that plays, and so does a full disk. A file that exists is
never written over, and a film without a picture leaves none.

An MP4 and a WebM have some loss, and each picture its own time. A kill may take their last pictures. A side that is
odd becomes one pixel longer.

ValueError says what is no film and no picture, OSError what cannot be written. It needs numpy and Pillow,
and av for an MP4 or a WebM.
"""

import errno
import math
import os
from abc import ABC, abstractmethod
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from netmq_example.extras import without

try:
    import numpy as np
    from PIL import Image
except ImportError as error:
    raise without(error) from None

from netmq_example import check
from netmq_example.video.film_formats import FORMATS, Format

MILLISECOND = Fraction(1, 1000)


class Codec(NamedTuple):
    """A codec with its options, and those of its file. Each picture is one packet, which is written at once."""

    codec: str
    options: dict[str, str]
    container: dict[str, str]


CODECS = {
    ".mp4": Codec(
        "libx264",
        {"preset": "veryfast", "tune": "zerolatency", "crf": "23", "bf": "0"},
        {"movflags": "frag_every_frame+empty_moov+default_base_moof", "flush_packets": "1"},
    ),
    ".webm": Codec(
        "libvpx-vp9",
        {"deadline": "realtime", "cpu-used": "8", "lag-in-frames": "0", "crf": "32", "b": "0"},
        {"cluster_time_limit": "100", "flush_packets": "1"},
    ),
}


def open_film(path: str | os.PathLike[str], fps: float = 25) -> "Film":
    """A new file. Each picture has its own time; `fps` is how often an MP4 or a WebM can be entered, once a second."""
    new = new_path("path", path)
    if not (check.is_number(fps) and 0 < fps <= 1000):
        raise ValueError(f"fps takes pictures a second, more than 0 and at most 1000, not {fps!r:.40}")
    if new.suffix.lower() in CODECS:
        return AvFilm(new, float(fps))
    return PictureFilm(new, FORMATS[new.suffix.lower()]())


def film_path(name: str, value: Any) -> Path:
    """A rule as in check.py: what it ends in is a film's."""
    if not isinstance(value, str | os.PathLike):
        raise ValueError(f"{name} takes the name of a file, not {value!r:.40}")
    path = Path(value)
    if path.suffix.lower() not in (*FORMATS, *CODECS):
        raise ValueError(f"'{path}' is no film: its name must end in {', '.join(FORMATS)}, .mp4 or .webm")
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


class AvFilm(Film):
    """An MP4 or a WebM, encoded in this process by FFmpeg, which PyAV brings along."""

    def __init__(self, path: Path, fps: float) -> None:
        av = pyav()
        how = CODECS[path.suffix.lower()]
        if how.codec not in av.codecs_available:
            raise OSError(f"this av has no {how.codec}: let the film end in .webm, .gif, .png or .webp")
        super().__init__(path)
        # Exclusive, and without a buffer: each packet is in the file at once.
        self.file = path.open("xb", buffering=0)
        self.fps = fps
        self.how = how
        self.container = av.open(self.file, "w", format=path.suffix[1:].lower(), options=how.container)
        self.stream: Any = None
        # The packet of the last picture, whose length is known when the next one comes.
        self.kept: Any = None
        self.ticks = -1

    def write_picture(self, pixels: Any, time: float) -> None:
        height, width = pixels.shape[:2]
        # Colours at half the size want an even number of rows and columns.
        even = np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        if not self.stream:
            self.start(*even.shape[:2])
        frame = pyav().VideoFrame.from_ndarray(even, format="rgb24")
        # No two pictures may have the same time.
        self.ticks = max(self.ticks + 1, round((time - self.began) * 1000))
        frame.pts = self.ticks
        frame.time_base = MILLISECOND
        self.write(self.stream.encode(frame))

    def write_end(self, time: float) -> None:
        if self.file.closed:
            return
        with self.file:
            if self.kept:
                self.write(self.stream.encode())
                end = round((time - self.began) / self.kept.time_base)
                self.kept.duration = max(1, end - self.kept.pts)
                self.container.mux(self.kept)
            if self.stream:
                self.container.close()
        if not self.frames:
            # Not a film, and it was made here.
            self.path.unlink()

    def start(self, height: int, width: int) -> None:
        rate = Fraction(self.fps).limit_denominator(1000)
        self.stream = self.container.add_stream(self.how.codec, rate=rate, options=self.how.options)
        self.stream.width = width
        self.stream.height = height
        self.stream.pix_fmt = "yuv420p"
        self.stream.codec_context.time_base = MILLISECOND
        self.stream.codec_context.gop_size = max(1, round(self.fps))

    def write(self, packets: list[Any]) -> None:
        for packet in packets:
            if self.kept:
                self.kept.duration = packet.pts - self.kept.pts
                self.container.mux(self.kept)
            self.kept = packet


def pyav() -> Any:
    """Only an MP4 and a WebM need it, and a GIF does not."""
    try:
        import av
    except ImportError as error:
        raise OSError(f"{without(error)}; or let the film end in .gif, .png or .webp") from None
    return av
