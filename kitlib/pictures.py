"""Draws img/NN_slug.svg, a lesson's sequence diagram, from img/NN_slug.seq: python3 -m kitlib.pictures

The text, line by line:
    title: what the picture shows
    actors: C# client, Python server
    C# client -> Python server: Hello        an arrow
    C# client -x Python server: Hello        an arrow that is lost on the way
    Python server: works                     a note beside an actor's line
"""

from __future__ import annotations

import re
import sys
from html import escape
from pathlib import Path

from .lessons import ROOT, KitError

WIDTH, MARGIN, TOP, STEP = 760, 130, 92, 40
INK, LINE, ARROW, LOST, NOTE = "#1f2328", "#8c959f", "#0550ae", "#a40e26", "#fff8c5"
FONT = "font-family='ui-sans-serif, system-ui, sans-serif'"


def text(x: float, y: float, words: str, size: int = 15, colour: str = INK, anchor: str = "middle") -> str:
    return f"<text x='{x:g}' y='{y:g}' font-size='{size}' fill='{colour}' text-anchor='{anchor}'>{escape(words)}</text>"


def arrow(start: float, end: float, y: float, words: str, lost: bool) -> list[str]:
    colour = LOST if lost else ARROW
    tip = start + (end - start) * (0.6 if lost else 1.0)
    way = 1 if end > start else -1
    # A lost message is dashed and ends in a cross, so that no reader depends on the colour.
    head = (
        f"<path d='M{tip - 6:g} {y - 6} l12 12 m0 -12 l-12 12' stroke='{colour}' stroke-width='2.5' fill='none'/>"
        if lost
        else f"<path d='M{tip:g} {y} l{-9 * way} -5 v10 z' fill='{colour}'/>"
    )
    dash = " stroke-dasharray='6 4'" if lost else ""
    return [
        f"<path d='M{start:g} {y} H{tip:g}' stroke='{colour}' stroke-width='2'{dash}/>",
        head,
        text((start + end) / 2, y - (11 if lost else 7), words),
    ]


def note(x: float, y: float, words: str) -> list[str]:
    width = 8.2 * len(words) + 20
    left = min(max(x - width / 2, 8), WIDTH - width - 8)
    box = f"<rect x='{left:g}' y='{y - 17}' width='{width:g}' height='26' rx='5' fill='{NOTE}' stroke='{LINE}'/>"
    return [box, text(left + width / 2, y + 1, words, 14)]


def draw(source: str, name: str = "the text") -> str:
    """The SVG of one sequence; KitError names a line that is not in the form above."""
    title, actors, *steps = [line.strip() for line in source.splitlines() if line.strip()]
    if not title.startswith("title: ") or not actors.startswith("actors: "):
        raise KitError(f"{name} must begin with a line `title: ...` and a line `actors: A, B`")
    names = [actor.strip() for actor in actors.removeprefix("actors: ").split(",")]
    gap = (WIDTH - 2 * MARGIN) / max(1, len(names) - 1)
    place = {actor: MARGIN + i * gap for i, actor in enumerate(names)}
    height = TOP + STEP * (len(steps) + 1)
    parts = [
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {WIDTH} {height}' width='{WIDTH}' role='img' {FONT}>",
        f"<title>{escape(title.removeprefix('title: '))}</title>",
        # A card of its own colour reads in a light and in a dark page.
        f"<rect width='{WIDTH}' height='{height}' rx='10' fill='#ffffff'/>",
        text(WIDTH / 2, 28, title.removeprefix("title: "), 17),
    ]
    for actor, x in place.items():
        parts.append(f"<path d='M{x:g} {TOP - 14} V{height - 16}' stroke='{LINE}' stroke-width='1.5'/>")
        wide = max(168, 8.4 * len(actor) + 16)
        box = f"x='{x - wide / 2:g}' y='{TOP - 48}' width='{wide:g}' height='34' rx='7'"
        parts.append(f"<rect {box} fill='#ddf4ff' stroke='{LINE}'/>")
        parts.append(text(x, TOP - 26, actor, 15))
    for i, step in enumerate(steps):
        y = TOP + STEP * i + 26
        form = re.fullmatch(r"(.+?)(?: -([>x]) (.+?))?: (.+)", step)
        if not form or form[1] not in place or (form[3] or form[1]) not in place:
            raise KitError(f"{name}: `{step}` is neither `A -> B: text` nor `A: text` with actors of line 2")
        if form[3]:
            parts += arrow(place[form[1]], place[form[3]], y, form[4], form[2] == "x")
        else:
            parts += note(place[form[1]], y, form[4])
    return "\n".join([*parts, "</svg>", ""])


def main() -> None:
    for path in sorted((ROOT / "img").glob("*.seq")):
        target = path.with_suffix(".svg")
        target.write_text(draw(path.read_text(encoding="utf-8"), path.name), encoding="utf-8")
        print(f"{Path(path.name)} -> {target.name}")


if __name__ == "__main__":
    try:
        main()
    except KitError as error:
        sys.exit(str(error))
