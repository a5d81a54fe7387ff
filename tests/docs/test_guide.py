"""The README and the guide are true: excerpts, transcripts, commands and programs, each compared or run."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest
import zmq

from kitlib.docs import guide, terminal_picture
from kitlib.lessons import find
from kitlib.setup import dotnet
from kitlib.terminal import COLOURS
from lab import report
from tests.conftest import PYTHON
from tests.programs import ROOT, finished, steady_endpoint

GUIDE = ROOT / "docs" / "guide"
PAGES = guide.pages()
BLOCKS = [block for page in PAGES for block in guide.blocks(page)]


def of(*kinds):
    """The blocks of these kinds; those of a page on one worker, because what a run printed is kept in its memory."""
    return pytest.mark.parametrize(
        "block",
        [
            pytest.param(block, id=block.where, marks=pytest.mark.xdist_group(block.page.stem))
            for block in BLOCKS
            if block.kind in kinds
        ],
    )


@of("bench")
def test_a_table_is_what_the_kept_run_has(block):
    assert block.body == report.in_a_page(block.source), "python3 -m lab.report rewrites it"


@of("excerpt")
def test_an_excerpt_is_what_its_file_has(block):
    assert block.body == guide.excerpt(block.source), "python3 -m kitlib.docs.guide rewrites it"


def printed(words, run=guide.printed):
    """However they are quoted: what was run once is not run again."""
    return run(shlex.join(shlex.split(words)))


@pytest.mark.timeout(1200)
@of("run", "like")
def test_a_transcript_is_what_a_run_prints(block, netmq, console):
    """`console` builds first: a run's limit is for what it prints, and not for the build that others wait for too."""
    difference = guide.contradiction(block, printed(block.source))
    if difference:
        # On a busy machine a client tries once more than the page says; a page that is wrong is so again.
        difference = guide.contradiction(block, printed(block.source, guide.printed.__wrapped__))
    assert not difference, f"{difference}\npython3 -m kitlib.docs.guide rewrites it"


@of("commands")
def test_every_command_runs(block, serve, start, client_command, netmq, tmp_path):
    for line in filter(None, block.body.splitlines()):
        words = shlex.split(line.split("  #")[0])
        if words[:2] == ["python3", "kit.py"]:
            run_kit(words[2:], serve, start, tmp_path)
        elif match := re.fullmatch(r"python/(\d\d_\w+)/server\.py", words[1] if len(words) > 1 else ""):
            assert words[0] == "python"
            server, _ = serve(match[1], *words[2:])
            assert server.stop() in (0, -15)
        elif match := re.fullmatch(r"python/(\d\d_\w+)/client\.py", words[1] if len(words) > 1 else ""):
            run_client("python", match[1], words[2:], serve, start, client_command)
        else:
            assert words[:5] == ["dotnet", "run", "--project", "csharp-console", "--"], f"unknown command: {line}"
            run_client("csharp", find(words[5]).key, words[6:], serve, start, client_command)


def run_kit(words, serve, start, folder):
    if words[0] == "server":
        free = ["--endpoint", find(words[1]).anywhere]
        server = start(PYTHON, ROOT / "kit.py", *words, *free, "--folder", folder)
        # Where others are behind it, each line says whose it is.
        server.wait_for(r"^(server +\| )?listening on ")
        server.stop()
        return
    if words[0] == "client":
        # In one folder with its server: lesson 15's has its keys there.
        words = [*words, "--endpoint", serve(find(words[1]).key)[1], "--folder", str(folder)]
    elif words[0] == "run":
        # The same words as in a transcript are not run again; the exit code is looked at there.
        said = printed(shlex.join(words[1:]))
        assert not [line for line in said if "Traceback" in line], "\n".join(said)
        return
    elif words[0] == "test":
        # This very run, or a part of it; only its words are checked.
        words = ["test", "--markers", *words[1:]]
    elif words[0] in ("bench", "doctor"):
        # Tests of their own run them; here only the words are checked.
        words = [*words, "--help"]
    elif words[0] == "unity":
        # It needs a project; test_unity_install.py has some.
        words = [*words, "--help"]
    elif words[0] == "copy":
        words[2] = str(folder / words[2].strip("./"))
    program = start(PYTHON, ROOT / "kit.py", *words)
    assert program.wait(240) in (0, 1), program.output
    assert "Traceback" not in program.output


def run_client(kind, key, options, serve, start, client_command):
    _, endpoint = serve(key)
    if options[:1] == ["--unity"]:
        # The endpoint is the test's own.
        kind, pairs = "unity", zip(options[1::2], options[2::2], strict=True)
        options = [word for name, value in pairs if name != "--endpoint" for word in (name, value)]
    program = start(*client_command(kind, key, endpoint, *options))
    assert program.wait(120) in (0, 1), program.output
    assert "Traceback" not in program.output


def compiled(project, netmq):
    """Every C# file that a project compiles, as MSBuild lists them."""
    command = ["dotnet", "msbuild", project, *netmq.properties, "-getItem:Compile"]
    done = subprocess.run(command, capture_output=True, env={**os.environ, **dotnet.ENVIRONMENT}, timeout=500)
    return {Path(item["FullPath"]) for item in json.loads(done.stdout)["Items"]["Compile"]}


def test_every_csharp_excerpt_is_of_a_file_that_is_compiled(netmq):
    sources = {
        ROOT / block.source.split()[0] for block in BLOCKS if block.language == "csharp" and block.kind == "excerpt"
    }
    assert sources
    # The lessons' own first: most of the time nobody else needs to be asked.
    projects = [project for tree in ("csharp-*", "lab", "tests") for project in ROOT.glob(f"{tree}/**/*.csproj")]
    for project in sorted(projects, key=lambda path: path.stem not in ("NetMQExample", "csharp-console")):
        if sources:
            sources -= compiled(project, netmq)
    assert not sources


@pytest.mark.parametrize(
    "block",
    [block for block in BLOCKS if block.language not in ("", "csharp", "mermaid") and block.kind != "excerpt"],
    ids=lambda block: block.where,
)
def test_every_block_of_another_language_can_be_read(block):
    if block.language == "python":
        compile(block.body, block.where, "exec")
    elif block.language == "json":
        json.loads(block.body)
    else:
        assert block.language == "xml"
        ElementTree.fromstring(block.body)


def test_the_picture_of_a_terminal_is_what_a_run_prints(netmq):
    svg = terminal_picture.PICTURE.read_text(encoding="utf-8")
    command, *lines = terminal_picture.lines_of(svg)
    assert command == f"$ python3 kit.py run {terminal_picture.RUN}"
    assert pictured(lines) == "", "python3 -m kitlib.docs.terminal_picture draws it"
    # In colour, as `show` prints it.
    assert svg == terminal_picture.draw(command[2:], [re.sub(r"^\w+ +\|", in_colour, line) for line in lines])


def pictured(lines):
    shown = guide.Block(terminal_picture.PICTURE, 1, "like", "", "", "".join(f"{line}\n" for line in lines))
    return guide.contradiction(shown, printed(terminal_picture.RUN))


def in_colour(prefix):
    return f"\033[{COLOURS[prefix[0].split()[0]]}m{prefix[0]}\033[0m"
