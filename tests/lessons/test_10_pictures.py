"""Lesson 10, sixteen cameras: the page's robots look for a ball, and a rule drives them by their pictures alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from kitlib.docs import guide
from kitlib.setup import dotnet
from tests.conftest import PYTHON
from tests.programs import ROOT, Program, elsewhere

for module in ("gymnasium", "numpy", "PIL"):
    pytest.importorskip(module, reason=f"it needs {module}: kit.py run 10 and kit.py run 12 install it")

PAGE = list(guide.blocks(ROOT / "docs" / "guide" / "10_many_agents.md"))


def of_the_page(name: str) -> str:
    (body,) = [block.body for block in PAGE if f"class {name} " in block.body]
    return body


def test_robots_find_what_they_see(start: Callable[..., Program], netmq: dotnet.NetMQ, tmp_path: Path) -> None:
    for name in ("Seeker", "SeekerAreas"):
        (tmp_path / f"{name}.cs").write_text(of_the_page(name), encoding="utf-8")
    script = Path(__file__).with_name("seek.py").read_text(encoding="utf-8")
    (tmp_path / "seek.py").write_text(elsewhere(script), encoding="utf-8")
    seek = start(PYTHON, "seek.py", folder=tmp_path)
    assert seek.wait(200) == 0, seek.output
    assert "50 balls were found" in seek.lines
    assert (tmp_path / "sixteen.gif").read_bytes()[:6] == b"GIF89a"
