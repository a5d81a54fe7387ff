"""Lesson 09: a value of any of Gymnasium's spaces arrives as it was, in both languages: golden bytes, samples of every
space, batches of them by Gymnasium's rules, and rows that are none.
"""

import contextlib
import itertools
import json
import random
import struct
import subprocess
import tracemalloc
import warnings
from typing import Annotated

import pytest

from tests.programs import LIMIT, ROOT, free_port
from tests.unity.test_unity_play import needs_mono

gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")
from gymnasium.spaces import (  # noqa: E402
    Box,
    Dict,
    Discrete,
    Graph,
    GraphInstance,
    MultiBinary,
    MultiDiscrete,
    OneOf,
    Sequence,
    Text,
    Tuple,
)
from gymnasium.utils.env_checker import data_equivalence  # noqa: E402
from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402
from gymnasium.vector.utils import iterate  # noqa: E402
from gymnasium.wrappers import TimeLimit  # noqa: E402

from netmq_example.envs import UnityGymEnv, UnityVectorEnv  # noqa: E402
from netmq_example.errors import Refused  # noqa: E402
from netmq_example.messages import Message, MessageError  # noqa: E402
from netmq_example.scene import Agent, Obs, Scene, SceneSimulator  # noqa: E402
from netmq_example.wire import trees  # noqa: E402
from netmq_example.wire.records import (  # noqa: E402
    ANSWERS,
    ASKS,
    ENDED,
    GROUPS,
    IDS,
    MASKS,
    RESET,
    SEEN,
    SIZES,
    STEP,
    WHO,
    Record,
    Section,
    read,
)
from netmq_example.wire.sections import rewards_in, seeds  # noqa: E402
from netmq_example.wire.space_bytes import Bytes  # noqa: E402
from netmq_example.wire.spaces import described, misfit, space_of  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402
from tests.lessons.vectors import play  # noqa: E402

GOLDEN = json.loads((ROOT / "tests" / "lessons" / "golden" / "09_environment.json").read_text(encoding="utf-8"))


def limits(dtype, low, high):
    return Box(np.array(low, dtype), np.array(high, dtype), dtype=np.dtype(dtype).type)


PAIR = limits("float32", [-1, -2], [1, 2])
# As in RecordChecks.cs.
BOTH = {
    "pair": PAIR,
    "grid": Box(-1, 1, (2, 3)),
    "number": Box(0, 1, ()),
    "nothing": Box(0, 1, (0,)),
    "picture": Box(0, 255, (4, 5, 3), np.uint8),
    "float64": limits("float64", [-np.inf, 0], [np.inf, 1]),
    "uint8": limits("uint8", [1, 2], [3, 200]),
    "uint16": limits("uint16", [0, 7], [65535, 7]),
    "int32": limits("int32", [-(2**31), -5], [2**31 - 1, 5]),
    "int64": limits("int64", [-5, 0], [5, 2**40]),
    "discrete": Discrete(3),
    "shifted": Discrete(4, start=-2),
    "bits": MultiBinary(5),
    "bits2": MultiBinary([2, 3]),
    "choices": MultiDiscrete([3, 4, 5]),
    "text": Text(8),
    "letters": Text(5, min_length=0, charset=" xäö€😀"),
    "dict": Dict({"a": Discrete(3), "b": PAIR, "c": MultiBinary(5)}),
    "tuple": Tuple([Text(8), Discrete(4, start=-2)]),
    "sequence": Sequence(PAIR),
    "words": Sequence(Text(8)),
    "stack": Sequence(PAIR, stack=True),
    "stacks": Sequence(Dict({"a": Discrete(3), "b": PAIR}), stack=True),
    "nothings": Sequence(Box(0, 1, (0,))),
    "graph": Graph(PAIR, Discrete(4, start=-2)),
    "points": Graph(PAIR, None),
    "one": OneOf([Discrete(3), PAIR, Text(8)]),
    "nested": Dict(
        {
            "a": Tuple([Sequence(Dict({"x": PAIR, "y": Text(8)})), Discrete(3)]),
            "b": OneOf([Graph(PAIR, Discrete(4, start=-2)), Sequence(Sequence(PAIR))]),
        }
    ),
}
# Which C# has no names for.
PYTHON_ALONE = {
    "int8": limits("int8", [-128, -3], [127, 3]),
    "int16": limits("int16", [-300], [300]),
    "uint32": limits("uint32", [0], [2**32 - 1]),
    "uint64": limits("uint64", [0], [2**40]),
    "float16": limits("float16", [-1, 0], [1, 2]),
    "bool": Box(0, 1, (3,), np.bool_),
    "choices2": MultiDiscrete(np.array([[3, 4], [5, 6]]), dtype=np.int32, start=np.array([[-1, 0], [2, 3]])),
    "dicts": Sequence(
        OneOf([Sequence(Discrete(2), stack=True), Dict({"z": Text(3), "a": Tuple([PAIR, Discrete(2)])})])
    ),
    "network": Graph(Box(0, 1, (2, 2), np.float64), Box(-1, 1, (3,))),
}
# Gymnasium 1.1 has neither.
with contextlib.suppress(TypeError):
    PYTHON_ALONE["small"] = Discrete(5, start=1, dtype=np.int32)
with contextlib.suppress(TypeError, AssertionError):
    PYTHON_ALONE["cities"] = Graph(Dict({"x": PAIR, "n": Discrete(3)}), Tuple([Discrete(3), PAIR]))


class Echo(Agent):
    """One sees what was done last; after a reset, what its option `say` says."""

    def __init__(self, space):
        super().__init__("echo")
        self.observation = self.action = space
        self.said, self.steps = None, 0

    def on_reset(self):
        self.said, self.steps = self.options["say"], 0

    def on_action(self, action):
        self.said = action
        self.steps += 1

    def on_stepped(self):
        self.reward += 0.5 * self.steps
        self.terminated, self.truncated = self.steps == 3, self.steps == 4
        self.info["steps"] = self.steps

    def observe(self):
        return self.said


class Fields(Agent):
    """One by attributes, which is told what it says."""

    number: Annotated[float, Obs()] = 0.5
    place: Annotated[object, Obs(".body.place")] = np.zeros(2, np.float32)
    says: Annotated[str, Obs("@@.says")] = ""
    mine: Annotated[str, Obs()] = ""
    steps = 0

    def __init__(self):
        super().__init__("echo")

    def on_reset(self):
        self.says, self.steps = self.options.get("say", ""), 0

    def on_action(self, action):
        self.says = self.mine = action
        self.steps += 1

    def on_stepped(self):
        self.number += 1
        self.place = np.full(2, self.number, np.float32)
        self.reward += 0.5 * self.steps
        self.terminated = self.steps == 2
        self.send_info(self.says)


def simulator(name, *agents):
    return SceneSimulator(Scene(name, agents))


def agent_of(name):
    return Fields() if name == "fields" else Echo(BOTH[name])


# Said to a single environment by nobody.
NOTHING: dict[str, list[object]] = {"env": [], "agent": []}


def samples(space, count=6):
    space.seed(1)
    with warnings.catch_warnings():
        # That a sequence of a stack may be empty.
        warnings.simplefilter("ignore")
        return [space.sample() for _ in range(count)]


def without_uint64(space, sample):
    """No option has it."""
    return sample.astype(np.int64) if getattr(sample, "dtype", None) == np.uint64 else sample


def without_stacks(space, sample):
    """In C# even a stack is a list."""
    stacked = isinstance(space, Sequence) and space.stack
    return list(iterate(space.stacked_feature_space, sample)) if stacked else sample


def echoes(env, said):
    """Each sample comes back, of a reset and of a step: the same values of the same types."""
    space = env.observation_space
    before = None
    for sample in samples(space):
        # Before 1.4 a sample of a Graph does not know where its edges' numbers start.
        if sample not in space and gymnasium.__version__ < "1.4":
            continue
        seen, info = env.reset(options={"say": said(space, sample)})
        assert data_equivalence(seen, sample, exact=True) and seen in space and info == NOTHING
        for step in range(1, 4):
            before, (seen, *rest) = seen, env.step(sample)
            assert data_equivalence(seen, sample, exact=True)
            assert rest == [0.5 * step, step == 3, False, {**NOTHING, "steps": step}]
        # A user may keep it, or write into it.
        if isinstance(seen, np.ndarray):
            assert seen.flags.writeable and not np.shares_memory(before, seen)


@pytest.mark.parametrize("name", [*BOTH, *PYTHON_ALONE])
def test_what_is_done_in_a_space_is_seen(name, inside):
    space = (BOTH | PYTHON_ALONE)[name]
    env = UnityGymEnv(name, socket=inside(simulator(name, Echo(space))).socket)
    assert env.observation_space == env.action_space == space
    # A Dict keeps the order of its keys, in which an agent flattens it.
    assert str(env.observation_space) == str(space)
    echoes(env, without_uint64)
    env.close()


@pytest.fixture
def program(checks):
    return ["dotnet", checks, "records"]


@pytest.fixture(params=["dotnet", "mono"])
def each_runtime(request, program):
    """Unity's runtime is a Mono."""
    if request.param == "mono":
        needs_mono()
    return [request.param, *program[1:]]


def said_by(program, *words, lines=()):
    done = subprocess.run([*program, *words], input="\n".join(lines), capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_what_is_done_in_a_space_is_seen_in_csharp(program, start):
    endpoint = f"tcp://127.0.0.1:{free_port()}"
    worlds = start(*program, "worlds", endpoint, *BOTH)
    for name, space in BOTH.items():
        env = UnityGymEnv(name, endpoint=endpoint, wait=LIMIT)
        assert env.observation_space == env.action_space == space
        echoes(env, without_stacks)
        env.close()
    assert worlds.wait() == 0


# Bytes


def python_says(name, count, *asks):
    """RecordChecks.cs's answer to the last of these requests."""
    answering = simulator(name, *(agent_of(name) for _ in range(int(count))))
    answering.hello()
    for digits in asks:
        try:
            (frame,) = answering.answer(read(ASKS, bytes.fromhex(digits)))
        except MessageError as error:
            return f"error {error.code}"
    return f"error {json.loads(frame)['values']['code']}" if frame[:1] == b"{" else frame.hex()


def begun(name, count=1):
    """The request before a step of theirs."""
    (say,) = samples(BOTH[name], 1)
    options = trees.write({"say": without_stacks(BOTH[name], say)})
    section = Section(0, seeds(range(count)), bytes([RESET]) * count)
    return Record(ASKS, 1, [section], said=options).frame().hex()


def test_python_agrees_with_the_golden_bytes():
    hello = SceneSimulator(Scene("CartPole", [CartPole()])).hello()
    assert GOLDEN["spaces"].keys() == {"hello", *BOTH}
    for name, space in BOTH.items():
        digits = GOLDEN["spaces"][name]
        assert trees.write(described(space)).hex() == digits, name
        assert space_of(trees.read(bytes.fromhex(digits))) == space
    assert bytes(hello.arrays[0].data).hex() == GOLDEN["spaces"]["hello"]
    for entry in GOLDEN["records"]:
        assert python_says(entry["space"], entry["agents"], *entry["asks"]) == entry["says"], entry["name"]
    # This one reads: two of three agents begin anew, and one steps.
    (entry,) = [one for one in GOLDEN["records"] if one["name"] == "three agents"]
    section = Section(0, seeds([7, -1, 0]), bytes([RESET, RESET, STEP]), values=b"\2" + bytes(7))
    assert Record(ASKS, 2**40, [section], said=trees.write({"say": 1})).frame().hex() == entry["asks"][1]


def test_each_column_stands_where_the_table_says():
    """By hand, also those of the scene's clock: two rows of kind 1, which have 3 choices."""
    head = struct.pack("<BBHIqII", ANSWERS, 1 | 8, 1, 0, 7, 2, 5) + b"ab".ljust(8, b"\0") + b"other".ljust(8, b"\0")
    columns = {
        WHO: struct.pack("<2I", 4, 2),
        IDS: struct.pack("<2i", -1, 9),
        GROUPS: struct.pack("<2i2f", 1, 0, 0.5, 2),
        MASKS: struct.pack("<I", 3) + b"\1\0\1\0\1\1" + bytes(6),
        SIZES: struct.pack("<2I", 3, 2),
        ENDED: b"",
    }
    begin = struct.pack("<HHIIIII", 1, sum(columns), 2, 1, 5, 3, 0) + struct.pack("<2d2B6x", 0.5, -1, SEEN | 1, SEEN)
    values = b"abcde\0\0\0" + struct.pack("<2I", 1, 3) + b"xyz\0\0\0\0\0"
    frame = head + begin + b"".join(columns.values()) + values
    record = read(ANSWERS, frame)
    (section,) = record.sections
    assert (record.id, record.bits, bytes(record.said), bytes(record.exchange)) == (7, 9, b"ab", b"other")
    assert (section.kind, list(section.whose()), rewards_in(section)) == (1, [4, 2], (0.5, -1))
    assert [bytes(part) for part in (section.ids, section.groups)] == [columns[IDS], columns[GROUPS]]
    assert bytes(section.masks) == columns[MASKS][4:10]
    assert [bytes(row) for row in section.rows(ANSWERS)] == [b"abc", b"de"]
    assert [(row, bytes(data)) for row, data in section.each_info()] == [(1, b"xyz")]
    assert record.frame() == frame
    # Cut anywhere, or with larger masks than there are, it is none; with another number in it, it is none or whole.
    larger = frame.replace(columns[MASKS][:5], struct.pack("<I", 20) + b"\1")
    assert larger != frame
    for wrong in (*(frame[:at] for at in range(len(frame))), larger):
        with pytest.raises(MessageError, match=r"^bad-record: "):
            read(ANSWERS, wrong)
    for at, number in itertools.product(range(0, len(frame), 4), (0, 1, 8, 32, 96, 2**31, 2**32 - 1)):
        with contextlib.suppress(MessageError):
            other = read(ANSWERS, frame[:at] + struct.pack("<I", number) + frame[at + 4 :])
            assert all(len(section.table) % 8 == 0 for section in other.sections)


def test_csharp_agrees_with_the_golden_bytes(each_runtime):
    assert dict(line.split() for line in said_by(each_runtime, "spaces")) == GOLDEN["spaces"]
    lines = [f"{entry['space']} {entry['agents']} {' '.join(entry['asks'])}" for entry in GOLDEN["records"]]
    for entry, answer in zip(GOLDEN["records"], said_by(each_runtime, "rows", lines=lines), strict=True):
        assert answer == entry["says"], entry["name"]


def test_a_golden_record_that_is_cut_anywhere_is_none(program):
    right = [entry for entry in GOLDEN["records"] if not entry["says"].startswith("error")]
    whole = {(entry["space"], entry["agents"], ask) for entry in right for ask in entry["asks"]}
    cut = [(*words, ask[:at]) for *words, ask in sorted(whole) for at in range(2, len(ask), 2)]
    assert {*said_by(program, "rows", lines=[" ".join(map(str, words)) for words in cut])} == {"error bad-record"}
    answers = [(ANSWERS, entry["says"][:at]) for entry in right for at in range(2, len(entry["says"]), 2)]
    for kind, digits in [*((ASKS, digits) for *_, digits in cut), *answers]:
        with pytest.raises(MessageError, match=r"^bad-record: "):
            read(kind, bytes.fromhex(digits))


def stepped(name, row):
    """A line for `rows`: a reset, and then this action."""
    step = Record(ASKS, 2, [Section(0, bytes(8), bytes([STEP]), values=row)]).frame().hex()
    return f"{name} 1 {begun(name)} {step}"


# Each is no row of its space.
NO_ROWS = {
    "pair": [struct.pack("<2f", *pair) for pair in ((1.1, 0), (0, -2.1), (np.nan, 0), (np.inf, 0))],
    "float64": [struct.pack("<2d", *pair) for pair in ((np.nan, 0), (0, 1.0000001), (0, np.inf))],
    "uint8": [b"\0\2", b"\3\xc9"],
    "uint16": [struct.pack("<2H", 0, 6), struct.pack("<2H", 0, 8)],
    "int32": [struct.pack("<2i", 0, 6), struct.pack("<2i", 0, -6)],
    "int64": [struct.pack("<2q", 0, -1), struct.pack("<2q", 6, 0)],
    "discrete": [struct.pack("<q", number) for number in (-1, 3, 2**63 - 1)],
    "shifted": [struct.pack("<q", number) for number in (-3, 2)],
    "bits": [b"\0\1\0\1\2", b"\0\1\0\1\xff"],
    "choices": [struct.pack("<3q", 2, 3, 5), struct.pack("<3q", 2, -1, 4)],
    "text": [
        b"\0\0\0\0",
        b"\2\0\0\0a ",
        b"\x09\0\0\0" + 9 * b"a",
        b"\1\0\0\0\xe4",
        b"\xff\xff\xff\xffa",
        b"\0\0\0\x80a",
    ],
    "letters": [b"\1\0\0\0y", b"\3\0\0\0\xed\xa0\xbd", b"\x06\0\0\0xxxxxx"],
    "sequence": [b"\2\0\0\0" + bytes(8), b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\xff\xff\xff\x1f" + bytes(64)],
    "words": [b"\1\0\0\0\0\0\0\0", b"\xff\xff\xff\xff" + b"\1\0\0\0a" * 9],
    "stack": [b"\2\0\0\0" + bytes(8), b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f" + bytes(8)],
    "nothings": [b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\xff\xff\x7f\0"],
    "graph": [
        struct.pack("<2I", 2**32 - 1, 2**32 - 1),
        struct.pack("<2I", 2**31 - 1, 0),
        struct.pack("<2I2f", 1, 2**31 - 1, 0, 0),
        struct.pack("<2I2f", 1, 2**29, 0, 0) + bytes(64),
        # A link to a node that is not there, on either side.
        *(struct.pack("<2I2fq2i", 1, 1, 0, 0, 0, 0, link) for link in (1, -1)),
        struct.pack("<2I2f", 1, 2**32 - 1, 3, 0),
        struct.pack("<I", 1),
    ],
    "points": [struct.pack("<2I2f", 1, 0, 0, 0)],
    "one": [b"\3\0\0\0" + bytes(8), b"\xff\xff\xff\xff" + bytes(8), b"\0\0\0\0" + bytes(7), b"\1\0"],
}


def bad_rows():
    """Those above; and samples of every space that are cut, or have a byte too many."""
    for name, rows in NO_ROWS.items():
        yield from ((name, row) for row in rows)
    for name, space in BOTH.items():
        for row in map(Bytes(space).write, samples(space, 3)):
            yield name, row + b"\0"
            if row:
                yield name, row[:-1]


def test_rows_that_are_none_are_refused_in_both_languages(program):
    lines = [stepped(name, row) for name, row in bad_rows()]
    answers = [python_says(*line.split()) for line in lines] + said_by(program, "rows", lines=lines)
    found = zip(lines * 2, answers, strict=True)
    assert [each for each in found if each[1] != "error not-in-space"] == []


NONE = b"\0\0\0\0"
# No items, no nodes, no edges.
EMPTY = {"sequence": NONE, "stack": NONE, "stacks": NONE, "points": NONE + b"\xff" * 4, "graph": b"\1" + bytes(15)}


HALF, ZEROS = np.array([0.5]), np.zeros((1, 2))
# None of these numbers is one of its space's dtype.
OTHER_NUMBERS = {
    "uint8": [[0.7, 2], [300, 2], [-1, 2], np.array([1, np.nan]), [2, 1e30], np.uint16([258, 2])],
    "uint16": [[-1, 7], [65536, 7]],
    "int32": [[0.5, 0], [2**31, 0]],
    "int64": [[0.5, 0], [2**63 - 1, 0.0], [1e300, 0]],
    "pair": [[1e39, 0], [-1e39, 0]],
    "discrete": [2.9, -0.1],
    "bits": [[0.5, 0, 0, 1, 0], [256, 0, 0, 0, 0]],
    "choices": [[0.9, 0, 0]],
    "one": [[0.7, 1], [0, 1.5], [-1, 0]],
    "graph": [GraphInstance(ZEROS, HALF, ZEROS), GraphInstance(ZEROS, HALF + 0.5, ZEROS + 0.5)],
}


def test_no_number_becomes_another_one_in_both_languages(program):
    """0.7 is no 0, 300 no 44 and NaN no 0: an agent would learn from what nobody has seen."""
    lines = []
    for name, wrong in OTHER_NUMBERS.items():
        for value in wrong:
            section = Section(0, seeds([1]), bytes([RESET]))
            lines.append(f"{name} 1 {Record(ASKS, 1, [section], said=trees.write({'say': value})).frame().hex()}")
    answers = [python_says(*line.split()) for line in lines]
    answers += said_by(program, "rows", lines=lines)
    wrong = [answer for answer in zip(lines * 2, answers, strict=True) if not answer[1].startswith("error ")]
    assert wrong == []
    # C# counts with doubles.
    assert said_by(program, "large") == ["low and high of int64 lie between -2^53 and 2^53"]


@pytest.mark.parametrize("pixel", [0.7, 300, "red"])
def test_a_picture_of_other_numbers_is_refused(pixel):
    echo = Echo(PAIR)
    echo.render = lambda: [[[pixel, 0, 0]]]
    frames = simulator("pair", echo).answer(Message("render", 1))
    with pytest.raises(Refused, match=r"^bad-picture: a picture is uint8 \[height, width, 3\]: "):
        Message.read_reply(frames)


@pytest.mark.parametrize("many", [np.zeros((2**19, 0), np.float32), np.full(2**19, 9, np.float32), "x" * 2**19])
def test_to_say_what_is_wrong_takes_no_more_memory_than_it_shows(many):
    tracemalloc.start()
    try:
        assert len(str(misfit(many, PAIR))) < 500
        assert tracemalloc.get_traced_memory()[1] < 100_000
    finally:
        tracemalloc.stop()


def test_both_languages_agree_on_rows_with_some_bytes_changed(each_runtime):
    """Each row is not in the space, or the same is seen. A row of nothing is in its space."""
    at_random = random.Random(1)
    lines = [stepped(name, row) for name, row in EMPTY.items()]
    # How many items of no bytes there may be is not the same.
    for name in sorted(BOTH.keys() - {"nothings"}):
        for row in map(bytearray, map(Bytes(BOTH[name]).write, samples(BOTH[name], 40))):
            for _ in range(at_random.choice([0, 1, 1, 2, 3]) if row else 0):
                # Small numbers too, which sizes are.
                byte = at_random.choice([0, 1, 2, 3, 127, 128, 255, at_random.randrange(256)])
                row[at_random.randrange(at_random.choice([len(row), min(8, len(row))]))] = byte
            lines.append(stepped(name, row))
    mine = [python_says(*line.split()) for line in lines]
    theirs = said_by(each_runtime, "rows", lines=lines)
    different = [each for each in zip(lines, mine, theirs, strict=True) if each[1] != each[2]]
    assert different == []
    assert not [answer for answer in mine[: len(EMPTY)] if answer.startswith("error")]
    right = sum(not answer.startswith("error") for answer in mine)
    assert len(lines) / 4 < right < len(lines)


# Batches


class Walk(Echo):
    """It goes on until its steps are as many as its beginning has said."""

    state_size = 1

    def on_reset(self):
        self.observation.seed(int(2**31 * self.rng()))
        self.last = int(self.state[0]) if self.state else 2 + int(5 * self.rng())
        self.said, self.steps = self.observation.sample(), 0

    def on_stepped(self):
        super().on_stepped()
        over = self.steps == self.last
        self.terminated, self.truncated = over and self.last % 2, over and not self.last % 2


WALKS = {
    "of a fixed size": Dict(
        {"a": Discrete(3, start=1), "b": PAIR, "c": Tuple([MultiBinary(2), MultiDiscrete([2, 3])])}
    ),
    "of any size": Dict({"a": Text(4), "b": Sequence(PAIR), "c": OneOf([Discrete(2), PAIR]), "d": Graph(PAIR, None)}),
}


@pytest.mark.parametrize("mode", AutoresetMode)
@pytest.mark.parametrize("kind", WALKS)
def test_batches_are_those_of_gymnasium(kind, mode, inside, make):
    space, count = WALKS[kind], 3

    def walk():
        return Walk(space_of(trees.read(trees.write(described(space)))))

    def single():
        return TimeLimit(UnityGymEnv("Walk", socket=inside(simulator("Walk", walk())).socket), 5)

    many = inside(simulator("Walk", *(walk() for _ in range(count))))
    ours = make(UnityVectorEnv, count, "Walk", max_episode_steps=5, autoreset_mode=mode, socket=many.socket)
    theirs = make(SyncVectorEnv, [single] * count, autoreset_mode=mode)
    theirs.action_space.seed(1)
    again = {"seed": [10, 11, 12]}, {"options": {"state": [3.0]}}
    ends = play([ours, theirs], lambda seen, step: theirs.action_space.sample(), 30, {"seed": 7}, *again)
    assert (ends.sum(1) > 3).all(), "episodes ended both ways"
