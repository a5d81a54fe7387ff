"""Puts the lessons' scripts and NetMQ's DLLs into a user's own Unity project.

Nothing is written before everything is at hand and nothing stands in the way: an interrupted run leaves no half.
"""

import json
import os
import re
from collections.abc import Iterator, Set
from pathlib import Path

from kitlib.files import digest, news, place, put
from kitlib.lessons import KIT, PACKAGE, ROOT, KitError, find, lessons, read_json
from kitlib.terminal import command, say
from kitlib.unity.inventory import JSON_DLL, TARGET, Inventory, unity_version
from kitlib.unity.libraries import PLUGINS, libraries, notices
from kitlib.unity.meta import behaviours
from kitlib.unity.project import OLDEST, advice, check_foreign, check_moved, find_project, has_scripts
from kitlib.unity.scripts import JSON, ML_AGENTS, code, scripts, unitys_packages

ALONE = "the scripts alone: they need NetMQ.dll and the DLLs that it needs"
# The files that this command wrote, and so may write again. Unity ignores names that begin with a dot.
RECORD = f"{TARGET}/.kit.json"


def install(
    project: Path,
    lesson: str | None = None,
    force: bool = False,
    scripts_only: bool = False,
    dlls: Path | None = None,
    there: Inventory | None = None,
) -> None:
    """Copy the package, or what one lesson needs of it, and the DLLs; a KitError says why not.

    The DLLs come from the folder `dlls`, or else from NuGet. `there`: what the project has, or will have.
    """
    root = find_project(project)
    there = there or Inventory(root)
    files, wrong = prepare(root, lesson, there)
    if by := has_scripts(root):
        say(f"the scripts come from {by}: they are not copied")
    if scripts_only:
        say(ALONE)
    elif not there.missing("NetMQ.dll"):
        say("NetMQ is in this project already: its DLLs are left as they are")
    else:
        files |= libraries(dlls, there.missing)
    write(root, files, force, dlls=not scripts_only)
    # Also of other lessons, which are there already: all are one assembly.
    here = {path.as_posix(): path.read_bytes() for path in (root / TARGET).rglob("*.cs")}
    add_packages(root, unitys_packages(here), there)
    left = [*wrong, *advice(root)]
    if there.missing("NetMQ.dll") and not (root / PLUGINS / "NetMQ.dll").exists():
        left.append("first bring the DLLs: route (b) or (d) of docs/guide/unity_project.md")
    if unity_version(root) < OLDEST:
        left.append("try it: this Unity is older than 2022.3, for which the kit is made; the lesson compiles there")
    for line in [*(f"left for you: {line}" for line in left), *next_steps(root, lesson)]:
        say(line)


def prepare(root: Path, lesson: str | None, there: Inventory) -> tuple[dict[str, bytes], list[str]]:
    """The files to copy, and what is wrong with the project's own NetMQ; a KitError if something is in the way."""
    # Unity reads no link.xml in a package. Without our .meta, whose GUID the package's own file has.
    alone = {f"{TARGET}/link.xml": (PACKAGE / "link.xml").read_bytes()}
    files = alone if has_scripts(root) else {**scripts(lesson), **notices()}
    check_age(root, lesson, files)
    wrong = list(there.check_netmq())
    check_moved(root, files)
    check_foreign(root, files)
    return files, wrong


def check_age(root: Path, lesson: str | None, files: dict[str, bytes]) -> None:
    """A KitError if this Unity is too old for these files."""

    def steps_physics(some: dict[str, bytes]) -> bool:
        return any(b"Physics.simulationMode" in data for data in some.values())

    age = unity_version(root)
    if age >= OLDEST or (age >= (2021, 2) and not steps_physics(files)):
        return
    reason, cure = "NetMQ needs 2021.2 or later (.NET Standard 2.1), all lessons 2022.3", ""
    if age >= (2021, 2):
        of_no_lesson = {None: "the whole package", ML_AGENTS: "ML-Agents' shape"}
        reason = f"{of_no_lesson.get(lesson, f'lesson {lesson} steps physics, which')} needs 2022.3 or later"
    if age >= (2021, 2) and lesson != ML_AGENTS:
        able = [str(one.number) for one in lessons() if not steps_physics(scripts(str(one.number)))]
        cure = f"--lesson takes {', '.join(able[:-1])} or {able[-1]} here; for the others "
    cure += "open a copy of the project with a newer editor in Unity Hub"
    raise KitError(f"this project is for Unity {age[0]}.{age[1]}; {reason}: nothing was copied; {cure}")


def add_packages(root: Path, needed: dict[str, str], there: Inventory) -> None:
    """Name in the project's manifest what nothing brings, and keep the manifest's look."""
    wanted = {name: version for name, version in needed.items() if name not in there.packages}
    if not there.missing(JSON_DLL):
        wanted.pop(JSON[0], None)
    if not wanted:
        return
    # Of a link the file behind it.
    path = (root / "Packages" / "manifest.json").resolve()
    try:
        if path.exists() and not os.access(path, os.W_OK):
            raise PermissionError("it is read-only")
        put(path, with_packages(path.read_bytes().decode(), wanted).encode())
    except OSError as error:
        names = ", ".join(wanted)
        why = error.strerror or error
        say(f"Packages/manifest.json cannot be written ({why}): add in Unity's Package Manager: {names}")
        return
    for name, version in wanted.items():
        say(f"added {name} {version} to Packages/manifest.json")
    for copy in there.copies:
        if JSON[0] in wanted and copy.name == JSON_DLL and copy.parts and copy.where.startswith("Assets/"):
            say(f"delete {copy.where}: a game needs JSON in the editor and in builds, and of {JSON[0]} it has both")


def with_packages(old: str, wanted: dict[str, str], removed: Set[str] = frozenset()) -> str:
    """A manifest that names other packages, with its own look."""
    indent = re.search(r"^([ \t]+)\S", old, re.MULTILINE)
    manifest = json.loads(old.removeprefix("\ufeff"))
    named = manifest.get("dependencies", {})
    manifest["dependencies"] = {name: version for name, version in named.items() if name not in removed} | wanted
    text = json.dumps(manifest, indent=indent[1] if indent else 2, ensure_ascii=False)
    text = text + "\n" if old.endswith("\n") else text
    return "\ufeff" * old.startswith("\ufeff") + text.replace("\n", "\r\n" if "\r\n" in old else "\n")


def write(root: Path, files: dict[str, bytes], force: bool, dlls: bool) -> None:
    """All of them or none. With `dlls`, a DLL that an earlier run wrote and this one does not is deleted."""
    record = read_json(root / RECORD)
    # Unity writes .meta files itself, and other files may refer to what they say: one that is not ours stays.
    metas = [name for name in files if name.endswith(".meta") and (root / name).exists()]
    unitys = [name for name in metas if digest((root / name).read_bytes()) != record.get(name)]
    wanted = {name: data for name, data in files.items() if name not in unitys}
    found = news(root, wanted, record, "" if force else "was changed in your project")
    # On Windows a file that is read-only cannot be replaced: version control makes them so until they are checked out.
    if locked := [name for name in found if (root / name).exists() and not os.access(root / name, os.W_OK)]:
        raise KitError(f"{locked[0]} is read-only: nothing was copied; check it out first, or clear the attribute")
    try:
        place(root, found)
        record |= {name: digest(data) for name, data in found.items()}
        if remove_outdated(root, record, files, dlls) or found:
            (root / RECORD).write_text(json.dumps(record, indent=1, sort_keys=True), encoding="utf-8")
    except OSError as error:
        raise KitError(f"could not write into {root}: {error}; close Unity, or make room, and run this again") from None
    for name in found:
        if not name.endswith(".meta"):
            say(f"wrote {name}")
    same = sum(not name.endswith(".meta") for name in files.keys() - found.keys())
    if same:
        say(f"{same} files were there already")


def remove_outdated(root: Path, record: dict[str, str], files: dict[str, bytes], dlls: bool) -> bool:
    """Delete what this command has written and the project must not have any more: two scripts with one class do not
    compile, nor do two DLLs of one name."""
    licences = notices()

    def stays(name: str) -> bool:
        # The record comes with the project, and so from anybody.
        if name in files or not name.startswith(f"{TARGET}/") or ".." in Path(name).parts:
            return True
        if name.startswith(PLUGINS):
            return not dlls
        return name in licences or (PACKAGE / name.removeprefix(f"{TARGET}/")).exists()

    old = [name for name in record if not stays(name)]
    for name in delete(root, record, old):
        why = "another package brings it" if name.startswith(PLUGINS) else "it is no longer a part of the kit"
        say(f"deleted {name}: {why}")
    return bool(old)


def delete(root: Path, record: dict[str, str], names: list[str]) -> Iterator[str]:
    """Delete these files of the kit, here and in its record, where they are as it wrote them; the names of those that
    are not .meta files."""
    # A script before its .meta, which stays where the script does; what is in a folder before the folder's.
    for name in sorted(names, key=lambda name: (name.endswith(".meta"), -name.count("/"))):
        path, known = root / name, record.pop(name)
        if not path.is_file() or (name.endswith(".meta") and path.with_suffix("").is_file()):
            continue
        if digest(path.read_bytes()) != known:
            say(f"{name} is no longer a part of the kit, and stays because you have changed it: delete it if you can")
            continue
        path.unlink()
        if not any(path.parent.iterdir()):
            path.parent.rmdir()
        if not name.endswith(".meta"):
            yield name


def next_steps(root: Path, lesson: str | None) -> list[str]:
    """The words to type and the buttons to press now."""
    if lesson == ML_AGENTS:
        return [
            "next, in a terminal: python -m netmq_example.mlagents_learn and your YAML file, or your own program with"
            " netmq_example.mlagents_envs; docs/guide/from_ml_agents.md has both",
            "then, in Unity: wait for the import, open your scene; and press Play",
        ]
    found = find(lesson or "1")
    key = found.key
    scripts = behaviours(PACKAGE / key)
    components = ", ".join("your agent or " * (": Agent\n" in code(path)) + path.stem for path in scripts)
    scene = f"{TARGET}/{key}/{key}.unity"
    there = f"open {scene}" if (root / scene).exists() else f"add to one GameObject: {components}"
    return [
        # The terminal may be in any folder.
        f"next, in a terminal: {command(KIT.split()[0], ROOT / 'kit.py', 'server', str(found.number))}",
        f"then, in Unity: wait for the import, {there}; and press Play",
    ]
