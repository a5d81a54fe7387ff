"""Draws img/architecture.svg, who talks to whom when Unity asks Python: python3 -m kitlib.docs.pictures"""

from __future__ import annotations

from html import escape

from kitlib.lessons import ROOT

# As wide as GitHub's column, so that text has there the size that it has here.
WIDTH, HEIGHT = 840, 418
INK, LINE, ARROW = "#1f2328", "#8c959f", "#0550ae"
CARD, PROCESS, YOURS, THEIRS = "#f6f8fa", "#ffffff", "#ddf4ff", "#eaeef2"
FONT = "font-family='ui-sans-serif, system-ui, sans-serif'"


def text(x: float, y: float, words: str, size: int = 14, anchor: str = "middle") -> str:
    """One line of words."""
    return f"<text x='{x:g}' y='{y:g}' font-size='{size}' fill='{INK}' text-anchor='{anchor}'>{escape(words)}</text>"


def box(x: float, y: float, width: float, height: float, fill: str) -> str:
    """A rectangle with round corners."""
    return f"<rect x='{x:g}' y='{y:g}' width='{width:g}' height='{height:g}' rx='8' fill='{fill}' stroke='{LINE}'/>"


def thread(x: float, y: float, width: float, fill: str, name: str, *lines: str) -> list[str]:
    """A box with the thread's name, and below it what the thread does."""
    middle = x + width / 2
    said = [text(middle, y + 44 + 20 * i, line) for i, line in enumerate(lines)]
    return [box(x, y, width, 76, fill), text(middle, y + 22, name, 16), *said]


def arrow(x: float, y: float, dx: float, dy: float) -> list[str]:
    """A straight arrow, across or down or up."""
    head = f"l{-9 if dx > 0 else 9} -5 v10 z" if dx else f"l-5 {-9 if dy > 0 else 9} h10 z"
    return [
        f"<path d='M{x:g} {y:g} l{dx:g} {dy:g}' stroke='{ARROW}' stroke-width='2'/>",
        f"<path d='M{x + dx:g} {y + dy:g} {head}' fill='{ARROW}'/>",
    ]


def to_and_fro(x: float, y: float, down: str, up: str) -> list[str]:
    """What goes down between two boxes, and what comes up."""
    there = [*arrow(x - 14, y + 3, 0, 40), text(x - 28, y + 28, down, anchor="end")]
    return [*there, *arrow(x + 14, y + 43, 0, -40), text(x + 28, y + 28, up, anchor="start")]


def card(width: int, height: int, title: str, *parts: str) -> str:
    """The SVG of a picture. A card of its own colour reads in a light and in a dark page."""
    head = f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}' width='{width}' role='img' {FONT}>"
    back = f"<rect x='.5' y='.5' width='{width - 1}' height='{height - 1}' rx='10' fill='{CARD}' stroke='{LINE}'/>"
    return "\n".join([head, f"<title>{escape(title)}</title>", back, *parts, "</svg>", ""])


def architecture() -> str:
    """Two processes, their threads, and the one connection between them."""
    title = "Unity's main thread hands a request to a network thread; NetMQ's I/O thread carries it over TCP to Python"
    return card(
        WIDTH,
        HEIGHT,
        title,
        box(20, 20, 400, 378, PROCESS),
        text(220, 47, "Unity process: it connects", 17),
        *thread(
            36,
            62,
            368,
            YOURS,
            "main thread",
            "Update and your callbacks: only here the scene",
            "is touched, and nothing waits for the network",
        ),
        *to_and_fro(220, 138, "request, by a queue", "reply, by a queue"),
        *thread(
            36,
            184,
            368,
            YOURS,
            "network thread",
            "REQ or DEALER socket: made, used and disposed",
            "here; each wait has a limit",
        ),
        *to_and_fro(220, 260, "message", "message"),
        *thread(
            36,
            306,
            368,
            THEIRS,
            "NetMQ's I/O thread",
            "connects to the address, and connects again",
            "when the server was away",
        ),
        box(566, 142, 254, 256, PROCESS),
        text(693, 169, "Python process: it binds", 17),
        *thread(582, 184, 222, YOURS, "your code", "REP or ROUTER socket:", "receive, answer, send"),
        *to_and_fro(693, 260, "message", "message"),
        *thread(
            582, 306, 222, THEIRS, "libzmq's I/O thread", "owns the address, and has a", "connection to each client"
        ),
        text(493, 312, "TCP"),
        *arrow(408, 332, 170, 0),
        *arrow(578, 352, -170, 0),
        text(493, 376, "127.0.0.1:5551"),
        box(566, 40, 20, 20, YOURS),
        text(596, 55, "code that you see and change", anchor="start"),
        box(566, 76, 20, 20, THEIRS),
        text(596, 91, "the library's own", anchor="start"),
    )


def main() -> None:
    """Write the picture."""
    target = ROOT / "img" / "architecture.svg"
    target.write_text(architecture(), encoding="utf-8")
    print(f"drew {target.relative_to(ROOT).as_posix()}")


if __name__ == "__main__":
    main()
