"""The house rules that a program can check: linters, types, sizes, and the same names in every tree.

They are for those who change the kit: `python3 kit.py test tests/house` runs them with the versions that they want.
"""

import ast
import io
import os
import re
import shutil
import sys
import tokenize
from pathlib import Path

import pytest

from kitlib.lessons import lessons
from kitlib.setup import dotnet, python_setup
from kitlib.unity.inventory import NETMQ
from tests.programs import ROOT, finished

# Files whose idea does not fit, and may not grow either.
LONGER = {
    # It is a base as well, from which the world of a scene derives.
    "unity/Assets/NetMQExample/09_environment/GymManager.cs": 93,
    # Beside what it says there is an event for the end of it.
    "unity/Assets/NetMQExample/21_talking_character/TalkingCharacter.cs": 66,
    # It counts requests, and of these the new ones: two more lines than others have, and no trick to save them.
    "python/02_lazy_pirate/server.py": 47,
}


def check(*command, **options):
    done = finished(command, timeout=900, cwd=ROOT, **options)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("how", [["check"], ["format", "--check"]], ids=["check", "format"])
def test_ruff(how):
    check(sys.executable, "-m", "ruff", *how, "kit.py", "kitlib", "lab", "python", "tests")


# Each is a folder of its own on the path: every lesson has a server.py, and to mypy they would be one module.
FOLDERS = [*sorted((ROOT / "python").glob("[0-9]*")), ROOT / "lab" / "contenders"]
OWN = """
from netmq_example.envs import NoSuchName, UnityAECEnv, UnityGymEnv

reveal_type(UnityGymEnv("CartPole"))
reveal_type(UnityAECEnv("Pursuit"))
"""


def test_mypy(tmp_path):
    """In one run, for which the programs are copied to where each folder is a package."""
    copies = tmp_path / "copies"
    for folder in FOLDERS:
        shutil.copytree(folder, copies / f"in_{folder.name}")
    trees = [ROOT / "kitlib", ROOT / "python" / "netmq_example", ROOT / "tests", copies]
    files = ["kit.py", *(ROOT / "lab").glob("*.py"), *(path for tree in trees for path in tree.rglob("*.py"))]
    environment = {**os.environ, "MYPYPATH": os.pathsep.join(map(str, [copies, *FOLDERS]))}
    # A cache of an earlier run can hide that a package has no types; and mypy knows the functions of one system.
    flags = ["--platform", "linux", "--explicit-package-bases", "--cache-dir", tmp_path]
    check(sys.executable, "-m", "mypy", *flags, *files, env=environment)
    # In a program of one's own a name that does not exist is found, and one that does has its type.
    (tmp_path / "own.py").write_text(OWN, encoding="utf-8")
    done = finished([sys.executable, "-m", "mypy", *flags, tmp_path / "own.py"], timeout=900, cwd=ROOT)
    assert 'Module "netmq_example.envs" has no attribute "NoSuchName"' in done.stdout, done.stdout + done.stderr
    for name in ("gym_env.UnityGymEnv", "parallel_env.UnityAECEnv"):
        assert f"netmq_example.envs.{name}" in done.stdout, done.stdout


PROJECTS = [path for tree in ("csharp-*", "lab", "tests") for path in ROOT.glob(f"{tree}/**/*.csproj")]


@pytest.mark.timeout(1200)
def test_dotnet_format(console, netmq, tmp_path):
    """Every C# project of the solution, in one that every SDK reads: those before 9 do not read .slnx."""
    env = {**os.environ, **dotnet.ENVIRONMENT}
    projects = re.findall(r'Project Path="([^"]+)"', (ROOT / "NetMQExample.slnx").read_text(encoding="utf-8"))
    assert sorted(projects) == sorted(path.relative_to(ROOT).as_posix() for path in PROJECTS)
    check("dotnet", "new", "sln", "--output", tmp_path, env=env)
    check("dotnet", "sln", tmp_path, "add", *projects, env=env)
    check("dotnet", "restore", tmp_path, *netmq.properties, env=env)
    check("dotnet", "format", tmp_path, "--verify-no-changes", "--no-restore", env=env)


@pytest.mark.timeout(1200)
def test_the_kits_own_scripts_have_no_warning(netmq, tmp_path):
    """A reader's own, which is built with them, may have some."""
    words = [*netmq.properties, "-p:Strict=true", f"-p:ArtifactsPath={tmp_path}", "-v:quiet"]
    check("dotnet", "build", "csharp-support/lessons", *words, env={**os.environ, **dotnet.ENVIRONMENT})


def python_lines(text):
    """The numbers of the lines that hold code: no blank ones, comments or docstrings."""
    quiet = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    tokens = [token for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type not in quiet]
    code = {line for token in tokens for line in range(token.start[0], token.end[0] + 1)}
    docs = [
        node
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    ]
    return code - {line for node in docs for line in range(node.lineno, node.end_lineno + 1)}


def csharp_lines(text):
    """The same, where XML documentation is a comment; a lone brace counts."""
    return [line for line in text.splitlines() if line.strip() and not line.strip().startswith("//")]


def limit(path, text):
    """How many lines of code a lesson's file has at the most."""
    if path.suffix == ".py":
        first = path.name in ("server.py", "client.py") and path.parent.name[0].isdigit()
        return 45 if first else 200
    if path.parent.name == "csharp-console":
        return 45
    return 60 if re.search(r"class \w+ : \w+Behaviour\b", text) and "abstract class" not in text else 200


PACKAGE = "unity/Assets/NetMQExample"
LESSON_FILES = [
    path
    for tree in (
        "python/*/*.py",
        "python/netmq_example/*/*.py",
        "unity/Assets/NetMQExample/[0-9SE][0-9hd]*/*.cs",
        "csharp-console/[0-9]*.cs",
    )
    for path in sorted(ROOT.glob(tree))
]


def test_a_lesson_stays_short():
    too_long = []
    for path in LESSON_FILES:
        text, name = path.read_text(encoding="utf-8"), path.relative_to(ROOT).as_posix()
        found = len(python_lines(text) if path.suffix == ".py" else csharp_lines(text))
        if found > LONGER.get(name, limit(path, text)):
            too_long.append(f"{name}: {found} lines; split the idea in two")
        too_long += [f"{name}: {line}" for line in text.splitlines() if len(line) > 120]
    assert too_long == []


def test_a_lesson_is_whole():
    """The same key in every tree."""
    for lesson in lessons():
        tests = ROOT / "tests" / "lessons" / f"test_{lesson.key}.py"
        for path in (lesson.python / "client.py", lesson.console, lesson.guide, tests):
            assert path.exists(), path
        assert list(lesson.unity.glob("*.cs")), lesson.unity
        assert "\n```mermaid\nsequenceDiagram\n" in lesson.guide.read_text(encoding="utf-8"), lesson.guide


def imports_of(path):
    """The modules of the package that a file names in its imports."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            yield from (node.module, *(f"{node.module}.{alias.name}" for alias in node.names))
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def test_no_module_of_the_package_needs_itself():
    """No circle of imports, and the package knows of no program: one file less is never one too few."""
    folder = ROOT / "python"
    files = {
        path: ".".join(path.relative_to(folder).with_suffix("").parts) for path in folder.rglob("netmq_example/**/*.py")
    }
    needs = {name.removesuffix(".__init__"): set(imports_of(path)) for path, name in files.items()}
    left = {
        name: {other for other in others & needs.keys() if not name.startswith(other)} for name, others in needs.items()
    }
    while free := [name for name, others in left.items() if not others & left.keys()]:
        for name in free:
            del left[name]
    assert left == {}


PROGRAMS = sorted((ROOT / "python").glob("[0-9]*/*.py"))
PATH_LINE = "sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])"


def test_a_program_alone_touches_the_path():
    """In one line, before all that may import the package: Gymnasium does."""
    for path in (ROOT / "python").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if path not in PROGRAMS or "__main__" not in text:
            assert "sys.path" not in text, path
            continue
        before, line, _ = text.partition(f"\n{PATH_LINE}\n")
        names = re.findall(r"^(?:from|import) ([\w.]+)", before, re.MULTILINE)
        assert line and text.count("sys.path") == 1, path
        assert {name.partition(".")[0] for name in names} <= sys.stdlib_module_names, path


ALONE = """
import sys, pytest
for name in sys.argv[1:]:
    sys.modules[name] = None
sys.exit(pytest.main(["tests", "--collect-only", "-q", "-p", "pytest_timeout"]))
"""


def test_the_tests_can_be_read_with_pyzmq_and_pytest_alone():
    """A test that needs more says so when it is read, and those of lesson 01 run."""
    others = {python_setup.module(python_setup.name(need)) for need in python_setup.needs(*python_setup.all_extras())}
    others -= {"zmq", "pytest", "pytest_timeout"}
    environment = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = finished([sys.executable, "-c", ALONE, *others], cwd=ROOT, env=environment)
    assert done.returncode == 0, done.stdout
    assert "tests/lessons/test_01_request_reply.py" in done.stdout


def tracked():
    if not shutil.which("git") or not (ROOT / ".git").exists():
        pytest.skip("not a git checkout")
    listed = finished(["git", "ls-files"], cwd=ROOT)
    if listed.returncode:
        pytest.skip(f"git does not list the files: {listed.stderr.splitlines()[0]}")
    return [ROOT / name for name in listed.stdout.split("\n") if name and (ROOT / name).exists()]


# What is said of another version on purpose: the first that ends on macOS, the lowest that compiles, the version that
# the assembly NetMQ.dll has in every one of them, and what tests make up or find in projects.
OTHER_VERSIONS = {"4.0.4.1", "4.0.1.11", "4.0.0.1", "4.0.0-1", "4.0.2-1234", "4.0.1.12", "4.0.1.13", "4.0.2.1"}


def test_netmqs_version_is_the_same_wherever_it_is_named():
    """UnityNuGet writes a hyphen before its fourth number. The changelog names older ones."""
    found = {}
    for path in tracked():
        if path.suffix not in (".png", ".gif", ".svg") and path.name != "CHANGELOG.md" and path != Path(__file__):
            for version in re.findall(r"\b4\.\d+\.\d+[.-]\d+\b", path.read_text(encoding="utf-8")):
                if version not in OTHER_VERSIONS:
                    found.setdefault(version.replace("-", "."), []).append(path.relative_to(ROOT).as_posix())
    others = [f"{version}: {', '.join(sorted(set(names)))}" for version, names in found.items() if version != NETMQ]
    assert others == [], "; ".join(others)


def test_no_binary_and_no_path_of_somebodys_machine_is_in_the_repository():
    for path in tracked():
        assert path.suffix not in {".dll", ".so", ".dylib", ".nupkg", ".whl", ".exe"}, path
        if path.suffix not in (".png", ".gif"):
            text = path.read_text(encoding="utf-8")
            assert not re.search(r"/(home|Users)/\w+/|[A-Z]:\\\\Users", text) or path == Path(__file__), path
            assert text.endswith("\n") or not text, f"{path}: no newline at the end"


# What is a program itself, or a process of its own; and the reports of Python's own.
ENDING = {"__init__", "asking", "console", "finalizers", "program", "keys", "launch", "workers"}
ENDS = {"print", "sys.exit", "os._exit", "signal.signal", "traceback.print_exc"}


def test_the_package_logs_and_leaves_the_end_to_programs():
    found = []
    for path in (ROOT / "python" / "netmq_example").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Name | ast.Attribute) and ast.unparse(node) in ENDS and path.stem not in ENDING:
                found.append(f"{path.relative_to(ROOT).as_posix()}:{node.lineno}: {ast.unparse(node)}")
    assert found == []


# A low floor, floors above each other, and separate rooms: the package as its real imports show it.


PYTHON_PACKAGE = ROOT / "python" / "netmq_example"
# Environments: they need what the clients and servers have, and never the other way round.
ABOVE = {
    *("wire", "locator", "envs", "scene", "fleet", "worlds", "video", "sb3", "mlagents_envs", "mlagents_learn"),
    *("records", "spaces", "space_bytes", "space_numbers", "trees", "split_mix", "locator_reader"),
    *("simulation", "side_channel", "environment", "base_env", "exception", "cross_entropy"),
}
ROOMS = {"jobs", "fleet", "body", "talk"}

# The server of lesson 01 runs up to its first receive, which ends it as Ctrl-C would.
FIRST_RECEIVE = """
import runpy, sys, zmq
def stop(*_, **__): raise KeyboardInterrupt
zmq.Socket.recv = zmq.Socket.recv_multipart = zmq.Socket.poll = stop
sys.argv = [sys.argv[1], "--endpoint", "tcp://127.0.0.1:0"]
try: runpy.run_path(sys.argv[0], run_name="__main__")
except SystemExit: pass
print(*(module.__file__ for name, module in sys.modules.items() if name.startswith("netmq_example")), sep="\\n")
"""


def room(path):
    """The folder of the package in which a module lies, or the module itself."""
    return path.relative_to(PYTHON_PACKAGE).parts[0].removesuffix(".py")


def needs():
    """Each module's room and another one that it imports, as (path, its room, the other room)."""
    for path in PYTHON_PACKAGE.rglob("*.py"):
        for name in imports_of(path):
            package, _, rest = str(name).partition(".")
            if package == "netmq_example" and rest:
                yield path.relative_to(PYTHON_PACKAGE).as_posix(), room(path), rest.partition(".")[0]


def test_clients_and_servers_need_no_environments():
    assert {(path, other) for path, own, other in needs() if own not in ABOVE and other in ABOVE} == set()


def test_the_rooms_of_lessons_14_17_20_and_21_need_nothing_of_each_other():
    assert {(path, other) for path, own, other in needs() if {own, other} <= ROOMS and own != other} == set()


def test_the_floor_of_lesson_01_is_low():
    server = ROOT / "python" / "01_request_reply" / "server.py"
    words = [sys.executable, "-c", FIRST_RECEIVE, server]
    done = finished(words)
    files = [line for line in done.stdout.splitlines() if str(PYTHON_PACKAGE) in line]
    code = {file: len(python_lines(Path(file).read_text(encoding="utf-8"))) for file in files}
    assert "listening on " in done.stdout, done.stderr
    assert 1 < len(code) <= 7 and sum(code.values()) <= 350, code


# An error that ends a program says in its one line what went wrong and what to do, so no page has to explain it.


# Those that end a program. A MessageError is a reply with a code, and a ValueError a mistake in the caller's code.
PYTHON_ERRORS = {
    *("Error", "Timeout", "Lost", "Closed", "ListenError", "SourceError", "WorkError", "OSError"),
    *("KitError", "UsageError", "NoNetMQ", "argparse.ArgumentTypeError", "sys.exit"),
}
CSHARP_ERRORS = "TimeoutException|UsageException|GaveUpException|InvalidOperationException"
# "…; do this", "…: do this", a question that leads to the cause, a hole called cure, or the rule that was broken.
CURE = r"; |: (?!\{)|\?|\{(with_)?cure|\{pip_install| takes | must |, not \{"
# These hand on a text of another place that has its own cure, or another program's words.
HANDED_ON = r"(gave up|no poses|failed|Ollama says): \{.*|scope, \{.*|\{[^}]*\}: \{.*"
# After these a program goes on by itself, or it has closed the thing itself.
GOES_ON = {"the client was disposed", "the environment is gone, or silent", "Python is gone", "no connection"}
GOES_ON |= {"the client was closed", "the listener was stopped", "the game is gone", "there is no game, or it is gone"}


def without_code(text):
    """The hole of an f-string holds code: of it only the name is kept."""
    return re.sub(r"\{(\w*)[^{}]*\}", r"{\1}", text)


def text_of(node):
    """The text that an expression is made of, with its holes; empty if it is none."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return without_code(ast.unparse(node)[2:-1])
    return text_of(node.left) + text_of(node.right) if isinstance(node, ast.BinOp) else ""


def python_texts(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and ast.unparse(node.func) in PYTHON_ERRORS and node.args:
            yield text_of(node.args[0])


def csharp_texts(path):
    for thrown in re.findall(
        rf"throw new (?:{CSHARP_ERRORS})\((.*?)\);\n", path.read_text(encoding="utf-8"), re.DOTALL
    ):
        yield without_code("".join(re.findall(r'"((?:[^"\\]|\\.)*)"', thrown)))


def test_an_error_names_its_cause_and_a_thing_to_do():
    texts = {}
    for tree in ("kit.py", "kitlib/**/*.py", "lab/**/*.py", "python/**/*.py"):
        texts |= {text: path for path in ROOT.glob(tree) for text in python_texts(path)}
    for tree in ("unity/**/*.cs", "csharp-console/*.cs"):
        texts |= {text: path for path in ROOT.glob(tree) for text in csharp_texts(path)}
    assert len(texts) > 150
    assert [
        f"{path.relative_to(ROOT).as_posix()}: {text}"
        for text, path in texts.items()
        if text and not re.search(CURE, text) and not re.fullmatch(HANDED_ON, text) and text not in GOES_ON
    ] == []
