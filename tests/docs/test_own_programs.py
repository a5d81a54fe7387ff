"""The sections *In a program of your own*, each of whose blocks runs as it stands on its page."""

import importlib.util
import json
import os
import re
import signal
import sys
import time

import pytest

from kitlib.docs import guide
from netmq_example import JobClient, LazyPirate, Publisher, TopicListener, errors
from netmq_example.pose_stream import snapshots_beside
from tests.conftest import PYTHON
from tests.lessons.conftest import ask
from tests.programs import ROOT, finished, steady_endpoint, two_ports

BLOCKS = [block for page in guide.pages() for block in guide.blocks(page)]
# A program finds the package here, as if it was installed.
INSTALLED = {"PYTHONPATH": str(ROOT / "python")}
LOGGED = "import logging\nlogging.basicConfig(level='INFO')\n"


def programs(test):
    """The blocks that name this test."""
    found = [block.body for block in BLOCKS if re.search(rf"\b{test}\b", block.source)]
    assert found, test
    return found


@pytest.fixture
def run(start, tmp_path):
    """run(program, "tcp://127.0.0.1:5551", endpoint): the started program of a page, with another endpoint in it."""

    def run(program, old="", new="", before=""):
        assert old in program
        path = tmp_path / f"program_{len(list(tmp_path.iterdir()))}.py"
        path.write_text(before + program.replace(old, new), encoding="utf-8")
        return start(PYTHON, "-u", path, folder=tmp_path, **INSTALLED)

    return run


def test_a_server_of_ones_own(run, tmp_path, context):
    server, its_test = programs("test_a_server_of_ones_own")
    (tmp_path / "my_server.py").write_text(server, encoding="utf-8")
    (tmp_path / "test_my_server.py").write_text(its_test, encoding="utf-8")
    words = [PYTHON, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", tmp_path, tmp_path]
    done = finished(words, cwd=tmp_path, env={**os.environ, **INSTALLED})
    assert "1 passed" in done.stdout, done.stdout + done.stderr
    program = run(server, ":5551", ":0", before=LOGGED)
    endpoint = program.wait_for(r"^INFO:netmq_example.server:listening on (\S+)$")[1]
    assert ask(context, endpoint, b"one frame") == [b"ONE FRAME"]
    with LazyPirate(endpoint) as pirate:
        assert pirate.request("two") == "TWO"
    code = program.stop(signal.SIGINT)
    assert sys.platform == "win32" or (code == 0 and "Traceback" not in program.output), program.output


def test_a_lazy_pirate_and_a_journal_of_ones_own(run, serve, context):
    client, journal = programs("test_a_lazy_pirate_and_a_journal_of_ones_own")
    endpoint = serve("02_lazy_pirate")[1]
    client = run(client, "tcp://127.0.0.1:5552", endpoint)
    assert client.wait() == 0 and client.lines == ["1"], client.output
    endpoint = steady_endpoint()
    server = run(journal, "tcp://127.0.0.1:5552", endpoint)
    visits = [ask(context, endpoint, id, b"Ada")[1] for id in (b"1", b"1", b"2")]
    server.kill()
    run(journal, "tcp://127.0.0.1:5552", endpoint)
    visits += [ask(context, endpoint, id, b"Ada")[1] for id in (b"2", b"3")]
    assert visits == [b"visit 1", b"visit 1", b"visit 2", b"visit 2", b"visit 3"]


def test_a_listener_in_python(run):
    (program,) = programs("test_a_listener_in_python")
    with Publisher() as publisher:
        listener = run(program, "tcp://127.0.0.1:5553", publisher.endpoint)
        while not listener.lines:
            publisher.send("pose/", "1 2 3")
            time.sleep(0.01)
        assert set(listener.lines) == {"pose/ 1 2 3"}


def test_jobs_of_ones_own(run):
    (program,) = programs("test_jobs_of_ones_own")
    endpoint = steady_endpoint()
    server = run(program, "tcp://127.0.0.1:5564", endpoint)
    with JobClient(endpoint, tries=20) as client:
        *_, last = client.watch(client.goal("squares", 12))
    assert (last.values["status"], last.values["text"]) == ("succeeded", "144")
    if sys.platform != "win32":
        assert server.stop(signal.SIGINT) == 0, server.output


def test_a_publisher_of_ones_own(run):
    (program,) = programs("test_a_publisher_of_ones_own")
    endpoint = steady_endpoint()
    run(program, "tcp://127.0.0.1:5553", endpoint)
    with TopicListener(endpoint, "scores/", timeout=60) as listener:
        while len(frames := listener.receive_frames()) == 1:
            text = frames[0].decode()
    assert frames[0] == b"scores/" and text == f"scores/ {json.loads(frames[1])['red']}"


def test_a_stream_of_ones_own(run):
    client, server = programs("test_a_stream_of_ones_own")
    endpoint = two_ports()
    second = snapshots_beside(endpoint)
    run(server.replace("tcp://127.0.0.1:5657", second).replace("poll(16)", "poll(1)"), "tcp://127.0.0.1:5557", endpoint)
    subscriber = run(client, "tcp://127.0.0.1:5557", endpoint)
    assert subscriber.wait() == 0, subscriber.output
    assert re.match(r"missed \d+:", subscriber.lines[-1]) and len(subscriber.lines) >= 300


def test_messages_of_ones_own(run):
    pytest.importorskip("numpy", reason="messages with arrays need numpy: kit.py run 5 installs it")
    (program,) = programs("test_messages_of_ones_own")
    program = run(program)
    assert program.wait() == 0 and program.lines == ["{'at': 1}"], program.output


def test_many_of_ones_own(run):
    (program,) = programs("test_many_of_ones_own")
    program = run(program)
    assert program.wait() == 0, program.output
    ends = [line for line in program.lines if re.match(r"[123] ", line)]
    assert re.match("3 error: ValueError", ends[0]) and ends[1:] == ["2 slept 0.1", "1 slept 0.8"], program.output


# As much of FastAPI as the page's service needs.
LIKE_FASTAPI = """
from types import SimpleNamespace


class HTTPException(Exception):
    def __init__(self, status_code, detail):
        self.status_code, self.detail = status_code, detail


class FastAPI:
    def __init__(self, lifespan):
        self.state = SimpleNamespace()

    def get(self, path):
        return lambda function: function
"""
CALLS = """
import asyncio


async def called(text):
    try:
        return await ask(text)
    except HTTPException as error:
        return f"{error.status_code} {error.detail}"


async def main():
    async with lifespan(app):
        print(*await asyncio.gather(*(called(f"echo {number}") for number in range(100))))
        print(await called("sing"))
        while not (said := await called("hello")).startswith("504 "):
            await asyncio.sleep(0.1)
        print(said)


asyncio.run(main())
"""


def test_a_web_service(run, serve, tmp_path):
    """A hundred at once get each their own reply; and what the server refuses, or does not answer, has its code."""
    (program,) = programs("test_a_web_service")
    if not importlib.util.find_spec("fastapi"):
        (tmp_path / "fastapi.py").write_text(LIKE_FASTAPI, encoding="utf-8")
    server, endpoint = serve("04_background_client")
    # A busy machine may take longer for a hundred than the seconds of the page, which the last one waits for in vain.
    patient = program.replace("within=3", "within=30 if text[0] == 'e' else 3")
    service = run(f"{patient}\n{CALLS}", "tcp://127.0.0.1:5554", endpoint)
    service.wait_for("^400 expected hello or echo TEXT")
    server.kill()
    assert service.wait() == 0, service.output
    assert service.lines[0] == " ".join(map(str, range(100)))
    assert service.lines[-1].startswith("504 ") and "'hello' may have been done or not" in service.lines[-1]


def test_the_tree_of_errors():
    """The table has every error, with the builtin that it is."""
    page = (ROOT / "docs" / "guide" / "troubleshooting.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (?:· )?`(\w+)` \| (?:`(\w+)`)? ?\|", page.partition("## Errors and logs")[2], re.MULTILINE)
    kit = {value for value in vars(errors).values() if isinstance(value, type) and issubclass(value, errors.Error)}
    assert {name for name, _ in rows} == {each.__name__ for each in kit - {errors.Coded}}
    for name, builtin in rows:
        bases = [each.__name__ for each in getattr(errors, name).__mro__[1:] if each not in kit]
        assert bases[0] == (builtin or "Exception"), name
