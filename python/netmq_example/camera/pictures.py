"""The pictures of a message: uint8 [height, width, 3] by the cameras' names, red, green and blue, the top row first.

    seen = pictures(frame)                  {"center": an array of numpy}; MessageError says why there is nothing to see
    file = encode(seen["center"])           a JPEG file; decode(file) gives its pixels

A message of kind `frame` has an array for each camera that its value `cameras` names: raw pixels, with `bottom_up` the
lowest row first and with alpha where the graphics card adds it, or a JPEG file. What does not fit is refused by name.
The C# side is CameraPictures.cs. It needs numpy, and for JPEG Pillow.
"""

import io
import re
import warnings
from typing import Any

import numpy as np

from netmq_example import check
from netmq_example.errors import Error
from netmq_example.messages import LIMIT, Array, Message, MessageError

try:
    from PIL import Image, UnidentifiedImageError

    # Its parts for the usual formats. At the first picture they would take long enough to make actions old.
    Image.preinit()
except ImportError:
    Image = None  # type: ignore[assignment]

CAMERAS = {names: names.split(",") for names in ("center", "left,right", "left,center,right")}
# The values that a frame needs besides its pictures, and their types.
NUMBERS = ("sim_time", "wall_time", "throttle", "brake", "steer", "speed")
VALUES: dict[str, tuple[type, ...]] = {"frame": (int,), "run": (str,), "manual": (bool,)}
VALUES |= dict.fromkeys(NUMBERS, (int, float))
# Of a JPEG file: scans, each of which costs a pass over the whole picture, and parts before the first one. A camera's
# file has one scan, or some ten for a picture that gets sharper while it loads, after some twenty parts.
MOST_SCANS = 20
MOST_PARTS = 200
# The height and width that a JPEG file can have.
MOST_PIXELS = 65_500
# Pillow's opinion of a peer's file does not belong into this terminal.
warnings.filterwarnings("ignore", module="PIL")
# These may stand before the first scan, each with its length: sizes, tables, notes of applications, comments. The kinds
# of JPEG that no camera writes are left out: some are ten times as slow to decode.
PART = re.compile(rb"\xff[\xc0-\xc2\xc4\xdb-\xef\xfe](..)", re.DOTALL)


def pictures(frame: Message) -> dict[str, Any]:
    """The view of each camera, read-only; MessageError says why there is nothing to see."""
    check_values(check.instance("frame", frame, Message))
    cameras, encoding = frame.values.get("cameras"), frame.values.get("encoding")
    if cameras not in CAMERAS:
        raise MessageError("bad-cameras", f"cameras must be {' or '.join(CAMERAS)}, not {cameras!a:.40}")
    names = CAMERAS[cameras]
    if len(names) != len(frame.arrays):
        raise MessageError("bad-cameras", f"{len(names)} cameras, {cameras}, but {len(frame.arrays)} pictures")
    if encoding not in ("raw", "jpeg"):
        raise MessageError("bad-encoding", f"encoding must be raw or jpeg, not {encoding!a:.40}")
    seen = [from_jpeg(array) if encoding == "jpeg" else from_raw(array, frame) for array in frame.arrays]
    if len(seen) > 1 and any(picture.shape != seen[0].shape for picture in seen):
        sizes = sorted({picture.shape for picture in seen})
        raise MessageError("bad-shape", f"pictures of one moment have one size, not {sizes}")
    return dict(zip(names, seen, strict=True))


def check_values(frame: Message) -> None:
    """Refuse a frame without its number, drive or telemetry: a driver and the recorder take them as they are."""
    if frame.kind != "frame":
        raise MessageError("unknown-kind", f"kind {frame.kind!a:.40} is not frame")
    values = frame.values
    for name, kinds in VALUES.items():
        if type(values.get(name)) not in kinds:
            raise MessageError("wrong-type", f"a frame needs the value '{name}', of type {kinds[-1].__name__}")
    if values["frame"] != frame.id:
        raise MessageError("wrong-frame", f"the id is {frame.id}, but the value 'frame' {values['frame']}")


def from_raw(array: Array, frame: Message) -> Any:
    """Without a copy: cutting off and turning over make views of the memory in which ZeroMQ received the bytes."""
    shape = array.shape
    if array.dtype != "uint8" or len(shape) != 3 or shape[2] not in (3, 4) or 0 in shape or max(shape) > MOST_PIXELS:
        raise MessageError("bad-shape", f"a picture is uint8 [height, width, 3 or 4], not {array.dtype} {[*shape]}")
    return array.numpy()[:: -1 if frame.values.get("bottom_up") is True else 1, :, :3]


def from_jpeg(array: Array) -> Any:
    if array.dtype != "uint8" or len(array.shape) != 1:
        raise MessageError("bad-shape", f"a JPEG file is uint8 [bytes], not {array.dtype} {[*array.shape]}")
    return decode(bytes(array.data))


def encode(picture: Any) -> bytes:
    """A JPEG file of a picture; Error where there is no Pillow."""
    if Image is None:
        raise Error("JPEG needs Pillow: pip install pillow, or let kit.py run 8 do it")
    pixels = np.asarray(picture)
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or 0 in pixels.shape:
        raise ValueError(f"picture takes uint8 [height, width, 3], not {pixels.dtype} {[*pixels.shape]}")
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, "JPEG", quality=90)
    return file.getvalue()


def decode(file: bytes) -> Any:
    """The pixels of a JPEG file."""
    return pixels_of(file, ["JPEG"])


def decode_any(file: bytes) -> Any:
    """The pixels of a JPEG or PNG file; in grey [height, width]."""
    return pixels_of(file, ["JPEG", "PNG"], grey=True)


def pixels_of(file: bytes, formats: list[str], grey: bool = False) -> Any:
    names = " or ".join(formats)
    if Image is None:
        raise MessageError("no-pillow", f"{names} needs Pillow: pip install pillow")
    if check.instance("file", file, bytes).startswith(b"\xff\xd8"):
        refuse_slow(file, names)
    try:
        with Image.open(io.BytesIO(file), formats=formats) as image:
            # Its size is known before it is decoded: a small file can claim to be an enormous picture.
            if image.mode.startswith("I"):
                raise ValueError("it has 16 bits for each number, and 8 are read")
            if image.width * image.height * 3 <= LIMIT:
                return np.asarray(image.convert("L" if grey and image.mode in ("1", "L", "LA") else "RGB"))
    # Pillow raises whatever its decoders meet.
    except Exception as error:
        why = "it begins otherwise" if isinstance(error, UnidentifiedImageError) else f"{error!s:.60}"
        raise MessageError("bad-jpeg", f"this is no {names} picture: {why}") from None
    raise MessageError("too-big", f"a {names} picture of {image.width} x {image.height} pixels is over the limit")


def refuse_slow(file: bytes, names: str) -> None:
    """Refuse a file that would be slow to decode, by what it announces."""
    at, parts = 2, 0
    while (part := PART.match(file, at)) and parts < MOST_PARTS:
        at += 2 + int.from_bytes(part[1], "big")
        parts += 1
    # In the pixels' data 0xff is never followed by 0xda: what looks like a scan is one.
    if part or file.count(b"\xff\xda", at) > MOST_SCANS:
        raise MessageError("too-big", f"a JPEG picture of over {MOST_SCANS} scans or {MOST_PARTS} parts is refused")
    if file[at : at + 2] != b"\xff\xda":
        raise MessageError("bad-jpeg", f"this is no {names} picture: its parts are not in order")
