"""Runs a lesson's server alone."""

import argparse

from kitlib.commands.run import server_command
from kitlib.lessons import find
from kitlib.programs import alone
from kitlib.setup import python_setup

ABOUT = "Runs a lesson's server in this terminal, until Ctrl-C. Other words than these are its own options."
EXAMPLES = ["server 1", "server 2 --drop 3   it loses reply 3"]
PASSES_ON = True


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("lesson", metavar="LESSON", help="its number or its name")


def do(options: argparse.Namespace) -> int:
    lesson = find(options.lesson)
    python = python_setup.interpreter(lesson.key)
    return alone([*server_command(lesson, python), *options.words], lesson.folder())
