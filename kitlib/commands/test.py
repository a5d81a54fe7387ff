"""Runs the tests."""

import argparse

from kitlib.lessons import ROOT
from kitlib.programs import end, spawn, wait
from kitlib.setup import python_setup
from kitlib.signals import later
from kitlib.terminal import say

ABOUT = "Runs every test that this machine can run, and says what it skipped and why. Other words are pytest's options."
EXAMPLES = [
    "test                    all of them: a quarter of an hour",
    "test -k request_reply   those with this word in their name",
    "test --long             also those that take minutes each",
    "test -- --help          pytest's own options",
]
PASSES_ON = True


def do(options: argparse.Namespace) -> int:
    """Set up what the tests need, then run them."""
    optional = tuple(extra for extra in python_setup.all_extras() if extra != "tests")
    python = python_setup.interpreter("tests", optional=optional)
    say(f"testing with {python}")
    pytest = None
    try:
        with later():
            pytest = spawn([str(python), "-m", "pytest", *options.words], cwd=ROOT)
        return wait(pytest)
    finally:
        if pytest:
            # After Ctrl-C pytest ends the programs of the test that was running, and says how far it came.
            end(pytest, 60)
