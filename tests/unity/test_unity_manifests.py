"""Every scene, prefab and settings file, read by unityparser: what they refer to exists, and so does what they set.

The same checks are then held to broken copies, each of which they must refuse.
"""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from kitlib.unity.install import LIBRARIES
from kitlib.unity.meta import PACKAGE, PREFAB
from tests.programs import ROOT

UNITY = ROOT / "unity"
FILES = sorted(
    path for kind in ("*.unity", "*.prefab", "*.asset") for path in UNITY.rglob(kind) if "Library" not in path.parts
)
# What Unity has built in, by the GUID of its library: the font and its ink. Its grey material is magenta in URP.
BUILT_IN = {"0" * 16 + "e" + "0" * 15: {"10102", "10100"}}
# A script's only object.
SCRIPT = "11500000"
# What Unity itself writes into a MonoBehaviour, beside the fields of its class.
UNITYS_FIELDS = {"anchor", "extra_anchor_data", "m_ObjectHideFlags", "m_GameObject", "m_Enabled", "m_EditorHideFlags"}
UNITYS_FIELDS |= {"m_Script", "m_Name", "m_EditorClassIdentifier"}
CLASS = r"\bclass {}\b(?:<\w+>)?(?: : (\w+))?"


def relative(path: Path) -> str:
    return path.relative_to(UNITY).as_posix()


@functools.cache
def scripts() -> dict[str, Path]:
    """Each script of the package by the GUID in its .meta."""
    metas = {path: path.with_name(f"{path.name}.meta").read_text(encoding="utf-8") for path in PACKAGE.rglob("*.cs")}
    return {re.search(r"^guid: (\w+)$", meta, re.MULTILINE)[1]: path for path, meta in metas.items()}


@functools.cache
def declaration(name: str) -> tuple[str, str | None]:
    """The code of the file that has this class, and its base class."""
    for path in PACKAGE.rglob("*.cs"):
        # Without texts and comments, in which anything may stand.
        code = re.sub(r'"(?:[^"\\\n]|\\.)*"|//.*', "", path.read_text(encoding="utf-8"))
        if found := re.search(CLASS.format(name), code):
            return code, found[1]
    return "", None


def lineage(name: str | None) -> Iterator[tuple[str, str]]:
    """A class and those that it derives from, as far as they are the package's; the last one is Unity's."""
    while name:
        code, base = declaration(name)
        yield name, code
        name = base


def serialized(code: str) -> set[str]:
    """The fields that Unity writes into a scene: those with SerializeField, and public ones."""
    marked = re.findall(r"\[SerializeField\b[^;=]*?\s(\w+)(?: = [^;]*)?;", code)
    return {
        *marked,
        *re.findall(r"^ {8}public (?!static|const|readonly)[\w<>\[\]]+ (\w+)(?: = [^;]*)?;", code, re.MULTILINE),
    }


def references(value: Any) -> Iterator[dict[str, str]]:
    """Each {fileID: …} somewhere in an object."""
    if isinstance(value, dict):
        if "fileID" in value:
            yield value
        value = list(value.values())
    if isinstance(value, list):
        for part in value:
            yield from references(part)


def faults(path: Path) -> list[str]:
    """What Unity would not find; nothing, if all is well."""
    unityparser = pytest.importorskip("unityparser", reason="unityparser is not installed: pip install unityparser")
    entries = unityparser.UnityDocument.load_yaml(str(path)).entries
    own, known, found = {entry.anchor for entry in entries}, scripts(), []
    for entry in entries:
        kind = entry.__class__.__name__
        for one in references(vars(entry)):
            number, guid = str(one["fileID"]), one.get("guid")
            if guid is None and number not in own | {"0"}:
                found.append(f"{kind} {entry.anchor} refers to {number}, which is not there")
            elif guid is not None and number not in BUILT_IN.get(guid, {SCRIPT} if guid in known else ()):
                found.append(f"{kind} {entry.anchor} refers to {number} of {guid}, which nothing has")
        if kind == "MonoBehaviour" and (script := known.get(entry.m_Script.get("guid"))):
            line = dict(lineage(script.stem))
            if "MonoBehaviour" not in line:
                found.append(f"{script.name} has no MonoBehaviour {script.stem}")
            unknown = vars(entry).keys() - UNITYS_FIELDS - {name for code in line.values() for name in serialized(code)}
            found += [f"{script.stem} has no field {name}" for name in sorted(unknown)]
    return found


@pytest.mark.parametrize("path", FILES, ids=relative)
def test_what_a_file_refers_to_exists(path: Path) -> None:
    assert faults(path) == []


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("component: {fileID: 202}", "component: {fileID: 999}", "GameObject 200 refers to 999, which is not there"),
        ("fileID: 10102", "fileID: 10103", "TextMesh 402 refers to 10103 of 0000000000000000e000000000000000, which"),
        ("  client: ", "  clint: ", "ClientHud has no field clint"),
        ("{script}", "0" * 31 + "1", "MonoBehaviour 202 refers to 11500000 of 00000000000000000000000000000001, which"),
        ("{script}", "{other}", "LazyPirateRequester.cs has no MonoBehaviour LazyPirateRequester"),
    ],
)
def test_a_broken_copy_is_refused(old: str, new: str, fault: str, tmp_path: Path) -> None:
    by_name = {path.name: guid for guid, path in scripts().items()}
    for mark, name in (("{script}", "HelloBackground.cs"), ("{other}", "LazyPirateRequester.cs")):
        old, new = old.replace(mark, by_name[name]), new.replace(mark, by_name[name])
    text = PREFAB.read_text(encoding="utf-8")
    assert text.count(old) == 1
    copy = tmp_path / PREFAB.name
    copy.write_text(text.replace(old, new), encoding="utf-8")
    assert any(one.startswith(fault) for one in faults(copy)), faults(copy)


def test_an_assembly_names_only_dlls_that_are_there() -> None:
    there = {inside.rsplit("/", 1)[1] for _, _, inside in LIBRARIES} | {"nunit.framework.dll", "Newtonsoft.Json.dll"}
    for path in PACKAGE.rglob("*.asmdef"):
        definition = json.loads(path.read_text(encoding="utf-8"))
        assert set(definition["precompiledReferences"]) <= there, path.name
        # A .meta of Unity's own kind: with another importer it would be a text.
        assert "AssemblyDefinitionImporter:" in path.with_name(f"{path.name}.meta").read_text(encoding="utf-8")
    meta = (PACKAGE / "package.json.meta").read_text(encoding="utf-8")
    assert "PackageManifestImporter:" in meta
