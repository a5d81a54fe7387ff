"""Runs a lesson's server alone."""

import argparse
import socket
import sys
from pathlib import Path

from kitlib.commands.run import add_folder, behind, own_options, run, server_command
from kitlib.imports import IMPORT_NAME, PYTHON
from kitlib.lessons import ROOT, UsageError, find, lessons
from kitlib.programs import run_in_terminal
from kitlib.reload import run_reloading
from kitlib.setup import python_setup
from kitlib.terminal import say

ABOUT = "Runs a lesson's server in this terminal, until Ctrl-C. Other words are its own options: `server 2 --help`."
EXAMPLES = [
    "server 1",
    "server 2 --drop 3   it loses reply 3",
    "server 2 --reload   change its answer and save: it is started anew, and its clients go on",
]
PASSES_ON = True
# The commands that show a machine's addresses.
SHOWS = {"win32": "ipconfig", "linux": "hostname -I"}


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("lesson", metavar="LESSON", help="its number or its name, or a server.py of yours")
    add_folder(parser)
    parser.add_argument("--reload", action="store_true", help="start it anew when it is saved, or was killed")


def program_help(lesson: str) -> str:
    return "" if lesson.endswith(".py") else own_options(lesson, "server.py")


def do(options: argparse.Namespace) -> int:
    if options.lesson.endswith(".py"):
        return own(Path(options.lesson).absolute(), options)
    lesson = find(options.lesson)
    if options.reload:
        where = ["--folder", str(options.folder)] if options.folder else []
        again = [sys.executable, str(ROOT / "kit.py"), "server", lesson.key, *where, "--", *options.words]
        others = [other.python for _, other in lesson.behind]
        return run_reloading(again, [lesson.python, *others, PYTHON / IMPORT_NAME])
    python = python_setup.interpreter(lesson.key)
    if any("0.0.0.0" in word for word in options.words):
        say(f"0.0.0.0 stands for every network of this machine; in a client's --endpoint take instead {address()}")
    command, folder = [*server_command(lesson, python), *options.words], lesson.folder(options.folder)
    if lesson.behind and "--help" not in options.words:
        return run(folder, command, [], [], behind(lesson, python, options.words), [])
    return run_in_terminal(command, folder)


def own(program: Path, options: argparse.Namespace) -> int:
    """A server of the reader's own, such as one that `kit.py copy` began."""
    if not program.is_file():
        raise UsageError(f"there is no file {program}: name a lesson, or a server.py of yours")
    key = program.parent.name
    python = python_setup.interpreter(key if key in {lesson.key for lesson in lessons()} else lessons()[0].key)
    command = [str(python), str(program), *options.words]
    if options.reload:
        folders = [program.parent, *(folder / IMPORT_NAME for folder in program.parents[:2])]
        return run_reloading(command, [folder for folder in folders if folder.is_dir()])
    return run_in_terminal(command, Path.cwd())


def address() -> str:
    """By which others reach this machine: its address in the network through which it would answer them."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # For a datagram this only chooses the network: nothing is sent.
            probe.connect(("192.0.2.1", 9))
            return str(probe.getsockname()[0])
        except OSError:
            # Where no router is, as in many a classroom, the system does not say which address others know.
            return f"its address, which `{SHOWS.get(sys.platform, 'ifconfig')}` shows"
