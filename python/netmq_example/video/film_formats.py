"""GIF, animated PNG and animated WebP, as pieces that are written one after another: a film that may grow.

    format = FORMATS[".gif"]()
    film = format.head((320, 240))
    film += format.frame(format.encode(image), 0, 4) + format.tail          the first picture, shown for 0.04 s

Pillow compresses each picture by itself; here it is taken out of its file, and put into a film's. The pieces are those
of the formats' descriptions: GIF89a (CompuServe, 1990), PNG third edition (W3C), WebP container (RFC 9649).
film_writer.py puts them into a file. It needs Pillow.
"""

import io
import struct
import zlib
from typing import Any


class Format:
    """What a film is made of. One is made for each film."""

    # A picture's time is counted in so many ticks to a second, and has at most so many of them.
    ticks = 1000
    most_ticks = 65_535
    # What ends the file.
    tail = b""

    def head(self, size: tuple[int, int]) -> bytes:
        """The beginning of a file of this width and height."""
        raise NotImplementedError

    def encode(self, image: Any) -> bytes:
        """The part of a picture that is the same however long it is shown."""
        raise NotImplementedError

    def frame(self, body: bytes, number: int, ticks: int) -> bytes:
        """An encoded picture, counted from 0, that is shown for so many ticks."""
        raise NotImplementedError

    def grown(self, frames: int, end: int) -> tuple[int, bytes]:
        """What stands in the head and changes with each picture: where, and what."""
        return 0, b""


class Gif(Format):
    """Any viewer shows it; 256 colours a picture, steps of 0.01 s. Browsers show none for less than 0.02 s."""

    ticks = 100
    tail = b";"

    def head(self, size: tuple[int, int]) -> bytes:
        if max(size) > 65_535:
            raise too_large("GIF", 65_535, size)
        # Without colours for all pictures: each has its own. Shown again and again.
        return b"GIF89a" + struct.pack("<HHxxx", *size) + b"\x21\xff\x0bNETSCAPE2.0\x03\x01\0\0\0"

    def encode(self, image: Any) -> bytes:
        file = saved(image.quantize(256, dither=0), "GIF", interlace=False)
        # A file of one picture: 13 bytes of head, 2 << depth colours of 3 bytes, the picture.
        depth = file[10] & 7
        colours_end = 13 + (6 << depth)
        colours = file[13:colours_end]
        picture = file[colours_end:-1]
        return picture[:9] + bytes([0x80 | depth]) + colours + picture[10:]

    def frame(self, body: bytes, number: int, ticks: int) -> bytes:
        return b"\x21\xf9\x04\0" + struct.pack("<Hxx", ticks) + body


class Png(Format):
    """All colours, nothing lost, large. Its chunks are counted."""

    tail = struct.pack(">I4sI", 0, b"IEND", zlib.crc32(b"IEND"))

    def head(self, size: tuple[int, int]) -> bytes:
        self.size = size
        # 8 bits each of red, green and blue.
        return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">II5B", *size, 8, 2, 0, 0, 0)) + self.counter(1)

    def encode(self, image: Any) -> bytes:
        file = saved(image, "PNG")
        data = b""
        at = 8
        while at < len(file):
            length, kind = struct.unpack_from(">I4s", file, at)
            if kind == b"IDAT":
                data += file[at + 8 : at + 8 + length]
            at += 12 + length
        return data

    def frame(self, body: bytes, number: int, ticks: int) -> bytes:
        first = max(0, 2 * number - 1)
        control = chunk(b"fcTL", struct.pack(">5I2H2x", first, *self.size, 0, 0, ticks, self.ticks))
        return control + (chunk(b"fdAT", struct.pack(">I", first + 1) + body) if number else chunk(b"IDAT", body))

    def grown(self, frames: int, end: int) -> tuple[int, bytes]:
        return 33, self.counter(frames)

    def counter(self, frames: int) -> bytes:
        return chunk(b"acTL", struct.pack(">II", frames, 0))


class WebP(Format):
    """Small, with some loss."""

    most_ticks = 2**24 - 1

    def head(self, size: tuple[int, int]) -> bytes:
        if max(size) > 16_383:
            raise too_large("WebP", 16_383, size)
        self.size = b"".join((side - 1).to_bytes(3, "little") for side in size)
        canvas = b"VP8X" + struct.pack("<IB3x", 10, 2) + self.size
        return b"RIFF\0\0\0\0WEBP" + canvas + b"ANIM" + struct.pack("<IIH", 6, 0, 0)

    def encode(self, image: Any) -> bytes:
        return saved(image, "WEBP", quality=85)[12:]

    def frame(self, body: bytes, number: int, ticks: int) -> bytes:
        head = bytes(6) + self.size + ticks.to_bytes(3, "little") + b"\x02"
        return b"ANMF" + struct.pack("<I", len(head + body)) + head + body

    def grown(self, frames: int, end: int) -> tuple[int, bytes]:
        return 4, struct.pack("<I", end - 8)


FORMATS: dict[str, type[Format]] = {".gif": Gif, ".png": Png, ".apng": Png, ".webp": WebP}


def too_large(format: str, most: int, size: tuple[int, int]) -> ValueError:
    return ValueError(f"a {format} has at most {most} pixels a side, not {size[0]} x {size[1]}: let it end in .png")


def saved(image: Any, format: str, **how: Any) -> bytes:
    """An image of Pillow's as the bytes of a file."""
    file = io.BytesIO()
    image.save(file, format, **how)
    return file.getvalue()


def chunk(kind: bytes, data: bytes) -> bytes:
    """A chunk of a PNG."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
