"""The performance lab: a quick run works, measures what it says, and a contender that cheats or lacks is found out."""

from __future__ import annotations

import json
import math
import os
import re
import socket
import threading

import pytest

from kitlib.lessons import KitError
from kitlib.setup import dotnet, python_setup
from lab import bench, contest, machine, report
from lab import programs as lab
from lab.contest import TCP, Contender, Lab, Row
from tests.conftest import PYTHON
from tests.programs import ROOT, Mark, Program, finds_processes

KEPT = ROOT / "lab" / "performance.json"


@pytest.fixture(scope="module")
def quick(netmq):
    """One quick run for all tests of this file: what it printed, and the results."""
    mark = Mark()
    command = [
        PYTHON,
        ROOT / "kit.py",
        "bench",
        "--quick",
    ]
    program = Program(command, **mark.environment)
    try:
        assert program.wait(1100) == 0, program.output
    finally:
        program.kill()
    results = json.loads((ROOT / ".build" / "bench" / "performance.json").read_text(encoding="utf-8"))
    return program.output, results, mark.processes()


# It measures: not beside Play and Stop.
pytestmark = [pytest.mark.timeout(1200), pytest.mark.xdist_group("times")]


def labels(results, title):
    return [row["label"] for row in report.rows_of(results, title)]


@pytest.mark.long
def test_a_quick_run_measures_everything_that_can_run_here(quick):
    output, results, _ = quick
    skipped = " ".join(results["skipped"])
    kit = ("lesson 01", "lesson 05, pooled", "lesson 06, 256 in flight", contest.FAST.label)
    for label in ("raw TCP", "busy-wait client", *kit):
        assert label in labels(results, "echo of 32 B"), output
    for contender in (contest.HTTP, contest.WEBSOCKET, contest.GRPC):
        assert (contender.label in labels(results, "echo of 230,400 B")) != (contender.label in skipped), output
    for title in (
        "echo of 2 MB",
        "one way, frames of 230,400 B",
        "a picture of 230,400 B, an action back",
        report.TAP,
        "publish 32 B to 100",
        "100 clients, 32 B",
        "a server that takes 10 ms",
    ):
        assert labels(results, title), output
    for contender in (contest.BY_WEBSOCKET, contest.BY_SOCKETIO):
        assert (contender.label in labels(results, report.GATEWAY)) != (contender.label in skipped), output
    for contender in contest.STEPS:
        assert (contender.label in labels(results, "steps of CartPole")) != (contender.label in skipped), output
    assert {row["label"] for row in results["first"]} >= {"program: C# client", "connection: lesson 01"}
    assert results["frames"][0]["label"] == ".NET"
    assert not [what for what in results["skipped"] if "(" in what], "something failed on the way"
    assert re.search(r"^took \d+ s$", output, re.MULTILINE)


@finds_processes
def test_what_measures_is_in_one_group(request):
    """Beside each other they would measure each other."""
    side_by_side = getattr(request.config.option, "loadgroup", False)
    assert request.node.nodeid.endswith("@times") == side_by_side


@pytest.mark.long
def test_nothing_of_a_run_is_left(quick):
    assert quick[2] == {}


@pytest.mark.long
def test_a_request_one_at_a_time_is_the_sum_of_its_waits(quick):
    """Messages a second, and the waits, are measured apart; they must agree."""
    _, results, _ = quick
    for row in report.rows_of(results, "echo of 230,400 B"):
        if row["latency"]:
            # A mean is at least half of the median, whatever else happened.
            assert 1e6 / row["rate"][2] > row["latency"]["p50"] / 2, row


def test_the_busy_wait_shows_its_price(netmq, monkeypatch):
    # Else .NET compiles once more what is often called; on a machine that is busy itself, that is most of what a few
    # slow requests take.
    monkeypatch.setenv("DOTNET_TieredCompilation", "0")
    place = Lab(PYTHON, {"dotnet": netmq}, rounds=2, moment=0.5, free=True)
    try:
        echo = "echo {name} {endpoint} 32 1"
        work = place.work("a server that takes 10 ms", [contest.HELLO, contest.BUSY], echo, "--delay", "0.01")
    finally:
        place.end()
    hello, busy = (row["client_cpu"] for row in work["rows"])
    if hello is None:
        pytest.skip("this system does not say how much processor time a thread has used")
    # On a machine that is busy itself, it gets no more of the processor than is left.
    assert busy > 2 * hello


@pytest.mark.long
def test_the_main_thread_allocates_nothing(quick):
    _, results, _ = quick
    assert all(row["bytes"] == 0 for row in results["frames"])


def client(netmq):
    return lab.Client(["dotnet", str(dotnet.build(netmq, ROOT / "lab" / "csharp"))], set())


def test_a_server_that_sends_something_else_back_is_found_out(netmq):
    """Otherwise a server that answers rubbish would win."""
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def lie():
            connection, _ = listener.accept()
            while data := connection.recv(65536):
                connection.sendall(bytes(len(data)))

        threading.Thread(target=lie, daemon=True).start()
        program = client(netmq)
        try:
            with pytest.raises(KitError, match="the answer is not the one that was expected"):
                program.ask(f"echo tcp tcp://127.0.0.1:{listener.getsockname()[1]} 32 0.1")
        finally:
            program.end()


def test_a_contender_that_fails_is_named_and_the_others_go_on(netmq):
    broken = Contender("broken", "dotnet", "nonsense", "tcp")
    place = Lab(PYTHON, {"dotnet": netmq}, rounds=1, moment=0.02, free=True)
    try:
        result = place.work("test", [TCP, broken], "echo {name} {endpoint} 32 0.02")
    finally:
        place.end()
    assert [row["label"] for row in result["rows"]] == ["raw TCP"]
    assert "no contender nonsense" in place.skipped["broken (test)"]


def test_a_missing_package_is_a_reason_to_skip(netmq):
    place = Lab(PYTHON, {"dotnet": netmq}, rounds=1, moment=0.02, free=True)
    needy = Contender("needy", "dotnet", "tcp", "tcp", package="no-such-package")
    assert place.here(TCP, needy, *contest.elsewhere("mono", "on Mono")) == [TCP]
    assert place.skipped["needy"] == 'it needs a package: pip install "no-such-package"'
    assert "lesson 01, on Mono" in place.skipped


def test_a_package_that_is_too_old_is_a_reason_to_skip(netmq, monkeypatch, tmp_path):
    """As Debian 12's websockets 10, which has no asyncio server."""
    (tmp_path / "websockets-10.4.dist-info").mkdir()
    (tmp_path / "websockets-10.4.dist-info" / "METADATA").write_text("Name: websockets\nVersion: 10.4\n")
    (tmp_path / "websockets.py").touch()
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    place = Lab(PYTHON, {"dotnet": netmq}, rounds=1, moment=0.02, free=True)
    assert place.here(TCP, contest.WEBSOCKET) == [TCP]
    assert re.fullmatch(r'it needs a package: pip install "websockets>=\d+"', place.skipped["WebSocket, websockets"])


def test_a_server_that_cannot_start_costs_no_run(netmq, monkeypatch, tmp_path):
    """In each of the works, with the last line of what it said to stderr."""
    for path in contest.LAB.glob("*.py"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / "json_server.py").write_text("import nothing_of_this_name\n", encoding="utf-8")
    monkeypatch.setattr(contest, "LAB", tmp_path)
    monkeypatch.setattr(python_setup, "has", lambda *_: False)
    place = Lab(PYTHON, {"dotnet": netmq}, rounds=1, moment=0.02, free=True)
    try:
        work = place.work("test", [TCP, contest.JSON], "echo {name} {endpoint} 32 0.02")
        first = bench.starts(place, quick=True)
    finally:
        place.end()
    assert [row["label"] for row in work["rows"]] == ["raw TCP"]
    assert "connection: raw TCP" in [row["label"] for row in first]
    why = "json_server.py ended: ModuleNotFoundError: No module named 'nothing_of_this_name'"
    for title in ("test", report.FIRST):
        assert place.skipped[f"{contest.JSON.label} ({title})"].endswith(why)


def test_a_client_program_that_ends_is_started_again(netmq):
    place = Lab(PYTHON, {"dotnet": netmq}, rounds=1, moment=0.02, free=True)
    try:
        place.program("dotnet").process.kill()
        place.program("dotnet").process.wait()
        lost = place.work("first", [TCP], "echo {name} {endpoint} 32 0.02")
        found = place.work("second", [TCP], "echo {name} {endpoint} 32 0.02")
    finally:
        place.end()
    assert lost["rows"] == []
    assert "ended" in place.skipped["raw TCP (first)"]
    assert [row["label"] for row in found["rows"]] == ["raw TCP"]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such limit")
def test_a_system_that_knows_no_limit_of_files_is_asked_for_a_number(monkeypatch):
    """MacOS says that there is no limit, and refuses to be asked for none."""
    import resource

    asked = []
    monkeypatch.setattr(resource, "getrlimit", lambda _: (256, resource.RLIM_INFINITY))
    monkeypatch.setattr(resource, "setrlimit", lambda _, limits: asked.append(limits))
    lab.many_files()
    assert asked == [(10_240, resource.RLIM_INFINITY)]


def test_a_ratio_is_taken_within_a_round():
    limit, row = Row("raw TCP"), Row("other")
    # The machine is half as fast in the second round, and so are both.
    for speed in (1.0, 0.5):
        for each, rate in ((limit, 1000), (row, 800)):
            each.add({"messages": int(rate * speed), "seconds": 1.0, "waits": []}, [1.0, 1.0, 1.0, math.nan])
            each.compare(limit)
    assert row.result()["ratio"] == [0.8, 0.8, 0.8]
    assert row.result()["client_cpu"] == pytest.approx(2 / 1200, rel=1e-3)
    assert row.result()["server_sleeps"] is None


def test_a_noisy_run_says_so():
    def work(rate):
        return {"title": "echo", "rows": [{"label": "raw TCP", "rate": rate}]}

    assert machine.noise(0.02, [work([900.0, 1000.0, 1100.0])]) == []
    assert "raw TCP made 300 to 1000 a second" in machine.noise(0.02, [work([300.0, 900.0, 1000.0])])[0]
    assert "50%" in machine.noise(0.5, [])[0]


@pytest.mark.skipif(not KEPT.exists(), reason="no full run is kept")
def test_the_kept_run_is_whole():
    """The guide's numbers are a full run's, in which nothing failed."""
    results = json.loads(KEPT.read_text(encoding="utf-8"))
    assert [work["title"] for work in results["works"]][:5] == [f"echo of {size}" for size in bench.SIZES]
    assert labels(results, "1000 clients, 32 B")
    assert results["skipped"] == {}
    assert results["seconds"] < 600


@pytest.mark.skipif(not KEPT.exists(), reason="no full run is kept")
def test_the_goals_of_lesson_16_follow_from_its_rows():
    kept = json.loads(KEPT.read_text(encoding="utf-8"))

    def goals(*more):
        others = [work for work in kept["works"] if work["title"] not in (report.GATEWAY, report.TAP)]
        shown = report.goals({**kept, "works": [*others, *more]})
        return [re.split("  +", line.strip())[::2] for line in shown if line.startswith("lesson 01 by ")]

    row = {"rate": [1.0, 400.0, 9.0], "latency": {"p50": 900.0}}
    direct = {"label": "lesson 01", "rate": [1.0, 1000.0, 9.0], "latency": {"p50": 400.0}}
    works = [{"title": title, "rows": [direct, {**row, "label": "by X"}]} for title in (report.GATEWAY, report.TAP)]
    ratio, added = ["lesson 01 by X, to lesson 01", "0.40"], ["lesson 01 by X: ms added, half below", "0.50"]
    assert goals(*works) == [ratio, added, ratio]


@pytest.mark.skipif(not KEPT.exists(), reason="no full run is kept")
@pytest.mark.parametrize("name", ["echo_32", "echo_230400", "latency", "rate", "price"])
def test_a_plot_shows_the_kept_run(name):
    """Which release of matplotlib drew it does not matter; its names and numbers do."""
    results = json.loads(KEPT.read_text(encoding="utf-8"))
    drawn = (ROOT / "img" / f"performance_{name}.svg").read_text(encoding="utf-8")
    shown = re.findall(r">([^<>\n]+)</text>", drawn)
    titles = {"echo_32": "echo of 32 B", "echo_230400": "echo of 230,400 B", "price": "a server that takes 10 ms"}
    if name in titles:
        for row in report.rows_of(results, titles[name]):
            if name != "price" and " in flight" not in row["label"]:
                assert row["label"] in shown
                assert f"{row['ratio'][1]:.3g}" in shown
            elif name == "price":
                assert f"{row['client_cpu']:,.0f}" in shown
    else:
        expected = {"latency": ["lesson 01", "999 of 1000"], "rate": ["Many clients", "requests in flight"]}
        assert set(expected[name]) <= set(shown)
    assert report.text(results)
