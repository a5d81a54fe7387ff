"""Lesson 08, a film: a GIF of a recorded drive, with the steering wheel and each picture's number drawn into it.

    python python/08_see_and_steer/film.py runs/run_0001 drive.gif                ten seconds, ten pictures in each
    python python/08_see_and_steer/film.py runs/run_0001 drive.gif --first 500    from line 500 on

It needs numpy and Pillow.
"""

import argparse
import itertools
import math
import sys
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.extras import importing
from netmq_example.program import run, whole

with importing("numpy and Pillow: pip install numpy pillow, or let kit.py run 8 do it", stopped="stopped"):
    from driver import main_camera
    from PIL import Image, ImageDraw

    from netmq_example.camera.recording import Row, recorded

# Few colours make a small file: 100 pictures of 320 x 240 are under 1 MB.
COLOURS = 32
WHITE = (255, 255, 255)
BLACK = (0, 0, 0)
RED = (200, 30, 30)


def scene(row: Row) -> Any:
    """A recorded picture with what is known about it."""
    picture = Image.fromarray(main_camera(row.pictures))
    pen = ImageDraw.Draw(picture)
    steer = row.values["steer"]
    width, height = picture.size
    pen.rectangle((0, height - 14, width, height), fill=BLACK)
    text = f"frame {row.values['frame']}   speed {row.values['speed']:.1f} m/s   steer {steer:+.2f}"
    pen.text((6, height - 13), text, fill=WHITE)
    # Full lock turns the wheel by a quarter; it stands upright at 0.
    x, y = width / 2, height - 46
    radius = 24
    angle = steer * math.pi / 2
    pen.ellipse((x - radius, y - radius, x + radius, y + radius), outline=BLACK, width=5)
    for spoke in (angle, angle + math.pi / 2, angle + math.pi, angle - math.pi / 2):
        end = x + radius * math.sin(spoke), y - radius * math.cos(spoke)
        pen.line((x, y, *end), fill=RED if spoke == angle else BLACK, width=4)
    return picture


def main() -> None:
    parser = argparse.ArgumentParser(description="Makes a GIF of a recorded drive.")
    parser.add_argument("recording", type=Path, help="a recorded drive, such as runs/run_0001")
    parser.add_argument("out", type=Path, help="the file to write")
    parser.add_argument("--first", type=whole, default=0, help="how many pictures to leave out at the beginning")
    parser.add_argument("--count", type=whole, default=100, help="how many pictures to show")
    options = parser.parse_args()
    try:
        # Every fifth of 50 a second: browsers show no GIF much faster.
        found = itertools.islice(recorded(options.recording), options.first, None, 5)
        scenes = [scene(row) for row in itertools.islice(found, options.count)]
    except OSError as error:
        sys.exit(f"no film of {options.recording}: {error}; server.py --record runs makes recordings")
    if not scenes:
        sys.exit(f"no film of {options.recording}: it has no picture there; try a smaller --first")
    # One palette for all: each picture then keeps only what has changed.
    palette = scenes[0].quantize(COLOURS)
    small = [each.quantize(palette=palette, dither=Image.Dither.NONE) for each in scenes]
    try:
        small[0].save(options.out, save_all=True, append_images=small[1:], duration=100, loop=0)
    except (OSError, ValueError) as error:
        sys.exit(f"cannot write {options.out}: {error}; give it a name that ends in .gif")
    print(f"wrote {options.out}: {len(scenes)} pictures, {options.out.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    run(main, stopped="stopped")
