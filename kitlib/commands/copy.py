"""Copies a lesson's programs, or a module of the package, into a folder of the user's own, with all that they need."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable
from pathlib import Path

from kitlib import doors, imports
from kitlib.files import digest, news, place
from kitlib.lessons import KIT, PACKAGE, ROOT, KitError, Lesson, UsageError, find
from kitlib.setup import python_setup
from kitlib.terminal import command, say
from kitlib.unity.scripts import code, without_unity

ABOUT = (
    "Copies a lesson's Python programs and just those modules of netmq_example that they import into a folder of yours,"
    " where they run by themselves."
)
EXAMPLES = [
    "copy 1 ../hello                     server.py and client.py of lesson 01, and what they import",
    'copy 9 "../My Game/python"          several lessons in one folder share their modules',
    "copy netmq_example.messages ../x    one module of the package",
    "copy 1 ../hello --csharp            lesson 01's C# files that need no Unity, for a .NET project",
]
CURE = 'a path with a space in it goes between quotation marks: copy 1 "../My Game"'
# Beside them, as the licence asks.
LICENCE = "NetMQExample_LICENSE.txt"


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", metavar="LESSON", help="its number or its name, or a module of netmq_example")
    parser.add_argument("folder", type=a_folder, metavar="FOLDER", help="where to; it is made if it is not there")
    parser.add_argument("--csharp", action="store_true", help="its C# files that need no Unity instead")
    parser.add_argument("--force", action="store_true", help="overwrite files that differ")


def a_folder(text: str) -> Path:
    # To Path the empty text is the folder where one is, such as of a variable that nobody has set.
    if not text:
        raise argparse.ArgumentTypeError("it is empty: name a folder, . for this one")
    return Path(text)


def do(options: argparse.Namespace) -> int:
    of_the_package = options.what.split(".")[0] == imports.IMPORT_NAME
    if options.csharp and of_the_package:
        raise UsageError(f"--csharp is for a lesson: leave it out, {options.what} is Python")
    if options.csharp:
        files, steps = csharp(find(options.what))
    elif of_the_package:
        files, steps = module(options.what)
    else:
        files, steps = programs(find(options.what), options.folder)
    write(options.folder, files, options.force)
    for line in steps:
        say(line)
    return 0


def programs(lesson: Lesson, folder: Path) -> tuple[dict[str, bytes], list[str]]:
    found = sorted(lesson.python.glob("*.py"))
    needs = python_setup.needs(lesson.key)
    others = [need for need in python_setup.imported(found) if need not in needs]
    some = f"; for some of it also {names(others)}" if others else ""
    python, server = python_setup.found(lesson.key), folder / lesson.key / "server.py"
    # Without one that has the packages: this command installs them first.
    start = command(python, server) if python else f"{KIT} server {command(server)}"
    return sources(found), [f"needs: {names(needs)}{some}", f"next: {start}"]


def module(name: str) -> tuple[dict[str, bytes], list[str]]:
    file = imports.file_of(name, ROOT) if re.fullmatch(r"\w+(\.\w+)*", name) else None
    if not file:
        raise UsageError(f"there is no module {name}; {imports.PYTHON / imports.IMPORT_NAME} has them")
    found = sorted(file.parent.rglob("*.py")) if file.name == "__init__.py" else [file]
    files = sources(found)
    if name == imports.IMPORT_NAME:
        # By it a type checker reads the types of a package.
        files[f"{name}/py.typed"] = file.with_name("py.typed").read_bytes()
    return files, [f"needs: {names([*python_setup.needs(), *python_setup.imported(found)])}"]


def csharp(lesson: Lesson) -> tuple[dict[str, bytes], list[str]]:
    """A lesson's plain C#, by the folders that it has in the Unity package."""
    found = without_unity(lesson)
    text = "\n".join(map(code, found))
    packages = [name for name in ("NetMQ", "Newtonsoft.Json") if re.search(rf"^using {re.escape(name)}\b", text, re.M)]
    needs = ", ".join(packages) or "nothing but .NET"
    return {path.relative_to(PACKAGE).as_posix(): path.read_bytes() for path in found}, [
        f"needs: {needs}; docs/guide/without_unity.md has a project for it"
    ]


def sources(files: Iterable[Path]) -> dict[str, bytes]:
    """Files of the folder python and what they import, by their names there."""
    found = imports.modules(files)
    return {path.relative_to(imports.PYTHON).as_posix(): path.read_bytes() for path in [*found, *imports.data(found)]}


def opened(folder: Path, files: Iterable[str]) -> tuple[dict[str, bytes], dict[str, bytes]]:
    """Each door of the copy, by its name: as an earlier copy has left it, and as it leads to what is there then."""
    there = {path.relative_to(folder).as_posix() for path in (folder / imports.IMPORT_NAME).rglob("*.py")}
    names = there.union(files)
    inits = [name for name in names if name.endswith("/__init__.py") and (imports.PYTHON / name).is_file()]
    was, become = ({name: doors.fitted(imports.PYTHON / name, some) for name in inits} for some in (there, names))
    return was, {name: data for name, data in become.items() if name in files or data != was[name]}


def names(needs: Iterable[str]) -> str:
    return ", ".join(map(python_setup.name, needs))


def write(folder: Path, files: dict[str, bytes], force: bool) -> None:
    """All of them or none; a file that differs stays, unless it is told otherwise."""
    if folder.exists() and not folder.is_dir():
        raise KitError(f"{folder} is a file: name a folder")
    was, become = opened(folder, files)
    files = {**files, **become, LICENCE: (ROOT / "LICENSE").read_bytes()}
    for name in files:
        if (folder / name).is_dir():
            raise KitError(f"{folder / name} is a folder, and a file of this name would be copied: nothing was")
        for parent in (folder / name).parents:
            if parent != folder and parent.is_relative_to(folder) and parent.exists() and not parent.is_dir():
                raise KitError(f"{parent} is a file, and a folder of this name would be made: nothing was copied")
    # A door that an earlier copy wrote is opened further, and is nobody's change.
    known = {name: digest(data) for name, data in was.items()}
    found = news(folder, files, known, "" if force else f"in {folder} differs")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        place(folder, found)
    except OSError as error:
        raise KitError(f"could not write into {folder}: {error}; name another folder, or make room") from None
    for name in found:
        say(f"wrote {folder / name}")
    if len(files) > len(found):
        say(f"{len(files) - len(found)} files were there already")
