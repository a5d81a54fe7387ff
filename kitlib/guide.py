"""Keeps the README and the guide true: python3 -m kitlib.guide rewrites every excerpt and says what stays by hand.

A fenced block says where it comes from in a comment on the line above it:

    <!-- excerpt: python/01_request_reply/server.py answer -->   a function, class or method, by its name
    <!-- run: 1 --client csharp --options='--count 1' -->        what `kit.py run` prints; `...` stands for any lines
    <!-- like: 3 -->                                             the same, but numbers and ids differ from run to run
    <!-- commands -->                                            one command a line, each of which a test starts
    <!-- by hand: why -->                                        neither, and counted

`run` blocks without the prefixes `server |` and `client |` show the client alone.
"""

from __future__ import annotations

import ast
import re
import sys
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from .lessons import ROOT, KitError

BLOCK = re.compile(
    r"(?:<!-- (?P<mark>[^\n]*?) -->\n)?^```(?P<language>\w*)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL
)


@dataclass(frozen=True)
class Block:
    """One fenced block of a page."""

    page: Path
    line: int
    kind: str
    source: str
    language: str
    body: str

    @property
    def where(self) -> str:
        return f"{self.page.relative_to(ROOT).as_posix()}:{self.line}"


def pages() -> list[Path]:
    return [ROOT / "README.md", *sorted((ROOT / "docs" / "guide").glob("*.md"))]


def blocks(page: Path) -> Iterator[Block]:
    text = page.read_text(encoding="utf-8")
    for found in BLOCK.finditer(text):
        kind, _, source = (found["mark"] or "").partition(":")
        line = text.count("\n", 0, found.start()) + 1
        yield Block(page, line, kind.strip(), source.strip(), found["language"], found["body"])


def excerpt(source: str) -> str:
    """The text of `path name`: a Python function or class, or a C# type or member, without its indentation."""
    path, _, name = source.partition(" ")
    text = (ROOT / path).read_text(encoding="utf-8")
    found = python_excerpt(text, name) if path.endswith(".py") else csharp_excerpt(text, name)
    if found is None:
        raise KitError(f"there is no {name} in {path}")
    return textwrap.dedent(found).rstrip() + "\n"


def python_excerpt(text: str, name: str) -> str | None:
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            return "\n".join(text.splitlines()[node.lineno - 1 : node.end_lineno])
    return None


def csharp_excerpt(text: str, name: str) -> str | None:
    """From the line that declares the name to its closing brace or semicolon, with no XML documentation."""
    lines = text.splitlines()
    declares = re.compile(rf"^\s*(public|private|internal|protected)\b[^=;(]*\b{name}\b")
    start = next((i for i, line in enumerate(lines) if declares.match(line)), None)
    if start is None:
        return None
    depth = 0
    for i in range(start, len(lines)):
        depth += lines[i].count("{") - lines[i].count("}")
        if depth == 0 and lines[i].rstrip().endswith((";", "}")):
            return "\n".join(lines[start : i + 1])
    return None


def rewritten(page: Path) -> str:
    """The page with every excerpt as its file has it now."""

    def replace(found: re.Match[str]) -> str:
        kind, _, source = (found["mark"] or "").partition(":")
        if kind.strip() != "excerpt":
            return found[0]
        start, end = (place - found.start() for place in found.span("body"))
        return found[0][:start] + excerpt(source.strip()) + found[0][end:]

    return BLOCK.sub(replace, page.read_text(encoding="utf-8"))


def main() -> None:
    by_hand = 0
    for page in pages():
        page.write_text(rewritten(page), encoding="utf-8")
        by_hand += sum(block.kind == "by hand" for block in blocks(page))
    print(f"{len(pages())} pages; {by_hand} blocks by hand")


if __name__ == "__main__":
    try:
        main()
    except KitError as error:
        sys.exit(str(error))
