"""Shows the lessons, and the applications after them."""

import argparse

from kitlib.lessons import lessons

ABOUT = "Shows the lessons and the applications: the name of each, and its idea."
EXAMPLES = ["list"]


def do(_: argparse.Namespace) -> int:
    for title, shown in (("lessons", False), ("applications", True)):
        print(f"{title}:")
        for lesson in lessons():
            if lesson.is_application == shown:
                print(f"  {lesson.key:24} {lesson.title}")
    return 0
