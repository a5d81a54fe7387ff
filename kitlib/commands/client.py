"""Runs a lesson's client alone."""

import argparse

from kitlib.commands.run import add_client, add_folder, client_command, own_options
from kitlib.lessons import find
from kitlib.programs import run_in_terminal

ABOUT = "Runs a lesson's client in this terminal. Other words are its own options: `client 2 --help`."
EXAMPLES = ["client 1 --count 3", "client 4 --client unity   its Unity scripts, played without Unity"]
PASSES_ON = True


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("lesson", metavar="LESSON", help="its number or its name")
    add_folder(parser)
    add_client(parser)


def program_help(lesson: str) -> str:
    return f"with --client python; the others have most of them:\n{own_options(lesson, 'client.py')}"


def do(options: argparse.Namespace) -> int:
    lesson = find(options.lesson)
    command = client_command(options.client, lesson)
    return run_in_terminal([*command, *options.words], lesson.folder(options.folder))
