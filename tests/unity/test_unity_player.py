"""The player and its stand-in of Unity: Unity's signatures, Unity's order of events, the command line."""

import itertools
import signal
import sys

import pytest

from kitlib.setup import dotnet
from kitlib.unity.inventory import LIBRARIES
from tests.programs import ROOT
from tests.unity.conftest import Editor


def test_what_netmq_names_is_there_and_no_more(harness):
    """IL2CPP's linker wants every name in NetMQ.dll, and in what that names, to be found."""
    nuget = dotnet.nuget_folder()
    dlls = [nuget / name.lower() / number / inside for name, number, inside in LIBRARIES]
    if not all(dll.exists() for dll in dlls):
        pytest.skip("it needs NetMQ from NuGet: kit.py run 1 fetches it")
    editor = Editor(["dotnet", str(harness), "editor"], ROOT)
    needed = {name for dll in dlls for name in editor.do(f"references {dll}")}
    editor.do("quit")
    # Unity's .NET Standard 2.1 forwards these.
    assert needed - {"netstandard", "System.Buffers", "System.Memory"} == {dll.stem for dll in dlls} - {"NetMQ"}


def test_scripts_may_do_here_what_they_do_in_unity(play):
    program = play("habits")
    assert program.wait() == 0, program.output
    end = program.lines.index("OnDestroy") + 1
    # After a long frame several FixedUpdates come in the next one.
    events = [line for line, _ in itertools.groupby(program.lines[:end]) if not line.startswith("   ")]
    refused = "Script error: Refused.OnEnable() can not be a coroutine."
    for line in (refused, "System.InvalidOperationException: in Update"):
        events.remove(line)
    assert events == [
        "Awake",
        "OnEnable",
        "OnApplicationPause False",
        "Start in frame 1",
        "FixedUpdate",
        "Update, deltaTime is capped: True",
        "after await, on the main thread: True",
        "LateUpdate, destroyed is null: False",
        "off the main thread: get_time can only be called from the main thread.",
        "FixedUpdate",
        "Update, deltaTime is capped: True",
        "after await, on the main thread: True",
        "LateUpdate, destroyed is null: True",
        "off the main thread: get_time can only be called from the main thread.",
        "OnApplicationQuit",
        "OnDisable",
        "OnDestroy",
    ]
    happened = [
        "a line",
        "shown: a line",
        f"shown: {'a' * 59}|b|{'c' * 70}|d|{'e' * 60}|f",
        "a cube: (0.00, 1.00, 0.00)",
        *["drawn by: Standard"] * 3,
        "drawn by: Sprites/Default",
        "drawn by: Standard",
        "drawn by: Universal Render Pipeline/Lit",
        "HelloWeb: False",
        "Application.runInBackground is now true",
        *["HelloWeb: True"] * 2,
    ]
    assert [line for line in program.lines[end:] if line in happened] == happened


# Each of these scripts has a Play of its own, and prints this. Game developers write their first ones like them.
FIRST = {
    "Waiting": """
Start in frame 1
null: frame 2, after Update: True
end of frame 2, after LateUpdate: True
a step: True, before Update: True
seconds: True
real seconds: True, of none in the game: True, True
until and while: 4
no wait at all: 4
a frame: 5
begins: a part of it
ends: a part of it
begins: one of its own
ends: one of its own
all in 7 frames
begins: by its name
ends: by its name
nothing to wait for: 8
errors: 0""",
    "Stopping": """
by its routine: ended
by its handle, with what is inside: ended
by its name: ended
all: ended
switched off: goes on
with the object above it: ended
Coroutine couldn't be started because the the game object 'counter' is inactive!
none: True
active again: ended
System.InvalidOperationException: in a coroutine
after another has failed: goes on
destroyed: ended
errors: 2""",
    "Seeing": """
frame 3: 8 bytes
System.InvalidOperationException: in a callback
errors: 1""",
}


@pytest.mark.parametrize("script", FIRST)
def test_first_scripts_play_as_in_unity(script, play):
    program = play("first", script)
    assert program.wait() == 0, program.output
    # Without the places of an exception.
    lines = [line for line in program.lines if not line.startswith("   at ")]
    assert lines == FIRST[script].strip().splitlines()


def test_keys_of_the_input_system_and_of_none(play):
    """For lessons 08 to 10. Where a project listens to nothing that the kit knows, one line says what to do."""
    program = play("keys")
    assert program.wait() == 0, program.output
    cure = (
        "no keyboard: install the package Input System, or set Project Settings, Player, Active Input Handling to Both"
    )
    program.lines.remove(cure)
    assert program.lines == [
        "no keyboard 0 0 False False",
        "Space 0 0 True False",
        "Enter 0 0 False True",
        "A -1 0 False False",
        "D 1 0 False False",
        "S 0 -1 False False",
        "W 0 1 False False",
        "LeftArrow -1 0 False False",
        "RightArrow 1 0 False False",
        "UpArrow 0 1 False False",
        "DownArrow 0 -1 False False",
        *["nothing 0 0 False False"] * 2,
    ]


def test_plays_the_console_twins_lines(runs, serve):
    """Its options set the fields of these names; one class is set apart from all, in whatever order."""
    endpoint = serve("01_request_reply")[1]
    (console,) = runs("csharp", "1", [["--endpoint", endpoint, "--count", "3"]])
    each = [
        ["--endpoint", endpoint, "--count", "3"],
        ["--set", f"endpoint={endpoint}", "--set", "count=3"],
        ["--HelloClient.endpoint", endpoint, "--HelloClient.count", "3", "--endpoint", "tcp://127.0.0.1:9"],
        ["--set", "HelloClient.count=3", "--count", "4", "--endpoint", endpoint],
    ]
    assert runs("unity", "1", each) == [console] * len(each)
    assert console.code == 0 and console.lines[-1] == "done: 3 replies"


def test_wrong_usage_is_one_line_and_code_2(runs):
    table = {
        "--set nope=3": "unknown: --nope; the fields that a script has here: endpoint count timeout",
        "--MyClient.count 3": "unknown: --MyClient.count; the fields that a script has here",
        "--set count=three": "'three' is no whole number",
        "--count three": "--count: 'three' is no whole number",
        "--count -1": "--count: it must be at least 0, not -1",
        "--timeout NaN": "--timeout: it must be at least 0.01, not NaN",
        "--help": "--endpoint tcp://127.0.0.1:5551  --count 10  --timeout 2.5",
        "--set count": "--set takes name=value",
        "--frames 3": "unknown: --frames",
    }
    for (words, says), (code, lines) in zip(
        table.items(), runs("unity", "1", [words.split() for words in table]), strict=True
    ):
        assert code == 2 and len(lines) == 1 and says in lines[0], (words, lines)
    ((code, lines),) = runs("unity", "99", [[]])
    assert code == 2 and len(lines) == 1 and "which lesson?" in lines[0]


def test_how_a_play_ends(runs):
    waits = ["--endpoint", "tcp://127.0.0.1:9", "--timeout", "60", "--seconds", "2"]
    ended, refused = runs("unity", "1", [waits, ["--endpoint", "127.0.0.1:5551"]])
    # On a busy machine not even this.
    assert ended.code == 0 and ended.lines in ([], ["asking tcp://127.0.0.1:9"])
    # An error in the log.
    assert refused.code == 1 and "write it like tcp://" in "".join(refused.lines)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no signals to another process")
def test_a_signal_ends_the_play_properly(console, start):
    played = start(*console, "1", "--unity", "--set", "endpoint=tcp://127.0.0.1:9", "--set", "timeout=60")
    played.wait_for("^asking")
    assert played.stop(signal.SIGINT, limit=30) == 1
    assert played.lines[-1] == "stopped"
