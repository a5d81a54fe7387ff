"""A .unitypackage, without an editor: the lessons' scripts and scenes, NetMQ's DLLs and the licences in one file.

It is a gzipped tar. Each asset has a folder there that is named by its GUID: `pathname` says where it belongs in a
project, `asset.meta` and `asset` are the two files; a folder has no `asset`. Equal input makes an equal file.
"""

import gzip
import io
import json
import tarfile
from pathlib import Path

from kitlib.files import put
from kitlib.lessons import KitError
from kitlib.terminal import say
from kitlib.unity.install import ALONE
from kitlib.unity.libraries import libraries, notices
from kitlib.unity.scripts import scripts, unitys_packages

# In this entry Unity's own tools write the packages that an import adds to the project's manifest.
MANIFEST = "packagemanagermanifest/asset"


def write_package(path: Path, lesson: str | None, force: bool, scripts_only: bool, dlls: Path | None) -> None:
    """All of the package, or what one lesson needs; a KitError says why not."""
    if path.suffix != ".unitypackage":
        raise KitError(f"{path.name!r:.80} must end in .unitypackage: by that Unity knows what it is")
    if path.exists() and not force:
        raise KitError(f"{path} is there already: nothing was written; --force overwrites it")
    files = {**scripts(lesson), **notices(), **({} if scripts_only else libraries(dlls))}
    found = entries(files)
    path.parent.mkdir(parents=True, exist_ok=True)
    put(path, packed(found))
    count = sum(name.endswith("/asset") and name != MANIFEST for name in found)
    say(f"wrote {path}: {count} files, {path.stat().st_size / 1e6:.1f} MB")
    if scripts_only:
        say(ALONE)
    say("next, in Unity: Assets, Import Package, Custom Package")


def entries(files: dict[str, bytes]) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    for name in sorted(files):
        if not name.endswith(".meta"):
            continue
        path = name.removesuffix(".meta")
        # The second line of a .meta file says the GUID.
        folder = files[name].splitlines()[1].removeprefix(b"guid: ").decode()
        if path in files:
            found[f"{folder}/asset"] = files[path]
        found[f"{folder}/asset.meta"] = files[name]
        found[f"{folder}/pathname"] = path.encode()
    if wanted := unitys_packages(files):
        found[MANIFEST] = json.dumps({"dependencies": wanted}).encode()
    return found


def packed(found: dict[str, bytes]) -> bytes:
    """No times, no names of users, and one order."""
    result = io.BytesIO()
    with (
        gzip.GzipFile(filename="", mode="wb", fileobj=result, mtime=0) as zipped,
        tarfile.open(fileobj=zipped, mode="w", format=tarfile.USTAR_FORMAT) as archive,
    ):
        for name in sorted(found):
            entry = tarfile.TarInfo(name)
            entry.size = len(found[name])
            archive.addfile(entry, io.BytesIO(found[name]))
    return result.getvalue()
