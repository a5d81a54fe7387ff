"""Arrays and pictures of a message for numpy, without a copy.

Take home: this file and messages.py. It needs numpy, and for JPEG Pillow: pip install numpy pillow
"""

from __future__ import annotations

import io
import math
import re
import sys
from typing import Any

from messages import LIMIT, Array, MessageError, Value

try:
    import numpy as np
except ImportError:
    sys.exit("this lesson needs numpy: pip install numpy, or let python3 kit.py run 5 do it")

MOST_SCANS, MOST_PARTS = 50, 200
# What may stand before the first scan, each with its length: sizes, tables, notes of applications, comments.
PART = re.compile(rb"\xff[\xc0-\xc7\xc9-\xcf\xdb-\xef\xfe](..)", re.DOTALL)


def as_numpy(array: Array) -> Any:
    """The array in the very memory that ZeroMQ received it in."""
    return np.frombuffer(array.data, np.dtype(array.dtype).newbyteorder("<")).reshape(array.shape)


def mean(items: Any) -> Value:
    """The mean of the numbers. NaN is in many a float array by mistake, and it must not get into anybody's game."""
    with np.errstate(over="ignore", invalid="ignore"):
        result = float(items.mean(dtype=np.float64))
    if not math.isfinite(result):
        raise MessageError("bad-value", "the array has numbers that are not finite, or too large to add up")
    return result


def brightest(picture: Any) -> dict[str, Value]:
    """Where its brightest pixel is, counted from the top left."""
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3:
        shape = f"{picture.dtype} {[*picture.shape]}"
        raise MessageError("bad-shape", f"a picture is uint8 [height, width, 3], not {shape}")
    y, x = divmod(int(picture.sum(axis=2, dtype=np.uint16).argmax()), picture.shape[1])
    return {"x": x, "y": y}


def check_jpeg(file: bytes) -> None:
    """Refuse a file that would be slow to decode by what it announces: each scan costs a pass over the whole picture.

    A camera's file has one scan, or some ten for a picture that gets sharper while it loads, after some twenty parts.
    """
    at, parts = 2, 0
    while (part := PART.match(file, at)) and parts < MOST_PARTS:
        at, parts = at + 2 + int.from_bytes(part[1], "big"), parts + 1
    if part:
        raise MessageError("too-big", f"a JPEG picture of more than {MOST_PARTS} parts is over the limit")
    # In the pixels' data 0xff is never followed by 0xda: what looks like a scan is one.
    if (scans := file.count(b"\xff\xda", at)) > MOST_SCANS:
        raise MessageError("too-big", f"a JPEG picture of {scans} scans is over the limit of {MOST_SCANS}")
    if file[at : at + 2] != b"\xff\xda":
        raise MessageError("bad-jpeg", "this is no JPEG picture: its parts are not in order")


def decode(array: Array) -> Any:
    """The pixels of a JPEG file, top row first."""
    try:
        from PIL import Image
    except ImportError:
        raise MessageError("no-pillow", "the server needs Pillow for JPEG: pip install pillow") from None
    file = bytes(array.data)
    check_jpeg(file)
    try:
        with Image.open(io.BytesIO(file), formats=["JPEG"]) as image:
            # Its size is known before it is decoded: a small file can claim to be an enormous picture.
            if image.width * image.height * 3 <= LIMIT:
                return np.asarray(image.convert("RGB"))
    # Pillow raises whatever its decoders meet.
    except Exception as error:
        raise MessageError("bad-jpeg", f"this is no JPEG picture: {error!s:.60}") from None
    raise MessageError("too-big", f"a JPEG picture of {image.width} x {image.height} pixels is over the limit")
