"""Puts the lessons' scripts and NetMQ's DLLs into a user's own Unity project.

Nothing is written before everything is at hand and nothing stands in the way: an interrupted run leaves no half.
"""

from __future__ import annotations

import functools
import hashlib
import io
import json
import os
import re
import shutil
import time
import urllib.error
import urllib.request
import zipfile
from collections.abc import Callable
from pathlib import Path

from kitlib.lessons import PACKAGE, ROOT, KitError, Lesson, find, lessons
from kitlib.setup import dotnet, python_setup
from kitlib.terminal import command, say
from kitlib.unity.inventory import JSON_DLL, LIBRARIES, PARTS, TARGET, Inventory, unity_version
from kitlib.unity.meta import assets, behaviours, guid, meta, meta_of
from kitlib.unity.modules import VERSION, needed
from kitlib.unity.project import OLDEST, advice, check_foreign, check_moved, find_project, has_scripts

ALONE = "the scripts alone: they need NetMQ.dll and the DLLs that it needs"
# Unity's own package of Newtonsoft.Json, with which lessons 04 and 05 read JSON.
JSON = ("com.unity.nuget.newtonsoft-json", "3.2.1")
NUGET = "https://api.nuget.org/v3-flatcontainer"
PLUGINS = f"{TARGET}/Plugins"
# What this command wrote, and so may write again. Unity ignores names that begin with a dot.
RECORD = f"{TARGET}/.kit.json"
# The texts that the licences of the DLLs ask for, and by what name a NuGet package has its own.
LICENCES = ROOT / "licences"
NOTICE = re.compile(r"(LICENSE|COPYING|THIRD-PARTY-NOTICES)[^/]*", re.IGNORECASE)

# isExplicitlyReferenced: no script names a class of .NET's own libraries, so a game's other scripts need not see them.
# validateReferences: another package's copy may have another version number, which is as good.
LIBRARY_META = """fileFormatVersion: 2
guid: {guid}
PluginImporter:
  externalObjects: {{}}
  serializedVersion: 2
  iconMap: {{}}
  executionOrder: {{}}
  defineConstraints: []
  isPreloaded: 0
  isOverridable: 0
  isExplicitlyReferenced: {hidden}
  validateReferences: 0
  platformData:
  - first:
      : Any
    second:
      enabled: 0
      settings:
        Exclude Editor: {no_editor}
        Exclude WebGL: 1
  - first:
      Any:
    second:
      enabled: {builds}
      settings: {{}}
  - first:
      Editor: Editor
    second:
      enabled: {editor}
      settings:
        DefaultValueInitialized: true
  - first:
      WebGL: WebGL
    second:
      enabled: 0
      settings: {{}}
  userData:
  assetBundleName:
  assetBundleVariant:
"""


def install(
    project: Path, lesson: str | None = None, force: bool = False, scripts_only: bool = False, dlls: Path | None = None
) -> None:
    """Copy the package, or what one lesson needs of it, and the DLLs; a KitError says why not.

    The DLLs come from the folder `dlls`, or else from NuGet.
    """
    root = find_project(project)
    there = Inventory(root)
    if by := has_scripts(root):
        say(f"the scripts come from {by}: they are not copied")
        # Unity reads no link.xml in a package. Without our .meta, whose GUID the package's own file has.
        files = {f"{TARGET}/link.xml": (PACKAGE / "link.xml").read_bytes()}
    else:
        files = {**scripts(lesson), **notices()}
    check_age(root, lesson, files)
    wrong = list(there.check_netmq())
    check_moved(root, files)
    check_foreign(root, files)
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
    for line in [*wrong, *advice(root)]:
        say(line)
    if there.missing("NetMQ.dll") and not (root / PLUGINS / "NetMQ.dll").exists():
        say("first bring the DLLs: route (b) or (d) of docs/guide/unity_project.md")
    for line in next_steps(root, lesson):
        say(line)


def check_age(root: Path, lesson: str | None, files: dict[str, bytes]) -> None:
    """A KitError if this Unity is too old for these files."""

    def steps_physics(some: dict[str, bytes]) -> bool:
        return any(b"Physics.simulationMode" in data for data in some.values())

    age = unity_version(root)
    if age >= OLDEST or (age >= (2021, 2) and not steps_physics(files)):
        return
    if age < (2021, 2):
        reason = "NetMQ needs 2021.2 or later (.NET Standard 2.1), all lessons 2022.3"
        cure = ""
    else:
        reason = f"{f'lesson {lesson} steps physics, which' if lesson else 'the whole package'} needs 2022.3 or later"
        able = [str(one.number) for one in lessons() if not steps_physics(scripts(str(one.number)))]
        cure = f"--lesson takes {', '.join(able[:-1])} or {able[-1]} here; for the others "
    raise KitError(
        f"this project is for Unity {age[0]}.{age[1]}; {reason}: nothing was copied; "
        f"{cure}open a copy of the project with a newer editor in Unity Hub"
    )


def scripts(lesson: str | None) -> dict[str, bytes]:
    """The files to copy, with their .meta: all of the package, or what one lesson needs."""
    chosen = assets() if lesson is None else of_lesson(find(lesson).unity)
    found: dict[str, bytes] = {}
    for path in chosen:
        name = f"{TARGET}/{path.relative_to(PACKAGE).as_posix()}".removesuffix("/.")
        if path.is_file():
            found[name] = path.read_bytes()
        if meta_of(path).exists():
            found[f"{name}.meta"] = meta_of(path).read_bytes()
    return found


def of_lesson(folder: Path) -> list[Path]:
    """A lesson's scripts, the earlier scripts that they use, and what IL2CPP must know."""
    if not folder.is_dir():
        raise KitError(f"lesson {folder.name} has no Unity scripts: is the kit whole?")
    chosen = with_used(sorted(folder.glob("*.cs")), folder.name, code)
    # The browser's half of a script, and the assembly of scripts that know nothing of NetMQ.
    chosen += [path for script in chosen if (path := script.with_suffix(".jslib")).exists()]
    folders = sorted({path.parent for path in chosen})
    chosen += [path for folder in folders if folder.name[:1].isdigit() for path in folder.glob("*.asmdef")]
    # With an assembly of their own: that is what a game's other assemblies can refer to, and what WebGL leaves out.
    # One without scripts is left out: Unity would warn of it at each compilation.
    inner = {path.parent for path in chosen if path.suffix == ".asmdef"}
    if not {path.parent for path in chosen if path.suffix == ".cs"} <= inner:
        chosen.append(PACKAGE / "NetMQExample.asmdef")
    return [PACKAGE, *folders, *chosen, PACKAGE / "link.xml"]


def without_unity(lesson: Lesson) -> list[Path]:
    """Those of a lesson's scripts that need .NET alone, and the earlier ones that they and its terminal client use."""
    scripts = [path for path in sorted(lesson.unity.glob("*.cs")) if plain_code(path).strip()]
    plain = [path for path in scripts if "UnityEngine" not in plain_code(path)]
    return [path for path in with_used([lesson.console, *plain], lesson.key, plain_code) if path != lesson.console]


def with_used(scripts: list[Path], key: str, read: Callable[[Path], str]) -> list[Path]:
    """These scripts, and those of Shared and of lessons before this one that they use."""
    others = [path for path in sorted(PACKAGE.glob("[0-9][0-9]_*/*.cs")) if path.parent.name < key]
    others += sorted(PACKAGE.glob("Shared/*.cs"))
    chosen = list(scripts)
    for path in chosen:  # It grows meanwhile: what is used may use others.
        text = read(path)
        chosen += [other for other in others if other not in chosen and any(uses(text, name) for name in types(other))]
    return chosen


def code(script: Path) -> str:
    """What the compiler sees of a script in Unity."""
    return re.sub(r"//.*", "", script.read_text(encoding="utf-8", errors="replace"))


def plain_code(script: Path) -> str:
    """What it sees without Unity."""
    return re.sub(r"#if UNITY_.*?#endif", "", code(script), flags=re.DOTALL)


def unitys_packages(files: dict[str, bytes]) -> dict[str, str]:
    """What the scripts among these files need of Unity's own packages, with their versions."""
    texts = [data.decode("utf-8-sig", "replace") for name, data in files.items() if name.endswith(".cs")]
    json_package = dict([JSON]) if any("using Newtonsoft.Json" in text for text in texts) else {}
    return {**json_package, **dict.fromkeys(sorted(needed(texts)), VERSION)}


def add_packages(root: Path, needed: dict[str, str], there: Inventory) -> None:
    """Name in the project's manifest what nothing brings, and keep the manifest's look."""
    wanted = {name: version for name, version in needed.items() if name not in there.packages}
    if not there.missing(JSON_DLL):
        wanted.pop(JSON[0], None)
    if not wanted:
        return
    # Of a link the file behind it.
    path = (root / "Packages" / "manifest.json").resolve()
    # Beside it, and so on the same disk: a full disk leaves the old one whole.
    new = path.with_name(f"manifest.json.{os.getpid()}")
    try:
        if path.exists() and not os.access(path, os.W_OK):
            raise PermissionError("it is read-only")
        old = path.read_bytes().decode()
        indent = re.search(r"^([ \t]+)\S", old, re.MULTILINE)
        manifest = json.loads(old.removeprefix("\ufeff"))
        manifest.setdefault("dependencies", {}).update(wanted)
        text = json.dumps(manifest, indent=indent[1] if indent else 2, ensure_ascii=False)
        text = text + "\n" if old.endswith("\n") else text
        text = "\ufeff" * old.startswith("\ufeff") + text.replace("\n", "\r\n" if "\r\n" in old else "\n")
        new.write_bytes(text.encode())
        replace(new, path)
    except OSError as error:
        new.unlink(missing_ok=True)
        names = ", ".join(wanted)
        why = error.strerror or error
        say(f"Packages/manifest.json cannot be written ({why}): add in Unity's Package Manager: {names}")
        return
    for name, version in wanted.items():
        say(f"added {name} {version} to Packages/manifest.json")
    for copy in there.copies:
        if JSON[0] in wanted and copy.name == JSON_DLL and copy.parts and copy.where.startswith("Assets/"):
            say(f"delete {copy.where}: a game needs JSON in the editor and in builds, and of {JSON[0]} it has both")


def notices() -> dict[str, bytes]:
    """The licences, which go where the files go."""
    found: dict[str, bytes] = {}
    for source, name in (("LICENSE", "LICENSE.md"), ("THIRD-PARTY-NOTICES.md", "THIRD-PARTY-NOTICES.md")):
        found[f"{TARGET}/{name}"] = (ROOT / source).read_bytes()
        found[f"{TARGET}/{name}.meta"] = meta(PACKAGE / "CHANGELOG.md", guid(name)).encode()
    return found


@functools.cache
def types(script: Path) -> list[str]:
    """What a script has for others: PoseSubscriber.cs has PoseMessage as well."""
    declared = r"^    (?:public|internal) [\w ]*\b(?:class|struct|interface|enum) (\w+)"
    return re.findall(declared, script.read_text(encoding="utf-8-sig", errors="replace"), re.MULTILINE)


def uses(code: str, name: str) -> bool:
    """True if the code names this class: `e.Message` does not name the class Message."""
    return re.search(rf"(?<![\w.]){name}\b", code) is not None


def libraries(folder: Path | None, ask: Callable[[str], set[str]] = lambda name: PARTS) -> dict[str, bytes]:
    """The DLLs with their import settings and licences; `ask` says where a DLL is missing, of PARTS."""
    found: dict[str, bytes] = {}
    texts = {path.name: path.read_bytes() for path in sorted(LICENCES.glob("*.txt"))}
    for package, version, inside in LIBRARIES:
        name = inside.rsplit("/", 1)[1]
        if not (parts := ask(name)):
            continue
        if folder:
            found[f"{PLUGINS}/{name}"] = in_folder(folder, name)
        else:
            found[f"{PLUGINS}/{name}"], carried = library(package, version, inside)
            texts |= {f"{package}-{text}": data for text, data in carried.items()}
        found[f"{PLUGINS}/{name}.meta"] = LIBRARY_META.format(
            guid=guid(f"Plugins/{name}"),
            hidden=int(name.startswith("System.")),
            editor=int("editor" in parts),
            no_editor=int("editor" not in parts),
            builds=int("builds" in parts),
        ).encode()
    found[f"{PLUGINS}.meta"] = meta(PACKAGE / "Shared", guid("Plugins")).encode()
    for name, data in texts.items():
        found[f"{PLUGINS}/{name}"] = data
        found[f"{PLUGINS}/{name}.meta"] = meta(PACKAGE / "CHANGELOG.md", guid(f"Plugins/{name}")).encode()
    return found


def in_folder(folder: Path, name: str) -> bytes:
    """One DLL of a folder that the user has."""
    if not (folder / name).is_file():
        raise KitError(f"there is no {name} in {folder}: nothing was copied")
    return (folder / name).read_bytes()


def library(package: str, version: str, inside: str) -> tuple[bytes, dict[str, bytes]]:
    """One DLL, and the notices that its package carries: from NuGet's folder on this machine, put there by dotnet if
    there is one, or from NuGet itself."""
    name = package.lower()
    file = f"{name}.{version}.nupkg"
    here = dotnet.nuget_folder() / name / version / file
    if not here.exists() and dotnet.sdk():
        say(f"asking NuGet for {package} …")
        result = dotnet.restore(dotnet.NetMQ(""))
        if not result.ok:
            why = dotnet.refusal(result)
            raise KitError(
                f"{why}: nothing was copied; --scripts-only copies the scripts without NetMQ's DLLs,"
                " for which docs/guide/unity_project.md has other routes"
            )
    try:
        with zipfile.ZipFile(here if here.exists() else download(package, version, file)) as archive:
            notices = {text: archive.read(text) for text in archive.namelist() if NOTICE.fullmatch(text)}
            return archive.read(inside), notices
    except (OSError, urllib.error.URLError, zipfile.BadZipFile, KeyError) as error:
        raise KitError(f"NuGet gave no {package} {version} ({error}): nothing was copied") from None


def download(package: str, version: str, file: str) -> io.BytesIO:
    say(f"downloading {package} {version} from NuGet …")
    with urllib.request.urlopen(f"{NUGET}/{package.lower()}/{version}/{file}", timeout=20) as answer:
        return io.BytesIO(answer.read())


def write(root: Path, files: dict[str, bytes], force: bool, dlls: bool) -> None:
    """All of them or none. With `dlls`, a DLL that an earlier run wrote and this one does not is deleted."""
    record = read_record(root)
    # Unity writes .meta files itself, and other files may refer to what they say: one that is not ours stays.
    wanted = {
        n: d
        for n, d in files.items()
        if not (n.endswith(".meta") and (root / n).exists() and digest((root / n).read_bytes()) != record.get(n))
    }
    news = {n: d for n, d in wanted.items() if not (root / n).exists() or digest((root / n).read_bytes()) != digest(d)}
    changed = [n for n in news if (root / n).exists() and digest((root / n).read_bytes()) != record.get(n)]
    if changed and not force:
        more = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
        raise KitError(f"{changed[0]}{more} was changed in your project: nothing was copied; --force overwrites it")
    # On Windows a file that is read-only cannot be replaced: version control makes them so until they are checked out.
    if locked := [name for name in news if (root / name).exists() and not os.access(root / name, os.W_OK)]:
        raise KitError(f"{locked[0]} is read-only: nothing was copied; check it out first, or clear the attribute")
    try:
        place(root, news)
        record |= {name: digest(data) for name, data in news.items()}
        if remove_outdated(root, record, files, dlls) or news:
            (root / RECORD).write_text(json.dumps(record, indent=1, sort_keys=True), encoding="utf-8")
    except OSError as error:
        raise KitError(f"could not write into {root}: {error}; close Unity, or make room, and run this again") from None
    for name in news:
        if not name.endswith(".meta"):
            say(f"wrote {name}")
    same = sum(not name.endswith(".meta") for name in files.keys() - news.keys())
    if same:
        say(f"{same} files were there already")


def place(folder: Path, files: dict[str, bytes]) -> None:
    """Write files by their names in a folder: what can fail fails before the first is moved to its place."""
    # In that folder, and so on the same disk. Not by tempfile, whose folders on Windows are for one account alone, and
    # so would be the files that are moved out of it.
    stage = folder / f".netmqexample-{os.getpid()}"
    try:
        stage.mkdir()
        for number, data in enumerate(files.values()):
            (stage / str(number)).write_bytes(data)
        for name in files:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
        for number, name in enumerate(files):
            replace(stage / str(number), folder / name)
    finally:
        shutil.rmtree(stage, ignore_errors=True)


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
    # A script before its .meta, which stays where the script does; what is in a folder before the folder's.
    for name in sorted(old, key=lambda name: (name.endswith(".meta"), -name.count("/"))):
        path, known = root / name, record.pop(name)
        if not path.is_file() or (name.endswith(".meta") and path.with_suffix("").is_file()):
            continue
        if digest(path.read_bytes()) != known:
            say(f"{name} is no longer a part of the kit, and stays because you have changed it: delete it if you can")
            continue
        path.unlink()
        if not name.endswith(".meta"):
            why = "another package brings it" if name.startswith(PLUGINS) else "it is no longer a part of the kit"
            say(f"deleted {name}: {why}")
        if not any(path.parent.iterdir()):
            path.parent.rmdir()
    return bool(old)


def replace(source: Path, target: Path) -> None:
    """Move a file; on Windows a virus scanner or Unity's importer may have the old one open for a moment."""
    for wait in (0.2, 0.2, 0.0):
        try:
            os.replace(source, target)
            return
        except PermissionError:
            if not wait:
                raise
            time.sleep(wait)


def read_record(root: Path) -> dict[str, str]:
    try:
        record = json.loads((root / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return record if isinstance(record, dict) else {}


def digest(data: bytes) -> str:
    """Git may have changed the ends of the lines, which is no change."""
    return hashlib.sha256(data.replace(b"\r\n", b"\n")).hexdigest()


def next_steps(root: Path, lesson: str | None) -> list[str]:
    """What to type and to press now."""
    key = find(lesson or "1").key
    # The one that kit.py runs the lessons with; the terminal may be in any folder.
    python = python_setup.interpreter(key)
    scripts = behaviours(PACKAGE / key)
    components = ", ".join("your agent or " * (": Agent\n" in code(path)) + path.stem for path in scripts)
    scene = f"{TARGET}/{key}/{key}.unity"
    there = f"open {scene}" if (root / scene).exists() else f"add to one GameObject: {components}"
    return [
        f"next, in a terminal: {command(python, ROOT / 'python' / key / 'server.py')}",
        f"then, in Unity: wait for the import, {there}; and press Play",
    ]
