"""A user's own Unity project: where it is, and what in it is in the way."""

import json
import re
from collections.abc import Iterator
from pathlib import Path

from kitlib.lessons import PACKAGE, KitError, read_json
from kitlib.unity.inventory import TARGET, dependencies, imported, package_folders, package_name

# The Unity that all of the package is made for.
OLDEST = (2022, 3)
# DLLs of games that were made for .NET Framework.
STANDARD = ("System.Memory.dll", "System.Buffers.dll", "System.Numerics.Vectors.dll")


def find_project(path: Path) -> Path:
    """The Unity project that PATH is, or is inside of."""
    if '"' in str(path):
        # On Windows "C:\My Game\" arrives so, with all that follows: a backslash takes the quotation mark its meaning.
        raise KitError(f"the path is {path}: leave out the backslash before the quotation mark")
    for folder in [path.resolve(), *path.resolve().parents]:
        # Git keeps no empty Assets.
        if (folder / "ProjectSettings" / "ProjectVersion.txt").is_file():
            return folder
    reason = "it has no ProjectSettings/ProjectVersion.txt" if path.exists() else "there is no such folder"
    raise KitError(f"{path} is no Unity project: {reason}; give the folder that Unity Hub shows")


def has_scripts(root: Path) -> str:
    """By what the package is there by another route, a second copy of which would not compile; empty if it is not."""
    if (root / TARGET).resolve() == PACKAGE.resolve():
        return TARGET
    name = package_name(PACKAGE)
    by = [str(folder.relative_to(root)) for folder in package_folders(root) if package_name(folder) == name]
    return "Packages/manifest.json" if name in dependencies(root) else "".join(by)


def scripts_of_the_kit(script: Path) -> list[Path] | None:
    """The kit's scripts in the Unity project of a script; None: it lies in none, or all of the package is there."""
    try:
        root = find_project(script)
    except KitError:
        return None
    if has_scripts(root):
        return None
    # The folder may have been moved.
    folder = next((path.parent for path in imported(root / "Assets", "NetMQExample.asmdef")), root / TARGET)
    inside = {path.relative_to(folder): path for path in sorted(folder.rglob("*.cs"))}
    return [
        path for name, path in inside.items() if name.parts[0] not in ("Editor", "Tests") and (PACKAGE / name).exists()
    ]


def elsewhere(root: Path, name: str) -> list[Path]:
    """The files of this name in the project, but for those in the kit's own folder."""
    found = [path for folder in (root / "Assets", *package_folders(root)) for path in imported(folder, name)]
    return [path for path in found if not path.is_relative_to(root / TARGET)]


def check_moved(root: Path, scripts: dict[str, bytes]) -> None:
    """A KitError if a script that was moved inside the project, its .meta with it, would be there twice."""
    ours = {Path(name).name: name for name in scripts}
    # Of a game's many files only those of the same name are read.
    for other in (path for path in elsewhere(root, "*.cs.meta") if path.name in ours):
        name = ours[other.name]
        # The second line says the GUID.
        if scripts[name].splitlines()[1] in other.read_bytes():
            moved = other.relative_to(root).as_posix().removesuffix(".meta")
            raise KitError(
                f"{moved} is {name.removesuffix('.meta')}, moved: nothing was copied, because two of them do not "
                "compile; move it back with its .meta, or delete it"
            )


def check_foreign(root: Path, files: dict[str, bytes]) -> None:
    """A KitError if an assembly would be there twice, or a user's own scripts would become a part of the kit's: an old
    example has this folder."""
    ours = {json.loads(data)["name"] for name, data in files.items() if name.endswith(".asmdef")}
    for path in elsewhere(root, "*.asmdef"):
        if (name := read_json(path).get("name")) in ours:
            raise KitError(
                f"{path.relative_to(root).as_posix()} is an assembly with the name {name}, too, and Unity refuses two: "
                "nothing was copied; rename yours"
            )
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
    """The reasons in the project for which the scripts do not compile, or may not."""
    for path in imported(root / "Assets", "System.ServiceModel.Primitives.asmdef"):
        yield f"delete {path.relative_to(root).as_posix()}: Unity refuses this name, and then compiles no script at all"
    settings = root / "ProjectSettings" / "ProjectSettings.asset"
    text = settings.read_text(encoding="utf-8", errors="replace") if settings.exists() else ""
    # 3 is NET_Unity_4_8 in UnityEditor.ApiCompatibilityLevel; 6 is NET_Standard, which new projects have.
    if re.search(r"^  apiCompatibilityLevelPerPlatform:\n(    \w+: \d+\n)*    \w+: 3$", text, re.MULTILINE):
        has = [path.name for name in STANDARD for path in imported(root / "Assets", name)]
        rest = f"; and delete {', '.join(has)}, which .NET Standard 2.1 has itself" if has else ""
        yield f"set Project Settings, Player, Api Compatibility Level to .NET Standard 2.1: it is .NET Framework{rest}"
    if not (root / "Library").exists() and any((root / TARGET).rglob("*.dll")):
        yield "open the project in Unity, then run this again: it deletes DLLs that packages of yours bring as well"
