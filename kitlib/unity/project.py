"""A user's own Unity project: where it is, what it has already, and what in it is in the way."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

from kitlib.lessons import PACKAGE, KitError
from kitlib.terminal import say

# Where the kit's files go in it.
TARGET = "Assets/NetMQExample"
# Where a DLL may be wanted.
PARTS = {"editor", "builds"}
# The Unity that all of the package is made for.
OLDEST = (2022, 3)


def find_project(path: Path) -> Path:
    """The Unity project that PATH is, or is inside of."""
    if '"' in str(path):
        # On Windows "C:\My Game\" arrives so, with all that follows: a backslash takes the quotation mark its meaning.
        raise KitError(f"the path is {path}: leave out the backslash before the quotation mark")
    for folder in [path.resolve(), *path.resolve().parents]:
        if (folder / "Assets").is_dir() and (folder / "ProjectSettings" / "ProjectVersion.txt").is_file():
            return folder
    lacks = [name for name in ("Assets", "ProjectSettings/ProjectVersion.txt") if not (path / name).exists()]
    reason = f"it has no {' and no '.join(lacks)}" if path.exists() else "there is no such folder"
    raise KitError(f"{path} is no Unity project: {reason}; give the folder that Unity Hub shows")


def version(root: Path) -> tuple[int, int]:
    """That of the project's Unity, such as (2022, 3); a far later one where it cannot be read."""
    text = (root / "ProjectSettings" / "ProjectVersion.txt").read_text(encoding="utf-8", errors="replace")
    found = re.search(r"^m_EditorVersion: (\d+)\.(\d+)", text, re.MULTILINE)
    return (int(found[1]), int(found[2])) if found else (9999, 0)


def check_age(root: Path, lesson: str | None, files: dict[str, bytes]) -> None:
    """A KitError if this Unity is too old for these files."""
    major, minor = version(root)
    if (major, minor) < (2021, 2):
        raise KitError(f"this project is for Unity {major}.{minor}; NetMQ needs 2021.2 or later (.NET Standard 2.1)")
    if (major, minor) >= OLDEST or not any(b"Physics.simulationMode" in data for data in files.values()):
        return
    what = f"lesson {lesson} steps physics, which" if lesson else "the whole package"
    raise KitError(
        f"this project is for Unity {major}.{minor}; {what} needs 2022.3 or later: nothing was copied; "
        "--lesson 4 copies one that steps no physics"
    )


def packages_of(root: Path) -> dict[str, str]:
    """The packages that the project names, with their versions."""
    path = root / "Packages" / "manifest.json"
    if not path.exists():
        return {}
    try:
        dependencies = json.loads(path.read_text(encoding="utf-8-sig")).get("dependencies", {})
        if not isinstance(dependencies, dict):
            raise ValueError("its dependencies are no object")
    except (ValueError, AttributeError) as error:
        raise KitError(f"{path} is no valid manifest: {error}; correct it, Unity cannot open it either") from None
    return dependencies


def all_packages(root: Path, manifest: dict[str, str]) -> set[str]:
    """Also what other packages bring along, which Unity writes down once it has opened the project, and what
    NuGetForUnity is to fetch when it is opened: under the name that a package of Unity's has, org.nuget.netmq."""
    try:
        lock = json.loads((root / "Packages" / "packages-lock.json").read_text(encoding="utf-8-sig"))
        brought = set(lock["dependencies"])
    except (OSError, ValueError, KeyError, TypeError):
        brought = set()
    brought |= {path.name.split("@")[0] for path in (root / "Library" / "PackageCache").glob("org.nuget.*@*")}
    listed = root / "Assets" / "packages.config"
    text = listed.read_text(encoding="utf-8", errors="replace") if listed.exists() else ""
    brought |= {f"org.nuget.{name.lower()}" for name in re.findall(r"<package\s[^>]*\bid=\"([^\"]+)", text)}
    return brought | set(manifest)


def has_scripts(root: Path, manifest: dict[str, str]) -> bool:
    """True if the package is there by another route; a second copy would not compile."""
    if (root / TARGET).resolve() == PACKAGE.resolve():
        return True
    name = json.loads((PACKAGE / "package.json").read_text(encoding="utf-8"))["name"]
    if name in manifest:
        say(f"the scripts come from {name} in Packages/manifest.json: they are not copied")
    return name in manifest


def scripts_of_the_kit(script: Path) -> list[Path] | None:
    """What the Unity project of a script has of the kit's; None: it lies in none, or all of the package is there."""
    try:
        root = find_project(script)
    except KitError:
        return None
    package = json.loads((PACKAGE / "package.json").read_text(encoding="utf-8"))["name"]
    if (root / TARGET).resolve() == PACKAGE.resolve() or package in packages_of(root):
        return None
    # The folder may have been moved.
    folder = next((path.parent for path in imported(root / "Assets", "NetMQExample.asmdef")), root / TARGET)
    inside = {path.relative_to(folder): path for path in sorted(folder.rglob("*.cs"))}
    return [
        path for name, path in inside.items() if name.parts[0] not in ("Editor", "Tests") and (PACKAGE / name).exists()
    ]


def other_dlls(root: Path) -> list[Path]:
    """Those of the project, and of the packages that Unity has fetched for it."""
    cache = root / "Library" / "PackageCache"
    # Unity ignores what has no .meta in a package, where it can write none.
    cached = [path for path in imported(cache, "*.dll") if path.with_name(f"{path.name}.meta").exists()]
    return [*elsewhere(root, "*.dll"), *cached]


def missing(others: list[Path], packages: set[str], package: str, name: str) -> set[str]:
    """Where nothing else in the project brings this DLL: two of one name do not compile, or the wrong one is taken."""
    if f"org.nuget.{package.lower()}" in packages:
        return set()
    return PARTS.difference(*(served(other) for other in others if other.name == name))


def served(dll: Path) -> set[str]:
    """Where a DLL is used, by its .meta: com.unity.collections has one for builds alone."""
    meta = dll.with_name(f"{dll.name}.meta")
    text = meta.read_text(encoding="utf-8", errors="replace") if meta.exists() else ""
    # Unity 6 writes no line `second:`.
    found = re.findall(r"^[ -]*(?:first:\n *)?([\w ]+):.*\n(?: *second:\n)? *enabled: (\d)", text, re.MULTILINE)
    if not found:
        return PARTS
    builds = {"builds"} if any(on == "1" for name, on in found if name != "Editor") else set()
    editor = dict(found).get("Editor", dict(found).get("Any"))
    return builds | ({"editor"} if editor == "1" else set())


def has_netmq(root: Path, packages: set[str]) -> bool:
    """True if NetMQ is there by another route; two copies of one library do not compile."""
    return "org.nuget.netmq" in packages or bool(elsewhere(root, "NetMQ.dll"))


def elsewhere(root: Path, name: str) -> list[Path]:
    """The files of this name in the project, but for those in the kit's own folder."""
    found = [path for folder in ("Assets", "Packages") for path in imported(root / folder, name)]
    return [path for path in found if not path.is_relative_to(root / TARGET)]


def imported(folder: Path, name: str) -> list[Path]:
    """The files of this name that Unity sees: it ignores what begins with a dot or ends with a tilde."""
    ignored = re.compile(r"^\.|~$")
    return [p for p in folder.rglob(name) if not any(map(ignored.search, p.relative_to(folder).parts))]


def check_moved(root: Path, scripts: dict[str, bytes]) -> None:
    """A KitError if a script that was moved inside the project, its .meta with it, would be there twice."""
    # Looked for once: a game has many files.
    others = elsewhere(root, "*.cs.meta")
    for name, meta in scripts.items():
        if not name.endswith(".cs.meta"):
            continue
        ours = re.search(rb"^guid: \S+", meta, re.MULTILINE)
        for other in (path for path in others if path.name == Path(name).name):
            if ours and ours[0] in other.read_bytes():
                moved, target = (str(path).removesuffix(".meta") for path in (other.relative_to(root).as_posix(), name))
                raise KitError(
                    f"{moved} is {target}, moved: nothing was copied, because two of them do not compile; "
                    "move it back with its .meta, or delete it"
                )


def check_foreign(root: Path, files: dict[str, bytes]) -> None:
    """A KitError if a user's own scripts would become a part of the kit's assembly: an old example has this folder."""
    assembly = f"{TARGET}/NetMQExample.asmdef"
    if assembly not in files or (root / assembly).exists():
        return
    for path in sorted((root / TARGET).rglob("*.cs")):
        if not (PACKAGE / path.relative_to(root / TARGET)).exists():
            raise KitError(
                f"{path.relative_to(root).as_posix()} is in the folder of the kit's assembly: nothing was copied; "
                f"rename {TARGET} in Unity, and run this again"
            )


def advice(root: Path) -> Iterator[str]:
    """What in the project keeps the scripts from compiling, or may do so."""
    for path in imported(root / "Assets", "System.ServiceModel.Primitives.asmdef"):
        yield f"delete {path.relative_to(root).as_posix()}: Unity refuses this name, and then compiles no script at all"
    settings = root / "ProjectSettings" / "ProjectSettings.asset"
    text = settings.read_text(encoding="utf-8", errors="replace") if settings.exists() else ""
    # 3 is NET_Unity_4_8 in UnityEditor.ApiCompatibilityLevel; 6 is NET_Standard, which new projects have.
    if re.search(r"^  apiCompatibilityLevelPerPlatform:\n(    \w+: \d+\n)*    \w+: 3$", text, re.MULTILINE):
        yield "set Project Settings, Player, Api Compatibility Level to .NET Standard 2.1: it is .NET Framework"
    if version(root) < OLDEST:
        yield "this Unity is older than 2022.3, for which the kit is made: this lesson compiles, but was not tried"
    if not (root / "Library").exists() and any((root / TARGET).rglob("*.dll")):
        yield "open the project in Unity, then run this again: it deletes DLLs that packages of yours bring as well"
