"""kit.py copy: what it writes runs there, imports nothing else of the kit, and overwrites nothing."""

import ast
from pathlib import Path

import pytest

from kitlib import commands, imports
from kitlib.commands import copy
from kitlib.lessons import KitError, UsageError, lessons
from kitlib.setup import python_setup
from kitlib.terminal import command
from tests.conftest import PYTHON
from tests.kit.test_collisions import outcomes
from tests.programs import ROOT, finished

# This ends a program that opens a file of the kit's Python, and so it does each that one starts.
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
    folders = {lesson.key: tmp_path / "my game" / lesson.key for lesson in lessons()}
    for key, folder in folders.items():
        copied(key, folder)
    found = outcomes(tmp_path, *folders.values(), PYTHONPATH=str(tmp_path), PYTHONDONTWRITEBYTECODE="1")
    for key, folder in folders.items():
        programs = {Path(name).name: said for name, said in found.items() if Path(name).is_relative_to(folder)}
        assert {"server.py", "client.py"} <= programs.keys()
        assert [said for said in programs.values() if said != "fine" and "needs" not in said] == [], key
    # A copy has the imports of a function, and a page that a program sends.
    assert (folders["05_messages"] / "netmq_example" / "former.py").exists()
    assert (folders["16_web_gateway"] / "netmq_example" / "tap" / "tap.html").exists()


def test_a_journal_that_a_server_has_left_is_not_copied(tmp_path):
    (tmp_path / "server.py").write_text('NAMES = "journal.sqlite3", "page.html"\n', encoding="utf-8")
    for name in "journal.sqlite3", "page.html":
        (tmp_path / name).touch()
    assert imports.data([tmp_path / "server.py"]) == [tmp_path / "page.html"]


OF_A_READER = """
import gymnasium, netmq_example, sys
id, launch = "netmq_example.envs:NetMQExample/CartPole-v0", [sys.executable, "09_environment/client.py"]
with gymnasium.make(id, launch=launch) as made:
    made.reset()
    assert made.step(1)[1] == 1
print(netmq_example.__all__)
from netmq_example import {}
gymnasium.make_vec("NetMQExample/CartPole-v0", 2)
"""


def test_a_door_of_a_copy_leads_to_what_is_there(tmp_path):
    """Another copy into the same folder opens it further, and takes no change of a reader's for one of its own."""
    door = tmp_path / "netmq_example" / "__init__.py"
    program = tmp_path / "mine.py"

    def said(name):
        program.write_text(OF_A_READER.format(name), encoding="utf-8")
        done = finished([PYTHON, program], cwd=tmp_path)
        return done.stdout.splitlines()[-1], done.stderr.splitlines()[-1]

    copied("9", tmp_path)
    closed = door.read_bytes()
    copied("netmq_example.publisher", tmp_path)
    names = ["Closed", "Error", "Lost", "Message", "MessageError", "Publisher", "Refused", "Timeout"]
    found, error = said("Publisher, Message")
    assert set(names) < set(ast.literal_eval(found)) and "Server" not in found
    assert error.startswith("AttributeError: UnityVectorEnv is not in this copy; kit.py copy netmq_example FOLDER")
    assert said("Server")[1].startswith("ImportError: cannot import name 'Server' from 'netmq_example'")
    copied("9", tmp_path)
    assert said("Publisher")[0] == found
    door.write_bytes(closed)
    with pytest.raises(KitError, match=r"__init__\.py in .* differs: nothing was copied"):
        copied("netmq_example.publisher", tmp_path)
    copied("netmq_example", tmp_path, "--force")
    assert door.read_bytes() == (ROOT / "python" / "netmq_example" / "__init__.py").read_bytes()


def test_what_differs_stays_unless_it_is_forced(tmp_path, capsys):
    folder = tmp_path / "game"
    copied("1", folder)
    server, license = folder / "01_request_reply" / "server.py", folder / copy.LICENCE
    run = command(python_setup.found("01_request_reply"), server)
    assert capsys.readouterr().out.endswith(f"kit    | next: {run}\n")
    server.write_text("mine", encoding="utf-8")
    # Git may have changed the ends of the lines, which is no change.
    license.write_bytes(license.read_bytes().replace(b"\n", b"\r\n"))
    # But for the front door, which leads to more then.
    before = {path: path.read_bytes() for path in folder.rglob("*.*") if path.name != "__init__.py"}
    with pytest.raises(KitError, match=r"01_request_reply.server\.py in \S+ differs: nothing was copied; --force"):
        copied("1", folder)
    # Lesson 02 has the same licence beside it, and its programs are others.
    copied("2", folder)
    assert {path: path.read_bytes() for path in before} == before
    copied("1", folder, "--force")
    assert server.read_bytes() == (ROOT / "python" / "01_request_reply" / "server.py").read_bytes()
    assert not list(folder.glob(".netmqexample*"))


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
