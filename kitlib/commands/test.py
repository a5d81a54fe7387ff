"""Runs the tests."""

import argparse
import os
import re
from pathlib import Path

from kitlib.lessons import ROOT, Lesson, UsageError, find, lessons
from kitlib.programs import end, spawn, wait
from kitlib.setup import python_setup
from kitlib.terminal import say

ABOUT = "Runs every test that this machine can run, and says what it skipped and why. Other words are pytest's options."
EXAMPLES = [
    "test                    all of them: five to ten minutes",
    "test 4                  what belongs to lesson 04: less than one",
    "test -k request_reply   those with this word in their name; also of one lesson: test 4 -k slow",
    "test --long             also those that take minutes each",
    "test -n 0               one after the other; otherwise side by side, with pytest-xdist",
    "test -- --help          pytest's own options",
]
PASSES_ON = True
# Where it is tested what a lesson does. Its page and its style are for all tests together.
FOLDERS = ("tests/lessons", "tests/web")
# The rules of those who change the kit, with the versions of the linters that they use.
HOUSE = "tests/house"


def do(options: argparse.Namespace) -> int:
    lesson = lesson_of(options.words)
    check_paths(options.words[1:] if lesson else options.words)
    house = ["style"] if any(word.startswith(HOUSE) for word in options.words) else []
    python = python_setup.interpreter("tests", *house, optional=optional(lesson))
    say(f"testing with {python}")
    chosen = of_a_lesson(lesson, options.words[1:]) if lesson else options.words
    words = [*side_by_side(python, options.words), *chosen]
    # The workers and a thousand programs would each compile anew what they import.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    pytest = spawn([str(python), "-m", "pytest", *words], cwd=ROOT)
    try:
        return wait(pytest, "pytest")
    finally:
        # After Ctrl-C pytest ends the programs of the test that was running, and says how far it came.
        end(pytest, 60)


def lesson_of(words: list[str]) -> Lesson | None:
    """The lesson that the first word names, if it is no option and no path."""
    if not words or words[0].startswith("-") or "/" in words[0] or words[0].endswith(".py") or is_there(words[0]):
        return None
    return find(words[0])


def is_there(word: str) -> bool:
    """Whether it is a file or folder of tests, as seen from the kit's own folder, where pytest runs."""
    return (ROOT / word.split("::")[0]).exists()


def check_paths(words: list[str]) -> None:
    """UsageError: a word is no option, no value of one, and no file. Side by side pytest itself would be silent."""
    for before, word in zip(["", *words], words, strict=False):
        if not word.startswith("-") and not before.startswith("-") and not is_there(word):
            raise UsageError(f"there is no {word}; test takes one lesson, or files, and pytest's options, such as -k")


def optional(lesson: Lesson | None) -> tuple[str, ...]:
    """The extras that the tests use where they are there. A lesson builds on all before it, and so do its tests."""
    if not lesson:
        return tuple(python_setup.tests_extras())
    return ("tests-more", *(each.key for each in lessons() if each.number <= lesson.number))


def of_a_lesson(lesson: Lesson, more: list[str]) -> list[str]:
    """Pytest's words for the tests with the lesson's name: its own, and its cases of the contract."""
    own = f"test_{lesson.number:02}_"
    # The other lessons' tests are not even read: they may need packages that this one does not.
    others = [path for path in ROOT.glob("tests/*/test_[0-9]*.py") if not path.name.startswith(own)]
    # pytest goes by the last -k alone.
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("-k")
    options, more = parser.parse_known_args(more)
    which = f"({lesson.key} or {own}) and ({options.k})" if options.k else f"{lesson.key} or {own}"
    return ["--tb=short", "-k", which, *FOLDERS, *(f"--ignore={path}" for path in others), *more]


def side_by_side(python: Path, words: list[str]) -> list[str]:
    """The words with which pytest uses the whole machine. Most tests wait for something: four for each core do well."""
    alone = any(re.match(r"-n|--dist|--co$|--collect-only|--pdb|-s$", word) for word in words)
    if alone or not python_setup.has(python, ["pytest-xdist"]):
        return []
    return ["-n", str(4 * (os.cpu_count() or 1)), "--dist", "loadgroup"]
