"""Lesson 12, the film writer: pictures become a film one by one, each shown as long as it was seen.

    film = open_film(Path("drive.gif"))      or .png, .webp; with ffmpeg on the machine .mp4
    film.add(picture, 0.04)                  uint8 [height, width, 3], and the second at which it was seen
    film.close(5.0)                          when the last picture was over

The file is whole after each picture: a kill leaves a film that plays, and so does a full disk. A file that is there
already is never written over.
They need numpy and Pillow.

Lesson 12, the formats of a film: GIF, animated PNG and animated WebP, as pieces that are written one after another.

Pillow compresses each picture by itself; here it is taken out of its file, and put into a film's. The pieces are those
of the formats' descriptions: GIF89a (CompuServe, 1990), PNG third edition (W3C), WebP container (RFC 9649).
It needs Pillow.

Lesson 12, a film as MP4: ffmpeg makes it, if it is on the machine.

Its rate is constant, so a picture is repeated for as long as it was seen: its time is right to one picture of the film.
The file is written in fragments of a second, and ffmpeg ends it when this program is gone: a kill leaves a film that
plays.
It needs numpy and ffmpeg.
"""

import contextlib
import errno
import io
import os
import shutil
import struct
import subprocess
import tempfile
import threading
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from PIL import Image


class Format:
    """What a film is made of. A picture's time is counted in `ticks` to a second, and in `most` at the most."""

    ticks, most, tail = 1000, 65_535, b""

    def head(self, size: tuple[int, int]) -> bytes:
        raise NotImplementedError

    def encode(self, image: Any) -> bytes:
        """What is the same however long the picture is shown."""
        raise NotImplementedError

    def frame(self, body: bytes, number: int, shown: int) -> bytes:
        raise NotImplementedError

    def grown(self, frames: int, end: int) -> tuple[int, bytes]:
        """What stands in the head and changes with each picture: where, and what."""
        return 0, b""


class Gif(Format):
    """Any viewer shows it; 256 colours a picture, steps of 0.01 s. Browsers show none for less than 0.02 s."""

    ticks, tail = 100, b";"

    def head(self, size: tuple[int, int]) -> bytes:
        if max(size) > 65_535:
            raise ValueError(f"a GIF has at most 65535 pixels a side, not {size[0]} x {size[1]}: let it end in .png")
        # Without colours for all pictures: each has its own. Shown again and again.
        return b"GIF89a" + struct.pack("<HHxxx", *size) + b"\x21\xff\x0bNETSCAPE2.0\x03\x01\0\0\0"

    def encode(self, image: Any) -> bytes:
        file = saved(image.quantize(256, dither=0), "GIF", interlace=False)
        # A file of one picture: 13 bytes of head, so many colours, the picture.
        depth = file[10] & 7
        colours, picture = file[13 : 13 + (6 << depth)], file[13 + (6 << depth) : -1]
        return picture[:9] + bytes([0x80 | depth]) + colours + picture[10:]

    def frame(self, body: bytes, number: int, shown: int) -> bytes:
        return b"\x21\xf9\x04\0" + struct.pack("<Hxx", shown) + body


class Png(Format):
    """All colours, nothing lost, large. Its chunks are counted."""

    tail = struct.pack(">I4sI", 0, b"IEND", zlib.crc32(b"IEND"))

    def head(self, size: tuple[int, int]) -> bytes:
        self.size = size
        # 8 bits each of red, green and blue.
        return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">II5B", *size, 8, 2, 0, 0, 0)) + self.counter(1)

    def encode(self, image: Any) -> bytes:
        file, at, found = saved(image, "PNG"), 8, b""
        while at < len(file):
            length, kind = struct.unpack_from(">I4s", file, at)
            found += file[at + 8 : at + 8 + length] if kind == b"IDAT" else b""
            at += 12 + length
        return found

    def frame(self, body: bytes, number: int, shown: int) -> bytes:
        first = max(0, 2 * number - 1)
        control = chunk(b"fcTL", struct.pack(">5I2H2x", first, *self.size, 0, 0, shown, self.ticks))
        return control + (chunk(b"fdAT", struct.pack(">I", first + 1) + body) if number else chunk(b"IDAT", body))

    def grown(self, frames: int, end: int) -> tuple[int, bytes]:
        return 33, self.counter(frames)

    def counter(self, frames: int) -> bytes:
        return chunk(b"acTL", struct.pack(">II", frames, 0))


class WebP(Format):
    """Small, with some loss."""

    most = 2**24 - 1

    def head(self, size: tuple[int, int]) -> bytes:
        self.size = b"".join((side - 1).to_bytes(3, "little") for side in size)
        canvas = b"VP8X" + struct.pack("<IB3x", 10, 2) + self.size
        return b"RIFF\0\0\0\0WEBP" + canvas + b"ANIM" + struct.pack("<IIH", 6, 0, 0)

    def encode(self, image: Any) -> bytes:
        return saved(image, "WEBP", quality=85)[12:]

    def frame(self, body: bytes, number: int, shown: int) -> bytes:
        head = bytes(6) + self.size + shown.to_bytes(3, "little") + b"\x02"
        return b"ANMF" + struct.pack("<I", len(head + body)) + head + body

    def grown(self, frames: int, end: int) -> tuple[int, bytes]:
        return 4, struct.pack("<I", end - 8)


def saved(image: Any, format: str, **how: Any) -> bytes:
    file = io.BytesIO()
    image.save(file, format, **how)
    return file.getvalue()


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


# Seconds that ffmpeg may take over one picture, and then over its end.
TAKES, ENDS = 10.0, 30.0
# H.264 and most of its viewers want an even number of rows and columns, and colours at half the size.
EVEN = "pad=ceil(iw/2)*2:ceil(ih/2)*2,format=yuv420p"


class Mp4Film:
    """A new file, written by a process of its own."""

    def __init__(self, path: Path, fps: float) -> None:
        if not shutil.which("ffmpeg"):
            raise OSError(
                "an MP4 needs ffmpeg, which is not here: install it, or let the film end in .gif, .png or .webp"
            )
        # So it is known that it can be written, and that nothing is written over.
        path.open("xb").close()
        self.path, self.fps, self.frames, self.written, self.began = path, fps, 0, 0, 0.0
        self.process: subprocess.Popen[bytes] | None = None
        self.last = b""
        self.said = tempfile.TemporaryFile()  # noqa: SIM115, it lives as long as ffmpeg.

    def add(self, picture: Any, time: float) -> None:
        if not self.process:
            self.process, self.began = self.start(*picture.shape[:2]), time
        self.repeat(time)
        self.last, self.frames = np.ascontiguousarray(picture).tobytes(), self.frames + 1

    def close(self, time: float) -> None:
        if not self.process:
            self.path.unlink(missing_ok=True)
            return
        try:
            self.repeat(time)
        finally:
            # What is not written yet is written now.
            with contextlib.suppress(OSError), self.limited(TAKES):
                self.process.stdin.close()  # type: ignore[union-attr]
            with self.limited(ENDS):
                self.process.wait()
        if self.process.returncode:
            raise OSError(self.why())

    def start(self, height: int, width: int) -> subprocess.Popen[bytes]:
        raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{self.fps:g}", "-i", "-"]
        whole = ["-vf", EVEN, "-bf", "0", "-g", str(max(1, round(self.fps))), "-movflags", "frag_keyframe+empty_moov"]
        command = ["ffmpeg", "-nostdin", "-loglevel", "error", "-y", *raw, *whole, "-f", "mp4", str(self.path)]
        # In a session of its own: Ctrl-C is for this program, which then ends the film.
        return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=self.said, start_new_session=True)

    def repeat(self, until: float) -> None:
        """The last picture, up to the one that is seen at that time."""
        wanted = round((until - self.began) * self.fps)
        for _ in range(wanted - self.written if self.last else 0):
            try:
                with self.limited(TAKES):
                    self.process.stdin.write(self.last)  # type: ignore[union-attr]
            except OSError:
                raise OSError(self.why()) from None
            self.written += 1

    @contextlib.contextmanager
    def limited(self, seconds: float) -> Iterator[None]:
        """To write to a process that reads nothing waits for ever: it is killed after so many seconds."""
        timer = threading.Timer(seconds, self.kill, [seconds])
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def kill(self, seconds: float) -> None:
        self.said.write(f"killed, because it did nothing for {seconds:g} s\n".encode())
        self.process.kill()  # type: ignore[union-attr]

    def why(self) -> str:
        self.said.seek(0)
        lines = self.said.read().decode(errors="replace").split("\n")
        return f"ffmpeg has ended: {next(filter(None, lines), 'it does not say why')[:200]}"


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
