"""Fills a folder with what a room without internet needs; beside kit.py, as `packages`, it is used by itself."""

import argparse
import re
import shutil
import sys
import tempfile
from pathlib import Path

from kitlib.lessons import PACKAGES, ROOT, KitError, UsageError, lessons
from kitlib.programs import step
from kitlib.setup import dotnet, python_setup
from kitlib.terminal import say
from kitlib.unity.libraries import LICENCES

# The tags that pip knows a system's wheels by, newer ones first, for each kind of processor. On macOS pip adds those of
# earlier systems, and of wheels for both kinds.
SYSTEMS = {
    "windows": [["win_amd64"]],
    "macos": [["macosx_14_0_arm64"], ["macosx_14_0_x86_64"]],
    "linux": [["manylinux_2_28_x86_64", "manylinux_2_26_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"]],
}


ABOUT = "Fetches what a room without internet needs: wheels for Python, NuGet packages, and where the installers are."
EXAMPLES = [
    "pack                                   into packages/, for this system",
    "pack --system windows --python 3.13    for another one, into the same folder",
]


def add_options(parser: argparse.ArgumentParser) -> None:
    where = "packages, if not said"
    parser.add_argument("folder", type=Path, nargs="?", default=PACKAGES, metavar="FOLDER", help=where)
    help = "the room's; this one, if not said"
    parser.add_argument("--system", choices=tuple(SYSTEMS), default=python_setup.HERE, help=help)
    help = "the room's; this one's, if not said"
    parser.add_argument("--python", metavar="VERSION", default=python_setup.VERSION, help=help)


def do(options: argparse.Namespace) -> int:
    """Fetch everything that the lessons and their tests need. What is there for another system stays."""
    folder, system, version = options.folder, options.system, options.python
    if not re.fullmatch(r"3\.(1[1-9]|[2-9]\d)(\.\d+)?", version):
        raise UsageError(f"--python takes a version of 3.11 or later, such as 3.13, not {version}")
    sdk = dotnet.sdk()
    if not sdk:
        raise KitError(dotnet.download())
    folder.mkdir(parents=True, exist_ok=True)
    for tags in SYSTEMS[system]:
        wheels(folder, system, version, tags)
    nuget(folder)
    note = folder / f"READ_ME_{system}_{version}.txt"
    text = (ROOT / "kitlib" / "notes" / f"{system}.txt").read_text(encoding="utf-8")
    # An SDK of another number may lack what this one has in its own folder, and so did not fetch.
    note.write_text(text.format(python=version, sdk=sdk.split(".")[0]), encoding="utf-8")
    say(f"{folder} is ready; its {note.name} says what to do with it")
    return 0


def wheels(folder: Path, system: str, version: str, tags: list[str]) -> None:
    """The Python packages of all lessons and their tests, by the pip of .venv or of this interpreter."""
    needs = python_setup.needs(*(lesson.key for lesson in lessons()), "guide", "tests", "tests-more")
    # Pytest needs it on Windows alone, and pip asks on which system it runs itself.
    needs += ["colorama"] if system == "windows" else []
    own = python_setup.venv_python()
    platforms = [word for tag in tags for word in ("--platform", tag)]
    command = [*python_setup.alone(own if own.exists() else sys.executable), "-m", "pip", "download", "--quiet"]
    command += ["--disable-pip-version-check", "--only-binary=:all:", "--dest", folder]
    command += ["--python-version", version, *platforms, *needs]
    what = f"fetching {', '.join(map(python_setup.name, needs))} for {system}, Python {version} ({tags[0]})"
    result = step(what, command, 600, python_setup.ELSEWHERE)
    if not result.ok:
        why = f"fetch them for {tags[0]}, Python {version}: {result.first('ERROR', 'No module')}"
        raise KitError(f"pip could not {why}; try again with internet, or another --python")


def nuget(folder: Path) -> None:
    """All that a restore of the C# client takes from NuGet: NetMQ, and what comes with it."""
    store = dotnet.nuget_folder()
    # A source that is not there is an error.
    store.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as fetched:
        # The packages of this machine need not come over the net again.
        here = f"-p:RestoreAdditionalProjectSources={dotnet.escaped(store)}"
        made = f"-p:ArtifactsPath={dotnet.escaped(Path(fetched, 'made'))}"
        words = [*dotnet.NetMQ().properties, here, made, "--packages", fetched]
        command: list[str | Path] = ["dotnet", "restore", dotnet.CONSOLE, *words]
        result = step("fetching NetMQ from NuGet", command, dotnet.TIMEOUT, dotnet.ENVIRONMENT, ROOT)
        if not result.ok:
            raise KitError(f"{dotnet.refusal(result)}: no C# client in {folder}; try again with internet")
        for package in Path(fetched).glob("*/*/*.nupkg"):
            shutil.copy(package, folder)
    # NetMQ's packages have none.
    shutil.copytree(LICENCES, folder / LICENCES.name, dirs_exist_ok=True)
