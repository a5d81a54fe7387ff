"""The package's folder Editor, against a stand-in of UnityEditor: buttons are pressed, Python servers really start."""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.programs import ROOT, Mark, finds_processes, steady_port
from tests.unity.conftest import Editor

# They share what was built.
pytestmark = pytest.mark.xdist_group("player")
WINDOW = "menu Tools/NetMQ Example/Lessons"


def test_the_stand_in_has_unitys_signatures(editor_dll: Path) -> None:
    """tests/unity/unity_editor_api.txt says for each type where Unity's published reference declares it."""
    dump = Editor(["dotnet", str(editor_dll)], ROOT)
    lines = dump.do("api")
    dump.do("quit")
    facts = (ROOT / "tests" / "unity" / "unity_editor_api.txt").read_text(encoding="utf-8").splitlines()
    facts = [line.rstrip() for line in facts if line and not line.startswith("#")]
    types = [line for line in facts if not line.startswith(" ")]
    assert all(re.fullmatch(r"\w+ [\w.`+]+( : \w+)?    \S+\.cs( \S+\.cs)*", line) for line in types)
    assert [line.rstrip() for line in lines] == [
        line if line.startswith(" ") else line.split("    ")[0] for line in facts
    ]


@finds_processes
@pytest.mark.parametrize("runtime", ["dotnet", "mono"])
def test_a_server_outlives_a_reload_and_ends_with_the_editor(
    runtime: str, editor: Callable[..., Editor], project: Path
) -> None:
    mark = Mark()
    unity = editor(project, runtime, **mark.environment)
    unity.do(WINDOW)
    unity.do(f"folder {ROOT}")
    unity.do("press Choose the kit's folder")
    unity.do("type Lesson=02_lazy_pirate")
    unity.do(f"type Options of its server=--endpoint tcp://127.0.0.1:{steady_port()}")
    assert "[Stop the server]" not in unity.do("draw")
    unity.do("press Start the server")
    unity.draw_until("^listening on tcp://127.0.0.1:")
    # Recompiled scripts: what was in static fields is gone, and what was in pipes.
    unity.do("load")
    drawn = unity.do("draw")
    assert "[Stop the server]" in drawn and any(line.startswith("listening on") for line in drawn)

    def servers() -> list[str]:
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


def test_doctor_is_a_button(editor: Callable[..., Editor], project: Path) -> None:
    unity = editor(project)
    unity.do(WINDOW)
    unity.do(f"folder {ROOT}")
    unity.do("press Choose the kit's folder")
    unity.do("press Run doctor")
    unity.draw_until(r"^(ok|--)  Python ")
    unity.do("quit")


def test_without_the_kit_the_window_says_where_the_servers_are(editor: Callable[..., Editor], project: Path) -> None:
    unity = editor(project)
    unity.do(WINDOW)
    drawn = unity.do("draw")
    assert drawn[0].startswith("Warning: The Python servers are not in this project") and "kit.py" in drawn[0]
    assert drawn[1:] == ["[Choose the kit's folder]"]
    unity.do(f"folder {project}")
    assert unity.do("press Choose the kit's folder") == drawn, "there is no kit.py either"


def test_a_python_without_pyzmq_is_named_with_its_cure(
    editor: Callable[..., Editor], project: Path, tmp_path: Path
) -> None:
    """A kit without .venv, and on the PATH one Python, without packages."""
    kit = tmp_path / "kit"
    (kit / "python" / "05_messages").mkdir(parents=True)
    for name in ("kit.py", "pyproject.toml", "python/05_messages/server.py"):
        shutil.copy(ROOT / name, kit / name)
    bare = tmp_path / "bare"
    bare.mkdir()
    python = bare / "python3"
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" -I -S "$@"\n', encoding="utf-8")
    python.chmod(0o755)
    unity = editor(project, str(shutil.which("dotnet")), PATH=str(bare))
    unity.do(WINDOW)
    unity.do(f"folder {kit}")
    unity.do("press Choose the kit's folder")
    unity.do("press Start the server")
    (error,) = [line for line in unity.do("draw") if line.startswith("Error:")]
    assert error.startswith("Error: python3 has no pyzmq: run the pip line in a terminal; or kit.py run 1")
    unity.do("press Copy the pip line")
    assert unity.do("clipboard") == ['"python3" -m pip install "pyzmq>=24" "numpy>=1.24"']
    python.unlink()
    unity.do("press Start the server")
    (error,) = [line for line in unity.do("draw") if line.startswith("Error:")]
    assert "no Python 3.11 or later" in error and "python.org" in error


def test_a_scene_is_opened_where_unity_opens_scenes(editor: Callable[..., Editor], project: Path) -> None:
    unity = editor(project)
    unity.do(WINDOW)
    unity.do(f"folder {ROOT}")
    unity.do("press Choose the kit's folder")
    unity.do("type Lesson=03_publish_subscribe")
    opened = "opened Assets/NetMQExample/03_publish_subscribe/03_publish_subscribe.unity"
    assert opened in unity.do("press Open its scene")
    # A package is read-only.
    (project / "Packages").mkdir()
    (project / "Packages" / "com.netmqexample.lessons").symlink_to(project / "Assets" / "NetMQExample")
    unity.do("package Packages/com.netmqexample.lessons")
    assert "[Open its scene]" not in unity.do("draw")


def test_in_the_kits_own_project_the_servers_are_found(editor: Callable[..., Editor]) -> None:
    unity = editor(ROOT / "unity")
    unity.do(WINDOW)
    assert "Lesson: 01_request_reply" in unity.do("draw")
