"""A release: the sources of the last commit, and Unity's package."""

import io
import subprocess
import tarfile
import zipfile

import pytest

from kitlib import release
from kitlib.lessons import KitError
from kitlib.unity import install


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A small repository, NetMQ's DLLs in a folder of NuGet's, and a changelog that has the version."""
    root = tmp_path / "kit"
    root.mkdir()
    (root / "pyproject.toml").write_text('[project]\nversion = "1.2.3"\n')
    (root / "CHANGELOG.md").write_text("# Changelog\n\n## [1.2.3] - 2026-11-22\n")
    (root / "kept.txt").write_text("kept\n")
    who = ["-c", "user.name=Nobody", "-c", "user.email=nobody@example.com"]
    for words in (["init", "-q"], ["add", "-A"], [*who, "commit", "-q", "-m", "All"]):
        subprocess.run(["git", *words], cwd=root, check=True)
    for package, version, inside in install.LIBRARIES:
        dll = tmp_path / "nuget" / package.lower() / version / inside
        dll.parent.mkdir(parents=True)
        dll.write_bytes(b"MZ")
    monkeypatch.setenv("NUGET_PACKAGES", str(tmp_path / "nuget"))
    monkeypatch.setattr(release, "ROOT", root)
    return root


def test_it_has_what_was_committed_and_unitys_package(checkout, tmp_path):
    release.release(tmp_path / "out")
    with zipfile.ZipFile(tmp_path / "out" / "NetMQExample-1.2.3.zip") as sources:
        names = {name for name in sources.namelist() if not name.endswith("/")}
        assert names == {f"NetMQExample-1.2.3/{name}" for name in ("pyproject.toml", "CHANGELOG.md", "kept.txt")}
    data = (tmp_path / "out" / "NetMQExample-1.2.3.unitypackage").read_bytes()
    with tarfile.open(fileobj=io.BytesIO(data)) as package:
        found = [package.extractfile(member) for member in package if member.name.endswith("/pathname")]
        paths = {file.read() for file in found if file}
    assert b"Assets/NetMQExample/Shared/NetMQLifetime.cs" in paths
    assert b"Assets/NetMQExample/Plugins/NetMQ.dll" in paths


@pytest.mark.parametrize(
    ("name", "text", "why"),
    [
        ("kept.txt", "changed", "kept.txt is not committed"),
        ("CHANGELOG.md", "# Changelog\n\n## [1.2.2] - 2026-01-01\n", r"CHANGELOG.md has no section \[1.2.3\]"),
    ],
)
def test_what_is_not_ready_is_said(checkout, tmp_path, name, text, why):
    (checkout / name).write_text(text)
    with pytest.raises(KitError, match=why):
        release.release(tmp_path / "out")
    assert not (tmp_path / "out").exists()
