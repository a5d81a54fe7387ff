"""The lab's results as tables: on the screen, and in the guide, where `python3 -m lab.report` rewrites them."""

from __future__ import annotations

import json
from typing import Any

from kitlib.docs import guide
from kitlib.lessons import ROOT

FRAMES, STEPS = "main thread, each frame", "steps of CartPole"
RUNTIMES = {"dotnet": ".NET", "mono": "Mono"}
HEAD = (
    *("", "a second", "least", "to TCP", "most", "p50 us", "p99 us", "p99.9 us"),
    *("client us", "server us", "client sleeps", "server sleeps"),
)


def rows_of(results: dict[str, Any], title: str) -> list[dict[str, Any]]:
    """The row of each contender in one kind of work."""
    return next(work["rows"] for work in results["works"] if work["title"] == title)


def lines(results: dict[str, Any]) -> str:
    """As JSON with a line for each row, so that a new run reads as a difference."""
    works = []
    for work in results["works"]:
        rows = ",\n   ".join(map(json.dumps, work["rows"]))
        works.append(f'{{"title": {json.dumps(work["title"])}, "rows": [\n   {rows}]}}')
    others = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in results.items() if key != "works"]
    return "{" + ",\n ".join([*others, '"works": [\n  ' + ",\n  ".join(works) + "]"]) + "}\n"


def text(results: dict[str, Any]) -> str:
    """Everything, for a terminal."""
    lines = [f"{name}: {value}" for name, value in results["machine"].items()]
    for title in [*(work["title"] for work in results["works"]), FRAMES]:
        lines += ["", f"{title}:", *table(results, title)]
    lines += ["", *(f"skipped {what}: {why}" for what, why in results["skipped"].items())]
    lines += [f"NOISY, do not trust the numbers: {why}" for why in results["noise"]]
    return "\n".join([*lines, f"took {results['seconds']} s"])


def table(results: dict[str, Any], title: str, columns: list[str] | None = None) -> list[str]:
    """The table of one kind of work, or of FRAMES; `columns` are those of HEAD to show, or all."""
    if title == FRAMES:
        keys = ("mean", "half", "of_100_99", "longest")
        rows = [
            (row["label"], *(f"{row[key]:.4f}" for key in keys), f"{row['bytes']:.0f}") for row in results["frames"]
        ]
        return aligned([("", "mean ms", "half below", "99 of 100 below", "longest", "bytes"), *rows])
    rows = without_empty([HEAD, *map(cells, rows_of(results, title))])
    kept = [i for i, name in enumerate(rows[0]) if not columns or i == 0 or name in columns]
    return aligned([tuple(row[i] for i in kept) for row in rows])


def cells(row: dict[str, Any]) -> tuple[str, ...]:
    """One row of a table."""
    ratios = [f"{value:.2f}" for value in row["ratio"]] if row["ratio"] else [""] * 3
    waits = [f"{value:.0f}" for value in row["latency"].values()] if row["latency"] else [""] * 3
    spent = [row[what] for what in ("client_cpu", "server_cpu", "client_sleeps", "server_sleeps")]
    used = ["?" if each is None else f"{each:.1f}" for each in spent]
    return (row["label"], f"{row['rate'][1]:,.0f}", *ratios, *waits, *used)


def without_empty(rows: list[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """The columns in which some row has something."""
    kept = [i for i in range(len(rows[0])) if i == 0 or any(row[i] for row in rows[1:])]
    return [tuple(row[i] for i in kept) for row in rows]


def aligned(rows: list[tuple[str, ...]]) -> list[str]:
    """Columns: the first to the left, numbers to the right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        "  ".join(
            [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        )
        for row in rows
    ]


def in_a_page(source: str) -> str:
    """The table of a block `<!-- bench: title -->`, or `title | column, column` for these columns alone."""
    title, _, columns = source.partition(" | ")
    results = json.loads((ROOT / "lab" / "performance.json").read_text(encoding="utf-8"))
    if title == "machine":
        return "".join(f"{name}: {value}\n" for name, value in results["machine"].items())
    lines = table(results, title, columns.split(", ") if columns else None)
    return "".join(f"{line.rstrip()}\n" for line in lines)


if __name__ == "__main__":
    for page in guide.pages():
        guide.rewrite(page, {"bench": lambda block: in_a_page(block.source)})
