"""What Unity wants beside the scripts: a .meta file for each file and folder, and a scene for each lesson.

    python3 -m kitlib.unity.meta      writes what is missing; run it after adding a lesson

A GUID is made from the path, so that it is the same wherever the file is written. What exists is never changed: a
scene may have been edited in Unity.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from kitlib.lessons import PACKAGE, ROOT

PREFAB = PACKAGE / "04_background_client" / "BackgroundClient.prefab"
# What stays out of Unity and of the repository: names that Unity ignores, and the DLLs that kit.py unity copies.
IGNORED = re.compile(r"^\.|~$|\.meta$|^Plugins$")

IMPORTERS = {
    ".cs": (
        "MonoImporter:\n  externalObjects: {}\n  serializedVersion: 2\n  defaultReferences: []\n"
        "  executionOrder: 0\n  icon: {instanceID: 0}\n"
    ),
    ".asmdef": "AssemblyDefinitionImporter:\n  externalObjects: {}\n",
    "package.json": "PackageManifestImporter:\n  externalObjects: {}\n",
    # JavaScript, which Unity adds to a WebGL build.
    ".jslib": (
        "PluginImporter:\n"
        "  externalObjects: {}\n"
        "  serializedVersion: 2\n"
        "  iconMap: {}\n"
        "  executionOrder: {}\n"
        "  defineConstraints: []\n"
        "  isPreloaded: 0\n"
        "  isOverridable: 0\n"
        "  isExplicitlyReferenced: 0\n"
        "  validateReferences: 1\n"
        "  platformData:\n"
        "  - first:\n"
        "      Any:\n"
        "    second:\n"
        "      enabled: 0\n"
        "      settings: {}\n"
        "  - first:\n"
        "      WebGL: WebGL\n"
        "    second:\n"
        "      enabled: 1\n"
        "      settings: {}\n"
    ),
    ".json": "TextScriptImporter:\n  externalObjects: {}\n",
    ".xml": "TextScriptImporter:\n  externalObjects: {}\n",
    ".md": "TextScriptImporter:\n  externalObjects: {}\n",
    ".prefab": "PrefabImporter:\n  externalObjects: {}\n",
}
ANYTHING = "DefaultImporter:\n  externalObjects: {}\n"
FOLDER = "folderAsset: yes\n" + ANYTHING
END = "  userData:\n  assetBundleName:\n  assetBundleVariant:\n"

YAML = """%YAML 1.1
%TAG !u! tag:unity3d.com,2011:
"""
SCENE = """{game_objects}--- !u!1660057539 &9223372036854775807
SceneRoots:
  m_ObjectHideFlags: 0
  m_Roots:
{roots}"""
GAME_OBJECT = """--- !u!1 &{number}
GameObject:
  m_ObjectHideFlags: 0
  serializedVersion: 6
  m_Component:
{components}  m_Layer: 0
  m_Name: {name}
  m_TagString: {tag}
  m_IsActive: 1
--- !u!4 &{transform}
Transform:
  m_ObjectHideFlags: 0
  m_GameObject: {{fileID: {number}}}
  m_LocalRotation: {rotation}
  m_LocalPosition: {position}
  m_LocalScale: {{x: 1, y: 1, z: 1}}
  m_Children:{children}
  m_Father: {{fileID: {father}}}
"""
CAMERA = """--- !u!20 &102
Camera:
  m_ObjectHideFlags: 0
  m_GameObject: {fileID: 100}
  m_Enabled: 1
  serializedVersion: 2
  m_ClearFlags: 2
  m_BackGroundColor: {r: 0.16, g: 0.2, b: 0.25, a: 1}
  m_NormalizedViewPortRect:
    serializedVersion: 2
    x: 0
    y: 0
    width: 1
    height: 1
  near clip plane: 0.3
  far clip plane: 1000
  field of view: 60
  m_CullingMask:
    serializedVersion: 2
    m_Bits: 4294967295
"""
LIGHT = """--- !u!108 &302
Light:
  m_ObjectHideFlags: 0
  m_GameObject: {fileID: 300}
  m_Enabled: 1
  serializedVersion: 10
  m_Type: 1
  m_Color: {r: 1, g: 0.96, b: 0.84, a: 1}
  m_Intensity: 1
"""
# What it refers to is built into Unity: the font and its ink.
TEXT = """--- !u!102 &402
TextMesh:
  m_ObjectHideFlags: 0
  m_GameObject: {fileID: 400}
  serializedVersion: 3
  m_Text: press Play
  m_OffsetZ: 0
  m_CharacterSize: 0.05
  m_LineSpacing: 1
  m_Anchor: 4
  m_Alignment: 1
  m_TabSize: 4
  m_FontSize: 80
  m_FontStyle: 0
  m_RichText: 0
  m_Font: {fileID: 10102, guid: 0000000000000000e000000000000000, type: 0}
  m_Color:
    serializedVersion: 2
    rgba: 4294967295
--- !u!23 &403
MeshRenderer:
  m_ObjectHideFlags: 0
  m_GameObject: {fileID: 400}
  m_Enabled: 1
  m_Materials:
  - {fileID: 10100, guid: 0000000000000000e000000000000000, type: 0}
"""
TEXT_BELOW = "\n  - {fileID: 401}"
SCRIPT = """--- !u!114 &{number}
MonoBehaviour:
  m_ObjectHideFlags: 0
  m_GameObject: {{fileID: {owner}}}
  m_Enabled: 1
  m_EditorHideFlags: 0
  m_Script: {{fileID: 11500000, guid: {guid}, type: 3}}
  m_Name:
  m_EditorClassIdentifier:
"""


def guid(path: str) -> str:
    """The GUID of an asset, from its path in this package."""
    return hashlib.md5(f"NetMQExample/{path}".encode(), usedforsecurity=False).hexdigest()


def own_guid(path: Path) -> str:
    """The GUID that a file's .meta says."""
    found = re.search(r"^guid: ([0-9a-f]{32})$", meta_of(path).read_text(encoding="utf-8"), re.MULTILINE)
    assert found, f"no guid in {meta_of(path)}"
    return found[1]


def meta_of(path: Path) -> Path:
    return path.with_name(path.name + ".meta")


def meta(path: Path, identity: str) -> str:
    """The text of a .meta file."""
    importer = FOLDER if path.is_dir() else IMPORTERS.get(path.name) or IMPORTERS.get(path.suffix, ANYTHING)
    return f"fileFormatVersion: 2\nguid: {identity}\n{importer}{END}"


def assets() -> list[Path]:
    """Every file and folder that Unity imports, the package's own folder included."""
    found = [PACKAGE]
    for path in sorted(PACKAGE.rglob("*")):
        if not any(IGNORED.search(part) for part in path.relative_to(PACKAGE).parts):
            found.append(path)
    return found


# For scenes of one's own: no lesson's scene has them, and the player (Scripts.cs) leaves them out.
SPARE = {"RaySensor"}


def behaviours(folder: Path) -> list[Path]:
    """The scripts of a lesson's game object: Unity wants the class named like its file."""
    bases = r"(?:Mono|Network|Connected|Driven|SideChannel|Stepped)Behaviour|Python(?:Environment|Agents)|Agent"
    pattern = rf"^\s*public (?:sealed )?class {{}} : (?:{bases}|SensorComponent)\b"
    scripts = [path for path in sorted(folder.glob("*.cs")) if path.stem not in SPARE]
    return [p for p in scripts if re.search(pattern.format(p.stem), p.read_text(encoding="utf-8"), re.MULTILINE)]


def scene(scripts: list[Path]) -> str:
    """A camera, a light, a text that shows the last line, and one game object with the lesson's scripts, whose fields
    have the values that the code gives. What moves is a cube, if it does not make its own."""
    code = "".join(path.read_text(encoding="utf-8") for path in scripts)
    if "transform." in code and not re.search(r"CreatePrimitive|Cube\.Make", code):
        scripts = [*scripts, PACKAGE / "Shared" / "Cube.cs"]
    numbers = [202 + i for i in range(len(scripts))]
    shown = PACKAGE / "Shared" / "LastLine.cs"
    parts = [
        game_object(100, "Main Camera", "MainCamera", "{x: 0, y: 1, z: -10}", [101, 102], children=TEXT_BELOW),
        CAMERA,
        game_object(200, scripts[0].stem, "Untagged", "{x: 0, y: 0, z: 0}", [201, *numbers]),
        *(script(n, 200, path) for n, path in zip(numbers, scripts, strict=True)),
        # Down and to the right, as the light of a new scene in Unity.
        game_object(
            300, "Light", "Untagged", "{x: 0, y: 3, z: 0}", [301, 302], "{x: 0.41, y: -0.23, z: 0.11, w: 0.88}"
        ),
        LIGHT,
        # Where the camera looks, and where it moves.
        game_object(400, "Last line", "Untagged", "{x: 0, y: 3, z: 10}", [401, 402, 403, 404], father=101),
        TEXT,
        script(404, 400, shown),
    ]
    roots = "".join(f"  - {{fileID: {number}}}\n" for number in (101, 201, 301))
    return YAML + SCENE.format(game_objects="".join(parts), roots=roots)


def prefab() -> str:
    """Lesson 04's client, with a text of its own that follows the camera."""
    client = PACKAGE / "04_background_client" / "HelloBackground.cs"
    parts = [
        game_object(200, "Background client", "Untagged", "{x: 0, y: 0, z: 0}", [201, 202], children=TEXT_BELOW),
        script(202, 200, client),
        game_object(400, "Hud", "Untagged", "{x: 0, y: 0, z: 2}", [401, 402, 403, 404], father=201),
        TEXT.replace("m_CharacterSize: 0.05", "m_CharacterSize: 0.01"),
        script(404, 400, PACKAGE / "Shared" / "ClientHud.cs") + "  client: {fileID: 202}\n",
    ]
    return YAML + "".join(parts)


def script(number: int, owner: int, path: Path) -> str:
    return SCRIPT.format(number=number, owner=owner, guid=own_guid(path))


def game_object(
    number: int,
    name: str,
    tag: str,
    position: str,
    components: list[int],
    rotation: str = "{x: 0, y: 0, z: 0, w: 1}",
    children: str = " []",
    father: int = 0,
) -> str:
    lines = "".join(f"  - component: {{fileID: {component}}}\n" for component in components)
    return GAME_OBJECT.format(
        number=number,
        transform=number + 1,
        name=name,
        tag=tag,
        position=position,
        rotation=rotation,
        components=lines,
        children=children,
        father=father,
    )


def write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")
    print(f"wrote {path.relative_to(ROOT).as_posix()}")


def write_metas() -> None:
    for path in assets():
        if not meta_of(path).exists():
            write(meta_of(path), meta(path, guid(path.relative_to(PACKAGE).as_posix())))


def main() -> None:
    write_metas()
    for folder in sorted(PACKAGE.glob("[0-9][0-9]_*")):
        scripts = behaviours(folder)
        if scripts and not (folder / f"{folder.name}.unity").exists():
            write(folder / f"{folder.name}.unity", scene(scripts))
    if not PREFAB.exists():
        write(PREFAB, prefab())
    write_metas()


if __name__ == "__main__":
    main()
