"""The lab's results as tables: on the screen, and in the guide."""

from __future__ import annotations

from typing import Any

RUNTIMES = {"dotnet": ".NET", "offline": ".NET, offline engine", "mono": "Mono"}


def text(results: dict[str, Any]) -> str:
    """Everything, for a terminal."""
    lines = [f"{name}: {value}" for name, value in results["machine"].items()]
    for work in results["works"]:
        rows = [(
            "", "a second", "least", "ratio to TCP", "most", "p50 us", "p99 us", "p99.9 us", "client us", "server us", "client sleeps", "server sleeps"
        ), *map(cells, work["rows"])]  # fmt: skip
        lines += ["", f"{work['title']}:", *aligned(rows)]
    lines += ["", "milliseconds to the first reply:"]
    lines += aligned([
        ("", "least", "middle", "most"),
        *((row["label"], *(f"{value:.1f}" for value in row["milliseconds"])) for row in results["first"]),
    ])  # fmt: skip
    lines += ["", "main thread, each frame:"]
    lines += aligned([
        ("", "mean ms", "half below", "99 of 100 below", "longest", "bytes"),
        *((
            row["label"], f"{row['mean']:.4f}", f"{row['half']:.4f}", f"{row['of_100_99']:.4f}", f"{row['longest']:.4f}", f"{row['bytes']:.0f}"
        ) for row in results["frames"]),
    ])  # fmt: skip
    lines += [""] + [f"skipped {what}: {why}" for what, why in results["skipped"].items()]
    lines += [f"NOISY, do not trust the numbers: {why}" for why in results["noise"]]
    return "\n".join([*lines, f"took {results['seconds']} s"])


def cells(row: dict[str, Any]) -> tuple[str, ...]:
    """One row of a table."""
    ratios = [f"{value:.2f}" for value in row["ratio"]] if row["ratio"] else [""] * 3
    waits = [f"{value:.0f}" for value in row["latency"].values()] if row["latency"] else [""] * 3
    spent = [row[what] for what in ("client_cpu", "server_cpu", "client_sleeps", "server_sleeps")]
    return (
        row["label"],
        f"{row['rate'][1]:,.0f}",
        *ratios,
        *waits,
        *("?" if each is None else f"{each:.1f}" for each in spent),
    )


def aligned(rows: list[tuple[str, ...]]) -> list[str]:
    """Columns: the first to the left, numbers to the right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        "  ".join(cell.rjust(width) if i else cell.ljust(width) for i, (cell, width) in enumerate(zip(row, widths, strict=True)))
        for row in rows
    ]  # fmt: skip
