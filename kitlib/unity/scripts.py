"""The scripts that a lesson needs, by the classes that they name."""

import functools
import re
import tomllib
from collections.abc import Callable, Iterable, Set
from pathlib import Path

from kitlib.lessons import PACKAGE, KitError, Lesson, find
from kitlib.unity.inventory import TARGET
from kitlib.unity.meta import assets, meta_of

# Unity's own package of Newtonsoft.Json, with which lessons 04 and 05 read JSON.
JSON = ("com.unity.nuget.newtonsoft-json", "3.2.1")
NAMES: dict[str, dict[str, str]] = tomllib.loads(Path(__file__).with_name("names.toml").read_text(encoding="utf-8"))


# The programs of lesson 13 itself, which nothing else uses.
EXAMPLES = ("SideChannelClient", "SideChannelRounds", "StringLogChannel")
# In the place of a lesson: the files of a project that comes from ML-Agents.
ML_AGENTS = "ml-agents"


def scripts(lesson: str | None) -> dict[str, bytes]:
    """The files to copy, with their .meta: all of the package, or what one lesson needs."""
    chosen = assets()
    if lesson == ML_AGENTS:
        chosen = of_ml_agents()
    elif lesson is not None:
        chosen = of_lesson(find(lesson).unity)
    found: dict[str, bytes] = {}
    for path in chosen:
        name = f"{TARGET}/{path.relative_to(PACKAGE).as_posix()}".removesuffix("/.")
        if path.is_file():
            found[name] = path.read_bytes()
        if meta_of(path).exists():
            found[f"{name}.meta"] = meta_of(path).read_bytes()
    return found


def of_lesson(folder: Path) -> list[Path]:
    """A lesson's scripts, the earlier scripts that they use, and what IL2CPP must know."""
    if not folder.is_dir():
        raise KitError(f"lesson {folder.name} has no Unity scripts: is the kit whole?")
    chosen = with_used(sorted(folder.glob("*.cs")), folder.name, code)
    # The browser's half of a script, and the assembly of scripts that know nothing of NetMQ.
    chosen += [path for script in chosen if (path := script.with_suffix(".jslib")).exists()]
    folders = sorted({path.parent for path in chosen})
    chosen += [path for folder in folders if folder.name[:1].isdigit() for path in folder.glob("*.asmdef")]
    # With an assembly of their own: that is what a game's other assemblies can refer to, and what WebGL leaves out.
    # One without scripts is left out: Unity would warn of it at each compilation.
    inner = {path.parent for path in chosen if path.suffix == ".asmdef"}
    if not {path.parent for path in chosen if path.suffix == ".cs"} <= inner:
        chosen.append(PACKAGE / "NetMQExample.asmdef")
    return [PACKAGE, *folders, *chosen, PACKAGE / "link.xml"]


def of_ml_agents() -> list[Path]:
    """The scripts of ML-Agents' shape, and those that they use; without the lessons' examples."""
    space = re.compile(r"^namespace NetMQExample\.(MLAgents|RawSideChannels)\b", re.MULTILINE)
    parts = [*sorted(PACKAGE.glob("MLAgents/**/*.cs")), *sorted(PACKAGE.glob("[0-9][0-9]_*/*.cs"))]
    shape = [path for path in parts if space.search(code(path)) and path.stem not in EXAMPLES]
    own = {name for path in shape for name in types(path)}
    chosen = with_used(shape, "99", code, own)
    folders = {folder for path in chosen for folder in path.parents if folder.is_relative_to(PACKAGE)}
    return [*sorted(folders), *chosen, PACKAGE / "NetMQExample.asmdef", PACKAGE / "link.xml"]


def without_unity(lesson: Lesson) -> list[Path]:
    """Those of a lesson's scripts that need .NET alone, and the earlier ones that they and its terminal client use."""
    scripts = [path for path in sorted(lesson.unity.glob("*.cs")) if plain_code(path).strip()]
    plain = [path for path in scripts if "UnityEngine" not in plain_code(path)]
    return [path for path in with_used([lesson.console, *plain], lesson.key, plain_code) if path != lesson.console]


def with_used(scripts: list[Path], key: str, read: Callable[[Path], str], own: Set[str] = frozenset()) -> list[Path]:
    """These scripts, and those of Shared and of lessons before this one that they use.

    To these scripts the names `own` are types of theirs, also where a lesson has one of that name.
    """
    others = [path for path in sorted(PACKAGE.glob("[0-9][0-9]_*/*.cs")) if path.parent.name < key]
    others += sorted(PACKAGE.glob("Shared/*.cs"))
    chosen, first = list(scripts), set(scripts)
    left = [path for path in others if path not in first]
    for path in chosen:  # It grows meanwhile: what is used may use others.
        text, theirs = read(path), own if path in first else frozenset()
        used = {other for other in left if any(uses(text, name) for name in types(other) if name not in theirs)}
        chosen += [other for other in left if other in used]
        left = [other for other in left if other not in used]
    return chosen


def code(script: Path) -> str:
    """A script as the compiler sees it in Unity, without its texts: an error names components, and uses none."""
    text = re.sub(r"//.*", "", script.read_text(encoding="utf-8", errors="replace"))
    return re.sub(r'"(?:\\.|[^"\\\n])*"', lambda found: " ".join(["", *re.findall(r"{[^{}]*}", found[0]), ""]), text)


def plain_code(script: Path) -> str:
    return re.sub(r"#if UNITY_.*?#endif", "", code(script), flags=re.DOTALL)


@functools.cache
def types(script: Path) -> list[str]:
    """The types that a script has for others: PoseSubscriber.cs has PoseMessage as well."""
    return types_of(script.read_text(encoding="utf-8-sig", errors="replace"))


def types_of(text: str) -> list[str]:
    return re.findall(r"^    (?:public|internal) [\w ]*\b(?:class|struct|interface|enum) (\w+)", text, re.MULTILINE)


def uses(code: str, name: str) -> bool:
    """True if the code names this class: `e.Message` does not name the class Message, nor does a member of that name
    and of another type."""
    if name not in code:
        return False
    if re.search(rf"\b(?!(?:{name}|new|return|public|internal|private)\b)\w+ {name}(?: {{ get|\(|;)", code):
        return False
    return re.search(rf"(?<![\w.]){name}\b(?!:)", code) is not None


def unitys_packages(files: dict[str, bytes]) -> dict[str, str]:
    """Unity's own packages that the scripts among these files need, with their versions."""
    texts = [data.decode("utf-8-sig", "replace") for name, data in files.items() if name.endswith(".cs")]
    json_package = dict([JSON]) if any("using Newtonsoft.Json" in text for text in texts) else {}
    return {**json_package, **modules(texts)}


def modules(scripts: Iterable[str]) -> dict[str, str]:
    """Unity's built-in packages that these C# files need; all have one version."""
    words = {word for code in scripts for word in re.findall(r"\w+", re.sub(r"//.*", "", code))}
    return {module: "1.0.0" for module, types in NAMES["modules"].items() if words & set(types.split())}
