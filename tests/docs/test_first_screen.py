"""The naked programs with which lesson 01's page begins: each side meets the other, and the lesson's own programs."""

from __future__ import annotations

import re

import pytest

from kitlib.docs import guide
from tests.conftest import PYTHON
from tests.docs.test_guide import build
from tests.programs import ROOT, steady_endpoint

KEY = "01_request_reply"
PAGE = guide.blocks(ROOT / "docs" / "guide" / f"{KEY}.md")
SERVER, CLIENT = [block.body for block in PAGE if block.kind == "by hand"][:2]
OWN = "tcp://127.0.0.1:5551"
USINGS = "using System; using NetMQ; using NetMQ.Sockets;\n"


@pytest.fixture(scope="module")
def naked_client(tmp_path_factory, console):
    """The command of the page's C#, which takes the server's endpoint as its word."""
    folder = tmp_path_factory.mktemp("naked")
    (folder / "Program.cs").write_text(USINGS + CLIENT.replace(f'"{OWN}"', "args[0]"), encoding="utf-8")
    done = build(folder, console, "<OutputType>Exe</OutputType><OutDir>out/</OutDir>")
    assert done.returncode == 0, done.stdout
    return ["dotnet", folder / "out" / "fragments.dll"]


@pytest.fixture
def naked_server(start, tmp_path):
    """Where the page's Python listens."""
    endpoint = steady_endpoint()
    (tmp_path / "naked.py").write_text(SERVER.replace(OWN, endpoint), encoding="utf-8")
    start(PYTHON, tmp_path / "naked.py")
    return endpoint


def test_they_are_as_short_as_they_look():
    assert [len(text.splitlines()) for text in (SERVER, CLIENT)] == [5, 3]
    assert OWN in SERVER and OWN in CLIENT
    assert re.findall(r"zmq\.(\w+)\)", SERVER) == ["REP"]


def test_each_meets_the_other(start, naked_server, naked_client):
    client = start(*naked_client, naked_server)
    assert client.wait() == 0, client.output
    assert client.lines == ["World"]


def test_the_lessons_server_answers_the_naked_client(start, serve, naked_client):
    client = start(*naked_client, serve(KEY)[1])
    assert client.wait() == 0, client.output
    assert client.lines == ["World"]


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_the_naked_server_answers_the_lessons_client(kind, start, client_command, naked_server):
    client = start(*client_command(kind, KEY, naked_server, "--count", "2", "--timeout", "60"))
    assert client.wait() == 0, client.output
    assert client.lines[-1] == "done: 2 replies"
    wrong = start(*client_command(kind, KEY, naked_server, "--count", "1", "--text", "Hi", "--timeout", "60"))
    assert wrong.wait() == 0
    assert "1: sent Hi, received error: expected Hello" in wrong.lines
