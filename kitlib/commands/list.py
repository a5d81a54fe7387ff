"""Shows the lessons."""

from __future__ import annotations

import argparse

from kitlib.lessons import lessons

ABOUT = "Shows the lessons: the name of each, and its idea."
EXAMPLES = ["list"]


def add_options(_: argparse.ArgumentParser) -> None:
    pass


def do(_: argparse.Namespace) -> int:
    for lesson in lessons():
        print(f"{lesson.key:24} {lesson.title}")
    return 0
