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

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from driver import main_camera

from netmq_example.camera.recording import recorded

try:
    from PIL import Image, ImageDraw
except ImportError:
    sys.exit("a film needs Pillow: pip install pillow, or let kit.py run 8 do it")

# Few colours make a small file: 100 pictures of 320 x 240 are under 1 MB.
COLOURS, WHITE, BLACK = 32, (255, 255, 255), (0, 0, 0)


def scene(values: dict[str, Any], seen: dict[str, Any]) -> Any:
    """A recorded picture with what is known about it."""
    picture = Image.fromarray(main_camera(seen))
    pen, steer = ImageDraw.Draw(picture), values["steer"]
    width, height = picture.size
    pen.rectangle((0, height - 14, width, height), fill=BLACK)
    text = f"frame {values['frame']}   speed {values['speed']:.1f} m/s   steer {steer:+.2f}"
    pen.text((6, height - 13), text, fill=WHITE)
    # Full lock turns the wheel by a quarter; it stands upright at 0.
    x, y, radius, angle = width / 2, height - 46, 24, steer * math.pi / 2
    pen.ellipse((x - radius, y - radius, x + radius, y + radius), outline=BLACK, width=5)
    for spoke in (angle, angle + math.pi / 2, angle + math.pi, angle - math.pi / 2):
        end = x + radius * math.sin(spoke), y - radius * math.cos(spoke)
        pen.line((x, y, *end), fill=(200, 30, 30) if spoke == angle else BLACK, width=4)
    return picture


def main() -> None:
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Makes a GIF of a recorded drive.")
    parser.add_argument("recording", type=Path, help="a folder of recorder.py, such as runs/run_0001")
    parser.add_argument("out", type=Path, help="the file to write")
    parser.add_argument("--first", type=int, default=0, help="how many pictures to leave out at the beginning")
    parser.add_argument("--count", type=int, default=100, help="how many pictures to show")
    options = parser.parse_args()
    try:
        # Every fifth of 50 a second: browsers show no GIF much faster.
        found = itertools.islice(recorded(options.recording), max(0, options.first), None, 5)
        scenes = [scene(values, seen) for _, values, _, seen in itertools.islice(found, max(0, options.count))]
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
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
