"""Lesson 11: values of every space as bytes, in both languages; C#'s own types; merging, where a value is written to
where a locator says; and what of a peer or a user is no value. The language of locators is in test_11_locators.py.
"""

from __future__ import annotations

import functools
import inspect
import io
import json
import math
import re
import struct
import warnings
from typing import Annotated, Any

import pytest

from tests.programs import ROOT, finished
from tests.tables import rows
from tests.unity.test_unity_play import needs_mono

np = pytest.importorskip("numpy", reason="lesson 11 needs numpy: kit.py run 11 installs it")
gymnasium = pytest.importorskip("gymnasium", reason="lesson 11 needs gymnasium: kit.py run 11 installs it")
pytest.importorskip("pettingzoo", reason="lesson 11 needs pettingzoo: kit.py run 10 installs it")
from gymnasium import spaces  # noqa: E402

from netmq_example import locator  # noqa: E402
from netmq_example.envs import UnityGymEnv, UnityParallelEnv, UnityVectorEnv  # noqa: E402
from netmq_example.envs import merge as fit  # noqa: E402
from netmq_example.envs.actions import Actions  # noqa: E402
from netmq_example.envs.kinds import Kind  # noqa: E402
from netmq_example.envs.plan import Sight  # noqa: E402
from netmq_example.locator import LocatorError  # noqa: E402
from netmq_example.messages import Message, MessageError  # noqa: E402
from netmq_example.scene import Agent, Obs, Scene, SceneSimulator  # noqa: E402
from netmq_example.scene.attributes import Seen  # noqa: E402
from netmq_example.wire import records, sections, trees  # noqa: E402
from netmq_example.wire.batches import empty  # noqa: E402
from netmq_example.wire.records import FORM, SIZES, TERMINATED, Record, Section  # noqa: E402
from netmq_example.worlds.coin_car import CoinCar  # noqa: E402

KEY = "11_observations"
PAGE = ROOT / "docs" / "guide" / "11_locators.md"


def same(one, other):
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
        # In C# an array of int8 becomes one of int32.
        assert answer == line or b'"int8['.hex() in line, space
        assert equal(fit.fitted(space, trees.read(bytes.fromhex(answer)), ""), value), (space, value)


def test_a_mask_stays_int8_as_gymnasium_wants_it():
    mask = np.array([[1, 0], [-128, 127]], np.int8)
    assert same(trees.read(trees.write({"mask": [mask, mask[0]]})), {"mask": [mask, mask[0]]})
    assert spaces.Discrete(2).sample(mask=trees.read(trees.write(mask[0]))) == 0


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
FORMED = '{"graph":["null","null","null"%s]%s}'
NUMBERS = [
    ("int64", bytes(7)),
    ("int64", bytes(9)),
    ("float64", bytes(7)),
    ("text", bytes(3)),
    *(("text", trees.SIZE.pack(size) + text) for size, text in ((5, b"four"), (2**32 - 1, b"four"), (2, b"\xc3("))),
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
    *map(tree, ('{"graph":["null","null"]}', '{"graph":{"nodes":"null"}}', FORMED % (',"null"', ""))),
    tree(FORMED % ("", ',"x":1')),
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
)
def test_what_no_message_takes_is_refused_before_it_is_sent(value, code):
    for write in (trees.write, lambda value: trees.write_pairs([("a@", value)])):
        with pytest.raises(MessageError) as refusal:
            write(value)
        assert refusal.value.code == code


TWO, LINKED = spaces.Discrete(2), spaces.GraphInstance([1], [1], [[0, 1]])


@pytest.mark.parametrize(
    ("space", "value", "said"),
    [
        (spaces.Box(0, 1, (2,)), "text", "x: str 'text' is not in Box"),
        (spaces.Box(0, 255, (1,), np.uint8), [300], "x: list [300] is not in Box(0, 255, (1,), uint8)"),
        (spaces.Discrete(3), 0.5, "x: float 0.5 is not in Discrete(3)"),
        (spaces.Text(2), "abc", "x: str 'abc' is not in Text"),
        (spaces.Dict(a=TWO), {"a": 2}, "x['a']: int 2 is not in Discrete(2)"),
        (spaces.Dict(a=TWO), {"a": 1, "b": 1}, "x: dict {'a': 1, 'b': 1} is not in Dict"),
        (spaces.Sequence(TWO), [1, 5], "x[1]: int 5 is not in Discrete(2)"),
        (spaces.Sequence(TWO), "10", "x: str '10' is not in Sequence"),
        (spaces.Sequence(spaces.Dict(a=TWO, b=TWO), stack=True), {"a": [1]}, "x: dict {'a': [1]} is not in Sequence"),
        (spaces.Graph(TWO, TWO), LINKED, f"x: GraphInstance {LINKED} is not in Graph"),
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
        # An array is a number to .NET, and has a text.
        "half: 0.5 7 True float32 []: 0.5",
        "int32 [9]: 1, 2, 3, 4, 5, 6, 7, 8, … uint8 [0, 2]: ",
        "this array has no single number: float32 [2]: 0, 0",
        "bad-reward: the reward of agent 'car' is NaN, which is not finite",
    ):
        assert [one for one in seen if one.startswith(line)], line
    assert "nothing is wrong" not in seen


def test_reflection_finds_the_members_once_and_not_in_each_step(seen):
    """A hundred agents of one class, and two hundred steps: each attribute was made once."""
    assert "made 1 times" in seen
    (line,) = [line for line in seen if "bytes a step" in line]
    allocated, members = re.match(r"(\d+) bytes a step for (\d+) members", line).groups()
    assert int(allocated) < 600 * int(members), json.dumps(line)


# Merging


def merge(observations, *said):
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
    ("{'t': 'a'}", "car@.t", "None", "{'t': ''}"),
    ("{'d': int64(0)}", "car@.d", "3", "{'d': int64(3)}"),
    ("{'n': 1}", "@@car@.n", "2", "{'n': 1}"),
    ("{'n': 1}", "bus@.n", "2", "'bus'@['n'] = $: there is no 'bus'"),
    ("{'n': 1}", ".n", "2", "['n'] = $: it names no agent"),
    ("{'n': 1}", "car@.n & car@.n[0]", "2", "'car'@['n'][0] = $: int has no [0]"),
    ("(1, 2)", "car@[0,1]", "7", "'car'@[0,1] = $: tuple has no [0,1]"),
    ("(1, 2)", "car@[0:1]", "[7, 8]", "'car'@[:1] = $: there would be 3 items and not 2"),
    # An array that numpy indexes is one after the dollar, too.
    ("{'x': array([0, 0])}", "car@.x = $[...,1][]", "array([[1, 2], [3, 4]])", "{'x': array([2, 4])}"),
    ("{'x': array([2, 4])}", "car@.x[...][np.newaxis][0,1] = $()", "array(7)", "{'x': array([2, 7])}"),
    *(
        ("{'x': array([2, 4])}", "car@.x = $[0,1]", value, f"'car'@['x'] = $[0,1]: {kind} has no [0,1]")
        for value, kind in (("[1, 2]", "list"), ("{'a': 1}", "dict"), ("1", "int"))
    ),
]


def test_a_value_is_written_as_the_page_says():
    found = rows(PAGE, "there is", "locator", "value", "then there is")
    assert len(found) > 5
    for there, text, value, then in [*found, *WRITTEN]:
        names = {"array": lambda items: np.array(items, np.float32), "int64": np.int64}
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


ONE = spaces.Box(-9, 9, (2,), np.float32)
# Gymnasium 1.1 has but one dtype.
HAS_DTYPE = "dtype" in inspect.signature(spaces.Discrete).parameters
NARROW = spaces.Discrete(9, **({"dtype": np.int32} if HAS_DTYPE else {}))


class Car(Agent):
    """It sees the value that its test puts there, and says whatever it hears."""

    x: Annotated[Any, Obs()] = None

    def on_info(self, info):
        self.send_info(info)


@pytest.fixture
def world(inside, make):
    """Makes an environment whose simulator is in this process; `change` alters what it answers."""

    def made(space=ONE, scene=None, change=lambda said: said, kind=UnityGymEnv, **words):
        simulator = SceneSimulator(scene or seeing(None))

        def answer(request):
            return [change(records.read_frames(records.ANSWERS, simulator.answer(request))).frames()]

        declared = {"observation_space": spaces.Dict(x=space), "action_space": spaces.Discrete(2)}
        socket = inside(simulator, answer).socket
        return make(kind, env_name="Cars", socket=socket, **({} if "observation_spaces" in words else declared) | words)

    return made


def seeing(*values, kind=Car):
    """A scene of agents each of which sees its value."""
    cars = [kind() for _ in values]
    for car, value in zip(cars, values, strict=True):
        car.x = value
    return Scene("Cars", cars, 0.1)


# From a simulator


PLACE = "@['x'] = $"
X, FLOATS = f'["{PLACE}",%s]', '"float32[2]"'


@pytest.mark.parametrize(
    ("odd", "said"),
    [
        *((tree(form), "bad-tree") for form in ("[1,2]", "[[1,1]]", '[[[1],"null"]]', "5", "{}", "[", f'"{PLACE}"')),
        (tree(f'["{PLACE}","null",2]'), "bad-tree"),
        *((tree(f"[{X % form}]"), "bad-tree") for form in ("5", '"float16[2]"', "[" * 65 + "]" * 65)),
        (b"\1\0", "bad-tree: .* too early"),
        (struct.pack("<I", 9) + b"[]", "bad-tree: .* too early"),
        (tree(f"[{X % FLOATS}]", bytes(7)), "bad-observation: it is cut short"),
        (tree(f"[{X % FLOATS}]", bytes(9)), "bad-observation: more follows what was seen"),
        (tree(f"[{X % FLOATS},{X % FLOATS}]", bytes(17)), "bad-observation: more follows what was seen"),
        (tree("[[\"'agent'@['x'\",\"null\"]]"), "bad-observation: .* column 13"),
    ],
)
def test_what_is_no_locator_with_a_value_is_named(odd, said, world):
    """Also where the form stands there once for all rows."""

    def whole(answer):
        answer.sections[0].columns, answer.sections[0].values = 0, odd
        return answer

    def parted(answer):
        answer.sections[0].form, answer.sections[0].values = trees.parted(odd)
        return answer

    for change in (whole, parted) if "early" not in said else (whole,):
        with pytest.raises(MessageError, match=f"^{said}") as refusal:
            world(change=change).reset(seed=1)
        assert "\n" not in str(refusal.value)


CARS = Kind(0, "agent", ("agent",), 0, 1, None, None, True)
GRAPH = spaces.Graph(spaces.Box(-9, 9, (1,), np.float32), spaces.Box(-9, 9, (1,), np.float32))
NODES, EDGES = np.zeros((2, 1), np.float32), np.zeros((1, 1), np.float32)


@pytest.mark.parametrize("stack", [False, True])
@pytest.mark.parametrize(
    ("feature", "items"),
    [
        (ONE, [np.array([1, 2], np.float32), [3, 4]]),
        (spaces.Box(0, 1, (), np.float32), [0.5, 1]),
        (spaces.Discrete(5, start=-2), [2, np.array([1]), -2]),
        (spaces.MultiDiscrete([2, 3]), [[0, 2], [1, 1]]),
        (spaces.MultiBinary(2), [[0, 1]]),
    ],
)
def test_items_that_are_fitted_at_once_are_what_each_of_them_is_alone(feature, items, stack):
    space = spaces.Sequence(feature, stack=stack)
    found = fit.fitted(space, items, "")
    alone = [fit.fitted(feature, item, "") for item in items]
    assert found in space and len(found) == len(alone)
    for one, other in zip(found, alone, strict=True):
        assert np.array_equal(one, other) and np.asarray(one).dtype == other.dtype
        assert stack or type(one) is type(other)


def test_an_episode_without_a_coin_is_one(serve, connect):
    server, endpoint = serve(KEY)
    socket = connect(endpoint)
    socket.send_multipart(SceneSimulator(Scene("Coins", [CoinCar()])).hello().frames())
    assert Message.read(socket.recv_multipart()).kind == "welcome"
    for ends in 0, TERMINATED:
        request = records.read_frames(records.ASKS, socket.recv_multipart())
        section = Section(0, sections.rewards([0.0]), bytes([records.SEEN | ends]), values=trees.write_pairs([]))
        socket.send_multipart(Record(records.ANSWERS, request.id, [section]).frames())
    server.wait_for("^episode 1: 1 steps, return 0.00: $")


# From a user


class Own(spaces.Space):
    """A space of a user's own."""


@pytest.mark.parametrize(
    ("wrong", "where"),
    [
        ({"observation_space": spaces.Dict(a=spaces.Tuple([ONE, Own()]))}, "observation['a'][1]: "),
        ({"observation_space": spaces.OneOf([Own()])}, "observation: "),
        ({"observation_space": spaces.Sequence(Own())}, "observation[]: "),
        ({"action_space": spaces.Dict(go=Own())}, "action['go']: "),
    ],
)
def test_a_space_that_no_message_has_is_named_before_anybody_is_waited_for(wrong, where):
    declared = {"observation_space": ONE, "action_space": ONE}
    with pytest.raises(ValueError, match=f"^{re.escape(where)}.* has no place in a message"):
        UnityGymEnv("Cars", wait=0.1, endpoint="tcp://127.0.0.1:*", **{**declared, **wrong})


def test_a_key_that_nothing_writes_is_named_at_reset_also_in_a_dict(world):
    deep = spaces.Dict(x=ONE, extra=ONE, deep=spaces.Dict(a=ONE, b=ONE))

    class Deep(Car):
        a: Annotated[Any, Obs(".deep.a(0)")] = 1.0

    car = Deep()
    car.x = np.zeros(2)
    env = world(scene=Scene("Cars", [car]), observation_space=deep)
    with pytest.warns(UserWarning) as told:
        seen, _ = env.reset(seed=1)
    with pytest.warns(UserWarning, match="^nothing writes 'agent_0'@") as many:
        world(scene=seeing(np.zeros(2), np.zeros(2)), kind=UnityVectorEnv, num_envs=2, observation_space=deep).reset()
    assert len(many) == 2, "of one for all"
    places = "nothing writes 'agent'@['extra']: ", "nothing writes 'agent'@['deep']['b']: "
    assert len(told) == 2 and all(str(one.message).startswith(place) for one, place in zip(told, places, strict=True))
    assert seen["deep"]["a"].tolist() == [1, 0]
    with warnings.catch_warnings(action="error"):
        env.step(1)
        world(scene=seeing(np.zeros(2))).reset(seed=1)


# Agents by attributes


def test_sixteen_are_seen_in_one_block_and_one_by_one_alike(world):
    """Of one form, which stands there once; of several; and who is away, as it was seen last."""
    scene, columns = seeing(*np.arange(32, dtype=np.float32).reshape(16, 2) / 4), []

    def change(answer):
        columns[:] = [section.columns for section in getattr(answer, "sections", [])]
        return answer

    envs = world(scene=scene, change=change, kind=UnityVectorEnv, num_envs=16)
    cars = list(scene.agents)

    def alike(seen):
        assert seen["x"].dtype == np.float32 and seen["x"].tolist() == [list(car.x) for car in cars]

    alike(envs.reset(seed=1)[0])
    assert columns == [FORM]
    nothing = np.zeros(16, int)
    cars[3].x = [5, 6.0]
    seen, *_ = envs.step(nothing)
    alike(seen)
    assert columns == [SIZES]
    seen["x"][:] = 7
    cars[3].x, cars[7].x = np.float32([6, 5]), np.float32([1, 0])
    alike(envs.step(nothing)[0])
    cars[3].x = np.float32([1, 2])
    scene.remove(cars[7])
    alike(envs.step(nothing)[0])
    assert columns == [FORM]
    scene.add(cars[7])
    cars[7].x = -cars[7].x
    alike(envs.step(nothing)[0])
    assert columns == [FORM]
    cars[7].x = np.float32([10, 0])
    with pytest.raises(MessageError, match=r"^not-in-space: 'agent_7'@\['x'\]: float32 \[2\] array\(\[10"):
        envs.step(nothing)


def test_each_of_several_has_the_space_that_python_gives_it(world):
    wide = spaces.Dict(x=spaces.Box(-9, 9, (2,), np.float64))
    given = {"agent_2": wide, "agent_0": spaces.Dict(x=ONE)}
    actions = {"agent_2": spaces.Discrete(5), "agent_0": spaces.Dict(go=ONE)}
    scene = seeing(*np.ones((3, 2), np.float32))
    env = world(scene=scene, kind=UnityParallelEnv, observation_spaces=given, action_spaces=actions)
    seen, _ = env.reset(seed=1)
    assert {name: one["x"].dtype for name, one in seen.items()} == {"agent_0": np.float32, "agent_2": np.float64}
    done: Any = []
    for car in scene.agents:
        car.on_action = done.append
    env.step({"agent_2": 4, "agent_0": {"go": np.ones(2, np.float32)}})
    assert done[0]["go"].tolist() == [1, 1] and done[1:] == [4], "and the one between them does nothing"


class Sure(Car):
    observation, action = spaces.Dict(x=ONE), spaces.Discrete(2)


def test_fields_are_seen_in_the_space_that_their_class_has(world):
    for words in ({"observation_space": None, "action_space": None}, {}):
        env = world(scene=seeing([1, 2], kind=Sure), **words)
        assert env.observation_space == Sure.observation
        assert env.reset(seed=1)[0]["x"].tolist() == [1, 2]
    with pytest.raises(MessageError, match=r"not-in-space: 'agent'@\['x'\]: float32 \[2\] array\(\[10"):
        world(scene=seeing([10, 0], kind=Sure)).reset(seed=1)
    with pytest.raises(MessageError, match=r"^wrong-scene: the observation of agent is Box.* here, at \['x'\]$"):
        world(GRAPH, scene=seeing([1, 2], kind=Sure))


def test_a_wrong_class_is_named():
    class Speeder(Agent):
        velocity: Annotated[Any, Obs(".speed[")] = None

    class Twice(Agent):
        speed: Annotated[Any, Obs()] = 1
        other: Annotated[Any, Obs(".speed")] = 2

    for kind, said in (
        (Speeder, 'Speeder.velocity, locator ".speed[": column 8: expected a key'),
        (Twice, "Twice.speed and Twice.other go to one place: 'agent'@['speed'] = $"),
    ):
        with pytest.raises(ValueError, match=f"^{re.escape(said)}"):
            kind()


@pytest.mark.filterwarnings("ignore:.*Box.*precision lowered:UserWarning", "ignore:.*overflow.*:RuntimeWarning")
def test_an_action_is_the_value_that_it_is_however_it_is_written():
    random = np.random.default_rng(12)
    spaces_of_actions = [NARROW, spaces.Dict(z=ONE, a=spaces.Discrete(2))]
    for space in [*spaces_of_actions, *(a_space(random) for _ in range(80))]:
        space.seed(12)
        action = space.sample()
        section = Section(0, b"", b"\1")
        Actions(space, CARS).put(section, [action])
        form = trees.SIZE.pack(len(section.form)) + section.form if section.columns & FORM else b""
        assert form + section.values == trees.write(fit.fitted(space, action, "")), space


# Plans: what is seen is read in the places where its form says that it goes


def told(sight, *pairs):
    try:
        sight.read(*trees.parted(trees.write_pairs(list(pairs))))
        return sight.again()
    except MessageError as error:
        return str(error)


def spoil(seen):
    for part in list(seen.values()) if isinstance(seen, dict) else seen if isinstance(seen, list | tuple) else ():
        spoil(part)
    if isinstance(seen, dict):
        seen.clear()
    elif isinstance(seen, np.ndarray):
        seen[...] = 1


STACK = spaces.Sequence(spaces.Dict(a=ONE, b=TWO), stack=True)
ODD = {
    **{
        f"links that are {what}": (GRAPH, spaces.GraphInstance(NODES, EDGES, links), "not-in-space: 'agent'@")
        for what, links in (("text", "x"), ("too large", [2**52]), ("fractions", np.array([[0, 0.7]])))
    },
    "a whole number that no float has": (ONE, [2**24 + 1, 0], "bad-observation: .*would become another number"),
    "too many": (spaces.Sequence(TWO), np.zeros(200_000, np.int64), "too-many: 'agent'@.*200000 items"),
    "another kind of what a OneOf has": (spaces.OneOf([ONE, spaces.Text(9)]), (1, "text"), None),
    "whole numbers of 32 bits": (spaces.Dict(a=NARROW, b=TWO), None, None),
    "a stack of dicts as a list": (STACK, [{"a": np.ones(2), "b": 1}] * 3, None),
    "a number for a text": (spaces.Text(9), 5, None),
    "a dict for a sequence": (spaces.Sequence(spaces.Text(9)), {"a": 1}, "not-in-space|bad-observation"),
    "no number of a OneOf": (spaces.OneOf([ONE]), [NODES, NODES], r"not-in-space: 'agent'@\['x'\]\[0\]: "),
    "keys in another order": (spaces.Dict(a=ONE, b=ONE), dict.fromkeys("ba", np.ones(2, np.float32)), None),
}


@pytest.mark.parametrize("what", ODD)
def test_a_plan_reads_what_merging_makes(what):
    """In the same place twice nothing can be planned: it is merged."""
    space, odd, said = ODD[what]
    space.seed(11)
    planned, merged = (Sight("agent", spaces.Dict(x=space)) for _ in range(2))
    for value in (space.sample(), odd, space.sample(), space.sample(), odd):
        value = space.sample() if value is None and what.startswith("whole") else value
        one, other = told(planned, (PLACE, value)), told(merged, (f"{PLACE} & {PLACE}", value))
        assert merged.plan is None
        assert isinstance(one, str) == (value is odd and said is not None), one
        if isinstance(one, str):
            assert re.match(said, one), one
            assert one.replace(PLACE, f"{PLACE} & {PLACE}")[:80] == other[:80] or isinstance(other, str)
            one, other = planned.again(), merged.again()
        assert equal(one, other) and str(one) == str(other), "in the same order, too"
        assert one in planned.space
        spoil(one)
        assert equal(planned.again(), merged.again()), "whatever its user does with it"


@pytest.mark.filterwarnings("ignore:.*Box.*precision lowered:UserWarning", "ignore:.*overflow.*:RuntimeWarning")
def test_plans_of_random_spaces_read_what_merging_makes():
    """Also of values of another space: both refuse them, or both take them for the same."""
    random = np.random.default_rng(11)
    for _ in range(100):
        space, other_space = a_space(random), a_space(random)
        planned, merged = (Sight("agent", spaces.Dict(x=space)) for _ in range(2))
        for value in (space.sample(), other_space.sample(), space.sample()):
            one, other = told(planned, (PLACE, value)), told(merged, (f"{PLACE} & {PLACE}", value))
            assert merged.plan is None
            assert isinstance(one, str) == isinstance(other, str), (space, value, one, other)
            assert equal(planned.again(), merged.again()), (space, value)
            if not isinstance(one, str):
                spoil(one)


def test_what_is_not_written_stays_whatever_form_comes():
    """Keys come and go, in any order, whole or in part; each is as it was when it was written last."""
    random = np.random.default_rng(11)
    space = spaces.Dict(
        a=ONE,
        deep=spaces.Dict(b=spaces.Discrete(99), c=spaces.Text(9, min_length=0), d=spaces.Dict(e=ONE, f=ONE)),
        many=spaces.Sequence(spaces.Dict(g=ONE), stack=True),
        one=spaces.OneOf([ONE, spaces.Text(9)]),
    )
    space.seed(11)
    keys = ["a", "deep.b", "deep.c", "deep.d", "deep.d.e", "deep.d.f", "many", "many[]", "one", "deep", "a(0)"]
    planned, merged = Sight("agent", space), Sight("agent", space)
    plans = 0
    for step in range(400):
        pairs = {}
        for key in random.permutation(keys)[: random.integers(4)]:
            path = re.sub(r"[\[(].*", "", key).split(".")
            value: Any = functools.reduce(lambda part, name: part[name], path, space.sample())
            pairs[str(key)] = float(value[0]) if "(" in key else {"g": np.ones(2)} if "[" in key else value
        # The whole of a thing before its parts, as a scene sends them.
        places = sorted((f"'agent'@.{key}", value) for key, value in pairs.items())
        one = told(planned, *places)
        # This pair must be merged, and changes nothing.
        nothing = ("'agent'@.a(0) = $(0)", merged.again()["a"])
        other = told(merged, nothing, *places)
        plans += planned.plan is not None
        assert merged.plan is None
        assert equal(one, other), (step, pairs)
        spoil(one)
        spoil(other)
        if step % 100 == 99:
            planned.forget()
            merged.forget()
            assert equal(planned.again(), merged.again()) and planned.again()["a"].tolist() == [0, 0]
    assert 100 < plans < 300


def test_forms_that_never_come_again_fill_no_memory(monkeypatch):
    monkeypatch.setattr(trees, "MOST_KEPT", 5)
    sight = Sight("agent", spaces.Dict(x=spaces.Sequence(spaces.Discrete(9)), y=ONE))
    for count in [*range(20), *range(20)]:
        seen = told(sight, (PLACE, [8] * count), *([("'agent'@.y", np.ones(2, np.float32))] if count == 0 else []))
        assert seen["x"] == (8,) * count and seen["y"].tolist() == [1, 1], "a plan that is forgotten is still the last"
        assert vars(sight.plan_for)["cache_info"]().currsize <= 5
    assert vars(trees.reader_of)["cache_info"]().maxsize
    # A long one is not kept at all.
    kept = vars(trees.reader_of)["cache_info"]().currsize
    trees.read(trees.write([1] * 3000))
    assert vars(trees.reader_of)["cache_info"]().currsize == kept


def test_what_goes_to_another_agent_as_well_is_that_ones_business():
    sight = Sight("agent", spaces.Dict(x=spaces.Discrete(9)))
    assert told(sight, ("agent@.x & bus@.nowhere", 5), ("@@agent@.nothing", 6), ("@@.x", 7)) == {"x": 7}


def test_each_message_clears_what_the_one_before_has_appended():
    sight = Sight("agent", spaces.Dict(x=spaces.Sequence(spaces.Discrete(9))))
    assert [told(sight, *[("agent@.x[]", number)] * 2)["x"] for number in (1, 2)] == [(1, 1), (2, 2)]
