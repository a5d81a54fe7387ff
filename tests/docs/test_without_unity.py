"""The page "Using it without Unity": its programs are built and run as they stand, with what kit.py copy writes."""

import os
import re

import pytest

from kitlib.commands import copy
from kitlib.docs import guide
from kitlib.lessons import lessons
from kitlib.setup import dotnet
from tests.conftest import PYTHON
from tests.programs import ROOT, elsewhere, finished, steady_endpoint

PAGE = ROOT / "docs" / "guide" / "without_unity.md"


def program(language):
    """The page's first program in a language."""
    found, *_ = [block for block in guide.blocks(PAGE) if block.language == language]
    return found.body


def test_the_dotnet_program_builds_and_runs(tmp_path, netmq, console, serve):
    """With what every lesson has for it, so that all of that is seen to compile without Unity."""
    project = tmp_path / "MyProgram.csproj"
    text = program("xml")
    project.write_text(text, encoding="utf-8")
    (tmp_path / "Program.cs").write_text(program("csharp"), encoding="utf-8")
    for lesson in lessons():
        copy.write(tmp_path, copy.csharp(lesson)[0], force=False)
    # A mirror of NuGet may have what NetMQ brings along in newer versions only: NU1603.
    words = ["-warnaserror", "-p:NoWarn=NU1603", "-o", tmp_path / "out"]
    command = ["dotnet", "build", project, *netmq.properties, *words]
    environment = {**os.environ, **dotnet.ENVIRONMENT}
    done = finished(command, timeout=500, env=environment)
    assert done.returncode == 0, done.stdout
    _, endpoint = serve("01_request_reply")
    done = finished(["dotnet", tmp_path / "out" / "MyProgram.dll", endpoint])
    assert done.stdout == "World\n", done.stdout + done.stderr


def test_the_python_program_runs(tmp_path, serve):
    pytest.importorskip("numpy", reason="lesson 05 needs numpy: kit.py run 5 installs it")
    # A busy machine may need longer for the first reply than the page's program waits.
    patient = program("python").replace("(endpoint)", "(endpoint, timeout=60)")
    (tmp_path / "my_program.py").write_text(patient, encoding="utf-8")
    copy.write(tmp_path, copy.module("netmq_example.message_requester")[0], force=False)
    _, endpoint = serve("05_messages")
    command = [PYTHON, tmp_path / "my_program.py", endpoint]
    done = finished(command)
    page = " ".join(PAGE.read_text(encoding="utf-8").split())
    said = re.search(r"answers where the bright pixels begin: `([^`]*)`", page)[1]
    assert done.stdout == f"{said}\n", done.stdout + done.stderr


def test_a_notebook():
    """Beside a server of the kit; and no process is left, or the test would not end."""
    pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
    _, serving, cell = (block.body for block in guide.blocks(PAGE) if block.language == "python")
    again = serving.replace('"--quiet"', f'"--quiet", "--endpoint", "{steady_endpoint()}"')
    done = finished([PYTHON, "-c", elsewhere(f"{again}\n{again}\n{cell}")])
    assert (done.returncode, done.stderr) == (0, ""), done
    assert "simulating CartPole" in done.stdout
    # A kernel that is killed; its server has the pipe that is read here.
    killed = f"{serving}\nimport os\nos.kill(os.getpid(), 9)"
    assert finished([PYTHON, "-c", elsewhere(killed)]).returncode
