"""What a program needs of the kit and of other packages, read from its imports.

An import names a module, and needs the `__init__.py` of each folder on its way as well. A text may name one, too:
"netmq_example.envs.gym_env:ZmqEnv", as Gymnasium's registry has it.
"""

from __future__ import annotations

import ast
import functools
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from kitlib.lessons import ROOT

PYTHON = ROOT / "python"
PACKAGE = "netmq_example"


@dataclass
class Source:
    """What one file names: modules by the function whose body imports them, "" where none does, and everything else."""

    imports: list[tuple[str, str]] = field(default_factory=list)
    names: set[str] = field(default_factory=set)
    texts: set[str] = field(default_factory=set)


@functools.cache
def file_of(module: str, importer: Path) -> Path | None:
    """The file of a module of the package, or of one beside a program."""
    if module.split(".")[0] == PACKAGE:
        path = PYTHON.joinpath(*module.split("."))
    elif importer.is_relative_to(PYTHON / PACKAGE):
        return None
    else:
        path = importer.parent.joinpath(*module.split("."))
    return next((file for file in (path / "__init__.py", path.with_suffix(".py")) if file.is_file()), None)


@functools.cache
def origin(module: str, name: str, importer: Path) -> str:
    """The module that `from module import name` needs: its own, where an `__init__` only lends it."""
    if file_of(f"{module}.{name}", importer):
        return f"{module}.{name}"
    file = file_of(module, importer)
    if file and file.name == "__init__.py":
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and name in [each.name for each in node.names]:
                return origin(str(node.module), name, importer)
    return module


@functools.cache
def read(path: Path) -> Source:
    source = Source()

    def visit(node: ast.AST, function: str) -> None:
        match node:
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                function = node.name
            case ast.If(test=ast.Name(id="TYPE_CHECKING")):
                # The names that __getattr__ has, for a type checker.
                function = "__getattr__"
            case ast.Call(func=ast.Attribute(attr="getLogger")):
                # A logger has a module's name, and needs none.
                return
            case ast.Import():
                source.imports += [(function, each.name) for each in node.names]
            case ast.ImportFrom(module=str(module)):
                source.imports += [(function, origin(module, each.name, path)) for each in node.names]
            case ast.Name():
                source.names.add(node.id)
            case ast.Attribute():
                source.names.add(node.attr)
            case ast.Constant(value=str(text)):
                source.texts.add(text)
        for child in ast.iter_child_nodes(node):
            visit(child, function)

    visit(ast.parse(path.read_text(encoding="utf-8"), str(path)), "")
    return source


def modules(files: Iterable[Path], named: bool = True) -> list[Path]:
    """These files, and all of the kit that they import, directly or through others.

    With `named` also what texts name, such as an environment of Gymnasium's registry, and what `__getattr__` imports.
    Only those of a package that is imported itself: one that is on the way to a module of it would bring all it has.
    """
    found = {(path, True): None for path in files}
    todo = list(found)
    for path, itself in todo:
        source, whole = read(path), itself and named
        wanted = [name for function, name in source.imports if whole or function != "__getattr__"]
        if whole:
            texts = [text for text in source.texts if re.fullmatch(rf"{PACKAGE}(\.\w+)+(:\w+)?", text)]
            wanted += [text.partition(":")[0] for text in texts]
        for name in wanted:
            if target := file_of(name, path):
                on_the_way = [(init, False) for init in inits(target) if init != target]
                new = [each for each in (*on_the_way, (target, True)) if each not in found]
                found.update(dict.fromkeys(new))
                todo += new
    return list(dict.fromkeys(path for path, _ in found))


def inits(module: Path) -> Iterator[Path]:
    """The `__init__.py` of each folder from the package's down to a module of it."""
    for folder in reversed(module.parents):
        if folder.is_relative_to(PYTHON / PACKAGE):
            yield folder / "__init__.py"


def data(files: Iterable[Path]) -> list[Path]:
    """What these read from their own folder, such as a page: a file whose name is one of their texts."""
    found = [
        path.with_name(text)
        for path in files
        for text in read(path).texts
        if re.fullmatch(r"[\w-]{1,100}\.\w{1,10}", text)
    ]
    return sorted({path for path in found if path.is_file() and path.suffix != ".py"})


def packages(files: Iterable[Path]) -> set[str]:
    """The modules of other packages that these files need, with the kit's that they import.

    What a function imports counts where something mentions that function: `Array.numpy` imports numpy.
    """
    sources = {path: read(path) for path in modules(files, named=False)}
    mentioned = set().union({""}, *(source.names for source in sources.values()))
    found = {
        name.partition(".")[0]
        for path, source in sources.items()
        for function, name in source.imports
        if function in mentioned and not file_of(name, path)
    }
    return found - sys.stdlib_module_names
