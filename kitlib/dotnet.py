"""The C# side: the .NET SDK, the choice of engine, and a build that is made again only when a file has changed."""

from __future__ import annotations

import functools
import hashlib
import json
import os
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from .lessons import ROOT, KitError
from .terminal import Result, quietly, say, step

BUILD = ROOT / ".build"
CONSOLE = ROOT / "csharp-console"
ENGINES = ("netmq", "libzmq")
DOWNLOAD = "no .NET SDK 8 or later here: get it from https://dotnet.microsoft.com/download"
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
# What NuGet says when it does not hold a package, or cannot be reached at all.
ABSENT = ("NU1100", "NU1101", "NU1102", "NU1103")
UNREACHABLE = ("NU1301", "NU1801")
PATIENCE = 60


@functools.cache
def sdk() -> str | None:
    """The version of the newest .NET SDK, or None where there is none of 8 or later."""
    if not shutil.which("dotnet"):
        return None
    versions = re.findall(r"^(\d+)\.(\S+)", quietly(["dotnet", "--list-sdks"], 20, ENVIRONMENT).output, re.MULTILINE)
    recent = [(int(major), f"{major}.{rest}") for major, rest in versions if int(major) >= 8]
    return max(recent)[1] if recent else None


@dataclass(frozen=True)
class Engine:
    """What NetMQ's names mean in this build, and why."""

    name: str
    why: str
    # True where NuGet cannot even give .NET Standard's reference assembly: the SDK's own framework serves then.
    offline: bool = False

    @property
    def properties(self) -> list[str]:
        # Without NuGet its list of vulnerable packages cannot be had either, and asking for it takes long.
        audit = ["-p:NuGetAudit=false"] if self.offline else []
        return [f"-p:NetMQEngine={self.name}", f"-p:LibraryFramework={self.framework}", *audit]

    @property
    def framework(self) -> str:
        return f"net{(sdk() or '').split('.')[0]}.0" if self.offline else "netstandard2.1"


def restore(engine: Engine, limit: float = PATIENCE) -> Result:
    return quietly(["dotnet", "restore", CONSOLE, *engine.properties], limit, ENVIRONMENT)


def choose_engine(asked: str | None = None, ask_again: bool = False) -> Engine:
    """NetMQ from NuGet; where NuGet cannot give it, the offline engine. `asked` overrides."""
    memory = BUILD / "engine.json"
    settings = sorted(f"{key}={value}" for key, value in os.environ.items() if key.upper().startswith("NUGET"))
    targets = (CONSOLE / "Directory.Build.targets").read_text(encoding="utf-8")
    key = hashlib.sha256(json.dumps([settings, targets, asked, sdk()]).encode()).hexdigest()
    try:
        known = json.loads(memory.read_text(encoding="utf-8"))
        if known.pop("key") == key and not ask_again:
            return Engine(**known)
    except (OSError, ValueError, KeyError, TypeError):
        pass
    engine = ask_nuget(asked)
    BUILD.mkdir(exist_ok=True)
    memory.write_text(json.dumps({"key": key, **engine.__dict__}), encoding="utf-8")
    return engine


def ask_nuget(asked: str | None) -> Engine:
    """A restore shows what NuGet can give."""
    why = "asked for with --engine"
    if asked != "libzmq":
        say(f"asking NuGet for NetMQ ({PATIENCE} s at the most) …")
        result = restore(Engine("netmq", ""))
        if result.ok:
            return Engine("netmq", "NuGet has it")
        why = refusal(result)
        if asked == "netmq":
            raise KitError(f"{why}; without --engine netmq the offline engine is used")
    if not restore(Engine("libzmq", ""), PATIENCE / 3).ok:
        result = restore(Engine("libzmq", "", offline=True))
        if not result.ok:
            raise KitError(f"dotnet restore failed: {result.first(' error ')}")
        return Engine("libzmq", why, offline=True)
    return Engine("libzmq", why)


def refusal(result: Result) -> str:
    """Why a restore gave no NetMQ, in a few words; any other failure of the restore is not hidden."""
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
    result = quietly([python, "-c", code], 20)
    return result.output.strip() if result.ok else ""


def fingerprint(engine: Engine, library: str, sources: list[Path]) -> str:
    """Changes when a source file, the SDK, the engine or the place of libzmq does."""
    digest = hashlib.sha256(f"{sdk()} {engine.properties} {library}".encode())
    for folder in sources:
        for path in sorted(folder.rglob("*")):
            if path.suffix in (".cs", ".csproj", ".props", ".targets") and not {"bin", "obj"} & set(path.parts):
                digest.update(f"{path}{path.stat().st_mtime_ns}{path.stat().st_size}".encode())
    return digest.hexdigest()


def build(python: Path, engine: Engine, project: Path = CONSOLE) -> Path:
    """Build a project with an engine, if anything changed since the last time; returns its .dll."""
    library = libzmq(python)
    if project == CONSOLE:
        record_choice(engine, library)
    dll = BUILD / engine.name / "bin" / project.name / "release" / f"{project.name}.dll"
    stamp = BUILD / engine.name / f"{project.name}.stamp"
    now = fingerprint(engine, library, [CONSOLE, project, ROOT / "unity" / "Assets" / "NetMQExample"])
    if dll.exists() and stamp.exists() and stamp.read_text(encoding="utf-8") == now:
        return dll
    command: list[str | Path] = [
        "dotnet",
        "build",
        project,
        *engine.properties,
        f"-p:Libzmq={library}",
        "-v:quiet",
        "-clp:NoSummary",
    ]
    result = step(f"building {project.name} with {engine.name}", command, 300, ENVIRONMENT)
    if not result.ok:
        raise KitError(f"the C# build failed:\n{result.output.strip()}")
    stamp.write_text(now, encoding="utf-8")
    return dll


def record_choice(engine: Engine, library: str) -> None:
    """Where Directory.Build.props looks, so that a plain `dotnet run` builds what kit.py builds."""
    text = (
        "<Project><PropertyGroup>\n"
        f"  <NetMQEngine Condition=\"'$(NetMQEngine)' == ''\">{engine.name}</NetMQEngine>\n"
        f"  <LibraryFramework Condition=\"'$(LibraryFramework)' == ''\">{engine.framework}</LibraryFramework>\n"
        f"  <Libzmq>{library}</Libzmq>\n"
        "</PropertyGroup></Project>\n"
    )
    path = BUILD / "engine.props"
    BUILD.mkdir(exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")
