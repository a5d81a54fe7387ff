"""The Unity project, read as Unity reads it: .meta files, scenes, assembly definitions, scripts, packages.

Many of the rules are those by which Unity's editor checks a project before it compiles, and when it imports; each was
read in Unity's published source. The files are those that kit.py unity copies, {path in a project: text}.
"""

import functools
import json
import math
import re
from collections import Counter
from pathlib import Path

import pytest

from kitlib.docs import guide
from kitlib.lessons import PACKAGE
from kitlib.unity import scripts
from kitlib.unity.inventory import LIBRARIES, NETMQ
from kitlib.unity.meta import assets, behaviours, guid, meta_of, own_guid, scene
from tests.programs import ROOT
from tests.unity.conftest import PREFAB

UNITY = ROOT / "unity"
HERE = ROOT / "tests" / "unity"
SCENES = sorted(PACKAGE.rglob("*.unity"))
MANIFESTS = (UNITY / "Packages" / "manifest.json", PACKAGE / "package.json")
# The assemblies of Unity's test framework, and of a package that may be there.
UNITYS_OWN = {"UnityEngine.TestRunner", "UnityEditor.TestRunner", "Unity.InputSystem"}
# The parts of Unity that are packages, in 2022.3 and in each 6000.x. InputLegacy, TextRendering and Scripting are none:
# their types are always there, and Unity refuses a manifest that names such a package.
MODULES = (
    "ai|androidjni|animation|assetbundle|audio|cloth|director|imageconversion|imgui|jsonserialize|particlesystem|"
    "physics|physics2d|screencapture|terrain|terrainphysics|tilemap|ui|uielements|vehicles|video|wind|xr|"
    "unitywebrequest(assetbundle|audio|texture)?"
)


def relative(path):
    return path.relative_to(UNITY).as_posix()


@functools.cache
def copied(lesson=None):
    return {name: data.decode("utf-8") for name, data in scripts.scripts(lesson).items()}


def documents(text):
    """The objects of a Unity file: (class number, file id, text)."""
    parts = re.split(r"^--- !u!(\d+) &(\d+)\n", text, flags=re.MULTILINE)
    return [(int(kind), name, body) for kind, name, body in zip(parts[1::3], parts[2::3], parts[3::3], strict=True)]


def test_each_asset_has_its_meta():
    """The GUIDs are unique, and no .meta is left of what was renamed or removed."""
    faults = [f"{relative(m)} is of nothing" for m in UNITY.rglob("*.meta") if not m.with_suffix("").exists()]
    seen = {}
    for path in assets():
        if not meta_of(path).exists():
            faults.append(f"{relative(path)} has no .meta: run python3 -m kitlib.unity.meta")
            continue
        text = meta_of(path).read_text(encoding="utf-8")
        begins = re.match(r"fileFormatVersion: 2\nguid: ([0-9a-f]{32})\n", text)
        if not begins or ("folderAsset: yes" in text) != path.is_dir():
            faults.append(f"{relative(path)} has a wrong .meta")
        elif begins[1] in seen:
            faults.append(f"{relative(path)} has the guid of {seen[begins[1]]}")
        else:
            seen[begins[1]] = relative(path)
        # With another importer it would be a text.
        importer = {".asmdef": "AssemblyDefinitionImporter:", ".cs": "MonoImporter:"}.get(path.suffix, "")
        if importer not in text or (path.name == "package.json" and "PackageManifestImporter:" not in text):
            faults.append(f"{relative(path)} has another importer")
    assert faults == []
    # Made from the path, so that it is the same wherever the file is written.
    assert guid("01_request_reply/HelloClient.cs") == own_guid(PACKAGE / "01_request_reply" / "HelloClient.cs")


def test_a_new_lessons_scene_has_its_scripts_and_a_cube_if_it_moves():
    """Those of these lessons are as they were written."""
    for key in ("07_catch_up", "08_see_and_steer", "12_video"):
        lesson = PACKAGE / key
        assert scene(behaviours(lesson)) == (lesson / f"{key}.unity").read_text(encoding="utf-8")


def test_each_lesson_has_a_scene_with_its_scripts_in_which_something_is_seen():
    """The player (csharp-console/Play.cs) plays the scripts of the folder: the scene must hold them, and what shows it.

    That is the last line, in lessons 03 and 07 a cube that moves, and in 21 one that talks.
    """
    by_guid = {own_guid(path): path for path in PACKAGE.rglob("*.cs")}
    faults = []
    for lesson in (path for path in PACKAGE.glob("[0-9][0-9]_*") if behaviours(path)):
        text = (lesson / f"{lesson.name}.unity").read_text(encoding="utf-8")
        shown = ["LastLine.cs", *(["Cube.cs"] if lesson.name.startswith(("03", "07", "21")) else [])]
        there = {
            by_guid.get(one) for one in re.findall(r"m_Script: \{fileID: 11500000, guid: (\w{32}), type: 3\}", text)
        }
        if there != {*behaviours(lesson), *(PACKAGE / "Shared" / name for name in shown)}:
            faults.append(f"{lesson.name} has {there}")
        kinds = Counter(kind for kind, _, _ in documents(text))
        # A camera, a light, and a text with its renderer. A shape would name a material, which is of one render
        # pipeline only.
        if [kinds[number] for number in (20, 108, 102, 23, 33)] != [1, 1, 1, 1, 0]:
            faults.append(f"{lesson.name} has {kinds}")
    assert faults == []


@pytest.mark.parametrize(("key", "begin", "end"), [("10_many_agents", -4, 4), ("11_observations", 0, 10)])
def test_a_field_is_seen_from_above_and_below_the_text(key, begin, end):
    """From its own height one thing on it would cover the other."""
    text = (PACKAGE / key / f"{key}.unity").read_text(encoding="utf-8")
    (camera,) = [body for _, name, body in documents(text) if name == "101"]
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


# What Unity has built in, by the GUID of its library: the font and its ink. Its grey material is magenta in URP.
BUILT_IN = {"0" * 16 + "e" + "0" * 15: {"10102", "10100"}}
# A script's only object.
SCRIPT = "11500000"
# What Unity itself writes into a MonoBehaviour, beside the fields of its class.
UNITYS_FIELDS = {"m_ObjectHideFlags", "m_GameObject", "m_Enabled", "m_EditorHideFlags", "m_Script", "m_Name"}
UNITYS_FIELDS |= {"m_EditorClassIdentifier"}


@functools.cache
def serialized(name):
    """The fields that Unity writes of a class and those that it derives from: with SerializeField, and public ones.

    At the end of the line the class MonoBehaviour is among them.
    """
    for path in PACKAGE.rglob("*.cs"):
        # Without texts and comments, in which anything may stand.
        code = re.sub(r'"(?:[^"\\\n]|\\.)*"|//.*', "", path.read_text(encoding="utf-8"))
        if found := re.search(rf"\bclass {name}\b(?:<\w+>)?(?: : (\w+))?", code):
            marked = re.findall(r"\[SerializeField\b[^;=]*?\s(\w+)(?: = [^;]*)?;", code)
            return {*marked, *PUBLIC.findall(code), *serialized(found[1])}
    return {name} if name else set()


def reference_faults(text):
    """What Unity would not find of all that a file refers to."""
    objects = documents(text)
    names = [name for _, name, _ in objects]
    known = {own_guid(path): path for path in PACKAGE.rglob("*.cs")}
    yield from (f"{name} is there twice" for name, count in Counter(names).items() if count > 1)
    for _, name, body in objects:
        for number, of in re.findall(r"\{fileID: (\d+)(?:, guid: (\w+), type: \d)?\}", body):
            there = BUILT_IN.get(of, {SCRIPT} if of in known else set()) if of else {"0", *names}
            if number not in there:
                yield f"{name} refers to {number} {of}, which is not there"
        if (used := re.search(r"m_Script: .*guid: (\w+)", body)) and used[1] in known:
            fields = serialized(known[used[1]].stem)
            if "MonoBehaviour" not in fields:
                yield f"{known[used[1]].name} has no MonoBehaviour of its name"
            for field in {*re.findall(r"^  (\w+):", body, re.MULTILINE)} - UNITYS_FIELDS - fields:
                yield f"{known[used[1]].stem} has no field {field}"


# Unity goes by the number, and takes the name as said.
KINDS = {1: "GameObject", 4: "Transform", 20: "Camera", 23: "MeshRenderer", 33: "MeshFilter", 102: "TextMesh"}
KINDS |= {108: "Light", 114: "MonoBehaviour", 1660057539: "SceneRoots"}


def scene_faults(text):
    """Of a scene, or of a prefab."""
    parts = re.split(r"^--- !u!(\d+) &(\d+)\n", text, flags=re.M)[1:]
    kinds = {number: int(kind) for kind, number in zip(parts[::3], parts[1::3], strict=True)}
    bodies = dict(zip(parts[1::3], parts[2::3], strict=True))
    scripts_of = {own_guid(path): path for path in PACKAGE.rglob("*.cs")}

    def pairs(kind, key):
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


def test_a_scene_is_one_tree_of_objects_that_exist():
    faults = []
    for path in [*SCENES, PREFAB, *UNITY.glob("ProjectSettings/*.asset")]:
        text = path.read_text(encoding="utf-8")
        if not text.startswith("%YAML 1.1\n%TAG !u! tag:unity3d.com,2011:\n--- !u!"):
            faults.append(f"{relative(path)} begins otherwise")
        tree = scene_faults(text) if path.suffix != ".asset" else []
        faults += [f"{relative(path)}: {one}" for one in (*reference_faults(text), *tree)]
    assert faults == []


def test_yaml_parses_with_unitys_tags():
    yaml = pytest.importorskip("yaml", reason="reads a scene: pip install pyyaml")

    class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[name-defined,misc]
        pass

    def construct(loader, _suffix, node):
        return loader.construct_mapping(node, deep=True)

    Loader.add_multi_constructor("tag:unity3d.com,2011:", construct)
    for path in [*SCENES, *UNITY.glob("ProjectSettings/*.asset"), *PACKAGE.rglob("*.meta")]:
        text = path.read_text(encoding="utf-8")
        # Unity declares the tag once for all documents of a file; YAML wants it before each, so it is written out here.
        text = re.sub(r"^%.*\n", "", text, flags=re.MULTILINE)
        text = re.sub(r"^--- !u!(\d+) ", r"--- !<tag:unity3d.com,2011:\1> ", text, flags=re.MULTILINE)
        found = list(yaml.load_all(text, Loader))
        assert found and all(isinstance(one, dict) for one in found), relative(path)


def assembly(name, files):
    """The .asmdef to which a script belongs: the nearest above it."""
    above = [path for path in files if path.endswith(".asmdef") and name.startswith(path.rpartition("/")[0] + "/")]
    return max(above, key=lambda path: path.count("/"), default=None)


PLATFORMS = {"Editor", "WebGL", "any other"}
# Unity's constraints and versions can say more, which the package does not need.
SYMBOL = re.compile("[A-Z_]+")


def outside_the_editor(files):
    """The scripts that a player may have."""
    cs = {name: text for name, text in files.items() if name.endswith(".cs")}
    return {n: t for n, t in cs.items() if runs_on(json.loads(files[assembly(n, files) or ""])) != {"Editor"}}


def runs_on(definition):
    return set(definition["includePlatforms"] or PLATFORMS) - set(definition["excludePlatforms"])


def reachable(name, by_name):
    seen = set()
    left = [name]
    while left:
        new = by_name.keys() & set(by_name[left.pop()]["references"]) - seen
        seen |= new
        left += new
    return seen


def assembly_faults(files):
    found = {name: json.loads(text) for name, text in files.items() if name.endswith(".asmdef")}
    by_name = {definition["name"]: definition for definition in found.values()}
    owners = {assembly(name, files) for name in files if name.endswith(".cs")}
    folders = Counter(name.rpartition("/")[0] for name in found)
    yield from (f"{folder} has {count} assembly definitions" for folder, count in folders.items() if count > 1)
    for path, definition in found.items():
        name, references, constraints = (definition[key] for key in ("name", "references", "defineConstraints"))
        # Unity refuses one that is named like an assembly of .NET's or its own, and then compiles nothing.
        if not name.startswith("NetMQExample"):
            yield f"{name}: Unity may have reserved this name"
        if path not in owners:
            yield f"{name} has no scripts, of which Unity warns"
        if len(references) > len(set(references)):
            yield f"{name} has a reference twice"
        if name in reachable(name, by_name):
            yield f"{name} refers to itself in the end"
        yield from (f"{name}: {one} is no constraint" for one in constraints if not SYMBOL.fullmatch(one))
        for one in {*definition["includePlatforms"], *definition["excludePlatforms"]} - PLATFORMS:
            yield f"{name}: {one} is a platform that the package does not know"
        for other in by_name.keys() & set(references):
            if missing := runs_on(definition) - runs_on(by_name[other]):
                yield f"{name}: there is no {other} in {sorted(missing)}"
        for one in definition["versionDefines"]:
            if one["expression"] or not SYMBOL.fullmatch(one["define"]):
                yield f"{name}: {one['expression']} is not every version, or {one['define']} no symbol"
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
FACTS = re.findall(
    r"^(\w+) (?:\w+\.)*(\w+)(?:`\d)?(?: : (\w+))?    (.+)$",
    (HERE / "unity_api.txt").read_text(encoding="utf-8"),
    re.M,
)
BASES = {name: base for kind, name, base, _ in FACTS if kind == "class"}
# A constructor of a component may call none of these, and neither may what its fields begin with.
ENGINE = {name for name in BASES if not re.search("Attribute$|UnityEvent", name)} | {"FindObjectOfType", "Instantiate"}


def script_faults(files):
    # Without texts and comments, in which anything may stand.
    code = {n: re.sub(r'"(?:[^"\\\n]|\\.)*"|//.*', '""', text) for n, text in files.items() if n.endswith(".cs")}
    classes = {found[1]: (name, *found) for name, text in code.items() for found in CLASS.findall(text)}
    own = re.findall(r"(?:\benum|\[Serializable\]\s+[\w ]*(?:class|struct)) (\w+)", "".join(code.values()))
    values = rf"{PLAIN}|(?:{'|'.join(own)})(<.*>)?"

    def line(name):
        """A class and its bases; the last one is not the package's."""
        return [name, *line(classes[name][4])] if name in classes else [name]

    def is_object(name):
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


def manifest_faults(manifest):
    """Of a project's manifest.json, or a package's package.json."""
    for name, version in manifest["dependencies"].items():
        if not re.fullmatch(r"[a-z][a-z.-]+", name) or not re.fullmatch(r"\d+\.\d+\.\d+(-\d+)?", version):
            yield f"{name} {version} is no package"
        if name.startswith("com.unity.modules.") and not re.fullmatch(rf"[a-z.]+\.({MODULES})", name):
            yield f"{name} is not in every Unity"
    for one in manifest.get("scopedRegistries", []):
        if not (one.get("name") and one.get("scopes") and one.get("url", "").startswith("https://")):
            yield "a registry wants a name, an address and scopes"


USED = re.compile(r"^using (NetMQ|AsyncIO|NaCl|Newtonsoft\.Json)\b", re.MULTILINE)


def test_unity_compiles_the_assemblies_that_are_copied():
    # Lesson 16 has an assembly of its own.
    for lesson in (None, "4", "16"):
        assert [f"{lesson}: {fault}" for fault in assembly_faults(copied(lesson))] == []
    found = [json.loads(text) for name, text in copied().items() if name.endswith(".asmdef")]
    names = {definition["name"] for definition in found} | UNITYS_OWN
    dlls = {inside.rsplit("/", 1)[1] for _, _, inside in LIBRARIES}
    dlls |= {"nunit.framework.dll", "Newtonsoft.Json.dll"}
    for definition in found:
        assert {*definition["references"]} <= names and {*definition["precompiledReferences"]} <= dlls, definition[
            "name"
        ]
        assert not (definition["includePlatforms"] and definition["excludePlatforms"]), "Unity takes one of the two"
        # Or it gets each DLL of a game: with an old System.Memory.dll no use of Span compiles.
        assert definition["overrideReferences"], definition["name"]
    assert all(Path(name).stem == json.loads(text)["name"] for name, text in copied().items() if ".asmdef" in name[-7:])
    for name, text in copied().items():
        used = {f"{one}.dll" for one in re.findall(USED, text) if name.endswith(".cs")}
        if used:
            has = json.loads(copied()[assembly(name, copied())])["precompiledReferences"]
            assert used <= set(has), f"{name} is in an assembly without {used - set(has)}"


def test_unity_takes_the_scripts():
    assert list(script_faults(copied())) == []


def test_the_package_manager_takes_the_manifests_which_name_the_modules_that_scripts_need():
    # An assembly for the editor alone gets all of Unity's modules, whatever the project has.
    needed = scripts.modules(outside_the_editor(copied()).values()).keys()
    for path in MANIFESTS:
        manifest = json.loads(path.read_text(encoding="utf-8"))
        assert list(manifest_faults(manifest)) == [] and needed <= manifest["dependencies"].keys(), path.name


def test_the_modules_are_those_of_unitys_sources():
    declared = {}
    for _, name, _, source in FACTS:
        module = source.removeprefix("Modules/").partition("/")[0].lower()
        if source.startswith("Modules/") and re.fullmatch(MODULES, module):
            declared.setdefault(f"com.unity.modules.{module}", set()).add(name)
    declared["com.unity.modules.imageconversion"].add("EncodeToJPG")
    declared["com.unity.modules.physics"].add("CreatePrimitive")
    assert declared == {module: set(types.split()) for module, types in scripts.NAMES["modules"].items()}
    code = ["// GUI\nvar colliders = GetComponent<Collider>();", "class GUIs { }"]
    assert scripts.modules(code) == {"com.unity.modules.physics": "1.0.0"}


def test_the_lessons_are_left_out_of_webgl_which_has_its_own_error():
    found = [json.loads(text) for name, text in copied().items() if name.endswith(".asmdef")]
    by_name = {definition["name"]: definition for definition in found}
    assert by_name["NetMQExample"]["excludePlatforms"] == ["WebGL"]
    assert by_name["NetMQExample"]["includePlatforms"] == []
    assert by_name["NetMQExample.WebGL"]["includePlatforms"] == ["WebGL"]
    code = (PACKAGE / "WebGL" / "NotInABrowser.cs").read_text(encoding="utf-8")
    assert "#if UNITY_WEBGL && !UNITY_EDITOR" in code
    assert "using NetMQ" not in code, "NetMQ is not there in a browser"


def test_the_package_is_valid():
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


def test_the_manifest_gets_netmq_from_a_scoped_registry():
    manifest = json.loads((UNITY / "Packages" / "manifest.json").read_text(encoding="utf-8"))
    outside = [name for name in manifest["dependencies"] if not name.startswith("com.unity.")]
    scopes = [scope for registry in manifest["scopedRegistries"] for scope in registry["scopes"]]
    assert outside == ["org.nuget.netmq"]
    assert all(any(name.startswith(f"{scope}.") for scope in scopes) for name in outside)
    lessons = (ROOT / "csharp-support" / "lessons" / "NetMQExample.csproj").read_text(encoding="utf-8")
    assert 'Include="Newtonsoft.Json" Version="13.' in lessons
    assert manifest["dependencies"][scripts.JSON[0]] == scripts.JSON[1]
    # UnityNuGet writes the fourth number of a version behind a hyphen.
    assert manifest["dependencies"]["org.nuget.netmq"].replace("-", ".") == NETMQ


def test_unity_is_a_version_that_can_have_netmq():
    text = (UNITY / "ProjectSettings" / "ProjectVersion.txt").read_text(encoding="utf-8")
    found = re.match(
        r"m_EditorVersion: 6000\.0\.(\d+)f\d+\nm_EditorVersionWithRevision: 6000\.0\.\1f\d+ \([0-9a-f]{12}\)\n", text
    )
    # Earlier ones have CVE-2025-59489.
    assert found and int(found[1]) >= 58
    settings = (UNITY / "ProjectSettings" / "ProjectSettings.asset").read_text(encoding="utf-8")
    assert "\n  m_ActiveColorSpace: 1\n" in settings, "left out, it is gamma"


def test_a_field_says_what_it_is_for_and_how_small_it_may_be():
    fields = []
    for path in PACKAGE.glob("[0-9S]*/*.cs"):
        found = re.findall(r"\[SerializeField([^]]*)\]\s+private (\S+) (\w+)", path.read_text(encoding="utf-8"))
        fields += [(path.stem, name, kind, attributes) for attributes, kind, name in found]
    assert len(fields) > 100
    assert [field for field in fields if "Tooltip(" not in field[3]] == []
    numbers = [field for field in fields if field[2] in ("int", "float")]
    assert [field for field in numbers if not re.search(r"(Min|Range)\(", field[3])] == []


def test_the_page_shows_what_the_kits_own_manifest_has():
    page = ROOT / "docs" / "guide" / "unity_project.md"
    (shown,) = [json.loads(block.body) for block in guide.blocks(page) if block.language == "json"]
    manifest = json.loads((ROOT / "unity" / "Packages" / "manifest.json").read_text(encoding="utf-8"))
    assert shown["scopedRegistries"] == manifest["scopedRegistries"]
    assert shown["dependencies"].items() <= manifest["dependencies"].items()


def test_the_linker_is_not_told_to_keep_all_of_netmq():
    """Kept whole it would drag in what only its BufferPool names, at every stripping level."""
    text = (PACKAGE / "link.xml").read_text(encoding="utf-8")
    assert re.findall(r'assembly fullname="(\w+)" preserve="all" ignoreIfMissing="1"', text) == ["NetMQExample"]


def test_each_component_has_its_place_in_the_menu():
    """Add Component, NetMQ Example, by lesson; without it all lie in one row below Scripts."""
    found = {}
    for path in PACKAGE.rglob("[0-9S]*/*.cs"):
        text = path.read_text(encoding="utf-8")
        for kind, name, base in re.findall(r"^    public (\w* ?)class (\w+)(?:<\w+>)? : (\w+)", text, re.MULTILINE):
            found[name] = (base, path, kind)
    bases = {name: base for name, (base, _, _) in found.items()}

    def is_component(name):
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


def test_the_linker_keeps_what_primitives_are_made_of():
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


def test_no_script_but_one_asks_for_keys():
    """A project that listens to the Input System alone refuses Input at each call."""
    asks = re.compile(r"\bInput\.(Get|mouse|touch|any)|ENABLE_(LEGACY_)?INPUT")
    found = [path.name for path in PACKAGE.rglob("*.cs") if asks.search(path.read_text(encoding="utf-8"))]
    assert found == ["ArrowKeys.cs"]
    definition = json.loads((PACKAGE / "NetMQExample.asmdef").read_text(encoding="utf-8"))
    # Unity passes over a reference by name to what is not there.
    assert definition["references"] == ["Unity.InputSystem"]
    define = {"name": "com.unity.inputsystem", "expression": "", "define": "NETMQEXAMPLE_INPUT_SYSTEM"}
    assert define in definition["versionDefines"]
