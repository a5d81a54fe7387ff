"""An interpreter that has what a lesson needs, on whatever machine this is.

In this order: .venv filled by pip; an interpreter that has the packages already; as root on Debian or Ubuntu, the
distribution's packages; otherwise one line that says what to run.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import sys
import tomllib
from pathlib import Path

from .lessons import ROOT, KitError
from .terminal import quietly, say, step

VENV = ROOT / ".venv"
CHOICE = ROOT / ".build" / "python.json"
# The name to import, and the distribution's package, where they are not simply the name on PyPI.
IMPORTS = {"pyzmq": "zmq", "pytest-timeout": "pytest_timeout", "pillow": "PIL", "pyyaml": "yaml", "grpcio": "grpc"}
DEBIAN = {"pyzmq": "python3-zmq", "pillow": "python3-pil", "pyyaml": "python3-yaml"}


def needs(*extras: str) -> list[str]:
    """The requirements of pyproject.toml: the core and the named extras, if there are such extras."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found = list(project["dependencies"])
    for extra in extras:
        found += project["optional-dependencies"].get(extra, [])
    return list(dict.fromkeys(found))


def all_extras() -> list[str]:
    """Every extra that pyproject.toml names: what the whole of the tests can use."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return list(project["optional-dependencies"])


def name(requirement: str) -> str:
    """`pyzmq` of `pyzmq>=24`."""
    return requirement.split(">")[0].split("=")[0].split("<")[0].split(";")[0].strip().lower()


def has(python: Path | str, requirements: list[str]) -> bool:
    """True if this interpreter is recent enough and has every package."""
    modules = [IMPORTS.get(name(need), name(need).replace("-", "_")) for need in requirements]
    code = (
        "import sys, importlib.util as u\n"
        f"sys.exit(sys.version_info < (3, 11) or any(u.find_spec(m) is None for m in {modules!r}))"
    )
    return quietly([python, "-c", code], limit=20).ok


def interpreter(*extras: str, optional: tuple[str, ...] = ()) -> Path:
    """The interpreter to run the lessons with; sets it up if need be. `optional` extras are nice to have."""
    required, wanted = needs(*extras), needs(*extras, *optional)
    key = hashlib.sha256(json.dumps([wanted, sys.version, pip_environment()]).encode()).hexdigest()
    known = remembered(key)
    if known and has(known, required):
        return known
    python = from_pip(required, wanted) or from_this_machine(required) or from_debian(required, wanted)
    if python is None:
        raise KitError(
            f"no Python with {', '.join(map(name, required))} here, and no package index answers; with internet run: "
            f"{Path(sys.executable).name} -m pip install {' '.join(map(name, required))}"
        )
    CHOICE.parent.mkdir(exist_ok=True)
    choices = json.loads(CHOICE.read_text()) if CHOICE.exists() else {}
    CHOICE.write_text(json.dumps({**choices, key: str(python)}))
    return python


def pip_environment() -> list[str]:
    """The settings a user may have made for pip: a change of them is a reason to ask again."""
    return sorted(f"{key}={value}" for key, value in os.environ.items() if key.startswith("PIP_"))


def remembered(key: str) -> Path | None:
    """What an earlier run with the same needs has settled on."""
    try:
        python = Path(json.loads(CHOICE.read_text())[key])
    except (OSError, ValueError, KeyError):
        return None
    return python if python.exists() else None


def venv_python() -> Path:
    return VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def from_pip(required: list[str], wanted: list[str]) -> Path | None:
    """.venv, filled by pip; None when there is no pip, no venv module or no index that answers."""
    python = venv_python()
    if has(python, wanted):
        return python
    made = not python.exists()
    if made and not make_venv():
        return None
    pip: list[str | Path] = [python, "-m", "pip"]
    if not quietly([*pip, "--version"], limit=60).ok:
        # A venv without pip of its own (Debian without python3-venv): the pip of this interpreter installs into it.
        pip = [Path(sys.executable), "-m", "pip", "--python", python]
    # One try and ten seconds: pip's own default goes on for minutes when no index can be reached.
    install = [
        *pip,
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--retries",
        "0",
        "--timeout",
        "10",
        "--prefer-binary",
    ]
    for requirements in [wanted] if wanted == required else [wanted, required]:
        result = step(
            f"installing {', '.join(map(name, requirements))} into .venv", [*install, *requirements], limit=600
        )
        if result.ok and has(python, requirements):
            return python
        say(f"pip could not: {result.first('ERROR', 'error', 'No module')}")
    if made:
        shutil.rmtree(VENV, ignore_errors=True)
    return None


def make_venv() -> bool:
    """Make .venv, with pip or, where the distribution left that out, without."""
    for option in ([], ["--without-pip"]):
        if quietly([sys.executable, "-m", "venv", *option, VENV], limit=120).ok:
            return True
        # What a failed try leaves behind would look like a working environment to the next.
        shutil.rmtree(VENV, ignore_errors=True)
    say("this Python cannot make a virtual environment (on Debian the package is python3-venv)")
    return False


def from_this_machine(required: list[str]) -> Path | None:
    """An interpreter that has the packages already."""
    names = [
        "python3",
        "python",
        *(f"python3.{minor}" for minor in range(11, 20)),
        "/usr/bin/python3",
        "/usr/local/bin/python3",
    ]
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
    for requirements in [wanted] if wanted == required else [wanted, required]:
        packages = [DEBIAN.get(name(need), f"python3-{name(need)}") for need in requirements]
        command = ["apt-get", "install", "--yes", "--no-install-recommends", *packages]
        what = f"installing {', '.join(packages)} with apt"
        # The lists may be missing or old on a machine where nobody has installed anything yet.
        result = step(what, command, limit=300, env=env)
        if not result.ok and step("apt-get update", ["apt-get", "update"], limit=120, env=env).ok:
            result = step(what, command, limit=300, env=env)
        if result.ok and has(python, required):
            return python
        say(f"apt could not: {result.first('E:')}")
    return None
