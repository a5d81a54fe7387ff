"""Lesson 11: a peer's bytes that are no values, and a user's spaces and values that cannot be, are a line each."""

from __future__ import annotations

import functools
import inspect
import re
import struct
import warnings
from typing import Annotated, Any

import pytest

from tests.lessons.test_11_trees import a_space, equal

gymnasium = pytest.importorskip("gymnasium", reason="lesson 11 needs gymnasium: kit.py run 11 installs it")
np = pytest.importorskip("numpy", reason="lesson 11 needs numpy: kit.py run 11 installs it")
pytest.importorskip("pettingzoo", reason="lesson 11 needs pettingzoo: kit.py run 10 installs it")
from gymnasium import spaces  # noqa: E402

from netmq_example.envs import UnityGymEnv, UnityParallelEnv, UnityVectorEnv  # noqa: E402
from netmq_example.envs import merge as fit  # noqa: E402
from netmq_example.envs.actions import Actions  # noqa: E402
from netmq_example.envs.kinds import Kind  # noqa: E402
from netmq_example.envs.plan import Sight  # noqa: E402
from netmq_example.messages import Message, MessageError  # noqa: E402
from netmq_example.scene import Agent, Obs, Scene, SceneSimulator  # noqa: E402
from netmq_example.wire import records, sections, trees  # noqa: E402
from netmq_example.wire.records import FORM, SIZES, TERMINATED, Record, Section  # noqa: E402
from netmq_example.worlds.coin_car import CoinCar  # noqa: E402

KEY = "11_observations"
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
X, TWO = f'["{PLACE}",%s]', '"float32[2]"'


def tree(form, numbers=b""):
    return struct.pack("<I", len(form)) + form.encode() + numbers


@pytest.mark.parametrize(
    ("odd", "said"),
    [
        *((tree(form), "bad-tree") for form in ("[1,2]", "[[1,1]]", '[[[1],"null"]]', "5", "{}", "[", f'"{PLACE}"')),
        (tree(f'["{PLACE}","null",2]'), "bad-tree"),
        *((tree(f"[{X % form}]"), "bad-tree") for form in ("5", '"float16[2]"', "[" * 65 + "]" * 65)),
        (b"\1\0", "bad-tree: .* too early"),
        (struct.pack("<I", 9) + b"[]", "bad-tree: .* too early"),
        (tree(f"[{X % TWO}]", bytes(7)), "bad-observation: it is cut short"),
        (tree(f"[{X % TWO}]", bytes(9)), "bad-observation: more follows what was seen"),
        (tree(f"[{X % TWO},{X % TWO}]", bytes(17)), "bad-observation: more follows what was seen"),
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
    """Not even to be seen."""
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


@pytest.mark.parametrize("space", [None, 5, Own])
def test_what_is_no_space_of_a_value_is_named_with_its_place(space):
    with pytest.raises((ValueError, TypeError), match=r"^x: "):
        fit.fitted(space, 1, "x")


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
    """Python may leave it out, or say the same."""
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
    """What is seen then, or what is wrong with it."""
    try:
        sight.read(*trees.parted(trees.write_pairs(list(pairs))))
        return sight.again()
    except MessageError as error:
        return str(error)


def spoil(seen):
    """As the user of an observation may do."""
    for part in list(seen.values()) if isinstance(seen, dict) else seen if isinstance(seen, list | tuple) else ():
        spoil(part)
    if isinstance(seen, dict):
        seen.clear()
    elif isinstance(seen, np.ndarray):
        seen[...] = 1


ODD = {
    "links that are text": (GRAPH, spaces.GraphInstance(NODES, EDGES, "x"), "not-in-space: 'agent'@"),
    "links too large": (GRAPH, spaces.GraphInstance(NODES, EDGES, [2**52]), "not-in-space: 'agent'@"),
    "links with a fraction": (
        GRAPH,
        spaces.GraphInstance(NODES, EDGES, np.array([[0, 0.7]])),
        "not-in-space: 'agent'@",
    ),
    "a whole number that no float has": (ONE, [2**24 + 1, 0], "bad-observation: .*would become another number"),
    "too many": (spaces.Sequence(spaces.Discrete(2)), np.zeros(200_000, np.int64), "too-many: 'agent'@.*200000 items"),
    "another kind of what a OneOf has": (spaces.OneOf([ONE, spaces.Text(9)]), (1, "text"), None),
    "whole numbers of 32 bits": (spaces.Dict(a=NARROW, b=spaces.Discrete(2)), None, None),
    "a stack of dicts as a list": (
        spaces.Sequence(spaces.Dict(a=ONE, b=spaces.Discrete(2)), stack=True),
        [{"a": np.ones(2), "b": 1}] * 3,
        None,
    ),
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
