"""Draws img/terminal.svg, a terminal in which a lesson has just run: python3 -m kitlib.docs.terminal_picture

It runs the lesson in a pseudo-terminal, so that the colours are the real ones; this takes Linux or macOS.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from html import escape, unescape

from kitlib.docs.guide import begin_anew, run_command, with_own_ports
from kitlib.lessons import ROOT

PICTURE = ROOT / "img" / "terminal.svg"
# A reply is lost, the client asks again, and nothing is counted twice.
RUN = '2 --server="--drop 2" --options="--count 3"'
TITLE = "A lost reply: the client asks again, and the server finds the answer in its journal"

# As wide as GitHub's column, so that text has there the size that it has here.
WIDTH, SIZE, STEP, LEFT, TOP = 840, 16, 24, 26, 78
ADVANCE = 0.6 * SIZE
FONT = "ui-monospace, SFMono-Regular, Menlo, Consolas, 'DejaVu Sans Mono', monospace"
CARD, BAR, EDGE, INK, DIM = "#0d1117", "#21262d", "#444c56", "#e6edf3", "#9198a1"
BUTTONS = ("#ff5f57", "#febc2e", "#28c840")
PALETTE = {"31": "#ff7b72", "32": "#3fb950", "33": "#e3b341", "36": "#56d4dd"}
COLOUR = re.compile(r"\033\[(\d+)m(.*?)\033\[0m")


def record(run: str) -> list[str]:
    """What a lesson prints into a terminal, with its colours; not what kit.py says of this machine."""
    import pty

    environment = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
    ours, its = pty.openpty()
    environment["TERM"] = "xterm"
    with subprocess.Popen(run_command(run), stdin=its, stdout=its, stderr=its, env=environment) as process:
        os.close(its)
        printed = b""
        while chunk := read(ours):
            printed += chunk
    os.close(ours)
    if process.returncode:
        sys.exit(f"`kit.py run {run}` ended with {process.returncode}; it printed {printed.decode()}")
    text = with_own_ports(printed.decode().replace("\r\n", "\n"), run)
    return [line for line in text.splitlines() if re.match(r"\033\[\d+m(server|client) \|", line)]


def read(terminal: int) -> bytes:
    """What has been printed; nothing when the program has ended, which Linux says with an error."""
    try:
        return os.read(terminal, 4096)
    except OSError:
        return b""


def draw(command: str, lines: list[str]) -> str:
    """The SVG of a terminal with this command and these lines."""
    height = TOP + STEP * len(lines) + 14
    parts = [
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {WIDTH} {height}' width='{WIDTH}' role='img'"
        f" font-family=\"{FONT}\" font-size='{SIZE}' fill='{INK}' xml:space='preserve'>",
        f"<title>{escape(TITLE)}</title>",
        # A card of its own colour, with an edge, reads in a light and in a dark page.
        f"<rect x='1' y='1' width='{WIDTH - 2}' height='{height - 2}' rx='10' fill='{CARD}' stroke='{EDGE}'/>",
        f"<path d='M1 38 V11 a10 10 0 0 1 10 -10 H{WIDTH - 11} a10 10 0 0 1 10 10 V38 z' fill='{BAR}'/>",
        *(f"<circle cx='{24 + 22 * i}' cy='20' r='6.5' fill='{fill}'/>" for i, fill in enumerate(BUTTONS)),
        row(TOP - 12, f"$ {command}", DIM),
        *(row(TOP - 12 + STEP * (i + 1), line) for i, line in enumerate(lines)),
    ]
    return "\n".join([*parts, "</svg>", ""])


def row(y: float, line: str, colour: str = INK) -> str:
    """One line of text. Its length is said, so that every font is as wide as the card expects."""
    shown = escape(COLOUR.sub(r"\2", line), quote=False)
    inside = COLOUR.sub(lambda f: f"<tspan fill='{PALETTE[f[1]]}'>{f[2]}</tspan>", escape(line, quote=False))
    width = f"{ADVANCE * len(unescape(shown)):g}"
    return f"<text x='{LEFT}' y='{y:g}' fill='{colour}' textLength='{width}'>{inside}</text>"


def lines_of(svg: str) -> list[str]:
    """The lines of text that a picture shows: the command, then what it printed."""
    rows = re.findall(r"<text .*?>(.*)</text>", svg)
    return [unescape(re.sub(r"<.*?>", "", line)) for line in rows]


def main() -> None:
    """Run the lesson on a new journal and draw what it printed."""
    begin_anew()
    lines = record(RUN)
    PICTURE.write_text(draw(f"python3 kit.py run {RUN}", lines), encoding="utf-8", newline="\n")
    print(f"drew {PICTURE.relative_to(ROOT).as_posix()}")


if __name__ == "__main__":
    main()
