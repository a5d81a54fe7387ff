"""Lesson 10, sixteen cameras: the page's robots look for a ball, and a rule drives them by their pictures alone."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from kitlib.docs import guide
from kitlib.setup import dotnet
from tests.conftest import PYTHON
from tests.programs import ROOT, Program, elsewhere

for module in ("gymnasium", "numpy", "PIL"):
    pytest.importorskip(module, reason=f"it needs {module}: kit.py run 10 and kit.py run 12 install it")

GUIDE = ROOT / "docs" / "guide"


def of_the_page(name: str, key: str = "10_many_agents") -> str:
    (body,) = [block.body for block in guide.blocks(GUIDE / f"{key}.md") if f"class {name} " in block.body]
    return body


def areas() -> str:
    """Those of the drones, changed as the page says."""
    (line,) = re.findall("^`(area.*;)`$", (GUIDE / "10_many_agents.md").read_text(encoding="utf-8"), re.MULTILINE)
    code = of_the_page("HoverAreas", "reinforcement_learning").replace("Hover", "Seeker")
    return code.replace("SetParent(transform);", f"SetParent(transform);\n{line}")


def test_robots_find_what_they_see(start: Callable[..., Program], netmq: dotnet.NetMQ, tmp_path: Path) -> None:
    for name, code in {"Seeker": of_the_page("Seeker"), "SeekerAreas": areas()}.items():
        (tmp_path / f"{name}.cs").write_text(code, encoding="utf-8")
    script = Path(__file__).with_name("seek.py").read_text(encoding="utf-8")
    (tmp_path / "seek.py").write_text(elsewhere(script), encoding="utf-8")
    seek = start(PYTHON, "seek.py", folder=tmp_path)
    assert seek.wait(200) == 0, seek.output
    assert "50 balls were found" in seek.lines
    assert (tmp_path / "sixteen.gif").read_bytes()[:6] == b"GIF89a"
