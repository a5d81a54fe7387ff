"""The performance lab: a quick run measures what it says, and a contender that cheats or lacks something is named."""

import json
import re
import socket
import threading

import pytest

from kitlib.lessons import KitError
from kitlib.setup import dotnet
from lab import contest, report
from lab import programs as lab
from lab.contest import TCP, Contender, Lab
from tests.conftest import PYTHON
from tests.programs import ROOT, Mark, finds_processes

RESULTS = json.loads((ROOT / "lab" / "performance.json").read_text(encoding="utf-8"))
# It measures: not beside Play and Stop.
pytestmark = [pytest.mark.timeout(1200), pytest.mark.xdist_group("times")]


def labels(results, title):
    return [row["label"] for row in report.rows_of(results, title)]


@pytest.fixture
def place(netmq):
    """A lab of one short round."""
    place = Lab(PYTHON, {"dotnet": netmq}, rounds=1, moment=0.02)
    yield place
    place.end()


@pytest.mark.long
@finds_processes
def test_a_quick_run_measures_everything_that_can_run_here(netmq, start):
    mark = Mark()
    program = start(PYTHON, ROOT / "kit.py", "bench", "--quick", **mark.environment)
    assert program.wait(1100) == 0, program.output
    results = json.loads((ROOT / ".build" / "bench" / "performance.json").read_text(encoding="utf-8"))
    for work in RESULTS["works"]:
        skipped = [row["label"] for row in work["rows"] if row["label"] in results["skipped"]]
        assert labels(results, work["title"]) == [
            each for each in labels(RESULTS, work["title"]) if each not in skipped
        ]
    assert not [what for what in results["skipped"] if "(" in what], "something failed on the way"
    assert all(row["bytes"] == 0 for row in results["frames"])
    for row in report.rows_of(results, "echo of 230,400 B"):
        # A mean is at least half of the median, whatever else happened. On a busy machine some have too few for one.
        assert not row["latency"] or 1e6 / row["rate"][2] > row["latency"]["p50"] / 2, row
    assert mark.processes() == {}


def test_a_server_that_sends_something_else_back_is_found_out(netmq):
    """Otherwise a server that answers rubbish would win."""
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def lie():
            connection, _ = listener.accept()
            while data := connection.recv(65536):
                connection.sendall(bytes(len(data)))

        threading.Thread(target=lie, daemon=True).start()
        program = lab.Client(["dotnet", str(dotnet.build(netmq, ROOT / "lab" / "csharp"))], set())
        try:
            with pytest.raises(KitError, match="the answer is not the one that was expected"):
                program.ask(f"echo tcp tcp://127.0.0.1:{listener.getsockname()[1]} 32 0.1")
        finally:
            program.end()


def test_a_contender_that_fails_is_named_and_the_others_go_on(place, monkeypatch, tmp_path):
    """One that there is not, one whose server cannot start, and a client program that ends, which is started again."""
    for path in contest.LAB.glob("*.py"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / "json_server.py").write_text("import nothing_of_this_name\n", encoding="utf-8")
    monkeypatch.setattr(contest, "LAB", tmp_path)
    broken = Contender("broken", "dotnet", "nonsense", "tcp")
    work = place.work("test", [TCP, broken, contest.JSON], "echo {name} {endpoint} 32 0.02")
    assert [row["label"] for row in work["rows"]] == ["raw TCP"]
    assert "no contender nonsense" in place.skipped["broken (test)"]
    why = "json_server.py ended; its last line: ModuleNotFoundError: No module named 'nothing_of_this_name'"
    assert place.skipped[f"{contest.JSON.label} (test)"].endswith(why)
    place.program("dotnet").process.kill()
    place.program("dotnet").process.wait()
    lost, found = (place.work(title, [TCP], "echo {name} {endpoint} 32 0.02") for title in ("first", "second"))
    assert lost["rows"] == []
    assert "ended" in place.skipped["raw TCP (first)"]
    assert [row["label"] for row in found["rows"]] == ["raw TCP"]


def test_the_kept_run_is_whole_and_the_plots_show_it():
    """The guide's numbers are a full run's, in which nothing failed, whichever release of matplotlib drew them."""
    assert RESULTS["skipped"] == {}
    assert json.loads(report.lines(RESULTS)) == RESULTS
    for name, title in ("echo_32", "echo of 32 B"), ("echo_230400", "echo of 230,400 B"):
        svg = (ROOT / "img" / f"performance_{name}.svg").read_text(encoding="utf-8")
        shown = re.findall(r">([^<>\n]+)</text>", svg)
        for row in report.rows_of(RESULTS, title):
            assert " in flight" in row["label"] or {row["label"], f"{row['ratio'][1]:.3g}"} <= {*shown}, row
