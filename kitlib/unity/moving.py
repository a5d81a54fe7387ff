"""Moves a project of ML-Agents in: `kit.py unity PATH --from ml-agents` says what it would do, `--yes` does it.

It changes text files of the project's own and writes down each change, by which `--undo` takes all of it back.
"""

import json
import os
import re
from collections.abc import Iterable, Iterator, Set
from pathlib import Path
from typing import Any

from kitlib.files import place
from kitlib.lessons import KIT, KitError, read_json
from kitlib.terminal import say
from kitlib.unity import ml_agents
from kitlib.unity.edits import Edit, applied, checksum, decoded, difference, reversed_
from kitlib.unity.install import RECORD, delete, install, prepare, with_packages
from kitlib.unity.inventory import TARGET, Inventory, dependencies
from kitlib.unity.leaving import Leaving, leaving, left_behind
from kitlib.unity.meta import own_guid
from kitlib.unity.own_files import ML_AGENTS as PACKAGES
from kitlib.unity.own_files import SCENES, copies_of_ml_agents, is_link, own_files, walk
from kitlib.unity.project import advice, find_project
from kitlib.unity.scripts import ML_AGENTS, scripts

# The changes and copies that this command has made. Unity ignores names that begin with a dot.
NOTES = f"{TARGET}/.{ML_AGENTS}.json"
MANIFEST = "Packages/manifest.json"
GUID = re.compile(rb"(?<=guid: )[0-9a-f]{32}")
FORCE_TEXT = (
    "it is no text and stays as it is: with ML-Agents still there choose Project Settings, Editor, Asset Serialization,"
    " Force Text, save the project, and run this again"
)
USED = "a scene or a prefab of yours uses it: move it and what it needs, with their .meta, into Assets; run this again"


class Plan:
    """All that would change in a project, and all that stays for a person."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.edits: dict[str, list[Edit]] = {}
        self.left: list[str] = []
        self.lines: list[str] = []
        self.notes_of_lfs: list[str] = []
        self.guids = ml_agents.guids(root)
        copies = sorted(set(copies_of_ml_agents(root)))
        files = list(own_files(root, copies))
        scenes = [root / name for name in files if name.endswith(SCENES)] if copies else []
        named = {guid for path in scenes for guid in GUID.findall(path.read_bytes())}
        for copy in copies:
            self.left += [f"{name}: {USED}" for name in added(root, copy, named)]
            self.left.append(f"{copy}: this is ML-Agents itself: delete it in Unity")
        texts = {name: decoded((root / name).read_bytes()) for name in files if name.endswith(".cs")}
        own = set[str]().union(*map(ml_agents.namespaces, texts.values()))
        everything = "\n".join(texts.values())
        old = "using MLAgents" in everything and "Unity.MLAgents" not in everything
        for name, text in texts.items():
            self.add(name, text, ml_agents.csharp(text, own, old), "name")
        for name in files:
            self.other(name)
        if self.notes_of_lfs:
            more = f" and {len(self.notes_of_lfs) - 1} more" if len(self.notes_of_lfs) > 1 else ""
            what = "only Git LFS's note of it is here: run git lfs pull, and this again"
            self.left.append(f"{self.notes_of_lfs[0]}{more}: {what}")
        # Of a project that never had ML-Agents nothing is taken away; a copy of ML-Agents needs what it needs.
        self.packages = Leaving(set(), {}, [])
        if self.edits or copies or dependencies(root).keys() & PACKAGES:
            after = self.scripts_after(texts)
            self.packages = self.packages if copies else leaving(root, after)
            self.left += [*self.packages.notes, *left_behind(root, files, after)]
        if self.packages.removed and (root / MANIFEST).is_symlink():
            self.left.append(f"{MANIFEST}: it is a link: remove {', '.join(sorted(self.packages.removed))} by hand")
            self.packages = Leaving(set(), {}, [])
        if self.packages.removed:
            kept = f", with {', '.join(sorted(self.packages.kept))}" if self.packages.kept else ""
            self.lines.append(f"{MANIFEST}: without {', '.join(sorted(self.packages.removed))}{kept}")

    def scripts_after(self, texts: dict[str, str]) -> dict[str, str]:
        return {
            name: ml_agents.without_quiet(decoded(applied((self.root / name).read_bytes(), self.edits.get(name, []))))
            for name in texts
        }

    def add(self, name: str, text: str, found: ml_agents.Found, what: str) -> None:
        if found.edits:
            self.edits[name] = sorted(found.edits)
            parts = ", ".join(f"{kind} {count}" for kind, count in sorted(found.components.items()))
            count = found.components.total() or len(found.edits)
            plural = "s" if count > 1 else ""
            self.lines.append(f"{name}: {count} {what}{plural}{f' ({parts})' if parts else ''}")
        for note in sorted(found.notes):
            line = text.count("\n", 0, note.at) + 1
            self.left.append(f"{name}:{line}: {note.text}")

    def other(self, name: str) -> None:
        path = self.root / name
        if name.endswith(SCENES):
            data = path.read_bytes()
            if data.startswith(b"version https://git-lfs"):
                self.notes_of_lfs.append(name)
            elif data.removeprefix(b"\xef\xbb\xbf").startswith(b"%YAML"):
                self.add(name, decoded(data), ml_agents.yaml(decoded(data), self.guids), "component")
            elif ml_agents.in_binary(data):
                self.left.append(f"{name}: {FORCE_TEXT}")
        elif name.endswith(".asmdef"):
            text = decoded(path.read_bytes())
            self.add(name, text, ml_agents.asmdef(text, own_guid(ml_agents.ASSEMBLY)), "reference")
        elif name.endswith(".asmref") and re.search(r"Unity\.ML-Agents|85e0054f8e64b", decoded(path.read_bytes())):
            self.left.append(f"{name}: it adds to ML-Agents' own assembly: delete it")

    def do(self, force: bool, scripts_only: bool, dlls: Path | None) -> None:
        """Copy the kit and write the files, after noting down how to take it back."""
        root = self.root
        refuse_read_only(root, self.files())
        before = {name: (root / name).read_bytes() for name in {*self.files(), MANIFEST} if (root / name).exists()}
        there = {*read_json(root / RECORD)}
        removed, kept, _ = self.packages
        install(root, ML_AGENTS, force, scripts_only, dlls, self.inventory())
        files = {name: applied(before[name], edits) for name, edits in self.edits.items()}
        edits = dict(self.edits)
        if MANIFEST in before:
            data = (root / MANIFEST).read_bytes()
            files[MANIFEST] = with_packages(data.decode(), kept, removed).encode() if removed else data
            edits[MANIFEST] = difference(before[MANIFEST], files[MANIFEST])
        entries = {
            name: {"before": checksum(before[name]), "after": checksum(data), "edits": edits[name]}
            for name, data in files.items()
            if data != before[name]
        }
        copied = sorted(read_json(root / RECORD).keys() - there)
        if not entries and not copied:
            return
        notes = read_json(root / NOTES)
        notes.setdefault("moves", []).append({"files": entries, "copied": copied})
        (root / NOTES).write_text(json.dumps(notes, indent=1), encoding="utf-8")
        place(root, {name: files[name] for name in entries})
        for line in self.lines:
            say(f"changed {line}")
        say(f"changed {len(entries)} files; `{KIT} unity PATH --from {ML_AGENTS} --undo` takes it back")

    def files(self) -> list[str]:
        return [*self.edits, *([MANIFEST] if self.packages.removed else [])]

    def inventory(self) -> Inventory:
        return Inventory(self.root, self.packages.removed, self.packages.kept.keys())

    def refusal(self) -> str:
        """The reason for which it could not be done; empty if there is none."""
        try:
            prepare(self.root, ML_AGENTS, self.inventory())
            refuse_read_only(self.root, self.files())
        except KitError as error:
            return str(error)
        return ""


def move_in(project: Path, yes: bool, force: bool, scripts_only: bool, dlls: Path | None) -> None:
    """Say what would change and what cannot; and change it, if it is told so."""
    root = find_project(project)
    if is_link(root / "Assets"):
        raise KitError(
            f"Assets is a link to {(root / 'Assets').resolve()}: nothing was changed; name the project there"
        )
    plan = Plan(root)
    if not plan.lines:
        say("nothing to change: no file here names ML-Agents any more")
    # The kit's own files may be others by now: Unity has fetched packages that bring DLLs.
    if yes and (plan.lines or (root / NOTES).exists()):
        plan.do(force, scripts_only, dlls)
    elif plan.lines:
        for line in plan.lines:
            say(f"would change {line}")
        count = sum(name.endswith(".cs") for name in scripts(ML_AGENTS))
        say(f"would copy {count} scripts into {TARGET}, and NetMQ's DLLs")
        plan.left += advice(root)
    for line in plan.left:
        say(f"left for you: {line}")
    if not yes and plan.lines:
        refusal = plan.refusal()
        then = "commit the project, then add --yes; --undo takes it back"
        say(f"nothing was changed yet: {f'--yes will refuse: {refusal}' if refusal else then}")


def undo(project: Path, force: bool) -> None:
    """Take back all that `--yes` has done, from its own notes; `force` leaves out the files that were changed since."""
    root = find_project(project)
    moves = read_json(root / NOTES).get("moves") or []
    if not moves:
        raise KitError(f"there is no {NOTES}: nothing was moved in here, or it was undone already")
    changed: set[str] = set()
    files: dict[str, bytes] = {}
    for move in reversed(moves):
        for name, entry in move["files"].items():
            if name not in changed and not take_back(root, name, entry, files):
                changed.add(name)
    if changed and not force:
        more = f" (and {len(changed) - 1} more)" if len(changed) > 1 else ""
        raise KitError(f"{min(changed)}{more} was changed since: nothing was undone; --force undoes the others")
    files = {name: data for name, data in files.items() if name not in changed}
    refuse_read_only(root, files)
    place(root, files)
    for name in files:
        say(f"as it was: {name}")
    for name in sorted(changed):
        say(f"left for you: {name} was changed since, and stays")
    remove(root, [name for move in moves for name in move["copied"]])


def take_back(root: Path, name: str, entry: dict[str, Any], files: dict[str, bytes]) -> bool:
    """Add one file as it was to `files`; False if it is not as it was left."""
    path = root / name
    # The notes come with the project, and so from anybody.
    if ".." in Path(name).parts or not path.resolve().is_relative_to(root.resolve()) or not path.is_file():
        return False
    data = files.get(name, path.read_bytes())
    try:
        if checksum(data) == entry["after"]:
            files[name] = applied(data, reversed_(Edit(*edit) for edit in entry["edits"]))
        return bool(checksum(files.get(name, data)) == entry["before"])
    except ValueError:
        return False


def remove(root: Path, copied: list[str]) -> None:
    """Delete the kit's files that this command has brought, but for those that were changed; and its notes."""
    record = read_json(root / RECORD)
    (root / NOTES).unlink()
    count = len(list(delete(root, record, [name for name in copied if name in record])))
    if record:
        (root / RECORD).write_text(json.dumps(record, indent=1, sort_keys=True), encoding="utf-8")
    else:
        (root / RECORD).unlink(missing_ok=True)
        if not any((root / TARGET).iterdir()):
            (root / TARGET).rmdir()
    say(f"deleted {count} files of the kit")


def added(root: Path, copy: str, named: Set[bytes]) -> Iterator[str]:
    """The files that somebody has added to a copy of ML-Agents, and that have one of these GUIDs."""
    for name in walk(root, copy):
        guid = name.endswith(".meta") and GUID.search((root / name).read_bytes())
        if guid and guid[0] in named and guid[0].decode() not in ml_agents.FACTS["scripts"]:
            yield name.removesuffix(".meta")


def refuse_read_only(root: Path, files: Iterable[str]) -> None:
    for name in files:
        if not os.access(root / name, os.W_OK):
            raise KitError(f"{name} is read-only: nothing was changed; check it out first, or clear the attribute")
