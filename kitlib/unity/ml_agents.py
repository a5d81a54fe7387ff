"""The changes in the files of a project that comes from ML-Agents, and those that a person must make there.

Each function takes a file's text and returns its edits, and lines for a person: each a position and what to do there.
"""

import functools
import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from kitlib.lessons import PACKAGE
from kitlib.unity.edits import Edit
from kitlib.unity.inventory import TARGET
from kitlib.unity.meta import own_guid
from kitlib.unity.scripts import types_of

FACTS = tomllib.loads(Path(__file__).with_name("ml_agents.toml").read_text(encoding="utf-8"))
OURS, RAW = "NetMQExample.MLAgents", "NetMQExample.RawSideChannels"
NEW = r"Unity\.MLAgents\b"
ASSEMBLY = PACKAGE / "NetMQExample.asmdef"
INFERENCE = r"(?:Unity\.(?:Barracuda|Sentis|InferenceEngine)|Barracuda)"
# The names that change in a scene, besides the GUIDs: of events, of references by type, and Unity 6's own notes.
NAMED = re.compile(
    r"Unity\.ML-Agents::Unity\.MLAgents(?P<note>[.\w]*)"
    r"|\bUnity\.MLAgents(?P<event>[.\w]*), Unity\.ML-Agents\b"
    r"|\bns: Unity\.MLAgents(?P<space>[.\w]*), asm: Unity\.ML-Agents\b"
)
# Comments, texts and characters of C#.
QUIET = re.compile(
    r'//[^\n]*|/\*.*?\*/|\$?@\$?"(?:[^"]|"")*"|\$?"(?:\\.|[^"\\\n])*"' + r"|'(?:\\[^\n]+?|[^'\\\n])'", re.DOTALL
)


class Note(NamedTuple):
    """For a person: where in the text, and what to do."""

    at: int
    text: str


class Found(NamedTuple):
    edits: list[Edit]
    notes: list[Note]
    # The components that are found again, each with how many of it.
    components: Counter[str]


@functools.cache
def spaces() -> dict[str, str]:
    """The kit's types in ML-Agents' shape, each with its namespace."""
    found: dict[str, str] = {}
    for path in [*sorted(PACKAGE.glob("MLAgents/**/*.cs")), *sorted(PACKAGE.glob("13_*/*.cs"))]:
        # One file may have two.
        for part in re.split(r"^(?=namespace )", path.read_text(encoding="utf-8-sig"), flags=re.MULTILINE):
            if declared := re.match(rf"namespace ({OURS}[.\w]*)", part):
                found |= dict.fromkeys(types_of(part), declared[1])
    return found


def guids(root: Path) -> dict[str, str]:
    """ML-Agents' script GUIDs, each with the kit's: of the project's own .meta, if the kit is there already."""
    ours = {path.stem: path for path in sorted(PACKAGE.glob("MLAgents/**/*.cs"))}
    found = {}
    for guid, name in FACTS["scripts"].items():
        if name in ours:
            there = root / TARGET / ours[name].relative_to(PACKAGE)
            found[guid] = own_guid(there if there.with_name(f"{there.name}.meta").exists() else ours[name])
    return found


def without_quiet(text: str) -> str:
    """The code of a script, as long as it was: without comments and texts."""
    return QUIET.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def namespaces(text: str) -> set[str]:
    """The namespaces of a project's own script that have ML-Agents' name, as they are called here."""
    found = re.findall(r"\bnamespace\s+(?:Unity\.)?MLAgents\b([.\w]*)", without_quiet(text))
    return {OURS + rest for rest in found}


def csharp(text: str, own: set[str], old: bool) -> Found:
    """A script. `own`: the namespaces of the project's scripts; `old`: they are of 2020, when MLAgents was the name."""
    code = without_quiet(text)
    edits, notes = [], []
    known = {*spaces().values(), *own, OURS}
    lacking = set(FACTS["types"]["names"].split()) - spaces().keys()
    lacks = {one[0]: one.start() for one in re.finditer(rf"(?<![\w.])(?:{'|'.join(lacking)})\b", code)}
    for found in re.finditer(rf"(?<![\w.])(?:{old_names(known) if old else NEW})((?:\.\w+)*)", code):
        first, rest = found[0].removesuffix(found[1]), singular(found[1]) if old else found[1]
        after = beyond(OURS + rest, known)
        if not after or after in spaces() or re.search(r"namespace\s+$", code[: found.start()]):
            edits.append(Edit(found.start(), first + found[1], RAW if raw(code, rest) else OURS + rest))
        elif not lacks and after != "Extensions" and (line := using_line(code, found.start())):
            edits.append(whole_line(text, line))
        else:
            notes.append(Note(found.start(), f"the kit has no {found[0]}: delete this, and what uses it"))
    others = re.search(rf"(?<![\w.])(?:{'|'.join(FACTS['inference']['types'].split())})\b", code)
    if not others:
        edits += models(text, code, {edit.new for edit in edits})
    for found in QUIET.finditer(text):
        if found[0][0] != "/" and re.search(r"Unity\.ML-?Agents\b", found[0]):
            notes.append(Note(found.start(), "a text names ML-Agents: change it by hand if it is a type's name"))
    if edits:
        cures = FACTS["cures"]
        notes += [Note(at, f"the kit has no {name}: {cures.get(name, cures['else'])}") for name, at in lacks.items()]
    if edits or old:
        for pattern, what in FACTS["words"].items():
            notes += [Note(found.start(), what) for found in list(re.finditer(pattern, code))[:1]]
    return Found(edits, notes, Counter())


def old_names(known: set[str]) -> str:
    """The namespace of 2020 in a using line and in a declaration, and before a name of ML-Agents."""
    names = "|".join([*(space.rpartition(".")[2] for space in known), "Sensor", "SideChannel", *spaces()])
    return rf"(?:(?<=using )|(?<=using static )|(?<=namespace )|(?<== ))MLAgents\b|MLAgents(?=\.(?:{names})\b)"


def singular(rest: str) -> str:
    """Early 2020's namespaces with the ending of today."""
    return re.sub(r"^\.(Sensor|SideChannel)(?=\.|$)", r".\1s", rest)


def raw(code: str, rest: str) -> bool:
    """Whether these are the side channels of early 2020, which read and write bytes."""
    return rest == ".SideChannels" and "OnMessageReceived(byte[]" in code


def beyond(name: str, known: set[str]) -> str:
    """The first word of a name that belongs to none of these namespaces."""
    parts = name.split(".")
    count = next(count for count in range(len(parts), 0, -1) if ".".join(parts[:count]) in known)
    return parts[count] if count < len(parts) else ""


def using_line(code: str, at: int) -> re.Match[str] | None:
    """The using line, to its end, that names something at this position."""
    begin = code.rfind("\n", 0, at) + 1
    return re.compile(r"[ \t]*using (?:static )?[\w.]+;[ \t]*\r?\n?").match(code, begin)


def whole_line(text: str, line: re.Match[str]) -> Edit:
    """A using line away, but not a comment behind it."""
    old = line[0] if text.startswith(line[0], line.start()) else line[0].strip()
    return Edit(text.index(old, line.start()), old, "")


def models(text: str, code: str, usings: set[str]) -> Iterator[Edit]:
    """The usings of an inference package that serve ML-Agents' models alone, and full names of these."""
    ours = {name: spaces()[name] for name in ("NNModel", "ModelAsset") if name in spaces()}
    for name, space in ours.items():
        for found in re.finditer(rf"(?<![\w.]){INFERENCE}(?=\.{name}\b)", code):
            yield Edit(found.start(), found[0], space)
    needed = {space for name, space in ours.items() if re.search(rf"(?<![\w.]){name}\b", code)} - usings
    for found in re.finditer(rf"(?<=using ){INFERENCE}(?:\.\w+)*(?=;)", code):
        if needed:
            yield Edit(found.start(), found[0], needed.pop())
        elif line := using_line(code, found.start()):
            yield whole_line(text, line)


def yaml(text: str, ours: dict[str, str]) -> Found:
    edits: list[Edit] = []
    notes: list[Note] = []
    components: Counter[str] = Counter()
    # A scene may have many megabytes, and most assets have nothing of it.
    if "ML-Agents" not in text and not any(guid in text for guid in FACTS["scripts"]):
        return Found(edits, notes, components)
    lacking: dict[str, list[int]] = {}
    for found in re.finditer(rf"(?<=guid: )(?:{'|'.join(FACTS['scripts'])})\b", text):
        name = FACTS["scripts"][found[0]]
        if found[0] not in ours:
            lacking.setdefault(name, []).append(found.start())
            continue
        components[name] += 1
        edits.append(Edit(found.start(), found[0], ours[found[0]]))
    for name, places in lacking.items():
        notes.append(Note(places[0], f"{times(len(places))}{name}, which the kit lacks: it becomes a missing script"))
    for name, what in FACTS["stubs"].items():
        if components[name]:
            place = next(edit.at for edit in edits if FACTS["scripts"][edit.old] == name)
            notes.append(Note(place, f"{times(components[name])}{name}, which {what}"))
    for found in NAMED.finditer(text):
        rest = next(part for part in found.groups() if part is not None)
        if found["space"] is None and rest.rpartition(".")[2] not in spaces():
            continue
        shapes = {
            "note": f"NetMQExample::{OURS}{rest}",
            "event": f"{OURS}{rest}, NetMQExample",
            "space": f"ns: {OURS}{rest}, asm: NetMQExample",
        }
        edits.append(Edit(found.start(), found[0], shapes[found.lastgroup or ""]))
    if components:
        for pattern, what in WAS_PLAYED.items():
            if places := [one.start() for one in re.finditer(pattern, text, re.MULTILINE)]:
                notes.append(Note(places[0], f"{times(len(places))}{what}"))
    return Found(edits, notes, components)


def in_binary(data: bytes) -> bool:
    """Whether a file of Unity's that is no text names one of the scripts: there each byte's halves are swapped."""
    swapped = (re.sub("(.)(.)", r"\2\1", guid) for guid in FACTS["scripts"])
    return any(bytes.fromhex(guid) in data for guid in swapped)


# The values of BehaviorParameters by which a model played.
WAS_PLAYED = {
    r"^  m_Model: {fileID: -?[1-9]": "a model in BehaviorParameters, which is kept and does not play: Python plays it",
    r"^  m_BehaviorType: 2": "Behavior Type Inference Only: choose Default, or the Heuristic plays",
}


def times(count: int) -> str:
    return f"{count} times " if count > 1 else ""


def asmdef(text: str, ours: str) -> Found:
    """An assembly definition; `ours` is the GUID of the kit's."""
    edits, notes = [], []
    # Unity refuses a reference twice.
    there = re.search(rf'"(?:NetMQExample|GUID:{ours})"', text) is not None
    for found in re.finditer(r'"(?:GUID:(\w{32})|(Unity\.ML-Agents[.\w-]*))"', text):
        name = found[2] or FACTS["assemblies"].get(found[1], "")
        if name in ("Unity.ML-Agents.Editor", "Unity.ML-Agents.Extensions"):
            notes.append(Note(found.start(), f"the kit has no assembly {name}: delete this reference"))
        elif name == "Unity.ML-Agents" and not there:
            edits.append(Edit(found.start(), found[0], f'"GUID:{ours}"' if found[1] else '"NetMQExample"'))
            there = True
        elif name in ("Unity.ML-Agents", "Unity.ML-Agents.CommunicatorObjects"):
            edits.append(without_entry(text, found.start(), found.end()))
    return Found(edits, notes, Counter())


def without_entry(text: str, begin: int, end: int) -> Edit:
    """An entry of a list or an object of JSON, with its comma and its line."""
    space = len(text[:begin]) - len(text[:begin].rstrip())
    if after := re.match(r"\s*,", text[end:]):
        # The space before it, or of the first in a line that behind it.
        end += after.end()
        end += 0 if space else len(text[end:]) - len(text[end:].lstrip(" "))
        begin -= space
    elif text[:begin].rstrip().endswith(","):
        begin -= space + 1
    return Edit(begin, text[begin:end], "")
