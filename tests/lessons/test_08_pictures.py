"""Lesson 08, its pictures: JPEG files that no camera wrote are refused before they cost time."""

import io
import struct

import pytest

from netmq_example.messages import Array, Message, MessageError

pytest.importorskip("numpy", reason="lesson 08 needs numpy: kit.py run 8 installs it")
Image = pytest.importorskip("PIL.Image", reason="JPEG needs Pillow: pip install pillow")
from netmq_example.camera import pictures  # noqa: E402


def jpeg(width, height, name="JPEG", mode="RGB", **more):
    file = io.BytesIO()
    Image.new(mode, (width, height)).save(file, name, **more)
    return file.getvalue()


def claiming(width, height):
    """A small file whose header claims an enormous picture."""
    data = bytearray(jpeg(8, 8))
    at = data.index(b"\xff\xc0") + 5
    data[at : at + 4] = struct.pack(">HH", height, width)
    return bytes(data)


def slow(scans, size=4096):
    """A progressive JPEG with so many scans that say nothing, each of which costs a pass over the whole picture."""
    data = bytearray(jpeg(8, 8, progressive=True))
    at = data.index(b"\xff\xc2") + 5
    data[at : at + 4] = struct.pack(">HH", size, size)
    # Its only code, a bit 0, says that in 2**14 blocks and as many as the next 14 bits say all is as it was.
    table = b"\xff\xc4" + struct.pack(">HB16BB", 20, 0x10, 1, *[0] * 15, 0xE0)
    bits = ("0" + "10" * 7) * (size * size // 64 // 27_306 + 1)
    bits += "0" * (-len(bits) % 8)
    nothing = int(bits, 2).to_bytes(len(bits) // 8, "big").replace(b"\xff", b"\xff\0")
    scan = b"\xff\xda" + struct.pack(">HBBBBBB", 8, 1, 1, 0, 1, 63, 0) + nothing
    return bytes(data[: data.index(b"\xff\xda")]) + table + scan * scans + b"\xff\xd9"


def notes(count):
    """A small JPEG with so many notes of applications before its pixels; Pillow puts them together one by one."""
    data = jpeg(8, 8)
    return data[:2] + b"\xff\xe1\x00\x09Exif\0\0x" * count + data[2:]


JPEGS = {
    "60,000 scans": (lambda: slow(60_000), "too-big"),
    "3,000,000 notes": (lambda: notes(3_000_000), "too-big"),
    "padding": (lambda: b"\xff\xd8" + b"\xff" * 60_000_000, "bad-jpeg"),
    "marks without an end": (lambda: b"\xff\xd8" + b"\xff\xd0" * 30_000_000, "bad-jpeg"),
    "ten scans": (lambda: slow(10), None),
    "ten notes": (lambda: notes(10), None),
    "its beginning": (lambda: b"\xff\xd8\xff", "bad-jpeg"),
    "other bytes": (lambda: b"x" * 5000, "bad-jpeg"),
    "cut off": (lambda: jpeg(64, 64)[:-200], "bad-jpeg"),
    "a PNG": (lambda: jpeg(8, 8, "PNG"), "bad-jpeg"),
    "a bomb": (lambda: claiming(60_000, 60_000), "bad-jpeg"),
    # Arithmetic coding, which takes ten times as long to decode, is not even begun.
    "what no camera writes": (lambda: jpeg(64, 64).replace(b"\xff\xc0", b"\xff\xc9"), "bad-jpeg: .* not in order"),
    "a large one": (lambda: claiming(6_000, 6_000), "too-big"),
    "a good one": (lambda: jpeg(8, 8), None),
    "grey": (lambda: jpeg(8, 8, mode="L"), None),
    "CMYK": (lambda: jpeg(8, 8, mode="CMYK"), None),
}


@pytest.mark.parametrize(("make", "why"), JPEGS.values(), ids=JPEGS.keys())
@pytest.mark.timeout(60)
def test_a_jpeg_of_every_sort(make, why):
    """One that would take a minute or more ends at the test's limit."""
    values = {"frame": 5, "run": "", "manual": False, "cameras": "center", "encoding": "jpeg"}
    numbers = dict.fromkeys(("sim_time", "wall_time", "throttle", "brake", "steer", "speed"), 0.0)
    frame = Message("frame", 5, values | numbers)
    data = make()
    frame.arrays.append(Array("uint8", (len(data),), data))
    if why is None:
        assert pictures.pictures(frame)["center"].shape[2] == 3
        return
    with pytest.raises(MessageError, match=f"^{why}") as refusal:
        pictures.pictures(frame)
    assert len(refusal.value.text) < 300
