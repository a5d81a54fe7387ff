"""An interpreter that has what a lesson needs, on whatever machine this is.

In this order: .venv filled by pip; an interpreter that has the packages already; as root on Debian or Ubuntu, the
distribution's packages; otherwise one line that says what to run.
"""

from __future__ import annotations

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
from kitlib.lessons import KIT, PACKAGES, ROOT, UNWRITABLE, KitError, Lesson, keep, recall, writable
from kitlib.programs import Result, quietly, step
from kitlib.terminal import say

VENV = ROOT / ".venv"
BUILD = ROOT / ".build"
CHOICE = BUILD / "python.json"
# This system, as `kit.py pack` calls it.
HERE = {"win32": "windows", "darwin": "macos"}.get(sys.platform, "linux")
# The name to import, and the distribution's package, where they are not simply the name on PyPI.
IMPORTS = {
    "pytest-xdist": "xdist",
    "pyzmq": "zmq",
    "pytest-timeout": "pytest_timeout",
    "pillow": "PIL",
    "pyyaml": "yaml",
    "grpcio": "grpc",
    "opencv-python": "cv2",
    "python-socketio": "socketio",
}
# On a Mac /usr/bin/python3 is too old, or opens a window that offers developer tools.
SYSTEM = [*(["/usr/bin/python3"] if sys.platform != "darwin" else []), "/usr/local/bin/python3"]
# What pip says where no index answers, or does not hold a package.
NOTHING = ("Could not find a version", "No matching distribution", "Max retries")
# What nobody gets unasked: it is large, not there for every system, and a lesson does most of its work without it.
LARGE = ("body", "ray")
DEBIAN = {
    "pyzmq": "python3-zmq",
    "pillow": "python3-pil",
    "pyyaml": "python3-yaml",
    "python-socketio": "python3-socketio",
}


def project() -> dict[str, Any]:
    """What pyproject.toml says of the package."""
    found: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return found


def needs(*names: str) -> list[str]:
    """The requirements of pyproject.toml: the core, and for each name those of that extra or of that lesson."""
    about = project()
    found = list(about["dependencies"])
    for each in names:
        found += about["optional-dependencies"].get(each) or of_lesson(Lesson(each))
    return list(dict.fromkeys(found))


def of_lesson(lesson: Lesson) -> list[str]:
    """What the programs that `kit.py run` starts import beyond the core, but for what only a part of them uses."""
    programs = ["server.py", "client.py", *(words[0] for words in lesson.also)]
    large = [need for needs in large_extras(lesson).values() for need in needs]
    return [need for need in imported(lesson.python / program for program in programs) if need not in large]


def large_extras(lesson: Lesson) -> dict[str, list[str]]:
    """What a part of the lesson's programs imports of the extras that nobody gets unasked."""
    wanted = imported(sorted(lesson.python.glob("*.py")))
    own = {extra: [need for need in needs(extra) if need not in needs(*tests_extras())] for extra in LARGE}
    return {
        extra: found for extra, all_of_it in own.items() if (found := [need for need in all_of_it if need in wanted])
    }


def imported(files: Iterable[Path]) -> list[str]:
    """What pyproject.toml asks of the packages beyond the core that these files need, in the order it has there."""
    names = imports.packages(files)
    core = needs()
    return [need for need in needs(*all_extras()) if need not in core and module(name(need)) in names]


def module(package: str) -> str:
    """`zmq` of `pyzmq`: the name to import."""
    return IMPORTS.get(package, package.replace("-", "_"))


def all_extras() -> list[str]:
    """Every extra that pyproject.toml names."""
    return list(project()["optional-dependencies"])


def tests_extras() -> list[str]:
    """What the whole of the tests can use."""
    return [extra for extra in all_extras() if extra not in LARGE]


def name(requirement: str) -> str:
    """`pyzmq` of `pyzmq>=24`."""
    return requirement.split(">")[0].split("=")[0].split("<")[0].split(";")[0].strip().lower()


# Run by the interpreter in question: which of the packages it lacks. One that cannot be imported is not there, whatever
# its folder says, and one that is too old for us is not either.
LACKING = """
import importlib, importlib.metadata, re, sys
def lacks(package, module, limits):
    try:
        importlib.import_module(module)
        have = numbers(importlib.metadata.version(package)) if limits else []
    except Exception:
        return True
    return not all(have >= numbers(at) if how == ">=" else have < numbers(at) for how, at in limits)
def numbers(version):
    return [int(number) for number in re.findall(r"\\d+", version)[:3]]
print("lacks:", *[each[0] for each in {needs!r} if lacks(*each)] if sys.version_info >= (3, 11) else ["Python"])
"""


def lacking(python: Path | str, requirements: list[str]) -> list[str]:
    """The packages that this interpreter lacks, or has in a version that does not fit."""
    needs = [(name(need), module(name(need)), re.findall(r"(>=|<)([\d.]+)", need)) for need in requirements]
    result = quietly([python, "-c", LACKING.replace("{needs!r}", repr(needs))], limit=60)
    # A package may print something of its own when it is imported.
    said = re.search(r"^lacks:(.*)", result.output, re.MULTILINE)
    return said[1].split() if said else [name(need) for need in requirements]


def has(python: Path | str, requirements: list[str]) -> bool:
    """True if this interpreter is recent enough and has every package, in a version that fits."""
    return not lacking(python, requirements)


def not_found(python: Path, packages: list[str]) -> list[str]:
    """Those that this interpreter has nothing of. To import some, such as MediaPipe, would take seconds."""
    modules = {package: module(package) for package in packages}
    code = "import importlib.util, sys; print(*filter(importlib.util.find_spec, sys.argv[1:]))"
    there = quietly([python, "-c", code, *modules.values()], limit=60).output.split()
    return [package for package in packages if modules[package] not in there]


def requirement(package: str) -> str:
    """What pyproject.toml asks of a package, such as `websockets>=13`."""
    return next((need for need in needs(*all_extras()) if name(need) == package), package)


def interpreter(*extras: str, optional: tuple[str, ...] = ()) -> Path:
    """The interpreter to run the lessons with; sets it up if need be. `optional` extras are nice to have."""
    required, wanted = needs(*extras), needs(*extras, *optional)
    key = hashlib.sha256(json.dumps([wanted, sys.version, pip_environment()]).encode()).hexdigest()
    known = remembered(key)
    if known and has(known, required):
        return known
    python = from_pip(required, wanted) or from_this_machine(required) or from_debian(required, wanted)
    if python is None:
        cure = f"{Path(sys.executable).name} -m pip install {' '.join(map(name, required))}"
        if any(PACKAGES.glob("*.whl")):
            mine = f"--system {HERE} --python {sys.version_info[0]}.{sys.version_info[1]}"
            cure = f"{KIT} pack {mine} ({PACKAGES.name} is for another Python or system)"
            if not any(quietly([sys.executable, "-m", pip, "--version"], limit=60).ok for pip in ("pip", "ensurepip")):
                raise KitError(f"{sys.executable} has no pip: with internet install it (Debian, Ubuntu: python3-venv)")
        missing = ", ".join(map(name, required))
        raise KitError(f"no Python with {missing} here, and no package index answers; with internet run: {cure}")
    keep(CHOICE, json.dumps({**recall(CHOICE), key: str(python)}))
    return python


def found(*extras: str) -> Path | None:
    """The interpreter that lessons run with, or would; sets up nothing."""
    known = [path for path in recall(CHOICE).values() if isinstance(path, str)]
    near = map(Path, [str(venv_python()), *reversed(known), sys.executable, *SYSTEM])
    return next((python for python in near if python.exists() and has(python, needs(*extras))), None)


def pip_environment() -> list[str]:
    """The settings a user may have made for pip: a change of them is a reason to ask again."""
    return sorted(f"{key}={value}" for key, value in os.environ.items() if key.startswith("PIP_"))


def remembered(key: str) -> Path | None:
    """What an earlier run with the same needs has settled on."""
    python = recall(CHOICE).get(key)
    return Path(python) if isinstance(python, str) and Path(python).exists() else None


def venv_python() -> Path:
    return VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def from_pip(required: list[str], wanted: list[str]) -> Path | None:
    """.venv, filled by pip; None when there is no pip, no venv module or no index that answers."""
    python = venv_python()
    if has(python, wanted):
        return python
    if not writable(BUILD):
        say(UNWRITABLE)
        return None
    made = not quietly([python, "-c", ""], limit=60).ok
    if made and not make_venv():
        return None
    for requirements in [wanted] if wanted == required else [wanted, required]:
        result = install(python, requirements)
        if result.ok and not has(python, required) and not made:
            # Pip takes for whole what has lost a file.
            say("a package in .venv is damaged: making it anew")
            made = True
            result = install(python, requirements) if make_venv() else result
        if result.ok and has(python, requirements):
            return python
        if result.ok:
            say(f"pip could not give {', '.join(lacking(python, requirements))}")
        elif any(words in result.output for words in NOTHING):
            say("pip found no package index, or not all of it there")
        else:
            say(f"pip could not: {result.first('ERROR', 'error', 'No module').removeprefix('ERROR: ')}")
    if made:
        remove(VENV)
    return None


def install(python: Path, requirements: list[str]) -> Result:
    """Let pip install into .venv: from the folder that was brought along, or else from an index."""
    pip: list[str | Path] = [python, "-m", "pip"]
    if not quietly([*pip, "--version"], limit=60).ok:
        # A venv without pip of its own (Debian without python3-venv): the pip of this interpreter installs into it.
        pip = [Path(sys.executable), "-m", "pip", "--python", python]
    # One try and ten seconds: pip's own default goes on for minutes when no index can be reached.
    limits = ["--retries", "0", "--timeout", "10", "--prefer-binary"]
    command = [*pip, "install", "--quiet", "--disable-pip-version-check", *limits, *requirements]
    what = f"installing {', '.join(map(name, requirements))} into .venv"
    if any(PACKAGES.glob("*.whl")):
        result = step(f"{what} from packages", [*command, "--no-index", "--find-links", PACKAGES], limit=600)
        if result.ok:
            return result
    return step(what, command, limit=600)


def make_venv() -> bool:
    """Make .venv, with pip or, where the distribution left that out, without."""
    for option in ([], ["--without-pip"]):
        # What a failed try leaves behind, or something else of this name, would look like an environment to the next.
        remove(VENV)
        if quietly([sys.executable, "-m", "venv", *option, VENV], limit=120).ok:
            return True
    remove(VENV)
    say("this Python cannot make a virtual environment (on Debian the package is python3-venv)")
    return False


def remove(path: Path) -> None:
    """A folder, or what is there in its place."""
    if path.is_symlink() or path.is_file():
        path.unlink()
    else:
        shutil.rmtree(path, ignore_errors=True)


def from_this_machine(required: list[str]) -> Path | None:
    """An interpreter that has the packages already."""
    names = ["python3", "python", *(f"python3.{minor}" for minor in range(11, 20)), *SYSTEM]
    found = [sys.executable, *(shutil.which(candidate) for candidate in names)]
    for python in dict.fromkeys(path for path in found if path):
        if has(python, required):
            say(f"using {python}, which has {', '.join(map(name, required))}")
            return Path(python)
    return None


def from_debian(required: list[str], wanted: list[str]) -> Path | None:
    """The distribution's packages, for its own python3."""
    python = Path("/usr/bin/python3")
    if os.name == "nt" or not shutil.which("apt-get") or os.geteuid() != 0 or not python.exists():
        return None
    env = {"DEBIAN_FRONTEND": "noninteractive"}
    # The lists may be missing or old on a machine where nobody has installed anything yet.
    step("apt-get update", ["apt-get", "update"], limit=120, env=env)
    packages = {need: DEBIAN.get(name(need), f"python3-{name(need)}") for need in wanted}
    # One that is not in this distribution must not keep the others away.
    known = [need for need in wanted if need in required or quietly(["apt-cache", "show", packages[need]], limit=60).ok]
    for requirements in [known] if known == required else [known, required]:
        asked = [packages[need] for need in requirements]
        command = ["apt-get", "install", "--yes", "--no-install-recommends", *asked]
        result = step(f"installing {', '.join(asked)} with apt", command, limit=300, env=env)
        if result.ok and has(python, required):
            return python
        say(f"apt could not: {result.first('E:')}")
    return None
