"""The libraries that a Unity project has already: by whichever route they came, and for whom."""

import itertools
import json
import re
from collections.abc import Iterator, Set
from pathlib import Path
from typing import Any, NamedTuple

from kitlib.lessons import ROOT, KitError, read_json

# Where the kit's files go in a project.
TARGET = "Assets/NetMQExample"
# Where a DLL may be wanted.
PARTS = {"editor", "builds"}
# Said once, for the C# projects and for this.
NETMQ = re.findall(r'"NetMQ" Version="\[(.+?)\]"', (ROOT / "Directory.Build.targets").read_text(encoding="utf-8"))[0]
# With those before it the scripts do not compile.
OLDEST_NETMQ = "4.0.1.11"
DOTNET = "lib/netstandard2.0/System."
# NetMQ inside Unity, with what it needs and Unity does not have: package, version, and the file in it. Of the last two
# only BufferPool.SetBufferManagerBufferPool has a use, but IL2CPP's linker wants to find every name that it meets.
LIBRARIES = (
    ("NetMQ", NETMQ, "lib/netstandard2.1/NetMQ.dll"),
    ("AsyncIO", "0.1.69", "lib/netstandard2.0/AsyncIO.dll"),
    ("NaCl.Net", "0.1.13", "lib/netstandard2.1/NaCl.dll"),
    ("System.Collections.Immutable", "10.0.7", f"{DOTNET}Collections.Immutable.dll"),
    ("System.Runtime.CompilerServices.Unsafe", "6.1.2", f"{DOTNET}Runtime.CompilerServices.Unsafe.dll"),
    ("System.ServiceModel.Primitives", "10.0.652802", f"{DOTNET}ServiceModel.Primitives.dll"),
    ("System.Security.Principal.Windows", "5.0.0", f"{DOTNET}Security.Principal.Windows.dll"),
)
JSON_DLL = "Newtonsoft.Json.dll"
# Packages that bring one of these DLLs. UnityNuGet's are named like NuGet's.
BRINGS = {f"org.nuget.{package.lower()}": inside.rsplit("/", 1)[1] for package, _, inside in LIBRARIES} | dict.fromkeys(
    (
        "com.unity.nuget.newtonsoft-json",
        "org.nuget.newtonsoft.json",
        "jillejr.newtonsoft.json-for-unity",
        "com.itisnajim.socketiounity",
    ),
    JSON_DLL,
)
NUGET_FOR_UNITY = ("Assets/packages.config", "Packages/nuget-packages/packages.config")


class Copy(NamedTuple):
    """A DLL that the project has, or gets when Unity opens it; `cure` says how it gets another version."""

    name: str
    where: str
    parts: set[str]
    version: str
    cure: str


class Inventory:
    """A project's packages by name, with their versions, and its copies of the DLLs that the kit needs."""

    def __init__(self, root: Path, without: Set[str] = frozenset(), kept: Set[str] = frozenset()) -> None:
        """`without`: packages that are about to leave, with all that they alone have brought along but for `kept`."""
        # Unity writes down what it has resolved, also what a package brings along.
        locked = lock(root)
        named = {name: str(entry.get("version", "")) for name, entry in locked.items()} | dependencies(root)
        gone = leaving_with(root, without | outdated(root), kept)
        named = {name: version for name, version in named.items() if name not in gone}
        cache = list((root / "Library" / "PackageCache").glob("*@*"))
        cache = [folder for folder in cache if folder.name.split("@")[0] not in gone]
        folders = {folder: folder.name.split("@")[0] for folder in cache}
        local = package_folders(root)
        embedded = {package_name(folder): "" for folder in local}
        # Such a folder may lie outside the project.
        local += [root / "Packages" / where[len("file:") :] for where in named.values() if where.startswith("file:")]
        folders |= {folder.resolve(): package_name(folder) for folder in local if folder.is_dir()}
        fetched = dict(folder.name.split("@", 1) for folder in cache if folder.name.startswith("org.nuget."))
        self.packages = fetched | embedded | named
        self.copies = [*by_name(root, self.packages), *by_file(root, folders, self.packages)]

    def missing(self, dll: str) -> set[str]:
        """Where nothing brings this DLL, of PARTS: two of one name do not compile, or the wrong one is taken."""
        return PARTS.difference(*(copy.parts for copy in self.copies if copy.name == dll))

    def check_netmq(self) -> Iterator[str]:
        """What is wrong with the project's own NetMQ; a KitError if it is too old for the scripts."""
        found = [copy for copy in self.copies if copy.name == "NetMQ.dll"]
        for copy in found:
            if copy.parts and copy.version and numbers(copy.version) < numbers(OLDEST_NETMQ):
                need = f"the scripts need {OLDEST_NETMQ} or later: nothing was copied"
                raise KitError(f"{copy.where} has NetMQ {copy.version}, and {need}; {copy.cure}, and run this again")
        for one, other in itertools.combinations(found, 2):
            if one.parts & other.parts:
                cure = "remove one with its AsyncIO.dll and NaCl.dll, or nothing compiles"
                yield f"NetMQ is here twice, by {one.where} and {other.where}: {cure}"


def lock(root: Path) -> dict[str, Any]:
    return read_json(root / "Packages" / "packages-lock.json").get("dependencies") or {}


def outdated(root: Path) -> set[str]:
    """The packages that the project does not name any more, before Unity has written its lock anew."""
    named = {name for name, entry in lock(root).items() if entry.get("depth") == 0}
    embedded = {package_name(folder) for folder in package_folders(root)}
    return named - dependencies(root).keys() - embedded


def leaving_with(root: Path, names: Set[str], kept: Set[str] = frozenset()) -> set[str]:
    """These packages, and all that they alone have brought along but for `kept`."""
    locked = lock(root)
    direct = {name for name, entry in locked.items() if not entry.get("depth")} | dependencies(root).keys()
    return brought(locked, names) - brought(locked, direct - names | kept)


def brought(locked: dict[str, Any], names: Set[str]) -> set[str]:
    """These packages, and all that they bring along."""
    found = set(names)
    todo = list(names)
    for name in todo:  # It grows meanwhile.
        new = (locked.get(name, {}).get("dependencies") or {}).keys() - found
        found |= new
        todo += new
    return found


def unity_version(root: Path) -> tuple[int, int]:
    """That of the project's Unity, such as (2022, 3); a far later one where it cannot be read."""
    text = (root / "ProjectSettings" / "ProjectVersion.txt").read_text(encoding="utf-8", errors="replace")
    found = re.search(r"^m_EditorVersion: (\d+)\.(\d+)", text, re.MULTILINE)
    return (int(found[1]), int(found[2])) if found else (9999, 0)


def dependencies(root: Path) -> dict[str, str]:
    path = root / "Packages" / "manifest.json"
    if not path.exists():
        return {}
    try:
        found = json.loads(path.read_text(encoding="utf-8-sig")).get("dependencies", {})
        return {name: str(version) for name, version in found.items()}
    except (ValueError, AttributeError) as error:
        raise KitError(f"{path} is no valid manifest: {error}; correct it, Unity cannot open it either") from None


def package_folders(root: Path) -> list[Path]:
    """The packages in Packages; of the other folders there Unity reads nothing."""
    return [path.parent for path in sorted((root / "Packages").glob("*/package.json"))]


def package_name(folder: Path) -> str:
    return str(read_json(folder / "package.json").get("name", folder.name))


def by_name(root: Path, packages: dict[str, str]) -> Iterator[Copy]:
    """The DLLs of the packages that are named, whether Unity and NuGetForUnity have fetched them or will."""
    ours = re.sub(r"\.(\d+)$", r"-\1", NETMQ)
    for name in [name for name in BRINGS if name in packages]:
        version = packages[name] if re.fullmatch(r"[\d.]+(-\d+)?", packages[name]) else ""
        cure = f'write "{name}": "{ours}" among the dependencies in Packages/manifest.json'
        yield Copy(BRINGS[name], name, PARTS, version, cure)
    for place in NUGET_FOR_UNITY:
        cure = f"change its version to {NETMQ}, in NuGetForUnity's window or in {place}"
        for name, version in nuget(root / place).items():
            if dll := BRINGS.get(f"org.nuget.{name}"):
                yield Copy(dll, place, PARTS, version, cure)


def nuget(path: Path) -> dict[str, str]:
    text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
    entries = [dict(re.findall(r'(\w+)="([^"]*)"', entry)) for entry in re.findall(r"<package\s[^>]*", text)]
    return {entry["id"].lower(): entry.get("version", "") for entry in entries if "id" in entry}


def by_file(root: Path, folders: dict[Path, str], packages: dict[str, str]) -> Iterator[Copy]:
    """The DLLs that lie in the project and in its packages, but for those that by_name has."""
    names = [name for place in NUGET_FOR_UNITY for name in nuget(root / place)]
    listed = [(f"/{name}.", BRINGS.get(f"org.nuget.{name}")) for name in names]
    unity = unity_version(root)
    for folder, package in {root / "Assets": "", **folders}.items():
        for path in imported(folder, "*.dll"):
            if path.name not in BRINGS.values() or path.is_relative_to(root / TARGET):
                continue
            if package in packages and BRINGS.get(package) == path.name:
                continue
            inside = f"/{path.parent.relative_to(folder).as_posix().lower()}"
            if any(begins in inside and dll == path.name for begins, dll in listed):
                continue
            # Unity ignores what has no .meta in a package where it can write none.
            if "@" in folder.name and not path.with_name(f"{path.name}.meta").exists():
                continue
            where = (path.relative_to(root) if path.is_relative_to(root) else path).as_posix()
            cure = f"update {package}" if package else f"delete {where} with its AsyncIO.dll and NaCl.dll"
            default = {"editor"} if "/editor/" in f"{inside}/" else PARTS
            version = file_version(path, where) if path.name == "NetMQ.dll" else ""
            yield Copy(path.name, where, served(path, unity, default), version, cure)


def file_version(dll: Path, where: str) -> str:
    """The version that stands in a DLL's resources, in UTF-16; empty if there is none."""
    data = dll.read_bytes()
    if data.startswith(b"version https://git-lfs"):
        note = "only Git LFS's note of it"
        raise KitError(f"{where} is not here yet, {note}: nothing was copied; run git lfs pull first")
    found = re.search("FileVersion\0".encode("utf-16-le") + rb"(?:\0\0)*((?:[\d.]\0)+)", data)
    return found[1].decode("utf-16-le") if found else ""


def numbers(version: str) -> list[int]:
    return [int(number) for number in re.findall(r"\d+", version)]


def served(dll: Path, unity: tuple[int, int], default: set[str]) -> set[str]:
    """Where a DLL is used, by its .meta, as PluginImporter reads it; without one as by default in its folder."""
    meta = dll.with_name(f"{dll.name}.meta")
    text = meta.read_text(encoding="utf-8", errors="replace") if meta.exists() else ""
    limits = re.findall(r"^ *- '?(!?)UNITY_(\d+)_(\d+)_OR_NEWER'?$", text, re.MULTILINE)
    switched_off = any((unity >= (int(major), int(minor))) == bool(no) for no, major, minor in limits)
    # Any other copy takes the place of an overridable one.
    if switched_off or re.search(r"^ *isOverridable: 1", text, re.MULTILINE):
        return set()
    # Neither the newest nor the oldest Unity writes the lines `first:` and `second:`.
    entry = r"^[ -]*(?:first:\n *)?(\w[\w ]*):.*\n(?: *second:\n)? *enabled: (\d)"
    found = {name: on == "1" for name, on in re.findall(entry, text, re.MULTILINE)}
    if not found:
        return default
    for_any, for_editor = found.pop("Any", False), found.pop("Editor", False)
    if for_any:
        for_editor = "Exclude Editor: 1" not in text
    for_builds = for_any or any(found.values())
    return {part for part, wanted in (("editor", for_editor), ("builds", for_builds)) if wanted}


def imported(folder: Path, name: str) -> list[Path]:
    """The files of this name that Unity sees: it ignores what begins with a dot or ends with a tilde."""
    ignored = re.compile(r"^\.|~$")
    files = (path for path in sorted(folder.rglob(name)) if path.is_file())
    return [path for path in files if not any(map(ignored.search, path.relative_to(folder).parts))]
