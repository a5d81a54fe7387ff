"""A sequence diagram of the guide as SVG: as much of Mermaid's language as the pages have."""

import re
from collections.abc import Sequence
from html import escape
from itertools import pairwise

# In pixels, of a letter of 14 px: generous, since each system has another font.
LETTER, LINE = 7.6, 19
ARROW = re.compile(r"(\w+?)(->>|--x)(\w+): (.*)")
NOTE = re.compile(r"Note over (\w+)(?:,(\w+))?: (.*)")


def width(text: str) -> float:
    return max(len(line) for line in text.split("<br/>")) * LETTER + 24


def height(text: str) -> int:
    return LINE * len(text.split("<br/>"))


def words(text: str, x: float, y: float) -> str:
    lines = enumerate(text.split("<br/>"))
    return "".join(f'<text x="{x:.0f}" y="{y + LINE * at:.0f}">{escape(line)}</text>' for at, line in lines)


def box(kind: str, left: float, top: float, wide: float, high: float) -> str:
    return f'<rect class="{kind}" x="{left:.0f}" y="{top:.0f}" width="{wide:.0f}" height="{high:.0f}" rx="6"/>'


def places(names: dict[str, str], lines: Sequence[str]) -> dict[str, float]:
    """The middle of each participant: as near to the one before as the names and the texts of the arrows allow."""
    order = list(names)
    gaps = [max(110.0, (width(names[one]) + width(names[other])) / 2 + 12) for one, other in pairwise(order)]
    for line in lines:
        if found := ARROW.fullmatch(line):
            first, last = sorted((order.index(found[1]), order.index(found[3])))
            missing = width(found[4]) - sum(gaps[first:last])
            for at in range(first, last):
                gaps[at] += max(0, missing) / (last - first)
    return {name: sum(gaps[:at]) for at, name in enumerate(order)}


def svg(source: str) -> str:
    """The picture, whose colours are those of the page's style."""
    lines = [line.strip() for line in source.splitlines()[1:] if line.strip()]
    declared = [re.fullmatch(r"participant (\w+)(?: as (.*))?", line) for line in lines]
    names = {each[1]: each[2] or each[1] for each in declared if each}
    at = places(names, lines)
    middle = list(at.values())
    shown, y, frames = [], 62.0, []
    left, right = middle[0] - width(names[next(iter(names))]) / 2, middle[-1] + width(list(names.values())[-1]) / 2
    for line in lines:
        if found := ARROW.fullmatch(line):
            one, other = at[found[1]], at[found[3]]
            y += height(found[4])
            shown.append(words(found[4], (one + other) / 2, y - height(found[4]) + LINE - 5))
            lost = found[2] == "--x"
            end = other + (14 if one > other else -14) * lost
            kind, mark = ("lost", "cross") if lost else ("sent", "head")
            shown.append(f'<path class="{kind}" d="M{one:.0f} {y + 4:.0f} H{end:.0f}" marker-end="url(#{mark})"/>')
            y += 16
        elif found := NOTE.fullmatch(line):
            over = sorted((at[found[1]], at[found[2] or found[1]]))
            wide = max(width(found[3]), over[1] - over[0] + 40)
            x = sum(over) / 2
            left, right = min(left, x - wide / 2), max(right, x + wide / 2)
            shown.append(box("note", x - wide / 2, y, wide, height(found[3]) + 10))
            shown.append(words(found[3], x, y + LINE))
            y += height(found[3]) + 20
        elif found := re.fullmatch(r"(alt|else) (.*)", line):
            frames += [y] if found[1] == "alt" else []
            rule = f'<path class="else" d="M{middle[0] - 50:.0f} {y:.0f} H{middle[-1] + 50:.0f}"/>'
            shown.append(rule if found[1] == "else" else "")
            shown.append(words(f"[{found[2]}]", (middle[0] + middle[-1]) / 2, y + LINE))
            y += LINE + 8
        elif line == "end":
            top = frames.pop()
            shown.append(box("frame", middle[0] - 50, top, middle[-1] - middle[0] + 100, y - top))
            y += 12
            left, right = min(left, middle[0] - 52), max(right, middle[-1] + 52)
    heads = []
    for name, text in names.items():
        heads.append(f'<path class="life" d="M{at[name]:.0f} 40 V{y + 6:.0f}"/>')
        heads.append(box("head", at[name] - width(text) / 2, 8, width(text), 32))
        heads.append(words(text, at[name], 29))
    view = f"{left - 8:.0f} 0 {right - left + 16:.0f} {y + 14:.0f}"
    marks = (
        '<defs><marker id="head" viewBox="0 0 10 10" refX="10" refY="5" markerWidth="9" markerHeight="9" orient="auto">'
        '<path class="tip" d="M0 0 L10 5 L0 10 z"/></marker>'
        '<marker id="cross" viewBox="0 0 10 10" refX="5" refY="5" markerWidth="10" markerHeight="10">'
        '<path class="lost" d="M1 1 L9 9 M9 1 L1 9"/></marker></defs>'
    )
    said = escape("; ".join(line for line in lines if ARROW.fullmatch(line)), quote=True)
    size = f'viewBox="{view}" width="{right - left + 16:.0f}" role="img" aria-label="{said}"'
    return f'<svg class="sequence" {size}>{marks}{"".join(heads)}{"".join(shown)}</svg>'
