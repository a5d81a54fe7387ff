"""Keeps the README and the guide true.

    python3 -m kitlib.docs.guide                   rewrites every excerpt, and every transcript that a run contradicts
    python3 -m kitlib.docs.guide --excerpts        the excerpts alone, which takes no time
    python3 -m kitlib.docs.guide docs/guide/X.md   these pages alone

A fenced block says where it comes from in a comment on the line above it:

    <!-- excerpt: python/01_request_reply/server.py answer -->   a function, class or method, by its name
    <!-- run: 1 --client csharp --options='--count 1' -->        what `kit.py run` prints; `...` stands for any lines
    <!-- like: 3 -->                                             the same, but numbers and ids differ from run to run
    <!-- bench: echo of 32 B | a second, p50 us -->              a table of the lab, which lab/report.py rewrites
    <!-- commands -->                                            one command a line, each of which a test starts
    <!-- diagram -->                                             a sequence diagram, whose grammar a test checks
    <!-- by hand: why -->                                        none of these, and counted

`run` and `like` blocks without the prefixes `server |` and `client |` show the client alone. A transcript that is
rewritten keeps as many lines before its first `...` and after its last one as it had; what stood between is gone.
"""

import argparse
import ast
import difflib
import functools
import re
import shlex
import sys
import tempfile
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from kitlib.commands import guarded
from kitlib.lessons import ROOT, KitError, find
from kitlib.programs import quietly

BLOCK = re.compile(
    r"(?:<!-- (?P<mark>[^\n]*?) -->\n)?^```(?P<language>\w*)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL
)
SIDES = ("server", "client")
LIMIT = 500


@dataclass(frozen=True)
class Block:
    page: Path
    line: int
    kind: str
    source: str
    language: str
    body: str
    # The place of the body in the page's text.
    start: int

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
        yield Block(page, line, kind.strip(), source.strip(), found["language"], found["body"], found.start("body"))


def excerpt(source: str) -> str:
    """The text of `path name`: a Python function or class, or a C# type or member, without its indentation."""
    path, _, name = source.partition(" ")
    text = (ROOT / path).read_text(encoding="utf-8")
    found = (python_lines if path.endswith(".py") else csharp_lines)(text, name)
    if found is None:
        raise KitError(f"there is no {name} in {path}: correct the comment above the excerpt")
    return textwrap.dedent("\n".join(text.splitlines()[found.start : found.stop])).rstrip() + "\n"


def python_lines(text: str, name: str) -> range | None:
    """The lines of a function or class, counted from 0. It begins at its first decorator: who pastes it needs them."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and node.name == name:
            first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
            return range(first - 1, node.end_lineno or first)
    return None


def csharp_lines(text: str, name: str) -> range | None:
    """From the attributes of the line that declares the name to its closing brace or semicolon, counted from 0.

    What is abstract has nothing to show.
    """
    lines = text.splitlines()
    attribute = r"\[[^\]]*\]\s*"
    declares = re.compile(
        rf"^\s*({attribute})*(public|private|internal|protected)\b(?! abstract)[^=;(]*\b{re.escape(name)}\b"
    )
    found = [i for i, line in enumerate(lines) if declares.match(line)]
    if not found:
        return None
    # Attributes stand above it, and above them XML documentation, which is left out.
    start = above = end = found[0]
    while above and not re.search(r"[;{}]|^\s*///|^\s*$", re.sub(r'"[^"]*"', "", lines[above - 1])):
        above -= 1
        if lines[above].lstrip().startswith("["):
            start = above
    depth = 0
    for i in range(end, len(lines)):
        depth += lines[i].count("{") - lines[i].count("}")
        if depth == 0 and lines[i].rstrip().endswith((";", "}")):
            return range(start, i + 1)
    return None


@functools.cache
def folder() -> tempfile.TemporaryDirectory[str]:
    """Where the runs of a page leave their files, such as lesson 02's journal; the reader's own are left alone."""
    return tempfile.TemporaryDirectory(prefix="kit-")


def run_command(source: str) -> list[str | Path]:
    """The words that start `kit.py run SOURCE`, on ports that are free and in a folder that will go."""
    words = shlex.split(source)
    apart = ["--endpoint", find(words[0]).anywhere, "--folder", folder().name]
    return [sys.executable, ROOT / "kit.py", "run", *words, *apart]


@functools.cache
def printed(source: str) -> tuple[str, ...]:
    """The lines that `kit.py run SOURCE` prints, with the ports that the lesson has by default."""
    result = quietly(run_command(source), LIMIT, {"PYTHONUNBUFFERED": "1"}, ROOT)
    if result.code not in (0, 1):
        raise KitError(f"`kit.py run {source}` ended with {result.code}; it printed {result.output}")
    return tuple(with_own_ports(result.output, source).splitlines())


def with_own_ports(output: str, source: str) -> str:
    """A run takes free ports. Its ready line names the lesson's own; what else listens has the port 100 higher."""
    port = find(shlex.split(source)[0]).port
    found = re.findall(r"\b(\w+) on (?:tcp|http)://127\.0\.0\.1:(\d+)", output)
    ports = {free: str(port + (0 if name == "listening" else 100)) for name, free in found}
    return re.sub(r"(?<=p://127\.0\.0\.1:)\d+", lambda one: ports.get(one[0], one[0]), output)


def said(lines: Sequence[str], side: str) -> list[str]:
    """The lines of one side, without its prefix; the author's `...` stands for lines of both."""
    return [re.sub(rf"^{side} \| ?", "", line) for line in lines if line == "..." or line.startswith(f"{side} |")]


def has_prefixes(lines: Sequence[str]) -> bool:
    return any(line.startswith(tuple(f"{side} |" for side in SIDES)) for line in lines)


def sides(block: Block, lines: Sequence[str]) -> Iterator[tuple[str, list[str], list[str]]]:
    """Each side of a transcript: its name, the lines that are shown, and those that a run printed."""
    shown = block.body.splitlines()
    for side in SIDES if has_prefixes(shown) else ["client"]:
        yield side, said(shown, side) if has_prefixes(shown) else shown, said(lines, side)


def comparable(block: Block, lines: Sequence[str]) -> list[str]:
    return shape(lines) if block.kind == "like" else list(lines)


def contradiction(block: Block, lines: Sequence[str]) -> str:
    """How a transcript differs from what a run printed, or nothing. How the two sides mix does not count."""
    for side, *both in sides(block, lines):
        expected, found = (comparable(block, each) for each in both)
        if not same(expected, found):
            return "\n".join([f"the {side} prints something else:", *difflib.ndiff(expected, found)])
    return ""


def first_difference(block: Block, lines: Sequence[str]) -> str:
    """The first line of a transcript that a run has not printed, or nothing: by the same rule."""
    for side, shown, heard in sides(block, lines):
        expected, found = comparable(block, shown), comparable(block, heard)
        for number, line in enumerate(expected):
            if not same([*expected[: number + 1], "..."], found):
                return f"{side}: the page has {next(text for text in shown if comparable(block, [text]) == [line])}"
        if not same(expected, found):
            return f"{side}: the page does not have {heard[-1]}"
    return ""


def verdict(page: Path, words: Sequence[str], lines: Sequence[str]) -> dict[str, str | bool]:
    """Whether a command of kit.py printed what the page shows of it, if it shows any of it."""
    for block in blocks(page):
        if block.kind in ("run", "like") and ["run", *shlex.split(block.source)] == words:
            difference = first_difference(block, with_own_ports("\n".join(lines), block.source).splitlines())
            told = "printed as on this page" + ", numbers aside" * (block.kind == "like")
            return {"verdict": difference or told, "good": not difference}
    return {"verdict": "ended"}


def same(expected: Sequence[str], found: Sequence[str]) -> bool:
    """True if the lines are equal, where a line `...` stands for any number of lines."""
    pattern = "".join("(.*\n)*?" if line == "..." else re.escape(line) + "\n" for line in expected)
    return re.fullmatch(pattern, "".join(f"{line}\n" for line in found)) is not None


def shape(lines: Sequence[str]) -> list[str]:
    """The lines with every number, id and key replaced, and what repeats itself said once.

    In a column a number with one digit more has one space less before it, which is no other text. An id is hexadecimal,
    and now and then it has only digits.
    """
    # A key of lesson 15 has 40 characters, and some of any kind.
    lines = [re.sub(r"( key| is) [!-~]{40}(?= |$)", r"\1 KEY", line) for line in lines]
    plain = [re.sub(r" *(\b[0-9a-f]{8,32}\b|(?<!\w)-?\d+(\.\d+)?|\d+(\.\d+)?)", " N", line) for line in lines]
    return [line for line, _ in groupby(plain)]


def renewed(block: Block, lines: Sequence[str]) -> str:
    """The body of a transcript as this run prints it, shortened where the author has shortened it."""
    old = block.body.splitlines()
    new = [line for line in lines if has_prefixes([line])] if has_prefixes(old) else said(lines, "client")
    if "..." in old:
        before, after = old.index("..."), old[::-1].index("...")
        if before + after < len(new):
            new = [*new[:before], "...", *new[len(new) - after :]]
    return "".join(f"{line}\n" for line in new)


def ran(block: Block) -> str:
    """The body of a transcript; where a run contradicts it, as this run prints it."""
    print(f"{block.where}: {block.kind} {block.source}", flush=True)
    lines = printed(block.source)
    why = contradiction(block, lines)
    if not why:
        return block.body
    print(why)
    return renewed(block, lines)


def rewrite(page: Path, bodies: Mapping[str, Callable[[Block], str]]) -> None:
    """Give each block of these kinds the body that its function returns."""
    text = new = page.read_text(encoding="utf-8")
    # From the last one on, so that the places of the others stay; but the runs of a page follow one another.
    made = [(block, bodies[block.kind](block)) for block in blocks(page) if block.kind in bodies]
    for block, body in reversed(made):
        new = new[: block.start] + body + new[block.start + len(block.body) :]
    if new != text:
        page.write_text(new, encoding="utf-8", newline="\n")
        print(f"{page.relative_to(ROOT).as_posix()}: rewritten")


def main() -> int:
    parser = argparse.ArgumentParser(description="Rewrites the excerpts and transcripts of the README and the guide.")
    parser.add_argument("pages", nargs="*", type=Path, metavar="PAGE", help="these pages alone")
    parser.add_argument("--excerpts", action="store_true", help="leave the transcripts, each of which takes a run")
    options = parser.parse_args()
    bodies: dict[str, Callable[[Block], str]] = {"excerpt": lambda block: excerpt(block.source)}
    if not options.excerpts:
        bodies |= {"run": ran, "like": ran}
    by_hand = []
    for page in [path.resolve() for path in options.pages] or pages():
        # The files of earlier runs go, such as lesson 02's journal, so that a page begins at 0.
        folder.cache_clear()
        rewrite(page, bodies)
        by_hand += [block for block in blocks(page) if block.kind == "by hand"]
    for each in by_hand:
        print(f"{each.where}: by hand: {each.source}")
    print(f"{len(by_hand)} blocks by hand")
    return 0


if __name__ == "__main__":
    sys.exit(guarded(main))
