"""Lesson 08, what was recorded: reads a folder of recording.py back. What cannot be read is said, and left out.
"""

import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pictures import decode

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import MessageError

NUMBERS = ("sim_time", "wall_time", "throttle", "brake", "steer", "speed")
ANSWERED = ("answered_throttle", "answered_brake", "answered_steer")


def recorded(folder: Path) -> Iterator[tuple[int, dict[str, Any], dict[str, bytes], dict[str, Any]]]:
    """Each line's number, its values, and each camera's JPEG file and its pixels; OSError if there is none."""
    found = False
    # A byte that is no text makes one cell bad, and not the whole file.
    with (folder / "metadata.csv").open(encoding="utf-8-sig", errors="replace") as table:
        columns = table.readline().rstrip("\n").split(",")
        for number, line in enumerate(table, 2):
            try:
                cells = dict(zip(columns, line.rstrip("\n").split(","), strict=True))
                kept = files(folder, cells)
                # One that was cut off is found here.
                yield number, values(cells), kept, {name: decode(file) for name, file in kept.items()}
                found = True
            except (OSError, ValueError, KeyError, MessageError) as error:
                print(f"trouble: line {number} of metadata.csv is left out: {error!s:.100}", flush=True)
    if not found:
        raise FileNotFoundError(2, "no picture in it can be read")


def values(cells: dict[str, str]) -> dict[str, Any]:
    numbers = {name: float(cells[name]) for name in (*NUMBERS, *ANSWERED)}
    if not all(map(math.isfinite, numbers.values())):
        raise ValueError("a number in it is not finite")
    return {"frame": int(cells["frame"]), "manual": cells["manual"] == "True", **numbers}


def files(folder: Path, cells: dict[str, str]) -> dict[str, bytes]:
    """By the cameras' names, in their order."""
    found = {}
    for column, name in cells.items():
        if column.endswith("file_name"):
            path = folder / name
            if not path.is_file():
                raise FileNotFoundError(f"there is no picture {name}")
            found[column.removesuffix("file_name").rstrip("_") or "center"] = path.read_bytes()
    return found
