"""Stands for a camera in lesson 05: grey pictures with a white square that moves."""

from __future__ import annotations

import io
import sys
import time

WIDTH, HEIGHT = 320, 240


def picture(number: int) -> bytearray:
    """RGB pixels, the lowest row first, as Unity's textures have it; the square has 8 x 8 of them."""
    pixels = bytearray([10 * number % 200]) * (WIDTH * HEIGHT * 3)
    left, top = 16 * number % WIDTH, 8 * number % HEIGHT
    for y in range(top, top + 8):
        start = ((HEIGHT - 1 - y) * WIDTH + left) * 3
        pixels[start : start + 24] = b"\xff" * 24
    return pixels


def jpeg(pixels: bytearray) -> bytes:
    """The picture as a JPEG file. Such a file has its top row first, so it is turned over here."""
    try:
        from PIL import Image
    except ImportError:
        sys.exit("--jpeg needs Pillow: pip install pillow, or let python3 kit.py run 5 do it")
    file = io.BytesIO()
    Image.frombytes("RGB", (WIDTH, HEIGHT), bytes(pixels), "raw", "RGB", 0, -1).save(file, "JPEG")
    return file.getvalue()


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
