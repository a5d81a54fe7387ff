"""The package as one installs it: `pip install .` in the kit's folder, and then a program of one's own elsewhere. A
package that is missing is named with its cure.
"""

import importlib
import re
import shutil
import sys
import zipfile

import pytest

from kitlib import imports
from kitlib.setup import python_setup
from netmq_example.extras import importing, without
from tests.conftest import PYTHON
from tests.programs import EACH_RUN, ROOT, InTurn, finished

PACKAGE = ROOT / "python" / "netmq_example"


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


def test_an_extra_is_what_the_modules_of_its_name_import():
    """So netmq_example.envs needs netmq-example[envs]. A webcam's packages are imported when they are used."""
    folders = [extra for extra in python_setup.all_extras() if (PACKAGE / extra).is_dir()]
    assert {"camera", "envs", "video", "web"} < set(folders)
    for extra in folders:
        found = python_setup.imported(sorted((PACKAGE / extra).glob("*.py")))
        assert python_setup.needs() + found == python_setup.needs(*([extra] if extra not in python_setup.LARGE else []))


@pytest.mark.parametrize(
    ("door", "name", "absent", "cure"),
    [
        ("envs", "UnityGymEnv", "gymnasium", "gymnasium"),
        ("sb3", "UnityVecEnv", "stable_baselines3", "stable_baselines3"),
        ("camera", "Recorder", "numpy", "numpy"),
        ("video", "Films", "numpy", "numpy"),
        ("video", "open_film", "PIL", "pillow"),
        ("web", "Door", "aiohttp", "aiohttp"),
        ("web", "SocketIORequester", "socketio", "python-socketio"),
    ],
)
def test_what_an_extra_brings_is_named_where_it_is_missing(door, name, absent, cure):
    needs = ["aiohttp"] if door == "web" else ["numpy", "gymnasium"]
    if lacking := python_setup.not_found(PYTHON, [need for need in needs if need != absent]):
        pytest.skip(f"without them it stops before: pip install {' '.join(lacking)}")
    code = f"import sys; sys.modules[{absent!r}] = None; from netmq_example.{door} import {name}"
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


def needed(module):
    try:
        importlib.import_module(module)
    except ImportError as error:
        raise without(error) from None


def test_a_package_that_is_there_and_broken_is_not_to_be_installed(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "brokenpackage.py").write_text("raise ImportError('another ABI: see its page')")
    with pytest.raises(ImportError, match=r"^another ABI: see its page$"):
        needed("brokenpackage")
    with pytest.raises(ImportError, match=r"pip install nosuchpackage$"):
        needed("nosuchpackage.part")
    with pytest.raises(SystemExit, match=r"^another ABI: see its page: this lesson needs it$"), importing("it"):
        needed("brokenpackage")


# As if all that a program needs besides pyzmq were not installed.
ABSENT = """
import sys
for name in ("numpy", "gymnasium", "pettingzoo", "PIL", "aiohttp", "socketio", "ray", "av", "mediapipe", "cv2"):
    sys.modules[name] = None
"""
PROGRAMS = sorted(ROOT.glob("python/[0-9]*/*.py"))


def test_a_program_without_what_it_needs_says_what_is_missing():
    with InTurn([sys.executable, "-c", ABSENT + EACH_RUN]) as run:
        for path in PROGRAMS:
            if "__main__" in (text := path.read_text(encoding="utf-8")):
                code, lines = run(path, "--help")
                said = len(lines) == 1 and bool(re.fullmatch(r"[^:]+: this lesson needs .+", lines[0]))
                assert said == (code == 1) == ("importing(" in text), (path, code, lines)


LIKE_ML_AGENTS = ["base_env", "environment", "envs.unity_gym_env", "envs.unity_parallel_env", "envs.unity_aec_env"]


def test_a_class_of_ml_agents_without_numpy_says_how_to_install_it():
    program = f"{ABSENT}\nimport importlib\nimportlib.import_module('netmq_example.mlagents_envs.' + sys.argv[1])"
    for module in LIKE_ML_AGENTS:
        words = [sys.executable, "-c", program, module]
        done = finished(words, cwd=ROOT / "python")
        assert done.returncode == 1 and re.search(r"numpy.*: \S+ -m pip install numpy$", done.stderr.strip()), module
