"""Lesson 08, its pictures: JPEG files that no camera wrote are refused before they cost time, and the buffers in which
pictures travel are used again.
"""

from __future__ import annotations

import io
import struct

import pytest

from netmq_example.messages import Array, Message, MessageError
from tests.lessons.conftest import answering
from tests.lessons.test_05_messages import echo
from tests.programs import finished

np = pytest.importorskip("numpy", reason="lesson 08 needs numpy: kit.py run 8 installs it")
from netmq_example.camera import pictures  # noqa: E402

PILLOW = {"reason": "JPEG needs Pillow: pip install pillow"}


def jpeg(width, height, name="JPEG", mode="RGB"):
    image = pytest.importorskip("PIL.Image", **PILLOW)
    file = io.BytesIO()
    image.new(mode, (width, height)).save(file, name)
    return file.getvalue()


def claiming(width, height):
    """A small file whose header claims an enormous picture."""
    data = bytearray(jpeg(8, 8))
    at = data.index(b"\xff\xc0") + 5
    data[at : at + 4] = struct.pack(">HH", height, width)
    return bytes(data)


def slow(scans, size=4096):
    """A progressive JPEG with so many scans that say nothing, each of which costs a pass over the whole picture."""
    image = pytest.importorskip("PIL.Image", **PILLOW)
    file = io.BytesIO()
    image.new("RGB", (8, 8)).save(file, "JPEG", progressive=True)
    data = bytearray(file.getvalue())
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
    "a large one": (lambda: claiming(6_000, 6_000), "too-big"),
    "a good one": (lambda: jpeg(8, 8), None),
    "grey": (lambda: jpeg(8, 8, mode="L"), None),
    "CMYK": (lambda: jpeg(8, 8, mode="CMYK"), None),
}


@pytest.mark.parametrize(("make", "code"), JPEGS.values(), ids=JPEGS.keys())
@pytest.mark.timeout(60)
def test_a_jpeg_of_every_sort(make, code):
    """One that would take a minute or more ends at the test's limit."""
    pytest.importorskip("PIL.Image", **PILLOW)
    values = {"frame": 5, "run": "", "manual": False, "cameras": "center", "encoding": "jpeg"}
    numbers = dict.fromkeys(("sim_time", "wall_time", "throttle", "brake", "steer", "speed"), 0.0)
    frame = Message("frame", 5, values | numbers)
    data = make()
    frame.arrays.append(Array("uint8", (len(data),), data))
    if code is None:
        assert pictures.pictures(frame)["center"].shape[2] == 3
        return
    with pytest.raises(MessageError) as refusal:
        pictures.pictures(frame)
    assert refusal.value.code == code
    assert len(refusal.value.text) < 300


def test_a_jpeg_that_no_camera_writes_is_not_even_begun():
    """It announces arithmetic coding, which takes ten times as long to decode."""
    with pytest.raises(MessageError, match="its parts are not in order"):
        pictures.decode(jpeg(64, 64).replace(b"\xff\xc0", b"\xff\xc9"))


def test_a_picture_is_a_jpeg_and_back_again():
    pytest.importorskip("PIL.Image", **PILLOW)
    grey = np.full((24, 32, 3), 80, "uint8")
    assert (pictures.decode(pictures.encode(grey)) == grey).all()


def test_without_pillow_it_says_so(monkeypatch):
    monkeypatch.setattr(pictures, "Image", None)
    with pytest.raises(MessageError, match="no-pillow: JPEG needs Pillow: pip install pillow"):
        pictures.decode(b"")


# The C# side


@pytest.mark.parametrize("kind", ["plain", "pooled"])
def test_a_requester_that_was_refused_asks_again_and_a_pooled_one_uses_its_buffers_again(
    kind, messages_program, context
):
    with answering(context, echo) as endpoint:
        done = finished([*messages_program, "ask", kind, endpoint])
    _, refused, size, *allocated = done.stdout.splitlines()
    assert [refused, size] == ["5 unknown-kind: only echo", "230400 bytes"], done.stderr
    assert kind == "plain" or int(allocated[0]) < 23_040, "less than a tenth of one picture"
