"""The tests that the package brings for Unity's Test Runner, here run by tests/unity/runner in the player.

They are compiled with NUnit from NuGet, and with a stand-in of the little that Unity's Test Framework adds to it.
"""

import re

import pytest

from kitlib.lessons import PACKAGE, KitError
from kitlib.setup import dotnet
from kitlib.setup.dotnet import nuget_folder
from kitlib.unity.meta import behaviours
from tests.programs import ROOT
from tests.unity.conftest import NEAREST

RUNNER = ROOT / "tests" / "unity" / "runner"


@pytest.fixture(scope="session")
def runner(netmq):
    try:
        return dotnet.build(netmq, RUNNER)
    except KitError as error:
        if (nuget_folder() / "nunit").exists():
            raise
        pytest.skip(f"NUnit comes from NuGet: {error}")


def test_they_pass(runner, start, tmp_path):
    program = start(NEAREST, runner, folder=tmp_path)
    code = program.wait(300)
    assert [line for line in program.lines if line.startswith("FAILED")] == []
    assert code == 0, program.output
    passed = {line.split(" ", 1)[1] for line in program.lines if line.startswith("passed ")}
    for test in ("BytesTests.AMessageComesBackAsItWasSent()", "ClientsTests.GetsItsReplies(5)"):
        assert test in passed
    # The name of a client's own tests, or what those of all clients are told.
    replied = {re.sub(r"ClientsTests\.GetsItsFirstReply\((\w+)\)|Tests\..*", r"\1", name) for name in passed}
    for lesson in sorted(PACKAGE.glob("[0-9][0-9]_*/")):
        assert replied & {path.stem for path in behaviours(lesson)}, f"{lesson.name} has no test in Play mode"
