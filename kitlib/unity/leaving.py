"""The packages that leave a project with ML-Agents, and those that it brought along and the project uses itself."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from kitlib.unity.inventory import dependencies, leaving_with, lock
from kitlib.unity.ml_agents import FACTS, times
from kitlib.unity.own_files import ML_AGENTS, SCENES

# They serve models. Where the project names one and does not use it, it was for ML-Agents.
INFERENCE = {"com.unity.barracuda", "com.unity.sentis", "com.unity.ai.inference"}


class Leaving(NamedTuple):
    """The packages that are removed, those that are named from now on with their versions, and lines for a person."""

    removed: set[str]
    kept: dict[str, str]
    notes: list[str]


def leaving(root: Path, scripts: dict[str, str]) -> Leaving:
    """By the code of the project's scripts, without comments and texts."""
    named = dependencies(root)
    locked = lock(root)
    users: dict[str, str] = {}
    for package, space in FACTS["packages"].items():
        found = (name for name, code in scripts.items() if re.search(rf"(?<![\w.])(?:{space})\b(?!\s*=)", code))
        if user := next(found, ""):
            users[package] = user
    removed = (ML_AGENTS | INFERENCE - users.keys()) & named.keys()
    gone = leaving_with(root, removed) & users.keys() & locked.keys()
    kept = {name: str(locked[name]["version"]) for name in sorted(gone)}
    notes = []
    for package, user in users.items():
        if package in named and package in INFERENCE:
            notes.append(f"{user}: it uses {package}, which stays")
        elif removed and not locked and package not in named:
            notes.append(f"{user}: it uses {package}, which came with ML-Agents: add it in Unity's Package Manager")
    return Leaving(removed, kept, notes)


def left_behind(root: Path, files: list[str], scripts: dict[str, str]) -> Iterator[str]:
    """The project's own files that use what leaves with ML-Agents and is no package, each as a line for a person."""
    own = {Path(name).name for name in files}
    libraries = [one for one in FACTS["libraries"]["names"].split() if f"{one}.dll" not in own]
    used = re.compile(rf"(?<![\w.])(?:{'|'.join(map(re.escape, libraries)) or '(?!)'})\b")
    for name, code in scripts.items():
        if use := used.search(code):
            line = code.count("\n", 0, use.start()) + 1
            yield f"{name}:{line}: {use[0]} came with ML-Agents: bring its DLL, or delete what uses it"
    metas = [(root / name).read_bytes() for name in files if name.endswith((".nn.meta", ".onnx.meta", ".sentis.meta"))]
    models = [found[1] for meta in metas if (found := re.search(rb"^guid: (\w{32})", meta, re.MULTILINE))]
    reference = re.compile(rb"guid: (?:%s)\b" % (b"|".join(models) or b"(?!)"))
    for name in (name for name in files if name.endswith(SCENES)):
        data = (root / name).read_bytes()
        places = [found.start() for found in reference.finditer(data)]
        # A model of BehaviorParameters is named with its component.
        if fields := [at for at in places if not data.startswith(b"  m_Model:", data.rfind(b"\n", 0, at) + 1)]:
            line = data.count(b"\n", 0, fields[0]) + 1
            what = f"{times(len(fields))}a model in a field: Python plays it, or an inference package that stays"
            yield f"{name}:{line}: {what}"
