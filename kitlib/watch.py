"""`run N --watch` puts lesson 16's tap between the lesson's two sides, and opens its page in a browser."""

import os
import sys
import webbrowser
from pathlib import Path

from kitlib.lessons import KitError, Lesson
from kitlib.programs import Program
from kitlib.terminal import say

# The tap needs this extra beyond the core.
EXTRA = "16_web_gateway"
# So many seconds a browser has to open the page.
TIMEOUT = 20.0


def tap_command(lesson: Lesson, python: Path | str) -> list[str]:
    """The words that start it, but for the servers that it stands in front of."""
    program, title = Lesson(EXTRA).python / "tap.py", f"Lesson {lesson.number:02}: {lesson.key[3:].replace('_', ' ')}"
    return [str(python), str(program), "--endpoint", "tcp://127.0.0.1:0", "--title", title]


def open_page(tap: Program) -> None:
    """Open it before there is a client, so that its first messages are seen as they pass."""
    page = tap.wait_for(r"^page at (\S+)")[1]
    # Without a display Python may find a browser that takes over this terminal.
    display = sys.platform in ("win32", "darwin") or {"DISPLAY", "WAYLAND_DISPLAY", "BROWSER"} & set(os.environ)
    opened = display and webbrowser.open(page)
    say(f"{'opening' if opened else 'open'} {page} in a browser; the client starts then, or after {TIMEOUT:.0f} s")
    try:
        tap.wait_for("^a page looks on$", TIMEOUT)
    except KitError:
        say("no page is open; the client starts, and a page that is opened later shows the latest messages")
