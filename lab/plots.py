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
MARKS = "os^Dv"


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


def echoes(results: dict[str, Any], title: str, path: Path) -> None:
    rows = [
        (row["label"], row["ratio"])
        for row in rows_of(results, f"echo of {title}")
        if row["ratio"] and " in flight" not in row["label"]
    ]
    bars(
        path, f"Echo of {title}, one after the other", "times raw TCP in the same round: least, middle, greatest", rows
    )


def latency(results: dict[str, Any], path: Path) -> None:
    """Where half, 99 of 100 and 999 of 1000 round trips end."""
    rows = [row for row in rows_of(results, "echo of 32 B") if row["latency"]]
    figure, axes = pyplot.subplots(figsize=(10, 1.4 + 0.42 * len(rows)))
    for place, row in enumerate(rows):
        values = list(row["latency"].values())
        axes.plot(values, [place] * len(values), color=colour(row["label"]), linewidth=1.5)
        for mark, name, value in zip(MARKS, ("half", "99 of 100", "999 of 1000"), values, strict=False):
            axes.plot(
                value,
                place,
                mark,
                color=colour(row["label"]),
                markersize=9,
                markeredgecolor="black",
                label=name if place == 0 else None,
            )
    axes.set_yticks(range(len(rows)), [row["label"] for row in rows])
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xlabel("microseconds, and less is better")
    axes.set_title("Round trips of 32 B that take less than", fontsize=16, loc="left")
    axes.legend(loc="upper center", bbox_to_anchor=(0.4, -0.1), ncol=3, frameon=False)
    save(path, figure, "Latency of round trips of 32 B")


def lines(results: dict[str, Any], path: Path) -> None:
    """How the rate grows with requests in flight, and with clients."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(12, 5))
    windows = [
        (row["label"], row["rate"])
        for row in rows_of(results, "echo of 32 B")
        if row["label"].startswith("lesson 06") and row["label"].endswith("in flight")
    ]
    numbers = [int(label.split(", ")[1].split()[0]) for label, _ in windows]
    left.plot(numbers, [rate[1] for _, rate in windows], "o-", color=OURS, linewidth=2)
    for number, (_, rate) in zip(numbers, windows, strict=True):
        left.annotate(
            f"{rate[1]:,.0f}", (number, rate[1]), textcoords="offset points", xytext=(-12, 9), ha="center", fontsize=12
        )
    left.set(xscale="log", yscale="log", xlabel="requests in flight", ylabel="requests of 32 B a second")
    left.set_xticks(numbers, [str(number) for number in numbers])
    left.margins(0.12, 0.2)
    left.set_title("Lesson 06, one client", fontsize=16, loc="left")
    counts = [int(each["title"].split()[0]) for each in results["works"] if each["title"].endswith("clients, 32 B")]
    series: dict[str, list[tuple[int, float]]] = {}
    for count in counts:
        for row in rows_of(results, f"{count} clients, 32 B"):
            series.setdefault(row["label"], []).append((count, row["rate"][1]))
    for mark, colour_, (label, points) in zip(
        MARKS, ("#000000", OURS, "#56B4E9", OTHERS, "#D55E00"), series.items(), strict=False
    ):
        right.plot(*zip(*points, strict=True), f"{mark}-", color=colour_, linewidth=2, markersize=8, label=label)
    right.set(
        xscale="log", yscale="log", xlabel="clients of one server, one request each", ylabel="requests of 32 B a second"
    )
    right.set_xticks(counts, [str(count) for count in counts])
    right.legend(fontsize=12, loc="upper center", bbox_to_anchor=(0.5, -0.17), ncol=2, frameon=False)
    right.set_title("Many clients", fontsize=16, loc="left")
    figure.tight_layout()
    save(path, figure, "Requests a second, by requests in flight and by clients")


def price(results: dict[str, Any], path: Path) -> None:
    """Processor time of the client for one message, where the server takes its time."""
    rows = [
        (row["label"], [row["client_cpu"]] * 3)
        for row in rows_of(results, "a server that takes 10 ms")
        if row["client_cpu"]
    ]
    bars(
        path,
        "The price of waiting: a server that takes 10 ms",
        "microseconds of processor time of the client for each request",
        rows,
    )


def main(kept: Path, folder: Path) -> None:
    results = json.loads(kept.read_text(encoding="utf-8"))
    for title, name in (("32 B", "32"), ("230,400 B", "230400")):
        echoes(results, title, folder / f"performance_echo_{name}.svg")
    latency(results, folder / "performance_latency.svg")
    lines(results, folder / "performance_rate.svg")
    price(results, folder / "performance_price.svg")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
