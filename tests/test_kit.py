"""kit.py as a person meets it: on a copy of the repository, as a process, on machines with and without things."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from kitlib import dotnet, lessons, python_setup
from kitlib.lessons import KitError
from kitlib.terminal import Result
from tests.conftest import PYTHON
from tests.programs import ROOT

KIT = ROOT / "kit.py"


@pytest.fixture
def copy(tmp_path):
    """What a fresh clone holds."""
    clone = tmp_path / "clone"
    skipped = shutil.ignore_patterns(".git", ".build", ".venv", "__pycache__", ".*_cache")
    shutil.copytree(ROOT, clone, ignore=skipped)
    return clone


@pytest.fixture
def bare_python(tmp_path):
    """An interpreter with nothing installed."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "bare"], check=True, timeout=120)
    return tmp_path / "bare" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def test_list_names_every_lesson_of_the_folders(start):
    program = start(PYTHON, KIT, "list")
    assert program.wait() == 0
    folders = sorted(path.name for path in (ROOT / "python").iterdir() if (path / "server.py").exists())
    assert [line.split()[0] for line in program.lines] == folders


@pytest.mark.parametrize("client", ["python", "csharp"])
def test_run_shows_both_sides_and_ends_with_the_clients_code(client, engine, start):
    program = start(
        PYTHON, KIT, "run", "1", "--client", client, "--engine", engine.name, "--endpoint", "tcp://127.0.0.1:*"
    )
    assert program.wait(300) == 0, program.output
    assert "client | done: 10 replies" in program.lines
    assert program.lines.count("server | sent World") == 10
    failing = start(
        PYTHON,
        KIT,
        "run",
        "01",
        "--client",
        client,
        "--engine",
        engine.name,
        "--endpoint",
        "tcp://127.0.0.1:*",
        "--server=--delay 30",
        "--options=--patience 0.2",
    )
    assert failing.wait(300) == 1, failing.output
    assert any(line.startswith("client | gave up") for line in failing.lines)


def test_a_second_build_happens_only_after_a_change(engine, copy, start):
    command = [PYTHON, copy / "kit.py", "run", "1", "--engine", engine.name, "--endpoint", "tcp://127.0.0.1:*"]
    first, second = start(*command), None
    assert first.wait(300) == 0, first.output
    assert "building" in first.output
    second = start(*command)
    assert second.wait(300) == 0
    assert "building" not in second.output
    assert "installing" not in second.output
    assert "asking NuGet" not in second.output
    script = copy / "unity" / "Assets" / "NetMQExample" / "01_request_reply" / "HelloRequester.cs"
    script.write_text(
        script.read_text(encoding="utf-8").replace("socket.SendFrame(text)", 'socket.SendFrame("Bye")'),
        encoding="utf-8",
    )
    third = start(*command)
    assert third.wait(300) == 0
    assert "building" in third.output
    assert "client | 1: sent Hello, received error: expected Hello, got 3 bytes beginning b'Bye'" in third.lines


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals to end a program with")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_leaves_nothing_running(how, start, serve):
    program = start(
        PYTHON, KIT, "run", "1", "--client", "python", "--endpoint", "tcp://127.0.0.1:*",
        "--server=--delay 300", "--options=--patience 300",
    )  # fmt: skip
    endpoint = program.wait_for(r"client \| asking (\S+)")[1]
    assert program.stop(how) == 130
    assert "Traceback" not in program.output
    # The port is free again, so the server is gone.
    assert serve("01_request_reply", endpoint=endpoint)[1] == endpoint


@pytest.mark.parametrize("number", ["99", "0", "request"])
def test_an_unknown_lesson_is_answered_with_the_lessons_there_are(number, start):
    program = start(PYTHON, KIT, "run", number)
    assert program.wait() == 1
    assert len(program.lines) == 1
    assert "01_request_reply" in program.lines[0]


@pytest.mark.parametrize("words", [["rum", "1"], ["run"], ["run", "1", "--clinet", "python"], []])
def test_wrong_usage_is_2_and_no_traceback(words, start):
    program = start(PYTHON, KIT, *words)
    assert program.wait() == 2
    assert "Traceback" not in program.output


def test_a_server_that_cannot_start_ends_the_run(serve, start):
    _, endpoint = serve("01_request_reply")
    program = start(PYTHON, KIT, "run", "1", "--client", "python", "--endpoint", endpoint)
    assert program.wait() == 1
    assert f"server | cannot listen on {endpoint}: the port is taken; try --endpoint tcp://127.0.0.1:*" in program.lines
    assert "Traceback" not in program.output


@pytest.mark.skipif(os.name == "nt", reason="needs symbolic links")
def test_without_a_dotnet_sdk_the_python_client_runs(tmp_path, start):
    tools = tmp_path / "tools"
    tools.mkdir()
    (tools / "python3").symlink_to(PYTHON)
    program = start(PYTHON, KIT, "run", "1", "--endpoint", "tcp://127.0.0.1:*", PATH=str(tools))
    assert program.wait(120) == 0, program.output
    assert any("no .NET SDK 8 or later here: get it from" in line for line in program.lines)
    assert "client | done: 10 replies" in program.lines


def test_without_an_index_an_interpreter_that_has_pyzmq_serves(copy, bare_python, tmp_path, start):
    env = {
        "PIP_NO_INDEX": "1",
        "PIP_FIND_LINKS": str(tmp_path),
        "PATH": f"{PYTHON.parent}{os.pathsep}{os.environ['PATH']}",
    }
    program = start(
        bare_python, copy / "kit.py", "run", "1", "--client", "python", "--endpoint", "tcp://127.0.0.1:*", **env
    )
    assert program.wait(120) == 0, program.output
    assert re.search(r"kit    \| using \S+, which has pyzmq", program.output)
    assert not (copy / ".venv").exists()
    again = start(
        bare_python, copy / "kit.py", "run", "1", "--client", "python", "--endpoint", "tcp://127.0.0.1:*", **env
    )
    assert again.wait(120) == 0
    assert not any("using" in line or "pip" in line for line in again.lines)


def test_with_an_index_a_venv_is_made(copy, bare_python, start):
    links = os.environ.get("PIP_FIND_LINKS", "")
    if not any(Path(links).glob("pyzmq-*.whl")):
        pytest.skip("no folder of wheels: PIP_FIND_LINKS names none with pyzmq")
    program = start(bare_python, copy / "kit.py", "run", "1", "--client", "python", "--endpoint", "tcp://127.0.0.1:*")
    assert program.wait(300) == 0, program.output
    assert "kit    | installing pyzmq into .venv …" in program.lines
    assert (copy / ".venv").exists()


def test_where_nothing_helps_one_line_says_what_to_run(monkeypatch, tmp_path):
    monkeypatch.setattr(python_setup, "CHOICE", tmp_path / "python.json")
    for way in ("from_pip", "from_this_machine", "from_debian"):
        monkeypatch.setattr(python_setup, way, lambda *_: None)
    with pytest.raises(KitError, match=r"with internet run: \S+ -m pip install pyzmq pytest pytest-timeout$"):
        python_setup.interpreter("tests")


def test_a_venv_without_pip_is_filled_by_the_pip_outside(monkeypatch, tmp_path):
    links = os.environ.get("PIP_FIND_LINKS", "")
    if not any(Path(links).glob("pyzmq-*.whl")):
        pytest.skip("no folder of wheels: PIP_FIND_LINKS names none with pyzmq")
    monkeypatch.setattr(python_setup, "VENV", tmp_path / "venv")
    real = python_setup.quietly

    def as_on_debian(command, *rest, **named):
        # Debian's python3 without python3-venv: the venv module is there, ensurepip is not.
        if "venv" in command and "--without-pip" not in command:
            return Result(1, "ensurepip is not available")
        return real(command, *rest, **named)

    monkeypatch.setattr(python_setup, "quietly", as_on_debian)
    python = python_setup.from_pip(["pyzmq"], ["pyzmq"])
    assert python is not None
    assert python_setup.has(python, ["pyzmq"])
    assert not python_setup.has(python, ["pip"])


@pytest.mark.parametrize(
    ("output", "why"),
    [
        ("error NU1101: Unable to find package NetMQ.", "NuGet does not hold NetMQ"),
        ("error NU1102: Unable to find package NetMQ with version (>= 4.0.2.2)", "NuGet does not hold NetMQ"),
        ("error NU1301: Unable to load the service index", "NuGet cannot be reached"),
    ],
)
def test_a_refusal_of_nuget_is_named(output, why):
    assert dotnet.refusal(Result(1, output)) == why


def test_another_failure_of_the_restore_is_not_taken_for_a_refusal():
    with pytest.raises(KitError, match="MSB4025"):
        dotnet.refusal(Result(1, "x.csproj : error MSB4025: The project file could not be loaded."))


def test_a_restore_that_hangs_counts_as_unreachable():
    assert dotnet.refusal(Result(124, "dotnet did not end within 60 s")) == "NuGet cannot be reached"


def test_doctor_names_each_thing_once(start):
    program = start(PYTHON, KIT, "doctor")
    assert program.wait(200) == 0, program.output
    for what in ("Python", "pyzmq", ".NET SDK", "Mono", "port 5551"):
        assert len([line for line in program.lines if re.match(rf"(ok|--)  {re.escape(what)} ", line)]) == 1, what


def test_a_lesson_is_found_by_number_and_name():
    assert {lessons.find(text).key for text in ("1", "01", "01_request_reply")} == {"01_request_reply"}
