"""Pictures become a film one by one, each shown as long as it was seen.

    film = open_film("drive.mp4")            or .webm, .gif
    film.add(picture, 0.04)                  uint8 [height, width, 3], [height, width, 4] or grey [height, width], and
                                             the second at which it was seen
    film.close(5.0)                          when the last picture was over

A kill or a full disk leaves a film that plays, without its last pictures. A file that exists is never written over, and
a film without a picture leaves none.

An MP4 and a WebM have some loss, and a side that is odd becomes one pixel longer. A GIF has 256 colours a picture, and
times in steps of 0.01 s.

ValueError says what is no film and no picture, OSError what cannot be written. It needs numpy and Pillow,
and av for an MP4 or a WebM.
"""

import errno
import io
import math
import os
from abc import ABC, abstractmethod
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import GifImagePlugin, Image

from netmq_example import arguments, check
from netmq_example.extras import without

MILLISECOND = Fraction(1, 1000)


class Codec(NamedTuple):
    """A codec with its options, and those of its file. Each picture is one packet, which is written at once."""

    codec: str
    options: dict[str, str]
    container: dict[str, str]


CODECS = {
    ".mp4": Codec(
        "libx264",
        {"preset": "veryfast", "tune": "zerolatency", "crf": "23"},
        {"movflags": "frag_every_frame+empty_moov+default_base_moof"},
    ),
    ".webm": Codec(
        "libvpx-vp9",
        {"deadline": "realtime", "cpu-used": "8", "lag-in-frames": "0", "crf": "32", "b": "0"},
        {"cluster_time_limit": "0"},
    ),
}


def open_film(path: str | os.PathLike[str], fps: float = 25) -> "Film":
    """A new file. Each picture has its own time; `fps` is how often an MP4 or a WebM can be entered, once a second."""
    new = new_path("path", path)
    if not (check.is_number(fps) and 0 < fps <= 1000):
        raise ValueError(f"fps takes pictures a second, more than 0 and at most 1000, not {fps!r:.40}")
    return AvFilm(new, float(fps)) if new.suffix.lower() in CODECS else GifFilm(new)


def film_path(name: str, value: Any) -> Path:
    """A rule as in check.py: what it ends in is a film's."""
    path = arguments.path(name, value)
    if path.suffix.lower() not in (*CODECS, ".gif"):
        raise ValueError(f"'{path}' is no film: its name must end in {', '.join(CODECS)} or .gif")
    return path


def new_path(name: str, value: Any) -> Path:
    """A rule as in check.py: the path of a film that does not exist yet."""
    path = film_path(name, value)
    if path.exists():
        raise ValueError(f"'{path}' is there already, and nothing is written over: give another name")
    return path


def usual_ending() -> str:
    """That of a film without a name: .mp4, or .webm where av is built without H.264, as on a 32-bit Raspberry Pi."""
    return next(ending for ending, how in CODECS.items() if how.codec in pyav().codecs_available)


class WholeWrites(io.FileIO):
    """A file that gets all of what is written, or nothing: readers refuse an MP4 whose last part has lost its end."""

    def write(self, data: Any) -> int:
        end = self.tell()
        if super().write(data) < len(data):
            self.seek(end)
            self.truncate()
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return len(data)


class Film(ABC):
    """A film that open_film has begun. `frames` is how many pictures it has."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.process_id = os.getpid()
        self.frames = 0
        self.shape: tuple[int, ...] = ()
        # When the first picture was seen.
        self.began = 0.0
        try:
            self.file = WholeWrites(path, "x")
        except OSError as error:
            cure = "name a file in a folder that you may write into"
            raise type(error)(f"cannot write {path}: {error.strerror or error}; {cure}") from None

    def add(self, picture: Any, time: float) -> None:
        """The next picture, uint8 [height, width, 3], [height, width, 4] or grey [height, width], and the second at
        which it was seen.
        """
        if os.getpid() != self.process_id:
            # An encoder's threads stay with the process that has begun it: this one would wait for ever.
            raise RuntimeError("this film was begun in another process: begin one in this process, after the fork")
        pixels = rgb(picture)
        if self.frames and pixels.shape != self.shape:
            raise ValueError(f"picture takes the size of the first one, {[*self.shape]}, not {[*pixels.shape]}")
        seen = moment(time)
        if not self.frames:
            self.began = seen
            self.shape = pixels.shape
        self.write_picture(pixels, seen - self.began)
        self.frames += 1

    def close(self, time: float) -> None:
        """The last picture was over at this second."""
        end = moment(time)
        if self.file.closed or os.getpid() != self.process_id:
            return
        with self.file:
            if self.frames:
                self.write_end(end - self.began)
        if not self.frames:
            # Not a film, and it was made here.
            self.path.unlink()

    @abstractmethod
    def write_picture(self, pixels: Any, time: float) -> None:
        """Here and in write_end the time is in seconds since the first picture."""

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


def moment(time: Any) -> float:
    if check.is_number(time):
        return float(time)
    raise ValueError(f"time takes a number of seconds, not {time!r:.40}")


class GifFilm(Film):
    """A GIF, encoded by Pillow. A picture is written when the next one comes and says how long it was seen."""

    # The last picture, and the hundredth of a second in which it was seen.
    image: Any = None
    begin = 0

    def write_picture(self, pixels: Any, time: float) -> None:
        height, width = pixels.shape[:2]
        if max(height, width) > 65_535:
            raise ValueError(f"a GIF has at most 65535 pixels a side, not {width} x {height}")
        image = Image.fromarray(pixels).quantize(256, dither=Image.Dither.NONE)
        if self.frames:
            self.write_image(time)
        else:
            # It is shown again and again.
            head, _ = GifImagePlugin.getheader(image, info={"loop": 0})
            self.file.write(b"".join(head))
        self.image = image
        self.begin = hundredths(time)

    def write_end(self, time: float) -> None:
        self.write_image(time)
        self.file.write(b";")

    def write_image(self, until: float) -> None:
        duration = 10 * min(max(0, hundredths(until) - self.begin), 65_535)
        # Without a disposal Pillow leaves a duration of 0 out.
        data = GifImagePlugin.getdata(self.image, duration=duration, disposal=1, include_color_table=True)
        self.file.write(b"".join(data))


def hundredths(seconds: float) -> int:
    """Rounded since the beginning of the film, so that errors do not add up."""
    # The middle goes down, also after a rounding error. Up, the last of 60 pictures a second in 30 would be one too
    # many; and by round(), to even numbers, some would be seen twice and others never.
    return math.ceil(seconds * 100 - 0.5 - 1e-6)


class AvFilm(Film):
    """An MP4 or a WebM, encoded in this process by FFmpeg, which PyAV brings along."""

    def __init__(self, path: Path, fps: float) -> None:
        av = pyav()
        self.how = CODECS[path.suffix.lower()]
        if self.how.codec not in av.codecs_available:
            raise OSError(f"this av has no {self.how.codec}: let the film end in {usual_ending()} or .gif")
        super().__init__(path)
        self.fps = fps
        self.container = av.open(self.file, "w", format=path.suffix[1:].lower(), options=self.how.container)
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
        self.ticks = max(self.ticks + 1, round(time * 1000))
        frame.pts = self.ticks
        frame.time_base = MILLISECOND
        self.write(self.stream.encode(frame))

    def write_end(self, time: float) -> None:
        self.write(self.stream.encode())
        self.kept.duration = max(1, round(time / self.kept.time_base) - self.kept.pts)
        self.container.mux(self.kept)
        self.container.close()

    def start(self, height: int, width: int) -> None:
        rate = Fraction(self.fps).limit_denominator(1000)
        self.stream = self.container.add_stream(self.how.codec, rate=rate, options=self.how.options)
        self.stream.width = width
        self.stream.height = height
        self.stream.pix_fmt = "yuv420p"
        self.stream.codec_context.time_base = MILLISECOND
        self.stream.codec_context.gop_size = max(1, round(self.fps))
        try:
            self.stream.codec_context.open()
        except pyav().FFmpegError as error:
            cure = "give them another size"
            raise OSError(f"{self.how.codec} has no pictures of {width} x {height} ({error}): {cure}") from None

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
        raise OSError(f"{without(error)}; or let the film end in .gif") from None
    return av
