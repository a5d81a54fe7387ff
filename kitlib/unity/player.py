"""Why a script of a reader's own does not compile in the player: what it names, and the player or its project lacks."""

import difflib
import functools
import hashlib
import itertools
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from kitlib.lessons import BUILD, KIT, PACKAGE, ROOT, lessons
from kitlib.setup.dotnet import SUPPORT, compiler_errors
from kitlib.terminal import command
from kitlib.unity.project import find_project
from kitlib.unity.scripts import NAMES, code, of_lesson, types, uses

NAMESPACE = "NetMQExample"
STAND_INS = SUPPORT / "unity-player" / "UnityEngine"
ALL_OF_IT = f"; all of Unity that it has is in {STAND_INS.relative_to(ROOT).as_posix()}"
MOVED, USINGS = NAMES["moved"], NAMES["usings"]
# Of these words, which others use as well: they count only beside one that nobody else has.
EVERYBODYS = {"ToArray", "GetSingle", "Image", "GetName", "MaxStep"}
CHANGED = "the player uses your copy of a kit's file only if you name it here, with each that uses its classes"
# The compiler's words for a type, a name or a namespace that is nowhere, and for a member that a type does not have.
NOWHERE = r"error CS(?:0246|0103|0234): \D*?'(?=\w+' does not exist in the namespace '([\w.]+)'|)(\w+)[<,>]*'"
NO_MEMBER = r"error CS(?:0117|1061): '(\w+)(?:<.*?>)?' does not contain a definition for '(\w+)'"
# For one that it has by other parameters.
NO_OVERLOAD = r"error CS(?:1729: '|7036: .* of ')(\w+)"
# A variable that is a thread.
THREAD = re.compile(r"\bThread\s+(\w+)|(\w+)\s*=\s*new (?:System\.Threading\.)?Thread\b")
TYPE = r"^    public (?:\w+ )*(class|struct|enum|interface) (\w+)(.*?)(?=^ {0,4}\w|\Z)"
# In the source: `public float x, y;`, `public float Range(`, and no operator.
MEMBER = r"(?:^ {8}|[{;] )public (?!delegate|class|.* operator )[^=({;]*?(\w+(?:, \w+)*)(?:<\w+>)?(?=\W*[=({;\n])"


@functools.cache
def stand_ins() -> dict[str, list[str]]:
    """Unity's types that the player has, each with its public members, as the source has them."""
    found: dict[str, list[str]] = {}
    for path in sorted(STAND_INS.glob("*.cs")):
        text = re.sub(r"//.*", "", path.read_text(encoding="utf-8"))
        for kind, name, body in re.findall(TYPE, text, re.MULTILINE | re.DOTALL):
            if kind == "enum":
                members = re.findall(r"(\w+)(?: = \d+)?(?=\s*[,}])", body)
            else:
                members = [member for some in re.findall(MEMBER, body, re.MULTILINE) for member in some.split(", ")]
            found.setdefault(name, []).extend(member for member in members if member != name)
    return {name: sorted(set(found[name])) for name in sorted(found)}


def for_dotnet(path: Path) -> Path:
    """The script, or a copy that calls the player's method in place of Abort of a thread, which .NET does not have."""
    text = path.read_text(encoding="utf-8-sig", errors="surrogateescape")
    threads = [name for pair in THREAD.findall(text) for name in pair if name]
    changed = re.sub(rf"\b({'|'.join(threads)})(\??)\.Abort\(\)", r"\1\2.AbortAsOnMono()", text) if threads else text
    if changed == text:
        return path
    copy = BUILD / "own" / hashlib.sha256(str(path).encode()).hexdigest()[:12] / path.name
    changed = f'#line 1 "{path}"\n{changed}'
    if not copy.exists() or copy.read_text(encoding="utf-8", errors="surrogateescape") != changed:
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(changed, encoding="utf-8", errors="surrogateescape")
    return copy


def bringing(names: Iterable[str]) -> list[int]:
    """The first lessons with which `kit.py unity` copies these classes; none: only the whole package has them."""
    copied = {
        lesson.number: {name for path in of_lesson(lesson.unity) if path.suffix == ".cs" for name in types(path)}
        for lesson in lessons()
    }
    each = [{number for number, has in copied.items() if name in has} for name in names]
    if not each or not all(each):
        return []
    together = set.intersection(*each)
    return sorted({min(numbers) for numbers in ([together] if together else each)})


def why(output: str, own: Sequence[Path], theirs: Sequence[Path] | None) -> str:
    """Each of the compiler's errors once, and then what is missing, with the cure."""
    errors = compiler_errors(output)
    said = [*lacking_of_the_kit(errors, own, theirs), *moved(errors, own), *lacking_of_unity(errors, own)]
    # Two classes of one name; or a member to override that only the reader's own file has.
    if "NetMQExample.dll]" in output or (not said and "error CS0115" in output):
        said = [CHANGED]
    return "\n".join(["your script does not compile:", *errors, *said])


def lacking_of_the_kit(errors: list[str], own: Sequence[Path], theirs: Sequence[Path] | None) -> Iterator[str]:
    kit = {name for name in kits_names() if not beside(name, own)}
    if theirs is None or not any(name in kit for line in errors for _, name in re.findall(NOWHERE, line)):
        return
    # Also those of which the compiler says nothing yet, because it has not come so far.
    text = "\n".join(map(code, own))
    there = set(re.findall(r"\b(?:class|struct|enum) (\w+)", text)).union([NAMESPACE], *map(types, theirs))
    lacks = sorted(name for name in kit - there if uses(text, name))
    words = [*KIT.split(), "unity", str(find_project(own[0]))]
    each = [command(*words, "--lesson", str(number)) for number in bringing(lacks)] or [command(*words)]
    cure = " and ".join(f"`{line}`" for line in each)
    yield f"this project has no {', '.join(lacks) or NAMESPACE}: {cure} copies what is missing"


def kits_names() -> set[str]:
    """The kit's names, which a script can use."""
    return {NAMESPACE, *(name for path in PACKAGE.glob("[0-9S]*/*.cs") for name in types(path))}


def beside(name: str, own: Sequence[Path]) -> Path | None:
    """A file of this name next to a script, or in its project, that was not named."""
    near = [path.with_name(f"{name}.cs") for path in own]
    inside = (path for folder in own[0].parents if folder.name == "Assets" for path in folder.rglob(f"{name}.cs"))
    return next((path for path in itertools.chain(near, inside) if path.exists() and path not in own), None)


def moved(errors: list[str], own: Sequence[Path]) -> Iterator[str]:
    """Names of gymize, of ML-Agents, of NetMQ 3 and of the kit's last version, and the page that has ours."""
    written = set(re.findall(r"\w+", "\n".join(map(code, own))))
    quoted = re.findall(r"'([^'\n]*)'", "\n".join(errors))
    words = set(re.findall(r"\w+", " ".join(quoted)))
    for page, names in MOVED.items():
        theirs = set(names.split())
        found = ", ".join(name for name in names.split() if name in words)
        if found and (theirs - EVERYBODYS) & (written | words):
            yield f"{page} says what to write for {found}"


def lacking_of_unity(errors: list[str], own: Sequence[Path]) -> Iterator[str]:
    kit = kits_names()
    text = "\n".join(map(code, own))
    # A name that is nowhere is a type if something of it is used, as in Mathf.Abs.
    nowhere = dict.fromkeys(
        words
        for line in errors
        for words in re.findall(NOWHERE, line)
        if "CS0103" not in line or re.search(rf"\b{words[1]}\.", text)
    )
    there = {words: path for words in nowhere if (path := beside(words[1], own))}
    if there:
        yield f"name {', '.join(shown(path, own[0]) for path in there.values())}, too"
    everybodys = EVERYBODYS - set(" ".join(moved(errors, own)).split())
    told = set(" ".join(MOVED.values()).split()) - everybodys
    lacks = [words for words in nowhere if words not in there and words[1] not in told | kit]
    spaces = [name for space, name in lacks if not space and re.search(rf"^\s*using {name}\b", text, re.MULTILINE)]
    for name in spaces:
        yield f"nothing here has the namespace {name}: if it is yours, name its files, too; the player takes no DLL"
    lacks = [words for words in lacks if words[1] not in spaces]
    for space, names in USINGS.items():
        if found := [name for _, name in lacks if name in names.split()]:
            yield f"{', '.join(found)}: write `using {space};`"
            lacks = [words for words in lacks if words[1] not in found]
    if lacks:
        names = ", ".join(".".join(filter(None, words)) for words in lacks)
        # A namespace is no misspelt type.
        types = [name for space, name in lacks if not space]
        like = likely(types, [name for name in stand_ins() if not name.endswith("Attribute")])
        yield f"the player has no {names}{like}{'; if it is yours, name its file, too' if types else ''}"
    unknown = dict.fromkeys(pair for line in errors for pair in re.findall(NO_MEMBER, line))
    for kind in dict.fromkeys(kind for kind, _ in unknown if kind in stand_ins()):
        members = [member for one, member in unknown if one == kind]
        yield f"the player's {kind} has no {', '.join(members)}{likely(members, stand_ins()[kind])}"
    for kind in dict.fromkeys(kind for line in errors for kind in re.findall(NO_OVERLOAD, line) if kind in stand_ins()):
        yield f"the player's {kind} has not every overload{ALL_OF_IT}"


def shown(path: Path, script: Path) -> str:
    return path.name if path.parent == script.parent else str(path)


def likely(names: Iterable[str], there: Sequence[str]) -> str:
    """What is there under such a name, and where everything is."""
    near = dict.fromkeys(one for name in names for one in difflib.get_close_matches(name, there, cutoff=0.75))
    like = f", but {', '.join(near)}" if near else ""
    return f"{like}{ALL_OF_IT}"
