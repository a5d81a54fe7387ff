"""Play and Stop, again and again, as the Unity editor does it: Stop is quick, nothing is left, the next Play works.

The player (csharp-support/unity-player) runs the scripts in tests/unity/play, which presses Play and Stop when told to.
Threads and sockets are counted from outside, in /proc. With a domain reload each Play has an AppDomain (Mono) or a
load context (.NET) of its own; without one, the default since Unity 6.6, every Play has the same statics.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from kitlib import lessons
from kitlib.setup import dotnet
from tests.programs import LIMIT, ROOT, Program, steady_port, two_ports

sys.path.append(str(ROOT / "python" / "15_security"))
from netmq_example.security import keys

# All waits of a Stop share 200 ms. A busy machine wakes it later than that, now and then much later. A wait that they
# do not share makes every Stop longer, and one for a reply takes more than a second.
STOP_LIMIT = 400.0
ONE_STOP_LIMIT = 1000.0
# An unloading may take so many times what a Play took to begin, on average. Up to twice that is usual, on an idle
# machine and on one with fifty programs at work; a wait of ten seconds for what never ends is far more.
UNLOAD_LIMIT = 20
RUNTIMES = ("mono", ".net")
MODES = ("reload", "keep")
# What each runtime keeps for itself, and starts and ends as it likes.
RUNTIME_THREADS = re.compile(r"\.NET |Thread Pool|SGen|Finalizer|Timer-Sched|Threadpool")
pytestmark = [
    pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="counts threads and sockets in /proc"),
    # They measure milliseconds: not beside each other.
    pytest.mark.xdist_group("times"),
]


@dataclass
class Row:
    """What one condition has shown."""

    condition: str
    plays: int = 0
    starts: list[float] = field(default_factory=list)
    stops: list[float] = field(default_factory=list)
    # The Stops without the time for which the machine had no core.
    worked: list[float] = field(default_factory=list)
    unloads: list[float] = field(default_factory=list)
    uncollected: int = 0
    threads: int = 0
    sockets: int = 0
    outcome: str = ""

    def __str__(self) -> str:
        if self.outcome:
            return f"{self.condition:50} {self.outcome}"
        unload = f"{max(self.unloads):6.0f} ms" if self.unloads else "        -"
        if self.uncollected:
            unload = f"{self.uncollected:3d} kept "
        stop = max(self.stops, default=0)
        return f"{self.condition:50} {self.plays:5} {stop:7.0f} ms {unload} {self.threads:8} {self.sockets:8}"


class Summary:
    """The table at the end of the run."""

    def __init__(self) -> None:
        self.rows: list[Row] = []

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        terminalreporter.section("Play and Stop")
        terminalreporter.write_line(
            f"{'runtime mode   scripts, server':50} Plays  worst Stop  unload  threads  sockets left"
        )
        for row in self.rows:
            terminalreporter.write_line(str(row))


@pytest.fixture
def plays(request: pytest.FixtureRequest) -> int:
    """How often Play and Stop are pressed. What is left behind at each is seen after the second, or after the fifth."""
    return 20 if request.config.getoption("--long") else 5


@pytest.fixture(scope="session")
def summary(request: pytest.FixtureRequest) -> Summary:
    table = Summary()
    request.config.pluginmanager.register(table)
    return table


@pytest.fixture(scope="session")
def harness(netmq: dotnet.NetMQ) -> Path:
    return dotnet.build(netmq, ROOT / "tests" / "unity" / "play")


class Editor:
    """tests/unity/play in a process of its own, with the buttons Play and Stop."""

    def __init__(self, command: list[str], row: Row, folder: Path) -> None:
        self.row = row
        self.program = Program(
            command, folder=folder, stdin=subprocess.PIPE, DOTNET_EnableDiagnostics="0", DOTNET_TieredCompilation="0"
        )
        self.said = 0
        self.wait_for("^ready$")
        self.before = self.count()

    def wait_for(self, pattern: str, limit: float = LIMIT) -> re.Match[str]:
        """The next line that matches, after the last one that was waited for."""
        found = self.program.wait_for(pattern, limit, self.said)
        self.said = 1 + next(
            i for i in range(self.said, len(self.program.lines)) if re.search(pattern, self.program.lines[i])
        )
        return found

    def press(self, button: str) -> None:
        pipe = self.program.process.stdin
        assert pipe
        pipe.write(f"{button}\n")
        pipe.flush()

    def play(self) -> None:
        self.row.plays += 1
        began = time.monotonic()
        self.press("play")
        self.wait_for("^playing$")
        self.row.starts.append(1000 * (time.monotonic() - began))

    def stop(self) -> None:
        """Stop, and look at what is left."""
        self.stop_in_time()
        self.nothing_left()

    def stop_in_time(self) -> None:
        before = self.without_a_core()
        self.press("stop")
        took = float(self.wait_for(r"^stopped in ([\d.]+) ms")[1])
        stalled = self.stalled(before)
        # A game that leaves one behind with each scene fills its memory. One material for each colour is no such thing.
        left = self.wait_for("^left: (.*)$")[1].split()
        assert all(one.startswith("Material:") for one in left) and len(left) == len(set(left)), left
        self.row.stops.append(took)
        ready = self.wait_for(r"^ready$|^unloaded in ([\d.]+) ms|^not collected")
        if ready[1]:
            self.row.unloads.append(float(ready[1]))
            assert self.row.unloads[-1] <= UNLOAD_LIMIT * statistics.mean(self.row.starts), (
                f"the domain took {ready[1]} ms to unload; the Plays began within {self.row.starts} ms"
            )
        self.row.uncollected += ready[0] == "not collected"
        if ready[0] != "ready":
            self.wait_for("^ready$")
        # That a thread was ready to run, and the machine had no core for it, is not the scripts' fault.
        self.row.worked.append(took - stalled)
        assert self.row.worked[-1] <= ONE_STOP_LIMIT, (
            f"Stop of Play {self.row.plays} took {took} ms, {stalled:.0f} of them without a core; "
            f"printed:\n{self.program.output[-3000:]}"
        )

    def nothing_left(self) -> None:
        """What ends a little later than Stop is waited for; the limit only ends what never ends."""
        deadline = time.monotonic() + 20
        while (left := self.left()) != (0, 0) and time.monotonic() < deadline:
            time.sleep(0.01)
        self.row.threads, self.row.sockets = left
        assert left == (0, 0), (
            f"after Play {self.row.plays} there are left {left[0]} threads and {left[1]} sockets; "
            f"stops took {self.row.stops}, unloads {self.row.unloads} ms; printed:\n{self.program.output[-3000:]}"
        )

    def without_a_core(self) -> dict[str, float]:
        """How many milliseconds each thread has been ready to run and could not, since it was started."""
        stalled = dict[str, float]()
        for task in Path(f"/proc/{self.program.process.pid}/task").glob("*/schedstat"):
            with contextlib.suppress(OSError):
                stalled[task.parent.name] = int(task.read_text().split()[1]) / 1e6
        return stalled

    def stalled(self, before: dict[str, float]) -> float:
        """The main thread may also wait for one that had no core: the compiler's, the collector's, the network's."""
        return sum(now - before.get(task, 0) for task, now in self.without_a_core().items())

    def left(self) -> tuple[int, int]:
        threads, sockets = self.count()
        return max(0, threads - self.before[0]), max(0, sockets - self.before[1])

    def count(self) -> tuple[int, int]:
        """The threads that are not the runtime's own, and the sockets (libzmq's eventfds are such)."""
        process = Path(f"/proc/{self.program.process.pid}")
        threads = sockets = 0
        for task in process.glob("task/*/comm"):
            try:
                threads += not RUNTIME_THREADS.match(task.read_text())
            except OSError:  # It has just ended.
                continue
        for number in process.glob("fd/*"):
            try:
                sockets += bool(re.match(r"socket:|anon_inode:\[eventfd\]", str(number.readlink())))
            except OSError:
                continue
        return threads, sockets


@pytest.fixture
def editor(netmq: dotnet.NetMQ, harness: Path, summary: Summary, tmp_path: Path) -> Iterator[Callable[..., Editor]]:
    """editor("mono", "keep", "1", endpoint, 2, "two clients"): Unity with two of lesson 1's clients in the scene."""
    opened: list[Editor] = []

    def open_editor(runtime: str, mode: str, script: str, endpoint: str, clients: int, condition: str) -> Editor:
        if runtime == "mono":
            needs_mono()
            if script == "15_security":
                pytest.skip("Debian's Mono 6.8 cannot run NetMQ's CURVE: its corlib has no indexer of ReadOnlySpan")
        if script == "15_security" and not (tmp_path / "keys").exists():
            keys.example(tmp_path / "keys")
        row = Row(f"{runtime:5} {mode:6} {condition}")
        summary.rows.append(row)
        program = {"mono": "mono", ".net": "dotnet"}[runtime]
        opened.append(Editor([program, str(harness), mode, script, endpoint, str(clients)], row, tmp_path))
        if script.startswith("16") and runtime == "mono":
            # Mono's thread pool, which only this lesson uses, brings one thread without a name, however many clients.
            opened[-1].before = (opened[-1].before[0] + 1, opened[-1].before[1])
        return opened[-1]

    yield open_editor
    for one in opened:
        one.program.kill()
    for worked in [one.row.worked for one in opened if len(one.row.worked) >= 3]:
        assert statistics.median(worked) <= STOP_LIMIT, f"Stops took {worked} ms"


def needs_mono() -> None:
    mono = shutil.which("mono")
    if not mono:
        pytest.skip("no mono here (on Debian: apt install mono-devel)")
    libraries = Path(mono).resolve().parent.parent / "lib" / "mono"
    if not any(libraries.glob("4.5/Facades/netstandard.dll")):
        pytest.skip("this mono cannot run .NET Standard libraries (on Debian: apt install mono-devel)")


@pytest.fixture
def silent() -> Iterator[str]:
    """The endpoint of a server that accepts and never answers."""
    accepted: list[socket.socket] = []
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def accept() -> None:
            while True:
                try:
                    accepted.append(listener.accept()[0])
                except OSError:
                    return

        threading.Thread(target=accept, daemon=True).start()
        yield f"tcp://127.0.0.1:{listener.getsockname()[1]}"
        listener.shutdown(socket.SHUT_RDWR)
    for connection in accepted:
        connection.close()


@pytest.fixture
def absent() -> str:
    """An endpoint where nobody listens."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return f"tcp://127.0.0.1:{listener.getsockname()[1]}"


every_way = pytest.mark.parametrize(("runtime", "mode"), [(r, m) for r in RUNTIMES for m in MODES])


@every_way
@pytest.mark.parametrize("clients", [1, 2])
def test_server_up(
    runtime: str, mode: str, clients: int, editor: Callable[..., Any], serve: Callable[..., Any], plays: int
) -> None:
    endpoint = serve("01_request_reply", "--delay", "0.002")[1]
    unity = editor(runtime, mode, "1", endpoint, clients, f"{clients} client{'s' * (clients > 1)}, server up")
    for _ in range(plays):
        unity.play()
        for _ in range(clients):
            unity.wait_for("^2: sent Hello, received World")
        unity.stop()


@every_way
def test_server_absent(runtime: str, mode: str, editor: Callable[..., Any], absent: str, plays: int) -> None:
    play_without_answer(editor(runtime, mode, "1", absent, 1, "1 client, server absent"), plays)


@every_way
def test_server_silent(runtime: str, mode: str, editor: Callable[..., Any], silent: str, plays: int) -> None:
    play_without_answer(editor(runtime, mode, "1", silent, 1, "1 client, server silent"), plays)


def play_without_answer(unity: Editor, plays: int) -> None:
    for i in range(plays):
        unity.play()
        unity.wait_for("^asking")
        # Stop comes at another moment of the client's wait each time, the first at once.
        time.sleep(i % 7 / 100)
        unity.stop()


@every_way
def test_server_killed(
    runtime: str, mode: str, editor: Callable[..., Any], serve: Callable[..., Any], plays: int
) -> None:
    server, endpoint = serve("01_request_reply", "--delay", "0.002")
    unity = editor(runtime, mode, "1", endpoint, 1, "1 client, server killed")
    for _ in range(plays):
        unity.play()
        unity.wait_for("^1: sent Hello, received World")
        server.kill()
        unity.stop()
        server = serve("01_request_reply", "--delay", "0.002", endpoint=endpoint)[0]


@every_way
def test_ten_clients_and_one_destroyed_early(
    runtime: str, mode: str, editor: Callable[..., Any], serve: Callable[..., Any], plays: int
) -> None:
    endpoint = serve("01_request_reply", "--delay", "0.001")[1]
    unity = editor(runtime, mode, "1", endpoint, 10, "10 clients, one destroyed early")
    for _ in range(plays):
        unity.play()
        for _ in range(10):
            unity.wait_for("^1: sent Hello, received World")
        unity.press("destroy")
        unity.wait_for("^destroyed$")
        # The others go on: each of these is a reply that came after.
        for _ in range(10):
            unity.wait_for(r"^\d+: sent Hello, received World")
        unity.stop()


@every_way
def test_destroyed_objects_are_not_waited_for(runtime: str, mode: str, editor: Callable[..., Any], silent: str) -> None:
    """Ten clients that wait for a reply, all destroyed in one frame."""
    unity = editor(runtime, mode, "1", silent, 10, "10 clients, all destroyed while they wait")
    for _ in range(5):
        unity.play()
        for _ in range(10):
            unity.wait_for("^asking")
        before = unity.without_a_core()
        unity.press("destroy all")
        took = float(unity.wait_for(r"^destroyed in ([\d.]+) ms")[1])
        stalled = unity.stalled(before)
        # Those that are waited for take up to 50 ms each, and 200 together.
        assert took - stalled < 100, f"{took} ms, {stalled:.0f} of them without a core"
        unity.stop()


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_a_recompile_while_playing(runtime: str, editor: Callable[..., Any], serve: Callable[..., Any]) -> None:
    """Unity disables everything, loads the new assembly and enables everything: the old run leaves it nothing."""
    endpoint = serve("01_request_reply", "--delay", "0.002")[1]
    unity = editor(runtime, "keep", "1", endpoint, 3, "3 clients, recompiled while playing")
    for _ in range(5):
        unity.play()
        for _ in range(3):
            unity.wait_for("^2: sent Hello, received World")
        before = unity.without_a_core()
        unity.press("recompile")
        took = float(unity.wait_for(r"^recompiled in ([\d.]+) ms")[1])
        unity.row.worked.append(took - unity.stalled(before))
        assert unity.row.worked[-1] <= ONE_STOP_LIMIT
        news = unity.said
        for _ in range(3):
            unity.wait_for("^2: sent Hello, received World")
        numbers = [int(n) for n in re.findall(r"^(\d+): ", "\n".join(unity.program.lines[news:]), re.MULTILINE)]
        assert max(numbers[:3]) <= 3, f"lines of the run before: {numbers[:9]}"
        unity.stop()


@pytest.mark.parametrize("runtime", RUNTIMES)
@pytest.mark.parametrize("key", [lesson.key for lesson in lessons.lessons() if list(lesson.unity.glob("*.cs"))])
def test_a_phone_closes_the_sockets_of_a_game_that_is_not_seen(
    runtime: str, key: str, editor: Callable[..., Any], serve: Callable[..., Any]
) -> None:
    # Lesson 07's second port is 100 higher if nobody says otherwise.
    endpoint = serve(key, endpoint=f"{lessons.Lesson(key).scheme}://127.0.0.1:{steady_port()}")[1]
    # The servers of lessons 09 to 12 have one game at a time, and a simulator of 17 waits: that says little.
    alone = key.startswith(("09", "10", "11", "12", "17"))
    clients, lines = (1, 2) if alone else (2, 4)
    unity = editor(runtime, "keep", key, endpoint, clients, f"{key} x {clients}, paused as on a phone")
    replies = r"^\d+: |^frame \d+: |^received |^snapshot|^person 0: pose |^job \w+: |^she: "
    reply = "^asking |^simulating | can film " if alone else replies
    unity.play()
    for _ in range(lines):
        unity.wait_for(reply)
    for _ in range(2):
        unity.press("pause")
        unity.wait_for("^paused$")
        unity.nothing_left()
        unity.press("resume")
        unity.wait_for("^resumed$")
        for _ in range(lines):
            unity.wait_for(reply)
    unity.stop()


@pytest.mark.parametrize("runtime", RUNTIMES)
@pytest.mark.parametrize("clients", [2, 3])
def test_each_client_comes_back_from_the_background_also_while_it_waits(
    runtime: str, clients: int, editor: Callable[..., Any], serve: Callable[..., Any]
) -> None:
    """A client that waits for an answer has no line for Update: whom another one had ended took itself for done."""
    endpoint = serve("01_request_reply", "--delay", "0.3")[1]
    unity = editor(runtime, "keep", "1", endpoint, clients, f"{clients} clients, paused as on a phone, slow server")
    unity.play()
    for _ in range(2):
        for _ in range(2 * clients):
            unity.wait_for("^[12]: sent Hello, received World")
        unity.press("pause")
        unity.wait_for("^paused$")
        unity.press("resume")
        unity.wait_for("^resumed$")
        for _ in range(clients):
            unity.wait_for("^asking ")
    unity.stop()


@pytest.mark.parametrize("key", ["1", "4"])
def test_a_client_begins_once_whatever_happens_while_the_game_is_paused(
    key: str, editor: Callable[..., Any], serve: Callable[..., Any]
) -> None:
    """Switched off and on meanwhile it has begun already; and a system may say twice that it goes."""
    lesson = {"1": "01_request_reply", "4": "04_background_client"}[key]
    unity = editor(".net", "keep", key, serve(lesson)[1], 1, f"{lesson}, switched in the background")
    unity.play()
    unity.wait_for("^1: sent ")
    for begun, buttons in ((2, "pause off on resume"), (3, "pause pause resume")):
        for button in buttons.split():
            unity.press(button)
            unity.wait_for(rf"^{button}d$|^switched {button}$")
        for _ in range(2):
            unity.wait_for("^[12]: sent ")
        assert sum(line.startswith("asking ") for line in unity.program.lines) == begun
    unity.stop()


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_a_paused_editor_is_felt_by_the_network_thread(
    runtime: str, editor: Callable[..., Any], serve: Callable[..., Any]
) -> None:
    """Without Update a queue without a limit would fill the memory."""
    server, endpoint = serve("01_request_reply")
    unity = editor(runtime, "keep", "1", endpoint, 1, "1 client, server up, editor paused")
    unity.play()
    unity.wait_for("^2: sent Hello, received World")
    unity.press("freeze")
    unity.wait_for("^frozen$")
    before, now = len(server.lines), -1
    deadline = time.monotonic() + 10
    while now != len(server.lines) and time.monotonic() < deadline:
        now = len(server.lines)
        time.sleep(0.5)
    assert len(server.lines) == now, "it never waited"
    # What was answered and not yet logged: a full queue, and what was on its way when the count began.
    assert now - before < 200
    unity.stop()


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_a_flood_of_replies_fills_no_frame(
    runtime: str, netmq: dotnet.NetMQ, harness: Path, serve: Callable[..., Any], start: Callable[..., Any]
) -> None:
    """Each line costs 0.3 ms, as it may in a build; in the editor it is more."""
    if runtime == "mono":
        needs_mono()
    endpoint = serve("01_request_reply", "--quiet")[1]
    play = start({"mono": "mono", ".net": "dotnet"}[runtime], harness, "flood", "1", endpoint, "3000")
    assert play.wait(300) == 0, play.output[-2000:]
    found = re.fullmatch(r"(\d+) lines in (\d+) frames, at most (\d+) in one", play.lines[-1])
    assert found, play.output[-2000:]
    replies = [line for line in play.lines if "sent Hello" in line]
    assert replies == [f"{i}: sent Hello, received World" for i in range(1, 3001)]
    assert int(found[1]) == 3002
    # 20 ms are 66 lines. Where the machine is busy there are fewer in a frame, never more.
    assert int(found[3]) <= 20, play.lines[-1]


@pytest.mark.parametrize(
    ("lesson", "name", "value", "says"),
    [
        ("1", "timeout", "NaN", "timeout must be"),
        ("1", "timeout", "-1", "timeout must be"),
        ("1", "timeout", "1e30", "timeout must be"),
        ("2", "tries", "0", "tries must be"),
        ("3", "timeout", "0", "timeout must be"),
        ("4", "tries", "0", "tries must be"),
        ("4", "timeout", "NaN", "timeout must be"),
        ("4", "timeout", "1e30", "timeout must be"),
        ("5", "timeout", "-1", "timeout must be"),
        ("6", "window", "0", "window must be"),
        ("13", "trouble", "bogus", "trouble"),
    ],
)
def test_a_wrong_field_is_said_once(
    lesson: str, name: str, value: str, says: str, harness: Path, start: Callable[..., Any]
) -> None:
    play = start("dotnet", harness, "wrong", lesson, name, value)
    assert play.wait() == 0, play.output
    assert "done before it was enabled: False" in play.lines
    assert play.lines[-1] == "errors: 1" or "errors: 1" in play.lines, play.output
    (said,) = [line for line in play.lines if "gave up: " in line]
    assert says in said
    assert not [line for line in play.lines if line.startswith("   at ") or "Exception" in line]


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_a_stop_while_a_client_is_being_made(runtime: str, editor: Callable[..., Any], silent: str) -> None:
    """Lesson 07's logs a line in the middle of it: that must not fail, or the first of its sockets stays for ever."""
    unity = editor(runtime, "keep", "7", silent, 2, "2 clients, stopped while they are made")
    for i in range(10):
        unity.play()
        time.sleep(i / 200)
        unity.stop()


OTHERS = [lesson.key for lesson in lessons.lessons() if lesson.number > 1 and list(lesson.unity.glob("*.cs"))]


@pytest.mark.parametrize("server", ["up", "silent"])
@pytest.mark.parametrize(("runtime", "mode"), [("mono", "reload"), (".net", "keep")])
@pytest.mark.parametrize("key", OTHERS)
def test_every_other_lesson(
    key: str, runtime: str, mode: str, server: str, editor: Callable[..., Any], serve: Callable[..., Any], silent: str
) -> None:
    endpoint = serve(key, endpoint=two_ports())[1] if server == "up" else silent
    unity = editor(runtime, mode, key, endpoint, 2, f"{key} x 2, server {server}")
    for i in range(5):
        unity.play()
        time.sleep(0.05 + i / 50)
        unity.stop()


def test_whoever_comes_in_the_midst_of_a_reload_opens_nothing(editor: Callable[..., Any], absent: str) -> None:
    """A thread that had no core until then: it would be aborted with its sockets open."""
    unity = editor("mono", "reload", "LateClient", absent, 1, "1 client, which connects while the domain is unloaded")
    for _ in range(2):
        unity.play()
        unity.wait_for("^asking")
        unity.stop()


@pytest.mark.parametrize(
    ("script", "last"),
    [
        ("PooledJob", "the job is done"),
        ("LateConnection", "the connection has ended: True, and what it sends: True"),
    ],
)
def test_what_is_on_the_thread_pool_ends_before_a_reload(
    script: str, last: str, editor: Callable[..., Any], absent: str
) -> None:
    """NetMQ's last events are there, and WebSockets. Mono 6.8 ends itself where one is aborted, once in some thousand
    reloads, or where a WebSocket begins in the midst of a reload, once in some 400."""
    unity = editor("mono", "reload", script, absent, 1, f"1 {script}, which is late")
    for _ in range(2):
        unity.play()
        # On a busy machine the last of it may come before Stop.
        played = unity.said
        unity.press("stop")
        unity.wait_for("^stopped")
        unity.program.wait_for(f"^{last}$", start=played)
        unity.wait_for("^ready$")


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_who_leaves_while_it_connects_leaves_no_connection(
    runtime: str, editor: Callable[..., Any], serve: Callable[..., Any]
) -> None:
    """.NET forgets a WebSocket's connection that comes about when nobody waits for it any more."""
    server, endpoint = serve("16_web_gateway", endpoint=two_ports())
    unity = editor(runtime, "keep", "16_web_gateway", endpoint, 2, "16_web_gateway x 2, Stop while they connect")
    for i in range(60):
        unity.play()
        time.sleep(i / 1000)
        unity.stop_in_time()
    unity.nothing_left()
    for _ in range(5):  # A gateway that has other things to do for a moment.
        os.kill(server.process.pid, signal.SIGSTOP)
        unity.play()
        unity.stop_in_time()
        time.sleep(1.5)
        os.kill(server.process.pid, signal.SIGCONT)
        unity.nothing_left()


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_the_naive_client_freezes(runtime: str, editor: Callable[..., Any], silent: str) -> None:
    """An endless receive, joined in OnDestroy: the same checks find it."""
    unity = editor(runtime, "keep", "EndlessClient", silent, 1, "(naive: endless receive, server silent)")
    unity.play()
    unity.wait_for("^client 1: asked")
    unity.press("stop")
    with pytest.raises(AssertionError, match="no line match"):
        unity.wait_for("^stopped", limit=3)
    assert unity.program.process.poll() is None, unity.program.output
    unity.row.outcome = "frozen: no end of Stop within 3 s"


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_the_naive_client_kills_its_neighbour(
    runtime: str, editor: Callable[..., Any], serve: Callable[..., Any]
) -> None:
    """Cleanup() per client: when one is destroyed, the other stops getting replies."""
    endpoint = serve("01_request_reply", "--delay", "0.002")[1]
    unity = editor(runtime, "keep", "CleaningClient", endpoint, 2, "(naive: Cleanup per client)")
    unity.play()
    unity.wait_for("^client 2: received World")
    unity.press("destroy")
    unity.wait_for("^destroyed$")
    with pytest.raises(AssertionError, match="no line match"):
        for _ in range(1000):
            unity.wait_for("^client 2: received World", limit=2)
    unity.row.outcome = "client 2 " + unity.program.wait_for("client 2: (Term.*|ObjectDisposedException)")[1]


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_netmq_that_never_ends(runtime: str, editor: Callable[..., Any], absent: str) -> None:
    """NetMQ waits for a socket that nobody disposed; before 4.0.4.1 it waits for ever on macOS, whatever was disposed.

    Stop keeps to its time, and the next Play says what is wrong: the first one soon, those after it at once.
    """
    unity = editor(runtime, "keep", "ForgetfulClient", absent, 1, "(naive: a socket is forgotten)")
    unity.play()
    unity.wait_for("^asked")
    unity.stop_in_time()
    for _ in range(2):
        unity.play()
        told = unity.wait_for(r"^gave up after (\d+) ms: (.*)")
        assert "dispose every socket" in told[2] and "macOS" in told[2] and "4.0.4.5" in told[2]
        unity.stop_in_time()
    assert int(told[1]) < 1000
    unity.row.outcome = "the next Play says why"


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_a_program_whose_netmq_never_ends_ends(
    runtime: str, harness: Path, netmq: dotnet.NetMQ, start: Callable[..., Program]
) -> None:
    if runtime == "mono":
        needs_mono()
    program = start({"mono": "mono", ".net": "dotnet"}[runtime], harness, "forgotten")
    assert program.wait() == 0, program.output
    assert program.lines == ["done"]


@pytest.mark.parametrize(("runtime", "count"), [("mono", 2), (".net", 0)])
def test_only_a_runtime_that_unloads_domains_is_listened_to(
    runtime: str, count: int, harness: Path, netmq: dotnet.NetMQ, start: Callable[..., Program]
) -> None:
    """CoreCLR, to which Unity moves, never unloads one, and what listens to that is never unloaded itself."""
    if runtime == "mono":
        needs_mono()
    program = start({"mono": "mono", ".net": "dotnet"}[runtime], harness, "listeners")
    assert program.wait() == 0, program.output
    assert program.lines == [f"{count} listen to the end of their domain"]
