"""kit.py unity PATH: what it copies into a project, and what it never does."""

import contextlib
import json
import os
import re
import shutil
import zipfile
from pathlib import Path

import pytest

from kitlib import files, terminal
from kitlib.docs import guide
from kitlib.lessons import PACKAGE, ROOT, KitError, lessons
from kitlib.programs import Result
from kitlib.setup import dotnet
from kitlib.unity import install as unity_install
from kitlib.unity import libraries
from kitlib.unity.inventory import LIBRARIES
from kitlib.unity.scripts import code as script_code
from kitlib.unity.scripts import scripts as copied_scripts
from tests.unity.conftest import put

TARGET = "Assets/NetMQExample"


# The words of texts that must lie beside NetMQ's DLLs.
LICENCES = (
    "GNU LESSER GENERAL",
    "SPECIAL EXCEPTION",
    "GNU GENERAL PUBLIC",
    "Mozilla Public",
    ".NET Foundation and Contr",
)


def a_dll(version):
    """The words of a DLL's resources that say its version."""
    return b"MZ" + f"FileVersion\0\0{version}\0".encode("utf-16-le")


@pytest.fixture
def project(tmp_path):
    """A Unity project as Unity Hub makes it, as far as this matters."""
    root = tmp_path / "My Game"
    for folder in ("Assets", "Packages", "ProjectSettings"):
        (root / folder).mkdir(parents=True)
    (root / "ProjectSettings" / "ProjectVersion.txt").write_text("m_EditorVersion: 2022.3.10f1\n")
    (root / "Packages" / "manifest.json").write_text('{"dependencies": {"com.unity.ugui": "1.0.0"}}')
    return root


def fill(folder, begins="MZ"):
    """A NuGet folder with stand-ins of the DLLs: what is copied does not depend on what is in them."""
    for package, version, inside in LIBRARIES:
        name = package.lower()
        path = folder / name / version / f"{name}.{version}.nupkg"
        path.parent.mkdir(parents=True, exist_ok=True)
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(inside, f"{begins} {package}")
            if package == "System.ServiceModel.Primitives":
                archive.writestr("THIRD-PARTY-NOTICES.TXT", "of others")


@pytest.fixture
def nuget(tmp_path, monkeypatch):
    folder = tmp_path / "packages"
    fill(folder)
    monkeypatch.setenv("NUGET_PACKAGES", str(folder))
    yield folder


@contextlib.contextmanager
def refused(project, why):
    """In one line, and nothing is changed."""
    before = listing(project)
    with pytest.raises(KitError, match=why) as error:
        yield
    assert "\n" not in str(error.value)
    assert listing(project) == before


def plugins(project):
    return {path.name for path in (project / TARGET / "Plugins").glob("*.dll")}


def listing(root):
    return {path.relative_to(root).as_posix(): path.read_bytes() for path in root.rglob("*") if path.is_file()}


def test_copies_everything_with_its_meta(project, nuget, capsys):
    unity_install.install(project)
    files = listing(project / TARGET)
    for path in PACKAGE.rglob("*.cs"):
        assert files[path.relative_to(PACKAGE).as_posix()] == path.read_bytes()
    for name in files:
        assert name.endswith(".meta") or name.startswith(".") or f"{name}.meta" in files, f"{name} has no .meta"
    assert files["Plugins/NetMQ.dll"] == b"MZ NetMQ"
    assert files["LICENSE.md"] == (ROOT / "LICENSE").read_bytes()
    assert b"MPL-2.0" in files["THIRD-PARTY-NOTICES.md"]
    texts = "\n".join(d.decode() for n, d in files.items() if n.startswith("Plugins/") and n.lower().endswith(".txt"))
    for words in LICENCES:
        assert words in texts
    assert files["Plugins/System.ServiceModel.Primitives-THIRD-PARTY-NOTICES.TXT"] == b"of others"
    settings = files["Plugins/NetMQ.dll.meta"].decode()
    assert "validateReferences: 0" in settings and "Exclude WebGL: 1" in settings
    # No script of the game sees the DLLs of .NET's own.
    hidden = {name for name, data in files.items() if b"isExplicitlyReferenced: 1\n" in data}
    assert hidden == {f"Plugins/{name}.meta" for name in SHARED_DLLS}
    guids = re.findall(rb"^guid: (.+)$", b"\n".join(d for n, d in files.items() if n.endswith(".meta")), re.MULTILINE)
    assert len(guids) == len(set(guids))
    printed = capsys.readouterr().out
    assert "wrote Assets/NetMQExample/Plugins/NetMQ.dll" in printed
    assert "kit.py server 1\n" in printed
    assert "press Play" in printed
    # An agent of one's own takes the place of the lesson's.
    assert (
        ": CameraSensor, your agent or CoinCarAgent, CoinField; and"
        in unity_install.next_steps(project.parent, "11")[-1]
    )
    assert not list(project.glob(".netmqexample-*"))


def test_the_page_shows_what_is_printed(project, nuget, tmp_path, monkeypatch, capsys):
    page = ROOT / "docs" / "guide" / "unity_project.md"
    (shown,) = [block.body for block in guide.blocks(page) if "test_the_page_shows_what_is_printed" in block.source]
    kit = tmp_path / "KIT"
    licences = libraries.notices()
    monkeypatch.setattr(unity_install, "ROOT", kit)
    monkeypatch.setattr(unity_install, "notices", lambda: licences)
    unity_install.install(project, "4")
    printed = capsys.readouterr().out.replace("\\", "/")
    assert guide.same(shown.splitlines(), printed.replace(f"{tmp_path.as_posix()}/", "").splitlines())


def test_a_changed_file_is_overwritten_by_force_alone_and_unitys_meta_never(project, nuget):
    unity_install.install(project)
    mine = project / TARGET / "01_request_reply" / "HelloClient.cs"
    mine.write_text("// mine\n")
    meta = mine.with_name("HelloClient.cs.meta")
    meta.write_text("fileFormatVersion: 2\nguid: 00000000000000000000000000000001\n")
    # A newer kit replaces what it wrote.
    fill(nuget, "MZ newer")
    with refused(project, r"HelloClient\.cs was changed .* --force"):
        unity_install.install(project)
    unity_install.install(project, force=True)
    assert mine.read_bytes() == (PACKAGE / "01_request_reply" / "HelloClient.cs").read_bytes()
    assert "0001" in meta.read_text()
    assert (project / TARGET / "Plugins" / "NetMQ.dll").read_bytes() == b"MZ newer NetMQ"


def asmdef(name):
    return json.dumps({"name": name})


VERSION, MANIFEST = "ProjectSettings/ProjectVersion.txt", "Packages/manifest.json"
NO_LIST = '{"dependencies": []}'
UNITY_2021 = {VERSION: "m_EditorVersion: 2021.3.45f1\n"}


@pytest.mark.parametrize(
    ("there", "lesson", "why"),
    [
        *(({MANIFEST: text}, "4", "manifest.json is no valid manifest: .*; correct it") for text in (NO_LIST, "{")),
        ({"Assets/A/A.asmdef": "\ufeff" + asmdef("NetMQExample")}, "1", "^Assets/A/A.asmdef is an assembly with"),
        # An old example has this folder: its scripts would become a part of the kit's assembly.
        ({f"{TARGET}/Scripts/Mine.cs": "// old"}, "1", r"Scripts/Mine\.cs is in the folder .* rename Assets"),
        (
            {VERSION: "m_EditorVersion: 2021.1.0f1\n"},
            None,
            "NetMQ needs 2021.2 or later.* nothing was copied; open a copy .* in Unity Hub$",
        ),
        (UNITY_2021, None, "package needs 2022.3 or later: nothing was copied; --lesson takes 1, 2,.* 20 or 21 .*Hub"),
        (UNITY_2021, "9", "lesson 9 steps physics, which needs 2022.3 or later: nothing was copied; --lesson takes"),
    ],
)
def test_what_stands_in_the_way_is_named_and_nothing_is_copied(there, lesson, why, project, nuget):
    put(project, there)
    with refused(project, why):
        unity_install.install(project, lesson)


@pytest.mark.parametrize(
    ("where", "why"),
    [
        ("nowhere", "is no Unity project: .*no such folder"),
        (".", "is no Unity project: .*ProjectVersion.txt"),
        # `"C:\\My Game\\" --lesson 4` arrives on Windows as one word.
        ('My Game" --lesson 4', "leave out the backslash before the quotation mark"),
    ],
)
def test_says_why_it_is_no_project(where, why, tmp_path):
    with refused(tmp_path, why):
        unity_install.install(tmp_path / where)


def test_one_lesson_takes_only_what_it_uses():
    """Each type of the kit that a copied file uses has come along, also where its file has another name."""
    scripts = [*PACKAGE.glob("[0-9]*/*.cs"), *PACKAGE.glob("Shared/*.cs")]
    code = {path.name: script_code(path) for path in scripts}
    # A member named like a class is another thing, also where it is given by its name.
    members = r"\b(?!(?:new|return|public|internal|private)\b)(\w+) (?!\1\b)(\w+)(?: { get|\(|;)"
    words = {
        name: {*re.findall(r"(?<![\w.])\w+\b(?!:)|\.\w+(?=\()", text)}
        - {member for _, member in re.findall(members, text)}
        for name, text in code.items()
    }
    # An extension method is called as if it were another class's.
    declared = (
        r"^    (?:public|internal) .*?\b(?:class|struct|interface|enum) (\w+)|^ {8}public static .*? (\w+)\(this "
    )
    for lesson in (lesson for lesson in lessons() if lesson.unity.is_dir()):
        key = lesson.key
        names = [*copied_scripts(key[:2])]
        copied = {Path(name).name for name in names if name.endswith(".cs")}
        assert copied >= {path.name for path in (PACKAGE / key).glob("*.cs")}
        # Lesson 16 runs in a browser as well: it knows nothing of NetMQ, and has its JavaScript and its own assembly.
        web = key.startswith("16")
        assert ("NetMQLifetime.cs" in copied) != web
        for kind in (".jslib", "NetMQExample.Web.asmdef"):
            assert any(name.endswith(kind) for name in names) == web
        # A game's own assemblies refer to it; of one without scripts Unity would warn.
        assert (f"{TARGET}/NetMQExample.asmdef" in names) != web
        assert not any(name.endswith(".unity") for name in names)
        here = [path for path in scripts if path.parent.name <= key or path.parent.name == "Shared"]
        homes = {
            name or f".{method}": path.name
            for path in here
            for name, method in re.findall(declared, code[path.name], re.MULTILINE)
        }
        for name in copied:
            assert {homes[word] for word in homes.keys() & words[name]} <= copied, f"{key}: {name}"


def test_a_lean_project_gets_what_the_scripts_need_of_unity(project, nuget, capsys):
    manifest = project / "Packages" / "manifest.json"
    own = json.loads((ROOT / "unity" / "Packages" / "manifest.json").read_text(encoding="utf-8"))["dependencies"]

    def added():
        dependencies = json.loads(manifest.read_text(encoding="utf-8"))["dependencies"]
        assert dependencies.pop("com.unity.ugui") == "1.0.0"
        assert dependencies.items() <= own.items()
        return dependencies.keys() | set()

    unity_install.install(project, "2")
    assert added() == {"com.unity.modules.jsonserialize"}, "ServerAddress reads a field"
    unity_install.install(project, "4")
    modules = {"com.unity.modules.imgui", "com.unity.modules.jsonserialize"}
    assert added() == modules | {"com.unity.nuget.newtonsoft-json"}, "HelloWorldHud draws, BackgroundClientJson reads"
    assert "added com.unity.modules.imgui 1.0.0 to Packages/manifest.json" in capsys.readouterr().out
    unity_install.install(project)
    package = json.loads((PACKAGE / "package.json").read_text(encoding="utf-8"))
    assert added() == package["dependencies"].keys()
    after = manifest.read_bytes()
    unity_install.install(project)
    assert manifest.read_bytes() == after
    assert [path.name for path in manifest.parent.iterdir()] == ["manifest.json"]


def test_a_project_that_unity_may_refuse_is_advised(project, nuget, capsys):
    """PATH may be a folder inside of a project, and an older Unity takes most lessons."""
    # An early kit brought this assembly, and no record says so.
    old = f"{TARGET}/ServiceModel/System.ServiceModel.Primitives.asmdef"
    put(project, {**UNITY_2021, old: "{}"})
    unity_install.install(project / "Assets", "4")
    assert (project / TARGET / "04_background_client" / "BackgroundClient.cs").exists()
    said = capsys.readouterr().out
    assert f"delete {old}: Unity refuses this name" in said and "this Unity is older than 2022.3" in said


def test_netmq_of_the_projects_own_is_used(project, nuget, capsys):
    put(project, {"Assets/Plugins/NetMQ.dll": a_dll("4.0.1.12")})
    unity_install.install(project, "1")
    assert not (project / TARGET / "Plugins").exists()
    printed = capsys.readouterr().out
    assert "NetMQ is in this project already" in printed and "delete" not in printed
    # A script may lie there that somebody has put there later.
    (project / TARGET / "Mine.cs").write_text("// mine\n")
    unity_install.install(project, "2")


@pytest.mark.parametrize("text", ["{", "[]"])
def test_a_damaged_lock_or_record_is_none(text, project, nuget):
    (project / "Packages" / "packages-lock.json").write_text(text)
    (project / TARGET).mkdir()
    (project / TARGET / ".kit.json").write_text(text)
    unity_install.install(project, "4")
    assert (project / TARGET / "Plugins" / "NetMQ.dll").exists()


ALL_DLLS = {Path(inside).name for _, _, inside in LIBRARIES}
SHARED_DLLS = [Path(inside).name for _, _, inside in LIBRARIES if "/System." in inside]
# A .meta as Unity wrote it before Unity 6, and since. The first of each is what a DLL has that somebody dropped in.
ENTRY = "  - first:\n      {}\n    second:\n      enabled: {}\n      settings:\n        {}\n"
DEFAULT = ENTRY.format("Any: ", 1, "{}") + ENTRY.format("Editor: Editor", 0, "DefaultValueInitialized: true")
FOR_BUILDS = ENTRY.format("'': Any", 0, "Exclude Editor: 1") + DEFAULT
FOR_EDITOR = DEFAULT.replace("enabled: 1", "enabled: 2").replace("enabled: 0", "enabled: 1").replace(": 2", ": 0")
FOR_ONE = FOR_EDITOR + ENTRY.format("Standalone: Win64", 1, "CPU: AnyCPU")
ENTRY_6 = "    {}:\n      enabled: {}\n      settings: {{}}\n"
DEFAULT_6 = ENTRY_6.format("Any", 1) + ENTRY_6.format("Editor", 0)
FOR_EDITOR_6 = ENTRY_6.format("Any", 0) + ENTRY_6.format("Editor", 1)
CONSTRAINT = "  defineConstraints:\n  - '!UNITY_2021_2_OR_NEWER'\n"


def test_a_dll_of_nets_own_that_another_package_brings_is_deleted(project, nuget):
    """A run in which nobody else brought it has copied it."""
    unity_install.install(project, "4")
    assert plugins(project) == ALL_DLLS
    name, other = SHARED_DLLS[:2]
    listed = f'<package id="{other.removesuffix(".dll")}"/>'
    put(project, {f"Assets/Other/{name}": b"MZ", "Assets/packages.config": listed})
    unity_install.install(project, "4")
    assert plugins(project) == ALL_DLLS - {name, other}
    assert not (project / TARGET / "Plugins" / f"{name}.meta").exists()


def test_a_dll_that_unity_ignores_is_none(project, nuget):
    """A folder that ends with ~ or begins with a dot; and in a package, where Unity writes none, one without .meta."""
    for where in ("Library/PackageCache/a@1/Server~", "Library/PackageCache/a@1", "Assets/.tools"):
        (project / where).mkdir(parents=True, exist_ok=True)
        for name in ("NetMQ.dll", "System.Collections.Immutable.dll"):
            (project / where / name).write_bytes(b"MZ other")
    # Visual Studio's NuGet puts packages where Unity reads none; nor is a folder a DLL.
    put(project, {"Packages/NetMQ.4.0.1.13/lib/net45/NetMQ.dll": a_dll("4.0.1.13")})
    (project / "Assets" / "AsyncIO.dll").mkdir()
    unity_install.install(project, "4")
    assert plugins(project) == ALL_DLLS


def test_the_dlls_go_where_netmq_comes_from_elsewhere(project, nuget, capsys):
    unity_install.install(project, "4")
    unity_install.install(project, "4", False, scripts_only=True)
    (project / "Packages" / "manifest.json").write_text('{"dependencies": {"org.nuget.netmq": "4.0.4-5"}}')
    unity_install.install(project, "4", False, scripts_only=True)
    assert plugins(project) == ALL_DLLS, "the user said that they bring them"
    assert "first bring the DLLs" not in capsys.readouterr().out
    unity_install.install(project, "4")
    assert not (project / TARGET / "Plugins").exists()


@pytest.mark.parametrize(
    ("theirs", "ours"),
    [
        (DEFAULT, None),
        (FOR_ONE, None),
        (FOR_BUILDS, (0, 1)),
        (FOR_EDITOR_6, (1, 0)),
        ("  isOverridable: 1\n" + DEFAULT, (1, 1)),
        (CONSTRAINT + DEFAULT, (1, 1)),
        (CONSTRAINT.replace("!", "") + DEFAULT, None),
    ],
)
def test_the_kit_adds_what_another_copy_does_not_serve(theirs, ours, project, nuget):
    """With two for one platform nothing compiles, so an earlier run's settings are put right, too."""
    unity_install.install(project, "4")
    cache = "Library/PackageCache/com.unity.some@1.0.0/Tests"
    put(project, {f"{cache}/{SHARED_DLLS[0]}": b"MZ", f"{cache}/{SHARED_DLLS[0]}.meta": f"PluginImporter:\n{theirs}"})
    unity_install.install(project, "4")
    meta = project / TARGET / "Plugins" / f"{SHARED_DLLS[0]}.meta"
    if ours is None:
        assert not meta.exists() and plugins(project) == ALL_DLLS - {SHARED_DLLS[0]}
        return
    enabled = dict(re.findall(r"(Any|Editor):.*\n    second:\n      enabled: (\d)", meta.read_text()))
    assert enabled == {"Any": str(ours[0]), "Editor": str(ours[1])}
    assert f"Exclude Editor: {1 - ours[1]}" in meta.read_text()


LOCK = "Packages/packages-lock.json"
OLD_LIST = '<packages><package version="4.0.0.1" id="NetMQ" /></packages>'
OLD_DLL = "Assets/Packages/NetMQ.4.0.0.1/lib/netstandard2.1/NetMQ.dll"


@pytest.mark.parametrize(
    ("theirs", "why"),
    [
        (
            {"Assets/Plugins/NetMQ.dll": a_dll("3.3.3.4")},
            "delete Assets/Plugins/NetMQ.dll with its AsyncIO.dll and NaCl",
        ),
        ({"Assets/Plugins/NetMQ.dll": a_dll("4.0.1.11")}, ""),
        ({"Assets/Plugins/NetMQ.dll": b"MZ unknown"}, ""),
        ({"Assets/Plugins/NetMQ.dll": b"version https://git-lfs.github.com/spec/v1"}, "run git lfs pull"),
        (
            {"Assets/packages.config": OLD_LIST, OLD_DLL: a_dll("4.0.0.1")},
            "in NuGetForUnity's window or in Assets/pack",
        ),
        # The list is newer than what was fetched: Unity has not been opened since.
        ({"Assets/packages.config": OLD_LIST.replace("0.0.1", "0.1.13"), OLD_DLL: a_dll("4.0.0.1")}, ""),
        ({"Library/PackageCache/org.nuget.netmq@4.0.2-1234/package.json": "{}"}, ""),
        ({"Packages/nuget-packages/packages.config": OLD_LIST}, "window or in Packages/nuget-packages/packages.config"),
        ({LOCK: '{"dependencies": {"org.nuget.netmq": {"version": "4.0.0-1"}}}'}, "manifest.json"),
        ({LOCK: '{"dependencies": {"org.nuget.netmq": {"version": "4.0.4-5"}}}'}, ""),
        ({"Packages/a/package.json": '{"name": "com.a"}', "Packages/a/NetMQ.dll": a_dll("4.0.0.1")}, "; update com.a"),
    ],
)
def test_a_netmq_that_is_too_old_is_named_with_the_cure_of_its_way(theirs, why, project, nuget, capsys):
    put(project, theirs)
    if why:
        with refused(project, f"^(?=.*nothing was copied).*{re.escape(why)}"):
            unity_install.install(project, "4")
        return
    unity_install.install(project, "4")
    assert not plugins(project)
    assert not re.search("delete|change|update|older", capsys.readouterr().out)


@pytest.mark.parametrize("where", ["../shared/com.a", "Packages/com.a", "Library/PackageCache/com.a@1.0", "Assets/a"])
def test_a_dll_is_found_wherever_unity_finds_it(where, project, nuget):
    manifest = {"dependencies": {"com.a": "file:../../shared/com.a"} if where.startswith("..") else {}}
    put(project, {MANIFEST: json.dumps(manifest), f"{where}/package.json": '{"name": "com.a"}'})
    for name in ("NetMQ.dll", "Newtonsoft.Json.dll"):
        put(project, {f"{where}/Lib/{name}": a_dll("4.0.1.13"), f"{where}/Lib/{name}.meta": DEFAULT_6})
    unity_install.install(project, "4")
    assert not plugins(project)
    assert "com.unity.nuget.newtonsoft-json" not in (project / "Packages" / "manifest.json").read_text()


@pytest.mark.parametrize(
    ("begin", "newline", "indent", "end"),
    [("", "\r\n", "\t", "\r\n"), ("\ufeff", "\n", "    ", ""), ("", "\n", "  ", "\n")],
)
def test_a_manifest_changes_by_its_new_lines_alone(begin, newline, indent, end, project, nuget):
    lines = ["{", f'{indent}"scopedRegistries": [],', f'{indent}"dependencies": {{', f'{indent * 2}"é": "1.0.0"']
    before = begin + newline.join([*lines, f"{indent}}}", "}"]) + end
    manifest = project / "Packages" / "manifest.json"
    manifest.write_bytes(before.encode())
    unity_install.install(project, "2")
    added = f'"1.0.0",{newline}{indent * 2}"com.unity.modules.jsonserialize": "1.0.0"'
    assert manifest.read_bytes().decode() == before.replace('"1.0.0"', added)


def test_what_an_older_kit_wrote_and_this_one_has_not_is_deleted(project, nuget, capsys):
    """Two scripts with one class do not compile, nor does an assembly definition with a name of Unity's own."""
    unity_install.install(project, "4")
    record = project / TARGET / ".kit.json"
    known = json.loads(record.read_text())
    outside = [f"{TARGET}/../Mine.cs", "Assets/Mine.cs"]
    stub, renamed = ["Stub/Old.cs", "Stub/Old.cs.meta", "Stub.meta"], ["Shared/Renamed.cs", "Shared/Renamed.cs.meta"]
    for name in [*stub, *renamed, "../Mine.cs"]:
        put(project / TARGET, {name: name})
        known[f"{TARGET}/{name}"] = files.digest(name.encode())
    known |= dict.fromkeys(outside, known[outside[0]])
    record.write_text(json.dumps(known))
    (project / TARGET / "Shared" / "Renamed.cs").write_text("// mine")
    unity_install.install(project, "4")
    assert not list((project / TARGET).glob("Stub*"))
    printed = capsys.readouterr().out
    assert f"deleted {TARGET}/Stub/Old.cs: it is no longer a part of the kit" in printed
    assert (project / "Assets" / "Mine.cs").exists(), "a record may say anything"
    assert f"{TARGET}/Shared/Renamed.cs is no longer a part of the kit, and stays" in printed
    assert (project / TARGET / "Shared" / "Renamed.cs.meta").exists()
    before = listing(project)
    unity_install.install(project, "4")
    assert listing(project) == before
    assert "wrote" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("system", "python", "line"),
    [
        ("posix", "/kit/python", "/kit/python /kit/server.py"),
        ("posix", "/my kit/python", "'/my kit/python' /kit/server.py"),
        ("nt", "/kit/python", "/kit/python /kit/server.py"),
        ("nt", "/R&D,1/python", '& "/R&D,1/python" /kit/server.py   (in a command prompt without the &)'),
        ("nt", "/O'B $1/python", "& '/O''B $1/python' '/kit/server.py'   (in PowerShell)"),
    ],
)
def test_the_last_line_fits_the_shell(system, python, line, monkeypatch):
    monkeypatch.setattr(os, "name", system)
    said = terminal.command(python, "/kit/server.py")
    monkeypatch.undo()
    assert said == line


def test_a_script_that_was_moved_would_be_there_twice(project, nuget):
    """A file of the same name is none of ours."""
    put(project, {"Assets/Message.cs.meta": "guid: 00000000000000000000000000000001\n"})
    unity_install.install(project, "5")
    unity_install.install(project, "4")
    (project / TARGET / "04_background_client").rename(project / "Assets" / "Scripts")
    with refused(project, r"^Assets/Scripts/BackgroundClient\.cs is .*, moved: nothing was copied"):
        unity_install.install(project, "4")


@pytest.mark.parametrize("embedded", [False, True])
def test_two_copies_of_the_scripts_do_not_compile(embedded, project, nuget):
    name = json.loads((PACKAGE / "package.json").read_text())["name"]
    if embedded:
        shutil.copytree(PACKAGE, project / "Packages" / "lessons", ignore=shutil.ignore_patterns("Plugins*"))
    else:
        put(project, {MANIFEST: json.dumps({"dependencies": {name: "https://example.org/x.git"}})})
    unity_install.install(project)
    assert not list((project / TARGET).rglob("*.cs"))
    # Unity reads no link.xml in a package, and the GUID of its .meta is taken.
    assert (project / TARGET / "link.xml").read_bytes() == (PACKAGE / "link.xml").read_bytes()
    assert not (project / TARGET / "link.xml.meta").exists()
    assert (project / TARGET / "Plugins" / "NetMQ.dll").exists()


@pytest.mark.parametrize(
    ("sdk", "why"), [("8.0", "nothing was copied; --scripts-only copies"), (None, "nothing was copied$")]
)
def test_without_nuget_nothing_is_copied(sdk, why, project, tmp_path, monkeypatch):
    monkeypatch.setenv("NUGET_PACKAGES", str(tmp_path / "empty"))
    monkeypatch.setattr(dotnet, "sdk", lambda: sdk)
    monkeypatch.setattr(dotnet, "restore", lambda netmq: Result(1, "error NU1301: no such host"))
    # A port where nobody listens.
    monkeypatch.setattr(libraries, "NUGET", "http://127.0.0.1:9")
    with refused(project, why):
        unity_install.install(project)


def test_downloads_without_an_sdk(project, nuget, tmp_path, monkeypatch):
    fill(tmp_path / "feed", "MZ downloaded")
    monkeypatch.setenv("NUGET_PACKAGES", str(tmp_path / "empty"))
    monkeypatch.setattr(dotnet, "sdk", lambda: None)
    monkeypatch.setattr(libraries, "NUGET", (tmp_path / "feed").as_uri())
    unity_install.install(project, "1")
    assert (project / TARGET / "Plugins" / "AsyncIO.dll").read_bytes() == b"MZ downloaded AsyncIO"


def test_the_dlls_can_come_from_a_folder(project, tmp_path):
    for name in ALL_DLLS:
        put(tmp_path, {name: b"theirs"})
    (tmp_path / "AsyncIO.dll").rename(tmp_path / "Other.dll")
    with refused(project, f"^there is no AsyncIO.dll in {re.escape(str(tmp_path))}: nothing was copied$"):
        unity_install.install(project, dlls=tmp_path)
    (tmp_path / "Other.dll").rename(tmp_path / "AsyncIO.dll")
    unity_install.install(project, dlls=tmp_path)
    assert {path.read_bytes() for path in (project / TARGET).rglob("*.dll")} == {b"theirs"}
    assert plugins(project) == ALL_DLLS


def test_the_real_dlls(project, netmq):
    unity_install.install(project, "1")
    for _, _, inside in LIBRARIES:
        assert (project / TARGET / "Plugins" / Path(inside).name).read_bytes()[:2] == b"MZ"
