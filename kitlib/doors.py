"""The `__init__.py` of a package in a copy: its door has the names of the modules that are there, and no others."""

from __future__ import annotations

import ast
import json
import textwrap
from collections.abc import Collection, Mapping
from pathlib import Path

from kitlib.imports import DOORS, rooms

# In place of the kit's own, which also knows the names that a copy does not have.
LOADS = """
def __getattr__(name):
    if name not in ROOMS:
        raise AttributeError(f"{name} is not in this copy; kit.py copy netmq_example FOLDER brings all of {__name__}")
    return getattr(importlib.import_module(ROOMS[name]), name)

def __dir__():
    return sorted({*globals(), *ROOMS})
"""


def fitted(init: Path, names: Collection[str]) -> bytes:
    """Its text, for a copy with files of these names."""
    text = init.read_text(encoding="utf-8")
    table = rooms(init)
    there = {name: room for name, room in table.items() if has(room, names)}
    if there == table and (not table or has(DOORS, names)):
        return init.read_bytes()
    lines = text.splitlines(keepends=True)
    for node in reversed(ast.parse(text).body):
        new = replaced(node, there, table)
        if new is not None:
            start, end = node.lineno - 1, node.end_lineno or node.lineno
            # A comment goes with the statement that it is about, and so do the blank lines behind it.
            while not new and lines[start - 1].startswith("#"):
                start -= 1
            while not new and end < len(lines) and not lines[end].strip():
                end += 1
            lines[start:end] = [new]
    return "".join(lines).rstrip().encode() + b"\n"


def loads(there: Mapping[str, str]) -> str:
    return textwrap.indent(f"ROOMS = {json.dumps(there, indent=4)}\n{LOADS}", "    ")


def has(module: str, names: Collection[str]) -> bool:
    path = module.replace(".", "/")
    return f"{path}.py" in names or f"{path}/__init__.py" in names


def replaced(node: ast.stmt, there: Mapping[str, str], table: Mapping[str, str]) -> str | None:
    """The lines in place of a statement of the door; None for any other statement, which stays."""
    match node:
        case ast.ImportFrom(module="typing") if not there:
            others = [each.name for each in node.names if each.name != "TYPE_CHECKING"]
            return f"from typing import {', '.join(others)}\n" if others else ""
        case ast.ImportFrom(module="netmq_example.doors"):
            return "import importlib\n" if there else ""
        case ast.Assign(targets=[ast.Name(id="__all__")], value=value):
            names = [name for name in ast.literal_eval(value) if name in there or name not in table]
            return f"__all__ = {json.dumps(names, indent=4)}\n" if names else ""
        case ast.If(test=ast.Name(id="TYPE_CHECKING"), orelse=orelse):
            imports = [f"    from {room} import {name}\n" for name, room in there.items()]
            otherwise = [f"else:\n    __all__ = {sorted(there)}\n{loads(there)}"] if orelse else []
            return "".join(["if TYPE_CHECKING:\n", *imports, *otherwise]) if imports else ""
        case ast.If(test=ast.UnaryOp(operand=ast.Name(id="TYPE_CHECKING"))):
            return f"if not TYPE_CHECKING:\n{loads(there)}" if there else ""
    return None
