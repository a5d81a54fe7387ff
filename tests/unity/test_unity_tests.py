"""The tests that the package brings for Unity's Test Runner, here run by tests/unity/runner in the player.

They are compiled with NUnit from NuGet, and with a stand-in of the little that Unity's Test Framework adds to it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from kitlib.lessons import KitError
from kitlib.setup import dotnet
from kitlib.unity.install import nuget_folder
from kitlib.unity.meta import PACKAGE, behaviours
from tests.programs import ROOT, Program
from tests.unity.test_unity_play import RUNTIMES, needs_mono

RUNNER = ROOT / "tests" / "unity" / "runner"
WORKFLOW = ROOT / ".github" / "workflows" / "unity.yml"


@pytest.fixture(scope="session")
def runner(netmq: dotnet.NetMQ) -> Path:
    try:
        return dotnet.build(netmq, RUNNER)
    except KitError as error:
        if (nuget_folder() / "nunit").exists():
            raise
        pytest.skip(f"NUnit comes from NuGet: {error}")


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_they_pass(
    runtime: str, runner: Path, netmq: dotnet.NetMQ, start: Callable[..., Program], tmp_path: Path
) -> None:
    if runtime == "mono":
        needs_mono()
    program = start({"mono": "mono", ".net": "dotnet"}[runtime], runner, folder=tmp_path)
    code = program.wait(120)
    assert [line for line in program.lines if line.startswith("FAILED")] == []
    assert code == 0, program.output
    passed = {line.split(" ", 1)[1] for line in program.lines if line.startswith("passed ")}
    for test in ("BytesTests.AMessageComesBackAsItWasSent()", "HelloClientTests.GetsItsReplies(5)"):
        assert test in passed
    # The name of a client's own tests, or what those of all clients are told.
    replied = {re.sub(r"ClientsTests\.GetsItsFirstReply\((\w+)\)|Tests\..*", r"\1", name) for name in passed}
    for lesson in sorted(PACKAGE.glob("[0-9][0-9]_*/")):
        assert replied & {path.stem for path in behaviours(lesson)}, f"{lesson.name} has no test in Play mode"


def test_the_workflow_runs_them_in_an_editor_where_there_is_a_licence() -> None:
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    text = WORKFLOW.read_text(encoding="utf-8")
    jobs = yaml.safe_load(text)["jobs"]
    test = jobs["test"]
    assert test["needs"] == "licence" and test["if"] == "needs.licence.outputs.there == 'yes'"
    (look,) = jobs["licence"]["steps"]
    assert look["id"] == "look" and "UNITY_LICENSE" in look["env"] and "there=" in look["run"]
    uses = [step["uses"] for step in test["steps"]]
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@v\d+", one) for one in uses), "each action has its version"
    (unity,) = [step for step in test["steps"] if step["uses"].startswith("game-ci/unity-test-runner@")]
    assert (ROOT / unity["with"]["projectPath"] / "ProjectSettings" / "ProjectVersion.txt").exists()
    assert unity["with"]["testMode"] == "all" and "UNITY_LICENSE" in unity["env"]
    assert test["strategy"]["matrix"]["unity"][0] == "auto"
