"""Every test shares these: the real programs, started as processes and gone at the end of the test."""

from __future__ import annotations

import contextlib
import functools
import os
import re
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import zmq

from kitlib.lessons import KitError, Lesson, lessons
from kitlib.setup import dotnet, python_setup
from tests.programs import LIMIT, ROOT, InTurn, Program, Run, python_in_turn, two_ports

PYTHON = Path(sys.executable)
CLIENTS = ("python", "csharp", "unity")

# A shell ignores Ctrl-C for what it starts in the background, and so would all that the tests start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
# And under nohup what a closed terminal says.
if sys.platform != "win32" and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
# By which kit.py passes Ctrl-C on to pytest on Windows.
if sys.platform == "win32":
    signal.signal(signal.SIGBREAK, signal.default_int_handler)


# The caches of matplotlib and others would go into the home of whoever runs the tests.
KEPT = tempfile.TemporaryDirectory()
os.environ.update(MPLCONFIGDIR=KEPT.name, XDG_CACHE_HOME=KEPT.name)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--long", action="store_true", help="also run the tests that take minutes")


@functools.cache
def lacking() -> dict[str, list[str]]:
    """The packages that this Python lacks of those that each lesson needs."""
    needs = {lesson.key: [*map(python_setup.name, python_setup.needs(lesson.key))] for lesson in lessons()}
    absent = python_setup.not_found(PYTHON, sorted(set().union(*needs.values())))
    return {key: [name for name in names if name in absent] for key, names in needs.items()}


# After pytest-xdist's own.
@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    by_number = {key[:2]: (key, names) for key, names in lacking().items()}
    for item in items:
        # A case of the contract, or a block of a page, has its lesson in its name.
        about = re.search(r"\[.*?\b(\d\d)_[a-z]", item.name)
        key, names = by_number.get(about[1] if about else "", ("", []))
        if names:
            item.add_marker(pytest.mark.skip(reason=f"{key} needs {' '.join(names)}: pip install {' '.join(names)}"))
        if "long" in item.keywords and not config.getoption("--long"):
            item.add_marker(pytest.mark.skip(reason="takes minutes: run with --long"))
        # The names of a group's tests end in its name, by which a worker gets them all. Up to 3.8 pytest-xdist writes
        # it into a field that pytest 9.2 does not read any more: github.com/pytest-dev/pytest-xdist/issues/1386.
        group = item.get_closest_marker("xdist_group")
        if group and getattr(config.option, "loadgroup", False) and not item.nodeid.endswith(f"@{group.args[0]}"):
            item._id = item._id.parse(f"{item.nodeid}@{group.args[0]}")  # type: ignore[attr-defined]


def pytest_report_header(config: pytest.Config) -> str:
    try:
        return f"NetMQ: {dotnet.find_netmq().why}"
    except KitError as error:
        return f"C#: {error}"


@pytest.fixture(scope="session")
def netmq() -> dotnet.NetMQ:
    """Where NetMQ comes from; skips where there is no .NET SDK, or no NetMQ."""
    try:
        return dotnet.find_netmq()
    except dotnet.NoNetMQ as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def console(netmq: dotnet.NetMQ) -> list[str]:
    """The command of the terminal clients, built once per run from the files as they are now."""
    return ["dotnet", str(dotnet.build(netmq))]


@pytest.fixture(scope="session")
def csharp_in_turn(netmq: dotnet.NetMQ, console: list[str]) -> Iterator[InTurn]:
    """For the terminal clients and the player; the first word of each run is the lesson."""
    with InTurn(["dotnet", dotnet.build(netmq, ROOT / "tests" / "lessons" / "checks"), "each", console[1]]) as in_turn:
        yield in_turn


@pytest.fixture
def run(request: pytest.FixtureRequest) -> Iterator[Callable[..., Run]]:
    """run("csharp", "01_request_reply", "--count", "x"): how this run of a client, or of the "server", has ended.

    C# runs are in one process, a lesson's Python runs of a test in another. Give --endpoint yourself.
    """
    # First, and on the test's own thread: it skips the test where there is no C#.
    callspec = getattr(request.node, "callspec", None)
    if callspec and {"csharp", "unity"} & {str(value) for value in callspec.params.values()}:
        request.getfixturevalue("csharp_in_turn")
    with contextlib.ExitStack() as stack:

        @functools.cache
        def python(folder: Path) -> InTurn:
            return stack.enter_context(python_in_turn(folder))

        def run(kind: str, key: str, *words: str) -> Run:
            if kind in ("python", "server"):
                program = ROOT / "python" / key / ("client.py" if kind == "python" else "server.py")
                return python(program.parent)(program, *words)
            csharp: InTurn = request.getfixturevalue("csharp_in_turn")
            return csharp(key, *(["--unity"] if kind == "unity" else []), *words)

        yield run


@pytest.fixture
def runs(run: Callable[..., Run]) -> Callable[..., list[Run]]:
    """runs("csharp", "01_request_reply", [["--count", "x"], …]): the same for many, one after the other."""
    return lambda kind, key, each: [run(kind, key, *words) for words in each]


@pytest.fixture
def start() -> Iterator[Callable[..., Program]]:
    """Starts a program that the end of the test ends, whatever happens."""
    started: list[Program] = []

    def start(*command: str | Path, folder: Path = ROOT, **environment: str) -> Program:
        program = Program(command, folder=folder, **environment)
        started.append(program)
        return program

    yield start
    for program in started:
        program.kill()
        # Shown where a test fails.
        print(program.command, program.output, sep="\n")


@pytest.fixture
def serve(start: Callable[..., Program], tmp_path: Path) -> Callable[..., tuple[Program, str]]:
    """serve("01_request_reply", "--delay", "1") starts a lesson's server on a free port: (program, endpoint).

    It works in a folder of this test's own: side by side, two of lesson 02's would share one journal. What a lesson has
    behind it is started before, unless the options say where that is.
    """

    def serve(key: str, *options: str, endpoint: str = "", **environment: str) -> tuple[Program, str]:
        for name, other in Lesson(key).behind:
            if name not in options:
                options = (*options, name, serve(other.key)[1])
        place = (endpoint or two_ports()).replace("tcp", Lesson(key).scheme)
        words = [ROOT / "python" / key / "server.py", "--endpoint", place, *options]
        program = start(PYTHON, *words, folder=tmp_path, **environment)
        return program, program.wait_for(r"^listening on (\S+)")[1]

    return serve


@pytest.fixture
def serve_own(start: Callable[..., Program], tmp_path: Path) -> Callable[..., tuple[Program, str]]:
    """serve_own("04_background_client", "def answer(text): …"): a lesson's server with this at the end of its file, or
    of another file of the lesson.
    """

    def serve_own(key: str, own: str, *options: str | Path, file: str = "server.py") -> tuple[Program, str]:
        for name in ("server.py", file):
            before, main, after = (ROOT / "python" / key / name).read_text(encoding="utf-8").partition("if __name__")
            text = f"{before}\n\n{own if name == file else ''}\n\n{main}{after}"
            (tmp_path / name).write_text(text, encoding="utf-8")
        words = [tmp_path / "server.py", "--endpoint", "tcp://127.0.0.1:0", *options]
        path = os.pathsep.join([str(ROOT / "python" / key), str(ROOT / "python")])
        server = start(PYTHON, *words, folder=tmp_path, PYTHONPATH=path)
        return server, server.wait_for(r"^listening on (\S+)")[1]

    return serve_own


@pytest.fixture
def context() -> Iterator[zmq.Context[zmq.Socket[bytes]]]:
    """Its sockets leave at once, whatever they have not sent. One that waits in vain raises zmq.Again in the end."""
    with zmq.Context() as context:
        context.linger, context.rcvtimeo = 0, int(1000 * LIMIT)
        yield context


@pytest.fixture
def client_command(request: pytest.FixtureRequest) -> Callable[..., list[str]]:
    """client_command("csharp", "01_request_reply", endpoint, "--count", "3"): the words that start this client."""

    def command(kind: str, key: str, endpoint: str, *options: str) -> list[str]:
        if kind == "python":
            return [str(PYTHON), str(ROOT / "python" / key / "client.py"), "--endpoint", endpoint, *options]
        # Asked for only now, so that the Python clients are tested where there is no .NET SDK.
        console: list[str] = request.getfixturevalue("console")
        # The MonoBehaviour's serialized fields have the names of the options.
        unity = ["--unity"] if kind == "unity" else []
        return [*console, key, *unity, "--endpoint", endpoint, *options]

    return command
