"""Pictures for lesson 05: what stands for a camera, where a picture is brightest, and JPEG files.

They only give the messages something to carry: a lesson about cameras is to come. It needs numpy, and for JPEG Pillow.
"""

import io
import re
import sys
import time
from typing import Any

from messages import LIMIT, Array, Message, MessageError

try:
    import numpy as np
except ImportError:
    sys.exit("this lesson needs numpy: pip install numpy, or let python3 kit.py run 5 do it")

WIDTH, HEIGHT = 320, 240
MOST_SCANS, MOST_PARTS = 50, 200
# What may stand before the first scan, each with its length: sizes, tables, notes of applications, comments. The kinds
# of JPEG that no camera writes are left out: some are ten times as slow to decode.
PART = re.compile(rb"\xff[\xc0-\xc2\xc4\xdb-\xef\xfe](..)", re.DOTALL)


def picture(number: int, as_jpeg: bool = False) -> Message:
    """A picture as a request: grey, with a white square of 8 x 8 pixels that moves."""
    pixels = np.full((HEIGHT, WIDTH, 3), 10 * number % 200, np.uint8)
    x, y = 16 * number % WIDTH, 8 * number % HEIGHT
    pixels[y : y + 8, x : x + 8] = 255
    if not as_jpeg:
        # The lowest row first, as Unity's textures have it.
        return Message("frame", number, {"bottom_up": True}, [Array("uint8", pixels.shape, pixels[::-1].tobytes())])
    try:
        from PIL import Image
    except ImportError:
        sys.exit("--jpeg needs Pillow: pip install pillow, or let python3 kit.py run 5 do it")
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG")
    return Message("jpeg", number, {}, [Array("uint8", (len(file.getvalue()),), file.getvalue())])


class Camera:
    """Counts pictures: `fps` a second, whether anybody looks or not, or with 0 one whenever somebody asks."""

    def __init__(self, fps: float) -> None:
        self.fps, self.begin, self.number = fps, time.monotonic(), 0

    def newest(self) -> int:
        """The number of the newest picture; waits for the next one if it was asked for the newest before."""
        self.number += 1
        if self.fps:
            time.sleep(max(0.0, self.begin + self.number / self.fps - time.monotonic()))
            self.number = max(self.number, int((time.monotonic() - self.begin) * self.fps))
        return self.number


def brightest(request: Message) -> dict[str, Any]:
    """Where a picture's brightest pixel is, counted from the top left; the picture is of kind frame or jpeg."""
    if len(request.arrays) != 1:
        raise MessageError("bad-shape", f"{request.kind} takes one array, not {len(request.arrays)}")
    items = decode(bytes(request.arrays[0].data)) if request.kind == "jpeg" else request.arrays[0].numpy()
    if items.dtype != np.uint8 or items.ndim != 3 or items.shape[2] != 3 or not items.size:
        raise MessageError("bad-shape", f"a picture is uint8 [height, width, 3], not {items.dtype} {[*items.shape]}")
    # Backwards is a view: it copies nothing.
    picture = items[::-1] if request.values.get("bottom_up") is True else items
    y, x = divmod(int(picture.sum(axis=2, dtype=np.uint16).argmax()), picture.shape[1])
    return {"x": x, "y": y, "mean": float(picture.mean())}


def described(values: dict[str, Any]) -> str:
    """A reply's values, to print. A server of your own may answer with something else."""
    if values.keys() >= {"x", "y", "mean"} and type(values["mean"]) in (int, float):
        return f"brightest at x {values['x']}, y {values['y']}, mean {values['mean']:.1f}"
    return ", ".join(f"{name} {value}" for name, value in values.items()) or "no values"


def decode(file: bytes) -> Any:
    """The pixels of a JPEG file, top row first."""
    try:
        from PIL import Image
    except ImportError:
        raise MessageError("no-pillow", "the server needs Pillow for JPEG: pip install pillow") from None
    check(file)
    try:
        with Image.open(io.BytesIO(file), formats=["JPEG"]) as image:
            # Its size is known before it is decoded: a small file can claim to be an enormous picture.
            if image.width * image.height * 3 <= LIMIT:
                return np.asarray(image.convert("RGB"))
    # Pillow raises whatever its decoders meet.
    except Exception as error:
        raise MessageError("bad-jpeg", f"this is no JPEG picture: {error!s:.60}") from None
    raise MessageError("too-big", f"a JPEG picture of {image.width} x {image.height} pixels is over the limit")


def check(file: bytes) -> None:
    """Refuse a file that would be slow to decode by what it announces: each scan costs a pass over the whole picture.

    A camera's file has one scan, or some ten for a picture that gets sharper while it loads, after some twenty parts.
    """
    at, parts = 2, 0
    while (part := PART.match(file, at)) and parts < MOST_PARTS:
        at, parts = at + 2 + int.from_bytes(part[1], "big"), parts + 1
    # In the pixels' data 0xff is never followed by 0xda: what looks like a scan is one.
    if part or file.count(b"\xff\xda", at) > MOST_SCANS:
        raise MessageError("too-big", f"a JPEG picture of over {MOST_SCANS} scans or {MOST_PARTS} parts is refused")
    if file[at : at + 2] != b"\xff\xda":
        raise MessageError("bad-jpeg", "this is no JPEG picture: its parts are not in order")
