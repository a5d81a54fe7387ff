"""Lesson 08's server with a driver that does not look, for the performance lab: the lesson's own share is left."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

LESSON = Path(__file__).resolve().parents[2] / "python" / "08_see_and_steer"


def idle(picture: Any, speed: float) -> tuple[float, float, float]:
    return 0.0, 1.0, 0.0


if __name__ == "__main__":
    sys.path.insert(0, str(LESSON))
    server = importlib.import_module("server")
    server.drive = idle  # type: ignore[attr-defined]
    sys.argv[1:] = ["--endpoint", "tcp://127.0.0.1:0"]
    server.run(server.main)
