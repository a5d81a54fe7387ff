"""Lesson 11: values of every space as bytes, in both languages; C#'s own types; and merging, where a value is written
to where a locator says. The language of locators is in test_11_locators.py.
"""

from __future__ import annotations

import io
import json
import math
import re
import struct
from typing import Any

import pytest

from tests.programs import ROOT, finished
from tests.tables import rows
from tests.unity.test_unity_play import needs_mono

np = pytest.importorskip("numpy", reason="lesson 11 needs numpy: kit.py run 11 installs it")
gymnasium = pytest.importorskip("gymnasium", reason="lesson 11 needs gymnasium: kit.py run 11 installs it")
from gymnasium import spaces  # noqa: E402

from netmq_example import locator  # noqa: E402
from netmq_example.envs import merge as fit  # noqa: E402
from netmq_example.locator import LocatorError  # noqa: E402
from netmq_example.messages import MessageError  # noqa: E402
from netmq_example.scene.attributes import Seen  # noqa: E402
from netmq_example.wire import records, sections, trees  # noqa: E402
from netmq_example.wire.batches import empty  # noqa: E402
from netmq_example.wire.records import Record, Section  # noqa: E402

PAGE = ROOT / "docs" / "guide" / "11_locators.md"


def same(one, other):
    """Equal, and of the same kinds."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and np.array_equal(one, other, equal_nan=True)
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other


@pytest.fixture(scope="session")
def program(checks):
    """The words that start tests/lessons/checks/ObservationChecks.cs."""
    return ["dotnet", checks, "observations"]


# Golden bytes

GOLDEN = json.loads((ROOT / "tests" / "lessons" / "golden" / "11_observations.json").read_text(encoding="utf-8"))


def meant(value):
    """Make the value of a golden one: JSON has no arrays, and no graphs."""
    match value:
        case {"array": [dtype, shape, items]}:
            return np.array(items, dtype).reshape(shape)
        case {"graph": parts}:
            return spaces.GraphInstance(*map(meant, parts))
        case {"bytes": digits}:
            return bytes.fromhex(digits)
        case {"dict": parts}:
            return {key: meant(part) for key, part in parts.items()}
        case list():
            return [meant(item) for item in value]
    return value


def test_both_languages_read_and_write_the_golden_values(program):
    golden = GOLDEN["values"]
    for one in golden:
        value = meant(one["means"])
        assert trees.write(value).hex() == one["data"], one["name"]
        assert equal(trees.read(bytes.fromhex(one["data"])), value), one["name"]
    done = finished([*program, "trees"], input="\n".join(one["data"] for one in golden))
    assert done.stdout.splitlines() == [one["data"] for one in golden], done.stderr


def test_both_languages_write_the_golden_rows(program):
    """The agent itself is not named: so the rows of all of a kind have one form."""
    reset = Record(records.ASKS, 1, [Section(0, sections.seeds([1]), bytes([records.RESET]))]).frame()
    lines = []
    for one in GOLDEN["rows"]:
        sources = [(locator.parse(text), meant(value)) for text, value in one["means"]]
        pairs = [(text, value) for place, value in sources if (text := Seen("", place).text_for("it's"))]
        pairs.sort(key=lambda pair: locator.ordinal(pair[0]))
        assert trees.write_pairs(pairs).hex() == one["data"], one["name"]
        words = [reset, *(data for place, value in sources for data in (place.text.encode(), trees.write(value)))]
        lines.append(" ".join(word.hex() for word in words))
    done = finished([*program, "row"], input="\n".join(lines))
    answers = [records.read(records.ANSWERS, bytes.fromhex(line)).sections[0] for line in done.stdout.splitlines()]
    rows = [trees.sized(section.form).hex() + section.values.hex() for section in answers]
    assert rows == [one["data"] for one in GOLDEN["rows"]], done.stderr


def test_a_picture_that_is_a_file_arrives_as_its_pixels():
    image = pytest.importorskip("PIL.Image", reason="pictures need Pillow: pip install pillow")
    colours = np.array([[[255, 0, 0], [0, 0, 255]]], np.uint8)
    for made, kind, expected in (
        (image.fromarray(colours), "PNG", colours),
        (image.fromarray(colours).convert("RGBA"), "PNG", colours),
        (image.fromarray(colours[..., 0]), "PNG", colours[..., 0]),
        (image.new("L", (16, 8), 90), "JPEG", np.full((8, 16), 90, np.uint8)),
    ):
        file = io.BytesIO()
        made.save(file, kind)
        assert equal(trees.read(tree('{"image":"bytes"}', trees.sized(file.getvalue()))), expected)
    deep = io.BytesIO()
    image.fromarray(np.full((2, 2), 30_000, np.uint16)).save(deep, "PNG")
    for file in (deep.getvalue(), b"GIF89a", b"\x89PNG", b"\xff\xd8"):
        with pytest.raises(MessageError, match="bad-jpeg: this is no JPEG or PNG picture"):
            trees.read(tree('{"image":"bytes"}', trees.sized(file)))


# Values of random spaces

CHARACTERS = "aß\\\"'\U0001f697\u202e\x7f\n{}"
DTYPES = ["bool", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "float16", "float32", "float64"]


def a_box(random):
    dtype = np.dtype(random.choice(DTYPES))
    shape = tuple(int(size) for size in random.integers(0, 4, random.integers(0, 4)))
    if dtype.kind == "b":
        return spaces.Box(0, 1, shape, bool)
    low = random.choice([0, 1] if dtype.kind == "u" else [-3, 0, 1])
    bounded = dtype.kind != "f" or random.random() < 0.7
    return spaces.Box(low if bounded else -np.inf, 100 if bounded else np.inf, shape, dtype.type)


def a_space(random, depth=0):
    seed = int(random.integers(2**31))
    kinds = [
        a_box,
        lambda random: spaces.Discrete(int(random.integers(1, 9)), start=int(random.integers(-5, 5))),
        lambda random: spaces.MultiBinary([2, 3] if random.random() < 0.5 else 4),
        lambda random: spaces.MultiDiscrete([2, 5], start=[-1, 3]),
        lambda random: spaces.Text(int(random.integers(1, 12)), min_length=0, charset=CHARACTERS),
        lambda random: spaces.Graph(a_box(random), spaces.Discrete(3) if random.random() < 0.5 else a_box(random)),
        lambda random: spaces.Graph(spaces.Discrete(4), None),
        lambda random: spaces.Sequence(a_box(random), stack=True),
        lambda random: spaces.Sequence(spaces.Dict(a=a_box(random), b=spaces.Discrete(4)), stack=True),
    ]
    if depth < 3:
        kinds += 2 * [
            lambda random: spaces.Dict(
                {name: a_space(random, depth + 1) for name in random.choice(["a", "array", "dict", "é", ""], 2)}
            ),
            lambda random: spaces.Tuple([a_space(random, depth + 1) for _ in range(random.integers(1, 4))]),
            lambda random: spaces.Sequence(a_space(random, depth + 1)),
            lambda random: spaces.OneOf([a_space(random, depth + 1) for _ in range(random.integers(1, 4))]),
        ]
    space = kinds[random.integers(len(kinds))](random)
    space.seed(seed)
    return space


def equal(one, other):
    """Equal, and of the same kinds; what is stacked of a graph too."""
    if isinstance(one, spaces.GraphInstance):
        return type(other) is type(one) and all(map(equal, one, other))
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(equal(one[key], other[key]) for key in one)
    # A tuple that merging knows.
    one, other = (tuple(each) if isinstance(each, fit.Chosen) else each for each in (one, other))
    if type(one) in (list, tuple):
        return type(one) is type(other) and len(one) == len(other) and all(map(equal, one, other))
    # A Box without dimensions samples a number, and an array with none is in it as well.
    return same(*(np.asarray(each) if isinstance(each, np.generic) else each for each in (one, other)))


@pytest.mark.filterwarnings("ignore:.*Box.*precision lowered:UserWarning", "ignore:.*overflow.*:RuntimeWarning")
@pytest.mark.parametrize("runtime", ["dotnet", "mono"])
def test_random_values_go_through_csharp_and_come_back_equal(runtime, program):
    if runtime == "mono":
        needs_mono()
    random, cases, lines = np.random.default_rng(11), [], []
    while len(cases) < 400:
        space = a_space(random)
        for _ in range(4):
            value = space.sample()
            lines.append(trees.write(value).hex())
            cases.append((space, value))
    done = finished([runtime, *program[1:], "trees"], input="\n".join(lines))
    again = done.stdout.splitlines()
    assert len(again) == len(cases), done.stderr
    for line, (space, value), answer in zip(lines, cases, again, strict=True):
        assert answer == line, space
        assert equal(fit.fitted(space, trees.read(bytes.fromhex(answer)), ""), value), (space, value)


def test_what_a_space_begins_with_is_in_it_and_no_sample():
    for number in range(150):
        space = a_space(np.random.default_rng(number))
        begin = empty(space, "")
        assert equal(empty(space, ""), begin), "not by chance"
        fit.fitted(space, begin, "")
    assert empty(spaces.Box(2, 3, (1,)), "").tolist() == [2], "as near to 0 as the space has it"
    assert empty(spaces.Discrete(3, start=-7), "") == -7
    assert empty(spaces.Text(4, min_length=2, charset="xy"), "") == "xx"


# What is no tree


def tree(form, numbers=b""):
    return struct.pack("<I", len(form)) + form.encode() + numbers


ENDLESS: list[Any] = []
ENDLESS.append(ENDLESS)
NAN, INFINITE = struct.pack("<d", math.nan), struct.pack("<d", -math.inf)
GRAPH = '{"graph":["null","null","null"%s]%s}'
NUMBERS = [
    ("int64", bytes(7)),
    ("int64", bytes(9)),
    ("float64", bytes(7)),
    ("text", bytes(3)),
    *(
        ("text", struct.pack("<I", length) + text)
        for length, text in ((5, b"four"), (2**32 - 1, b"four"), (2, b"\xc3("))
    ),
    ("bool", b""),
    ("null", b"\0"),
    ("bool[1]", bytes(1)),
    ("uint32[1]", bytes(4)),
    ("float32[2]", bytes(7)),
    *((f"float32[{shape}", bytes(8)) for shape in ("2", "2]x", "-2]", "2,]", " 2]")),
    ("uint8[1,1,1,1,1,1,1,1,1]", bytes(1)),
    ("uint8[999999999,999999999,999999999]", bytes(8)),
]
BAD_TREES = [
    b"",
    b"\1\0\0",
    *(struct.pack("<I", length) + b'"null"' for length in (7, 2**32 - 1)),
    struct.pack("<I", 8) + b'"\xff\xff\xff\xff"' + b"  ",
    # Forms that are no JSON, or none of a value.
    *map(tree, ("{", "NaN", "5", "null", '"\\ud800"', '"nothing"', "[" * 65 + "]" * 65, "{}")),
    *map(tree, ('{"dict":[]}', '{"dict":{"a":{"b":1}}}', '{"dict":{},"graph":["null","null","null"]}')),
    *map(
        tree,
        ('{"graph":["null","null"]}', '{"graph":{"nodes":"null"}}', GRAPH % (',"null"', ""), GRAPH % ("", ',"x":1')),
    ),
    # Forms with other numbers than theirs.
    *(tree(f'"{form}"', numbers) for form, numbers in NUMBERS),
]
WRONG = [
    *((data, "bad-tree") for data in BAD_TREES),
    (tree('"float64"', NAN), "bad-value"),
    (tree('["int64","float64"]', bytes(8) + INFINITE), "bad-value"),
]


def test_what_is_no_tree_is_refused_by_both(program):
    done = finished([*program, "trees"], input="\n".join(data.hex() or "-" for data, _ in WRONG))
    said = done.stdout.splitlines()
    assert len(said) == len(WRONG), done.stderr
    for (data, code), line in zip(WRONG, said, strict=True):
        assert line == f"error {code}", data[:80]
        with pytest.raises(MessageError) as refusal:
            trees.read(data)
        assert refusal.value.code == code, data[:80]
        assert len(str(refusal.value)) < 200 and "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("value", "code"),
    [
        (float("nan"), "bad-value"),
        (2**63, "bad-value"),
        (-(2**63) - 1, "bad-value"),
        ({1: 2}, "bad-tree"),
        ({"\ud800": 2}, "bad-tree"),
        ({"a": object}, "bad-tree"),
        (ENDLESS, "bad-tree"),
        (json.loads("[" * 65 + "]" * 65), "bad-tree"),
        (np.zeros(1, np.uint64), "bad-dtype"),
        (np.array(["x"]), "bad-dtype"),
    ],
    ids=[
        *("NaN", "2**63", "-2**63-1", "a number as key", "half a character", "an object", "itself", "65 levels"),
        *("uint64", "an array of texts"),
    ],
)
def test_what_no_message_takes_is_refused_before_it_is_sent(value, code):
    for write in (trees.write, lambda value: trees.write_pairs([("a@", value)])):
        with pytest.raises(MessageError) as refusal:
            write(value)
        assert refusal.value.code == code


@pytest.mark.parametrize(
    ("space", "value", "said"),
    [
        (spaces.Box(0, 1, (2,)), "text", "x: str 'text' is not in Box"),
        (spaces.Box(0, 255, (1,), np.uint8), [300], "x: list [300] is not in Box(0, 255, (1,), uint8)"),
        (spaces.Discrete(3), 0.5, "x: float 0.5 is not in Discrete(3)"),
        (spaces.Text(2), "abc", "x: str 'abc' is not in Text"),
        (spaces.Dict(a=spaces.Discrete(2)), {"a": 2}, "x['a']: int 2 is not in Discrete(2)"),
        (spaces.Dict(a=spaces.Discrete(2)), {"a": 1, "b": 1}, "x: dict {'a': 1, 'b': 1} is not in Dict"),
        (spaces.Sequence(spaces.Discrete(2)), [1, 5], "x[1]: int 5 is not in Discrete(2)"),
        (spaces.Sequence(spaces.Discrete(2)), "10", "x: str '10' is not in Sequence"),
        (
            spaces.Sequence(spaces.Dict(a=spaces.Discrete(2), b=spaces.Discrete(2)), stack=True),
            {"a": [1]},
            "x: dict {'a': [1]} is not in Sequence",
        ),
        (
            spaces.Graph(spaces.Discrete(2), spaces.Discrete(2)),
            spaces.GraphInstance([1], [1], [[0, 1]]),
            "x: GraphInstance GraphInstance(nodes=[1], edges=[1], edge_links=[[0, 1]]) is not in Graph",
        ),
    ],
)
def test_what_does_not_fit_its_space_is_named_with_its_place(space, value, said):
    with pytest.raises(MessageError) as refusal:
        fit.fitted(space, value, "x")
    assert str(refusal.value).startswith(f"not-in-space: {said}")
    assert "\n" not in str(refusal.value)


# C#'s own types


@pytest.fixture(scope="session")
def seen(program):
    done = finished([*program, "attributes"])
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_every_member_is_seen_as_its_attribute_says(seen):
    found = {}
    for line in seen:
        if " : " in line and "@" in line:
            locator, data = line.split(" : ")
            value = trees.read(bytes.fromhex(data))
            found.setdefault(re.sub(r"^'it\\'s'@|^@@|['\[\]]| = \$$", "", locator), value)
    floats, graph = np.float32, spaces.GraphInstance
    expected = {
        "plain": graph(np.array([[1, 2]], floats), np.array([[3.0]]), np.zeros((1, 2), np.int32)),
        "lone": np.array(1, floats),
        "twice": np.array(0.0),
        "bit": np.array(1, np.uint8),
        "wide": np.array(-1, np.int32),
        "hidden": 8,  # Of a member that hides another one, the derived class's.
        "old": 1.0,
        "Says": "not this",
        "Gear": -1,
        "yes": True,
        "tenth": 0.1,
        "single": float(floats(1 / 3)),
        "money": 1.25,
        "text": "naïve \U0001f697",
        "nothing": None,
        "ofbytes": np.array([[1, 2, 3], [4, 5, 6]], np.uint8),
        "whole": np.array([1, -2], np.int32),
        "bits": np.array([1, 0], np.uint8),
        "small": np.array([-5], np.int32),
        "mixed": [1, "two", np.array([3.5], floats)],
        "parts": {"a": 1, "b": np.array([2])},
        "graph": graph(np.zeros((2, 1), floats), None, None),
        "place": np.array([1, 2, 3], floats),
        "turn": np.array([0.5, 0.25, 0.125, 1], floats),  # x, y, z, w
        "way": np.array([[1, 2, 3], [4, 5, 6]], floats),
        "rows": np.array([[1, 2], [3, 4]], floats),
        "wheels(0)": np.array(3.0),
        "letters": np.array([97, 223], np.uint16),
        "picture": np.array([0, 255], np.uint8),
        "colour": np.array([1, 2, 3, 4], np.uint8),
        "cell": np.array([-1, 1], np.int32),
        "gear": 1,
        "round": 2,
        "spelled": "0.5",
        "corners": {"left": np.array([1, 2], floats)},
        "seen": [1, 2],
        "queue": ["x"],
        "said": "one",
        "said = $0": ["two"],
        "exact": np.array(16777216, floats),
        "Behind": 4,
        "most": 2**63 - 1,
        "Edges": graph(np.zeros(2, np.int64), np.zeros(1, np.int64), np.zeros((1, 2), np.int32)),
    }
    assert found.keys() == expected.keys()
    assert [name for name, value in expected.items() if not equal(found[name], value)] == []


def test_what_is_wrong_with_a_member_is_named_with_its_class(seen):
    for line in (
        """ArgumentException WrongLocator.speed, locator ".speed[": column 8: expected a key, a number""",
        "ArgumentException Unreadable.Speed cannot be read: give it a get",
        "ArgumentException OnePlace.a and OnePlace.b go to one place: 'car'@['a'] = $",
        "MessageException bad-value: Wrong.nan: NaN is not finite",
        "MessageException no-space: Wrong.version: no space takes a Version",
        "MessageException bad-shape: Wrong.ragged: its rows are not equally long",
        "MessageException bad-value: Wrong.big: 300 would become another number as uint8",
        "MessageException no-space: Wrong.half: 0.5 is no whole number",
        "MessageException bad-dtype: Wrong.dtype: dtype float128 is none of uint8, uint16, int32, int64, float32",
        "MessageException no-space: Wrong.keys: Dictionary`2 is no dictionary of texts",
        "InvalidOperationException Wrong.Broken: no gearbox",
        "bad-dtype: its numbers are float64, which is no Single",
        "ArgumentException NoObjects.speed is static: it belongs to no agent",
        "ArgumentException TwoAttributes.speed has two attributes: one is enough",
        "ArgumentException Indexed.Item cannot be read: give it a get",
        "MessageException no-space: Wrong.endless: it is nested more than 100 times, or has no end",
        "MessageException bad-shape: Wrong.deep: an array has at most 8 dimensions",
        "MessageException bad-value: Wrong.wide: 18446744073709551615 is too large for an int64",
        "MessageException bad-value: Wrong.huge: 1E+300 would become another number as float32",
        "MessageException bad-value: Wrong.lossy: 16777217 would become another number as float32",
    ):
        assert [one for one in seen if one.startswith(line)], line
    assert "nothing is wrong" not in seen


def test_an_array_is_a_number_to_dotnet_and_has_a_text(seen):
    for line in (
        "half: 0.5 7 True float32 []: 0.5",
        "int32 [9]: 1, 2, 3, 4, 5, 6, 7, 8, … uint8 [0, 2]: ",
        "this array has no single number: float32 [2]: 0, 0",
        "bad-reward: the reward of agent 'car' is NaN, which is not finite",
    ):
        assert line in seen


def test_reflection_finds_the_members_once_and_not_in_each_step(seen):
    """A hundred agents of one class, and two hundred steps: each attribute was made once."""
    assert "made 1 times" in seen
    (line,) = [line for line in seen if "bytes a step" in line]
    allocated, members = re.match(r"(\d+) bytes a step for (\d+) members", line).groups()
    assert int(allocated) < 600 * int(members), json.dumps(line)


# Merging


def merge(observations, *said):
    """One message of texts and values."""
    appended = set()
    for text, value in said:
        fit.merge(observations, locator.parse(text), value, appended)
    return observations


# As the page's table, which has the others.
WRITTEN = [
    ("{'x': array([[0, 0], [0, 0]])}", "car@.x[0:2,1]", "[1, 2]", "{'x': array([[0, 1], [0, 2]])}"),
    ("{'x': array([0, 0])}", "car@.x = $(-1)", "array([[1, 2], [3, 4]])", "{'x': array([3, 4])}"),
    ("{'s': array([[1, 2], [3, 4]])}", "car@.s[]", "[5, 6]", "{'s': array([[5, 6]])}"),
    ("{'n': 1}", "@@.n", "2.0", "{'n': 2}"),
    ("{'n': 1}", "@@car@.n", "2", "{'n': 1}"),
    ("{'n': 1}", "bus@.n", "2", "'bus'@['n'] = $: there is no 'bus'"),
    ("{'n': 1}", ".n", "2", "['n'] = $: it names no agent"),
    ("{'n': 1}", "car@.n & car@.n[0]", "2", "'car'@['n'][0] = $: int has no [0]"),
    ("(1, 2)", "car@[0,1]", "7", "'car'@[0,1] = $: tuple has no [0,1]"),
    ("(1, 2)", "car@[0:1]", "[7, 8]", "'car'@[:1] = $: there would be 3 items and not 2"),
]


def test_a_value_is_written_as_the_page_says():
    found = rows(PAGE, "there is", "locator", "value", "then there is")
    assert len(found) > 5
    for there, text, value, then in [*found, *WRITTEN]:
        names = {"array": lambda items: np.array(items, np.float32)}
        before = {"car": eval(there, names)}
        kept = before["car"]
        try:
            after = merge(before, (text, eval(value, names)))
        except LocatorError as error:
            assert str(error) == then
            assert before == {"car": kept}, "all or nothing"
        else:
            assert same(after, {"car": eval(then, names)}), (text, after)
        assert same(kept, eval(there, names)), f"{text}: what was given out is not changed"


def test_a_new_message_clears_what_was_appended_of_each_agent():
    there = {"a": {"s": [0]}, "b": {"s": (0,)}, "c": {"s": []}}
    merge(there, ("@@.s[]", 1), ("@@.s[]", 2), ("a@.s[]", 3))
    assert there == {"a": {"s": [1, 2, 3]}, "b": {"s": (1, 2)}, "c": {"s": [1, 2]}}
    merge(there, ("a@.s[]", 4))
    assert there == {"a": {"s": [4]}, "b": {"s": (1, 2)}, "c": {"s": [1, 2]}}


def test_what_numpy_indexes_is_an_array_also_after_the_dollar():
    there = {"car": {"x": np.zeros(2), "s": [0, 0]}}
    merge(there, ("car@.x = $[...,1][]", np.array([[1, 2], [3, 4]])))
    assert there["car"]["x"].tolist() == [2, 4]
    merge(there, ("car@.x[...][np.newaxis][0,1] = $()", np.float32(7)))
    assert there["car"]["x"].tolist() == [2, 7]
    for value, kind in (([1, 2], "list"), ({"a": 1}, "dict"), (1, "int")):
        with pytest.raises(LocatorError, match=rf"\['x'\] = \$\[0,1\]: {kind} has no \[0,1\]"):
            merge(there, ("car@.x = $[0,1]", value))


def test_every_kind_of_value_is_cast_to_what_is_there():
    picture = np.frombuffer(b"\1\2\3\4", np.uint8)
    given = {
        "f": (np.zeros(2, np.float32), [1, None], np.array([1, np.nan], np.float32)),
        "one": (np.zeros(1, np.float32), 2.5, np.array([2.5], np.float32)),
        "u": (np.zeros(4, np.uint8), picture, picture),
        "b": (np.zeros(2, np.int8), [True, False], np.array([1, 0], np.int8)),
        "d": (np.int64(0), 3, np.int64(3)),
        "t": ("", "naïve", "naïve"),
        "tuple": ((np.zeros(1), "a"), [[1], "b"], (np.ones(1), "b")),
        "longer": ((np.float32(0),), [1, 2, 3], (np.float32(1), np.float32(2), np.float32(3))),
        "empty": ([], [1, 2], [1, 2]),
        "none": (None, 5, 5),
    }
    there = {"car": {key: before for key, (before, _, _) in given.items()}}
    merge(there, ("car@", {key: value for key, (_, value, _) in given.items()}))
    assert same(there["car"], {key: after for key, (_, _, after) in given.items()}), there
    assert not np.shares_memory(there["car"]["u"], picture), "what was received is not handed on"


@pytest.mark.parametrize(
    "value", [300, -1, 1.5, float("nan"), None, "x", [[1, 2]], 10**400, {}, b"1"], ids=lambda value: repr(value)[:9]
)
def test_what_would_become_another_number_is_refused(value):
    there = {"car": {"u": np.zeros(3, np.uint8)}}
    with pytest.raises(LocatorError) as refusal:
        merge(there, ("car@.u(0)", value))
    assert re.fullmatch(r"'car'@\['u'\]\(0\) = \$: [ -~]{5,200}", str(refusal.value))
    assert there["car"]["u"].tolist() == [0, 0, 0]


@pytest.mark.parametrize("text", [[("car@", 1), (".u", 3000)], [("car@.x", 1), ("(:)", 5_000)]], ids=["keys", "slices"])
def test_a_path_deeper_than_anything_is_refused(text):
    with pytest.raises(LocatorError) as refusal:
        merge({"car": {"u": {}, "x": np.zeros(3)}}, ("".join(piece * count for piece, count in text), 1))
    assert len(str(refusal.value)) < 400
