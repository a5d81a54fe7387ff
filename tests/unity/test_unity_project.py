"""The Unity project, read as Unity reads it: .meta files, GUIDs, scenes, assembly definitions, packages."""

from __future__ import annotations

import json
import math
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import pytest

from kitlib.docs import guide
from kitlib.unity import install as unity_install
from kitlib.unity.meta import PACKAGE, assets, behaviours, guid, meta_of, own_guid
from tests.programs import ROOT, finished

UNITY = ROOT / "unity"
SCENES = sorted(PACKAGE.rglob("*.unity"))
# The assemblies of Unity's test framework, and of a package that may be there.
UNITYS_OWN = {"UnityEngine.TestRunner", "UnityEditor.TestRunner", "Unity.InputSystem"}


def relative(path: Path) -> str:
    return path.relative_to(UNITY).as_posix()


def documents(text: str) -> list[tuple[int, int, str]]:
    """The objects of a Unity file: (class number, file id, text)."""
    parts = re.split(r"^--- !u!(\d+) &(\d+)\n", text, flags=re.MULTILINE)
    return [
        (int(kind), int(name), body) for kind, name, body in zip(parts[1::3], parts[2::3], parts[3::3], strict=True)
    ]


@pytest.mark.parametrize("path", assets(), ids=relative)
def test_has_a_meta(path: Path) -> None:
    assert meta_of(path).exists(), "run python3 -m kitlib.unity.meta"
    text = meta_of(path).read_text(encoding="utf-8")
    assert re.match(r"fileFormatVersion: 2\nguid: [0-9a-f]{32}\n", text)
    assert ("folderAsset: yes" in text) == path.is_dir()


def test_no_meta_is_left_of_what_is_gone() -> None:
    orphans = [relative(m) for m in UNITY.rglob("*.meta") if not m.with_suffix("").exists()]
    assert orphans == [], "an asset was renamed or removed: remove its .meta, or rename it along"


def test_guids_are_unique() -> None:
    seen: dict[str, str] = {}
    for path in assets():
        assert own_guid(path) not in seen, f"{relative(path)} has the guid of {seen[own_guid(path)]}"
        seen[own_guid(path)] = relative(path)


def test_guids_are_made_from_the_path() -> None:
    assert guid("01_request_reply/HelloClient.cs") == own_guid(PACKAGE / "01_request_reply" / "HelloClient.cs")


def test_the_command_has_nothing_left_to_write() -> None:
    done = finished([sys.executable, "-m", "kitlib.unity.meta"], cwd=ROOT, check=True)
    assert done.stdout == "", "it has written these just now: add them to git"


@pytest.mark.parametrize(
    "lesson", sorted(p for p in PACKAGE.glob("[0-9][0-9]_*") if behaviours(p)), ids=lambda p: p.name
)
def test_each_lesson_has_a_scene_with_its_scripts(lesson: Path) -> None:
    text = (lesson / f"{lesson.name}.unity").read_text(encoding="utf-8")
    by_guid = {own_guid(path): path for path in PACKAGE.rglob("*.cs")}
    found = re.findall(r"m_Script: \{fileID: 11500000, guid: ([0-9a-f]{32}), type: 3\}", text)
    assert all(one in by_guid for one in found), "the scene names a script that is not there"
    # The player (csharp-console/Play.cs) plays the scripts of the folder: the scene must hold them, and what shows it:
    # the last line, in lessons 03 and 07 a cube that moves, and in 21 one that talks.
    shown = ["LastLine.cs", *(["Cube.cs"] if lesson.name.startswith(("03", "07", "21")) else [])]
    assert {by_guid[one] for one in found} == {*behaviours(lesson), *(PACKAGE / "Shared" / name for name in shown)}


@pytest.mark.parametrize("path", SCENES, ids=relative)
def test_something_can_be_seen_in_a_scene(path: Path) -> None:
    kinds = [kind for kind, _, _ in documents(path.read_text(encoding="utf-8"))]
    # A light, and a text with its renderer. A shape would name a material, which is of one render pipeline only.
    assert (kinds.count(108), kinds.count(102), kinds.count(23), kinds.count(33)) == (1, 1, 1, 0)


@pytest.mark.parametrize(("key", "begin", "end"), [("10_many_agents", -4, 4), ("11_observations", 0, 10)])
def test_a_field_is_seen_from_above_and_below_the_text(key: str, begin: float, end: float) -> None:
    """From its own height one thing on it would cover the other."""
    text = (PACKAGE / key / f"{key}.unity").read_text(encoding="utf-8")
    (camera,) = [body for _, name, body in documents(text) if name == 101]
    turn, place = (
        [float(number) for number in re.findall(r"[xyzw]: (-?[\d.]+)", re.search(f"m_Local{what}: (.*)", camera)[1])]
        for what in ("Rotation", "Position")
    )
    assert turn[1:3] == [0, 0], "it looks straight ahead, and down"
    down = 2 * math.atan2(turn[0], turn[3])
    assert math.degrees(down) >= 30
    for x in (begin, end):
        for z in (begin, end):
            right, up, ahead = x - place[0], -place[1], z - place[2]
            depth = ahead * math.cos(down) - up * math.sin(down)
            high = up * math.cos(down) + ahead * math.sin(down)
            # 60 degrees from top to bottom, in a window of 4 to 3; the text stands 3 m high in 10 m.
            assert -math.tan(math.radians(30)) < high / depth < 0.25
            assert abs(right) / depth < math.tan(math.radians(30)) * 4 / 3


@pytest.mark.parametrize("path", SCENES, ids=relative)
def test_a_scene_refers_to_objects_that_exist(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.startswith("%YAML 1.1\n%TAG !u! tag:unity3d.com,2011:\n--- !u!")
    objects = documents(text)
    names = [name for _, name, _ in objects]
    assert len(names) == len(set(names))
    for _, _, body in objects:
        for target in re.findall(r"\{fileID: (\d+)\}", body):
            assert int(target) in {0, *names}, f"{target} is referred to and does not exist"
    # Each component says which object it is on, and that object lists it.
    owners = {name: re.findall(r"component: \{fileID: (\d+)\}", body) for kind, name, body in objects if kind == 1}
    for _, name, body in objects:
        if owner := re.search(r"m_GameObject: \{fileID: (\d+)\}", body):
            assert str(name) in owners[int(owner[1])]
    assert [kind for kind, _, _ in objects].count(20) == 1, "one camera"


def test_yaml_parses_with_unitys_tags() -> None:
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")

    class Loader(yaml.SafeLoader):  # type: ignore[name-defined,misc]
        pass

    def construct(loader: Any, _suffix: str, node: Any) -> object:
        return loader.construct_mapping(node, deep=True)

    Loader.add_multi_constructor("tag:unity3d.com,2011:", construct)
    for path in [*SCENES, *UNITY.glob("ProjectSettings/*.asset"), *PACKAGE.rglob("*.meta")]:
        text = path.read_text(encoding="utf-8")
        # Unity declares the tag once for all documents of a file; YAML wants it before each, so it is written out here.
        text = re.sub(r"^%.*\n", "", text, flags=re.MULTILINE)
        text = re.sub(r"^--- !u!(\d+) ", r"--- !<tag:unity3d.com,2011:\1> ", text, flags=re.MULTILINE)
        found = list(yaml.load_all(text, Loader))
        assert found and all(isinstance(one, dict) for one in found), relative(path)


def definitions() -> dict[Path, dict[str, Any]]:
    return {path: json.loads(path.read_text(encoding="utf-8")) for path in PACKAGE.rglob("*.asmdef")}


def test_assembly_definitions_refer_to_what_exists() -> None:
    names = [definition["name"] for definition in definitions().values()]
    assert len(names) == len(set(names))
    for path, definition in definitions().items():
        assert path.stem == definition["name"]
        assert set(definition["references"]) <= {*names, *UNITYS_OWN}
        assert not (definition["includePlatforms"] and definition["excludePlatforms"]), "Unity takes one of the two"
        # Without overrideReferences Unity passes over this list.
        assert definition["overrideReferences"] or not definition["precompiledReferences"]


def test_what_netmq_names_is_there_and_no_more() -> None:
    """IL2CPP's linker wants every name in NetMQ.dll, and in what that names, to be found."""
    disassembler = shutil.which("ikdasm") or shutil.which("monodis")
    dlls = [
        unity_install.nuget_folder() / name.lower() / number / inside
        for name, number, inside in unity_install.LIBRARIES
    ]
    if not disassembler or not all(dll.exists() for dll in dlls):
        pytest.skip("it needs ikdasm or monodis (of Mono), and NetMQ from NuGet")
    texts = [finished([disassembler, dll]).stdout for dll in dlls]
    needed = {name for text in texts for name in re.findall(r"^\.assembly extern (\S+)", text, re.MULTILINE)}
    # What Unity's .NET Standard 2.1 forwards.
    assert needed - {"netstandard", "System.Buffers", "System.Memory"} == {dll.stem for dll in dlls} - {"NetMQ"}


def test_the_lessons_are_left_out_of_webgl_which_has_its_own_error() -> None:
    by_name = {definition["name"]: definition for definition in definitions().values()}
    assert by_name["NetMQExample"]["excludePlatforms"] == ["WebGL"]
    assert by_name["NetMQExample"]["includePlatforms"] == []
    assert by_name["NetMQExample.WebGL"]["includePlatforms"] == ["WebGL"]
    code = (PACKAGE / "WebGL" / "NotInABrowser.cs").read_text(encoding="utf-8")
    assert "#if UNITY_WEBGL && !UNITY_EDITOR" in code
    assert "using NetMQ" not in code, "NetMQ is not there in a browser"


def test_the_package_is_valid() -> None:
    package = json.loads((PACKAGE / "package.json").read_text(encoding="utf-8"))
    assert re.fullmatch(r"[a-z0-9][a-z0-9._-]{0,213}", package["name"])
    assert re.fullmatch(r"\d+\.\d+\.\d+", package["version"])
    assert re.fullmatch(r"20\d\d\.\d|6000\.\d", package["unity"])
    assert package["displayName"] and package["description"] and package["license"]
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert f'version = "{package["version"]}"' in project, "one version for the whole kit"
    # What the package needs of Unity, the project has.
    manifest = json.loads((UNITY / "Packages" / "manifest.json").read_text(encoding="utf-8"))
    assert package["dependencies"].items() <= manifest["dependencies"].items()
    # Who adds the package by its address gets these, and nothing else of the repository.
    assert (PACKAGE / "LICENSE.md").read_bytes() == (ROOT / "LICENSE").read_bytes()
    assert f"[{package['version']}]" in (PACKAGE / "CHANGELOG.md").read_text(encoding="utf-8")
    assert "NetMQ" in (PACKAGE / "README.md").read_text(encoding="utf-8")


def test_the_manifest_gets_netmq_from_a_scoped_registry() -> None:
    manifest = json.loads((UNITY / "Packages" / "manifest.json").read_text(encoding="utf-8"))
    outside = [name for name in manifest["dependencies"] if not name.startswith("com.unity.")]
    scopes = [scope for registry in manifest["scopedRegistries"] for scope in registry["scopes"]]
    assert outside == ["org.nuget.netmq"]
    assert all(any(name.startswith(f"{scope}.") for scope in scopes) for name in outside)
    lessons = (ROOT / "csharp-support" / "lessons" / "NetMQExample.csproj").read_text(encoding="utf-8")
    assert 'Include="Newtonsoft.Json" Version="13.' in lessons
    assert manifest["dependencies"][unity_install.JSON[0]] == unity_install.JSON[1]
    # UnityNuGet writes the fourth number of a version behind a hyphen.
    assert manifest["dependencies"]["org.nuget.netmq"].replace("-", ".") == unity_install.NETMQ


def test_unity_is_a_version_that_can_have_netmq() -> None:
    text = (UNITY / "ProjectSettings" / "ProjectVersion.txt").read_text(encoding="utf-8")
    found = re.match(
        r"m_EditorVersion: 6000\.0\.(\d+)f\d+\nm_EditorVersionWithRevision: 6000\.0\.\1f\d+ \([0-9a-f]{12}\)\n", text
    )
    # Earlier ones have CVE-2025-59489.
    assert found and int(found[1]) >= 58
    settings = (UNITY / "ProjectSettings" / "ProjectSettings.asset").read_text(encoding="utf-8")
    assert "\n  m_ActiveColorSpace: 1\n" in settings, "left out, it is gamma"


def test_an_editor_for_code_finds_the_project() -> None:
    """Without its package Unity writes no .csproj: no completion and no debugger."""
    manifest = json.loads((UNITY / "Packages" / "manifest.json").read_text(encoding="utf-8"))
    assert {"com.unity.ide.rider", "com.unity.ide.visualstudio"} <= manifest["dependencies"].keys()


def test_no_third_party_dll_is_in_the_repository() -> None:
    done = finished(["git", "ls-files", "unity"], cwd=ROOT)
    if done.returncode:
        pytest.skip("this is not a git repository")
    assert [name for name in done.stdout.splitlines() if name.lower().endswith((".dll", ".so", ".dylib"))] == []


def test_a_field_says_what_it_is_for_and_how_small_it_may_be() -> None:
    fields = []
    for path in PACKAGE.glob("[0-9S]*/*.cs"):
        found = re.findall(r"\[SerializeField([^]]*)\]\s+private (\S+) (\w+)", path.read_text(encoding="utf-8"))
        fields += [(path.stem, name, kind, attributes) for attributes, kind, name in found]
    assert len(fields) > 100
    assert [field for field in fields if "Tooltip(" not in field[3]] == []
    numbers = [field for field in fields if field[2] in ("int", "float")]
    assert [field for field in numbers if not re.search(r"(Min|Range)\(", field[3])] == []


def test_the_page_shows_what_the_kits_own_manifest_has() -> None:
    page = ROOT / "docs" / "guide" / "unity_project.md"
    (shown,) = [json.loads(block.body) for block in guide.blocks(page) if block.language == "json"]
    manifest = json.loads((ROOT / "unity" / "Packages" / "manifest.json").read_text(encoding="utf-8"))
    assert shown["scopedRegistries"] == manifest["scopedRegistries"]
    assert shown["dependencies"].items() <= manifest["dependencies"].items()


def test_the_linker_is_not_told_to_keep_all_of_netmq() -> None:
    """Kept whole it would drag in what only its BufferPool names, at every stripping level."""
    text = (PACKAGE / "link.xml").read_text(encoding="utf-8")
    assert re.findall(r'assembly fullname="(\w+)" preserve="all" ignoreIfMissing="1"', text) == ["NetMQExample"]


def test_each_component_has_its_place_in_the_menu() -> None:
    """Add Component, NetMQ Example, by lesson; without it all lie in one row below Scripts."""
    found: dict[str, tuple[str, Path, str]] = {}
    for path in PACKAGE.rglob("[0-9S]*/*.cs"):
        text = path.read_text(encoding="utf-8")
        for kind, name, base in re.findall(r"^    public (\w* ?)class (\w+)(?:<\w+>)? : (\w+)", text, re.MULTILINE):
            found[name] = (base, path, kind)
    bases = {name: base for name, (base, _, _) in found.items()}

    def is_component(name: str) -> bool:
        return name == "MonoBehaviour" or (name in bases and is_component(bases[name]))

    components = {name: path for name, (_, path, kind) in found.items() if kind != "abstract " and is_component(name)}
    assert len(components) > 30
    # A link to nowhere would be worse than Unity's own page on scripts: with the package's address they all get one.
    public = "documentationUrl" in json.loads((PACKAGE / "package.json").read_text(encoding="utf-8"))
    for name, path in components.items():
        text = path.read_text(encoding="utf-8")
        number = f"{path.parent.name[:2]} " if path.parent.name[:2].isdigit() else ""
        words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
        assert f'    [AddComponentMenu("NetMQ Example/{number}{words}")]\n' in text, relative(path)
        assert ("[HelpURL(" in text) == public, relative(path)


# What a primitive is made of, which fails if IL2CPP's linker has taken one away: GameObject.CreatePrimitive's page in
# Unity's reference. Of a cylinder the collider is a capsule.
COLLIDERS = {
    "Cube": "Box",
    "Sphere": "Sphere",
    "Capsule": "Capsule",
    "Cylinder": "Capsule",
    "Plane": "Mesh",
    "Quad": "Mesh",
}


def test_the_linker_keeps_what_primitives_are_made_of() -> None:
    # A script may name the kind in one place and create it in another.
    named = {
        kind for path in PACKAGE.rglob("*.cs") for kind in re.findall(r"PrimitiveType\.(\w+)", path.read_text("utf-8"))
    }
    assert {"Cube", "Sphere"} <= named
    kept = {
        (assembly, name)
        for assembly, types in re.findall(
            r'<assembly fullname="UnityEngine\.(\w+)".*?>(.*?)</assembly>',
            (PACKAGE / "link.xml").read_text("utf-8"),
            re.DOTALL,
        )
        for name in re.findall(r'<type fullname="UnityEngine\.(\w+)" preserve="all" />', types)
    }
    colliders = {("PhysicsModule", f"{COLLIDERS[kind]}Collider") for kind in named}
    assert kept == {("CoreModule", "MeshFilter"), ("CoreModule", "MeshRenderer"), *colliders}
