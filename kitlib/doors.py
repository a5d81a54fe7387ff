"""The `__init__.py` of a package in a copy: its door has the names of the modules that are there, and no others."""

from __future__ import annotations

import ast
import json
import textwrap
from collections.abc import Collection, Mapping
from pathlib import Path

from kitlib.imports import DOORS, PYTHON, rooms


def fitted(init: Path, names: Collection[str]) -> bytes:
    """Its text, for a copy with files of these names. Without doors.py there is no door at all."""
    text = init.read_text(encoding="utf-8")
    table, package = rooms(init), ".".join(init.parent.relative_to(PYTHON).parts)
    there = {name: room for name, room in table.items() if has(DOORS, names) and has(room, names)}
    if there == table:
        return init.read_bytes()
    lines = text.splitlines(keepends=True)
    for node in reversed(ast.parse(text).body):
        new = replaced(node, package, there, table)
        if new is not None:
            start, end = node.lineno - 1, node.end_lineno or node.lineno
            # A comment goes with the statement that it is about, and so do the blank lines behind it.
            while not new and lines[start - 1].startswith("#"):
                start -= 1
            while not new and end < len(lines) and not lines[end].strip():
                end += 1
            lines[start:end] = [new]
    return "".join(lines).rstrip().encode() + b"\n"


def has(module: str, names: Collection[str]) -> bool:
    path = module.replace(".", "/")
    return f"{path}.py" in names or f"{path}/__init__.py" in names


def replaced(node: ast.stmt, package: str, there: Mapping[str, str], table: Mapping[str, str]) -> str | None:
    """The lines in place of a statement of the door; None for any other statement, which stays."""
    match node:
        case ast.ImportFrom(module="typing") if not there:
            others = [each.name for each in node.names if each.name != "TYPE_CHECKING"]
            return f"from typing import {', '.join(others)}\n" if others else ""
        case ast.ImportFrom(module="netmq_example.doors") if not there:
            return ""
        case ast.Assign(targets=[ast.Name(id="__all__")], value=value):
            names = [name for name in ast.literal_eval(value) if name in there or name not in table]
            return f"__all__ = {json.dumps(names, indent=4)}\n" if names else ""
        case ast.If(test=ast.Name(id="TYPE_CHECKING")):
            imports = [f"    from {room} import {name}\n" for name, room in there.items()]
            return "".join(["if TYPE_CHECKING:\n", *imports]) if imports else ""
        case ast.If(test=ast.UnaryOp(operand=ast.Name(id="TYPE_CHECKING"))):
            return hidden(package, there) if there else ""
    return None


def hidden(package: str, there: Mapping[str, str]) -> str:
    """The table for Python itself, in the form that the kit's own have."""
    found: dict[str, list[str]] = {}
    for name, room in there.items():
        found.setdefault(room.removeprefix(f"{package}."), []).append(name)
    table = json.dumps({room: " ".join(names) for room, names in found.items()}, indent=4)
    lines = f"ROOMS = {table}\n__getattr__, __dir__ = door(__name__, ROOMS)\n"
    return "if not TYPE_CHECKING:\n" + textwrap.indent(lines, "    ")
