"""A sequence diagram of the guide as a table, which any browser lays out: as much of Mermaid's as the pages have."""

import re
from html import escape

ARROW = re.compile(r"(\w+?)(->>|--x)(\w+): (.*)")
NOTE = re.compile(r"Note over (\w+)(?:,(\w+))?: (.*)")
PART = re.compile(r"(?:alt|else|end) ?(.*)")


def row(start: int, stop: int, wide: int, kind: str, text: str) -> str:
    """A row whose cell from `start` to `stop` has the text. Each participant has two columns, its line in between."""
    empty = ["<td></td>" if number % 2 else '<td class="life"></td>' for number in range(wide)]
    shown = "<br>".join(map(escape, text.split("<br/>")))
    cell = f'<td colspan="{stop - start}" class="{kind}">{shown}</td>'
    return f"<tr>{''.join([*empty[:start], cell, *empty[stop:]])}</tr>"


def table(source: str) -> str:
    names = {name: shown or name for name, shown in re.findall(r"participant (\w+)(?: as (.*))?", source)}
    line_of = {name: 2 * number + 1 for number, name in enumerate(names)}
    wide = 2 * len(names)
    rows = "".join(f'<th colspan="2">{escape(shown)}</th>' for shown in names.values())
    for line in map(str.strip, source.splitlines()):
        if found := ARROW.fullmatch(line):
            one, other = line_of[found[1]], line_of[found[3]]
            kind = f"{'right' if other > one else 'left'} life{' lost' * (found[2] == '--x')}"
            rows += row(min(one, other), max(one, other), wide, kind, found[4])
        elif found := NOTE.fullmatch(line):
            rows += row(line_of[found[1]] - 1, line_of[found[2] or found[1]] + 1, wide, "note", found[3])
        elif found := PART.fullmatch(line):
            rows += row(0, wide, wide, "part", found[1])
    return f'<table class="sequence">{rows}</table>'
