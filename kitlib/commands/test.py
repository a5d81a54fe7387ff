"""Runs the tests."""

import argparse
import os
import re
from pathlib import Path

from kitlib.lessons import ROOT, find
from kitlib.programs import end, spawn, wait
from kitlib.setup import python_setup
from kitlib.signals import later
from kitlib.terminal import say

ABOUT = "Runs every test that this machine can run, and says what it skipped and why. Other words are pytest's options."
EXAMPLES = [
    "test                    all of them: a quarter of an hour",
    "test 4                  what belongs to lesson 04: a minute or two",
    "test -k request_reply   those with this word in their name",
    "test --long             also those that take minutes each",
    "test -n 0               one after the other; otherwise side by side, with pytest-xdist",
    "test -- --help          pytest's own options",
]
PASSES_ON = True


def do(options: argparse.Namespace) -> int:
    """Set up what the tests need, then run them."""
    # What a webcam needs is large, and the tests have none. Ray is large as well, and tested where it is there.
    optional = tuple(e for e in python_setup.all_extras() if e != "tests" and not e.endswith(("_camera", "_ray")))
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
    return ["-k", find(words[0]).key, "tests/lessons", "tests/docs", "tests/kit", "tests/web", *words[1:]]


def side_by_side(python: Path, words: list[str]) -> list[str]:
    """What makes pytest use the whole machine. Most tests wait for something: three for each core do well."""
    alone = any(re.match(r"-n|--dist|--co$|--collect-only|--pdb|-s$", word) for word in words)
    if alone or not python_setup.has(python, ["pytest-xdist"]):
        return []
    return ["-n", str(3 * (os.cpu_count() or 1)), "--dist", "loadgroup"]
