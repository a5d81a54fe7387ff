"""kit.py unity PATH: what it copies into a project, and what it never does."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from kitlib import dotnet, guide, python_setup, unity_install
from kitlib.lessons import ROOT, KitError, lessons
from kitlib.terminal import Result
from kitlib.unity_meta import PACKAGE

TARGET = "Assets/NetMQExample"


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A Unity project as Unity Hub makes it, as far as this matters."""
    root = tmp_path / "My Game"
    for folder in ("Assets", "Packages", "ProjectSettings"):
        (root / folder).mkdir(parents=True)
    (root / "ProjectSettings" / "ProjectVersion.txt").write_text("m_EditorVersion: 2022.3.10f1\n")
    (root / "Packages" / "manifest.json").write_text('{"dependencies": {"com.unity.ugui": "1.0.0"}}')
    return root


@pytest.fixture
def nuget(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A NuGet folder with stand-ins of the three DLLs: what is copied does not depend on what is in them."""
    folder = tmp_path / "packages"
    for package, version, inside in unity_install.LIBRARIES:
        path = folder / package.lower() / version / inside
        path.parent.mkdir(parents=True)
        path.write_bytes(b"MZ " + package.encode())
    monkeypatch.setenv("NUGET_PACKAGES", str(folder))
    yield folder


def listing(root: Path) -> dict[str, bytes]:
    return {path.relative_to(root).as_posix(): path.read_bytes() for path in root.rglob("*") if path.is_file()}


def test_copies_everything_with_its_meta(project: Path, nuget: Path, capsys: pytest.CaptureFixture[str]) -> None:
    unity_install.install(project, None, False)
    files = listing(project / TARGET)
    for path in PACKAGE.rglob("*.cs"):
        assert files[path.relative_to(PACKAGE).as_posix()] == path.read_bytes()
    for name in files:
        assert name.endswith(".meta") or name.startswith(".") or f"{name}.meta" in files, f"{name} has no .meta"
    assert files["Plugins/NetMQ.dll"] == b"MZ NetMQ"
    settings = files["Plugins/NetMQ.dll.meta"].decode()
    assert "validateReferences: 0" in settings and "Exclude WebGL: 1" in settings
    guids = re.findall(rb"^guid: (.+)$", b"\n".join(d for n, d in files.items() if n.endswith(".meta")), re.MULTILINE)
    assert len(guids) == len(set(guids))
    printed = capsys.readouterr().out
    assert "wrote Assets/NetMQExample/Plugins/NetMQ.dll" in printed
    assert str(ROOT / "python" / "01_request_reply" / "server.py") in printed
    assert "press Play" in printed
    assert not list(project.glob(".netmqexample-*"))


def test_the_page_shows_what_is_printed(
    project: Path, nuget: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = ROOT / "docs" / "guide" / "unity_project.md"
    (shown,) = [block.body for block in guide.blocks(page) if "test_the_page_shows_what_is_printed" in block.source]
    kit = tmp_path / "KIT"
    (kit / ".venv" / "bin").mkdir(parents=True)
    (kit / ".venv" / "bin" / "python").touch()
    licences = unity_install.notices()
    monkeypatch.setattr(unity_install, "ROOT", kit)
    monkeypatch.setattr(python_setup, "venv_python", lambda: kit / ".venv" / "bin" / "python")
    monkeypatch.setattr(unity_install, "notices", lambda: licences)
    unity_install.install(project, "4", False)
    assert capsys.readouterr().out.replace(f"{tmp_path}/", "") == shown


def test_again_changes_nothing(project: Path, nuget: Path, capsys: pytest.CaptureFixture[str]) -> None:
    unity_install.install(project, None, False)
    before = listing(project)
    capsys.readouterr()
    unity_install.install(project, None, False)
    assert listing(project) == before
    assert "wrote" not in capsys.readouterr().out


def test_a_newer_kit_replaces_what_it_wrote(project: Path, nuget: Path) -> None:
    unity_install.install(project, None, False)
    dll = nuget / "netmq" / "4.0.4.3" / "lib" / "netstandard2.1" / "NetMQ.dll"
    dll.write_bytes(b"MZ newer")
    unity_install.install(project, None, False)
    assert (project / TARGET / "Plugins" / "NetMQ.dll").read_bytes() == b"MZ newer"


def test_never_overwrites_a_changed_file(project: Path, nuget: Path) -> None:
    unity_install.install(project, None, False)
    mine = project / TARGET / "01_request_reply" / "HelloClient.cs"
    mine.write_text("// mine\n")
    (project / TARGET / "01_request_reply" / "HelloRequester.cs").unlink()
    before = listing(project)
    with pytest.raises(KitError, match=r"HelloClient\.cs was changed .* --force") as error:
        unity_install.install(project, None, False)
    assert "\n" not in str(error.value)
    assert listing(project) == before
    unity_install.install(project, None, True)
    assert mine.read_bytes() == (PACKAGE / "01_request_reply" / "HelloClient.cs").read_bytes()


def test_keeps_a_meta_file_that_unity_wrote(project: Path, nuget: Path) -> None:
    unity_install.install(project, None, False)
    meta = project / TARGET / "01_request_reply" / "HelloClient.cs.meta"
    meta.write_text("guid: 00000000000000000000000000000001\n")
    unity_install.install(project, None, True)
    assert "0001" in meta.read_text()


@pytest.mark.parametrize("key", [lesson.key for lesson in lessons() if lesson.unity.is_dir()])
def test_one_lesson_takes_only_what_it_uses(key: str, project: Path, nuget: Path) -> None:
    unity_install.install(project, key[:2], False)
    copied = {path.name for path in (project / TARGET).rglob("*.cs")}
    assert copied >= {path.name for path in (PACKAGE / key).glob("*.cs")}
    assert "NetMQLifetime.cs" in copied
    assert (project / TARGET / "NetMQExample.asmdef").exists(), "the game's own assemblies could not refer to them"
    assert not list((project / TARGET).rglob("*.unity"))
    if key.startswith("01"):
        assert copied == {"HelloClient.cs", "HelloRequester.cs", "NetMQLifetime.cs"}
    # Whatever class of the kit a copied file uses has come along.
    stems = {path.stem for path in PACKAGE.glob("[0-9]*/*.cs") if path.parent.name <= key}
    for path in (project / TARGET).rglob("*.cs"):
        words = set(re.findall(r"(?<![\w.])\w+", re.sub(r"//.*", "", path.read_text(encoding="utf-8"))))
        assert {f"{stem}.cs" for stem in stems & words} <= copied


def test_two_copies_of_netmq_do_not_compile(project: Path, nuget: Path) -> None:
    (project / "Packages" / "manifest.json").write_text('{"dependencies": {"org.nuget.netmq": "4.0.4-3"}}')
    unity_install.install(project, None, False)
    assert not (project / TARGET / "Plugins").exists()


def test_a_library_that_is_there_alone_is_not_copied_again(project: Path, nuget: Path) -> None:
    """Some other package has brought it."""
    mine = project / "Assets" / "Other" / "AsyncIO.dll"
    mine.parent.mkdir()
    mine.write_bytes(b"MZ mine")
    unity_install.install(project, "4", False)
    copied = {path.name for path in (project / TARGET / "Plugins").iterdir()}
    assert copied == {"NetMQ.dll", "NetMQ.dll.meta", "NaCl.dll", "NaCl.dll.meta"}


def test_a_script_that_was_moved_would_be_there_twice(project: Path, nuget: Path) -> None:
    unity_install.install(project, "4", False)
    new = project / "Assets" / "Scripts"
    new.mkdir()
    for name in ("BackgroundClient.cs", "BackgroundClient.cs.meta"):
        (project / TARGET / "04_background_client" / name).rename(new / name)
    before = listing(project)
    with pytest.raises(
        KitError, match=r"^Assets/Scripts/BackgroundClient\.cs is .*, moved: nothing was copied"
    ) as error:
        unity_install.install(project, "4", False)
    assert "\n" not in str(error.value)
    assert listing(project) == before


def test_a_file_of_the_same_name_is_no_script_of_ours(project: Path, nuget: Path) -> None:
    for name, text in (
        ("Message.cs", "class Message { }"),
        ("Message.cs.meta", "guid: 00000000000000000000000000000001\n"),
    ):
        (project / "Assets" / name).write_text(text)
    unity_install.install(project, "5", False)
    assert (project / TARGET / "05_messages" / "Message.cs").exists()


@pytest.mark.parametrize(("level", "said"), [(3, True), (6, False)])
def test_the_net_framework_is_advised_against(
    level: int, said: bool, project: Path, nuget: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = (
        f"PlayerSettings:\n  apiCompatibilityLevelPerPlatform:\n    Android: 6\n    Standalone: {level}\n  other: 3\n"
    )
    (project / "ProjectSettings" / "ProjectSettings.asset").write_text(settings)
    unity_install.install(project, "4", False)
    assert ("Api Compatibility Level" in capsys.readouterr().out) == said


def test_the_licences_go_where_the_files_go(project: Path, nuget: Path) -> None:
    unity_install.install(project, "4", False)
    assert (project / TARGET / "LICENSE.md").read_bytes() == (ROOT / "LICENSE").read_bytes()
    assert "MPL-2.0" in (project / TARGET / "THIRD-PARTY-NOTICES.md").read_text(encoding="utf-8")


def test_two_copies_of_the_scripts_do_not_compile(project: Path, nuget: Path) -> None:
    name = json.loads((PACKAGE / "package.json").read_text())["name"]
    (project / "Packages" / "manifest.json").write_text(
        json.dumps({"dependencies": {name: "https://example.org/x.git"}})
    )
    unity_install.install(project, None, False)
    assert not list((project / TARGET).rglob("*.cs"))
    # Unity reads no link.xml in a package, and the GUID of its .meta is taken.
    assert (project / TARGET / "link.xml").read_bytes() == (PACKAGE / "link.xml").read_bytes()
    assert not (project / TARGET / "link.xml.meta").exists()
    assert (project / TARGET / "Plugins" / "NetMQ.dll").exists()


def test_a_folder_inside_the_project_will_do(project: Path, nuget: Path) -> None:
    unity_install.install(project / "Assets", "1", False)
    assert (project / TARGET / "01_request_reply" / "HelloClient.cs").exists()


@pytest.mark.parametrize("where", ["nowhere", "."])
def test_says_why_it_is_no_project(where: str, tmp_path: Path, nuget: Path) -> None:
    with pytest.raises(KitError, match="is no Unity project") as error:
        unity_install.install(tmp_path / where, None, False)
    assert "\n" not in str(error.value)


def test_an_old_unity_is_refused(project: Path, nuget: Path) -> None:
    (project / "ProjectSettings" / "ProjectVersion.txt").write_text("m_EditorVersion: 2020.3.1f1\n")
    with pytest.raises(KitError, match=r"2021\.2 or later"):
        unity_install.install(project, None, False)


@pytest.mark.parametrize("sdk", ["8.0", None])
def test_without_nuget_nothing_is_copied(
    sdk: str | None, project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUGET_PACKAGES", str(tmp_path / "empty"))
    monkeypatch.setattr(dotnet, "sdk", lambda: sdk)
    monkeypatch.setattr(dotnet, "restore", lambda engine: Result(1, "error NU1301: no such host"))
    # A port where nobody listens.
    monkeypatch.setattr(unity_install, "NUGET", "http://127.0.0.1:9")
    before = listing(project)
    with pytest.raises(KitError, match="nothing was copied") as error:
        unity_install.install(project, None, False)
    assert "\n" not in str(error.value)
    assert listing(project) == before


def test_downloads_without_an_sdk(project: Path, nuget: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """NuGet's packages are zip files; here they come from a folder."""
    import zipfile

    for package, version, inside in unity_install.LIBRARIES:
        name = package.lower()
        path = tmp_path / "feed" / name / version / f"{name}.{version}.nupkg"
        path.parent.mkdir(parents=True)
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(inside, b"MZ downloaded")
    monkeypatch.setenv("NUGET_PACKAGES", str(tmp_path / "empty"))
    monkeypatch.setattr(dotnet, "sdk", lambda: None)
    monkeypatch.setattr(unity_install, "NUGET", (tmp_path / "feed").as_uri())
    unity_install.install(project, "1", False)
    assert (project / TARGET / "Plugins" / "AsyncIO.dll").read_bytes() == b"MZ downloaded"


def test_the_real_dlls(project: Path, engine: dotnet.Engine) -> None:
    if engine.name != "netmq":
        pytest.skip(f"the engine of this run is {engine.name}, and NetMQ's DLLs come from NuGet")
    unity_install.install(project, "1", False)
    for name in ("NetMQ.dll", "AsyncIO.dll", "NaCl.dll"):
        assert (project / TARGET / "Plugins" / name).read_bytes()[:2] == b"MZ"
