"""The soak: what it calls growth, and a short run of it all."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from lab.soak import SAMPLES, Soaked
from tests.conftest import PYTHON
from tests.programs import ROOT


@pytest.mark.parametrize(
    ("first", "then", "grows"),
    [(20_000, 20_000, False), (20_000, 23_900, False), (200_000, 210_000, False), (20_000, 25_000, True)],
)
def test_growth_is_a_tenth_and_some_megabytes(first, then, grows):
    each = Soaked("3 client", [str(PYTHON), "-c", ""])
    each.program.end()
    # The first quarter is the start of a program, and counts for nothing.
    each.kilobytes = [1000] * 15 + [first] * 30 + [then] * 15
    assert each.row().endswith("GROWS") == grows


def test_silence_counts_at_the_end_alone():
    each = Soaked("3 client", [str(PYTHON), "-c", ""])
    each.program.end()
    each.printed = [0] * (SAMPLES - 1) + [1]
    assert not each.silent()
    each.printed = [1] * 45 + [0] * 15
    assert each.silent()


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="Linux alone says another program's memory in /proc")
def test_a_short_run_has_a_row_for_each_program():
    # Half a minute is a start: some programs still grow.
    words = [PYTHON, "-m", "lab.soak", "--minutes", "0.5"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=250)
    rows = re.findall(r"^(\d+ \w+) +[\d.]+ MB +[\d.]+ MB +[\d,]+", done.stdout, re.MULTILINE)
    assert len(rows) == 15, done.stdout + done.stderr
    assert "SILENT" not in done.stdout
