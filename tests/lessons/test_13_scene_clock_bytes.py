"""Records of the scene's clock against golden bytes. C# reads and writes the same: it plays with this Python in
tests/unity/test_ml_agents_*.py, and here it refuses what Python does.
"""

import json
import struct

import pytest

pytest.importorskip("numpy", reason="a value needs numpy: kit.py run 9 installs it")

from netmq_example.messages import MessageError
from netmq_example.wire import trees
from netmq_example.wire.records import (
    ANEW,
    ANSWERS,
    ASKS,
    ENDED,
    GROUPS,
    IDS,
    MASKS,
    SCENE_CLOCK,
    SEEN,
    STEP,
    TERMINATED,
    TRUNCATED,
    WANTS,
    Record,
    Section,
    read,
)
from netmq_example.wire.sections import rewards, seeds
from tests.programs import ROOT, finished

GOLDEN = json.loads((ROOT / "tests/lessons/golden/09_scene_clock.json").read_text())


def sensor(name, shape, dtype, kind, properties):
    return {"name": name, "shape": shape, "dtype": dtype, "type": kind, "properties": properties}


NUMBERS = sensor("VectorSensor_size3", [3], "float32", 0, [1])
PICTURE = sensor("Eye", [1, 2, 2], "uint8", 1, [1, 2, 2])
BALL = {"name": "Ball", "team": 0, "continuous": 2, "branches": [3, 2], "sensors": [NUMBERS, PICTURE]}
ONE = sensor("seen", [1], "float32", 0, [1])
GOAL = {"name": "Goal", "team": 1, "continuous": 0, "branches": [2], "sensors": [ONE]}


def floats(*numbers):
    return struct.pack(f"<{len(numbers)}f", *numbers)


def whole(*numbers):
    return struct.pack(f"<{len(numbers)}i", *numbers)


def wanting(kind, ids, earned, values, columns=0, **more):
    marks = bytes([WANTS | SEEN]) * len(ids)
    return Section(kind, rewards(earned), marks, columns=IDS | columns, ids=whole(*ids), values=values, **more)


def ended(kind, mark, ids, earned, values, columns=0, **more):
    marks = bytes([mark | SEEN]) * len(ids)
    return Section(kind, rewards(earned), marks, columns=IDS | ENDED | columns, ids=whole(*ids), values=values, **more)


def clocked(kind, id, sections=(), exchange=b"", said=b"", bits=0):
    return Record(kind, id, [*sections], SCENE_CLOCK | bits, said, exchange)


def records():
    yield (
        "the first reset, with a seed and an empty exchange",
        clocked(ASKS, 1, said=trees.write({"seed": 7}), bits=ANEW),
    )
    yield "another reset", clocked(ASKS, 2, exchange=b"told", bits=ANEW)
    seen = floats(1, 2, 3) + bytes([0, 85, 170, 255]) + floats(-1, 0.25, 0) + bytes([1, 2, 3, 4])
    groups, masks = whole(0, 3) + floats(0, -1.5), bytes([0, 1, 0, 0, 0, 0, 0, 0, 0, 1])
    balls = wanting(0, [0, 2], [0.0, 0.5], seen, GROUPS | MASKS, groups=groups, masks=masks)
    come = "two kinds come, and two of the first and one of the second want an action"
    kinds = trees.write({"kinds": [BALL, GOAL]})
    yield come, clocked(ANSWERS, 1, [balls, wanting(1, [1], [0.0], floats(9))], said=kinds)
    actions = floats(0.5, -2) + whole(2, 1) + floats(0, 1) + whole(0, 0)
    steps = Section(0, seeds([0, 0]), bytes([STEP] * 2), values=actions)
    yield "go on: actions of the first kind, zeros for the second", clocked(ASKS, 3, [steps])
    yield "go on without any action", clocked(ASKS, 4)
    over = ended(0, TERMINATED, [2], [1.0], floats(1, 1, 1) + bytes([9] * 4), GROUPS, groups=whole(3) + floats(2))
    cut = ended(1, TRUNCATED, [1], [-0.25], floats(4))
    again = wanting(0, [2], [0.0], floats(0, 0, 0) + bytes(4), GROUPS, groups=whole(3) + floats(0))
    both = "an agent has ended and wants an action as well, another was interrupted"
    yield both, clocked(ANSWERS, 3, [over, cut, again], exchange=b"said")
    yield "nobody wants anything", clocked(ANSWERS, 4)


def test_they_are_the_golden_bytes():
    assert {name: record.frame().hex() for name, record in records()} == {one["name"]: one["frame"] for one in GOLDEN}


@pytest.mark.parametrize("entry", GOLDEN, ids=[one["name"] for one in GOLDEN])
def test_what_is_read_is_written_again_and_a_cut_one_is_none(entry):
    frame = bytes.fromhex(entry["frame"])
    assert read(frame[0], frame).frame() == frame
    for end in range(len(frame)):
        with pytest.raises(MessageError, match=r"^bad-record: "):
            read(frame[0], frame[:end])


def test_what_cannot_be():
    anew_by_pythons_clock = Record(ASKS, 1, [], ANEW).frame()
    nobody_has_ended = ended(0, TERMINATED, [1], [0.0], b"")
    nobody_has_ended.columns = ENDED
    nobody_has_ended.ids = b""
    no_choices = wanting(0, [1], [0.0], floats(1), MASKS)
    for frame in (
        anew_by_pythons_clock,
        clocked(ANSWERS, 1, [nobody_has_ended]).frame(),
        clocked(ANSWERS, 1, [no_choices]).frame(),
    ):
        with pytest.raises(MessageError, match=r"^bad-record: "):
            read(frame[0], frame)


def test_csharp_refuses_what_is_cut_and_what_cannot_be(checks):
    asks = [one["frame"] for one in GOLDEN if one["frame"].startswith("03")]
    # All begin anew by Python's clock, or with actions; nobody steps by Python's clock; a bit that is none.
    heads = ((0x10, 0), (0x14, 1), (0x00, 0), (0x24, 0))
    wrong = [f"03{bits:02x}{count:02x}0000000000010000000000000000000000000000".ljust(48, "0") for bits, count in heads]
    wrong += [frame[:end] for frame in asks for end in range(2, len(frame), 2)]
    done = finished(["dotnet", checks, "records", "rows"], input="\n".join(f"pair 1 {frame}" for frame in wrong))
    assert done.stdout.splitlines() == ["error bad-record"] * len(wrong), done.stderr


def test_who_has_ended_may_be_said_by_ids_alone():
    (section,) = read(ANSWERS, clocked(ANSWERS, 1, [ended(0, TERMINATED, [5], [1.0], floats(1))]).frame()).sections
    assert (section.columns, bytes(section.ids)) == (IDS | ENDED, whole(5))
