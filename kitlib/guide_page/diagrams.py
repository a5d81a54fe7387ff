"""A sequence diagram of the guide as SVG: as much of Mermaid's language as the pages have."""

import re
from html import escape

# In pixels, of a letter of 14 px: generous, since each system has another font.
LETTER, LINE = 7.6, 19
ARROW = re.compile(r"(\w+?)(->>|--x)(\w+): (.*)")
NOTE = re.compile(r"Note over (\w+)(?:,(\w+))?: (.*)")


def size(text: str) -> tuple[float, int]:
    lines = text.split("<br/>")
    return max(map(len, lines)) * LETTER + 24, LINE * len(lines)


def words(text: str, x: float, y: float) -> str:
    lines = enumerate(text.split("<br/>"))
    spans = (f'<tspan x="{x:.0f}" y="{y + LINE * at:.0f}">{escape(line)}</tspan>' for at, line in lines)
    return f"<text>{''.join(spans)}</text>"


def box(x: float, y: float, wide: float, high: float) -> str:
    """`x` is its middle."""
    place = f'x="{x - wide / 2:.0f}" y="{y:.0f}" width="{wide:.0f}" height="{high:.0f}"'
    return f'<rect {place} rx="6"/>'


def svg(source: str) -> str:
    """The picture, whose colours are those of the page's style."""
    lines = [line.strip() for line in source.splitlines()[1:] if line.strip()]
    names = {name: shown or name for name, shown in re.findall(r"participant (\w+)(?: as (.*))?", source)}
    order, arrows = list(names), [found for found in map(ARROW.fullmatch, lines) if found]
    spans = [size(each[4])[0] / abs(order.index(each[1]) - order.index(each[3])) for each in arrows]
    gap = max(*spans, *(size(name)[0] + 12 for name in names.values()))
    at = {name: gap * number for number, name in enumerate(order)}
    right = gap * (len(order) - 1)
    edges = [x + side * size(names[name])[0] / 2 for name, x in at.items() for side in (-1, 1)]
    shown, y = "", 54.0
    for line in lines:
        if found := ARROW.fullmatch(line):
            one, other, high = at[found[1]], at[found[3]], size(found[4])[1]
            y += high + 14
            way = 1 if other > one else -1
            kind, end = ("lost", other - 14 * way) if found[2] == "--x" else ("sent", other)
            tip = "m-5 -5 l10 10 m0 -10 l-10 10" if kind == "lost" else f"m0 0 l{-10 * way} -5 v10 z"
            shown += words(found[4], (one + other) / 2, y - high + 8)
            shown += f'<path class="{kind}" d="M{one:.0f} {y:.0f} H{end:.0f} {tip}"/>'
        elif found := NOTE.fullmatch(line):
            first, last, (wide, high) = at[found[1]], at[found[2] or found[1]], size(found[3])
            x, wide = (first + last) / 2, max(wide, abs(last - first) + 40)
            edges += [x - wide / 2, x + wide / 2]
            shown += box(x, y + 10, wide, high + 10) + words(found[3], x, y + LINE + 10)
            y += high + 24
        elif found := re.fullmatch(r"(?:alt|else|end) ?(.*)", line):
            shown += f'<path class="life" d="M-50 {y + 14:.0f} h{right + 100:.0f}"/>'
            y += LINE + 14 if found[1] else 14
            shown += words(found[1], right / 2, y)
            edges += [-50, right + 50]
    heads = ""
    for name, x in at.items():
        heads += f'<path class="life" d="M{x:.0f} 40 V{y + 14:.0f}"/>'
        heads += box(x, 8, size(names[name])[0], 32) + words(names[name], x, 29)
    left, wide = min(edges) - 8, max(edges) - min(edges) + 16
    said = escape("; ".join(each[0] for each in arrows), quote=True)
    view = f'viewBox="{left:.0f} 0 {wide:.0f} {y + 22:.0f}" width="{wide:.0f}" role="img" aria-label="{said}"'
    return f'<svg class="sequence" {view}>{heads}{shown}</svg>'
