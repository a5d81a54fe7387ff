"""The pictures of lessons 03 to 06 show what the lesson teaches: those that are kept, and what a run draws now."""

from __future__ import annotations

import math
import re
from itertools import pairwise
from xml.etree import ElementTree

import pytest

from kitlib.docs.lesson_pictures import PICTURES
from kitlib.lessons import find
from tests.programs import ROOT

SVG = "{http://www.w3.org/2000/svg}"
NEEDS = {"05_rows": ("numpy", "aiohttp"), "06_time_lines": ("aiohttp",)}


@pytest.fixture(params=["kept", "drawn now"])
def picture(request):
    """The picture of this name, as it is in the kit, and as a run draws it."""

    def picture(name):
        assert f"../../img/{name}.svg" in find(name[:2]).guide.read_text(encoding="utf-8")
        if request.param == "kept":
            svg = (ROOT / "img" / f"{name}.svg").read_text(encoding="utf-8")
            assert len(svg) < 30_000
        else:
            for package in NEEDS.get(name, ()):
                pytest.importorskip(package, reason=f"a run for {name} needs {package}: pip install {package}")
            svg = PICTURES[name]()
        return ElementTree.fromstring(svg)

    return picture


def shapes(drawn, group, kind):
    """The numbers of each shape of a group."""
    found = drawn.findall(f".//{SVG}g[@id='{group}']/{SVG}{kind}")
    return [{name: float(value) for name, value in each.items() if name[0] in "xywhcr"} for each in found]


@pytest.mark.timeout(180)
def test_the_circle_lacks_what_a_listener_has_missed(picture):
    drawn = picture("03_circle")
    words = " ".join(drawn.itertext())
    said = [(int(count), int(last)) for count, last in re.findall(r"(\d+) poses,\s+the last is (\d+)", words)]
    # The radians between one pose received and the next, for each listener.
    steps = []
    for (count, _), name, centre in zip(said, ("late", "queue", "conflate"), (112, 320, 528), strict=True):
        dots = [(dot["cx"] - centre, 164 - dot["cy"]) for dot in shapes(drawn, name, "circle")]
        assert len(dots) == count and all(math.hypot(*dot) == pytest.approx(92, abs=0.2) for dot in dots)
        turns = [math.atan2(y, x) for x, y in dots]
        steps.append([(after - before) % (2 * math.pi) for before, after in pairwise(turns)])
    late, queue, conflate = steps
    assert late + queue == pytest.approx([1 / 60] * len(late + queue), abs=0.005), "they get every pose"
    assert max(conflate) > 2 / 60, "CONFLATE skips"
    assert said[0][1] - said[0][0] >= 99, "who comes late has missed the beginning"
    assert said[1][1] < said[2][1], "who takes every pose gets old ones"


@pytest.mark.timeout(180)
def test_one_frame_is_two_seconds_long_or_none(picture):
    drawn = picture("04_frames")
    blocking, background = (shapes(drawn, name, "rect") for name in ("blocking", "background"))
    for strip in blocking, background:
        assert all(a["x"] + a["width"] == pytest.approx(b["x"], abs=0.02) for a, b in pairwise(strip))
    widths = [frame["width"] for frame in blocking]
    # From the end of the first frame to that of the tenth; the third one waits.
    assert len(widths) == 9 and widths.index(max(widths)) == 1
    assert len(background) > len(blocking) and max(frame["width"] for frame in background) < max(widths)


@pytest.mark.timeout(180)
def test_the_square_is_where_the_server_saw_it_if_the_lowest_row_comes_first(picture):
    drawn = picture("05_rows")
    upright, turned = (shapes(drawn, name, "rect") for name in ("upright", "turned"))
    assert len(upright) == len(turned) == 8, "rows of the white square"
    assert all(a["x"] == b["x"] and a["width"] == b["width"] == 8 for a, b in zip(upright, turned, strict=True))
    assert all(a["y"] + b["y"] == 239 for a, b in zip(upright, turned, strict=True))
    (seen,), (not_there,) = shapes(drawn, "upright", "circle"), shapes(drawn, "turned", "circle")
    assert seen == not_there, "the server has said one place"
    assert (seen["cx"], seen["cy"]) == (upright[0]["x"] + 4, min(row["y"] for row in upright) + 4)
    assert abs(seen["cy"] - turned[0]["y"]) > seen["r"]


@pytest.mark.timeout(180)
def test_in_flight_requests_do_not_wait_for_each_other(picture):
    drawn = picture("06_time_lines")
    turns, flight = (shapes(drawn, f"window-{window}", "rect") for window in (1, 4))
    assert len(turns) == len(flight) == 6
    # What is shorter than 4 is drawn as 4.
    assert all(after["x"] >= before["x"] + before["width"] - 4 for before, after in pairwise(turns))
    assert any(each["x"] < flight[0]["x"] + flight[0]["width"] for each in flight[1:4])
    # None takes less time than the server sleeps.
    marks = {each.text: float(each.attrib["x"]) for each in drawn.iter(f"{SVG}text")}
    second = 2 * (marks["0.5 s"] - marks["0 s"])
    for bars in turns, flight:
        assert all(bars[i]["width"] > time * second - 1 for i, time in ((0, 0.8), (2, 0.5), (4, 0.2)))
