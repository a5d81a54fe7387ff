"""kit.py unity --package FILE, read back with tarfile and compared with the tree. No editor has imported one here."""

import json
import re
import tarfile
from pathlib import Path

import pytest

from kitlib import files
from kitlib.unity import package
from kitlib.unity.inventory import LIBRARIES
from tests.conftest import PYTHON
from tests.programs import ROOT, finished

TREE = ROOT / "unity" / "Assets" / "NetMQExample"
ENTRY = re.compile(r"([0-9a-f]{32})/(asset|asset\.meta|pathname)")
# They share a package.
pytestmark = pytest.mark.xdist_group("package")


@pytest.fixture(scope="module")
def dlls(tmp_path_factory):
    """Stand-ins: what is packed does not depend on what is in them."""
    folder = tmp_path_factory.mktemp("dlls")
    for _, _, inside in LIBRARIES:
        (folder / Path(inside).name).write_bytes(b"MZ " + inside.encode())
    return folder


def pack(file, dlls, *words):
    done = finished([PYTHON, ROOT / "kit.py", "unity", "--package", file, "--dlls", dlls, *words])
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.rstrip().endswith("next, in Unity: Assets, Import Package, Custom Package")
    return file


@pytest.fixture(scope="module")
def packed(dlls, tmp_path_factory):
    return pack(tmp_path_factory.mktemp("package") / "Kit.unitypackage", dlls)


def read(file):
    """Each path in a project, and its parts: asset.meta and, of a file, asset."""
    with tarfile.open(file, "r:gz") as archive:
        members = archive.getmembers()
        assert len({member.name for member in members}) == len(members), "an entry is there twice"
        parts = {member.name: archive.extractfile(member).read() for member in members}
    parts.pop("packagemanagermanifest/asset", None)
    assert all(ENTRY.fullmatch(name) for name in parts)
    found = {}
    for folder in sorted({name.partition("/")[0] for name in parts}):
        path = parts[f"{folder}/pathname"].decode()
        assert path not in found, f"{path} has two GUIDs"
        found[path] = {
            name: parts[f"{folder}/{name}"] for name in ("asset", "asset.meta") if f"{folder}/{name}" in parts
        }
        assert re.findall(rb"^guid: (.+)$", found[path]["asset.meta"], re.MULTILINE) == [folder.encode()]
    for path in found:
        assert path == "Assets/NetMQExample" or str(Path(path).parent.as_posix()) in found, f"{path} has no folder"
    return found


def tree():
    """Every file and folder of the package in the repository, by its path in a project."""
    here = [path for path in TREE.rglob("*") if path.suffix != ".meta" and "Plugins" not in path.parts]
    return {f"Assets/{path.relative_to(TREE.parent).as_posix()}": path for path in [TREE, *here]}


def test_it_holds_the_package_the_dlls_and_the_licences(packed, dlls):
    found = read(packed)
    for name, path in tree().items():
        parts = found.pop(name)
        assert parts["asset.meta"] == path.with_name(f"{path.name}.meta").read_bytes(), name
        assert parts.get("asset") == (path.read_bytes() if path.is_file() else None), name
    assert found.pop("Assets/NetMQExample/Plugins").keys() == {"asset.meta"}
    notices = found.pop("Assets/NetMQExample/THIRD-PARTY-NOTICES.md")
    assert notices["asset"] == (ROOT / "THIRD-PARTY-NOTICES.md").read_bytes()
    beside = [*dlls.iterdir(), *(ROOT / "licences").iterdir()]
    libraries = {f"Assets/NetMQExample/Plugins/{path.name}": path.read_bytes() for path in beside}
    assert {name: parts["asset"] for name, parts in found.items()} == libraries
    for name, parts in found.items():
        assert (b"Exclude WebGL: 1" in parts["asset.meta"]) == name.endswith(".dll"), name


def test_equal_input_makes_an_equal_file(packed, dlls, tmp_path):
    assert pack(tmp_path / "Other.unitypackage", dlls).read_bytes() == packed.read_bytes()


def test_an_interrupted_run_leaves_nothing(tmp_path, monkeypatch):
    def full(*paths):
        raise OSError("no space left")

    monkeypatch.setattr(files, "replace", full)
    with pytest.raises(OSError, match="no space left"):
        package.write_package(tmp_path / "Kit.unitypackage", "1", False, True, None)
    assert list(tmp_path.iterdir()) == []


def test_what_stands_in_the_way_is_named(start, tmp_path):
    def refused(file, *words):
        program = start(PYTHON, ROOT / "kit.py", "unity", "--package", file, "--scripts-only", *words)
        assert program.wait() == 1, program.output
        assert len(program.lines) == 1
        return program.lines[0]

    mine = tmp_path / "mine.unitypackage"
    mine.write_bytes(b"mine")
    assert refused(mine).endswith("is there already: nothing was written; --force overwrites it")
    assert mine.read_bytes() == b"mine"
    assert "'Kit.zip' must end in .unitypackage" in refused(tmp_path / "Kit.zip")
    assert refused(mine / "Kit.unitypackage").endswith("; it is in the way: name another place")
    assert [path.name for path in tmp_path.iterdir()] == ["mine.unitypackage"]
    forced = start(PYTHON, ROOT / "kit.py", "unity", "--package", mine, "--scripts-only", "--force", "--lesson", "1")
    assert forced.wait() == 0, forced.output
    found = read(mine)
    assert "Assets/NetMQExample/01_request_reply/HelloClient.cs" in found
    assert not [name for name in found if "/02_" in name or "/Plugins" in name]
    with tarfile.open(mine) as archive:
        manifest = json.load(archive.extractfile("packagemanagermanifest/asset"))
    assert manifest == {"dependencies": {"com.unity.modules.jsonserialize": "1.0.0"}}, "ServerAddress reads a field"
