"""What Unity wants beside the scripts: a .meta file for each file and folder, and a scene for each lesson.

    python3 -m kitlib.unity_meta      writes what is missing; run it after adding a lesson

A GUID is made from the path, so that it is the same wherever the file is written. What exists is never changed: a
scene may have been edited in Unity.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from .lessons import ROOT

ASSETS = ROOT / "unity" / "Assets"
PACKAGE = ASSETS / "NetMQExample"
# What stays out of Unity and of the repository: names that Unity ignores, and the DLLs that kit.py unity copies.
IGNORED = re.compile(r"^\.|~$|\.meta$|^Plugins$")

IMPORTERS = {
    ".cs": (
        "MonoImporter:\n  externalObjects: {}\n  serializedVersion: 2\n  defaultReferences: []\n"
        "  executionOrder: 0\n  icon: {instanceID: 0}\n"
    ),
    ".asmdef": "AssemblyDefinitionImporter:\n  externalObjects: {}\n",
    "package.json": "PackageManifestImporter:\n  externalObjects: {}\n",
    ".json": "TextScriptImporter:\n  externalObjects: {}\n",
    ".xml": "TextScriptImporter:\n  externalObjects: {}\n",
    ".md": "TextScriptImporter:\n  externalObjects: {}\n",
}
ANYTHING = "DefaultImporter:\n  externalObjects: {}\n"
FOLDER = "folderAsset: yes\n" + ANYTHING
END = "  userData:\n  assetBundleName:\n  assetBundleVariant:\n"

SCENE = """%YAML 1.1
%TAG !u! tag:unity3d.com,2011:
{game_objects}--- !u!1660057539 &9223372036854775807
SceneRoots:
  m_ObjectHideFlags: 0
  m_Roots:
  - {{fileID: 101}}
  - {{fileID: 201}}
"""
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
  m_LocalRotation: {{x: 0, y: 0, z: 0, w: 1}}
  m_LocalPosition: {position}
  m_LocalScale: {{x: 1, y: 1, z: 1}}
  m_Children: []
  m_Father: {{fileID: 0}}
"""
CAMERA = """--- !u!20 &102
Camera:
  m_ObjectHideFlags: 0
  m_GameObject: {fileID: 100}
  m_Enabled: 1
  serializedVersion: 2
  m_ClearFlags: 2
  m_BackGroundColor: {r: 0.16, g: 0.2, b: 0.25, a: 1}
"""
SCRIPT = """--- !u!114 &{number}
MonoBehaviour:
  m_ObjectHideFlags: 0
  m_GameObject: {{fileID: 200}}
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


def behaviours(folder: Path) -> list[Path]:
    """The scripts of a lesson that can be put on a game object: Unity wants the class named like its file."""
    pattern = r"^\s*public (?:sealed )?class {} : MonoBehaviour"
    scripts = sorted(folder.glob("*.cs"))
    return [p for p in scripts if re.search(pattern.format(p.stem), p.read_text(encoding="utf-8"), re.MULTILINE)]


def scene(scripts: list[Path]) -> str:
    """A camera, and one game object with the lesson's scripts; their fields have the values that the code gives."""
    numbers = [202 + i for i in range(len(scripts))]
    parts = [
        game_object(100, "Main Camera", "MainCamera", "{x: 0, y: 1, z: -10}", [101, 102]),
        CAMERA,
        game_object(200, scripts[0].stem, "Untagged", "{x: 0, y: 0, z: 0}", [201, *numbers]),
        *(SCRIPT.format(number=n, guid=own_guid(path)) for n, path in zip(numbers, scripts, strict=True)),
    ]
    return SCENE.format(game_objects="".join(parts))


def game_object(number: int, name: str, tag: str, position: str, components: list[int]) -> str:
    lines = "".join(f"  - component: {{fileID: {component}}}\n" for component in components)
    return GAME_OBJECT.format(
        number=number, transform=number + 1, name=name, tag=tag, position=position, components=lines
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
    write_metas()


if __name__ == "__main__":
    main()
