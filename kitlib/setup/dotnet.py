"""The C# side: the .NET SDK, the choice of engine, and a build that is made again only when a file has changed."""

from __future__ import annotations

import functools
import hashlib
import json
import os
import re
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from kitlib import lessons
from kitlib.lessons import PACKAGES, ROOT, UNWRITABLE, KitError, keep, recall, writable
from kitlib.programs import Result, quietly, step
from kitlib.setup.lock import locked
from kitlib.terminal import say
from kitlib.unity.meta import PACKAGE

BUILD = ROOT / ".build"
CONSOLE = ROOT / "csharp-console"
SUPPORT = ROOT / "csharp-support"
ENGINES = ("netmq", "libzmq")
ENGINE_HELP = "NetMQ from NuGet, or the libzmq engine"
PROPS = BUILD / "engine.props"
# Who builds or restores holds it: all projects share what stands in .build.
LOCK = BUILD / "lock"
INSTALLER = "https://dotnet.microsoft.com/download"
DOWNLOAD = f"no .NET SDK 8 or later here: get it from {INSTALLER}; just installed: open a new terminal"
# No server that stays behind after a build, no telemetry, no greeting; and NuGet asks twice at most.
ENVIRONMENT = {
    "DOTNET_NOLOGO": "1",
    "DOTNET_CLI_TELEMETRY_OPTOUT": "1",
    "DOTNET_CLI_UI_LANGUAGE": "en",
    "MSBUILDDISABLENODEREUSE": "1",
    "UseSharedCompilation": "false",
    "NUGET_ENHANCED_MAX_NETWORK_TRY_COUNT": "2",
    "NUGET_ENHANCED_NETWORK_RETRY_DELAY_MILLISECONDS": "200",
}
KNOWN = "Update, OnEnable, Time, Transform, Debug.Log; no keys, physics or UI. Name all files whose classes it uses"
CHANGED = "the player uses your copy of a kit's file only if you name it here, with each that uses its classes:"
# What NuGet says when it does not hold a package, or not this version of it, or cannot be reached at all.
ABSENT = ("NU1101", "NU1102", "NU1103")
UNREACHABLE = ("NU1301", "NU1801")
NO_SOURCE = "dotnet nuget add source https://api.nuget.org/v3/index.json -n nuget.org"
# The first restore on a Windows machine has to wait for the virus scanner.
TIMEOUT = 180 if lessons.WINDOWS else 60
# Where the installers put dotnet: a terminal that was open before does not have it on its PATH yet.
PLACES = {
    "win32": Path(os.environ.get("PROGRAMFILES", "C:/Program Files"), "dotnet"),
    "darwin": Path("/usr/local/share/dotnet"),
}
if sys.platform in PLACES and PLACES[sys.platform].exists() and not shutil.which("dotnet"):
    os.environ["PATH"] += f"{os.pathsep}{PLACES[sys.platform]}"


class NoEngine(KitError):
    """Nothing that can stand behind NetMQ's names, at the moment."""


@functools.cache
def sdk() -> str | None:
    """The version of the newest .NET SDK, or None where there is none of 8 or later."""
    if not shutil.which("dotnet"):
        return None
    versions = re.findall(r"^(\d+)\.(\S+)", quietly(["dotnet", "--list-sdks"], 60, ENVIRONMENT).output, re.MULTILINE)
    recent = [(int(major), f"{major}.{rest}") for major, rest in versions if int(major) >= 8]
    return max(recent)[1] if recent else None


@dataclass(frozen=True)
class Engine:
    """What NetMQ's names mean in this build, and why."""

    name: str
    why: str
    # True where NuGet cannot even give .NET Standard's reference assembly: the SDK's own framework serves then.
    offline: bool = False
    # The folder of packages that was brought along, if they come from there and nowhere else.
    source: str = ""

    @property
    def properties(self) -> list[str]:
        # Without NuGet its list of vulnerable packages cannot be had either, and asking for it takes long.
        audit = ["-p:NuGetAudit=false"] if self.offline or self.source else []
        source = [f"-p:RestoreSources={self.source}"] if self.source else []
        # One process: the few projects are worth less work than MSBuild's start in a second one.
        return [f"-p:NetMQEngine={self.name}", f"-p:LibraryFramework={self.framework}", "-m:1", *audit, *source]

    @property
    def framework(self) -> str:
        return f"net{(sdk() or '').split('.')[0]}.0" if self.offline else "netstandard2.1"


def restore(engine: Engine, limit: float = TIMEOUT) -> Result:
    # By force, because what an interrupted restore has left looks whole to the next one.
    forget_damaged(engine)
    return quietly(["dotnet", "restore", CONSOLE, "--force", *engine.properties], limit, ENVIRONMENT)


def forget_damaged(engine: Engine) -> None:
    """NuGet reads what its last restore has written, even by force, and an empty file ends it."""
    for path in (BUILD / engine.name / "obj").glob("*/project.assets.json"):
        if not recall(path):
            path.unlink(missing_ok=True)


def choose_engine(asked: str | None = None, ask_again: bool = False) -> Engine:
    """NetMQ from NuGet; where NuGet cannot give it, the libzmq engine. `asked` overrides."""
    # One for each choice: who asks for an engine, as the tests do, must not make the next run ask NuGet again.
    memory = BUILD / f"engine-{asked or 'any'}.json"
    settings = sorted(f"{key}={value}" for key, value in os.environ.items() if key.upper().startswith("NUGET"))
    targets = (ROOT / "Directory.Build.targets").read_text(encoding="utf-8")
    brought = sorted(path.name for path in PACKAGES.glob("*.nupkg"))
    key = hashlib.sha256(json.dumps([settings, targets, brought, asked, sdk()]).encode()).hexdigest()
    known = recall(memory)
    if known.pop("key", "") == key and not ask_again:
        try:
            return Engine(**known)
        except TypeError:
            pass
    if not writable(BUILD):
        raise KitError(UNWRITABLE)
    try:
        ElementTree.parse(PROPS)
    except (OSError, ElementTree.ParseError):
        # A damaged one would end every restore; the build writes it anew.
        PROPS.unlink(missing_ok=True)
    engine = ask_nuget(asked)
    keep(memory, json.dumps({"key": key, **engine.__dict__}))
    return engine


def ask_nuget(asked: str | None) -> Engine:
    """A restore shows what the folder of packages or NuGet can give."""
    why = "asked for with --engine"
    if asked != "libzmq":
        if any(PACKAGES.glob("*.nupkg")):
            brought = Engine("netmq", f"from the folder {PACKAGES.name}", source=str(PACKAGES))
            if (result := restore(brought)).ok:
                return brought
            say(f"the folder {PACKAGES.name} does not do: {result.first(' error ')}")
        say(f"asking NuGet for NetMQ ({TIMEOUT} s at the most) …")
        result = restore(Engine("netmq", ""))
        if result.ok:
            return Engine("netmq", "NuGet, or its store on this machine, has it")
        why = refusal(result)
        if asked == "netmq":
            raise KitError(f"{why}; without --engine netmq the libzmq engine is used")
        if lessons.WINDOWS:
            # Pyzmq for Windows holds no libzmq that others could use. Not kept in mind: NuGet may answer next time.
            raise NoEngine(f"{why}, so there is no C# client here today")
    if not restore(Engine("libzmq", ""), TIMEOUT / 2).ok:
        result = restore(Engine("libzmq", "", offline=True))
        if not result.ok:
            raise KitError(f"dotnet restore failed: {result.first(' error ')}")
        return Engine("libzmq", why, offline=True)
    return Engine("libzmq", why)


def refusal(result: Result) -> str:
    """Why a restore gave no NetMQ, in a few words; any other failure of the restore is not hidden."""
    if "NU1100" in result.output:
        return f"no source of NuGet's holds NetMQ (with internet: {NO_SOURCE})"
    if any(code in result.output for code in ABSENT):
        return "NuGet does not hold NetMQ"
    if result.code == 124 or any(code in result.output for code in UNREACHABLE):
        return "NuGet cannot be reached"
    raise KitError(f"dotnet restore failed: {result.first(' error ')}")


def libzmq(python: Path) -> str:
    """The libzmq that this interpreter's pyzmq brought along, or nothing: the system's then."""
    code = (
        "import pathlib, zmq; site = pathlib.Path(zmq.__file__).parent.parent\n"
        "found = [f for g in ('pyzmq.libs/libzmq*', 'zmq/.dylibs/libzmq*', 'zmq/libzmq*') for f in site.glob(g)]\n"
        "print(found[0] if found else '')"
    )
    result = quietly([python, "-c", code], 60)
    return result.output.strip() if result.ok else ""


def fingerprint(engine: Engine, library: str, sources: list[Path]) -> str:
    """Changes when a source file, the SDK, the engine or the place of libzmq does."""
    digest = hashlib.sha256(f"{sdk()} {engine.properties} {library}".encode())
    for source in sources:
        for path in [source] if source.is_file() else sorted(source.rglob("*")):
            if path.suffix in (".cs", ".csproj", ".props", ".targets") and not {"bin", "obj"} & set(
                path.relative_to(source).parts
            ):
                digest.update(f"{path}{path.stat().st_mtime_ns}{path.stat().st_size}".encode())
    return digest.hexdigest()


def outputs(folder: Path) -> str:
    """What a build has made: a full disk, or a hand, may have taken from it since."""
    return " ".join(sorted(f"{path.name}={path.stat().st_size}" for path in folder.glob("*") if path.is_file()))


def build(python: Path, engine: Engine, project: Path = CONSOLE, own: Sequence[Path] = ()) -> Path:
    """Build a project with an engine, if anything changed since the last time; returns its .dll.

    `own` are a reader's own scripts, which own-scripts.csproj compiles.
    """
    library = libzmq(python)
    name = next(project.glob("*.csproj")).stem
    dll = BUILD / engine.name / "bin" / name / "release" / f"{name}.dll"
    stamp = BUILD / engine.name / f"{name}.stamp"
    sources = [CONSOLE, SUPPORT, project, PACKAGE, *own]
    now = fingerprint(engine, library, sources)

    def whole() -> bool:
        return recall(stamp).get("outputs") == outputs(dll.parent)

    def fresh() -> bool:
        return whole() and recall(stamp).get("sources") == now

    if fresh():
        return dll
    if not writable(BUILD):
        raise KitError(UNWRITABLE)
    with locked(LOCK):
        # Who held the lock before may have built the same.
        if fresh():
            return dll
        if project == CONSOLE:
            record_choice(engine, library)
        properties = [*engine.properties, f"-p:Libzmq={library}"]
        again = [] if whole() else ["--no-incremental", "--force"]
        # What a reader's scripts refer to was built with the console, a moment ago.
        no_references = ["-p:BuildProjectReferences=false"] if own else []
        # Until it has succeeded there is no stamp, and without one nothing that lies there is trusted: MSBuild takes
        # even an empty file for finished.
        stamp.unlink(missing_ok=True)
        forget_damaged(engine)
        words = [*properties, *again, *no_references, "-v:quiet", "-clp:NoSummary"]
        # MSBuild takes a variable for a property; on its command line a semicolon would end it. A name is escaped.
        kit = taken_from_the_kit(own)
        names = [str(path).replace("%", "%25").replace(";", "%3B") for path in own if path not in kit]
        environment = {**ENVIRONMENT, "OwnScripts": ";".join(names), "KitScripts": ";".join(path.stem for path in kit)}
        result = step(f"building {name} with {engine.name}", ["dotnet", "build", project, *words], 500, environment)
        if not result.ok:
            raise KitError(own_failure(result) if own else failure(result))
        keep(stamp, json.dumps({"sources": now, "outputs": outputs(dll.parent)}))
    return dll


def taken_from_the_kit(own: Sequence[Path]) -> list[Path]:
    """The kit's scripts and unchanged copies: compiled once more, their classes would be other ones.

    Beside a changed copy they are the reader's too: it is the changed one that they are to use.
    """
    return [] if any(map(changed_copy, own)) else [path for path in own if any(PACKAGE.rglob(path.name))]


def changed_copy(path: Path) -> bool:
    """Whether a script is named like one of the kit's, and is another one."""
    namesakes = [*PACKAGE.rglob(path.name)]
    return bool(namesakes) and all(path.read_bytes() != one.read_bytes() for one in namesakes)


def failure(result: Result) -> str:
    """Why a build has failed: in one line where it is not the code."""
    if any(words in result.output for words in ("No space left", "not enough space")):
        return "the disk is full: the C# build needs some 50 MB in .build"
    if "MSB3021" in result.output or "MSB3027" in result.output:
        return "the C# build cannot replace a file that is in use: end the client that still runs"
    if "error NU1301" in result.output:
        return "the C# build needs NuGet, which cannot be reached: try again with internet, or with --engine libzmq"
    return f"the C# build failed:\n{result.output.strip()}"


def own_failure(result: Result) -> str:
    """The same for a reader's own scripts: each error once, without what MSBuild says around them."""
    # After an error stands the project, which is ours.
    errors = dict.fromkeys(re.findall(r"^(.+: error CS.+?)(?: \[[^\]]+proj\])?$", result.output, re.MULTILINE))
    unknown = any(re.search(r"error CS(0019|0103|0117|0234|0246|1061|1501|7036)\b", line) for line in errors)
    why = f"; the player knows only as much of UnityEngine as the lessons use: {KNOWN}" if unknown else ":"
    # Two classes of one name; or a member to override that only the reader's own file has.
    if any("NetMQExample.dll]" in line or (not unknown and "error CS0115" in line) for line in errors):
        why = f"; {CHANGED}"
    return "\n".join([f"your script does not compile{why}", *errors]) if errors else failure(result)


def record_choice(engine: Engine, library: str) -> None:
    """Where Directory.Build.props looks, so that a plain `dotnet run` builds what kit.py builds."""
    text = (
        "<Project><PropertyGroup>\n"
        f"  <NetMQEngine Condition=\"'$(NetMQEngine)' == ''\">{engine.name}</NetMQEngine>\n"
        f"  <LibraryFramework Condition=\"'$(LibraryFramework)' == ''\">{engine.framework}</LibraryFramework>\n"
        f"  <Libzmq>{library}</Libzmq>\n"
        "</PropertyGroup></Project>\n"
    )
    if not PROPS.exists() or PROPS.read_text(encoding="utf-8", errors="replace") != text:
        keep(PROPS, text)
