"""kit.py copy: what it writes runs there, imports nothing else of the kit, and overwrites nothing."""

from pathlib import Path

import pytest

from kitlib import commands, imports
from kitlib.commands import copy
from kitlib.lessons import KIT, KitError, UsageError, lessons
from kitlib.setup import python_setup
from kitlib.terminal import command
from tests.conftest import PYTHON
from tests.kit.test_collisions import outcomes
from tests.programs import ROOT, two_ports

# Whoever opens a file of the kit's Python is ended, in the programs that they start as well.
GUARD = f"""
import os, sys
def guard(event, values):
    if event == "open" and os.path.realpath(str(values[0])).startswith({str(ROOT / "python" / "x")[:-1]!r}):
        sys.stderr.write(f"{{values[0]}} is the kit's\\n")
        sys.stderr.flush()
        os._exit(99)
sys.addaudithook(guard)
"""


def copied(*words):
    return copy.do(commands.parse(copy, [str(word) for word in words]))


def test_a_copied_lesson_runs_elsewhere(tmp_path):
    """Every program starts, and one may need a package that is not here; a space in the folder's name is no matter."""
    (tmp_path / "sitecustomize.py").write_text(GUARD, encoding="utf-8")
    for lesson in lessons():
        folder = tmp_path / "my game" / lesson.key
        copied(lesson.key, folder)
        found = outcomes(tmp_path, folder, PYTHONPATH=str(tmp_path), PYTHONDONTWRITEBYTECODE="1")
        programs = {Path(name).name: said for name, said in found.items() if name.endswith(".py")}
        assert {"server.py", "client.py"} <= programs.keys()
        assert [said for said in programs.values() if said != "fine" and "needs" not in said] == [], lesson.key


@pytest.mark.parametrize("key", ["09_environment", "16_web_gateway"])
def test_a_copied_lesson_does_its_work_elsewhere(key, start, tmp_path):
    """Also with what functions import, and with the data beside the modules."""
    folder, other = tmp_path / "my game", tmp_path / "other"
    other.mkdir()
    (other / "sitecustomize.py").write_text(GUARD, encoding="utf-8")
    environment = {"folder": other, "PYTHONPATH": str(other), "PYTHONDONTWRITEBYTECODE": "1"}
    (lesson,) = [each for each in lessons() if each.key == key]
    behind = []
    for name, each in [*lesson.behind, ("", lesson)]:
        copied(each.key, folder)
        place = two_ports().replace("tcp", each.scheme)
        words = behind if each == lesson else []
        server = start(PYTHON, folder / each.key / "server.py", "--endpoint", place, *words, **environment)
        behind += [name, server.endpoints()["endpoint"]]
    words = [word for name, address in server.endpoints().items() for word in (f"--{name}", address)]
    client = start(PYTHON, folder / lesson.key / "client.py", *words, **environment)
    client.wait_for("^(?!asking|gave up)")
    assert "the kit's" not in server.output + client.output


@pytest.fixture
def small(tmp_path, monkeypatch):
    """A package and a lesson, made up: modules(name) has what the copy of a program with these lines holds."""
    monkeypatch.setattr(imports, "PYTHON", tmp_path)
    files = {
        "netmq_example/__init__.py": "",
        "netmq_example/one.py": "import os\n\n\ndef late():\n    import netmq_example.two\n",
        "netmq_example/two.py": "import nothing_of_the_kit",
        "netmq_example/envs/__init__.py": (
            "from netmq_example import one\n\nNAMES = ['netmq_example.envs.gym:Env']\n\n\n"
            "if TYPE_CHECKING:\n    from netmq_example.envs.gym import Env\n\n\n"
            "def __getattr__(name):\n    from netmq_example.envs.lazy import Lazy\n"
        ),
        "netmq_example/envs/lazy.py": "",
        "netmq_example/envs/gym.py": "class Env:\n    page = 'page.html'\n    why = 'there is no missing.html'",
        "netmq_example/envs/page.html": "",
        "netmq_example/envs/vector.py": "import json",
        "netmq_example/json.py": "",
        "01_lesson/beside.py": "",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")

    def modules(text):
        program = tmp_path / "01_lesson" / "program.py"
        program.write_text(text, encoding="utf-8")
        imports.read.cache_clear()
        return {name.removeprefix("netmq_example/") for name in copy.sources([program])} - {"01_lesson/program.py"}

    yield modules
    imports.read.cache_clear()


ONE, ENVS = {"__init__.py", "one.py", "two.py"}, {"envs/__init__.py"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("import json, zmq", set()),
        ("import beside", {"01_lesson/beside.py"}),
        # Also what a function imports, which is in two.
        ("from netmq_example.one import late", ONE),
        ("try:\n    from netmq_example import one\nexcept ImportError:\n    pass", ONE),
        # A folder on the way runs its __init__, and nothing needs what that has names for.
        ("from netmq_example.envs.vector import Any", ONE | ENVS | {"envs/vector.py"}),
        ("from netmq_example.envs import vector", ONE | ENVS | {"envs/vector.py"}),
        ("import netmq_example.envs", ONE | ENVS | {"envs/gym.py", "envs/page.html", "envs/lazy.py"}),
        # What its __init__ only lends is looked for where it is.
        ("from netmq_example.envs import Env", ONE | ENVS | {"envs/gym.py", "envs/page.html"}),
        ("WORLD = 'netmq_example.envs.vector:World'", ONE | ENVS | {"envs/vector.py"}),
        ("SAID = 'netmq_example.envs.vector and others'", set()),
    ],
)
def test_what_is_copied_is_read_from_the_imports(text, expected, small):
    assert small(text) == expected


def test_what_differs_stays_unless_it_is_forced(tmp_path, capsys):
    folder = tmp_path / "game"
    copied("1", folder)
    server, license = folder / "01_request_reply" / "server.py", folder / copy.LICENCE
    run = command(python_setup.found("01_request_reply"), server)
    assert capsys.readouterr().out.endswith(f"kit    | next: {run}\n")
    server.write_text("mine", encoding="utf-8")
    # Git may have changed the ends of the lines, which is no change.
    license.write_bytes(license.read_bytes().replace(b"\n", b"\r\n"))
    before = {path: path.read_bytes() for path in folder.rglob("*.*")}
    with pytest.raises(KitError, match=r"01_request_reply.server\.py in \S+ differs: nothing was copied; --force"):
        copied("1", folder)
    # Lesson 02 has the same licence beside it, and its programs are others.
    copied("2", folder)
    assert {path: path.read_bytes() for path in before} == before
    copied("1", folder, "--force")
    assert server.read_bytes() == (ROOT / "python" / "01_request_reply" / "server.py").read_bytes()
    assert not list(folder.glob(".netmqexample*"))


def test_the_last_line_starts_the_server_with_what_it_needs(tmp_path, monkeypatch, capsys):
    """By the kit, which installs it, where no Python has it yet."""
    monkeypatch.setattr(python_setup, "found", lambda *lessons: None if lessons else PYTHON)
    copied("5", tmp_path / "my game")
    server = command(tmp_path / "my game" / "05_messages" / "server.py")
    assert capsys.readouterr().out.endswith(f"needs: pyzmq, numpy\nkit    | next: {KIT} server {server}\n")


def test_what_is_in_the_way_is_named_and_nothing_is_written(tmp_path):
    (tmp_path / "one" / "netmq_example" / "check.py").mkdir(parents=True)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "netmq_example").write_text("")
    (tmp_path / "file").write_text("")
    before = sorted(tmp_path.rglob("*"))
    for folder, why in {
        "one": r"check\.py is a folder, and ",
        "other": "netmq_example is a file, and ",
        "file": "is a file: name a folder$",
        "file/x": "^could not write into ",
    }.items():
        with pytest.raises(KitError, match=why):
            copied("1", tmp_path / folder)
    assert sorted(tmp_path.rglob("*")) == before
    with pytest.raises(UsageError, match="it is empty: name a folder"):
        copied("1", "")


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["99"], "^there is no lesson 99; there are: "),
        (["netmq_example."], "^there is no module netmq_example.; "),
        (["netmq_example.nothing"], "^there is no module netmq_example.nothing; "),
        (["netmq_example", "--csharp"], "^--csharp is for a lesson: leave it out, netmq_example is Python$"),
    ],
)
def test_what_there_is_not_is_said(words, why, tmp_path):
    with pytest.raises(KitError, match=why):
        copied(*words, tmp_path / "new")
    assert not list(tmp_path.iterdir())


def test_a_module_or_a_folder_of_the_package_is_copied(tmp_path, capsys):
    copied("netmq_example.messages", tmp_path)
    assert capsys.readouterr().out.endswith("kit    | needs: pyzmq\n")
    assert (tmp_path / "netmq_example" / "messages.py").exists()
    assert not (tmp_path / "netmq_example" / "envs").exists()
    assert not (tmp_path / "netmq_example" / "py.typed").exists()
    copied("netmq_example.envs", tmp_path)
    assert capsys.readouterr().out.endswith("kit    | needs: pyzmq, numpy, gymnasium, pettingzoo\n")
    assert {path.name for path in (tmp_path / "netmq_example" / "envs").iterdir()} == {
        path.name for path in (ROOT / "python" / "netmq_example" / "envs").glob("*.py")
    }

    copied("netmq_example", tmp_path)
    assert (tmp_path / "netmq_example" / "py.typed").exists()


def test_the_csharp_side_is_read_from_its_sources(tmp_path, capsys):
    """test_without_unity.py compiles all of it."""
    copied("1", tmp_path, "--csharp")
    found = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.cs")}
    # No component, and nothing of other lessons.
    assert {"01_request_reply/HelloRequester.cs", "Shared/NetMQLifetime.cs"} <= found
    assert {name.split("/")[0] for name in found} == {"01_request_reply", "Shared"}
    assert not {"01_request_reply/HelloClient.cs", "Shared/NetworkBehaviour.cs"} & found
    assert len(found) <= 6, "a first client stands on five files"
    assert "kit    | needs: NetMQ; " in capsys.readouterr().out
    copied("16", tmp_path, "--csharp")
    # It has no ZeroMQ. What is for browsers alone, a DLL of JavaScript, stays away.
    assert "kit    | needs: Newtonsoft.Json; " in capsys.readouterr().out
    assert not (tmp_path / "16_web_gateway" / "BrowserConnection.cs").exists()
