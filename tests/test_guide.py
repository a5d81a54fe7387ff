"""The README and the guide are true: excerpts, transcripts, commands, links and pictures, each compared."""

from __future__ import annotations

import re
import shlex
from itertools import groupby
from pathlib import Path

import pytest

from kitlib import guide
from kitlib.lessons import find
from tests.conftest import PYTHON
from tests.programs import ROOT

PAGES = guide.pages()
BLOCKS = [block for page in PAGES for block in guide.blocks(page)]


def of(kind):
    return pytest.mark.parametrize(
        "block", [block for block in BLOCKS if block.kind == kind], ids=lambda block: block.where
    )


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.where)
def test_every_block_says_where_it_comes_from(block):
    known = {"excerpt", "run", "like", "commands", "by hand"}
    assert block.kind in known or block.language == "mermaid", (
        f"{block.where}: put a comment above it, see kitlib/guide.py"
    )
    if block.kind == "by hand":
        assert block.source, f"{block.where}: say why it is by hand"


@of("excerpt")
def test_an_excerpt_is_what_its_file_has(block):
    assert block.body == guide.excerpt(block.source), "python3 -m kitlib.guide rewrites it"


def speakers(lines, number):
    """What each side printed; its own order counts, how the two mix does not."""
    said = {"server": [], "client": []}
    for line in lines:
        if match := re.match(r"(server|client) \| ?(.*)", line):
            said[match[1]].append(re.sub(r"(tcp://127\.0\.0\.1:)\d+", rf"\g<1>{5550 + number}", match[2]))
    return said


def same(expected, printed):
    """True if the lines are equal, where a line `...` stands for any number of lines."""
    pattern = "".join("(.*\n)*?" if line == "..." else re.escape(line) + "\n" for line in expected)
    return re.fullmatch(pattern, "".join(f"{line}\n" for line in printed)) is not None


def shape(lines):
    """The lines with every number and id replaced, and what repeats itself said once."""
    plain = [re.sub(r"-?\d+(\.\d+)?", "N", re.sub(r"\b[0-9a-f]{8,32}\b", "ID", line)) for line in lines]
    return [line for line, _ in groupby(plain)]


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.kind in ("run", "like")], ids=lambda block: block.where)
@pytest.mark.timeout(300)
def test_a_transcript_is_what_a_run_prints(block, engine, start):
    words = shlex.split(block.source)
    number = find(words[0]).number
    program = start(PYTHON, ROOT / "kit.py", "run", *words, "--engine", engine.name, "--endpoint", "tcp://127.0.0.1:*")
    assert program.wait(240) in (0, 1), program.output
    said = speakers(program.lines, number)
    lines = block.body.splitlines()
    form = shape if block.kind == "like" else list
    if any(re.match(r"(server|client) \|", line) for line in lines):
        # `...` between prefixed lines stands for lines of both.
        for side in said:
            expected = [line for line in lines if line == "..." or line.startswith(side)]
            expected = form([re.sub(r"^\w+ +\| ?", "", line) for line in expected])
            assert same([line for line, _ in groupby(expected)], form(said[side])), program.output
    else:
        assert same(form(lines), form(said["client"])), program.output


@of("commands")
@pytest.mark.timeout(300)
def test_every_command_runs(block, serve, start, client_command, engine):
    for line in filter(None, block.body.splitlines()):
        words = shlex.split(line.split("  #")[0])
        if words[:2] == ["python3", "kit.py"]:
            run_kit(words[2:], start, engine)
        elif match := re.fullmatch(r"python/(\d\d_\w+)/server\.py", words[1] if len(words) > 1 else ""):
            assert words[0] == "python"
            server, _ = serve(match[1], *words[2:])
            assert server.stop() in (0, -15)
        elif match := re.fullmatch(r"python/(\d\d_\w+)/client\.py", words[1] if len(words) > 1 else ""):
            run_client("python", match[1], words[2:], serve, start, client_command)
        else:
            assert words[:5] == ["dotnet", "run", "--project", "csharp-console", "--"], f"unknown command: {line}"
            run_client("csharp", find(words[5]).key, words[6:], serve, start, client_command)


def run_kit(words, start, engine):
    if words[0] == "run":
        words = [*words, "--engine", engine.name, "--endpoint", "tcp://127.0.0.1:*"]
    elif words[0] == "test":
        # This very run, or a part of it; only its words are checked.
        words = ["test", "--collect-only", "-q", *words[1:]]
    program = start(PYTHON, ROOT / "kit.py", *words)
    assert program.wait(240) in (0, 1), program.output
    assert "Traceback" not in program.output


def run_client(kind, key, options, serve, start, client_command):
    _, endpoint = serve(key)
    program = start(*client_command(kind, key, endpoint, *options))
    assert program.wait(120) in (0, 1), program.output
    assert "Traceback" not in program.output


def anchors(page):
    titles = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", [*PAGES, *ROOT.glob("*.md")], ids=lambda page: page.name)
def test_every_link_and_picture_exists(page):
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith(("http://", "https://", "mailto:")):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.exists(), f"{page.name}: {target}"
        if anchor and file.suffix == ".md":
            assert anchor in anchors(file), f"{page.name}: {target}"


def test_every_picture_is_what_its_command_draws():
    from kitlib import pictures

    for source in (ROOT / "img").glob("*.seq"):
        drawn = pictures.draw(source.read_text(encoding="utf-8"), source.name)
        assert source.with_suffix(".svg").read_text(encoding="utf-8") == drawn, "python3 -m kitlib.pictures draws it"


def test_every_lesson_has_a_row_in_the_readme():
    readme = Path(ROOT / "README.md").read_text(encoding="utf-8")
    from kitlib.lessons import lessons

    for lesson in lessons():
        assert f"docs/guide/{lesson.key}.md" in readme, lesson.key
