"""Draws img/lessons.svg, the map of the lessons with three paths through them: python3 -m kitlib.docs.lesson_map"""

from __future__ import annotations

from kitlib.docs.pictures import PROCESS, box, card, text
from kitlib.lessons import ROOT, find

WIDTH, HEIGHT = 840, 344
# A box's size, and how far it is to the next one.
BROAD, HIGH, STEP = 80, 64, 92
# All begin with lesson 01; each path has its colour, and at its end what is for when others come in.
PATHS = (
    ("a game", "#0550ae", ("02", "04", "06", "14", "21"), "15"),
    ("agents that see and learn", "#116329", ("05", "08", "09", "10", "11", "12", "13"), "17"),
    ("what happens now, for everybody", "#953800", ("03", "07", "20"), "16"),
)
FIRST = "01"


def station(x: float, y: float, number: str) -> list[str]:
    """A lesson: its number, and below it its name in one line or two."""
    words = find(number).key.split("_")[1:]
    # In two lines of about equal length.
    cut = min(range(1, len(words) + 1), key=lambda i: max(len(" ".join(words[:i])), len(" ".join(words[i:]))))
    lines = [" ".join(words[:cut]), " ".join(words[cut:])]
    named = [text(x + BROAD / 2, y + 38 + 16 * i, line, 12) for i, line in enumerate(lines)]
    return [box(x, y, BROAD, HIGH, PROCESS), text(x + BROAD / 2, y + 20, number, 15), *named]


def picture() -> str:
    """Lesson 01 on the left, a line for each path, and on the right what all of them may need at last."""
    title = "Lesson 01 leads to three paths: " + "; ".join(
        f"{name}, lessons {', '.join((*numbers, last))}" for name, _, numbers, last in PATHS
    )
    right, middle = WIDTH - 14 - BROAD, 160 + HIGH / 2
    lines, stations = list[str](), station(14, 160, FIRST)
    for row, (name, colour, numbers, last) in enumerate(PATHS):
        y = 60 + 100 * row
        centre = y + HIGH / 2
        lines += [
            f"<path d='M{14 + BROAD / 2:g} {middle:g} L{106:g} {centre:g} H{right:g}' "
            f"stroke='{colour}' stroke-width='5' fill='none'/>",
            text(106, y - 10, name, anchor="start"),
        ]
        for i, number in enumerate(numbers):
            stations += station(106 + STEP * i, y, number)
        stations += station(right, y, last)
    last_column = text(right + BROAD, 30, "when others come in", anchor="end")
    return card(WIDTH, HEIGHT, title, last_column, *lines, *stations)


def main() -> None:
    """Write the picture."""
    target = ROOT / "img" / "lessons.svg"
    target.write_text(picture(), encoding="utf-8")
    print(f"drew {target.relative_to(ROOT).as_posix()}")


if __name__ == "__main__":
    main()
