"""The C# side: the .NET SDK, where NetMQ comes from, and a build that is made again only when a file has changed."""

import functools
import hashlib
import json
import os
import re
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from kitlib import lessons
from kitlib.files import keep, locked
from kitlib.lessons import BUILD, KIT, PACKAGE, PACKAGES, ROOT, KitError, denied, read_json, unwritable, writable
from kitlib.programs import Result, quietly, step
from kitlib.terminal import say

CONSOLE = ROOT / "csharp-console"
SUPPORT = ROOT / "csharp-support"
PROJECTS = (".csproj", ".props", ".targets")
# csharp-support builds these, and every other project refers to them.
LIBRARIES = ("NetMQExample", "UnityPlayer")
# The compiler, and its words for whatever Unity compiles, as NetMQExample.csproj writes them.
COMPILER = BUILD / "bin" / "NetMQExample" / "release" / "scripts.rsp"
# A build and a restore hold it: all projects share what stands in .build.
LOCK = BUILD / "lock"
# Which projects have their packages, and for which files.
RESTORED = BUILD / "restored.json"
INSTALLER = "https://dotnet.microsoft.com/download"
# MSBuild takes every variable for a property, such as VERSION or OutDir, and an empty one for none. The variables that
# the system and .NET themselves need have one of these names, or an underscore.
OF_THE_SYSTEM = (
    r"PATH|PATHEXT|HOME\w*|USER\w*|LOGNAME|PUBLIC|TMPDIR|TMP|TEMP|LANG|LANGUAGE|TZ|TERM|SHELL|COMSPEC|OS|WINDIR|SYSTEM\w+"
    r"|APPDATA|LOCALAPPDATA|ALLUSERSPROFILE|(COMMON)?PROGRAM\w+(\(X86\))?|COMPUTERNAME|PSMODULEPATH|\w*_\w*"
)
ENVIRONMENT = {name: "" for name in os.environ if not re.fullmatch(OF_THE_SYSTEM, name, re.IGNORECASE)}
# No server that stays behind after a build, no telemetry, no greeting; and NuGet asks twice at most.
ENVIRONMENT |= {
    "DOTNET_NOLOGO": "1",
    "DOTNET_CLI_TELEMETRY_OPTOUT": "1",
    "DOTNET_CLI_UI_LANGUAGE": "en",
    "MSBUILDDISABLENODEREUSE": "1",
    "UseSharedCompilation": "false",
    "NUGET_ENHANCED_MAX_NETWORK_TRY_COUNT": "2",
    "NUGET_ENHANCED_NETWORK_RETRY_DELAY_MILLISECONDS": "200",
}
# In a container HOME may be / or nothing: what dotnet and NuGet keep goes into .build then.
if not lessons.WINDOWS and not os.access(os.environ.get("HOME", ""), os.W_OK):
    ENVIRONMENT["HOME"] = str(BUILD)
NO_SOURCE = "dotnet nuget add source https://api.nuget.org/v3/index.json -n nuget.org"
# In the lines in which dotnet says what is wrong, during a build and before there is one.
ERRORS = (" error ", "Requested SDK", "not found", "not be found", "Couldn't", "No usable", "ailed")
NO_FAULT_OF_THE_CODE = {
    "No space left|not enough space": "the disk is full: the C# build needs some 50 MB in .build",
    "MSB3021|MSB3027": "the C# build cannot replace a file that is in use: end the client that still runs",
    "error NU1301": "the C# build needs NuGet, which cannot be reached: try again with internet",
}
# The first restore on a Windows machine has to wait for the virus scanner.
TIMEOUT = 180 if lessons.WINDOWS else 60
# Where the installers put dotnet: a terminal that was open before does not have it on its PATH yet.
PROGRAMS = os.environ.get("PROGRAMFILES", "C:/Program Files") if lessons.WINDOWS else "/usr/local/share"
if Path(PROGRAMS, "dotnet").exists() and not shutil.which("dotnet"):
    os.environ["PATH"] += f"{os.pathsep}{Path(PROGRAMS, 'dotnet')}"


class NoNetMQ(KitError):
    """There is no C# client, at the moment: the Python client runs."""


class DoesNotCompile(KitError):
    """Somebody has changed a C# file: another client would hide it. It says what the compiler says."""


@functools.cache
def listed() -> Result:
    return quietly(["dotnet", "--list-sdks"], 60, ENVIRONMENT)


def download() -> str:
    """Why there is no .NET SDK, and the cure. A dotnet that is there and fails says why itself."""
    why = "no .NET SDK 8 or later here" if listed().code in (0, 127) else f"dotnet fails ({listed().first(*ERRORS)})"
    return f"{why}: get it from {INSTALLER}; just installed: open a new terminal"


@functools.cache
def sdk() -> str | None:
    """The version of the newest .NET SDK, or None where there is none of 8 or later."""
    versions = re.findall(r"^(\d+)\.(\S+)", listed().output, re.MULTILINE)
    recent = [(int(major), f"{major}.{rest}") for major, rest in versions if int(major) >= 8]
    return max(recent)[1] if recent else None


@dataclass(frozen=True)
class NetMQ:
    """Where the package NetMQ comes from: from NuGet, or from a folder of packages that was brought along."""

    folder: str = ""

    @property
    def why(self) -> str:
        if self.folder:
            return f"from the folder {Path(self.folder).name}"
        return "NuGet, or its store on this machine, has it"

    @property
    def properties(self) -> list[str]:
        # Without NuGet its list of vulnerable packages cannot be had either, and asking for it takes long.
        brought = ["-p:NuGetAudit=false", f"-p:RestoreSources={escaped(self.folder)}"] if self.folder else []
        # One process: the few projects are worth less work than MSBuild's start in a second one. No Directory.Build.rsp
        # of a folder above.
        return ["-m:1", "-noAutoResponse", *brought]


def escaped(value: str | Path) -> str:
    """A path as the value of a property: some signs, such as what separates values, mean something to MSBuild."""
    return re.sub("[%$@'();,?*]", lambda sign: f"%{ord(sign[0]):02X}", str(value))


def nuget_folder() -> Path:
    home = ENVIRONMENT.get("HOME") or Path.home()
    return Path(os.environ.get("NUGET_PACKAGES") or Path(home, ".nuget", "packages"))


def projects(netmq: NetMQ, project: Path) -> str:
    return fingerprint(netmq, sorted({CONSOLE, SUPPORT, project}), PROJECTS)


def restore(netmq: NetMQ, project: Path = CONSOLE, limit: float = TIMEOUT) -> Result:
    known = read_json(RESTORED)
    RESTORED.unlink(missing_ok=True)
    # By force, because what an interrupted restore has left looks whole to the next one. In the kit's folder, whose
    # global.json counts there, and none of where the user is.
    result = quietly(["dotnet", "restore", project, "--force", *netmq.properties], limit, ENVIRONMENT, ROOT)
    if result.ok:
        keep(RESTORED, json.dumps({**known, project.name: projects(netmq, project)}))
    return result


def find_netmq(ask_again: bool = False) -> NetMQ:
    """From the folder of packages, or from NuGet; NoNetMQ says why not."""
    if not sdk():
        raise NoNetMQ(download())
    if sign := re.search('%[0-9A-Fa-f]{2}|"', str(ROOT)):
        raise NoNetMQ(f"MSBuild takes {sign[0]} in {ROOT} for another sign: rename the folder")
    memory = BUILD / "netmq.json"
    settings = sorted(f"{key}={value}" for key, value in os.environ.items() if key.upper().startswith("NUGET"))
    targets = (ROOT / "Directory.Build.targets").read_text(encoding="utf-8")
    brought = sorted(path.name for path in PACKAGES.glob("*.nupkg"))
    key = hashlib.sha256(json.dumps([settings, targets, brought, sdk()]).encode()).hexdigest()
    known = read_json(memory)
    if known.get("key") == key and not ask_again:
        return NetMQ(str(known.get("folder", "")))
    if not writable(BUILD):
        raise NoNetMQ(unwritable(BUILD))
    netmq = ask_nuget()
    keep(memory, json.dumps({"key": key, "folder": netmq.folder}))
    return netmq


def ask_nuget() -> NetMQ:
    """A restore shows what they can give. A refusal is not kept: NuGet may answer next time."""
    if any(PACKAGES.glob("*.nupkg")):
        brought = NetMQ(str(PACKAGES))
        if (result := restore(brought)).ok:
            return brought
        say(f"the folder {PACKAGES.name} does not do: {result.first(' error ')}")
    say(f"asking NuGet for NetMQ ({TIMEOUT} s at the most) …")
    if (result := restore(NetMQ())).ok:
        return NetMQ()
    raise NoNetMQ(f"{refusal(result)}; a folder {PACKAGES.name} from `{KIT} pack` serves without internet")


def refusal(result: Result) -> str:
    """Why a restore gave no NetMQ, in a few words; any other failure of the restore is not hidden."""
    if "PackageSourceMapping" in result.output:
        return "no source for NetMQ and what it needs: add the pattern * to packageSourceMapping in your nuget.config"
    if "NU1100" in result.output:
        return f"no source of NuGet's holds NetMQ (with internet: {NO_SOURCE})"
    # It does not hold the package, or not this version of it.
    if re.search("NU110[123]", result.output):
        return "NuGet does not hold NetMQ"
    if result.code == 124 or re.search("NU1301|NU1801", result.output):
        return "NuGet cannot be reached"
    if why := denied(result.output):
        raise KitError(why)
    raise KitError(f"dotnet restore failed: {result.first(*ERRORS)}; is the SDK whole? dotnet --info")


def fingerprint(netmq: NetMQ, sources: list[Path], kinds: Sequence[str] = (".cs", *PROJECTS)) -> str:
    """Changes when a source file, the SDK or the place of NetMQ does."""
    digest = hashlib.sha256(f"{sdk()} {netmq.properties}".encode())
    for source in [*ROOT.glob("Directory.*"), *sources]:
        for path in [source] if source.is_file() else sorted(source.rglob("*")):
            if path.suffix in kinds:
                digest.update(f"{path}{path.stat().st_mtime_ns}{path.stat().st_size}".encode())
    return digest.hexdigest()


def build(netmq: NetMQ, project: Path = CONSOLE) -> Path:
    """Build a project, if anything changed since the last time; returns its .dll."""
    name = next(project.glob("*.csproj")).stem
    dll = BUILD / "bin" / name / "release" / f"{name}.dll"
    # An interrupted build of another project may have taken away what all of them refer to.
    wanted = [dll, COMPILER, *(BUILD / "bin" / one / "release" / f"{one}.dll" for one in LIBRARIES)]

    def make(whole: bool) -> Result:
        if read_json(RESTORED).get(project.name) != projects(netmq, project):
            result = restore(netmq, project, 500)
            if not result.ok:
                return result
        # MSBuild takes even an empty file of an interrupted build for finished.
        again = [] if whole else ["--no-incremental"]
        words = [*netmq.properties, *again, "--no-restore", "-v:quiet", "-clp:NoSummary"]
        result = step(f"building {name}", ["dotnet", "build", project, *words], 500, ENVIRONMENT, ROOT)
        if not result.ok and "error CS" not in result.output:
            # NuGet's store may have been emptied.
            RESTORED.unlink(missing_ok=True)
        return result

    once(name, fingerprint(netmq, [CONSOLE, SUPPORT, project, PACKAGE]), wanted, make)
    return dll


def compile_scripts(netmq: NetMQ, own: Sequence[Path], theirs: Sequence[Path] | None = None) -> Path:
    """Compile a reader's own scripts, if need be: with all of the kit's, which are built, or with those that their
    Unity project has of it, `theirs`. By the compiler alone, since a build would take five times as long.
    """
    # Each list of scripts has a folder of its own: who goes back to one does not wait.
    name = f"own-scripts-{hashlib.sha256(repr(own).encode()).hexdigest()[:12]}"
    folder = BUILD / "bin" / name
    dll, names = folder / "own-scripts.dll", folder / "Names.cs"

    def make(_: bool) -> Result:
        forget_old_lists()
        folder.mkdir(parents=True, exist_ok=True)
        # Compiled once more, the classes of unchanged copies would be other ones than the kit's. Beside a changed copy
        # they are the reader's too: it is the changed one that they are to use.
        unchanged = theirs is None and not any(map(changed_copy, own))
        kit = [path for path in own if unchanged and any(PACKAGE.rglob(path.name))]
        # The player takes what they name of the kit from there, and what their project has of it was not named.
        notes = [(path.stem, "script") for path in kit] + [(path.stem, "unnamed") for path in theirs or ()]
        attribute = "[assembly: System.Reflection.AssemblyMetadata({}, {})]\n"
        names.write_text("".join(attribute.format(*map(json.dumps, note)) for note in notes), encoding="utf-8")
        # A script of a Unity project sees what that project has of the kit, and not the kit behind this name, by which
        # nobody calls the kit's own.
        alias = "" if theirs is None else "kit="
        scripts = [path for path in [*own, *(theirs or ())] if path not in kit]
        words = [f"@{COMPILER}", f'-r:{alias}"{COMPILER.with_name("NetMQExample.dll")}"', f'-out:"{dll}"']
        compiler = COMPILER.read_text(encoding="utf-8").partition("\n")[0].lstrip("# ")
        command: list[str | Path] = ["dotnet", compiler, "-noconfig", *words, names, *scripts]
        return step("building your scripts", command, 500, ENVIRONMENT)

    sources = fingerprint(netmq, [CONSOLE, SUPPORT, PACKAGE, *own, *(theirs or ())])
    once(name, f"{theirs is None} {sources}", [dll], make)
    return dll


def once(name: str, sources: str, wanted: list[Path], make: Callable[[bool], Result]) -> None:
    """Make what is wanted, unless it is there and of the same sources; `make` hears if the last time came to an end."""
    stamp = BUILD / f"{name}.stamp"

    def fresh() -> bool:
        return all(map(Path.exists, wanted)) and read_json(stamp).get("sources") == sources

    if fresh():
        return
    if not writable(BUILD):
        raise KitError(unwritable(BUILD))
    with locked(LOCK):
        # The one that held the lock before may have built the same.
        if fresh():
            return
        whole = stamp.exists()
        stamp.unlink(missing_ok=True)
        result = make(whole)
        if result.ok:
            keep(stamp, json.dumps({"sources": sources}))
            return
        why = failure(result)
        if "error CS" not in why:
            raise KitError(why)
        if whole:
            keep(stamp, "{}")
        raise DoesNotCompile(why)


def forget_old_lists() -> None:
    """A day of trying things out should not fill a disk."""
    for stamp in sorted(BUILD.glob("own-scripts-*.stamp"), key=lambda path: path.stat().st_mtime)[:-20]:
        shutil.rmtree(BUILD / "bin" / stamp.stem, ignore_errors=True)
        stamp.unlink()


def changed_copy(path: Path) -> bool:
    namesakes = [*PACKAGE.rglob(path.name)]
    return bool(namesakes) and all(path.read_bytes() != one.read_bytes() for one in namesakes)


def failure(result: Result) -> str:
    """Why a build has failed: in one line where it is not the code."""
    if why := denied(result.output):
        return f"the C# build failed: {why}"
    for pattern, why in NO_FAULT_OF_THE_CODE.items():
        if re.search(pattern, result.output):
            return why
    if "error CS" not in result.output:
        return f"the C# build failed ({result.first(*ERRORS)}); delete the folder {BUILD} and try again"
    cure = f"fix it; if nobody has changed a file, delete the folder {BUILD}"
    return "\n".join(["the C# build failed:", *compiler_errors(result.output), cure])


def compiler_errors(output: str) -> list[str]:
    """Each of them once, without the project that stands after it."""
    return list(dict.fromkeys(re.findall(r"^(.+: error CS.+?)(?: \[[^\]]+proj\])?$", output, re.MULTILINE)))
