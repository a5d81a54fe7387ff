"""The tests' Unity: the player, and the package's folder Editor against a stand-in, in programs that do what they are
told."""

from __future__ import annotations

import inspect
import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from kitlib.setup import dotnet
from tests.programs import LIMIT, ROOT, Program

PACKAGE = ROOT / "unity" / "Assets" / "NetMQExample"
PREFAB = PACKAGE / "04_background_client" / "BackgroundClient.prefab"
# Mono is the runtime nearest to Unity's.
NEAREST = "mono" if shutil.which("mono") else "dotnet"
# Faults below us, each by a text that tells it. Wine, while it still notes the end of one thread's send, refuses
# another thread's on the same socket (server/sock.c, send_socket): NetMQ's reaper, which writes to itself, ends of that
# once in 3,000 Plays. Mono 6.8, when it frees an AppDomain, aborts if an old copy of its table of compiled methods,
# which a thread has just read, is still there (mono/metadata/domain.c, 1240): once in some 3,500 reloads of lesson 16.
NOT_OURS = ("SocketException (10035)", "condition `domain->num_jit_info_table_duplicates == 0' not met")


def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool:
    """Once more, if it was one of these."""
    fixtures = {name: pyfuncitem.funcargs[name] for name in inspect.signature(pyfuncitem.obj).parameters}
    try:
        pyfuncitem.obj(**fixtures)
    except AssertionError as error:
        if not any(fault in str(error) for fault in NOT_OURS):
            raise
        pyfuncitem.obj(**fixtures)
    return True


def put(root: Path, files: dict[str, str | bytes]) -> None:
    """Files of a project that are not the kit's doing."""
    for name, data in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data if isinstance(data, bytes) else data.encode())


def needs_mono() -> None:
    mono = shutil.which("mono")
    if not mono:
        pytest.skip("no mono here (on Debian: apt install mono-devel)")
    libraries = Path(mono).resolve().parent.parent / "lib" / "mono"
    if not any(libraries.glob("4.5/Facades/netstandard.dll")):
        pytest.skip("this mono cannot run .NET Standard libraries (on Debian: apt install mono-devel)")


@pytest.fixture(scope="session")
def harness(netmq: dotnet.NetMQ) -> Path:
    return dotnet.build(netmq, ROOT / "tests" / "unity" / "play")


@pytest.fixture
def play(harness: Path, start: Callable[..., Program]) -> Callable[..., Program]:
    """play("drive", "count=60", …) starts tests/unity/play."""

    def start_play(*words: str, runtime: str = "dotnet", **more: Any) -> Program:
        if runtime == "mono":
            needs_mono()
        return start(runtime, harness, *words, **more)

    return start_play


@pytest.fixture(scope="session")
def stage(harness: Path) -> Iterator[Any]:
    """Where the worlds of ML-Agents' shape are played."""
    # It needs numpy.
    from tests.unity.scene_worlds import Stage

    one = Stage(harness)
    yield one
    one.close()


@pytest.fixture
def world(stage: Any) -> Iterator[Callable[..., Any]]:
    """world("A period=2", …): this world, with Python."""
    from tests.unity.scene_worlds import World

    yield partial(World, stage)
    # Shown where a test fails.
    print(*stage.program.lines[stage.said :], sep="\n")


@pytest.fixture
def alone(stage: Any) -> Callable[..., tuple[list[str], str]]:
    """alone("A period=2", …): what happens in this world without Python, and all that was printed."""
    from tests.unity import scene_worlds

    return partial(scene_worlds.alone, stage)


class Editor:
    """tests/unity/play/EditorProgram.cs in a process of its own, in the folder of a Unity project."""

    def __init__(self, command: list[str], project: Path, **environment: str) -> None:
        self.program = Program(
            command, folder=project, stdin=subprocess.PIPE, DOTNET_EnableDiagnostics="0", **environment
        )
        self.program.wait_for("^ready$")

    def do(self, what: str) -> list[str]:
        """One thing after the other; returns what was printed meanwhile."""
        before = len(self.program.lines)
        self.program.process.stdin.write(f"{what}\n")
        self.program.process.stdin.flush()
        self.program.wait_for(f"^did {re.escape(what)}$", start=before)
        return self.program.lines[before:-1]

    def draw_until(self, pattern: str) -> str:
        """The window draws itself ten times a second."""
        for _ in range(int(LIMIT / 0.1)):
            drawn = "\n".join(self.do("draw"))
            if re.search(pattern, drawn, re.MULTILINE):
                return drawn
            time.sleep(0.1)
        raise AssertionError(f"never drawn: {pattern}; the last: {drawn}")

    def play_until(self, line: str) -> None:
        """Frames, until a line was logged."""
        for _ in range(int(LIMIT / 0.1)):
            self.do("draw")
            if line in self.program.lines:
                return
            time.sleep(0.1)
        raise AssertionError(f"never logged: {line}; printed:\n{self.program.output}")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A game with the package in it, and without the servers."""
    (tmp_path / "Assets").mkdir()
    shutil.copytree(PACKAGE, tmp_path / "Assets" / "NetMQExample")
    return tmp_path


@pytest.fixture
def editor(harness: Path) -> Iterator[Callable[..., Editor]]:
    """Opens a project, in an editor that runs on Mono where that is there."""
    opened = []

    def open_project(project: Path, runtime: str = NEAREST, words: Sequence[str] = (), **environment: str) -> Editor:
        opened.append(Editor([runtime, str(harness), "editor", *words], project, **environment))
        opened[-1].do("load")
        return opened[-1]

    yield open_project
    for one in opened:
        # No server is left, even if the test has failed.
        if "did quit" not in one.program.lines and not one.program.ended:
            one.do("quit")
        one.program.wait()
