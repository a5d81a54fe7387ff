"""kit.py as a person meets it: on a copy of the repository, as a process, on machines with and without things."""

from __future__ import annotations

import io
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import time
import uuid
from pathlib import Path

import pytest

import kit
from kitlib import dotnet, lessons, python_setup, terminal
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
        script.read_text(encoding="utf-8").replace("TrySendFrame(Slice, text)", 'TrySendFrame(Slice, "Bye")'),
        encoding="utf-8",
    )
    third = start(*command)
    assert third.wait(300) == 0
    assert "building" in third.output
    assert "client | 1: sent Hello, received error: expected Hello, got 3 bytes beginning b'Bye'" in third.lines


class Stopped:
    """kit.py in a terminal of its own, and everything that it started, found by a mark in the environment."""

    def __init__(self, words, folder, **env):
        self.mark = f"KIT_TEST_MARK={uuid.uuid4()}"
        self.output = folder / "printed.txt"
        name, value = self.mark.split("=")
        with self.output.open("w") as file:
            self.process = subprocess.Popen(
                [str(word) for word in words], cwd=ROOT, stdin=subprocess.DEVNULL, stdout=file,
                stderr=subprocess.STDOUT, start_new_session=True,
                env={**os.environ, "PYTHONUNBUFFERED": "1", **env, name: value},
            )  # fmt: skip

    def running(self):
        """The command of each process that has the mark."""
        found = []
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                if self.mark.encode() in (folder / "environ").read_bytes():
                    found.append((folder / "cmdline").read_bytes().replace(b"\0", b" ").decode())
            except OSError:
                pass
        return found

    def wait_for(self, what, limit=120):
        deadline = time.monotonic() + limit
        while not what():
            assert time.monotonic() < deadline, self.printed
            assert self.process.poll() is None, self.printed
            time.sleep(0.02)

    @property
    def printed(self):
        return self.output.read_text(encoding="utf-8", errors="replace")

    def stop(self, how):
        """Ctrl-C in a terminal is SIGINT for kit.py and all programs beside it; SIGTERM is for kit.py alone."""
        if how == signal.SIGINT:
            os.killpg(self.process.pid, how)
        else:
            self.process.send_signal(how)
        code = self.process.wait(60)
        assert self.running() == []
        assert "Traceback" not in self.printed
        return code

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                if self.mark.encode() in (folder / "environ").read_bytes():
                    os.kill(int(folder.name), signal.SIGKILL)
            except OSError:
                pass
        self.process.wait()


finds_processes = pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="finds processes in /proc")


@finds_processes
@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_ctrl_c_in_a_run_leaves_nothing_running(how, tmp_path, serve):
    words = ["run", "1", "--client", "python", "--endpoint", "tcp://127.0.0.1:*", "--server=--delay 300"]
    with Stopped([PYTHON, KIT, *words, "--options=--patience 300"], tmp_path) as run:
        run.wait_for(lambda: "client | asking" in run.printed)
        assert len(run.running()) == 3
        assert run.stop(getattr(signal, how)) == 130
        endpoint = re.search(r"listening on (\S+)", run.printed)[1]
    # The port is free again.
    assert serve("01_request_reply", endpoint=endpoint)[1] == endpoint


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends a Ctrl-C in another way")
def test_ctrl_c_while_a_program_is_being_started_ends_it(monkeypatch):
    started = []

    class Interrupted(subprocess.Popen):
        def __init__(self, *words, **options):
            super().__init__(*words, **options)
            started.append(self)
            # The worst moment: it runs, and who asked for it does not know it yet.
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(subprocess, "Popen", Interrupted)
    try:
        with pytest.raises(KeyboardInterrupt):
            terminal.quietly([sys.executable, "-c", "import time; time.sleep(60)"], 60)
        assert started[0].poll() is not None
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        started[0].kill()


@finds_processes
def test_ctrl_c_in_the_set_up_leaves_nothing_running_and_the_next_run_works(copy, bare_python, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as silent:
        # An index that accepts connections and never answers.
        index = f"http://127.0.0.1:{silent.getsockname()[1]}/simple"
        env = {"PIP_NO_INDEX": "0", "PIP_FIND_LINKS": "", "PIP_INDEX_URL": index}
        with Stopped([bare_python, copy / "kit.py", "run", "1", "--client", "python"], tmp_path, **env) as run:
            run.wait_for(lambda: any(" pip " in line and "install" in line for line in run.running()))
            assert run.stop(signal.SIGINT) == 130
    again = [bare_python, copy / "kit.py", "run", "1", "--client", "python", "--endpoint", "tcp://127.0.0.1:*"]
    done = subprocess.run(again, capture_output=True, text=True, timeout=120)
    assert "client | done: 10 replies" in done.stdout, done.stdout


@finds_processes
def test_ctrl_c_in_the_build_leaves_nothing_running(engine, copy, tmp_path):
    words = ["run", "1", "--engine", engine.name, "--endpoint", "tcp://127.0.0.1:*"]
    with Stopped([PYTHON, copy / "kit.py", *words], tmp_path) as run:
        run.wait_for(
            lambda: "building" in run.printed and any("/csc" in line or "nodemode" in line for line in run.running())
        )
        assert run.stop(signal.SIGINT) == 130


SLOW_TEST = """
import subprocess, sys, time
def test_slow():
    deaf = "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); time.sleep(300)"
    started = subprocess.Popen([sys.executable, "-c", deaf])
    try:
        print("started", flush=True)
        started.wait()
    finally:
        time.sleep(1)
        print("cleared up", flush=True)
"""


@finds_processes
def test_ctrl_c_in_the_tests_lets_the_running_test_clear_up(tmp_path):
    (tmp_path / "test_slow.py").write_text(SLOW_TEST, encoding="utf-8")
    words = ["test", "-s", "-p", "no:cacheprovider", "--confcutdir", tmp_path, tmp_path / "test_slow.py"]
    with Stopped([PYTHON, KIT, *words], tmp_path) as run:
        run.wait_for(lambda: "started" in run.printed)
        assert len(run.running()) >= 3
        assert run.stop(signal.SIGINT) == 130
        assert "cleared up" in run.printed


def test_a_second_ctrl_c_does_not_stop_the_clearing_up():
    with terminal.uninterrupted():
        signal.raise_signal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def refused(start, *words):
    """The one line that answers wrong words."""
    program = start(PYTHON, KIT, *words)
    assert program.wait() == 2
    assert len(program.lines) == 1, program.output
    return program.lines[0].removeprefix("kit    | ")


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        ("rum 1", "there is no command 'rum'; did you mean run?"),
        ("2", "there is no command '2'; did you mean `python3 kit.py run 2`?"),
        ("--version", r"there is no command '--version'; there are: run, test, "),
        ("run", r".* required: LESSON; `python3 kit\.py run --help` shows how$"),
        ("run 99", "there is no lesson 99; there are: 01_request_reply, 02_lazy_pirate, "),
        ("run 0", "there is no lesson 0; there are: 01_request_reply, "),
        ("run request", r"there is no lesson request; did you mean 01_request_reply\?$"),
        ("run lazy_pirat", r"there is no lesson lazy_pirat; did you mean 02_lazy_pirate\?$"),
        ("run 2_lasy_pirate", r"there is no lesson 2_lasy_pirate; did you mean 02_lazy_pirate\?$"),
        ("run 1 --clinet python", r"run takes no '--clinet'; did you mean --client\?$"),
        ("run 1 --count 3", r"run takes no '--count'; what the client takes goes into --options="),
        ("run 1 more", r"run takes no 'more'; what the client takes"),
        ("run 1 --client c#", r"argument --client: invalid choice: 'c#' \(choose from .*csharp.*--help` shows how$"),
        ("run 1 --endpoint", r"argument --endpoint: expected one argument; .*--help` shows how$"),
        ("run 1 --options='x", r"--options 'x: a quotation mark in it is not closed"),
        ("unity", r".* required: PATH; `python3 kit\.py unity --help` shows how$"),
        ("unity My Game", r"unity takes no 'Game'; a path with a space"),
        ("list all", r"list takes no 'all'; `python3 kit\.py list --help` shows what it takes$"),
    ],
)
def test_a_wrong_word_is_answered_in_one_line_with_the_cure(words, answer, start):
    assert re.match(answer, refused(start, *words.split()))


@pytest.mark.parametrize("words", [[], ["--help"], ["-h"], ["help"]])
def test_the_help_names_every_command(words, start):
    program = start(PYTHON, KIT, *words)
    # Nothing was asked for, so nothing was done.
    assert program.wait() == (0 if words else 2)
    for command in kit.commands():
        assert f"    python3 kit.py {command.name} " in program.output


@pytest.mark.parametrize("name", [command.name for command in kit.commands()])
@pytest.mark.parametrize("option", ["--help", "-h"])
def test_every_command_explains_itself_with_examples_that_it_takes(name, option, start):
    program = start(PYTHON, KIT, name, option)
    assert program.wait() == 0
    command = next(command for command in kit.commands() if command.name == name)
    assert command.description in program.output
    examples = re.findall(rf"^  python3 kit\.py {name}\b(.*?)(?:   .*)?$", program.output, re.MULTILINE)
    assert examples
    for example in examples:
        if "--help" not in example:
            command.parse(shlex.split(example))


def test_what_comes_after_test_is_for_pytest(start):
    program = start(
        PYTHON, KIT, "test", "-k", "not_a_test or what_comes_after", "--collect-only", "-q", "--", "--no-header"
    )
    assert program.wait(60) == 0
    assert any(line.endswith("::test_what_comes_after_test_is_for_pytest") for line in program.lines)
    theirs = start(PYTHON, KIT, "test", "--", "--help")
    assert theirs.wait(60) == 0
    assert any(line.startswith("usage: ") and "file_or_dir" in line for line in theirs.lines)


class Screen(io.StringIO):
    def __init__(self, terminal):
        super().__init__()
        self.terminal = terminal

    def isatty(self):
        return self.terminal


@pytest.mark.parametrize(
    ("on_terminal", "env", "colour"),
    [
        (True, {}, True),
        (False, {}, False),
        (True, {"NO_COLOR": "1"}, False),
        (True, {"NO_COLOR": ""}, True),
        (True, {"TERM": "dumb"}, False),
    ],
)
def test_colour_is_for_terminals_that_want_it(on_terminal, env, colour, monkeypatch):
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    for name, value in env.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(terminal, "windows_console", lambda _: True)
    assert ("\033" in terminal.coloured("kit", "kit", Screen(on_terminal))) == colour


@pytest.mark.skipif(os.name == "nt", reason="needs a pseudo-terminal")
@pytest.mark.parametrize("on_terminal", ["stdout", "stderr"])
def test_an_error_is_coloured_where_the_errors_go(on_terminal, monkeypatch, tmp_path):
    import pty

    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    ours, its = pty.openpty()
    with (tmp_path / "file").open("w+b") as file:
        streams = {"stdout": file, "stderr": file, on_terminal: its}
        assert subprocess.run([PYTHON, KIT, "rum"], **streams, timeout=30).returncode == 2
        os.close(its)
        file.seek(0)
        printed = os.read(ours, 1000) if on_terminal == "stderr" else file.read()
    os.close(ours)
    assert b"did you mean run?" in printed
    assert (b"\033[31m" in printed) == (on_terminal == "stderr")


@pytest.mark.skipif(os.name == "nt", reason="needs head")
def test_who_stops_reading_is_not_answered_with_a_traceback():
    command = f"'{PYTHON}' '{KIT}' run 1 --client python --endpoint 'tcp://127.0.0.1:*' | head -2"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, timeout=60)
    assert len(done.stdout.splitlines()) == 2
    assert done.stderr == ""


def test_a_server_that_cannot_start_ends_the_run(serve, start):
    _, endpoint = serve("01_request_reply")
    program = start(PYTHON, KIT, "run", "1", "--client", "python", "--endpoint", endpoint)
    assert program.wait() == 1
    said = f"cannot listen on {endpoint}: the port is taken; try --endpoint tcp://127.0.0.1:0, which takes a free one"
    assert f"server | {said}" in program.lines
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
