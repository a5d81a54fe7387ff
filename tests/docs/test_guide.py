"""The README and the guide are true: excerpts, transcripts, commands and programs, each compared or run."""

import contextlib
import functools
import importlib.util
import io
import json
import re
import shlex
from xml.etree import ElementTree

import pytest

from kitlib import commands
from kitlib.commands import run as runner
from kitlib.docs import guide
from kitlib.lessons import find
from kitlib.setup import python_setup
from lab import report
from tests.conftest import PYTHON, lacking
from tests.programs import EACH_RUN, ROOT, InTurn

BLOCKS = [block for page in guide.pages() for block in guide.blocks(page)]


def test_tables_and_excerpts_are_what_their_files_have():
    for block in BLOCKS:
        if block.kind == "bench":
            assert block.body == report.in_a_page(block.source), f"{block.where}: python3 -m lab.report rewrites it"
        elif block.kind == "excerpt":
            assert block.body == guide.excerpt(block.source), f"{block.where}: python3 -m kitlib.docs.guide rewrites it"


def ran(source):
    """The lines of `kit.py run`, by the function behind it: no program has to start and look for packages."""
    said = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(said):
        patch.setattr(python_setup, "interpreter", lambda *_: PYTHON)
        code = runner.do(commands.parse(runner, [str(word) for word in guide.run_command(source)[3:]]))
    assert code in (0, 1), said.getvalue()
    return guide.with_own_ports(said.getvalue(), source).splitlines()


@functools.cache
def once(source):
    return ran(source)


@pytest.mark.timeout(1200)
@pytest.mark.parametrize(
    "block",
    # Those of a page on one worker, because what a run printed is kept in its memory.
    [
        pytest.param(block, id=block.where, marks=pytest.mark.xdist_group(block.page.stem))
        for block in BLOCKS
        if block.kind in ("run", "like")
    ],
)
def test_a_transcript_is_what_a_run_prints(block, netmq, console):
    difference = guide.contradiction(block, once(block.source))
    for _ in range(3):
        # On a busy machine a client tries once more than the page says; a page that is wrong is so each time.
        difference = difference and guide.contradiction(block, ran(block.source))
    assert not difference, f"{difference}\npython3 -m kitlib.docs.guide rewrites it"


# A program stops when it has understood its words.
PARSE = """
import argparse
parse = argparse.ArgumentParser.parse_args
def only(self, *args, **named):
    parse(self, *args, **named)
    raise SystemExit(0)
argparse.ArgumentParser.parse_args = only
"""


def typed():
    """Each command of the pages for a lesson's program: its block, the client or "server", the lesson and the words."""
    for block in BLOCKS:
        for line in filter(None, block.body.splitlines()) if block.kind == "commands" else ():
            words = shlex.split(line.split("  #")[0])
            if words[:2] == ["python3", "kit.py"]:
                given = commands.parse(importlib.import_module(f"kitlib.commands.{words[2]}"), words[3:])
                if words[2] == "run":
                    yield block, "server", find(given.lesson).key, shlex.split(given.server)
                    yield block, given.client or "csharp", find(given.lesson).key, shlex.split(given.options)
                elif words[2] in ("server", "client"):
                    kind = "server" if words[2] == "server" else given.client or "csharp"
                    yield block, kind, find(given.lesson).key, given.words
            elif words[0] == "python":
                assert words[1].startswith("python/"), block.where
                yield block, "file", words[1].removeprefix("python/"), words[2:]
            else:
                assert words[:5] == ["dotnet", "run", "--project", "csharp-console", "--"], (block.where, line)
                number, *options = [word for word in words[5:] if word != "--unity"]
                yield block, "unity" if "--unity" in words else "csharp", find(number).key, options


def test_every_command_is_understood(run):
    """By kit.py, by the programs for which it has words, and by the terminal clients; transcripts run many of them."""
    files = {"server": "/server.py", "python": "/client.py", "file": ""}
    with InTurn([PYTHON, "-c", PARSE + EACH_RUN]) as parse:
        for block, kind, key, words in typed():
            if kind in ("csharp", "unity"):
                # By the list that it gives of its options; their values are tested elsewhere.
                known = " ".join(run(kind, key, "--help").lines)
                for name in [word[2:].partition("=")[0] for word in words if word.startswith("--")]:
                    assert re.search(rf"(?:--| ){re.escape(name)}\b", known), (block.where, name, known)
            elif words and not lacking().get(key.split("/")[0]):
                done = parse(ROOT / "python" / f"{key}{files[kind]}", *words)
                assert done.code == 0, (block.where, words, done.lines)


def test_every_block_of_another_language_can_be_read():
    for block in BLOCKS:
        if block.kind == "excerpt" or block.language in ("", "csharp", "mermaid"):
            continue
        if block.language == "python":
            compile(block.body, block.where, "exec")
        elif block.language == "json":
            json.loads(block.body)
        elif block.language == "yaml":
            # Without PyYAML it is read where the block is used.
            if importlib.util.find_spec("yaml"):
                importlib.import_module("yaml").safe_load(block.body)
        else:
            assert block.language == "xml", block.where
            ElementTree.fromstring(block.body)
