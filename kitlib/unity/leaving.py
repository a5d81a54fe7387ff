"""The packages that leave a project with ML-Agents, and those that it brought along and the project uses itself."""

import re
from pathlib import Path
from typing import NamedTuple

from kitlib.lessons import read_json
from kitlib.unity.inventory import brought, dependencies
from kitlib.unity.ml_agents import FACTS
from kitlib.unity.own_files import ML_AGENTS

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
    locked = read_json(root / "Packages" / "packages-lock.json").get("dependencies") or {}
    users: dict[str, str] = {}
    for package, space in FACTS["packages"].items():
        found = (name for name, code in scripts.items() if re.search(rf"(?<![\w.])(?:{space})\b(?!\s*=)", code))
        if user := next(found, ""):
            users[package] = user
    removed = (ML_AGENTS | INFERENCE - users.keys()) & named.keys()
    direct = {name for name, entry in locked.items() if not entry.get("depth")} | named.keys()
    gone = brought(locked, removed) - brought(locked, direct - removed)
    kept = {name: str(locked[name]["version"]) for name in sorted(gone & users.keys() & locked.keys())}
    notes = []
    for package, user in users.items():
        if package in named and package in INFERENCE:
            notes.append(f"{user}: it uses {package}, which stays")
        elif removed and not locked and package not in named:
            notes.append(f"{user}: it uses {package}, which came with ML-Agents: add it in Unity's Package Manager")
    return Leaving(removed, kept, notes)
