"""Shows the lessons."""

import argparse

from kitlib.lessons import lessons

ABOUT = "Shows the lessons: the name of each, and its idea."
EXAMPLES = ["list"]


def do(_: argparse.Namespace) -> int:
    for lesson in lessons():
        print(f"{lesson.key:24} {lesson.title}")
    return 0
