"""kit.py server N --reload: when a file counts as saved. A whole run is in test_kit.py."""

import os
import signal
from types import SimpleNamespace

from kitlib import reload
from kitlib.commands import copy
from kitlib.lessons import find
from tests.conftest import PYTHON
from tests.programs import ROOT, Mark, finds_processes, steady_endpoint


def test_an_editor_that_writes_in_steps_starts_it_once(tmp_path, monkeypatch):
    path, other = tmp_path / "server.py", tmp_path / "4913.py"
    path.write_text("1")
    steps = [
        lambda: None,
        # One that comes and goes is no save.
        lambda: other.write_text("x"),
        other.unlink,
        lambda: None,
        lambda: path.write_text(""),
        lambda: path.write_text("whole"),
        lambda: path.rename(other),
        lambda: other.rename(path),
        lambda: None,
        lambda: None,
    ]
    monkeypatch.setattr(reload, "time", SimpleNamespace(sleep=lambda _: steps.pop(0)()))
    running = SimpleNamespace(poll=lambda: None)
    assert reload.wait_for_reason([tmp_path], reload.files([tmp_path]), running) == "server.py saved"
    assert len(steps) == 1, "as soon as it is whole"


@finds_processes
def test_a_server_that_was_killed_is_started_again_and_loses_nothing(start, tmp_path):
    """As an assertion of libzmq's ends it, or the system where the memory is full."""
    key = "02_lazy_pirate"
    mark, endpoint = Mark(), steady_endpoint()
    own = ["--endpoint", endpoint, "--journal", str(tmp_path / "journal")]
    kit = start(PYTHON, ROOT / "kit.py", "server", key, "--reload", *own, **mark.environment)
    kit.wait_for("^listening on")
    client = start(
        PYTHON, ROOT / "python" / key / "client.py", "--endpoint", endpoint, "--count", "1000", "--tries", "100"
    )
    client.wait_for("^20: sent")
    begin = len(kit.lines)
    (number,) = (number for number, command in mark.processes().items() if "server.py" in command)
    os.kill(number, signal.SIGABRT)
    kit.wait_for(r"^kit    \| the server was killed: starting anew$", start=begin)
    kit.wait_for("^listening on", start=begin)
    assert client.wait() == 0, client.output
    assert "1000: sent add 1, received 1000" in client.lines[-2:], client.output
    assert kit.stop(signal.SIGINT) == 130
    assert mark.gone()


@finds_processes
def test_a_run_whose_server_is_changed_goes_on(start, tmp_path):
    """Here of a server of one's own: what is saved answers the client that still asks."""
    mark, key = Mark(), "02_lazy_pirate"
    copy.write(tmp_path, copy.programs(find(key), tmp_path)[0], force=False)
    path = tmp_path / key / "server.py"
    words = ["run", path, "--reload", "--client", "python", "--folder", tmp_path, "--endpoint", steady_endpoint()]
    kit = start(PYTHON, ROOT / "kit.py", *words, "--options=--count 1000000 --tries 100", **mark.environment)
    kit.wait_for(r"^client \| 20: sent add 1, received 20$")
    path.write_text(path.read_text(encoding="utf-8").replace("balance + ?", "balance - ?"), encoding="utf-8")
    kit.wait_for(r"^server \| kit    \| server.py saved: starting anew$")
    kit.wait_for(r"^client \| \d+: sent add 1, received -\d+$")
    assert kit.stop(signal.SIGINT) == 130
    assert mark.gone()


def test_a_server_of_ones_own(start, tmp_path):
    """It may lie anywhere, and has the kit's packages."""
    path = tmp_path / "mine.py"
    text = "import sys, time, zmq\nprint('one', *sys.argv[1:], flush=True)\ntime.sleep(600)\n"
    path.write_text(text, encoding="utf-8")
    kit = start(PYTHON, ROOT / "kit.py", "server", path, "--reload", "--endpoint", "here")
    kit.wait_for("^one --endpoint here$")
    path.write_text(text.replace("one", "two"), encoding="utf-8")
    kit.wait_for("^two --endpoint here$")
    assert kit.stop(signal.SIGINT) == 130
    nobody = start(PYTHON, ROOT / "kit.py", "server", tmp_path / "none.py")
    assert nobody.wait() == 2 and "name a lesson, or a server.py of yours" in nobody.output
