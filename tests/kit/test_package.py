"""The package as one installs it: `pip install .` in the kit's folder, and then a program of one's own elsewhere."""

import re
import shutil
import site
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from kitlib import imports
from kitlib.lessons import lessons
from kitlib.setup import python_setup
from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, finished

PACKAGE = ROOT / "python" / "netmq_example"
# Extras that are too large for a cell of the workflow, and those for who changes the kit.
UNRUN = ("body", "ray", "sb3", "tests-more", "unity-tests", "style", "bench")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Built without an index, from a copy: the sources must not be where it is imported later."""
    if lacking := python_setup.not_found(PYTHON, ["pip", "hatchling"]):
        pytest.skip(f"it builds the package: pip install {' '.join(lacking)}")
    sources, made = tmp_path_factory.mktemp("kit"), tmp_path_factory.mktemp("made")
    for name in ("pyproject.toml", "README.md", "LICENSE", ".gitignore"):
        shutil.copy(ROOT / name, sources)
    shutil.copytree(ROOT / "python", sources / "python")
    words = ["wheel", "--no-index", "--no-build-isolation", "--no-deps", "--wheel-dir", made, sources]
    done = finished([PYTHON, "-m", "pip", *words])
    assert done.returncode == 0, done.stderr
    (path,) = made.iterdir()
    return path


@pytest.fixture(scope="module")
def elsewhere(wheel, tmp_path_factory):
    """A fresh environment with the package; those that it needs are the tests' own."""
    folder = tmp_path_factory.mktemp("elsewhere")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "venv"], check=True, timeout=LIMIT)
    python = folder / "venv" / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    where = finished([python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]).stdout.strip()
    (Path(where) / "of_the_tests.pth").write_text("\n".join(site.getsitepackages()), encoding="utf-8")
    words = ["install", "--no-index", "--no-deps", wheel]
    done = finished([PYTHON, "-m", "pip", "--python", python, *words])
    assert done.returncode == 0, done.stderr
    return python


def test_the_wheel_holds_the_package_alone(wheel):
    files = {path.relative_to(ROOT / "python").as_posix() for path in PACKAGE.rglob("*.*") if path.suffix != ".pyc"}
    assert {"netmq_example/py.typed", "netmq_example/tap/tap.html", "netmq_example/envs/__init__.py"} < files
    with zipfile.ZipFile(wheel) as archive:
        found = set(archive.namelist())
        (about,) = [name for name in found if name.endswith("/METADATA")]
        metadata = archive.read(about).decode()
    assert {name for name in found if ".dist-info/" not in name} == files
    assert f"\nVersion: {python_setup.project()['version']}\n" in metadata
    assert "\nLicense-Expression: MIT\n" in metadata and "\nClassifier: Typing :: Typed\n" in metadata
    # An older pip finds no extra whose name has an underscore.
    assert "_" not in "".join(re.findall(r"^Provides-Extra: (.+)$", metadata, re.MULTILINE))
    assert re.findall(r"^Requires-Dist: ([^;\n]+)$", metadata, re.MULTILINE) == python_setup.needs()


def test_a_gymnasium_environment_needs_no_import_of_the_package(elsewhere, tmp_path):
    """Gymnasium imports what stands before the colon; since its version 1.0 it goes by no entry point any more."""
    if lacking := python_setup.not_found(PYTHON, ["numpy", "gymnasium"]):
        pytest.skip(f"it makes an environment: pip install {' '.join(lacking)}")
    program = tmp_path / "mine.py"
    program.write_text(
        "import sys, gymnasium\n"
        "env = gymnasium.make('netmq_example.envs:NetMQExample/CartPole-v0', launch=sys.argv[1:])\n"
        "env.reset(seed=1)\n"
        "print('reward', env.step(1)[1], 'by', sys.modules['netmq_example'].__file__)\n"
        "env.close()\n",
        encoding="utf-8",
    )
    done = finished([elsewhere, program, PYTHON, ROOT / "python" / "09_environment" / "client.py"], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    # The simulator prints its own lines, too.
    file = re.search(r"^reward 1.0 by (.+)$", done.stdout, re.MULTILINE)[1]
    assert Path(file).is_relative_to(elsewhere.parents[1])


def test_an_extra_is_what_the_modules_of_its_name_import():
    """So netmq_example.envs needs netmq-example[envs]. A webcam's packages are imported when they are used."""
    folders = [extra for extra in python_setup.all_extras() if (PACKAGE / extra).is_dir()]
    assert {"camera", "envs", "video", "web"} < set(folders)
    for extra in folders:
        found = python_setup.imported(sorted((PACKAGE / extra).glob("*.py")))
        assert python_setup.needs() + found == python_setup.needs(*([extra] if extra not in python_setup.LARGE else []))


@pytest.mark.parametrize(
    ("module", "absent", "cure"),
    [
        ("envs", "gymnasium", "gymnasium"),
        ("environment", "gymnasium", "gymnasium"),
        ("sb3", "stable_baselines3", "stable_baselines3"),
        ("camera.recording", "numpy", "numpy"),
        ("video.films", "numpy", "numpy"),
        ("video.film_writer", "PIL", "pillow"),
        ("web.door", "aiohttp", "aiohttp"),
        ("web.socketio_requester", "socketio", "python-socketio"),
    ],
)
def test_what_an_extra_brings_is_named_where_it_is_missing(module, absent, cure):
    needs = {"envs": ["numpy", "gymnasium"], "web": ["aiohttp"]}.get(module.split(".")[0], ["numpy", "gymnasium"])
    if lacking := python_setup.not_found(PYTHON, [need for need in needs if need != absent]):
        pytest.skip(f"without them it stops before: pip install {' '.join(lacking)}")
    code = f"import sys; sys.modules[{absent!r}] = None; import netmq_example.{module}"
    said = finished([PYTHON, "-c", code], cwd=ROOT / "python").stderr.splitlines()[-1]
    assert said.startswith("ModuleNotFoundError: ") and said.endswith(f"-m pip install {cure}"), said


def test_an_older_python_is_refused_by_every_program_in_the_same_words():
    programs = [path for path in sorted((ROOT / "python").glob("[0-9]*/*.py")) if "__main__" in path.read_text("utf-8")]
    code = """
import runpy, sys
sys.version_info = (3, 10, 13, "final", 0)
for program in sys.argv[1:]:
    try:
        runpy.run_path(program, run_name="__main__")
    except SystemExit as end:
        print(end)
"""
    said = finished([PYTHON, "-c", code, ROOT / "kit.py", *programs]).stdout.splitlines()
    why = "needs Python 3.11 or later, this is 3.10: get one from https://www.python.org, and then open a new terminal"
    assert said == [f"kit.py {why}", *[f"netmq_example {why}"] * len(programs)]


def test_every_package_that_is_imported_is_in_pyproject_toml():
    known = {python_setup.module(python_setup.name(need)) for need in python_setup.needs(*python_setup.all_extras())}
    # Engine.IO is the half of Socket.IO that python-socketio brings along, as MediaPipe does OpenCV.
    assert imports.packages(sorted((ROOT / "python").rglob("*.py"))) - known == {"engineio", "cv2"}


@pytest.mark.parametrize(
    ("number", "needs"),
    [
        (1, []),
        # Array.numpy imports it only when it is called, as the server does.
        (5, ["numpy"]),
        (10, ["numpy", "gymnasium", "pettingzoo"]),
        # messages.py is there too, and nothing calls Array.numpy.
        (14, []),
        (16, ["aiohttp", "python-socketio"]),
        # One of its programs is for Ray, which `kit.py run` does not start.
        (17, ["numpy", "gymnasium"]),
        # Finding persons before a webcam is one of its server's two sources.
        (20, []),
    ],
)
def test_what_a_lesson_needs_is_read_from_its_imports(number, needs):
    (lesson,) = [each for each in lessons() if each.number == number]
    assert [python_setup.name(need) for need in python_setup.needs(lesson.key)] == ["pyzmq", *needs]


def test_each_lowest_version_that_is_declared_is_one_that_is_run():
    """That users' packages may have: by a cell of the workflow, with these very versions."""
    lowest = dict(re.findall(r"^([\w-]+)==([\d.]+)$", (ROOT / "tests" / "lowest.txt").read_text(), re.MULTILINE))
    declared = python_setup.needs(*(extra for extra in python_setup.all_extras() if extra not in UNRUN))
    for need in declared:
        package, _, version = need.partition(">=")
        # 1.1 is 1.1.0.
        assert f"{lowest.get(package)}.0".startswith(f"{version}.0"), need
    workflow = (ROOT / ".github" / "workflows" / "test.yml").read_text(encoding="utf-8")
    assert "packages: tests/lowest.txt" in workflow


def test_what_only_a_part_of_a_lesson_needs_is_known():
    found = {lesson.number: parts for lesson in lessons() if (parts := python_setup.large_extras(lesson))}
    names = {
        number: {part: [*map(python_setup.name, needs)] for part, needs in found[number].items()} for number in found
    }
    assert names == {17: {"ray": ["ray"]}, 20: {"body": ["mediapipe"]}}
