"""The Unity project, read as Unity reads it: .meta files, scenes, assembly definitions, scripts, packages.

Many of the rules are those by which Unity's editor checks a project before it compiles, and when it imports; each was
read in Unity's published source. The files are those that kit.py unity copies, {path in a project: text}.
"""

import functools
import json
import re
from collections import Counter
from pathlib import Path

from kitlib.docs import guide
from kitlib.lessons import PACKAGE
from kitlib.unity import scripts
from kitlib.unity.inventory import LIBRARIES, NETMQ
from kitlib.unity.meta import assets, behaviours, guid, meta_of, own_guid
from netmq_example import __version__
from tests.programs import ROOT
from tests.unity.conftest import PREFAB

UNITY = ROOT / "unity"
SCENES = sorted(PACKAGE.rglob("*.unity"))
MANIFESTS = (UNITY / "Packages" / "manifest.json", PACKAGE / "package.json")
# The assemblies of Unity's test framework, and of a package that may be there.
UNITYS_OWN = {"UnityEngine.TestRunner", "UnityEditor.TestRunner", "Unity.InputSystem"}


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


def test_each_lesson_has_a_scene_with_its_scripts_in_which_something_is_seen():
    """The player (csharp-console/Play.cs) plays the scripts of the folder: the scene must hold them, and what shows it.

    That is the last line, in lessons 03 and 07 a cube that moves, and in 21 one that talks.
    """
    by_guid, faults = known_scripts(), []
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


# Unity has these built in, by the GUID of their library: the font and its ink. Its grey material is magenta in URP.
BUILT_IN = {"0" * 16 + "e" + "0" * 15: {"10102", "10100"}}
# A script's only object.
SCRIPT = "11500000"
# Unity itself writes these into a MonoBehaviour, beside the fields of its class.
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


@functools.cache
def known_scripts():
    return {own_guid(path): path for path in PACKAGE.rglob("*.cs")}


def reference_faults(text):
    """A line for each reference of a file that leads nowhere in Unity."""
    objects = documents(text)
    names = [name for _, name, _ in objects]
    known = known_scripts()
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


def test_a_scene_refers_to_objects_and_fields_that_exist():
    faults = []
    for path in [*SCENES, PREFAB, *UNITY.glob("ProjectSettings/*.asset")]:
        text = path.read_text(encoding="utf-8")
        if not text.startswith("%YAML 1.1\n%TAG !u! tag:unity3d.com,2011:\n--- !u!"):
            faults.append(f"{relative(path)} begins otherwise")
        faults += [f"{relative(path)}: {one}" for one in reference_faults(text)]
    assert faults == []


def assembly(name, files):
    """The .asmdef to which a script belongs: the nearest above it."""
    above = [path for path in files if path.endswith(".asmdef") and name.startswith(path.rpartition("/")[0] + "/")]
    return max(above, key=lambda path: path.count("/"), default=None)


PLATFORMS = {"Editor", "WebGL", "any other"}


def outside_the_editor(files):
    """The scripts that a player may have."""
    cs = {name: text for name, text in files.items() if name.endswith(".cs")}
    return {n: t for n, t in cs.items() if runs_on(json.loads(files[assembly(n, files) or ""])) != {"Editor"}}


def runs_on(definition):
    return set(definition["includePlatforms"] or PLATFORMS) - set(definition["excludePlatforms"])


def assembly_faults(files):
    found = {name: json.loads(text) for name, text in files.items() if name.endswith(".asmdef")}
    by_name = {definition["name"]: definition for definition in found.values()}
    owners = {assembly(name, files) for name in files if name.endswith(".cs")}
    for path, definition in found.items():
        name, references = definition["name"], definition["references"]
        # Unity refuses one that is named like an assembly of .NET's or its own, and then compiles nothing.
        if not name.startswith("NetMQExample"):
            yield f"{name}: Unity may have reserved this name"
        if path not in owners:
            yield f"{name} has no scripts, of which Unity warns"
        for other in by_name.keys() & set(references):
            if missing := runs_on(definition) - runs_on(by_name[other]):
                yield f"{name}: there is no {other} in {sorted(missing)}"
        # UNITY_INCLUDE_TESTS is defined in every editor, with the package of the Test Framework and without it.
        framework = [one["define"] for one in definition["versionDefines"] if one["name"] == "com.unity.test-framework"]
        if "UnityEngine.TestRunner" in references and not set(framework) & set(definition["defineConstraints"]):
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
# Of each class of Unity's that a script may use here: its base class.
BASES = {
    name: base
    for path in (ROOT / "csharp-support" / "unity-player" / "UnityEngine").glob("*.cs")
    for name, base in re.findall(
        r"^ *public (?:sealed |abstract |static |partial )*class (\w+)(?:<[^>]*>)?(?: : (?:\w+\.)*(\w+))?",
        path.read_text("utf-8"),
        re.M,
    )
}
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


def test_the_manifests_name_the_modules_that_scripts_need():
    # An assembly for the editor alone gets all of Unity's modules, whatever the project has.
    needed = scripts.modules(outside_the_editor(copied()).values()).keys()
    for path in MANIFESTS:
        manifest = json.loads(path.read_text(encoding="utf-8"))
        assert needed <= manifest["dependencies"].keys(), path.name


def test_the_package_is_valid():
    package = json.loads((PACKAGE / "package.json").read_text(encoding="utf-8"))
    assert re.fullmatch(r"[a-z0-9][a-z0-9._-]{0,213}", package["name"])
    assert re.fullmatch(r"\d+\.\d+\.\d+", package["version"])
    assert re.fullmatch(r"20\d\d\.\d|6000\.\d", package["unity"])
    assert package["displayName"] and package["description"] and package["license"]
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert f'version = "{package["version"]}"' in project, "one version for the whole kit"
    assert package["version"] == __version__
    # The project has all that the package needs of Unity.
    manifest = json.loads((UNITY / "Packages" / "manifest.json").read_text(encoding="utf-8"))
    assert package["dependencies"].items() <= manifest["dependencies"].items()
    # By the package's address one gets these, and nothing else of the repository.
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
    page = ROOT / "docs" / "guide" / "unity_project.md"
    (shown,) = [json.loads(block.body) for block in guide.blocks(page) if block.language == "json"]
    assert shown["scopedRegistries"] == manifest["scopedRegistries"]
    assert shown["dependencies"].items() <= manifest["dependencies"].items()


# Of a shape that has another one's.
COLLIDERS = {"Cube": "Box", "Cylinder": "Capsule", "Plane": "Mesh", "Quad": "Mesh"}


def test_the_linker_keeps_what_primitives_are_made_of():
    """CreatePrimitive fails if IL2CPP's linker has taken one of these away."""
    text = (PACKAGE / "link.xml").read_text("utf-8")
    kept = set(re.findall(r'<type fullname="UnityEngine\.(\w+)" preserve="all" />', text))
    used = {
        kind for path in PACKAGE.rglob("*.cs") for kind in re.findall(r"PrimitiveType\.(\w+)", path.read_text("utf-8"))
    }
    assert kept == {"MeshFilter", "MeshRenderer", *(f"{COLLIDERS.get(kind, kind)}Collider" for kind in used)}


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
