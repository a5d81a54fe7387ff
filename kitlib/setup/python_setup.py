"""An interpreter that has what a lesson needs: .venv, filled by pip, or else the one that runs kit.py.

Where neither has it, one line says what to run.
"""

import functools
import hashlib
import json
import os
import re
import shutil
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from kitlib import imports
from kitlib.files import keep
from kitlib.lessons import BUILD, KIT, PACKAGES, ROOT, KitError, Lesson, denied, read_json, unwritable, writable
from kitlib.programs import Result, quietly, step
from kitlib.terminal import command, say

VENV = ROOT / ".venv"
CHOICE = BUILD / "python.json"
# This system and this Python, as `kit.py pack` calls them.
HERE = {"win32": "windows", "darwin": "macos"}.get(sys.platform, "linux")
VERSION = f"{sys.version_info[0]}.{sys.version_info[1]}"
# The name to import, where it is not simply the name on PyPI.
IMPORTS = {"markdown-it-py": "markdown_it"}
IMPORTS |= {"pytest-xdist": "xdist", "pyzmq": "zmq", "pillow": "PIL", "pyyaml": "yaml", "grpcio": "grpc"}
# Pip says these where no index answers, or does not hold a package.
NOTHING = ("Could not find a version", "No matching distribution", "Max retries")
# Nobody gets these unasked: each is large, not there for every system, and of use to a part of a lesson alone.
LARGE = ("body", "ray", "sb3")
# Settings of a user's for pip that would fill another folder, or none. To pip an empty one is not there.
ELSEWHERE = dict.fromkeys(("PIP_TARGET", "PIP_PREFIX", "PIP_ROOT", "PIP_PYTHON"), "")
ELSEWHERE |= dict.fromkeys(("PIP_USER", "PIP_DRY_RUN", "PIP_REQUIRE_HASHES"), "0")


@functools.cache
def project() -> dict[str, Any]:
    return dict(tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"])


def needs(*names: str) -> list[str]:
    """The requirements of pyproject.toml: the core, and for each name those of that extra or of that lesson."""
    about = project()
    found = list(about["dependencies"])
    for each in names:
        found += about["optional-dependencies"].get(each) or of_lesson(Lesson(each))
    return list(dict.fromkeys(found))


def of_lesson(lesson: Lesson) -> list[str]:
    """The packages beyond the core that the programs of `kit.py run` import, but for those of only a part of them."""
    programs = ["server.py", "client.py", *(words[0] for words in lesson.also)]
    large = [need for needs in large_extras(lesson).values() for need in needs]
    return [need for need in imported(lesson.python / program for program in programs) if need not in large]


def large_extras(lesson: Lesson) -> dict[str, list[str]]:
    """The extras that nobody gets unasked, as far as a part of the lesson's programs imports them."""
    wanted = imported(sorted(lesson.python.glob("*.py")))
    others = needs(*tests_extras())
    own = {extra: [need for need in needs(extra) if need in wanted and need not in others] for extra in LARGE}
    return {extra: found for extra, found in own.items() if found}


def imported(files: Iterable[Path]) -> list[str]:
    """The requirements beyond the core that these files have, in pyproject.toml's words and order."""
    names = imports.packages(files)
    return [need for need in needs(*all_extras()) if need not in needs() and module(name(need)) in names]


def module(package: str) -> str:
    return IMPORTS.get(package, package.removeprefix("python-").replace("-", "_"))


def all_extras() -> list[str]:
    return list(project()["optional-dependencies"])


def tests_extras() -> list[str]:
    """All that the tests can use; `style` is for tests/house alone."""
    return [extra for extra in all_extras() if extra not in (*LARGE, "style")]


def name(requirement: str) -> str:
    """`pyzmq` of `pyzmq>=24`."""
    return re.split("[>=<;]", requirement)[0].strip().lower()


# Run by the interpreter in question: which of the packages it lacks. One that cannot be imported is not there, whatever
# its folder says, and one that is too old for us is not either.
LACKING = """
import importlib, importlib.metadata, re, sys
def lacks(package, module, limits):
    try:
        # What has lost its files is a folder, and can be imported.
        if importlib.import_module(module).__file__ is None:
            return True
        have = numbers(importlib.metadata.version(package)) if limits else []
    except Exception:
        return True
    return not all(have >= numbers(at) if how == ">=" else have < numbers(at) for how, at in limits)
def numbers(version):
    return [int(number) for number in re.findall(r"\\d+", version)[:3]]
print("lacks:", *[each[0] for each in {needs!r} if lacks(*each)] if sys.version_info >= (3, 11) else ["Python"])
"""


def alone(python: Path | str) -> list[str | Path]:
    """The words that ask it for what a lesson will find: nothing of the current folder, and of .venv what is in it."""
    return [python, *(["-I", "-X", "utf8"] if Path(python) == venv_python() else ["-P"])]


def chosen(python: Path) -> Path:
    """The lessons will run with it. Before .venv's own packages would come those of a PYTHONPATH, such as ROS sets."""
    for variable in ("PYTHONPATH", "PYTHONHOME") if python == venv_python() else ():
        os.environ.pop(variable, None)
    return python


def lacking(python: Path | str, requirements: list[str]) -> list[str]:
    """The packages that this interpreter lacks, or has in a version that does not fit."""
    needs = [(name(need), module(name(need)), re.findall(r"(>=|<)([\d.]+)", need)) for need in requirements]
    result = quietly([*alone(python), "-c", LACKING.replace("{needs!r}", repr(needs))], limit=60)
    # A package may print something of its own when it is imported.
    said = re.search(r"^lacks:(.*)", result.output, re.MULTILINE)
    return said[1].split() if said else [name(need) for need in requirements]


def has(python: Path | str, requirements: list[str]) -> bool:
    return not lacking(python, requirements)


def not_found(python: Path, packages: list[str]) -> list[str]:
    """Those that this interpreter has nothing of. To import some, such as MediaPipe, would take seconds."""
    modules = {package: module(package) for package in packages}
    code = "import importlib.util, sys; print(*filter(importlib.util.find_spec, sys.argv[1:]))"
    there = quietly([*alone(python), "-c", code, *modules.values()], limit=60).output.split()
    return [package for package in packages if modules[package] not in there]


def requirement(package: str) -> str:
    """A package in pyproject.toml's words, such as `websockets>=13`."""
    return next((need for need in needs(*all_extras()) if name(need) == package), package)


def interpreter(*extras: str, optional: tuple[str, ...] = ()) -> Path:
    """The interpreter to run the lessons with; sets it up if need be. `optional` extras are nice to have."""
    required, wanted = needs(*extras), needs(*extras, *optional)
    # A change of a user's settings for pip is a reason to ask again.
    settings = sorted(f"{key}={value}" for key, value in os.environ.items() if key.startswith("PIP_"))
    key = hashlib.sha256(json.dumps([wanted, sys.version, settings]).encode()).hexdigest()
    known = read_json(CHOICE).get(key)
    if isinstance(known, str) and os.path.exists(known) and has(known, required):
        return chosen(Path(known))
    names = [name(need) for need in required]
    python = from_pip(required, wanted)
    if not python and has(sys.executable, required):
        say(f"using {sys.executable}, which has {', '.join(names)}")
        python = Path(sys.executable)
    if not python:
        raise KitError(nowhere(names))
    keep(CHOICE, json.dumps({**read_json(CHOICE), key: str(python)}))
    return chosen(python)


def nowhere(names: list[str]) -> str:
    """The cure where no interpreter has these packages and pip cannot fetch them."""
    cure = command(sys.executable, "-m", "pip", "install", *names)
    if any(PACKAGES.glob("*.whl")):
        cure = f"{KIT} pack --system {HERE} --python {VERSION} ({PACKAGES.name} is for another Python or system)"
        if not any(quietly([sys.executable, "-m", pip, "--version"], limit=60).ok for pip in ("pip", "ensurepip")):
            return f"{sys.executable} has no pip: with internet install it (Debian, Ubuntu: python3-venv)"
    elif shutil.which("apt-get") and sys.executable.startswith("/usr/bin/"):
        # Debian names a package after the module.
        packages = [f"python3-{module(each).lower().replace('_', '-')}" for each in names]
        there = all(quietly(["apt-cache", "show", package], limit=60).ok for package in packages)
        # With the other one, .venv can be filled: the distribution has no Gymnasium, for example.
        cure = f"sudo apt install {' '.join(packages) if there else 'python3-venv, and then this again'}"
    return f"no Python with {', '.join(names)} here, and .venv could not be filled; with internet run: {cure}"


def found(*extras: str) -> Path | None:
    """The interpreter that lessons run with, or would; sets up nothing."""
    known = [path for path in read_json(CHOICE).values() if isinstance(path, str)]
    near = map(Path, [str(venv_python()), *reversed(known), sys.executable])
    return next((chosen(python) for python in near if os.path.exists(python) and has(python, needs(*extras))), None)


def venv_python() -> Path:
    return VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def from_pip(required: list[str], wanted: list[str]) -> Path | None:
    """.venv, filled by pip; None when there is no pip, no venv module or no index that answers."""
    python = venv_python()
    if has(python, wanted):
        return python
    if not writable(BUILD):
        say(unwritable(BUILD))
        return None
    # For Path one in a folder where we may not look is an error. It is no use either.
    made = not os.path.exists(python)
    if VENV.is_file() or not (made or quietly([*alone(python), "-c", ""], limit=60).ok):
        raise KitError(f"the Python in {VENV} cannot be started: delete {VENV} and run this again")
    if made and not make_venv():
        return None
    for requirements in [wanted] if wanted == required else [wanted, required]:
        result = install(python, requirements)
        if result.ok and has(python, requirements):
            return python
        if any(words in result.output for words in NOTHING):
            index = setting(python, "no-index", "index-url") or "https://pypi.org/simple"
            # A password may stand in it.
            say(f"pip did not get all of it from {re.sub('//[^/]*@', '//', index)}")
        elif why := denied(result.output):
            say(why)
        elif not result.ok:
            say(f"pip could not: {result.first('ERROR', 'error', 'No module').removeprefix('ERROR: ')}")
        elif elsewhere := setting(python, "target", "prefix", "root"):
            say(f"pip's setting {elsewhere} fills another folder than .venv: drop it; pip config debug shows its file")
        elif missing := lacking(python, requirements):
            # Pip takes for whole what has lost a file.
            say(f"{', '.join(missing)} in {VENV.name} cannot be imported: delete the folder {VENV} and run this again")
    if made:
        shutil.rmtree(VENV, ignore_errors=True)
    return None


def install(python: Path, requirements: list[str]) -> Result:
    """Let pip install into .venv: from the folder that was brought along, or else from an index."""
    pip = [*alone(python), "-m", "pip"]
    if not quietly([*pip, "--version"], limit=60).ok:
        # A venv without pip of its own (Debian without python3-venv): the pip of this interpreter installs into it.
        pip = [sys.executable, "-P", "-m", "pip", "--python", python]
    # One try and ten seconds: pip's own default goes on for minutes when no index can be reached.
    limits = ["--retries", "0", "--timeout", "10", "--prefer-binary"]
    command = [*pip, "install", "--quiet", "--disable-pip-version-check", *limits, *requirements]
    what = f"installing {', '.join(map(name, requirements))} into .venv"
    if any(PACKAGES.glob("*.whl")):
        brought = step(f"{what} from packages", [*command, "--no-index", "--find-links", PACKAGES], 600, ELSEWHERE)
        if brought.ok:
            return brought
    return step(what, command, 600, ELSEWHERE)


def setting(python: Path, *names: str) -> str | None:
    """`name='value'` of the first of these that is set for pip, by a variable or by a file of its settings."""
    said = quietly([*alone(python), "-m", "pip", "config", "list"], 60, ELSEWHERE).output
    found = re.search(rf"^\S+\.((?:{'|'.join(names)})=(?!'').+)", said, re.MULTILINE)
    return found[1] if found else None


def make_venv() -> bool:
    """Make .venv, with pip or, where the distribution left that out, without."""
    # Conda's, or that of Windows and WSL in one folder. A link may lead to where only the other one can look.
    others = [VENV / place for place in ("bin/python", "Scripts/python.exe", "python.exe")]
    if any(os.path.lexists(other) for other in others if other != venv_python()):
        say(f"{VENV} is of another system or of conda, and stays: copy the kit to a folder of its own for this one")
        return False
    for links, option in ((True, []), (False, []), (False, ["--without-pip"])):
        # The leavings of a failed try would look like an environment to the next.
        shutil.rmtree(VENV, ignore_errors=True)
        if HERE == "linux" and not links:
            # Of all that is a link in an environment, only this one cannot be a copy, as on a stick or in a shared
            # folder. It may be there already.
            (VENV / "lib64").mkdir(parents=True, exist_ok=True)
        result = quietly([sys.executable, "-I", "-m", "venv", *option, VENV], limit=120)
        if result.ok:
            return True
    shutil.rmtree(VENV, ignore_errors=True)
    said = denied(result.output) or f"{result.first('rror')} (on Debian the package is python3-venv)"
    say(f"this Python cannot make a virtual environment: {said}")
    return False
