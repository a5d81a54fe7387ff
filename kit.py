"""The one entry to the kit: does all set-up, runs a lesson, runs the tests.

    python3 kit.py run 1         lesson 01: the Python server and the C# client, side by side
    python3 kit.py server 1      only its server: for two terminals
    python3 kit.py client 1      only its client, in the other one
    python3 kit.py test          every test that this machine can run
    python3 kit.py list          the lessons
    python3 kit.py doctor        what is on this machine, and what is missing
    python3 kit.py bench         how fast it is, beside what people would pick instead
    python3 kit.py unity PATH    put the scripts and NetMQ's DLLs into your own Unity project
    python3 kit.py pack          bring along what a classroom without internet needs

Each command explains itself with examples: python3 kit.py run --help
On Windows type `py` instead of `python3`. Ctrl-C stops everything that was started. --version says which kit this is.
"""

import sys

if sys.version_info < (3, 11):
    sys.exit(
        "kit.py needs Python 3.11 or later, this is %d.%d: get one from https://www.python.org,"
        " and then open a new terminal" % sys.version_info[:2]
    )

import signal

if __name__ == "__main__" and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    # Until main() takes over nothing is there to be cleared up, and a Ctrl-C would only show a traceback.
    signal.signal(signal.SIGINT, signal.SIG_DFL)

import argparse
import io
import os
import re
from pathlib import Path

from kitlib import run as runner
from kitlib.commands import Command, Half, PassingOn, split, start
from kitlib.lessons import KIT, PACKAGES, ROOT, UNWRITABLE, KitError, find, lessons
from kitlib.setup import doctor, dotnet, pack, python_setup
from kitlib.terminal import coloured, end, interruptible, later, nobody_reads, say, spawn, wait
from kitlib.unity import install as unity_install
from lab import bench


def commands() -> list[Command]:
    """Every command, with what its --help says."""
    run = Command(
        "run",
        run_lesson,
        "Runs a lesson: starts its Python server and a client, shows both line by line, and stops the server.",
        [
            f"{KIT} run 1                            lesson 01 with the C# client",
            f"{KIT} run lazy-pirate --client unity   its Unity scripts, played without Unity",
            f'{KIT} run 4 --server="--drop 3"        the server loses request 3',
            f'{KIT} run 1 --options="--count 3"      the client asks three times',
        ],
        cure='what the client takes goes into --options="…", what the server takes into --server="…"',
    )
    run.add_argument("lesson", metavar="LESSON", help="its number or its name: 1, 01, request-reply")
    run.add_argument("--endpoint", help="where the server listens; tcp://127.0.0.1:0 takes a free port")
    run.add_argument("--server", default="", metavar="OPTIONS", help="options for the server; its own --help has them")
    run.add_argument("--options", default="", metavar="OPTIONS", help="options for the client; its own --help has them")
    server = Half(
        "server",
        run_server,
        "Runs a lesson's server in this terminal, until Ctrl-C. Other words than these are its own options.",
        [f"{KIT} server 1", f"{KIT} server 4 --drop 3   it loses request 3"],
    )
    server.add_argument("lesson", metavar="LESSON", help="its number or its name")
    client = Half(
        "client",
        run_client,
        "Runs a lesson's client in this terminal. Other words than these are its own options.",
        [f"{KIT} client 1 --count 3", f"{KIT} client 4 --client unity   its Unity scripts, played without Unity"],
    )
    client.add_argument("lesson", metavar="LESSON", help="its number or its name")
    for command in (run, client):
        command.add_argument(
            "--client", choices=("csharp", "python", "unity"), default="csharp", help="csharp, if not said"
        )
        command.add_argument(
            "--engine", choices=dotnet.ENGINES, help="NetMQ from NuGet, or the offline engine over libzmq"
        )
    packing = Command(
        "pack",
        fill,
        "Fetches what a room without internet needs: wheels for Python, NuGet packages, and where the installers are.",
        [
            f"{KIT} pack                                   into packages/, for this system",
            f"{KIT} pack D:/stick --system windows --python 3.13",
        ],
    )
    packing.add_argument(
        "folder", type=Path, nargs="?", default=PACKAGES, metavar="FOLDER", help="packages, if not said"
    )
    packing.add_argument("--system", choices=tuple(pack.SYSTEMS), help="the room's; this one, if not said")
    packing.add_argument("--python", metavar="VERSION", help="the room's; this one's, if not said")
    unity = Command(
        "unity",
        install,
        "Copies the Unity scripts and NetMQ's three DLLs into a Unity project. What you have changed there stays.",
        [
            f"{KIT} unity ../MyGame              the whole package",
            f"{KIT} unity ../MyGame --lesson 4   only what lesson 04 takes home",
        ],
        cure='a path with a space in it goes between quotation marks: unity "../My Game"',
    )
    unity.add_argument("project", type=Path, metavar="PATH", help="the folder that holds Assets and ProjectSettings")
    unity.add_argument("--lesson", help="copy only this lesson's take-home files")
    unity.add_argument("--force", action="store_true", help="overwrite files that were changed")
    tests = PassingOn(
        "test",
        test,
        "Runs every test that this machine can run, and says what it skipped and why.",
        [
            f"{KIT} test                    all of them: five minutes",
            f"{KIT} test 4                  what belongs to lesson 04: less than a minute",
            f"{KIT} test -k request_reply   those with this word in their name",
            f"{KIT} test --long             also those that take minutes each",
            f"{KIT} test -n 0               one after the other; otherwise side by side, with pytest-xdist",
            f"{KIT} test -- --help          pytest's own options",
        ],
    )
    tests.add_argument("words", metavar="WORD", nargs="*", help="a lesson, or any option of pytest")
    speed = Command(
        "bench",
        run_bench,
        "Measures the kit beside raw TCP, WebSocket, HTTP, gRPC and others, in rounds that take turns.",
        [
            f"{KIT} bench --quick   less than a minute, to see that it works",
            f"{KIT} bench           less than ten minutes; writes img/performance*, and wants a machine at rest",
            f"{KIT} bench --free    without a half of the processor cores for each side",
        ],
    )
    speed.add_argument("--quick", action="store_true", help="fewer and shorter rounds; results go into .build/bench")
    speed.add_argument(
        "--free", action="store_true", help="the system places the programs; results go into .build/bench"
    )
    speed.add_argument("--engine", choices=dotnet.ENGINES, help="NetMQ from NuGet, or the offline engine over libzmq")
    shows = "Shows what is on this machine and what is missing, each missing thing with its cure."
    return [
        run,
        server,
        client,
        tests,
        Command("list", list_lessons, "Shows the lessons: the name of each, and its idea.", [f"{KIT} list"]),
        Command("doctor", show_doctor, shows, [f"{KIT} doctor"]),
        speed,
        unity,
        packing,
    ]


def run_lesson(options: argparse.Namespace) -> int:
    """Set up what the lesson needs, then run it."""
    lesson = find(options.lesson)
    for_client, for_server = split(options.options, "--options"), split(options.server, "--server")
    python = python_setup.interpreter(lesson.key)
    client = runner.client_command(options.client, lesson, python, options.engine)
    return runner.run(lesson, python, [*client, *for_client], options.endpoint, for_server)


def run_server(options: argparse.Namespace) -> int:
    """The server alone."""
    lesson = find(options.lesson)
    python = python_setup.interpreter(lesson.key)
    return runner.alone([str(python), str(lesson.python / "server.py"), *options.words])


def run_client(options: argparse.Namespace) -> int:
    """The client alone."""
    lesson = find(options.lesson)
    python = python_setup.interpreter(lesson.key)
    command = runner.client_command(options.client, lesson, python, options.engine)
    return runner.alone([*command, *options.words])


def fill(options: argparse.Namespace) -> int:
    """Pack for a classroom."""
    pack.pack(options.folder, options.system, options.python)
    return 0


def test(options: argparse.Namespace) -> int:
    """Set up what the tests need, then run them."""
    optional = tuple(extra for extra in python_setup.all_extras() if extra != "tests")
    python = python_setup.interpreter("tests", optional=optional)
    say(f"testing with {python}")
    words = [*side_by_side(python, options.words), *of_a_lesson(options.words)]
    pytest = None
    try:
        with later():
            pytest = spawn([str(python), "-m", "pytest", *words], cwd=ROOT)
        return wait(pytest)
    finally:
        if pytest:
            # After Ctrl-C pytest ends the programs of the test that was running, and says how far it came.
            end(pytest, 60)


def of_a_lesson(words: list[str]) -> list[str]:
    """A lesson in front stands for what has its name: its own tests, its cases of the contract, its page."""
    if not words or words[0].startswith("-") or Path(words[0].split("::")[0]).exists():
        return words
    return ["-k", find(words[0]).key, "tests/lessons", "tests/docs", "tests/kit", *words[1:]]


def side_by_side(python: Path, words: list[str]) -> list[str]:
    """What makes pytest use the whole machine. Most tests wait for something: two for each core do well."""
    alone = any(re.match(r"-n|--dist|--co$|--collect-only|--pdb|-s$", word) for word in words)
    if alone or not python_setup.has(python, ["pytest-xdist"]):
        return []
    return ["-n", str(2 * (os.cpu_count() or 1)), "--dist", "loadgroup"]


def run_bench(options: argparse.Namespace) -> int:
    """Measure, print and draw."""
    return bench.bench(options.quick, options.free, options.engine)


def list_lessons(_: argparse.Namespace) -> int:
    """Print the lessons."""
    for lesson in lessons():
        print(f"{lesson.key:24} {lesson.title}")
    return 0


def show_doctor(_: argparse.Namespace) -> int:
    """Print what is here and what is missing, with the interpreter that the lessons use."""
    doctor.show(python_setup.found())
    return 0


def install(options: argparse.Namespace) -> int:
    """Install into a Unity project."""
    unity_install.install(options.project, options.lesson, options.force)
    return 0


def main() -> int:
    """Do what the command line says; returns the exit code."""
    # A legacy console code page must not turn a printed line into a traceback; and in a pipe every system gets UTF-8.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding=None if stream.isatty() else "utf-8", errors="backslashreplace")
    interruptible()
    try:
        return start(commands(), __doc__, sys.argv[1:])
    except KitError as error:
        print(coloured("kit    |", "error", sys.stderr), error, file=sys.stderr)
        return error.code
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        nobody_reads()
        return 1
    except OSError as error:
        # A full disk, a folder of somebody else's: whatever it is, the system's own words name it.
        why = UNWRITABLE if isinstance(error, PermissionError) else "free some space, or try another folder"
        print(coloured("kit    |", "error", sys.stderr), f"{error}; {why}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
