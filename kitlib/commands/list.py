"""Shows the lessons, and the applications after them."""

import argparse

from kitlib.lessons import lessons

ABOUT = "Shows the lessons and the applications: the name of each, and its idea."
EXAMPLES = ["list"]


def do(_: argparse.Namespace) -> int:
    found = lessons()
    # Applications teach nothing new: they show what people build with the lessons before them.
    for title, chosen in {"lessons": range(20), "applications": range(20, 100)}.items():
        print(f"{title}:")
        for lesson in found:
            if lesson.number in chosen:
                print(f"  {lesson.key:24} {lesson.title}")
    return 0
