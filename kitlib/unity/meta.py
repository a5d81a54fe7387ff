"""Unity wants more than the scripts: a .meta file for each file and folder, and a scene for each lesson.

    python3 -m kitlib.unity.meta      writes what is missing; run it after adding a lesson

A GUID is made from the path, so that it is the same wherever the file is written. What exists is never changed: a
scene may have been edited in Unity.
"""

import functools
import hashlib
import re
import sys
from pathlib import Path

from kitlib.lessons import PACKAGE, ROOT

EXAMPLE = PACKAGE / "03_publish_subscribe" / "03_publish_subscribe.unity"
# These stay out of Unity and of the repository: names that Unity ignores, and the DLLs that kit.py unity copies.
IGNORED = re.compile(r"^\.|~$|\.meta$|^Plugins$")


def guid(path: str) -> str:
    return hashlib.md5(f"NetMQExample/{path}".encode(), usedforsecurity=False).hexdigest()


def own_guid(path: Path) -> str:
    """The GUID that a file's .meta says, in its second line."""
    return meta_of(path).read_text(encoding="utf-8").splitlines()[1].removeprefix("guid: ")


def meta_of(path: Path) -> Path:
    return path.with_name(path.name + ".meta")


def meta(like: Path, identity: str) -> str:
    """The text of a .meta file, as another asset of the same kind has it."""
    return meta_of(like).read_text(encoding="utf-8").replace(own_guid(like), identity)


def assets() -> list[Path]:
    """Every file and folder that Unity imports, the package's own folder included."""
    found = [PACKAGE]
    for path in sorted(PACKAGE.rglob("*")):
        if not any(IGNORED.search(part) for part in path.relative_to(PACKAGE).parts):
            found.append(path)
    return found


# For scenes of your own: no lesson's scene has it, and the player (Scripts.cs) leaves it out. No source says so.
SPARE = {"RaySensor"}


@functools.cache
def bases() -> dict[str, tuple[str, str]]:
    """The words before each class of the package that has a base, and that base."""
    declared = r"^    public ((?:\w+ )*)class (\w+)(?:<\w+>)? : (\w+)"
    # Where ML-Agents' shape has a class of the same name, a lesson's goes before it.
    files = sorted(PACKAGE.rglob("*.cs"), key=lambda path: "MLAgents" not in path.parts)
    text = "\n".join(path.read_text(encoding="utf-8") for path in files)
    return {name: (words, base) for words, name, base in re.findall(declared, text, re.MULTILINE)}


def behaviours(folder: Path) -> list[Path]:
    """The scripts of a lesson's game object: Unity wants the class named like its file."""
    return [path for path in sorted(folder.glob("*.cs")) if path.stem not in SPARE and is_component(path.stem)]


def is_component(name: str) -> bool:
    """Whether Unity can add it to an object: by its bases it is a MonoBehaviour, and it is not abstract."""
    words, base = bases().get(name, ("abstract", ""))
    while base in bases():
        base = bases()[base][1]
    return base == "MonoBehaviour" and "abstract" not in words


def scene(scripts: list[Path]) -> str:
    """Lesson 03's scene, with these scripts on its game object; their fields have the values that the code gives.

    It also has a camera, a light and a text that shows the last line. A script that moves its object, and makes no
    shape, gets a cube.
    """
    code = "".join(path.read_text(encoding="utf-8") for path in scripts)
    if "transform." in code and not re.search(r"CreatePrimitive|Cube\.Make", code):
        scripts = [*scripts, PACKAGE / "Shared" / "Cube.cs"]
    text = EXAMPLE.read_text(encoding="utf-8")
    follower, cube = re.findall(r"^--- !u!114 &20\d\n.*?(?=^---)", text, re.MULTILINE | re.DOTALL)
    its_guid = own_guid(EXAMPLE.with_name("PoseFollower.cs"))
    parts = components = ""
    for number, path in enumerate(scripts, start=202):
        parts += follower.replace("&202", f"&{number}").replace(its_guid, own_guid(path))
        components += f"  - component: {{fileID: {number}}}\n"
    text = text.replace(follower + cube, parts)
    text = text.replace("  - component: {fileID: 202}\n  - component: {fileID: 203}\n", components)
    return text.replace("m_Name: PoseFollower\n", f"m_Name: {scripts[0].stem}\n")


def write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")
    print(f"wrote {path.relative_to(ROOT).as_posix()}")


def write_metas() -> None:
    for path in assets():
        if not meta_of(path).exists():
            alike = [other for other in assets() if other.suffix == path.suffix and other.is_dir() == path.is_dir()]
            like = next((other for other in alike if meta_of(other).exists()), None)
            if not like:
                sys.exit(f"no other file is like {path.name}: let Unity write its .meta")
            write(meta_of(path), meta(like, guid(path.relative_to(PACKAGE).as_posix())))


def main() -> None:
    write_metas()
    for folder in sorted(PACKAGE.glob("[0-9][0-9]_*")):
        scripts = behaviours(folder)
        if scripts and not (folder / f"{folder.name}.unity").exists():
            write(folder / f"{folder.name}.unity", scene(scripts))
    write_metas()


if __name__ == "__main__":
    main()
