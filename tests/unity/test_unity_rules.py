"""The rules by which Unity's editor checks a project before it compiles, and when it imports.

Each was read in Unity's published source, and is held to a broken copy too. The files are those that kit.py unity
copies, {path in a project: text}.
"""

from __future__ import annotations

import functools
import json
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from kitlib.lessons import lessons
from kitlib.unity import modules
from kitlib.unity.install import scripts
from kitlib.unity.meta import PACKAGE, PREFAB, own_guid
from kitlib.unity.project import TARGET
from tests.programs import ROOT

Files = dict[str, str]
Json = dict[str, Any]
HERE = ROOT / "tests" / "unity"
RESERVED = set((HERE / "unity_reserved_names.txt").read_text(encoding="utf-8").lower().splitlines())
MANIFESTS = (ROOT / "unity" / "Packages" / "manifest.json", PACKAGE / "package.json")
# The parts of Unity that are packages, in 2022.3 and in each 6000.x. InputLegacy, TextRendering and Scripting are none:
# their types are always there, and Unity refuses a manifest that names such a package.
MODULES = (
    "ai|androidjni|animation|assetbundle|audio|cloth|director|imageconversion|imgui|jsonserialize|particlesystem|"
    "physics|physics2d|screencapture|terrain|terrainphysics|tilemap|ui|uielements|vehicles|video|wind|xr|"
    "unitywebrequest(assetbundle|audio|texture)?"
)


@functools.cache
def copied(lesson: str | None = None) -> Files:
    return {name: data.decode("utf-8") for name, data in scripts(lesson).items()}


def assembly(name: str, files: Files) -> str | None:
    """The .asmdef to which a script belongs: the nearest above it."""
    above = [path for path in files if path.endswith(".asmdef") and name.startswith(path.rpartition("/")[0] + "/")]
    return max(above, key=lambda path: path.count("/"), default=None)


PLATFORMS = {"Editor", "WebGL", "any other"}
SYMBOL = r"[^\W\d]\w{0,246}"
CONSTRAINT = re.compile(rf"[ \t]*!?{SYMBOL}[ \t]*(\|\|[ \t]*!?{SYMBOL}[ \t]*)*")
NUMBER = r"\d[\w.-]*"
RANGE = re.compile(rf"({NUMBER}|\[{NUMBER}\]|\({NUMBER},\)|\(,{NUMBER}[\])]|[\[(]{NUMBER},{NUMBER}[\])])?")


def outside_the_editor(files: Files) -> Files:
    """The scripts that a player may have."""
    cs = {name: text for name, text in files.items() if name.endswith(".cs")}
    return {n: t for n, t in cs.items() if runs_on(json.loads(files[assembly(n, files) or ""])) != {"Editor"}}


def runs_on(definition: Json) -> set[str]:
    return set(definition["includePlatforms"] or PLATFORMS) - set(definition["excludePlatforms"])


def reachable(name: str, by_name: dict[str, Json]) -> set[str]:
    seen: set[str] = set()
    left = [name]
    while left:
        new = by_name.keys() & set(by_name[left.pop()]["references"]) - seen
        seen |= new
        left += new
    return seen


def assembly_faults(files: Files) -> Iterator[str]:
    found: dict[str, Json] = {name: json.loads(text) for name, text in files.items() if name.endswith(".asmdef")}
    by_name = {definition["name"]: definition for definition in found.values()}
    owners = {assembly(name, files) for name in files if name.endswith(".cs")}
    folders = Counter(name.rpartition("/")[0] for name in found)
    yield from (f"{folder} has {count} assembly definitions" for folder, count in folders.items() if count > 1)
    for path, definition in found.items():
        name, references, constraints = (definition[key] for key in ("name", "references", "defineConstraints"))
        if name.lower() in RESERVED:
            yield f"{name}: Unity has reserved this name"
        if path not in owners:
            yield f"{name} has no scripts, of which Unity warns"
        if len(references) > len(set(references)):
            yield f"{name} has a reference twice"
        if name in reachable(name, by_name):
            yield f"{name} refers to itself in the end"
        yield from (f"{name}: {one} is no constraint" for one in constraints if not CONSTRAINT.fullmatch(one))
        for one in {*definition["includePlatforms"], *definition["excludePlatforms"]} - PLATFORMS:
            yield f"{name}: {one} is a platform that the package does not know"
        for other in by_name.keys() & set(references):
            if missing := runs_on(definition) - runs_on(by_name[other]):
                yield f"{name}: there is no {other} in {sorted(missing)}"
        for one in definition["versionDefines"]:
            if not RANGE.fullmatch(one["expression"]) or not re.fullmatch(SYMBOL, one["define"]):
                yield f"{name}: {one['expression']} is no version, or {one['define']} no symbol"
        # UNITY_INCLUDE_TESTS is defined in every editor, with the package of the Test Framework and without it.
        framework = [one["define"] for one in definition["versionDefines"] if one["name"] == "com.unity.test-framework"]
        if "UnityEngine.TestRunner" in references and not set(framework) & set(constraints):
            yield f"{name} does not compile where Unity's Test Framework is missing"


ROOTS = ("MonoBehaviour", "ScriptableObject", "EditorWindow", "UnityEditor.Editor")
CLASS = re.compile(r"^ {4}([\w ]*)class (\w+)(<\w+>)?(?: : ([\w.]+))?[^{;]*\n {4}\{\n(.*?)^ {4}\}", re.M | re.S)
MARKED = re.compile(r"\[SerializeField\b[^;=]*\]\s+((?:\w+ )*)([\w.<>\[\](),? ]+?) (\w+)(?: = |;)")
PUBLIC = re.compile(r"^ {8}public (?!static|const|readonly|event)[\w.<>\[\]]+ (\w+)(?: = |;)", re.M)
FIRST_VALUE = re.compile(r"^ {8}[^=\n/]*?(?:public|protected|private) (?!static|const)[^=(\n]* = ([^;]*);", re.M)
METHOD = re.compile(r"^ {8}((?:\w+ )+)(\w+)\((\w*)", re.M)
PLAIN = (
    r"bool|s?byte|char|u?short|u?int|u?long|float|double|string|Vector[234]|Vector[23]Int|Quaternion|Color|Color32|"
    "Rect|Bounds|LayerMask|AnimationCurve|Gradient|UnityEvent(<.*>)?"
)
ALONE = "Awake|Start|(Fixed|Late)?Update|On(Enable|Disable|Destroy|GUI|Validate|ApplicationQuit)|Reset"
# What Unity calls by an attribute is static, and has one of these lists of parameters.
CALLED = {
    "MenuItem": ("", "MenuCommand"),
    "InitializeOnLoadMethod": ("",),
    "RuntimeInitializeOnLoadMethod": ("",),
    "PostProcessBuild": ("BuildTarget string",),
}
ATTRIBUTE = re.compile(rf"\[({'|'.join(CALLED)})\b[^\n]*\n\s+((?:\w+ )*)(\w+)\(([^)]*)\)")
# Of each type of Unity that a script may use: its kind, its name, its base class, and where Unity declares it.
FACTS: list[tuple[str, str, str, str]] = re.findall(
    r"^(\w+) (?:\w+\.)*(\w+)(?:`\d)?(?: : (\w+))?    (.+)$",
    (HERE / "unity_api.txt").read_text(encoding="utf-8"),
    re.M,
)
BASES = {name: base for kind, name, base, _ in FACTS if kind == "class"}
# A constructor of a component may call none of these, and neither may what its fields begin with.
ENGINE = {name for name in BASES if not re.search("Attribute$|UnityEvent", name)} | {"FindObjectOfType", "Instantiate"}


def script_faults(files: Files) -> Iterator[str]:
    # Without texts and comments, in which anything may stand.
    code = {n: re.sub(r'"(?:[^"\\\n]|\\.)*"|//.*', '""', text) for n, text in files.items() if n.endswith(".cs")}
    classes = {found[1]: (name, *found) for name, text in code.items() for found in CLASS.findall(text)}
    own = re.findall(r"(?:\benum|\[Serializable\]\s+[\w ]*(?:class|struct)) (\w+)", "".join(code.values()))
    values = rf"{PLAIN}|(?:{'|'.join(own)})(<.*>)?"

    def line(name: str) -> list[str]:
        """A class and its bases; the last one is not the package's."""
        return [name, *line(classes[name][4])] if name in classes else [name]

    def is_object(name: str) -> bool:
        last = line(name)[-1]
        return last == "Object" or (last in BASES and is_object(BASES[last]))

    for name, text in code.items():
        without = re.sub(r"^#if UNITY_EDITOR$.*?^#(else|endif)$", "", text, flags=re.M | re.S)
        if "UnityEditor" in without and name in outside_the_editor(files):
            yield f"{name}: a player has no UnityEditor"
        for attribute, words, method, parameters in ATTRIBUTE.findall(text):
            types = " ".join(one.split()[0] for one in parameters.split(",") if one)
            if "static" not in words.split() or types not in CALLED[attribute]:
                yield f"{name}: {method} is no method for {attribute}"
    for name, (file, words, _, generic, _, body) in classes.items():
        chain = line(name)
        if chain[-1] not in ROOTS:
            continue
        if "abstract" not in words and (Path(file).stem != name or generic):
            yield f"{name}: Unity wants the class named like its file, and without <>"
        if re.search(rf"^ {{8}}\w+ {name}\(", body, re.M):
            yield f"{name}: Unity makes it, and wants no constructor"
        bodies = [classes[one][5] for one in chain[:-1]]
        fields = Counter(f for one in bodies for f in (*(m[2] for m in MARKED.findall(one)), *PUBLIC.findall(one)))
        yield from (f"{name}: {field} is serialized twice" for field, count in fields.items() if count > 1)
        for words, kind, field in MARKED.findall(body):
            inner = re.sub(r"\[\]$|^List<(.*)>$", r"\1", kind)
            if {"static", "readonly"} & set(words.split()) or not (re.fullmatch(values, inner) or is_object(inner)):
                yield f"{name}: Unity does not serialize {words}{kind} {field}"
        for value in FIRST_VALUE.findall(body):
            engine = ENGINE & set(re.findall(r"\w+", re.sub(r"<[^>]*>", "", value)))
            yield from (f"{name}: no field may begin with {one}" for one in engine)
        hidden = {method for one in bodies[1:] for words, method, _ in METHOD.findall(one) if "private" in words}
        for _, method, parameter in METHOD.findall(body):
            told = re.fullmatch(f"(OnApplication(?:Pause|Focus))|{ALONE}", method)
            if told and chain[-1] == "MonoBehaviour" and parameter != ("bool" if told[1] else ""):
                yield f"{name}: {method} is a message of Unity's with other parameters"
            if told and method in hidden:
                yield f"{name}: then Unity does not call {method} of its base class"


PACKAGE_NAME = re.compile(r"[a-z\d][a-z\d._-]{0,213}")
PART = r"(0|[1-9]\d*|\d*[A-Za-z-][\dA-Za-z-]*)"
VERSION = re.compile(rf"(0|[1-9]\d*)(\.(0|[1-9]\d*)){{2}}(-{PART}(\.{PART})*)?(\+[\dA-Za-z.-]+)?")


def manifest_faults(manifest: Json) -> Iterator[str]:
    """Of a project's manifest.json, or a package's package.json."""
    for name, version in manifest["dependencies"].items():
        if not PACKAGE_NAME.fullmatch(name) or not VERSION.fullmatch(version):
            yield f"{name} {version} is no package"
        if name.startswith("com.unity.modules.") and not re.fullmatch(rf"[a-z.]+\.({MODULES})", name):
            yield f"{name} is not in every Unity"
    for one in manifest.get("scopedRegistries", []):
        if not (one.get("name") and one.get("scopes") and one.get("url", "").startswith("https://")):
            yield "a registry wants a name, an address and scopes"
    if not re.fullmatch(r"((0|[1-9]\d*)[abfp](0|[1-9]\d*))?", manifest.get("unityRelease", "")):
        yield "unityRelease is no release"
    for sample in manifest.get("samples", []):
        if not sample.keys() >= {"displayName", "description", "path"} or not (PACKAGE / sample["path"]).is_dir():
            yield f"{sample} is no sample"


# Unity goes by the number, and takes the name as said.
KINDS = {1: "GameObject", 4: "Transform", 20: "Camera", 23: "MeshRenderer", 33: "MeshFilter", 102: "TextMesh"}
KINDS |= {108: "Light", 114: "MonoBehaviour", 1660057539: "SceneRoots"}


def scene_faults(text: str) -> Iterator[str]:
    """Of a scene, or of a prefab."""
    parts = re.split(r"^--- !u!(\d+) &(\d+)\n", text, flags=re.M)[1:]
    kinds = {number: int(kind) for kind, number in zip(parts[::3], parts[1::3], strict=True)}
    bodies = dict(zip(parts[1::3], parts[2::3], strict=True))
    scripts_of = {own_guid(path): path for path in PACKAGE.rglob("*.cs")}

    def pairs(kind: int, key: str) -> set[tuple[str, str]]:
        """Each object of this kind, or of any, with each fileID that it has under this key."""
        listed = {number: re.search(rf"^  {key}:(.*(?:\n  - .*)*)", bodies[number], re.M) for number in kinds}
        return {
            (number, one)
            for number, found in listed.items()
            if found and kind in (0, kinds[number])
            for one in re.findall(r"fileID: (\d+)", found[1])
        }

    for number, body in bodies.items():
        if not body.startswith(f"{KINDS.get(kinds[number])}:"):
            yield f"{number} is no {KINDS.get(kinds[number])}"
    owned, fathers = pairs(1, "m_Component"), pairs(4, "m_Father")
    roots = {number for number, father in fathers if father == "0"}
    for one in owned ^ {(owner, part) for part, owner in pairs(0, "m_GameObject")}:
        yield f"{one} is not said on both sides"
    for one in pairs(4, "m_Children") ^ {(father, child) for child, father in fathers if child not in roots}:
        yield f"{one} is not said on both sides"
    if {one for _, one in pairs(1660057539, "m_Roots")} != roots if "SceneRoots:" in text else len(roots) != 1:
        yield f"the roots are {sorted(roots)}"
    for owner in (number for number, kind in kinds.items() if kind == 1):
        own = [part for number, part in owned if number == owner and part in kinds]
        if [kinds[part] for part in own].count(4) != 1:
            yield f"{owner} has not one Transform"
        guids = re.findall(r"m_Script: .*guid: (\w+)", "".join(bodies[part] for part in own))
        used = [scripts_of[one] for one in guids if one in scripts_of]
        for path in used:
            for wanted in re.findall(r"RequireComponent\(typeof\((\w+)\)", path.read_text(encoding="utf-8")):
                if wanted not in {other.stem for other in used} | {KINDS.get(kinds[part]) for part in own}:
                    yield f"{owner} has no {wanted} for {path.stem}"


@pytest.mark.parametrize("lesson", [None, *(lesson.key for lesson in lessons() if lesson.unity.is_dir())])
def test_unity_compiles_the_assemblies_that_are_copied(lesson: str | None) -> None:
    assert list(assembly_faults(copied(lesson))) == []


def test_unity_takes_the_scripts() -> None:
    assert list(script_faults(copied())) == []


@pytest.mark.parametrize("path", MANIFESTS, ids=lambda path: path.name)
def test_the_package_manager_takes_the_manifests(path: Path) -> None:
    assert list(manifest_faults(json.loads(path.read_text(encoding="utf-8")))) == []


@pytest.mark.parametrize("path", [*sorted(PACKAGE.rglob("*.unity")), PREFAB], ids=lambda path: path.stem)
def test_a_scene_is_one_tree_of_known_objects(path: Path) -> None:
    assert list(scene_faults(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize("path", MANIFESTS, ids=lambda path: path.name)
def test_the_modules_that_scripts_need_are_named(path: Path) -> None:
    # An assembly for the editor alone gets all of Unity's modules, whatever the project has.
    needed = modules.needed(outside_the_editor(copied()).values())
    assert needed - json.loads(path.read_text(encoding="utf-8"))["dependencies"].keys() == set()


def test_the_modules_are_those_of_unitys_sources() -> None:
    declared: dict[str, set[str]] = {}
    for _, name, _, source in FACTS:
        module = source.removeprefix("Modules/").partition("/")[0].lower()
        if source.startswith("Modules/") and re.fullmatch(MODULES, module):
            declared.setdefault(f"com.unity.modules.{module}", set()).add(name)
    declared["com.unity.modules.imageconversion"].add("EncodeToJPG")
    declared["com.unity.modules.physics"].add("CreatePrimitive")
    assert declared == modules.TYPES
    assert modules.needed(["// GUI\nvar colliders = GetComponent<Collider>();", "class GUIs { }"]) == {
        "com.unity.modules.physics"
    }


TEST = {"name": "com.unity.test-framework", "expression": "", "define": "A"}


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"name": "System.Buffers"}, "System.Buffers: Unity has reserved this name"),
        ({"name": "assembly-csharp"}, "assembly-csharp: Unity has reserved this name"),
        ({"references": ["NetMQExample", "NetMQExample"]}, "Broken has a reference twice"),
        ({"references": ["Broken"]}, "Broken refers to itself in the end"),
        ({"references": ["NetMQExample"], "excludePlatforms": []}, "Broken: there is no NetMQExample in ['WebGL']"),
        ({"references": ["NetMQExample.Editor"]}, "Broken: there is no NetMQExample.Editor in ['any other']"),
        ({"includePlatforms": ["Windows"]}, "Broken: Windows is a platform that the package does not know"),
        ({"defineConstraints": ["A && B"]}, "Broken: A && B is no constraint"),
        ({"defineConstraints": ["!A || 2D"]}, "Broken: !A || 2D is no constraint"),
        ({"versionDefines": [TEST | {"expression": "[1.0, 2.0)"}]}, "Broken: [1.0, 2.0) is no version, or A no symbol"),
        ({"versionDefines": [TEST | {"expression": ">=1.0"}]}, "Broken: >=1.0 is no version, or A no symbol"),
        ({"versionDefines": [TEST | {"define": "A-B"}]}, "Broken:  is no version, or A-B no symbol"),
        ({"references": ["UnityEngine.TestRunner"], "versionDefines": [TEST]}, "Broken does not compile where Unity's"),
    ],
)
def test_a_broken_assembly_is_refused(change: Json, fault: str) -> None:
    keys = ("references", "includePlatforms", "defineConstraints", "versionDefines")
    sound = {**{key: [] for key in keys}, "name": "Broken", "excludePlatforms": ["WebGL"]}
    files = copied() | {f"{TARGET}/Broken/Broken.cs": "", f"{TARGET}/Broken/Broken.asmdef": json.dumps(sound)}
    assert not [one for one in assembly_faults(files) if "Broken" in one]
    files[f"{TARGET}/Broken/Broken.asmdef"] = json.dumps(sound | change)
    assert any(one.startswith(fault) for one in assembly_faults(files)), list(assembly_faults(files))
    del files[f"{TARGET}/Broken/Broken.cs"]
    files[f"{TARGET}/Other.asmdef"] = files[f"{TARGET}/NetMQExample.asmdef"]
    assert {
        f"{(sound | change)['name']} has no scripts, of which Unity warns",
        f"{TARGET} has 2 assembly definitions",
    } <= {*assembly_faults(files)}


@pytest.mark.parametrize(
    ("member", "fault"),
    [
        ("[SerializeField] private Dictionary<string, int> map;", "Unity does not serialize private Dictionary<"),
        ("[SerializeField] private (int, int) pair;", "Unity does not serialize private (int, int) pair"),
        ("[SerializeField] private int? maybe;", "Unity does not serialize private int? maybe"),
        ("[SerializeField] private int[,] grid;", "Unity does not serialize private int[,] grid"),
        ("[SerializeField] private ICar car;", "Unity does not serialize private ICar car"),
        ("[SerializeField] private static int count;", "Unity does not serialize private static int count"),
        ("[SerializeField] private bool runInBackground;", "runInBackground is serialized twice"),
        ('private readonly Material ink = new Material("");', "no field may begin with Material"),
        ("public Broken() { }", "Unity makes it, and wants no constructor"),
        ("private void LateUpdate(float seconds) { }", "LateUpdate is a message of Unity's with other parameters"),
        ("private void OnApplicationFocus() { }", "OnApplicationFocus is a message of Unity's with other parameters"),
        ("private UnityEditor.MessageType kind;", "a player has no UnityEditor"),
        ("[InitializeOnLoadMethod]\n        private void Load() { }", "Load is no method for InitializeOnLoadMethod"),
        ('[MenuItem("A/B")]\n        private static void Open(int to) { }', "Open is no method for MenuItem"),
        ("}\n    public class Other : Broken\n    {", "Other: Unity wants the class named like its file"),
        (
            "private void Awake() { }\n    }\n    public class Other : Broken\n    {\n        private void Awake() { }",
            "Other: then Unity does not call Awake of its base class",
        ),
    ],
)
def test_a_broken_script_is_refused(member: str, fault: str) -> None:
    text = f"{{\n    public class Broken : ConnectedBehaviour\n    {{\n        {member}\n    }}\n}}\n"
    found = list(script_faults(copied() | {f"{TARGET}/Shared/Broken.cs": text.replace("        }\n", "    }\n")}))
    assert any(fault in one for one in found), found


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"dependencies": {"com.unity.modules.inputlegacy": "1.0.0"}}, "com.unity.modules.inputlegacy is not in every"),
        ({"dependencies": {"org.nuget.netmq": "4.0.4.5"}}, "org.nuget.netmq 4.0.4.5 is no package"),
        ({"dependencies": {"org.nuget.netmq": "1.0.4-05"}}, "org.nuget.netmq 1.0.4-05 is no package"),
        ({"dependencies": {"org.nuget.NetMQ": "4.0.4-5"}}, "org.nuget.NetMQ 4.0.4-5 is no package"),
        ({"scopedRegistries": [{"name": "a", "url": "https://a.b"}]}, "a registry wants a name, an address and scopes"),
        ({"unityRelease": "0f"}, "unityRelease is no release"),
        ({"samples": [{"displayName": "a", "description": "b", "path": "Samples~/c"}]}, "{'displayName': 'a', 'desc"),
    ],
)
def test_a_broken_manifest_is_refused(change: Json, fault: str) -> None:
    assert [one[: len(fault)] for one in manifest_faults({"dependencies": {}, **change})] == [fault]


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("!u!23 &403", "!u!33 &403", "403 is no MeshFilter"),
        ("  - component: {fileID: 202}\n", "", "('200', '202') is not said on both sides"),
        ("m_Father: {fileID: 201}", "m_Father: {fileID: 0}", "the roots are ['201', '401']"),
        ("m_Children:\n  - {fileID: 401}", "m_Children: []", "('201', '401') is not said on both sides"),
        ("--- !u!4 &401\nTransform:", "--- !u!20 &401\nCamera:", "400 has not one Transform"),
        ("--- !u!102 &402\nTextMesh:", "--- !u!20 &402\nCamera:", "400 has no TextMesh for ClientHud"),
    ],
)
def test_a_broken_scene_is_refused(old: str, new: str, fault: str) -> None:
    text = PREFAB.read_text(encoding="utf-8")
    assert text.count(old) == 1
    assert fault in list(scene_faults(text.replace(old, new)))
