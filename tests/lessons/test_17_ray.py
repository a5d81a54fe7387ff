"""Lesson 17, with Ray: the numbers are those of a training without Ray and without ZeroMQ, whoever dies."""

import os
import shutil
import signal
import sys
import tempfile
import time

import pytest

from tests.conftest import PYTHON
from tests.programs import ROOT, Mark, finds_processes, python_runs

pytest.importorskip("ray", reason="needs Ray: pip install ray")
pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")

RAY = ROOT / "python" / "17_many_machines" / "ray_train.py"
from tests.lessons.poles import timeless, trained  # noqa: E402

pytestmark = [pytest.mark.xdist_group("ray"), pytest.mark.skipif(os.name == "nt", reason="Ray is in beta on Windows")]


@pytest.fixture
def train(start):
    """Starts ray_train.py; what Ray writes is in a folder of its own, whose name is short enough for its sockets."""
    folder = tempfile.mkdtemp(prefix="ray")
    # In a session of its own, so that a test can send Ctrl-C to the whole group, as a terminal does.
    command = *(["setsid"] if shutil.which("setsid") else []), PYTHON, RAY
    yield lambda *words, **environment: start(*command, *words, RAY_TMPDIR=folder, HOME=folder, **environment)
    shutil.rmtree(folder, ignore_errors=True)


def test_a_killed_actor_changes_no_number(train, caplog):
    lines, episodes = trained(caplog, 0, 50)
    trainer = train("--crash-on", "10")
    assert trainer.wait(180) == 0, trainer.output
    assert timeless(trainer.lines) == lines
    assert f"done: {episodes} episodes by 3 processes of 2 actors" in trainer.lines


@pytest.mark.long
@finds_processes
@pytest.mark.skipif(not shutil.which("setsid"), reason="needs setsid")
def test_ctrl_c_leaves_no_process_behind(train):
    mark = Mark()
    # A simulator that is slow: there is time for Ctrl-C.
    trainer = train("--launch", sys.executable, str(RAY.with_name("client.py")), "--delay", "0.02", **mark.environment)
    trainer.wait_for("^generation 1", 180)
    assert len([command for command in mark.processes().values() if "ray::Player" in command]) == 2
    os.killpg(trainer.process.pid, signal.SIGINT)
    assert trainer.wait() == 1
    assert trainer.lines[-1] == "stopped" and "Traceback" not in trainer.output
    end = time.monotonic() + 30
    while (left := mark.processes()) and time.monotonic() < end:
        time.sleep(0.1)
    assert left == {}


@pytest.mark.long
@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--launch", "no/such/game"], "FileNotFoundError: no game at no/such/game: "),
        (["--launch", "false"], "netmq_example.errors.Timeout: the launched simulator ended with code 1"),
        (["--address", "nonsense"], "Invalid address format: nonsense"),
    ],
)
def test_what_it_cannot_do_it_says_in_a_line(words, text, train):
    trainer = train(*words)
    assert trainer.wait(180) == 1
    assert trainer.lines[-1].startswith(f"gave up: {text}") and "Traceback" not in trainer.output


def test_wrong_words_are_said_before_ray_starts():
    wrong = [["--actors", "0"], ["--actors", "x"], ["--seed", "-1"]]
    for words, run in zip(wrong, python_runs(RAY, wrong), strict=True):
        assert run.code == 2 and words[0] in run.lines[-1], run
