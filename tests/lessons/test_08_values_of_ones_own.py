"""Lesson 08's page says in which lines a value of one's own goes with a picture, and comes with an action."""

from __future__ import annotations

import csv
import shutil

import pytest

from tests.conftest import PYTHON
from tests.programs import ROOT, two_ports

pytest.importorskip("PIL.Image", reason="recording needs Pillow: pip install pillow")

SCRIPTS = ROOT / "unity/Assets/NetMQExample/08_see_and_steer"
MINE = """using NetMQExample;
using UnityEngine;

public sealed class MyCar : DrivenBehaviour
{
    public override double Battery => 1.5;
    public override double Speed => 0;
    public override void Step(double throttle, double brake, double steer) { }
}
"""
# What the page's table says, in what is copied.
CHANGES = {
    "08_see_and_steer/server.py": [
        ('"steer": float(steer)}', '"steer": float(steer), "zoom": 2 * frame.values["battery"]}')
    ],
    "netmq_example/camera/pictures.py": [('NUMBERS = ("sim_time",', 'NUMBERS = ("battery", "sim_time",')],
    "netmq_example/camera/recording.py": [('ANSWERED = ("throttle",', 'ANSWERED = ("zoom", "throttle",')],
    "Shot.cs": [
        ("public double Speed { get", "public double Battery { get; set; } public double Speed { get"),
        ("var values = message.Values;", 'var values = message.Values; values["battery"] = Battery;'),
    ],
    "Drive.cs": [("shot.WallTime =", "shot.Battery = ((DrivenBehaviour)car).Battery; shot.WallTime =")],
    "DriverClient.cs": [
        ("public long Frame { get; }", "public long Frame { get; } public double Zoom { get; }"),
        ("double milliseconds = 0)", "double milliseconds = 0, double zoom = 0)"),
        ("Frame = frame;", "Frame = frame; Zoom = zoom;"),
        ("clock.Elapsed.TotalMilliseconds);", 'clock.Elapsed.TotalMilliseconds, Take(reply, "zoom"));'),
    ],
    "DrivenBehaviour.cs": [
        ("public abstract double Speed", "public virtual double Battery => 0; public abstract double Speed"),
        ("Drive.Apply(action);", 'Drive.Apply(action); Debug.Log($"zoom {action?.Zoom}");'),
    ],
    # Unchanged, and made anew with those that are.
    "ShotTaker.cs": [],
    "CameraSender.cs": [],
    "RoadScene.cs": [],
}


def test_a_number_more_each_way_is_played_and_recorded(tmp_path, start, console, netmq):
    for folder in ("netmq_example", "08_see_and_steer"):
        shutil.copytree(ROOT / "python" / folder, tmp_path / folder)
    mine = tmp_path / "08_see_and_steer"
    scripts = [name for name in CHANGES if name.endswith(".cs")]
    for name in scripts:
        shutil.copy(SCRIPTS / name, mine)
    for name, changes in CHANGES.items():
        path = (mine if name in scripts else tmp_path) / name
        text = path.read_text(encoding="utf-8")
        for old, new in changes:
            assert text.count(old) == 1, (name, old)
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")
    (mine / "MyCar.cs").write_text(MINE, encoding="utf-8")
    server = start(PYTHON, mine / "server.py", "--endpoint", two_ports(), "--record", tmp_path / "runs")
    endpoint = server.wait_for(r"^listening on (\S+)")[1]

    def play(*names):
        files = [mine / name for name in ("MyCar.cs", *names)]
        options = ["--endpoint", endpoint, "--count", "3"]
        program = start(PYTHON, ROOT / "kit.py", "play", *files, *options)
        return program.wait(300), program.lines

    code, lines = play(*scripts)
    assert code == 0 and lines.count("zoom 3") == 3, lines
    with (tmp_path / "runs/run_0001/metadata.csv").open() as table:
        rows = list(csv.DictReader(table))
    assert {(row["battery"], row["answered_zoom"]) for row in rows} == {("1.5", "3.0")}
    replay = start(PYTHON, mine / "replay.py", tmp_path / "runs/run_0001", "--endpoint", endpoint)
    assert replay.wait() == 0, replay.output
    # One that needs a changed one, and is the kit's.
    code, lines = play(*(name for name in scripts if name != "ShotTaker.cs"))
    assert code == 1 and any("the player uses your copy of a kit's file only if" in line for line in lines), lines
