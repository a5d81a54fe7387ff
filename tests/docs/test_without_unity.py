"""The page "Using it without Unity": its programs are built and run as they stand there, with the files it names."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess

import pytest

from kitlib.docs import guide
from kitlib.lessons import lessons
from kitlib.setup import dotnet, lock
from tests.conftest import PYTHON
from tests.programs import ROOT, finished

PAGE = ROOT / "docs" / "guide" / "without_unity.md"
PACKAGE = ROOT / "unity" / "Assets" / "NetMQExample"
LIBZMQ_ENGINE = ROOT / "csharp-support" / "libzmq-engine" / "NetMQ.csproj"


def program(language):
    """The page's one program in a language."""
    (found,) = [block for block in guide.blocks(PAGE) if block.language == language]
    return found.body


def table():
    """Each lesson's key, with the C# files, the Python files and the server's files to take."""
    rows = re.findall(
        r"^\| \[\d\d\]\((\d\d_\w+)\.md\) \|(.*)\|(.*)\|(.*)\|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE
    )
    return [(key, *(re.findall(r"`(\w+\.\w+)`", cell) for cell in cells)) for key, *cells in rows]


def scripts(names):
    return [next(PACKAGE.glob(f"*/{name}")) for name in names]


def test_the_table_has_every_lesson():
    assert [row[0] for row in table()] == [lesson.key for lesson in lessons()]


@pytest.mark.parametrize("row", table(), ids=lambda row: row[0])
def test_the_files_to_take_need_no_others(row):
    key, csharp, client, server = row
    scripts_of_the_kit = [*PACKAGE.glob("[0-9]*/*.cs"), *PACKAGE.glob("Shared/*.cs")]
    others = {path.stem for path in scripts_of_the_kit} - {name.removesuffix(".cs") for name in csharp}
    for path in scripts(csharp):
        code = re.sub(r"//.*", "", path.read_text(encoding="utf-8"))
        # What is for Unity alone is not compiled elsewhere.
        code = re.sub(r"#if UNITY_.*?#endif", "", code, flags=re.DOTALL)
        assert "UnityEngine" not in code, path.name
        assert not [name for name in others if re.search(rf"(?<![\w.]){name}\b", code)], path.name
    folder = ROOT / "python" / key
    for names in (client, server):
        for name in names:
            # An earlier lesson's, where this one has none of that name.
            path = folder / name if (folder / name).exists() else next(ROOT.glob(f"python/*/{name}"))
            nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            used = {f"{node.module}.py" for node in nodes if isinstance(node, ast.ImportFrom)}
            assert not [other for other in used - set(names) if (folder / other).exists()], name


PYTHON_FILES = [path for lesson in lessons() for path in sorted(lesson.python.glob("*.py"))]


@pytest.mark.parametrize(
    "path",
    [path for path in PYTHON_FILES if "Take home" in path.read_text(encoding="utf-8")],
    ids=lambda path: str(path.relative_to(ROOT)),
)
def test_what_a_header_says_to_take_home_runs_there(path, tmp_path):
    """A file with the others that the sentence names, and nothing else, in an empty folder: each is imported there."""
    text = path.read_text(encoding="utf-8")
    said = re.search(r"Take home: (.*?)\.(\s|$)", ast.get_docstring(ast.parse(text)), re.DOTALL)[1]
    for name in {path.name, *re.findall(r"\w+\.py", said)}:
        # An earlier lesson's, where this one has none of that name.
        earlier = ROOT.glob(f"python/*/{name}")
        shutil.copy(path.parent / name if (path.parent / name).exists() else next(earlier), tmp_path)
    for package in "numpy", "gymnasium", "ray":
        if any(re.search(rf"(import|from) {package}\b", copied.read_text("utf-8")) for copied in tmp_path.glob("*.py")):
            pytest.importorskip(package, reason=f"it needs {package}: pip install {package}")
    code = "import " + ", ".join(copied.stem for copied in tmp_path.glob("*.py"))
    done = finished([PYTHON, "-c", code], cwd=tmp_path)
    assert done.returncode == 0, done.stderr


def test_the_dotnet_program_builds_and_runs(tmp_path, engine, console, serve):
    """With every C# file of the table beside it, so that all of them are seen to compile without Unity."""
    project = tmp_path / "MyProgram.csproj"
    text = program("xml")
    if engine.name == "libzmq":
        text = re.sub(r'<PackageReference Include="NetMQ".*/>', f'<ProjectReference Include="{LIBZMQ_ENGINE}" />', text)
    if engine.offline:
        # Where NuGet is away, the SDK's own copy, as the kit's projects have it.
        own = '<Reference Include="Newtonsoft.Json" HintPath="$(MSBuildToolsPath)/Newtonsoft.Json.dll" />'
        text = re.sub(r'<PackageReference Include="Newtonsoft.Json".*/>', own, text)
    project.write_text(text, encoding="utf-8")
    (tmp_path / "Program.cs").write_text(program("csharp"), encoding="utf-8")
    for path in {path for _, csharp, _, _ in table() for path in scripts(csharp)}:
        shutil.copy(path, tmp_path)
    # A mirror of NuGet may have what NetMQ brings along in newer versions only: NU1603.
    words = ["-warnaserror", "-p:NoWarn=NU1603", "-o", tmp_path / "out"]
    command = ["dotnet", "build", project, *engine.properties, *words]
    environment = {**os.environ, **dotnet.ENVIRONMENT}
    # The engine's project is the kit's, and another test's build may have one with other properties.
    with lock.locked(dotnet.LOCK):
        done = subprocess.run(command, capture_output=True, text=True, timeout=500, env=environment)
    assert done.returncode == 0, done.stdout
    _, endpoint = serve("01_request_reply")
    done = finished(["dotnet", tmp_path / "out" / "MyProgram.dll", endpoint])
    assert done.stdout == "World\n", done.stdout + done.stderr


def test_the_python_program_runs(tmp_path, serve):
    pytest.importorskip("numpy")
    # A busy machine may need longer for the first reply than the page's program waits.
    patient = program("python").replace("poll(2500)", "poll(60_000)")
    (tmp_path / "program.py").write_text(patient, encoding="utf-8")
    for name in next(client for key, _, client, _ in table() if key == "05_messages"):
        shutil.copy(ROOT / "python" / "05_messages" / name, tmp_path)
    _, endpoint = serve("05_messages")
    command = [PYTHON, tmp_path / "program.py", endpoint]
    done = finished(command)
    page = " ".join(PAGE.read_text(encoding="utf-8").split())
    said = re.search(r"answers where the bright pixels begin: `([^`]*)`", page)[1]
    assert done.stdout == f"{said}\n", done.stdout + done.stderr
