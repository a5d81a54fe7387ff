"""The files of a Unity project that are its own: not a package that was fetched, nor ML-Agents, nor the kit."""

import os
from collections.abc import Iterator
from pathlib import Path

from kitlib.unity.inventory import TARGET, package_folders, package_name
from kitlib.unity.ml_agents import FACTS

ML_AGENTS = {"com.unity.ml-agents", "com.unity.ml-agents.extensions"}
# A project's files that name scripts, and others, by their GUIDs.
SCENES = (".unity", ".prefab", ".asset", ".preset")


def copies_of_ml_agents(root: Path) -> Iterator[str]:
    """ML-Agents' own folders inside the project: a package in Packages, or its scripts in Assets."""
    for folder in package_folders(root):
        if package_name(folder) in ML_AGENTS:
            yield folder.relative_to(root).as_posix()
    known = [guid.encode() for guid in FACTS["copies"]["scripts"].split()]
    for name in walk(root, "Assets"):
        if name.endswith(("/Agent.cs.meta", "/Academy.cs.meta")):
            data = (root / name).read_bytes()
            if any(guid in data for guid in known):
                folder = Path(name).parent
                for part in (folder, folder.parent / "Editor", folder.parent / "Plugins"):
                    # Plugins of Assets itself are everybody's.
                    if (root / part).is_dir() and part.parent.name != "Assets":
                        yield part.as_posix()


def own_files(root: Path, copies: list[str]) -> Iterator[str]:
    """The files of the project's own: below Assets, and in the packages that lie in it."""
    packages = [folder.relative_to(root).as_posix() for folder in package_folders(root)]
    apart = [*copies, TARGET]
    for top in ("Assets", *packages):
        for name in walk(root, top):
            if not any(name.startswith(f"{folder}/") for folder in apart):
                yield name


def walk(root: Path, top: str) -> Iterator[str]:
    """The names of the files that Unity imports, in order; nothing behind a link, which may lead out of the project."""
    for folder, folders, files in os.walk(root / top):
        here = Path(folder)
        if is_link(here):
            folders.clear()
            continue
        folders.sort()
        folders[:] = [name for name in folders if not ignored(name)]
        for name in sorted(files):
            # A pipe or a socket would never end.
            if not ignored(name) and (here / name).is_file() and not (here / name).is_symlink():
                yield (here / name).relative_to(root).as_posix()


def ignored(name: str) -> bool:
    return name.startswith(".") or name.endswith("~")


def is_link(folder: Path) -> bool:
    """Also a junction of Windows, which Python before 3.12 does not know."""
    return os.path.realpath(folder) != os.path.join(os.path.realpath(folder.parent), folder.name)
