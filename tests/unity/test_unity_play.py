"""Play and Stop, again and again, as the Unity editor does it: Stop is quick, nothing is left, the next Play works.

The player (csharp-support/unity-player) runs the scripts in tests/unity/play, which presses Play and Stop when told to.
Threads and sockets are counted from outside, in /proc. Mono is the runtime nearest to Unity's: with a domain reload
each Play has an AppDomain of its own, and without one, the default since Unity 6.6, every Play has the same statics.
On .NET there is only what its own code is for, and what Debian's Mono cannot run.
"""

import contextlib
import os
import re
import shutil
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path

import pytest

from kitlib import lessons
from tests.bad_peers import Listener
from tests.programs import LIMIT, ROOT, Program, two_ports
from tests.unity.conftest import needs_mono

sys.path.append(str(ROOT / "python" / "15_security"))
from netmq_example.security import keys

# All waits of a Stop share 200 ms. A busy machine wakes it later than that, now and then much later. A wait for a reply
# takes more than this.
STOP_LIMIT = 1000.0
# An unloading may take so many times what a Play took to begin, on average. Up to twice that is usual, on an idle
# machine and on one with fifty programs at work; a wait of ten seconds for what never ends is far more.
UNLOAD_LIMIT = 20
# Each runtime keeps these for itself, and starts and ends them as it likes.
RUNTIME_THREADS = re.compile(r"\.NET |Thread Pool|SGen|Finalizer|Timer-Sched|Threadpool")
pytestmark = [
    pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="counts threads and sockets in /proc"),
    # They share programs, and measure milliseconds: not beside each other.
    pytest.mark.xdist_group("times"),
]


class Editor:
    """tests/unity/play in a process of its own, with the buttons Play and Stop."""

    def __init__(self, runtime, mode, harness, folder):
        self.runtime, self.folder = runtime, folder
        self.starts: list[float] = []
        self.plays = self.spoilt = False
        environment = {"DOTNET_EnableDiagnostics": "0"}
        command = [runtime, str(harness), mode]
        self.program = Program(command, folder=folder, stdin=subprocess.PIPE, **environment)
        self.said = 0
        self.wait_for("^ready$")

    def wait_for(self, pattern, limit=LIMIT):
        """The next line that matches, after the last one that was waited for."""
        found = self.program.wait_for(pattern, limit, self.said)
        self.said = 1 + next(
            i for i in range(self.said, len(self.program.lines)) if re.search(pattern, self.program.lines[i])
        )
        return found

    def press(self, button, answer=""):
        pipe = self.program.process.stdin
        pipe.write(f"{button}\n")
        pipe.flush()
        return self.wait_for(answer) if answer else None

    def play(self, script, endpoint, clients=1):
        self.before = self.count()
        if script.startswith("16") and self.runtime == "mono":
            # Mono's thread pool, which only this lesson uses, brings one thread without a name, however many clients.
            self.before = (self.before[0] + 1, self.before[1])
        self.plays = True
        began = time.monotonic()
        self.press(f"play {script} {endpoint} {clients}", "^playing$")
        self.starts.append(1000 * (time.monotonic() - began))

    def stop(self):
        self.stop_in_time()
        self.nothing_left()

    def stop_in_time(self):
        self.in_time("stop", r"^stopped in ([\d.]+) ms", STOP_LIMIT)
        # A game that leaves one behind with each scene fills its memory. One material for each colour is no such thing.
        left = self.wait_for("^left: (.*)$")[1].split()
        assert all(one.startswith("Material:") for one in left) and len(left) == len(set(left)), left
        ready = self.wait_for(r"^ready$|^unloaded in ([\d.]+) ms")
        if ready[1]:
            assert float(ready[1]) <= UNLOAD_LIMIT * statistics.mean(self.starts), (
                f"the domain took {ready[1]} ms to unload; the Plays began within {self.starts} ms"
            )
            self.wait_for("^ready$")
        self.plays = False

    def in_time(self, button, answer, limit):
        """That a thread was ready to run, and the machine had no core for it, is not the scripts' fault."""
        before = self.without_a_core()
        self.press(button)
        took = float(self.wait_for(answer)[1])
        # The main thread may also wait for one that had no core: the compiler's, the collector's, the network's.
        stalled = sum(now - before.get(task, 0) for task, now in self.without_a_core().items())
        assert took - stalled <= limit, (
            f"{button} took {took} ms, {stalled:.0f} of them without a core; printed:\n{self.program.output[-3000:]}"
        )

    def nothing_left(self):
        """Threads and sockets may end a little later than Stop; the limit is for those that never end."""
        deadline = time.monotonic() + 20
        while (left := self.left()) != (0, 0) and time.monotonic() < deadline:
            time.sleep(0.01)
        assert left == (0, 0), (
            f"{left[0]} threads and {left[1]} sockets are left; printed:\n{self.program.output[-3000:]}"
        )

    def without_a_core(self):
        """How many milliseconds each thread has been ready to run and could not, since it was started."""
        stalled = dict[str, float]()
        for task in Path(f"/proc/{self.program.process.pid}/task").glob("*/schedstat"):
            with contextlib.suppress(OSError):
                stalled[task.parent.name] = int(task.read_text().split()[1]) / 1e6
        return stalled

    def left(self):
        threads, sockets = self.count()
        return max(0, threads - self.before[0]), max(0, sockets - self.before[1])

    def count(self):
        """The threads that are not the runtime's own, and the sockets."""
        process = Path(f"/proc/{self.program.process.pid}")
        threads = sockets = 0
        for task in process.glob("task/*/comm"):
            # It may have just ended.
            with contextlib.suppress(OSError):
                threads += not RUNTIME_THREADS.match(task.read_text())
        for number in process.glob("fd/*"):
            with contextlib.suppress(OSError):
                sockets += str(number.readlink()).startswith("socket:")
        return threads, sockets


@pytest.fixture(scope="module")
def editor(harness, tmp_path_factory):
    """editor("mono", "keep"): one of these for all tests, until it fails or is spoilt."""
    opened = {}

    def open_editor(runtime="mono", mode="keep"):
        if runtime == "mono":
            needs_mono()
        one = opened.get((runtime, mode))
        if one is None or one.plays or one.spoilt or one.program.ended:
            if one:
                one.program.kill()
            one = opened[runtime, mode] = Editor(runtime, mode, harness, tmp_path_factory.mktemp("editor"))
        return one

    yield open_editor
    for one in opened.values():
        one.program.kill()


@pytest.fixture(scope="module")
def silent():
    """The endpoint of a server that accepts and never answers."""
    with Listener() as listener:
        yield listener.endpoint


ABSENT = "tcp://127.0.0.1:9"


def test_a_domain_is_left_at_each_moment(editor, serve, silent):
    """Two clients; the second Play begins as the first did, also after a server was killed.

    Without an answer Stop comes at another moment of the client's wait each time, the first at once.
    """
    unity = editor(mode="reload")
    server, endpoint = serve("01_request_reply", "--delay", "0.002")
    for number in range(2):
        unity.play("1", endpoint, 2)
        for _ in range(2):
            unity.wait_for("^2: sent Hello, received World")
        if number == 1:
            server.kill()
        unity.stop()
    for moment, endpoint in enumerate([silent, ABSENT, silent]):
        unity.play("1", endpoint)
        unity.wait_for("^asking")
        time.sleep(moment / 30)
        unity.stop()


def test_the_others_go_on_when_one_is_destroyed(editor, serve):
    unity = editor()
    unity.play("1", serve("01_request_reply", "--delay", "0.001")[1], 3)
    for _ in range(3):
        unity.wait_for("^1: sent Hello, received World")
    unity.press("destroy", "^destroyed$")
    # Each of these is a reply that came after.
    for _ in range(10):
        unity.wait_for(r"^\d+: sent Hello, received World")
    unity.stop()


def test_destroyed_objects_are_not_waited_for(editor):
    """Nor is a client at Stop that does not hear of it, for longer than 200 ms, however many there are."""
    unity = editor()
    unity.play("DeafClient", ABSENT, 6)
    for _ in range(6):
        unity.wait_for("^asking")
    unity.in_time("stop", r"^stopped in ([\d.]+) ms", 800)
    unity.wait_for("^ready$")
    unity.plays = False
    unity.nothing_left()
    unity.play("DeafClient", ABSENT, 6)
    for _ in range(6):
        unity.wait_for("^asking")
    unity.in_time("destroy all", r"^destroyed in ([\d.]+) ms", 150)
    unity.stop()


def test_a_recompile_while_playing(editor, serve):
    """Unity disables everything, loads the new assembly and enables everything: the old run leaves it nothing."""
    unity = editor()
    unity.play("1", serve("01_request_reply", "--delay", "0.002")[1], 3)
    for _ in range(3):
        unity.wait_for("^2: sent Hello, received World")
    unity.in_time("recompile", r"^recompiled in ([\d.]+) ms", STOP_LIMIT)
    news = unity.said
    for _ in range(3):
        unity.wait_for("^2: sent Hello, received World")
    numbers = [int(n) for n in re.findall(r"^(\d+): ", "\n".join(unity.program.lines[news:]), re.MULTILINE)]
    assert max(numbers[:3]) <= 3, f"lines of the run before: {numbers[:9]}"
    unity.stop()


@pytest.mark.parametrize("key", [lesson.key for lesson in lessons.lessons() if list(lesson.unity.glob("*.cs"))])
def test_every_lesson(key, editor, serve, silent, tmp_path):
    """A phone closes the sockets of a game that is not seen; Stop comes while it talks, and while it waits."""
    # Debian's Mono 6.8 cannot run NetMQ's CURVE: its corlib has no indexer of ReadOnlySpan.
    unity = editor("dotnet" if key.startswith("15") else "mono")
    if key.startswith("15"):
        keys.example(tmp_path / "keys")
        shutil.copytree(tmp_path / "keys", unity.folder / "keys", dirs_exist_ok=True)
    # Lesson 07's second port is 100 higher if nobody says otherwise.
    endpoint = serve(key, endpoint=two_ports())[1]
    # The servers of lessons 09 to 12 have one game at a time, and a simulator of 17 waits: that says little.
    alone = key.startswith(("09", "10", "11", "12", "17"))
    clients, lines = (1, 2) if alone else (2, 4)
    replies = r"^\d+: |^frame \d+: |^received |^snapshot|^person 0: pose |^job \w+: |^she: "
    reply = "^asking |^simulating | can film " if alone else replies
    unity.play(key, endpoint, clients)
    for _ in range(lines):
        unity.wait_for(reply)
    unity.press("pause", "^paused$")
    unity.nothing_left()
    unity.press("resume", "^resumed$")
    for _ in range(lines):
        unity.wait_for(reply)
    unity.stop()
    unity.play(key, silent, 2)
    time.sleep(0.05)
    unity.stop()


def test_each_client_comes_back_from_the_background_also_while_it_waits(editor, serve):
    """A client that waits for an answer has no line for Update: one that another had ended took itself for done."""
    unity = editor()
    unity.play("1", serve("01_request_reply", "--delay", "0.3")[1], 2)
    for _ in range(2):
        unity.wait_for("^1: sent Hello, received World")
    unity.press("pause", "^paused$")
    unity.press("resume", "^resumed$")
    for _ in range(2):
        unity.wait_for("^asking ")
    unity.stop()


@pytest.mark.parametrize("lesson", ["01_request_reply", "04_background_client"])
def test_a_client_begins_once_whatever_happens_while_the_game_is_paused(lesson, editor, serve):
    """Switched off and on meanwhile it has begun already; and a system may say twice that it goes."""
    unity = editor()
    before = len(unity.program.lines)
    unity.play(lesson, serve(lesson)[1])
    unity.wait_for("^1: sent ")
    for begun, buttons in ((2, "pause off on resume"), (3, "pause pause resume")):
        for button in buttons.split():
            unity.press(button, rf"^{button}d$|^switched {button}$")
        for _ in range(2):
            unity.wait_for("^[12]: sent ")
        assert sum(line.startswith("asking ") for line in unity.program.lines[before:]) == begun
    unity.stop()


def test_a_paused_editor_is_felt_by_the_network_thread(editor, serve):
    """Without Update a queue without a limit would fill the memory."""
    server, endpoint = serve("01_request_reply")
    unity = editor()
    unity.play("1", endpoint)
    unity.wait_for("^2: sent Hello, received World")
    unity.press("freeze", "^frozen$")
    before, now = len(server.lines), -1
    deadline = time.monotonic() + 10
    while now != len(server.lines) and time.monotonic() < deadline:
        now = len(server.lines)
        time.sleep(0.5)
    assert len(server.lines) == now, "it never waited"
    # These were answered and not yet logged: a full queue, and some that were on their way when the count began.
    assert now - before < 200
    unity.stop()


def test_a_flood_of_replies_fills_no_frame(play, serve):
    """Each line costs 0.3 ms, as it may in a build; in the editor it is more."""
    program = play("flood", "1", serve("01_request_reply", "--quiet")[1], "150")
    assert program.wait() == 0, program.output
    found = re.fullmatch(r"(\d+) lines in (\d+) frames, at most (\d+) in one", program.lines[-1])
    assert found, program.output
    replies = [line for line in program.lines if "sent Hello" in line]
    assert replies == [f"{i}: sent Hello, received World" for i in range(1, 151)]
    # 20 ms are 66 lines. Where the machine is busy there are fewer in a frame, never more.
    assert int(found[3]) <= 20, program.lines[-1]


# Lesson, field, value, and what is said of it.
WRONG = [
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
]


def test_a_wrong_field_is_said_once(play):
    program = play("wrong", *(word for *words, _ in WRONG for word in words))
    assert program.wait() == 0, program.output
    each = program.output.split("done before it was enabled: False")[1:]
    assert len(each) == len(WRONG)
    for (*words, says), said in zip(WRONG, each, strict=True):
        lines = said.splitlines()
        (gave_up,) = [line for line in lines if "gave up: " in line]
        assert says in gave_up and lines[-1] == "errors: 1", (words, said)
        assert not [line for line in lines if line.startswith("   at ") or "Exception" in line], (words, said)


def test_a_stop_while_a_client_is_being_made(editor, silent):
    """Lesson 07's logs a line in the middle of it: that must not fail, or the first of its sockets stays for ever."""
    unity = editor()
    for i in range(5):
        unity.play("7", silent, 2)
        time.sleep(i / 200)
        unity.stop()


def test_whoever_comes_in_the_midst_of_a_reload_opens_nothing(editor):
    """A thread that had no core until then: it would be aborted with its sockets open."""
    unity = editor(mode="reload")
    unity.play("LateClient", ABSENT)
    unity.wait_for("^asking")
    unity.stop()


def test_what_is_on_the_thread_pool_ends_before_a_reload(editor):
    """NetMQ's last events are there. Mono 6.8 ends itself where one is aborted, once in some thousand reloads."""
    unity = editor(mode="reload")
    unity.play("PooledJob", ABSENT)
    # On a busy machine the last of it may come before Stop.
    played = unity.said
    unity.press("stop", "^stopped")
    unity.program.wait_for("^the job is done$", start=played)
    unity.wait_for("^ready$")
    unity.plays = False


@pytest.mark.parametrize("runtime", ["mono", "dotnet"])
def test_who_leaves_while_it_connects_leaves_no_connection(runtime, editor, serve):
    """.NET forgets a WebSocket's connection that comes about when nobody waits for it any more."""
    server, endpoint = serve("16_web_gateway", endpoint=two_ports())
    unity = editor(runtime)
    for i in range(5):
        unity.play("16_web_gateway", endpoint, 2)
        time.sleep(i / 100)
        unity.stop()
    # A gateway that has other things to do for a moment.
    os.kill(server.process.pid, signal.SIGSTOP)
    unity.play("16_web_gateway", endpoint, 2)
    unity.stop_in_time()
    time.sleep(0.5)
    os.kill(server.process.pid, signal.SIGCONT)
    unity.nothing_left()


@pytest.mark.parametrize("runtime", ["mono", "dotnet"])
def test_a_program_whose_netmq_never_ends_ends(runtime, play):
    program = play("forgotten", runtime=runtime)
    assert program.wait() == 0, program.output
    assert program.lines == ["forgotten"]


def test_netmq_that_never_ends(editor):
    """NetMQ waits for a socket that nobody disposed; before 4.0.4.1 it waits for ever on macOS, whatever was disposed.

    Stop keeps to its time, and the next Play says what is wrong: the first one soon, those after it at once.
    """
    unity = editor()
    unity.spoilt = True
    unity.play("ForgetfulClient", ABSENT)
    unity.wait_for("^asked")
    unity.stop_in_time()
    for _ in range(2):
        unity.play("ForgetfulClient", ABSENT)
        told = unity.wait_for(r"^gave up after (\d+) ms: (.*)")
        assert "dispose every socket" in told[2] and "macOS" in told[2] and "4.0.4.5" in told[2]
        unity.stop_in_time()
    assert int(told[1]) < 1000


def test_the_naive_client_kills_its_neighbour(editor, serve):
    """Cleanup() per client: when one is destroyed, the other stops getting replies."""
    unity = editor()
    unity.play("CleaningClient", serve("01_request_reply", "--delay", "0.002")[1], 2)
    unity.wait_for("^client 2: received World")
    unity.press("destroy", "^destroyed$")
    unity.program.wait_for("^client 2: (TerminatingException|ObjectDisposedException)$")


def test_the_naive_client_freezes(editor, silent):
    """An endless receive, joined in OnDestroy."""
    unity = editor()
    unity.play("EndlessClient", silent)
    unity.wait_for("^client 1: asked")
    unity.press("stop")
    with pytest.raises(AssertionError, match="no line match"):
        unity.wait_for("^stopped", limit=2)
    assert unity.program.process.poll() is None, unity.program.output
