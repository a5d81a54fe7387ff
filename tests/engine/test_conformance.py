"""Both engines print the transcript that was recorded from NetMQ."""

from __future__ import annotations

import difflib
import os
import subprocess
from pathlib import Path

import pytest

from kitlib.lessons import KitError
from kitlib.setup import dotnet
from tests.conftest import PYTHON
from tests.programs import ROOT

PROJECT = ROOT / "tests" / "engine" / "conformance"


def built(name: str) -> Path:
    """The conformance program on one engine; skips where this machine cannot build it."""
    if name == "libzmq" and os.name == "nt" and not os.environ.get("LIBZMQ"):
        pytest.skip("pyzmq for Windows holds no libzmq: set LIBZMQ to one")
    if not dotnet.sdk():
        pytest.skip(dotnet.DOWNLOAD)
    try:
        engine = dotnet.choose_engine(name)
    except KitError as error:
        pytest.skip(str(error))
    return dotnet.build(PYTHON, engine, PROJECT)


@pytest.mark.parametrize("name", dotnet.ENGINES)
@pytest.mark.timeout(900)
def test_the_transcript_is_the_one_recorded_from_netmq(name):
    done = subprocess.run(
        ["dotnet", str(built(name))], cwd=ROOT, capture_output=True, text=True, encoding="utf-8", timeout=360
    )
    assert done.returncode == 0, done.stdout + done.stderr
    recorded = (PROJECT / "transcript.txt").read_text(encoding="utf-8").splitlines()
    printed = done.stdout.splitlines()
    assert printed == recorded, "\n".join(difflib.unified_diff(recorded, printed, "transcript.txt", name, lineterm=""))


@pytest.mark.timeout(900)
def test_another_thread_ends_a_wait_and_not_the_process():
    """Disposing a socket in use, and Cleanup against constructors, on the libzmq engine."""
    done = subprocess.run(
        ["dotnet", str(built("libzmq")), "threads"], capture_output=True, text=True, encoding="utf-8", timeout=360
    )
    assert done.returncode == 0, done.stdout + done.stderr
    waits = ("receiving", "receiving with a limit", "sending", "sending with a limit", "polling")
    assert done.stdout.splitlines() == [
        "== threads",
        *(f"disposed while {wait}: ObjectDisposedException" for wait in waits),
        "disposed at work, 60 times: ObjectDisposedException",
        "Cleanup against constructors: True",
        "the constructors ended: True",
        "and threw at the most: TerminatingException",
        "and all was closed: True",
    ]
