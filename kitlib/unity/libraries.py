"""NetMQ's DLLs for Unity, with their import settings and licences: from NuGet, or from a folder that the user has."""

import io
import re
import urllib.request
import zipfile
from collections.abc import Callable
from pathlib import Path

from kitlib.lessons import PACKAGE, ROOT, KitError
from kitlib.setup import dotnet
from kitlib.terminal import say
from kitlib.unity.inventory import LIBRARIES, PARTS, TARGET
from kitlib.unity.meta import guid, meta

NUGET = "https://api.nuget.org/v3-flatcontainer"
PLUGINS = f"{TARGET}/Plugins"
# The texts that the licences of the DLLs ask for, and by what name a NuGet package has its own.
LICENCES = ROOT / "licences"
NOTICE = re.compile(r"(LICENSE|COPYING|THIRD-PARTY-NOTICES)[^/]*", re.IGNORECASE)
# isExplicitlyReferenced: no script names a class of .NET's own libraries, so a game's other scripts need not see them.
# validateReferences: another package's copy may have another version number, which is as good.
IMPORT_SETTINGS = Path(__file__).with_name("dll.meta.txt")


def notices() -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    for source, name in (("LICENSE", "LICENSE.md"), ("THIRD-PARTY-NOTICES.md", "THIRD-PARTY-NOTICES.md")):
        found[f"{TARGET}/{name}"] = (ROOT / source).read_bytes()
        found[f"{TARGET}/{name}.meta"] = meta(PACKAGE / "CHANGELOG.md", guid(name)).encode()
    return found


def libraries(folder: Path | None, ask: Callable[[str], set[str]] = lambda name: PARTS) -> dict[str, bytes]:
    """The DLLs with their import settings and licences; `ask` says where a DLL is missing, of PARTS."""
    found: dict[str, bytes] = {}
    texts = {path.name: path.read_bytes() for path in sorted(LICENCES.glob("*.txt"))}
    for package, version, inside in LIBRARIES:
        name = inside.rsplit("/", 1)[1]
        if not (parts := ask(name)):
            continue
        if folder:
            if not (folder / name).is_file():
                raise KitError(f"there is no {name} in {folder}: nothing was copied")
            found[f"{PLUGINS}/{name}"] = (folder / name).read_bytes()
        else:
            found[f"{PLUGINS}/{name}"], carried = library(package, version, inside)
            texts |= {f"{package}-{text}": data for text, data in carried.items()}
        where = {"editor": "editor" in parts, "no_editor": "editor" not in parts, "builds": "builds" in parts}
        settings = IMPORT_SETTINGS.read_text(encoding="utf-8")
        text = settings.format(guid=guid(f"Plugins/{name}"), hidden=name.startswith("System."), **where)
        found[f"{PLUGINS}/{name}.meta"] = text.encode()
    found[f"{PLUGINS}.meta"] = meta(PACKAGE / "Shared", guid("Plugins")).encode()
    for name, data in texts.items():
        found[f"{PLUGINS}/{name}"] = data
        found[f"{PLUGINS}/{name}.meta"] = meta(PACKAGE / "CHANGELOG.md", guid(f"Plugins/{name}")).encode()
    return found


def library(package: str, version: str, inside: str) -> tuple[bytes, dict[str, bytes]]:
    """One DLL, and the notices that its package carries: from NuGet's folder on this machine, put there by dotnet if
    there is one, or from NuGet itself."""
    file = f"{package.lower()}/{version}/{package.lower()}.{version}.nupkg"
    here = dotnet.nuget_folder() / file
    if not here.exists() and dotnet.sdk():
        say(f"asking NuGet for {package} …")
        result = dotnet.restore(dotnet.NetMQ())
        if not result.ok:
            others = "without NetMQ's DLLs, for which docs/guide/unity_project.md has other routes"
            why = dotnet.refusal(result)
            raise KitError(f"{why}: nothing was copied; --scripts-only copies the scripts {others}")
    if not here.exists():
        say(f"downloading {package} {version} from NuGet …")
    try:
        with zipfile.ZipFile(here if here.exists() else download(file)) as archive:
            notices = {text: archive.read(text) for text in archive.namelist() if NOTICE.fullmatch(text)}
            return archive.read(inside), notices
    except (OSError, zipfile.BadZipFile, KeyError) as error:
        raise KitError(f"NuGet gave no {package} {version} ({error}): nothing was copied") from None


def download(file: str) -> io.BytesIO:
    with urllib.request.urlopen(f"{NUGET}/{file}", timeout=20) as answer:
        return io.BytesIO(answer.read())
