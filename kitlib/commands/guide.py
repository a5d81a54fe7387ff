"""Opens the guide in the browser, where its commands run by a button."""

import argparse
from contextlib import suppress
from pathlib import Path

from kitlib.commands import run
from kitlib.guide_page import answers
from kitlib.lessons import ROOT, KitError, find
from kitlib.programs import run_in_terminal
from kitlib.setup import python_setup

ABOUT = "Opens the guide in your browser, from this machine: its commands run by a button, and your answers by another."
EXAMPLES = [
    "guide                            until Ctrl-C; no internet is needed",
    "guide --folder ../anna           what you change and what you have done is kept there",
    "guide --no-answers               for pupils: the pages without their answers",
    "guide --report ../anna ../bo     a teacher's table: which exercises are done",
]


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--folder", type=Path, metavar="DIR", help="for your answers; else the kit's folder answers")
    parser.add_argument("--no-answers", dest="answers", action="store_false", help="leave out what folds as an answer")
    parser.add_argument("--report", type=Path, nargs="+", metavar="FOLDER", help="print a table of these folders")


def do(options: argparse.Namespace) -> int:
    if options.report:
        return answers.report(options.report)
    folder = (options.folder or ROOT / "answers").resolve()
    try:
        from kitlib.guide_page import server
    except ModuleNotFoundError:
        words = [*(["--folder", folder] if options.folder else []), *([] if options.answers else ["--no-answers"])]
        # Lesson 16's packages draw the arrows, and a lesson is no time to install them.
        python = python_setup.interpreter("guide", optional=(run.EXTRA,))
        return run_in_terminal([python, ROOT / "kit.py", "guide", *words])
    # Built now, since in the page whatever is pressed next would end a build that takes a minute.
    with suppress(KitError):
        run.client_command(None, find("1"))
    return server.serve(folder, folder / "runs" if options.folder else None, options.answers)
