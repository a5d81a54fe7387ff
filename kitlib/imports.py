"""A program's needs, of the kit and of other packages, are read from its imports, and from nothing else.

An import names a module, and needs the `__init__.py` of each folder on its way as well. A name that such a folder's
door lends, as in `from netmq_example import Server`, needs the module that the door has for it.
"""

from __future__ import annotations

import ast
import functools
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from kitlib.lessons import ROOT, parsed

PYTHON = ROOT / "python"
IMPORT_NAME = "netmq_example"
# The doors of a copy have their own way to load a name: see kitlib/doors.py.
DOORS = f"{IMPORT_NAME}.doors"


@dataclass
class Source:
    """A file's imports, each with the function around it or "", and the names and texts that it uses."""

    imports: list[tuple[str, str]] = field(default_factory=list)
    names: set[str] = field(default_factory=set)
    texts: set[str] = field(default_factory=set)


@functools.cache
def file_of(module: str, importer: Path) -> Path | None:
    """The file of a module of the package, or of one beside a program."""
    if module.split(".")[0] == IMPORT_NAME:
        path = PYTHON.joinpath(*module.split("."))
    elif importer.is_relative_to(PYTHON / IMPORT_NAME):
        return None
    else:
        path = importer.parent.joinpath(*module.split("."))
    return next((file for file in (path / "__init__.py", path.with_suffix(".py")) if file.is_file()), None)


@functools.cache
def rooms(init: Path) -> dict[str, str]:
    """The names that a door lends, each with its module: a type checker reads them from the same lines."""
    found: dict[str, str] = {}
    for node in parsed(init).body:
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            for line in node.body:
                if isinstance(line, ast.ImportFrom) and line.names[0].name == "*":
                    found |= rooms(init.with_name(str(line.module).rpartition(".")[2] + ".py"))
                elif isinstance(line, ast.ImportFrom):
                    found |= {each.name: str(line.module) for each in line.names if each.name != "__all__"}
    return found


def needed(module: str, name: str, importer: Path) -> str:
    """The module that `from module import name` needs."""
    if file_of(f"{module}.{name}", importer):
        return f"{module}.{name}"
    file = file_of(module, importer)
    room = rooms(file).get(name) if file and file.name == "__init__.py" else None
    return room or module


def is_optional(node: ast.Try) -> bool:
    """Whether all that is tried is an import of the kit's own."""
    return all(isinstance(each, ast.ImportFrom) and str(each.module).startswith(IMPORT_NAME) for each in node.body)


@functools.cache
def read(path: Path) -> Source:
    source = Source()

    def visit(node: ast.AST, function: str) -> None:
        match node:
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                function = node.name
            case ast.If(test=ast.Name(id="TYPE_CHECKING")) | ast.ImportFrom(module="netmq_example.doors"):
                # The first is for a type checker alone, and no copy needs the second.
                return
            case ast.Try(handlers=[ast.ExceptHandler(type=ast.Name(id="ModuleNotFoundError"))]) if is_optional(node):
                # It does without this module, unless something else brings it along.
                return
            case ast.Import():
                source.imports += [(function, each.name) for each in node.names]
            case ast.ImportFrom(module=str(module)):
                source.imports += [(function, needed(module, each.name, path)) for each in node.names]
            case ast.Name():
                source.names.add(node.id)
            case ast.Attribute():
                source.names.add(node.attr)
            case ast.Constant(value=str(text)):
                source.texts.add(text)
        for child in ast.iter_child_nodes(node):
            visit(child, function)

    visit(parsed(path), "")
    return source


def modules(files: Iterable[Path]) -> list[Path]:
    """These files, and all of the kit that they import, directly or through others."""
    found = dict.fromkeys(files)
    todo = list(found)
    for path in todo:
        for _, name in read(path).imports:
            if target := file_of(name, path):
                new = [each for each in (*inits(target), target) if each not in found]
                found |= dict.fromkeys(new)
                todo += new
    return list(found)


@functools.cache
def inits(module: Path) -> list[Path]:
    """The `__init__.py` of each folder from the package's down to a module of it."""
    folders = [folder for folder in reversed(module.parents) if folder.is_relative_to(PYTHON / IMPORT_NAME)]
    return [folder / "__init__.py" for folder in folders if folder / "__init__.py" != module]


def data(files: Iterable[Path]) -> list[Path]:
    """The web pages that these read from their own folder: each is named by one of their texts. A journal that one of
    their texts names was left there by a server.
    """
    found = [
        path.with_name(text) for path in files for text in read(path).texts if re.fullmatch(r"[\w-]{1,100}\.html", text)
    ]
    return sorted({path for path in found if path.is_file()})


def packages(files: Iterable[Path]) -> set[str]:
    """The modules of other packages that these files need, with the kit's that they import.

    The imports of a function count where something mentions that function: `Array.numpy` imports numpy.
    """
    sources = {path: read(path) for path in modules(files)}
    mentioned = set().union({""}, *(source.names for source in sources.values()))
    found = {
        name.partition(".")[0]
        for path, source in sources.items()
        for function, name in source.imports
        if function in mentioned and not file_of(name, path)
    }
    return found - sys.stdlib_module_names
