"""kit.py as a person meets it: on a copy of the repository, as a process, on machines with and without things."""

import contextlib
import importlib
import json
import os
import pkgutil
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from unittest.mock import Mock

import pytest

import kit
from kitlib import commands, lessons, programs, signals
from kitlib.commands import doctor
from kitlib.commands import run as runner
from kitlib.commands import test as tests_command
from kitlib.docs import guide
from kitlib.lessons import KitError
from kitlib.programs import Result
from kitlib.setup import dotnet, python_setup
from tests.conftest import PYTHON
from tests.programs import LIMIT, PATIENT, ROOT, Mark, Program, finds_processes, finished, python_runs, steady_endpoint

KIT = ROOT / "kit.py"
# For the client: its first reply may take seconds on a busy machine.
UNHURRIED = f"--options={' '.join(PATIENT)}"


@pytest.fixture
def copy(tmp_path):
    """A fresh clone."""
    clone = tmp_path / "clone"
    skipped = shutil.ignore_patterns(".git", ".build", ".venv", "__pycache__", ".*_cache", "*.sqlite3*")
    shutil.copytree(ROOT, clone, ignore=skipped)
    return clone


@pytest.fixture
def prepared(copy):
    """A clone that has its Python packages already: these very ones, because a venv of its own takes long to make."""
    mine = PYTHON.parent.parent
    if (mine / "pyvenv.cfg").exists() and os.name != "nt":
        (copy / ".venv").symlink_to(mine, target_is_directory=True)
    return copy


@pytest.fixture
def bare_python(tmp_path):
    """An interpreter with nothing installed."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "bare"], check=True, timeout=LIMIT)
    return tmp_path / "bare" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


class Stopped(Program):
    """kit.py in a terminal of its own, and everything that it started, found by a mark in the environment."""

    def __init__(self, *words, **environment):
        self.mark = Mark()
        super().__init__(["setsid", *words], **environment, **self.mark.environment)

    def running(self):
        """The command of each process that has the mark."""
        return list(self.mark.processes().values())

    def wait_until(self, what):
        deadline = time.monotonic() + 500
        while not any(map(what, self.running())):
            assert time.monotonic() < deadline and not self.ended, self.output
            time.sleep(0.02)

    def press(self, how):
        """Ctrl-C in a terminal is SIGINT for kit.py and all programs beside it; SIGTERM is for kit.py alone."""
        if how == signal.SIGINT:
            os.killpg(self.process.pid, how)
        else:
            self.process.send_signal(how)
        code = self.wait(60)
        assert self.mark.gone()
        assert "Traceback" not in self.output
        return code

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.mark.processes():
            os.kill(process, signal.SIGKILL)
        self.kill()


@finds_processes
@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_ctrl_c_in_a_run_leaves_nothing_running(how, serve):
    words = ["run", "1", "--client", "python", "--endpoint", "tcp://127.0.0.1:0", "--server=--delay 300"]
    with Stopped(PYTHON, KIT, *words, "--options=--timeout 300") as run:
        run.wait_for(r"^client \| asking")
        assert len(run.running()) == 3
        assert run.press(getattr(signal, how)) == 130
        endpoint = re.search(r"listening on (\S+)", run.output)[1]
    # The port is free again.
    assert serve("01_request_reply", endpoint=endpoint)[1] == endpoint


@finds_processes
def test_ctrl_c_in_the_set_up_leaves_nothing_running_and_the_next_run_works(copy, bare_python):
    """In the packages' installation, and in the build; what an index then gives is installed, and built once."""
    has_wheels()
    words = [bare_python, copy / "kit.py", "run", "1", "--client", "python", "--endpoint", "tcp://127.0.0.1:0"]
    with socket.create_server(("127.0.0.1", 0)) as silent:
        # An index that accepts connections and never answers.
        index = f"http://127.0.0.1:{silent.getsockname()[1]}/simple"
        env = {"PIP_NO_INDEX": "0", "PIP_FIND_LINKS": "", "PIP_INDEX_URL": index}
        with Stopped(*words, **env) as run:
            run.wait_until(lambda command: " pip " in command and "install" in command)
            assert run.press(signal.SIGINT) == 130
    done = finished([*words, UNHURRIED])
    assert "kit    | installing pyzmq into .venv …" in done.stdout
    assert "client | done: 10 replies" in done.stdout, done.stdout
    assert (copy / ".venv").exists()


# Of a repository in which the kit lies, and of its CI.
ABOVE = {
    "global.json": '{"sdk": {"version": "8.0.100", "rollForward": "disable"}}',
    "Directory.Packages.props": "<Project><PropertyGroup><ManagePackageVersionsCentrally>true"
    "</ManagePackageVersionsCentrally></PropertyGroup></Project>",
    "Directory.Build.rsp": "-p:OutDir=elsewhere/",
}
VARIABLES = {"VERSION": "v1.4", "Configuration": "Debug", "OUTPUTPATH": "out", "BaseOutputPath": "out", "OutDir": "out"}


@finds_processes
def test_ctrl_c_in_the_build_leaves_nothing_running_and_the_next_run_builds(netmq, prepared, start):
    """MSBuild takes the environment for its own, and reads the folders above; neither matters."""
    words = ["run", "1", "--endpoint", "tcp://127.0.0.1:0", UNHURRIED]
    for name, text in ABOVE.items():
        (prepared.parent / name).write_text(text, encoding="utf-8")
    where = {"folder": prepared.parent, **VARIABLES}
    with Stopped(PYTHON, prepared / "kit.py", *words, **where) as run:
        run.wait_for("building")
        run.wait_until(lambda command: "/csc" in command or "nodemode" in command)
        assert run.press(signal.SIGINT) == 130
    for first in (True, False):
        again = start(PYTHON, prepared / "kit.py", *words, **where)
        assert again.wait(500) == 0, again.output
        assert again.lines[-1] == "client | done: 10 replies"
        assert ("building" in again.output) == first
        assert not re.search("installing|asking NuGet|Python client", again.output), again.output


SLOW_TEST = """
import subprocess, sys, time
def test_slow():
    deaf = "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); print(flush=True); time.sleep(300)"
    started = subprocess.Popen([sys.executable, "-c", deaf], stdout=subprocess.PIPE)
    started.stdout.readline()
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
    with Stopped(PYTHON, KIT, *words) as run:
        run.wait_for("started")
        assert len(run.running()) >= 3
        assert run.press(signal.SIGINT) == 130
        assert "cleared up" in run.output


def test_a_second_ctrl_c_does_not_stop_the_clearing_up():
    with signals.uninterrupted():
        signal.raise_signal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def kit_runs(*each):
    """How kit.py ended with each of these words, all in one process."""
    return python_runs(KIT, each)


WRONG = [
    ("rum 1", "there is no command 'rum'; did you mean run?"),
    ("--nonsense", r"there is no command '--nonsense'; there are: run, server, client, guide, test, "),
    ("run", f".* required: LESSON; `{lessons.KIT} run --help` shows how$"),
    ("run 99", "there is no lesson 99; there are: 01_request_reply, 02_lazy_pirate, "),
    ("run request", r"there is no lesson request; did you mean 01_request_reply\?$"),
    ("run 2_lasy_pirate", r"there is no lesson 2_lasy_pirate; did you mean 02_lazy_pirate\?$"),
    ("run 1 --clinet python", r"run takes no '--clinet'; did you mean --client\?$"),
    ("run 1 --count 3", r"run takes no '--count'; what the client takes goes into --options="),
    ("run 1 --client c#", r"argument --client: invalid choice: 'c#' \(choose from .*csharp.*--help` shows how$"),
    ("run 1 --options='x", r"--options 'x: a quotation mark in it is not closed"),
    ("unity", f"one of the arguments PATH --package is required; `{lessons.KIT} unity --help` shows how$"),
    ("unity Game --package K.unitypackage", "argument --package: not allowed with argument PATH; "),
    ("unity My Game", r"unity takes no 'Game'; a path with a space"),
    ("pack there --python 3.10", r"--python takes a version of 3\.11 or later, such as 3\.13, not 3\.10$"),
    ("test tests/nix.py", r"there is no tests/nix\.py; test takes one lesson, or files, and pytest's options"),
    ("test 1 -k x nix", "there is no nix; test takes one lesson"),
    ("copy netmq_example.nothing new", r"there is no module netmq_example\.nothing; "),
    ("copy netmq_example new --csharp", "--csharp is for a lesson: leave it out, netmq_example is Python$"),
    ("list all", f"list takes no 'all'; `{lessons.KIT} list --help` shows what it takes$"),
]


def test_a_wrong_word_is_answered_in_one_line_with_the_cure():
    for (words, answer), (code, lines) in zip(WRONG, kit_runs(*(words.split() for words, _ in WRONG)), strict=True):
        assert (code, len(lines)) == (2, 1), (words, lines)
        assert re.match(answer, lines[0].removeprefix("kit    | ")), (words, lines)


def test_the_help_names_every_command_and_the_version_is_said():
    nothing, help, (code, said) = kit_runs([], ["--help"], ["--version"])
    # Nothing was asked for, so nothing was done.
    assert (nothing.code, help.code, nothing.lines) == (2, 0, help.lines)
    for name in sorted(module.name for module in pkgutil.iter_modules(commands.__path__)):
        assert any(line.startswith(f"    {lessons.KIT} {name} ") for line in help.lines), name
    assert code == 0
    assert re.fullmatch(r"NetMQExample \d+\.\d+\.\d+, Python 3\.\d+\S*, .+", said[0])


def test_every_command_explains_itself_with_examples_that_it_takes():
    for name, (code, lines) in zip(kit.COMMANDS, kit_runs(*([name, "--help"] for name in kit.COMMANDS)), strict=True):
        command, text = importlib.import_module(f"kitlib.commands.{name}"), "\n".join(lines)
        assert code == 0 and command.ABOUT in text and all(f"{lessons.KIT} {each}" in text for each in command.EXAMPLES)
        for example in command.EXAMPLES:
            if "--help" not in example:
                commands.parse(command, shlex.split(example.partition("   ")[0])[1:])


def test_the_help_of_a_half_ends_with_its_programs_own_options():
    asked = {"server 2": "drop", "client lazy-pirate": "tries"}
    for (words, own), (code, lines) in zip(
        asked.items(), kit_runs(*([*words.split(), "--help"] for words in asked)), strict=True
    ):
        assert code == 0
        ours, theirs = "\n".join(lines).split(f"options of 02_lazy_pirate/{words.split()[0]}.py:")
        assert f"--{own} " not in ours.partition("examples:")[0]
        assert re.search(rf"^ +--{own} \w+ +\w", theirs, re.MULTILINE)
    for code, lines in kit_runs(["server", "99", "--help"], ["client", "99", "--help"]):
        assert code == 2 and lines[0].startswith("kit    | there is no lesson 99")


def test_a_lesson_is_tested_without_what_only_the_others_need():
    words = tests_command.of_a_lesson(lessons.find("8"), ["-k", "slow or frame", "-n", "0"])
    # Pytest goes by the last -k alone.
    assert words.count("-k") == 1 and words[-2:] == ["-n", "0"]
    assert words[words.index("-k") + 1] == "(08_see_and_steer or test_08_) and (slow or frame)"
    ignored = {Path(word.partition("=")[2]).name for word in words if word.startswith("--ignore=")}
    assert {"test_05_messages.py", "test_17_ray.py"} < ignored
    assert not [name for name in ignored if name.startswith(("test_08_", "test_contract"))]


def test_where_nothing_helps_one_line_says_what_to_run(monkeypatch, tmp_path):
    monkeypatch.setattr(python_setup, "CHOICE", tmp_path / "python.json")
    for way in ("from_pip", "has"):
        monkeypatch.setattr(python_setup, way, lambda *_: None)
    monkeypatch.setattr(sys, "executable", "/opt/bin/python3")
    with pytest.raises(KitError, match=r"with internet run: \S+ -m pip install pyzmq pytest pytest-timeout$"):
        python_setup.interpreter("tests")
    # In a room without internet the advice to ask an index would be of no use.
    (tmp_path / "pyzmq-27.0.0-cp399-cp399-win_amd64.whl").write_bytes(b"")
    monkeypatch.setattr(python_setup, "PACKAGES", tmp_path)
    mine = f"--system {python_setup.HERE} --python {python_setup.VERSION}"
    for code, said in ((0, f"with internet run: {lessons.KIT} pack {mine} "), (1, "has no pip: with internet install")):
        monkeypatch.setattr(python_setup, "quietly", lambda *_, code=code, **__: Result(code, ""))
        with pytest.raises(KitError, match=said):
            python_setup.interpreter("tests")
    monkeypatch.setattr(python_setup, "PACKAGES", tmp_path / "none")
    # Debian's own Python takes nothing from pip.
    monkeypatch.setattr(sys, "executable", "/usr/bin/python3")
    monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}")
    monkeypatch.setattr(python_setup, "quietly", lambda words, **_: Result(100 * ("gymnasium" in words[2]), ""))
    with pytest.raises(KitError, match=r"run: sudo apt install python3-zmq python3-pytest python3-pytest-timeout$"):
        python_setup.interpreter("tests")
    # Which has no Gymnasium.
    with pytest.raises(KitError, match=r"run: sudo apt install python3-venv, and then this again$"):
        python_setup.interpreter("09_environment")


def test_a_venv_without_pip_is_filled_by_the_pip_outside_whatever_its_settings(monkeypatch, tmp_path):
    has_wheels()
    (tmp_path / "pip.conf").write_text("[install]\nuser = true\n", encoding="utf-8")
    settings = {"USER": "1", "REQUIRE_HASHES": "1", "DRY_RUN": "1", "PYTHON": "nothing"}
    settings |= dict.fromkeys(("TARGET", "PREFIX", "ROOT"), str(tmp_path / "elsewhere"))
    for name, value in {**settings, "CONFIG_FILE": str(tmp_path / "pip.conf")}.items():
        monkeypatch.setenv(f"PIP_{name}", value)
    monkeypatch.setattr(python_setup, "VENV", tmp_path / "venv")
    real = programs.quietly

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
    assert not (tmp_path / "elsewhere").exists()


def test_a_foreign_package_does_not_hide_those_of_the_venv(prepared, tmp_path, start):
    """On PYTHONPATH, as ROS sets it, and in the folder one is in."""
    if not (prepared / ".venv").exists():
        pytest.skip("the tests run with a system's packages: there is no package index")
    (tmp_path / "zmq.py").write_text("raise ImportError('of another Python')", encoding="utf-8")
    words = ["--client", "python", "--endpoint", "tcp://127.0.0.1:0", UNHURRIED]
    foreign = {"PYTHONPATH": str(tmp_path), "PYTHONSAFEPATH": "", "PYTHONHOME": sys.base_prefix}
    program = start(PYTHON, prepared / "kit.py", "run", "1", *words, folder=tmp_path, **foreign)
    assert program.wait() == 0, program.output
    assert "kit    |" not in program.output


def test_what_python_is_told_to_leave_out_is_found(start):
    program = start(PYTHON, KIT, "--help", PYTHONSAFEPATH="1", PYTHONOPTIMIZE="2")
    assert program.wait() == 0, program.output
    assert any(line.startswith(f"    {lessons.KIT} run 1 ") for line in program.lines)


@pytest.mark.skipif(os.name == "nt", reason="needs a shell that closes streams")
@pytest.mark.parametrize(("streams", "said"), [(">&- 2>&- <&-", ""), (">&-", ""), (">/dev/full", "No space left")])
def test_output_that_cannot_be_written_ends_nothing(streams, said):
    if "/dev/full" in streams and not Path("/dev/full").exists():
        pytest.skip("no /dev/full")
    words = f"run 1 --client python --endpoint tcp://127.0.0.1:0 '{UNHURRIED}'"
    done = finished(["sh", "-c", f"exec '{PYTHON}' '{KIT}' {words} {streams}"])
    assert (done.returncode, done.stdout) == (0, "")
    assert (said in done.stderr) and "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"sdk": lambda: None, "listed": Result(127, "")}, "no .NET SDK 8 or later here: get it from"),
        ({"sdk": lambda: None, "listed": Result(131, "no libicu")}, "dotnet fails (no libicu): get it from"),
        ({"ROOT": Path("/My%20Kit")}, "MSBuild takes %20 in"),
        ({"ROOT": Path('/My "Kit"')}, 'MSBuild takes " in'),
        ({"restore": Result(1, "error NU1301: Unable to load")}, "NuGet cannot be reached; a folder packages from"),
        ({"step": Result(1, "x: error MSB3094: items\n0 Warning(s)")}, "the C# build failed (x: error MSB3094: items)"),
    ],
)
def test_where_there_is_no_csharp_client_the_python_client_runs(settings, said, monkeypatch, tmp_path, capsys):
    without_nuget(monkeypatch, tmp_path)
    for name, value in settings.items():
        monkeypatch.setattr(dotnet, name, (lambda *_, value=value: value) if isinstance(value, Result) else value)
    command = runner.client_command(None, lessons.find("1"), PYTHON)
    assert command == [str(PYTHON), str(lessons.find("1").python / "client.py")]
    printed = capsys.readouterr().out.splitlines()[-1]
    assert said in printed and printed.endswith("; running the Python client instead")
    with pytest.raises(KitError, match=r"; `--client python` runs without it$"):
        runner.client_command("csharp", lessons.find("1"), PYTHON)


def test_a_changed_file_that_does_not_compile_is_not_hidden_by_another_client(monkeypatch, tmp_path):
    without_nuget(monkeypatch, tmp_path)
    monkeypatch.setattr(dotnet, "step", lambda *_: Result(1, "x: error CS1002: ; expected"))
    with pytest.raises(KitError, match="CS1002"):
        runner.client_command(None, lessons.find("1"), PYTHON)


def test_what_an_interrupted_build_has_left_is_built_anew_also_after_a_mistake(monkeypatch, tmp_path):
    """Where none was interrupted, a mistake costs no whole build."""
    without_nuget(monkeypatch, tmp_path)
    mistake, done = Result(1, "x: error CS1002: ; expected"), Result(0, "")
    ends = [mistake, mistake, done, mistake, mistake, KeyboardInterrupt, mistake, done]
    step = Mock(side_effect=ends)
    monkeypatch.setattr(dotnet, "step", step)
    for end in ends:
        with contextlib.nullcontext() if end is done else pytest.raises((KitError, KeyboardInterrupt)):
            dotnet.build(dotnet.NetMQ())
    whole = ["--no-incremental" in call.args[1] for call in step.mock_calls]
    assert whole == [True, True, True, False, False, False, True, True]


@pytest.mark.skipif(os.name == "nt", reason="Windows has its own place for each account")
def test_without_a_home_dotnet_has_one_in_the_kit():
    code = "from kitlib.setup import dotnet; print(dotnet.ENVIRONMENT['HOME'], dotnet.nuget_folder())"
    environment = {**os.environ, "HOME": "/nowhere", "NUGET_PACKAGES": ""}
    said = finished([PYTHON, "-c", code], cwd=ROOT, env=environment).stdout
    assert said == f"{lessons.BUILD} {lessons.BUILD / '.nuget' / 'packages'}\n"


def test_a_folder_may_have_any_name(netmq, copy):
    """MSBuild takes many signs for something else; a whole build in each folder would take minutes."""
    here = copy.rename(copy.with_name("O'Brien & Smith, John $(1)"))
    properties = [f"-p:Probe={dotnet.escaped(here / 'a;b%41')}", "-getProperty:Probe", "-getProperty:OutDir"]
    words = ["dotnet", "msbuild", here / "csharp-console", *properties]
    read = json.loads(finished(words, env={**os.environ, **dotnet.ENVIRONMENT}).stdout)["Properties"]
    assert read["Probe"] == str(here / "a;b%41")
    assert "'" not in read["OutDir"]


def test_a_client_in_csharp_needs_no_package_of_its_lesson(monkeypatch):
    monkeypatch.setattr(python_setup, "interpreter", None)
    monkeypatch.setattr(dotnet, "find_netmq", dotnet.NetMQ)
    monkeypatch.setattr(dotnet, "build", lambda _: Path("console.dll"))
    assert runner.client_command("csharp", lessons.find("9")) == ["dotnet", "console.dll", "09_environment"]


def test_doctor_names_each_thing_once(start):
    program = start(PYTHON, KIT, "doctor")
    assert program.wait(200) == 0, program.output
    named = [re.match(r"(?:ok|--)  (\S+(?: \S+)*) ", line)[1] for line in program.lines if line[:2] in ("ok", "--")]
    assert sorted(named) == sorted(set(named))
    assert {"Python", "pyzmq", "numpy", "body", ".NET SDK", "Mono", "ports"} <= set(named)
    # A lesson's port is named only if it is taken, here perhaps by another test.
    assert [line for line in program.lines if " port 55" in line and line.startswith("ok")] == []


def own_run(copy, python, *words):
    """The words that run lesson 01 in the copy."""
    return [python, copy / "kit.py", "run", "1", "--endpoint", "tcp://127.0.0.1:0", *words]


def test_no_first_line_sends_windows_to_another_python():
    """There `py kit.py` obeys it, and takes the first python3 on the PATH, of whatever program."""
    assert KIT.read_text(encoding="utf-8").startswith('"""')


def test_of_a_program_that_prints_without_end_the_last_lines_are_kept(start):
    program = start(PYTHON, "-c", "for number in range(30_000): print(number)")
    assert program.wait() == 0 and program.lines == [str(number) for number in range(10_000, 30_000)]


def test_server_and_client_are_the_halves_of_run(start):
    mark = Mark()
    everywhere = ["--endpoint", "tcp://0.0.0.0:0", "--open-to-anyone"]
    server = start(PYTHON, KIT, "server", "1", *everywhere, **mark.environment)
    assert re.search(r"--endpoint take instead (\d+\.|its address, which)", server.wait_for("^kit ").string)
    endpoint = server.wait_for(r"^listening on (\S+)")[1].replace("0.0.0.0", "127.0.0.1")
    client = start(PYTHON, KIT, "client", "1", "--client", "python", "--endpoint", endpoint, "--count", "3")
    assert client.wait(500) == 0, client.output
    assert client.lines[-1] == "done: 3 replies"
    refused = start(PYTHON, KIT, "client", "1", "--client", "python", "--cuont", "3")
    assert refused.wait() == 2
    server.stop(signal.SIGINT)
    assert "Traceback" not in server.output
    assert mark.processes() == {}


@finds_processes
def test_a_saved_answer_reaches_the_clients_that_run(prepared, start, serve):
    """After a mistake, too; and Ctrl-C leaves nothing."""
    path, endpoint = prepared / "python" / "04_background_client" / "server.py", steady_endpoint()
    text, mark = path.read_text(encoding="utf-8"), Mark()
    words = ["server", "4", "--reload", "--endpoint", endpoint]
    kit = start(PYTHON, prepared / "kit.py", *words, **mark.environment)
    kit.wait_for("^listening on")
    client = start(PYTHON, path.with_name("client.py"), "--endpoint", endpoint, "--count", "1000000")
    client.wait_for("received world$")
    path.write_text(text.replace("def answer", "def def answer"), encoding="utf-8")
    ended = "kit    | the server has ended; the next save starts it again, Ctrl-C ends this"
    kit.wait_for(f"^{re.escape(ended)}$")
    for word in ("moon", "sun"):
        # As many an editor saves: another file takes the old one's place.
        new = path.with_name("server.py.new")
        new.write_text(text.replace('"world"', f'"{word}"'), encoding="utf-8")
        new.replace(path)
        client.wait_for(f"received {word}$")
    client.kill()
    assert kit.stop(signal.SIGINT) == 130
    anew, ready, mistake = (
        "kit    | server.py saved: starting anew",
        f"listening on {endpoint}",
        f"kit    | {path}, line ",
    )
    story = [each for line in kit.lines for each in (anew, ready, ended, mistake) if line.startswith(each)]
    assert story == [ready, anew, mistake, ended, anew, ready, anew, ready], kit.output
    assert "Traceback" not in kit.output
    assert mark.processes() == {}
    serve("04_background_client", endpoint=endpoint)


@finds_processes
@pytest.mark.parametrize(
    ("killed", "timeout", "code", "name"), [("client", 300, 137, "client"), ("server", 2, 1, "server.py")]
)
def test_a_program_that_the_system_kills_is_named(killed, timeout, code, name, start):
    """Such as where the memory is full: it has no last line of its own."""
    mark, late = Mark(), ["--server=--delay 300", f"--options=--timeout {timeout}"]
    words = ["run", "1", "--client", "python", "--endpoint", "tcp://127.0.0.1:0", *late]
    kit = start(PYTHON, KIT, *words, **mark.environment)
    kit.wait_for(r"^client \| asking")
    (found,) = (number for number, command in mark.processes().items() if f"{killed}.py" in command)
    os.kill(found, signal.SIGKILL)
    assert kit.wait() == code
    assert f"kit    | {name} was ended by signal 9 (Killed); is the memory full?" in kit.lines


# A server prints what it did after the client has heard of it.
LATE_SERVER = """
import signal, sys, time
RUN = {"also": ["second.py --port 0"]}
def late(*_):
    print("sent b'World'", flush=True)
    sys.exit()
signal.signal(signal.SIGTERM, late)
print("listening on tcp://127.0.0.1:5551", flush=True)
time.sleep(60)
"""
SECOND = """
import pathlib, sys, time
print("told", *sys.argv[1:], flush=True)
pathlib.Path("second").touch()
time.sleep(600)
"""
CLIENT = """
import pathlib, time
while not pathlib.Path("second").exists():
    time.sleep(0.01)
print("1: sent Hello\\ndone: 1 replies")
"""


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGTERM")
def test_a_lesson_says_what_else_is_started_and_the_last_line_is_the_clients(prepared, start):
    lesson = prepared / "python" / "01_request_reply"
    for name, text in {"server": LATE_SERVER, "second": SECOND, "client": CLIENT}.items():
        (lesson / f"{name}.py").write_text(text, encoding="utf-8")
    program = start(PYTHON, prepared / "kit.py", "run", "1", "--client", "python")
    assert program.wait(120) == 0, program.output
    assert "second | told --port 0 --endpoint tcp://127.0.0.1:5551" in program.lines
    assert program.lines[-3:] == ["client | 1: sent Hello", "server | sent b'World'", "client | done: 1 replies"]
    (lesson / "server.py").write_text("import os; os.kill(os.getpid(), 9)", encoding="utf-8")
    program = start(PYTHON, prepared / "kit.py", "run", "1", "--client", "python")
    assert program.wait() == 1
    assert program.lines[-2:] == [
        "kit    | server was ended by signal 9 (Killed); is the memory full?",
        "kit    | the server ended before it was ready; the line above says why",
    ]


@pytest.mark.skipif(os.name == "nt", reason="Windows sends a Ctrl-C in another way")
@pytest.mark.parametrize(("module", "code"), [("kitlib.commands", -signal.SIGINT), ("kitlib.commands.list", 130)])
def test_ctrl_c_while_the_modules_load_shows_no_traceback(module, code):
    program = f"""
import os, runpy, signal, sys
class Moment:
    def find_spec(self, name, *_):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Moment())
sys.path.insert(0, {str(ROOT)!r})
sys.argv = ["kit.py", "list"]
runpy.run_path({str(KIT)!r}, run_name="__main__")
"""
    done = finished([PYTHON, "-c", program])
    assert (done.returncode, done.stdout, done.stderr) == (code, "", "")


def test_in_a_pipe_the_output_is_utf_8_on_every_system(start):
    """As on Windows, where a pipe has the encoding of the system."""
    program = start(PYTHON, KIT, "run", "grüße…", PYTHONIOENCODING="cp1252", PYTHONUTF8="0")
    assert program.wait() == 2
    assert "there is no lesson grüße…;" in program.output


def has_wheels():
    links = os.environ.get("PIP_FIND_LINKS", "")
    if not any(Path(links).glob("pyzmq-*.whl")):
        pytest.skip("no folder of wheels: PIP_FIND_LINKS names none with pyzmq")
    return Path(links)


def test_a_folder_that_cannot_be_written_to_is_named_in_one_line(netmq, copy, start):
    """The tests may be root's, who may write anywhere; a file in the folder's place stops even him."""
    (copy / ".build").write_text("", encoding="utf-8")
    for words, code in ((["--client", "csharp"], 1), ([], 0), (["--client", "python"], 0)):
        program = start(*own_run(copy, PYTHON, *words))
        assert program.wait(120) == code, program.output
        owner = "" if lessons.WINDOWS else f", which belongs to {(copy / '.build').owner()},"
        assert f"kit    | {copy / '.build'}{owner} cannot be written to: copy the kit" in program.output
        assert "Traceback" not in program.output


def test_a_package_is_there_if_it_can_be_imported_and_is_not_too_old(tmp_path, monkeypatch):
    """As on Debian 12: its websockets 10 has none of what we import."""
    for package, version, code in (("old_one", "10.4", ""), ("broken", "3.0", "import nothing_of_this_name")):
        (tmp_path / f"{package}-{version}.dist-info").mkdir()
        (tmp_path / f"{package}-{version}.dist-info" / "METADATA").write_text(f"Name: {package}\nVersion: {version}\n")
        (tmp_path / f"{package}.py").write_text(f"print('I talk')\n{code}\n")
    # One that has lost its files is a folder, and can be imported.
    (tmp_path / "emptied").mkdir()
    # The tests' own Python may be that of .venv, which is asked without PYTHONPATH.
    monkeypatch.setattr(python_setup, "VENV", tmp_path / ".venv")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    wanted = [
        "old_one>=9",
        "old_one>=10.4,<11",
        "old_one>=13",
        "old_one<10",
        "broken",
        "emptied",
        "absent",
        "pyzmq>=24",
    ]
    assert python_setup.lacking(PYTHON, wanted) == ["old_one", "old_one", "broken", "emptied", "absent"]


def without_nuget(monkeypatch, tmp_path, code=0):
    monkeypatch.setattr(dotnet, "BUILD", tmp_path)
    for name in ("LOCK", "RESTORED", "PACKAGES"):
        monkeypatch.setattr(dotnet, name, tmp_path / name.lower())
    monkeypatch.setattr(dotnet, "sdk", lambda: "10.0.100")
    monkeypatch.setattr(dotnet, "restore", lambda *_: Result(code, "error NU1301" * code))


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a command is named that tells it")
def test_who_holds_a_port_is_named():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        (holder,) = doctor.listeners(port)
        assert f"(process {os.getpid()})" in holder
        assert doctor.taken(port) == f"taken by {holder}; end it, or "
    assert doctor.listeners(port) == []


def test_a_run_leaves_its_files_in_a_folder_of_its_own(prepared, start, monkeypatch, tmp_path):
    """The guide's runs and a server with --folder write elsewhere."""
    monkeypatch.setattr(guide, "ROOT", prepared)
    guide.folder.cache_clear()
    assert "client | done: 2 replies" in guide.printed("2 --client python --options='--count 2'")
    folder = tmp_path / "new" / "folder"
    server = start(PYTHON, prepared / "kit.py", "server", "2", "--folder", folder, "--endpoint", "tcp://127.0.0.1:0")
    server.wait_for("^listening on ")
    server.stop()
    assert (folder / "lazy_pirate.sqlite3").exists() and not list(prepared.rglob("*.sqlite3*"))
    for balance in ("0", "2"):
        words = ["run", "2", "--client", "python", "--endpoint", "tcp://127.0.0.1:0", "--options=--count 2"]
        program = start(PYTHON, prepared / "kit.py", *words)
        assert program.wait(120) == 0, program.output
        assert f"server | journal lazy_pirate.sqlite3, balance {balance}" in program.lines
    assert list(prepared.rglob("*.sqlite3")) == [prepared / ".build" / "run" / "02" / "lazy_pirate.sqlite3"]


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_a_room_without_internet_runs_from_what_was_packed(copy, netmq, bare_python, tmp_path, start):
    links = has_wheels()
    if os.environ.get("PIP_NO_INDEX") and not any(links.glob("numpy-*.whl")):
        pytest.skip("no folder of wheels: PIP_FIND_LINKS names none with numpy")
    packed = start(PYTHON, copy / "kit.py", "pack", copy / "packages")
    assert packed.wait(500) == 0, packed.output
    names = " ".join(path.name.lower() for path in (copy / "packages").iterdir())
    for needed in ("pyzmq-", "numpy-", "pillow-", "netmq.", "asyncio.", "nacl.net.", "licences"):
        assert needed in names, names
    version = f"{sys.version_info[0]}.{sys.version_info[1]}"
    note = (copy / "packages" / f"READ_ME_{python_setup.HERE}_{version}.txt").read_text(encoding="utf-8")
    assert dotnet.INSTALLER in note
    nowhere = {"HTTPS_PROXY": "http://127.0.0.1:9", "HTTP_PROXY": "http://127.0.0.1:9", "NO_PROXY": ""}
    room = {**nowhere, "PIP_NO_INDEX": "", "PIP_FIND_LINKS": "", "NUGET_PACKAGES": str(tmp_path / "store")}
    program = start(*own_run(copy, bare_python), **room)
    assert program.wait(500) == 0, program.output
    assert program.lines[-1] == "client | done: 10 replies"
    assert "asking NuGet" not in program.output
    # An exercise can be tested there, too.
    tests = start(bare_python, copy / "kit.py", "test", "5", "--version", **room)
    assert tests.wait(500) == 0, tests.output
    assert f"kit    | testing with {copy / '.venv'}" in tests.output
    assert "pip found no" not in tests.output
