"""The house rules that a program can check: linters, sizes, and the same names in every tree."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from kitlib.lessons import lessons
from kitlib.setup import dotnet, python_setup
from tests.programs import ROOT

UNITY = ROOT / "unity" / "Assets" / "NetMQExample"


def check(*command, **options):
    done = subprocess.run(
        [str(word) for word in command], cwd=ROOT, capture_output=True, text=True, timeout=300, **options
    )
    assert done.returncode == 0, done.stdout + done.stderr


def needs_tool(name):
    need = python_setup.requirement(name)
    if not python_setup.has(sys.executable, [need]):
        pytest.skip(f'another version of {name}, or none: pip install "{need}"')


@pytest.mark.parametrize("how", [["check"], ["format", "--check"]], ids=["check", "format"])
def test_ruff(how):
    needs_tool("ruff")
    check(sys.executable, "-m", "ruff", *how, "kit.py", "kitlib", "lab", "python", "tests")


MYPY = [
    ["kit.py", *sorted((ROOT / "kitlib").rglob("*.py")), *sorted((ROOT / "lab").glob("*.py"))],
    sorted((ROOT / "lab" / "contenders").glob("*.py")),
    # One folder at a time: every lesson has a server.py, and to mypy they would be one module.
    *(sorted(folder.glob("*.py")) for folder in sorted((ROOT / "python").iterdir()) if any(folder.glob("*.py"))),
    sorted((ROOT / "tests").rglob("*.py")),
]


@pytest.mark.parametrize("files", MYPY, ids=lambda files: Path(files[-1]).parent.name)
def test_mypy(files, tmp_path):
    needs_tool("mypy")
    # Mypy's cache of an earlier run can hide that a package has no types; and it knows the functions of one system.
    flags = ["--platform", "linux", "--explicit-package-bases"]
    check(sys.executable, "-m", "mypy", *flags, "--cache-dir", tmp_path, *files)


PROJECTS = [path for tree in ("csharp-*", "lab", "tests") for path in ROOT.glob(f"{tree}/**/*.csproj")]


@pytest.mark.timeout(600)
def test_dotnet_format(console, engine, tmp_path):
    """Every C# project of the solution, in one that every SDK reads: those before 9 do not read .slnx."""
    env = {**os.environ, **dotnet.ENVIRONMENT}
    projects = re.findall(r'Project Path="([^"]+)"', (ROOT / "NetMQExample.slnx").read_text(encoding="utf-8"))
    assert sorted(projects) == sorted(path.relative_to(ROOT).as_posix() for path in PROJECTS)
    check("dotnet", "new", "sln", "--output", tmp_path, env=env)
    check("dotnet", "sln", tmp_path, "add", *projects, env=env)
    check("dotnet", "restore", tmp_path, *engine.properties, env=env)
    check("dotnet", "format", tmp_path, "--verify-no-changes", "--no-restore", env=env)


def code_lines(path):
    """The lines that do something: no blank ones, comments, docstrings, imports, usings, or lone braces."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        lines = text.splitlines()
        for node in ast.walk(ast.parse(text)):
            if isinstance(
                node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
            ) and ast.get_docstring(node):
                first, last = node.body[0].lineno - 1, node.body[0].end_lineno
                lines[first:last] = [""] * (last - first)
        return [line for line in lines if line.strip() and not line.strip().startswith(("#", "import ", "from "))]
    return [line for line in text.splitlines() if not re.fullmatch(r"\s*((//|using [\w.= ]+;).*|[{}();,]*)", line)]


def limit(path):
    """A MonoBehaviour has about 60 lines, a console twin 30, a class to take home 120.

    A server has about 60 too, and 35 more that keep it alive among bad peers.
    """
    if path.parent.name == "csharp-console":
        return 30
    if path.name == "server.py":
        return 95
    component = re.search(r": (Mono|Network)Behaviour\b", path.read_text(encoding="utf-8"))
    return 60 if component else 120


LESSON_FILES = [
    path
    for lesson in lessons()
    for path in [*lesson.python.glob("*.py"), *lesson.unity.glob("*.cs"), lesson.twin]
    if path.exists()
]


@pytest.mark.parametrize("path", LESSON_FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_lesson_stays_short(path):
    # "About" is a quarter more.
    assert len(code_lines(path)) <= 1.25 * limit(path), "split the idea in two"


@pytest.mark.parametrize("lesson", lessons(), ids=lambda lesson: lesson.key)
def test_a_lesson_is_whole(lesson):
    """The same key in every tree."""
    assert (lesson.python / "client.py").exists()
    assert list(lesson.unity.glob("*.cs"))
    assert lesson.twin.exists()
    assert lesson.guide.exists()
    assert "\n```mermaid\nsequenceDiagram\n" in lesson.guide.read_text(encoding="utf-8")
    assert (ROOT / "tests" / "lessons" / f"test_{lesson.key}.py").exists()


def tracked():
    if not shutil.which("git") or not (ROOT / ".git").exists():
        pytest.skip("not a git checkout")
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip(f"git does not list the files: {listed.stderr.splitlines()[0]}")
    return [ROOT / name for name in listed.stdout.split("\n") if name and (ROOT / name).exists()]


def test_no_binary_and_no_path_of_somebodys_machine_is_in_the_repository():
    for path in tracked():
        assert path.suffix not in {".dll", ".so", ".dylib", ".nupkg", ".whl", ".exe"}, path
        if path.suffix != ".png":
            text = path.read_text(encoding="utf-8")
            assert not re.search(r"/(home|Users)/\w+/|[A-Z]:\\\\Users", text) or path == Path(__file__), path
            assert text.endswith("\n") or not text, f"{path}: no newline at the end"
