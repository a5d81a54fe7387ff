"""Draws the lab's results: python3 -m lab.plots lab/performance.json img

Needs matplotlib. Colours are Okabe and Ito's, which also colour-blind readers tell apart; nothing is said by a colour
alone: each bar and line has its name and its number.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from matplotlib import pyplot

from lab.report import rows_of

pyplot.switch_backend("svg")
# Letters stay letters, and two runs on the same numbers draw the same file.
pyplot.rcParams.update({
    "svg.fonttype": "none", "svg.hashsalt": "netmqexample", "font.family": "sans-serif", "font.size": 14,
    "axes.spines.top": False, "axes.spines.right": False,
})  # fmt: skip

OURS, OTHERS, LIMIT = "#0072B2", "#E69F00", "#999999"


def colour(label: str) -> str:
    """Ours, theirs, and the limit."""
    if label.startswith("raw TCP"):
        return LIMIT
    return OURS if label.startswith(("lesson", "NetMQ")) else OTHERS


def save(path: Path, figure: Any, title: str) -> None:
    figure.savefig(path, format="svg", facecolor="white", metadata={"Date": None, "Title": title}, bbox_inches="tight")
    pyplot.close(figure)
    text = path.read_text(encoding="utf-8")
    path.write_text("\n".join(line.rstrip() for line in text.splitlines()) + "\n", encoding="utf-8")


def bars(path: Path, title: str, unit: str, rows: list[tuple[str, list[float]]]) -> None:
    """A bar for each row from the top, as long as its middle value, with a line from the least to the greatest.

    The axis begins at 0 and is linear: a bar says by its length how many times as much it stands for.
    """
    figure, axes = pyplot.subplots(figsize=(10, 1.2 + 0.42 * len(rows)))
    for place, (label, (least, middle, greatest)) in enumerate(rows):
        hatched = not label.startswith("lesson") and colour(label) == OURS
        axes.barh(place, middle, color=colour(label), hatch="//" if hatched else None, edgecolor="white")
        axes.plot([least, greatest], [place, place], color="black", linewidth=1.5)
        axes.annotate(
            f"{middle:,.3g}" if middle < 1000 else f"{middle:,.0f}",
            (greatest, place),
            textcoords="offset points",
            xytext=(8, 0),
            va="center",
        )
    axes.set_yticks(range(len(rows)), [label for label, _ in rows])
    axes.invert_yaxis()
    axes.set_xlabel(unit)
    axes.set_xlim(left=0)
    axes.set_title(title, fontsize=16, loc="left")
    save(path, figure, title)


def main(kept: Path, folder: Path) -> None:
    results = json.loads(kept.read_text(encoding="utf-8"))
    for title, name in (("32 B", "32"), ("230,400 B", "230400")):
        found = [
            row for row in rows_of(results, f"echo of {title}") if row["ratio"] and " in flight" not in row["label"]
        ]
        path, unit = folder / f"performance_echo_{name}.svg", "times raw TCP in the same round: least, middle, greatest"
        bars(path, f"Echo of {title}, one after the other", unit, [(row["label"], row["ratio"]) for row in found])


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
