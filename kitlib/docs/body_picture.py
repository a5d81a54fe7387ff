"""Draws img/20_body_tracking.gif, the recorded persons of application 20: python3 -m kitlib.docs.body_picture

Pillow must be there. The lines are those of the skeleton in Unity, seen from its scene's camera.
"""

from __future__ import annotations

import csv
import re
from pathlib import Path

from kitlib.lessons import ROOT, find

PICTURE = ROOT / "img" / "20_body_tracking.gif"
WIDTH, HEIGHT, FOCAL = 480, 320, 360
# Where the scene's camera sees the hips of each person: to the right, up, ahead, in metres.
PLACES = [(-0.8, -0.03, 3.4), (0.8, -0.03, 3.4)]
COLOURS = [(255, 170, 70), (90, 190, 255)]
BACKGROUND = (41, 51, 64)
# One picture in two of the recording's 30 a second. A GIF counts hundredths of a second.
EVERY, MILLISECONDS = 2, 70


def lines() -> list[tuple[int, int]]:
    """The skeleton's, as its script has them."""
    text = (find("20").unity / "BodyLines.cs").read_text(encoding="utf-8")
    return [(int(a), int(b)) for a, b in re.findall(r"\((\d+), (\d+)\)", text)]


def seen(row: list[str]) -> list[tuple[float, float]]:
    """Where in the picture the landmarks of a line of the recording are."""
    right, up, ahead = PLACES[int(row[1])]
    numbers = [float(word) for word in row[2:]]
    points = []
    for x, y, z in zip(numbers[::4], numbers[1::4], numbers[2::4], strict=True):
        scale = FOCAL / (ahead + z)
        points.append((WIDTH / 2 + (right + x) * scale, HEIGHT / 2 - (up - y) * scale))
    return points


def draw(path: Path) -> int:
    """The number of pictures drawn."""
    from PIL import Image, ImageDraw

    with (find("20").python / "walk.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))[1:]
    films = []
    for seconds in list(dict.fromkeys(row[0] for row in rows))[::EVERY]:
        # Twice as large, and then made smaller: so the lines have no steps.
        film = Image.new("RGB", (2 * WIDTH, 2 * HEIGHT), BACKGROUND)
        pen = ImageDraw.Draw(film)
        for row in (row for row in rows if row[0] == seconds):
            points = [(2 * x, 2 * y) for x, y in seen(row)]
            for a, b in lines():
                pen.line([points[a], points[b]], COLOURS[int(row[1])], 5)
            for x, y in points:
                pen.ellipse([x - 5, y - 5, x + 5, y + 5], (255, 255, 255))
        films.append(film.resize((WIDTH, HEIGHT)).quantize(32, dither=Image.Dither.NONE))
    films[0].save(path, save_all=True, append_images=films[1:], duration=MILLISECONDS, loop=0, optimize=True)
    return len(films)


if __name__ == "__main__":
    print(f"wrote {PICTURE.relative_to(ROOT).as_posix()}: {draw(PICTURE)} pictures")
