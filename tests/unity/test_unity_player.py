"""The player and its stand-in of UnityEngine: Unity's signatures, Unity's order of events, the command line."""

from __future__ import annotations

import itertools
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from kitlib.setup import dotnet
from tests.programs import ROOT

# A group begins early: alone at the end, its builds would be waited for.
pytestmark = pytest.mark.xdist_group("player")


@pytest.fixture(scope="session")
def harness(netmq: dotnet.NetMQ) -> Path:
    return dotnet.build(netmq, ROOT / "tests" / "unity" / "play")


def test_the_stand_in_has_unitys_signatures(harness: Path, start: Callable[..., Any]) -> None:
    """tests/unity/unity_api.txt says for each member where Unity's published reference declares it."""
    dump = start("dotnet", harness, "api")
    assert dump.wait() == 0, dump.output
    facts = [
        line.rstrip() for line in (ROOT / "tests" / "unity" / "unity_api.txt").read_text(encoding="utf-8").splitlines()
    ]
    facts = [line for line in facts if line and not line.startswith("#")]
    types = [line for line in facts if not line.startswith(" ")]
    assert all(re.fullmatch(r"\w+ [\w.`]+( : \w+)?    \S+\.cs( \S+\.cs)*", line) for line in types)
    known = [line if line.startswith(" ") else line.split("    ")[0] for line in facts]
    assert [line.rstrip() for line in dump.lines] == known


def test_events_come_in_unitys_order(harness: Path, start: Callable[..., Any]) -> None:
    play = start("dotnet", harness, "events")
    assert play.wait() == 0, play.output
    # After a long frame several FixedUpdates come in the next one.
    assert [line for line, _ in itertools.groupby(play.lines)] == [
        "SubsystemRegistration",
        "AfterAssembliesLoaded",
        "BeforeSplashScreen",
        "BeforeSceneLoad",
        "Awake",
        "OnEnable",
        "AfterSceneLoad",
        "Start in frame 1",
        "FixedUpdate",
        "Update",
        "after await, on the main thread: True",
        "LateUpdate",
        "off the main thread: get_time can only be called from the main thread.",
        "destroyed is null: False",
        "Destroy: OnDisable",
        "Destroy: OnDestroy",
        "destroyed is null: True, and its token cancelled: True",
        "OnApplicationQuit",
        "quitting",
        "OnDisable",
        "OnDestroy",
    ]


def test_scripts_may_do_here_what_they_do_in_unity(harness: Path, start: Callable[..., Any]) -> None:
    play = start("dotnet", harness, "habits")
    assert play.wait() == 0, play.output
    happened = [
        "OnValidate",
        "a component's name: renamed",
        "a line",
        "shown: a line",
        f"shown: {'a' * 59}|b|{'c' * 70}|d|{'e' * 60}|f",
        "a cube: (0.00, 1.00, 0.00)",
        *["drawn by: Standard"] * 3,
        "drawn by: Sprites/Default",
        "drawn by: Standard",
        "drawn by: Universal Render Pipeline/Lit",
        "HelloWeb: False",
        "HelloWeb: True",
        "a second one: True",
        'JSON: {"hp":3,"speeds":[1,0.5],"path":[{"x":0,"y":1,"z":0}],"to":{"who":""},"text":"a \\"word\\",\\n",'
        '"kind":1,"marked":true} -4 0.25 (0.00, 1.00, 0.00)  10 5',
        "heard once",
        "JSON of what is in no class: {} {} {}",
        *["no JSON: JSON parse error: Invalid value."] * 3,
        "no JSON: JSON must represent an object type.",
        "Mathf: 3 0.5 2 1 30 2 (0.00, 0.50, 0.00)",
        "turned: (350.00, 200.00, 30.00) (-0.577, -0.577, -0.577) (35.26, 225.00, 0.00)"
        " (270.00, 90.00, 0.00) (0.00, 1.00, 0.00) 5 (9.00, 12.00, 0.00)",
        "OnApplicationFocus True",
        "OnApplicationPause False",
        "Start of what was made in frame 1",
        "LateUpdate of what was made in frame 1",
        "OnGUI",
        "after await",
        "Send came to the main thread: True",
        "deltaTime is capped: True, unscaledDeltaTime: False",
        "in the scene: Connecting",
    ]
    assert [line for line in play.lines if line in happened] == happened
    # HelloWeb and, of the two clients, the first.
    assert play.lines.count("Application.runInBackground is now true") == 2
    assert "Can't add component 'Once' to renamed: it allows no second one" in play.lines
    assert "Habits.Start returns IEnumerator: it is left out, because the player runs no coroutines" in play.lines
    assert "System.InvalidOperationException: in a continuation" in play.lines
    assert not [line for line in play.lines if "wrong deltaTime" in line]
    # A frame of a second is one of a second, though the game's time stands still for most of it.
    (longest,) = [found[1] for line in play.lines if (found := re.match(r"frames: .* took (\d+) ms", line))]
    assert int(longest) >= 1000


def build(netmq: dotnet.NetMQ, project: str, into: Path, *properties: str) -> Path:
    """Build somewhere else than kit.py does; returns the folder."""
    command = ["dotnet", "build", ROOT / project, *netmq.properties, "-v", "quiet", "--nologo"]
    words = [str(word) for word in [*command, f"-p:ArtifactsPath={into}", *properties]]
    environment = {**os.environ, **dotnet.ENVIRONMENT}
    done = subprocess.run(words, capture_output=True, text=True, timeout=500, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return into


MINE = """using UnityEngine;

public class MyOwn : MonoBehaviour
{
    [SerializeField] private int times = 1;
    private int unused = 3;
    public bool Done;

    void Update() { int alsoUnused; for (var i = 0; i < times; i++) Debug.Log("mine"); Application.Quit(); }
}
"""


def test_a_readers_own_script_is_built_and_played(
    netmq: dotnet.NetMQ, tmp_path: Path, start: Callable[..., Any]
) -> None:
    """Without XML documentation, with warnings, in no namespace: as one writes it."""
    scripts = tmp_path / "scripts"
    shutil.copytree(ROOT / "unity" / "Assets" / "NetMQExample", scripts)
    (scripts / "07_mine").mkdir()
    (scripts / "07_mine" / "MyOwn.cs").write_text(MINE)
    out = build(netmq, "csharp-console", tmp_path / "out", f"-p:PackageScripts={scripts}/")
    played = start("dotnet", next(out.glob("bin/csharp-console/*/csharp-console.dll")), "7", "--unity", "--times", "2")
    assert played.wait() == 0, played.output
    assert played.lines == ["mine", "mine"]


def test_the_kits_own_scripts_have_no_warning(netmq: dotnet.NetMQ, tmp_path: Path) -> None:
    build(netmq, "csharp-support/lessons", tmp_path / "out", "-p:Strict=true")


def test_plays_the_console_twins_lines(
    console: list[str], serve: Callable[..., Any], start: Callable[..., Any]
) -> None:
    endpoint = serve("01_request_reply")[1]
    console_client = start(*console, "1", "--endpoint", endpoint, "--count", "3")
    assert console_client.wait() == 0, console_client.output
    # Its options set the fields of these names; one class is set apart from all, in whatever order.
    for words in (
        ("--endpoint", endpoint, "--count", "3"),
        ("--set", f"endpoint={endpoint}", "--set", "count=3"),
        ("--HelloClient.endpoint", endpoint, "--HelloClient.count", "3", "--endpoint", "tcp://127.0.0.1:9"),
        ("--set", "HelloClient.count=3", "--count", "4", "--endpoint", endpoint),
    ):
        played = start(*console, "1", "--unity", *words)
        assert played.wait() == 0, played.output
        assert played.lines == console_client.lines
        assert played.lines[-1] == "done: 3 replies"


def test_an_error_in_the_log_is_exit_code_1(console: list[str], start: Callable[..., Any]) -> None:
    played = start(*console, "1", "--unity", "--set", "endpoint=127.0.0.1:5551")
    assert played.wait() == 1
    assert "write it like tcp://" in played.output


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (
            ["1", "--unity", "--set", "nope=3"],
            "unknown: --nope; the fields that a script has here: endpoint count timeout",
        ),
        (["1", "--unity", "--MyClient.count", "3"], "unknown: --MyClient.count; the fields that a script has here"),
        (["1", "--unity", "--set", "count=three"], "'three' is no Int32"),
        (["1", "--unity", "--count", "three"], "--count: 'three' is no Int32"),
        (["1", "--unity", "--count", "-1"], "--count: it must be at least 0, not -1"),
        (["2", "--unity", "--tries", "0"], "--tries: it must be at least 1, not 0"),
        (["2", "--unity", "--timeout", "NaN"], "--timeout: it must be at least 0.01, not NaN"),
        (["1", "--unity", "--help"], "--endpoint tcp://127.0.0.1:5551  --count 10  --timeout 2.5"),
        (["1", "--unity", "--set", "count"], "--set takes name=value"),
        (["1", "--unity", "--frames", "3"], "unknown: --frames"),
        (["99", "--unity"], "which lesson?"),
        (["--unity"], "which lesson?"),
    ],
)
def test_wrong_usage_is_one_line_and_code_2(
    words: list[str], says: str, console: list[str], start: Callable[..., Any]
) -> None:
    played = start(*console, *words)
    assert played.wait() == 2, played.output
    assert len(played.lines) == 1
    assert says in played.lines[0]


def test_seconds_end_a_play(console: list[str], start: Callable[..., Any]) -> None:
    words = ["--set", "endpoint=tcp://127.0.0.1:9", "--set", "timeout=60", "--seconds", "5"]
    played = start(*console, "1", "--unity", *words)
    assert played.wait() == 0, played.output
    assert played.lines == ["asking tcp://127.0.0.1:9"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no signals to another process")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_play_properly(how: signal.Signals, console: list[str], start: Callable[..., Any]) -> None:
    played = start(*console, "1", "--unity", "--set", "endpoint=tcp://127.0.0.1:9", "--set", "timeout=60")
    played.wait_for("^asking")
    assert played.stop(how, limit=30) == 1
    assert played.lines[-1] == "stopped"
