"""Lesson 17's curves: a quick run works, and the picture and the page have the numbers that are kept."""

from __future__ import annotations

import json
import os
import re
import subprocess

import pytest

from tests.conftest import PYTHON
from tests.programs import ROOT

# What the lab needs.
pytest.importorskip("numpy", reason="needs numpy: pip install numpy")
from lab import scaling


def kept():
    return json.loads(scaling.KEPT.read_text(encoding="utf-8"))


def test_the_picture_shows_the_kept_run():
    shown = re.findall(r">([^<>\n]+)</text>", scaling.PICTURE.read_text(encoding="utf-8"))
    curves = kept()["curves"]
    for name in ("wait", "compute"):
        assert [int(count) for count in curves[name]] == list(scaling.COUNTS)
        assert f"{curves[name]['64']:,.0f}" in shown
    assert any(kept()["machine"]["date"] in text and kept()["machine"]["others"] in text for text in shown)


def test_the_pages_table_follows_from_the_kept_run():
    assert scaling.paper(kept()) in scaling.PAGE.read_text(encoding="utf-8"), (
        "python3 -m lab.scaling --draw rewrites it"
    )


def test_the_size_of_a_step_is_that_of_its_messages():
    """Not what is on the wire in all: ZeroMQ adds two bytes to each frame, and TCP its own."""
    assert sum(len(frame) for frame in scaling.state(1000)) == kept()["hub"]["state"]


@pytest.mark.long
def test_a_quick_run_measures_what_it_says():
    pytest.importorskip("matplotlib", reason="the plots need matplotlib")
    pytest.importorskip("gymnasium", reason="lesson 17 needs gymnasium: pip install gymnasium")
    done = subprocess.run(
        [PYTHON, "-m", "lab.scaling", "--quick"], cwd=ROOT, capture_output=True, text=True, timeout=250
    )
    assert done.returncode == 0, done.stderr
    found = json.loads((scaling.ASIDE / "scaling.json").read_text(encoding="utf-8"))["curves"]
    # A step that waits 10 ms is never faster than that, whatever else the machine does.
    for count, rate in found["wait"].items():
        assert 0 < rate <= 100 * int(count)
    for rate in found["compute"].values():
        assert 0 < rate <= 100 * (os.cpu_count() or 1)
    assert "</svg>" in (scaling.ASIDE / "17_scaling.svg").read_text(encoding="utf-8")
