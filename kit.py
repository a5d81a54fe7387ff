#!/usr/bin/env python3
"""The one entry to the kit: does all set-up, runs a lesson, runs the tests.

    python3 kit.py run 1         lesson 01: the Python server and the C# client, side by side
    python3 kit.py test          every test that this machine can run
    python3 kit.py list          the lessons
    python3 kit.py doctor        what is on this machine, and what is missing
    python3 kit.py unity PATH    put the scripts and NetMQ's DLLs into your own Unity project

Each command explains itself: python3 kit.py run --help
"""

import sys

if sys.version_info < (3, 11):
    sys.exit(
        "kit.py needs Python 3.11 or later, this is %d.%d: get one from https://www.python.org" % sys.version_info[:2]
    )

import argparse
import io
import shlex
import subprocess
from pathlib import Path

from kitlib import doctor, dotnet, python_setup, unity_install
from kitlib import run as runner
from kitlib.lessons import ROOT, KitError, find, lessons
from kitlib.terminal import coloured, say


def parser() -> argparse.ArgumentParser:
    top = argparse.ArgumentParser(
        prog="kit.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="run a lesson: python3 kit.py run 1 --client python")
    run.add_argument("lesson", help="its number or its name: 1, 01 or 01_request_reply")
    run.add_argument("--client", choices=("csharp", "python", "unity"), default="csharp")
    run.add_argument("--engine", choices=dotnet.ENGINES, help="NetMQ from NuGet, or the offline engine over libzmq")
    run.add_argument("--endpoint", help="where the server listens; port * takes a free one")
    run.add_argument("--server", default="", metavar="OPTIONS", help="options for the server: --server='--delay 1'")
    run.add_argument("--options", default="", metavar="OPTIONS", help="options for the client: --options='--count 3'")
    commands.add_parser("list", help="the lessons")
    commands.add_parser("doctor", help="what is on this machine, and what is missing")
    unity = commands.add_parser("unity", help="install into a project: python3 kit.py unity ../MyGame --lesson 4")
    unity.add_argument("project", type=Path, metavar="PATH", help="the folder that holds Assets and ProjectSettings")
    unity.add_argument("--lesson", help="copy only this lesson's take-home files")
    unity.add_argument("--force", action="store_true", help="overwrite files that were changed")
    commands.add_parser("test", help="run the tests: python3 kit.py test -k request_reply", add_help=False)
    return top


def run(options: argparse.Namespace) -> int:
    lesson = find(options.lesson)
    python = python_setup.interpreter(lesson.key)
    client = runner.client_command(options.client, lesson, python, options.engine)
    return runner.run(
        lesson, python, [*client, *shlex.split(options.options)], options.endpoint, shlex.split(options.server)
    )


def list_lessons() -> int:
    for lesson in lessons():
        print(f"{lesson.key:24} {lesson.title}")
    return 0


def test(arguments: list[str]) -> int:
    optional = tuple(extra for extra in python_setup.all_extras() if extra != "tests")
    python = python_setup.interpreter("tests", optional=optional)
    say(f"testing with {python}")
    return subprocess.run([python, "-m", "pytest", *arguments], cwd=ROOT).returncode


def unity(options: argparse.Namespace) -> int:
    unity_install.install(options.project, options.lesson, options.force)
    return 0


def show_doctor() -> int:
    required = python_setup.needs()
    here = [python_setup.venv_python(), Path(sys.executable), Path("/usr/bin/python3")]
    doctor.show(next((python for python in here if python.exists() and python_setup.has(python, required)), None))
    return 0


def main() -> int:
    options, rest = parser().parse_known_args()
    if options.command == "test":
        return test(rest)
    if rest:
        parser().error(f"unknown: {' '.join(rest)}")
    if options.command in ("run", "unity"):
        return {"run": run, "unity": unity}[options.command](options)
    return {"list": list_lessons, "doctor": show_doctor}[options.command]()


if __name__ == "__main__":
    # A legacy console code page must not turn a printed line into a traceback.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        sys.exit(main())
    except KitError as error:
        sys.exit(f"{coloured('kit    |', 'error')} {error}")
    except KeyboardInterrupt:
        sys.exit(130)
