"""The package's folder Editor, against a stand-in of UnityEditor: buttons are pressed, Python servers really start."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.programs import ROOT, Mark, finds_processes, steady_endpoint
from tests.unity.conftest import NEAREST, PACKAGE

# They share what was built.
pytestmark = pytest.mark.xdist_group("player")
WINDOW = "menu Tools/NetMQ Example/Lessons"
# Where the kit has no .venv, the window takes the first python3: here that of the tests, which has what they need.
OURS = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"


def choose(unity, kit=ROOT):
    """The window opens, and is told where the kit is: what it then draws."""
    unity.do(WINDOW)
    unity.do(f"folder {kit}")
    return unity.do("press Choose the kit's folder")


def test_what_is_for_the_editor_alone_needs_no_more_than_net_framework():
    """Unity compiles them against it by default (Player Settings, Editor Assemblies Compatibility Level), the tests do
    against .NET Standard 2.1. So here is what the kit uses elsewhere, and .NET Framework 4.8 lacks."""
    lacking = re.compile(
        r"\bAsSpan|\.Span\b|\bSpan<|ReadOnlySpan|\.TryDequeue|\.TryPeek|GetValueOrDefault|Array\.Fill|Math\.Clamp|HashCode"
    )
    for path in [*(PACKAGE / "Editor").glob("*.cs"), *(PACKAGE / "Tests" / "EditMode").glob("*.cs")]:
        code = re.sub(r"//.*", "", path.read_text(encoding="utf-8"))
        assert not lacking.search(code), path
        # There a MatchCollection is no IEnumerable<Match>.
        assert code.count(".Matches(") == code.count(".Cast<Match>()"), path


@finds_processes
def test_a_server_outlives_a_reload_and_ends_with_the_editor(editor, project):
    mark = Mark()
    unity = editor(project, **mark.environment, PATH=OURS)
    choose(unity)
    unity.do("type Lesson=02_lazy_pirate")
    unity.do(f"type Options of its server=--endpoint {steady_endpoint()}")
    assert "[Stop the server]" not in unity.do("draw")
    unity.do("press Start the server")
    unity.draw_until("^listening on tcp://127.0.0.1:")
    # Recompiled scripts: what was in static fields is gone, and what was in pipes.
    unity.do("load")
    drawn = unity.do("draw")
    assert "[Stop the server]" in drawn and any(line.startswith("listening on") for line in drawn)

    def servers():
        return [command for command in mark.processes().values() if "server.py" in command]

    assert len(servers()) == 1
    unity.do("press Stop the server")
    assert servers() == []
    drawn = unity.do("draw")
    assert "[Start the server]" in drawn and any(line.startswith("listening on") for line in drawn)
    # The port is free again, at once.
    unity.do("press Start the server")
    unity.draw_until("^listening on tcp://127.0.0.1:")
    unity.do("quit")
    assert servers() == []


@finds_processes
def test_the_next_editor_finds_the_server_of_one_that_crashed(editor, project):
    mark = Mark()

    def servers():
        return [number for number, command in mark.processes().items() if "server.py" in command]

    try:
        crashed = editor(project, **mark.environment, PATH=OURS)
        choose(crashed)
        crashed.do(f"type Options of its server=--endpoint {steady_endpoint()}")
        # A double click.
        crashed.do("twice Start the server")
        crashed.draw_until("^listening on tcp://127.0.0.1:")
        assert len(servers()) == 1
        crashed.program.kill()
        unity = editor(project)
        drawn = choose(unity) + unity.do("draw")
        assert "[Stop the server]" in drawn and any(line.startswith("listening on") for line in drawn)
        unity.do("quit")
        assert servers() == []
    finally:
        for number in servers():
            os.kill(number, signal.SIGKILL)


def test_another_program_with_the_servers_number_is_left_alone(editor, project):
    """Numbers are given again; and a note may be cut short."""
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as other:
        folder = project / "Library" / "NetMQExample"
        folder.mkdir(parents=True)
        (folder / "server.log").touch()
        unity = editor(project)
        choose(unity)
        for note in (f"{other.pid} 639000000000000000", f"{other.pid} 0", f"{other.pid}", "", "x y"):
            (folder / "server.log.pid").write_text(note)
            unity.do("load")
            assert "[Start the server]" in unity.do("draw")
        unity.do("quit")
        assert other.poll() is None
        other.communicate(b"\n")
        assert other.returncode == 0


def test_a_server_speaks_also_where_a_program_is_given_no_output(editor, project, tmp_path):
    """As on Windows, where a program with windows has none that it could hand on; and in folders of any name."""
    kit, bare, game = (tmp_path / f"über all ({name})" for name in ("kit", "bare", "game"))
    game.mkdir()
    (project / "Assets").rename(game / "Assets")
    for folder in ("01_request_reply", "netmq_example"):
        shutil.copytree(ROOT / "python" / folder, kit / "python" / folder)
    shutil.copy(ROOT / "kit.py", kit)
    bare.mkdir()
    python = bare / "python3"
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@" >&- 2>&-\n', encoding="utf-8")
    python.chmod(0o755)
    unity = editor(game, str(shutil.which(NEAREST)), PATH=f"{bare}:{os.environ['PATH']}")
    choose(unity, kit)
    unity.do("type Options of its server=--endpoint tcp://127.0.0.1:0")
    unity.do("press Start the server")
    unity.draw_until("^listening on tcp://127.0.0.1:")
    unity.do("press Stop the server")
    unity.do("type Options of its server=--endpoint x")
    unity.do("press Start the server")
    unity.draw_until("argument --endpoint: bad endpoint 'x'")
    if NEAREST == "mono":
        # As Unity is. .NET closes a quotation mark by itself.
        unity.draw_until(r"^\[Start the server\]$")
        unity.do('type Options of its server=--endpoint "x')
        unity.do("press Start the server")
        said = 'Error: could not start with the options --endpoint "x: is each " and \' closed?'
        assert said in unity.do("draw")
    unity.do("quit")


def test_without_the_kit_the_window_says_where_the_servers_are(editor, project):
    unity = editor(project, PATH=OURS)
    unity.do(WINDOW)
    drawn = unity.do("draw")
    assert drawn[0].startswith("Warning: The Python servers are not in this project") and "kit.py" in drawn[0]
    assert drawn[1:] == ["[Choose the kit's folder]"]
    unity.do(f"folder {project}")
    assert unity.do("press Choose the kit's folder") == drawn, "there is no kit.py either"
    # A kit.py alone is no kit.
    (project / "kit.py").touch()
    unity.do("press Choose the kit's folder")
    assert unity.do("draw") == drawn
    (project / "python").mkdir()
    unity.do("press Choose the kit's folder")
    assert unity.do("draw") == drawn
    (project / "python" / "01_request_reply").mkdir()
    (project / "python" / "01_request_reply" / "server.py").touch()
    (project / "kit.py").write_text("import sys\nprint('this is', sys.argv[1])\n")
    unity.do("press Choose the kit's folder")
    unity.do("press Run doctor")
    unity.draw_until("^this is doctor$")


def test_a_python_without_pyzmq_is_named_with_its_cure(editor, project, tmp_path):
    """A kit without .venv, and on the PATH one Python, without packages."""
    kit = tmp_path / "kit"
    for key in ("05_messages", "20_body_tracking"):
        (kit / "python" / key).mkdir(parents=True)
        shutil.copy(ROOT / "python" / key / "server.py", kit / "python" / key)
    for name in ("kit.py", "pyproject.toml"):
        shutil.copy(ROOT / name, kit / name)
    bare = tmp_path / "bare"
    bare.mkdir()
    python = bare / "python3"
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" -I -S "$@"\n', encoding="utf-8")
    python.chmod(0o755)
    unity = editor(project, str(shutil.which(NEAREST)), PATH=str(bare))
    choose(unity, kit)
    unity.do("press Start the server")
    (error,) = [line for line in unity.do("draw") if line.startswith("Error:")]
    assert error.startswith("Error: python3 has no pyzmq: run the pip line in a terminal; or kit.py run 1")
    unity.do("press Copy the pip line")
    assert unity.do("clipboard") == [f'python3 -m pip install "{kit}[camera,envs,web]"']
    # And what its webcam needs.
    unity.do("type Lesson=20_body_tracking")
    unity.do("press Copy the pip line")
    assert unity.do("clipboard") == [f'python3 -m pip install "{kit}[camera,envs,web,body]"']
    python.unlink()
    unity.do("press Start the server")
    (error,) = [line for line in unity.do("draw") if line.startswith("Error:")]
    assert "no Python 3.11 or later" in error and "python.org" in error


def test_a_scene_is_opened_where_unity_opens_scenes(editor, project):
    unity = editor(project)
    choose(unity)
    unity.do("type Lesson=03_publish_subscribe")
    opened = "opened Assets/NetMQExample/03_publish_subscribe/03_publish_subscribe.unity"
    assert opened in unity.do("press Open its scene")
    # A package is read-only.
    (project / "Packages").mkdir()
    (project / "Packages" / "com.netmqexample.lessons").symlink_to(project / "Assets" / "NetMQExample")
    unity.do("package Packages/com.netmqexample.lessons")
    for _ in range(2):
        assert "opened Assets/NetMQExample scenes/03_publish_subscribe.unity" in unity.do("press Open its scene")
    copy = project / "Assets" / "NetMQExample scenes" / "03_publish_subscribe.unity"
    assert copy.read_bytes() == (PACKAGE / "03_publish_subscribe" / "03_publish_subscribe.unity").read_bytes()


def test_in_the_kits_own_project_the_servers_are_found(editor):
    unity = editor(ROOT / "unity")
    unity.do(WINDOW)
    assert "Lesson: 01_request_reply" in unity.do("draw")
