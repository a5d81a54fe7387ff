"""Draws what lessons 03 to 06 do, from a run of their own programs: python3 -m kitlib.docs.lesson_pictures

03_circle.svg, 04_frames.svg, 05_rows.svg and 06_time_lines.svg in img, or those that are named: `… 03 06`. Lesson 05
needs numpy; in 05 and 06 lesson 16's tap looks on, which needs aiohttp. On a machine that does something else as well
the frames of lesson 04 are not equal: then draw it again.
"""

from __future__ import annotations

import base64
import gzip
import json
import re
import sys
import tempfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from kitlib.docs.pictures import ARROW, INK, LINE, PROCESS, arrow, card, text
from kitlib.docs.tap_recordings import record
from kitlib.lessons import ROOT, find
from kitlib.programs import Program

# Narrower than GitHub's column, so that a telephone shows letters that can be read.
WIDTH = 640
SLOW = "#bc4c00"


def axis(left: float, top: float, bottom: float, scale: float) -> list[str]:
    """A line for each half second; what is drawn upon it begins at 0."""
    parts = [f"<path d='M{left} {bottom} H{WIDTH - 24}' stroke='{LINE}'/>"]
    for half in range(int(2 * (WIDTH - 24 - left) / scale) + 1):
        x = left + scale * half / 2
        parts += [f"<path d='M{x:.1f} {top} V{bottom + 5}' stroke='{LINE}'/>", text(x, bottom + 20, f"{half / 2:g} s")]
    return parts


def started(*words: str | Path) -> Program:
    return Program([sys.executable, *words])


# Lesson 03: the places that three listeners received, at one moment of one run.


class Heard(NamedTuple):
    """The numbers and places of the poses that a listener has taken."""

    numbers: list[int]
    places: list[tuple[float, float]]


def circle_run() -> dict[str, Heard]:
    """Two listeners take 0.1 s for each pose, and one comes late; until that one has received pose 300."""
    lesson, slow = find("3").python, ("--work", "0.1")
    programs = {"server": started(lesson / "server.py", "--endpoint", "tcp://127.0.0.1:0")}
    try:
        endpoint = programs["server"].endpoints()["endpoint"]
        listen = (lesson / "client.py", "--every", "1", "--count", "1000", "--endpoint", endpoint)
        programs["queue"] = started(*listen, *slow)
        programs["conflate"] = started(*listen, *slow, "--conflate")
        programs["conflate"].wait_for(r"pose/ \d{3} ")
        programs["late"] = started(*listen)
        programs["late"].wait_for(r"pose/ [3-9]\d\d ")
        lines = {name: programs[name].lines[:] for name in ("late", "queue", "conflate")}
    finally:
        for program in programs.values():
            program.end()
    return {name: heard(said) for name, said in lines.items()}


def heard(lines: list[str]) -> Heard:
    poses = [line.split()[2:] for line in lines if line.startswith("received pose/ ")]
    return Heard([int(pose[0]) for pose in poses], [(float(pose[1]), float(pose[3])) for pose in poses])


def circle(run: dict[str, Heard]) -> str:
    """A circle for each listener, seen from above: x to the right, z up, as in Unity."""
    said = {
        "late": ("comes late", "the beginning is lost"),
        "queue": ("takes 0.1 s for each", "every pose, but old ones"),
        "conflate": ("and with CONFLATE", "few poses, but new ones"),
    }
    # The one that keeps up knows best where the cube is.
    now = run["late"].places[-1]
    parts = []
    for i, (name, (what, then)) in enumerate(said.items()):
        x, y, scale = 112 + 208 * i, 164, 46
        path = f"<circle cx='{x}' cy='{y}' r='{2 * scale}' fill='none' stroke='{LINE}' stroke-dasharray='1 4'/>"
        dots = [
            f"<circle cx='{x + scale * right:.1f}' cy='{y - scale * ahead:.1f}' r='3'/>"
            for right, ahead in run[name].places
        ]
        cube = f"<rect x='{x + scale * now[0] - 8:.1f}' y='{y - scale * now[1] - 8:.1f}' width='16' height='16' "
        parts += [
            text(x, 34, what, 15),
            text(x, 54, then),
            path,
            f"<g id='{name}' fill='{ARROW}'>{''.join(dots)}</g>",
            f"{cube}fill='none' stroke='{SLOW}' stroke-width='3'/>",
            text(x, y - 4, f"{len(dots)} poses,", 14),
            text(x, y + 16, f"the last is {run[name].numbers[-1]}", 14),
        ]
    parts += [
        f"<circle cx='120' cy='291' r='4' fill='{ARROW}'/>",
        text(132, 296, "a pose received", anchor="start"),
        f"<rect x='274' y='283' width='16' height='16' fill='none' stroke='{SLOW}' stroke-width='3'/>",
        text(300, 296, f"where the cube is now: pose {run['late'].numbers[-1]}", anchor="start"),
    ]
    title = "The places on the circle that three listeners of lesson 03 have received, at the same moment"
    return card(WIDTH, 318, title, *parts)


# Lesson 04: how long each frame of two games takes, of which one waits for its replies.

# The client as it is, but for a line where a frame pauses.
WATCHED = """
import runpy, sys, time
sleep = time.sleep
def pause(seconds):
    if seconds == 1 / 60: print("frame", time.perf_counter(), flush=True)
    sleep(seconds)
time.sleep = pause
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def frames_run() -> dict[str, list[float]]:
    """The seconds at which the frames end, blocking and not, while the third reply comes two seconds late."""
    lesson, ends = find("4").python, {}
    for name, words in (("blocking", ["--naive"]), ("background", [])):
        server = started(lesson / "server.py", "--endpoint", "tcp://127.0.0.1:0", "--slow-on", "3")
        try:
            endpoint = server.endpoints()["endpoint"]
            game = started("-c", WATCHED, lesson / "client.py", "--endpoint", endpoint, "--timeout", "5", *words)
            game.wait_for("^done")
            game.end()
            ends[name] = [float(line.split()[1]) for line in game.lines if line.startswith("frame ")]
        finally:
            server.end()
    return ends


def frames(run: dict[str, list[float]]) -> str:
    """A strip for each game; a frame is as broad as it is long."""
    said = {"blocking": "waits for its reply: --naive", "background": "goes on, with BackgroundClient"}
    left, bottom = 36, 236
    scale = (WIDTH - 24 - left) / max(ends[-1] - ends[0] for ends in run.values())
    parts = axis(left, bottom, bottom, scale)
    for i, (name, ends) in enumerate(run.items()):
        y = 44 + 106 * i
        times = [end - begin for begin, end in pairwise(ends)]
        shapes = [
            f"<rect x='{left + scale * (begin - ends[0]):.2f}' y='{y}' width='{scale * (end - begin):.2f}' height='44' "
            f"fill='{SLOW if end - begin > 1 else PROCESS}'/>"
            for begin, end in pairwise(ends)
        ]
        parts += [
            text(left, y - 12, f"a game that {said[name]}", 15, "start"),
            f"<g id='{name}' stroke='{INK}' stroke-width='.7'>{''.join(shapes)}</g>",
            text(left + 4, y + 64, f"the longest of {len(times)} frames: {1000 * max(times):,.0f} ms", anchor="start"),
        ]
    parts.append(text(left, 286, "A box is a frame, from the second one on. Reply 3 comes 2 s late.", anchor="start"))
    return card(WIDTH, 304, "Frames of two games of lesson 04 while a reply is two seconds late", *parts)


# Lessons 05 and 06: what the tap saw of them.


class Message(NamedTuple):
    seconds: float
    up: bool
    frames: list[bytes]


def tapped(number: str, words: str) -> list[Message]:
    """Every message between a lesson's client and its server, in the order in which they passed."""
    with tempfile.TemporaryDirectory() as folder:
        record(number, words, "", folder, page := Path(folder) / "recording.html")
        packed = re.search(r'id="recording">([^<]+)<', page.read_text(encoding="utf-8"))
    assert packed, "a page that holds a recording"
    arrows = json.loads(gzip.decompress(base64.b64decode(packed[1])))["arrows"]
    return [
        Message(each["seconds"], each["way"] == "up", [base64.b64decode(data) for _, data in each["frames"]])
        for each in arrows
        if each["frames"] and not each["command"]
    ]


class Picture(NamedTuple):
    """Pixels as they were sent, and where the server saw the brightest one."""

    rows: list[bytes]
    place: tuple[int, int]


def rows_run() -> Picture:
    """The eighth picture of lesson 05."""
    request, reply = tapped("05", "--count 8 --timeout 60")[-2:]
    # Without REQ's empty frame.
    header, pixels = request.frames[-2:]
    height, width, depth = json.loads(header)["arrays"][0]["shape"]
    assert (height, width, depth, len(pixels)) == (240, 320, 3, 230_400)
    values = json.loads(reply.frames[-1])["values"]
    step = width * depth
    return Picture([pixels[i : i + step] for i in range(0, len(pixels), step)], (values["x"], values["y"]))


def rows(run: Picture) -> str:
    """The same rows from the bottom up and from the top down, and the server's place in both."""
    scale, parts = 0.8, list[str]()
    grey = "".join(f"{byte:02x}" for byte in run.rows[0][:3])
    for i, (name, what, then) in enumerate(
        (("upright", "row 0 is the lowest, as in Unity", "upright"), ("turned", "row 0 is the top one", "upside down"))
    ):
        x, y, begin, way = 46 + 312 * i, 66, *((192, -192) if name == "upright" else (0, 192))
        bright = []
        for number, row in enumerate(run.rows):
            if white := row.count(b"\xff\xff\xff"):
                place = f"x='{row.index(255) // 3}' y='{239 - number if name == 'upright' else number}'"
                bright.append(f"<rect {place} width='{white}' height='1'/>")
        parts += [
            text(x + 128, 34, what, 15),
            text(x + 128, 54, then),
            f"<g id='{name}' transform='translate({x} {y}) scale({scale})' fill='#fff' font-size='17'>"
            f"<path fill='#{grey}' d='M0 0 h320 v240 h-320 z'/>{''.join(bright)}"
            f"<text x='8' y='{228 if begin else 22}'>row 0</text><text x='8' y='{22 if begin else 228}'>row 239</text>"
            # The server counts from the top left.
            f"<circle cx='{run.place[0] + 4}' cy='{run.place[1] + 4}' r='16' fill='none' "
            "stroke='#ffb000' stroke-width='3'/></g>",
            *arrow(x - 12, y + begin, 0, way),
        ]
    x, y = run.place
    parts += [
        "<circle cx='58' cy='286' r='10' fill='none' stroke='#b87a00' stroke-width='3'/>",
        text(78, 291, f"where the server saw the white square: x {x}, y {y} from the top left", anchor="start"),
    ]
    return card(WIDTH, 312, "The same 230,400 bytes of lesson 05 as a picture, upright and upside down", *parts)


class Request(NamedTuple):
    """A request's text, and the seconds at which it and its reply passed."""

    text: str
    sent: float
    replied: float


def time_lines_run() -> dict[int, list[Request]]:
    """The six requests of lesson 06, with one in flight and with four."""
    runs = {}
    for window in (1, 4):
        messages = tapped("06", f"--window {window}")
        replied = {message.frames[0]: message.seconds for message in messages if not message.up}
        asked = [message for message in messages if message.up]
        runs[window] = [Request(m.frames[1].decode(), m.seconds, replied[m.frames[0]]) for m in asked]
    return runs


def time_lines(run: dict[int, list[Request]]) -> str:
    """A bar for each request, from its way to the server to the reply's way back."""
    said = {1: "one after the other: --window 1", 4: "four in flight: the default"}
    parts, left, y = list[str](), 130, 0
    scale = (WIDTH - left - 36) / max(each.replied - run[window][0].sent for window in run for each in run[window])
    for window, requests in run.items():
        began, end = requests[0].sent, max(each.replied for each in requests)
        bottom = y + 47 + 20 * len(requests)
        parts.append(text(24, y + 32, f"{said[window]}; all are done after {end - began:.1f} s", 15, "start"))
        parts += axis(left, y + 42, bottom, scale)
        bars = []
        for i, each in enumerate(requests):
            parts.append(text(left - 10, y + 56 + 20 * i, f"{i + 1}: {each.text}", anchor="end"))
            # What takes a millisecond is to be seen as well.
            place = f"x='{left + scale * (each.sent - began):.1f}' y='{y + 44 + 20 * i}'"
            bars.append(f"<rect {place} width='{max(4, scale * (each.replied - each.sent)):.1f}' height='14' rx='2'/>")
        parts.append(f"<g id='window-{window}' fill='{ARROW}'>{''.join(bars)}</g>")
        y = bottom + 22
    parts += [
        f"<rect x='{left}' y='{y + 16}' width='28' height='14' rx='2' fill='{ARROW}'/>",
        text(left + 38, y + 28, "a request is under way", anchor="start"),
    ]
    return card(WIDTH, y + 44, "When the six requests of lesson 06 are under way, with one and four in flight", *parts)


PICTURES: dict[str, Callable[[], str]] = {
    "03_circle": lambda: circle(circle_run()),
    "04_frames": lambda: frames(frames_run()),
    "05_rows": lambda: rows(rows_run()),
    "06_time_lines": lambda: time_lines(time_lines_run()),
}


def main() -> None:
    """Run and draw those that are named, or all."""
    for name, draw in PICTURES.items():
        if not sys.argv[1:] or name[:2] in sys.argv[1:]:
            target = ROOT / "img" / f"{name}.svg"
            target.write_text(draw(), encoding="utf-8", newline="\n")
            print(f"drew {target.relative_to(ROOT).as_posix()}")


if __name__ == "__main__":
    main()
