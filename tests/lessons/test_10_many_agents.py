"""Lesson 10: areas as Gymnasium's vectors, agents as PettingZoo's, each with each simulator. Faults are in
test_10_many_agents_faults.py.
"""

from __future__ import annotations

import importlib
import inspect
import sys
import time
import warnings
from collections import OrderedDict
from typing import ClassVar

import pytest

from tests.conftest import CLIENTS
from tests.programs import ROOT

gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: kit.py run 10 installs it")
np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: kit.py run 10 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
from gymnasium import spaces  # noqa: E402
from gymnasium.utils.env_checker import data_equivalence  # noqa: E402
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test  # noqa: E402
from pettingzoo.utils.conversions import parallel_to_aec  # noqa: E402

KEY, AREAS = "10_many_agents", 4
sys.path.append(str(ROOT / "python" / KEY))
from netmq_example.envs import ZmqParallelEnv  # noqa: E402
from netmq_example.launch import game  # noqa: E402
from netmq_example.messages import Message, MessageError  # noqa: E402
from netmq_example.scene.agents import AgentSimulator  # noqa: E402
from netmq_example.scene.areas import AreaSimulator  # noqa: E402
from netmq_example.scene.simulation import AgentSimulation, InfoQueue, RealTime  # noqa: E402
from netmq_example.wire import trees  # noqa: E402
from netmq_example.wire.records import ASKS, NOTHING, RESET, STEP, Record, seeds  # noqa: E402
from netmq_example.wire.space_bytes import Bytes  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402
from netmq_example.worlds.pursuit import Pursuit  # noqa: E402
from netmq_example.worlds.road_car import RoadCar  # noqa: E402

players = importlib.import_module("players")
policy, drive = players.policy, players.drive
each_client = pytest.mark.parametrize("kind", CLIENTS)


@pytest.fixture
def areas(inside, make):
    """Areas of a simulator in this process."""

    def made(**more):
        simulator = inside(AreaSimulator([CartPole() for _ in range(AREAS)]))
        return make(gymnasium.make_vec, "NetMQExample/CartPole-v0", AREAS, socket=simulator.socket, **more)

    return made


@pytest.fixture
def pursuit(inside, make):
    """The game in this process."""
    return lambda **more: make(ZmqParallelEnv, socket=inside(AgentSimulator(Pursuit())).socket, **more)


@pytest.fixture(scope="module")
def kept():
    """Environments by what simulates, each for several tests."""
    kept = {}
    yield kept
    for env in kept.values():
        env.close()


@pytest.fixture
def csharp_areas(kept, launch):
    if "areas" not in kept:
        words = launch("csharp", "--world", "CartPole", "--areas", str(AREAS), key=KEY)
        kept["areas"] = gymnasium.make_vec("NetMQExample/CartPole-v0", AREAS, launch=words, render_mode="rgb_array")
    return kept["areas"]


@pytest.fixture
def played(kind, kept, launch):
    if kind not in kept:
        kept[kind] = ZmqParallelEnv(launch=launch(kind, key=KEY), render_mode="rgb_array")
    return kept[kind]


def steps(*numbers):
    """A request in which so many step, each with the number of a discrete action."""
    rows = [number.to_bytes(8, "little") for number in numbers]
    return Record(ASKS, 0, bytes(8 * len(rows)), [STEP] * len(rows), rows)


def resets(orders, options=b""):
    return Record(ASKS, 0, seeds([1] * len(orders)), orders, [b""] * len(orders), options=options)


def info(value):
    return Message("info", 0, {}, [trees.array_of(trees.write(value))])


# Areas


def same(ours, theirs):
    assert data_equivalence(ours[0], theirs[0]), "observations"
    for mine, other in zip(ours[1:-1], theirs[1:-1], strict=True):
        assert np.array_equal(mine, other) and mine.dtype == other.dtype
    assert data_equivalence(ours[-1], theirs[-1]), f"{ours[-1]} {theirs[-1]}"


def test_both_languages_drive_cars_alike(launch, inside, make):
    """To the last bit, by actions that are no whole numbers; and one of them leaves its road."""
    words = launch("csharp", "--world", "Car", "--areas", "3", key=KEY)
    ours = inside(AreaSimulator([RoadCar() for _ in range(3)])).socket
    wheres = {"launch": words}, {"socket": ours}
    envs = [make(gymnasium.make_vec, "NetMQExample/Car-v0", 3, **where) for where in wheres]
    seen = [each.reset(seed=5) for each in envs]
    same(*seen)
    ends = 0
    for step in range(150):
        action = np.array([[1, 1], *drive(seen[0][0])[1:]], np.float32)
        action[2, 0] *= np.float32(0.1 * (step % 10))
        seen = [each.step(action) for each in envs]
        same(*seen)
        ends += seen[0][2].sum()
    assert ends and seen[0][-1]["metres"][1] > 1


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_crowd_of_cars_stays_on_its_roads(kind, serve, start, client_command):
    words = ["--world", "Car", "--areas", "3"]
    server, endpoint = serve(KEY, *words)
    client = start(*client_command(kind, KEY, endpoint, *words))
    # Their time is up, all at once, and nobody has left the road before.
    server.wait_for("^1000 steps of 3 areas: 3 episodes ended$")
    assert client.wait() == 0
    assert client.lines[-1] == "done: 3 episodes, 3000 steps"


def test_each_area_has_its_picture(csharp_areas, areas):
    for envs in csharp_areas, areas(render_mode="rgb_array"):
        envs.reset(seed=[1, 2, 3, 4])
        pictures = envs.render()
        assert [picture.shape for picture in pictures] == [(200, 300, 3)] * AREAS
        assert len({picture.tobytes() for picture in pictures}) == AREAS


def test_areas_name_what_is_wrong_and_none_of_them_moves(csharp_areas, areas):
    orders = [RESET] * AREAS
    for envs in csharp_areas, areas():
        seen, _ = envs.reset(seed=1)
        # To Gymnasium 1.1, numbers with a fraction are in a MultiDiscrete.
        fractions = [] if np.zeros(AREAS) in envs.action_space else [np.zeros(AREAS)]
        for actions in (np.array([0, 1, 2, 1]), np.array([0, 1]), *fractions):
            with pytest.raises(ValueError, match=r"are not in MultiDiscrete\(\[2 2 2 2\]\)"):
                envs.step(actions)
        # And when they come all the same, the simulator refuses them.
        short = steps(1, 1, 1, 1)
        short.rows[3] = short.rows[3][:4]
        for request, text in (
            (steps(1, 1, 1, 2), r"not-in-space: .* is not in Discrete\(2\)"),
            (short, r"not-in-space: 4 bytes are not in Discrete\(2\)"),
            (steps(1, 1), r"wrong-areas: this simulator has 4 areas, not 2: make_vec\(…, num_envs=4\)"),
            (resets(orders, b"x"), "bad-tree"),
            (resets(orders, trees.write([])), "bad-options: options are a dict"),
            (resets(orders, trees.write({"state": [1.0, 2.0]})), "bad-state: a state is 4 numbers, not 2"),
            (resets(orders, trees.write({"state": "here"})), "bad-state: a state is numbers"),
            (Message("jump"), "unknown-kind: kind .?jump.? is none of reset, step, render, close"),
        ):
            with pytest.raises(MessageError, match=text):
                envs.areas.ask(request)
        assert np.array_equal(envs.areas.read(envs.areas.ask(resets([NOTHING] * AREAS)))[0], seen)


# Agents


@pytest.mark.parametrize("kind", ["csharp"])
def test_pettingzoos_tests_pass_without_a_warning(played, pursuit):
    ours = pursuit(render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(played, num_cycles=200)
        api_test(parallel_to_aec(ours), num_cycles=200)
    # PettingZoo 1.24 decides by itself how many.
    cycles = {"num_cycles": 100} if "num_cycles" in inspect.signature(parallel_seed_test).parameters else {}
    parallel_seed_test(pursuit, **cycles)


@pytest.mark.parametrize(("kind", "seeds"), [("csharp", [9, 2]), ("unity", [9]), ("python", [9])])
def test_a_game_is_the_same_everywhere(kind, seeds, played, pursuit):
    """To the last bit: what is seen, rewards, ends and infos; agents end early and late, and infos go both ways. In the
    first game both rabbits are caught, and the environment hears of it.
    """
    envs = [pursuit(), played]
    early, survivors, told = set(), [], []
    for seed in seeds:
        states = [env.reset(seed=seed) for env in envs]
        for env in envs:
            assert env.send_info({"weather": "rain", "at": 1.5, "on": True, "n": 3}) == {}
            assert env.send_info({"you": "run"}, "rabbit_0") == {}
        while envs[0].agents:
            assert data_equivalence(*states)
            before = list(envs[0].agents)
            actions = {agent: policy(agent, states[0][0][agent]) for agent in before}
            states = [env.step(actions) for env in envs]
            assert envs[0].agents == envs[1].agents
            ended = set(before) - set(envs[0].agents)
            early |= ended if envs[0].agents else set()
            told += states[1][4][before[0]].get("told", {}).get("env", [])
        assert data_equivalence(*states)
        survivors.append(len(before))
    assert {info["caught"] for info in told[:2]} == {"rabbit_0", "rabbit_1"}
    assert {info["by"][:6] for info in told} == {"hunter"}
    if kind == "csharp":
        assert {name[:6] for name in early} == {"hunter", "rabbit"} and survivors == [5, 3]


@each_client
def test_a_picture_shows_who_is_in_the_game(played):
    seen, _ = played.reset(seed=4)
    picture = played.render()
    assert (picture.shape, picture.dtype) == ((200, 200, 3), np.uint8)
    for name, colour in (("rabbit_0", (240, 240, 240)), ("hunter_0", (180, 40, 40))):
        x, y, _ = seen[name][:3]
        assert tuple(picture[199 - int((1 + y) * 99.5), int((1 + x) * 99.5)]) == colour
    assert played.metadata["render_fps"] == 10


@each_client
def test_an_agent_nobody_knows_and_an_action_outside_its_space(played):
    played.reset(seed=1)
    fine = dict.fromkeys(played.agents, 0)
    for wrong in ({**fine, "ghost": 0}, {"hunter_0": 0}):
        with pytest.raises(ValueError, match=r"actions \{'hunter_0'.*, but those that live are \['hunter_0', "):
            played.step(wrong)
    with pytest.raises(ValueError, match=r"action 5 of rabbit_1 is not in Discrete\(5\)"):
        played.step({**fine, "rabbit_1": 5})
    with pytest.raises(ValueError, match="agent 'ghost' is none of"):
        played.send_info({}, "ghost")
    mixed = steps(0, 0, 0, 0, 0)
    mixed.flags = bytes([RESET, STEP, STEP, STEP, STEP])
    partly = steps(0, 0, 0, 0, 0)
    partly.flags = bytes([STEP, STEP, NOTHING, STEP, STEP])
    for request, text in (
        (steps(0, 0, 0, 0, 5), r"not-in-space: .* is not in Discrete\(5\)"),
        (steps(0, 0, 0, 0), "wrong-agents: 4 rows, but there are 5 agents"),
        (mixed, "wrong-agents"),
        (partly, "wrong-agents"),
        (resets([RESET] * 5, trees.write("rain")), "bad-options: options are a dict"),
        (info(["ghost", {}]), "unknown-agent: .*ghost"),
        (info({"a": [1]}), "bad-info"),
        (info(["hunter_0"]), "bad-info"),
        (info([1, {}]), "bad-info"),
        (info(["hunter_0", []]), "bad-info"),
        (Message("info"), "bad-info"),
        (Message("jump"), "unknown-kind: kind .?jump.? is none of reset, step, info, render, close"),
    ):
        with pytest.raises(MessageError, match=text):
            played.remote.ask(request)
    assert set(played.step(fine)[0]) == set(fine), "it goes on"


class Post(AgentSimulation):
    """Ann writes letters, and sees what she wrote and Bob's stamps. In C# it is tests/lessons/checks/Post.cs."""

    name, dt = "Post", 0.5
    says = spaces.Text(20, min_length=0)
    stamped = spaces.Dict(OrderedDict(says=says, stamps=spaces.Sequence(spaces.Box(0, 9, (2,)))))
    letter = spaces.Dict(OrderedDict(says=spaces.Text(5, min_length=0), times=spaces.Discrete(4)))
    agents: ClassVar = {"ann": (stamped, letter), "bob": (says, spaces.Sequence(spaces.Discrete(5)))}

    def reset(self, rng, options):
        self.written, self.stamps, self.steps = options.get("says", ""), [], 0

    def apply(self, actions):
        self.steps += 1
        self.stamps = list(map(int, actions["bob"]))
        if "ann" in actions:
            self.written = actions["ann"]["says"] * int(actions["ann"]["times"])
            self.infos.send("bob", {"stamps": self.stamps, "letter": actions["ann"]})

    def observe(self, agent):
        stamps = tuple(np.array([stamp, stamp / 2], np.float32) for stamp in self.stamps)
        return self.written if agent == "bob" else {"says": self.written, "stamps": stamps}

    def reward_and_end(self, agent):
        ends = {"terminated": agent == "ann" and self.steps == 4, "truncated": agent == "bob" and self.steps == 6}
        return {"reward": len(self.stamps), "read": [self.written, len(self.stamps)], **ends}

    def on_info(self, agent, info):
        self.infos.send(agent, info)


@pytest.fixture
def post(inside, make):
    return make(ZmqParallelEnv, "Post", socket=inside(AgentSimulator(Post())).socket)


def test_a_game_of_texts_dicts_and_sequences(post):
    """What is seen is what was done, also where one of two is over."""
    assert post.reset(options={"says": "dear"})[0] == {"ann": {"says": "dear", "stamps": ()}, "bob": "dear"}
    letters = [("ah", 3, (4, 1)), ("", 2, ()), ("x", 0, (0,)), ("oh", 1, (2, 2))]
    for step, (says, times, stamps) in enumerate(letters, 1):
        actions = {"ann": {"says": says, "times": times}, "bob": stamps}
        seen, rewards, terminated, _, infos = post.step(actions)
        assert seen["bob"] == seen["ann"]["says"] == says * times
        np.testing.assert_equal(seen["ann"]["stamps"], tuple(np.array([one, one / 2], np.float32) for one in stamps))
        assert rewards == dict.fromkeys(("ann", "bob"), len(stamps)) and terminated["ann"] == (step == 4)
        told = {"bob": [{"stamps": list(stamps), "letter": actions["ann"]}]}
        assert infos["ann"] == {"read": [says * times, len(stamps)], "told": told}
    for _ in range(2):
        seen, *_ = post.step({"bob": (3,)})
        assert seen == {"bob": "oh"}
    assert post.agents == []
    assert post.step({}) == ({}, {}, {}, {}, {}), "wrappers step once more"
    nested = {"a": [1, {"b": "c"}], "d": [], "e": {"f": None}}
    assert post.send_info(nested, "bob") == {"bob": [nested]}


def test_a_game_of_texts_dicts_and_sequences_is_the_same_in_both_languages(post, make, checks):
    envs = [post, make(ZmqParallelEnv, "Post", launch=["dotnet", checks, "game"])]
    for name in envs[0].possible_agents:
        assert envs[0].observation_space(name) == envs[1].observation_space(name)
        assert envs[0].action_space(name) == envs[1].action_space(name)
        envs[0].action_space(name).seed(3)
    for episode in range(3):
        assert data_equivalence(*(env.reset(seed=episode, options={"says": "dear"}) for env in envs))
        while envs[0].agents:
            actions = {name: envs[0].action_space(name).sample() for name in envs[0].agents}
            assert data_equivalence(*(env.step(actions) for env in envs))
            assert envs[0].agents == envs[1].agents
    letter = Bytes(Post.letter).write({"says": "", "times": 1})
    for env in envs:
        env.reset(seed=1)
        for wrong in (b"\1", (1).to_bytes(4, "little") + b"\xff" * 8, (2**30).to_bytes(4, "little")):
            with pytest.raises(MessageError, match="not-in-space"):
                env.remote.ask(Record(ASKS, 0, bytes(16), [STEP] * 2, [letter, wrong]))
        with pytest.raises(MessageError, match=r"not-in-space: \['says'\]: 'é' is not in Text"):
            env.reset(options={"says": "é"})


# Infos


def test_before_the_first_reset_nobody_lives():
    wrong = steps(0, 0, 0, 0, 0)
    wrong.id = 1
    error = Message.read(AgentSimulator(Pursuit()).answer(wrong)).values
    assert error["code"] == "wrong-agents" and error["text"].endswith("but those that live are []")


def test_the_queue_of_infos_is_bounded_and_says_so():
    queue = InfoQueue()
    for number in range(1000):
        queue.send("hunter_0", {"number": number, "text": 'é"' * 20})
    kept = trees.read(queue.take())
    assert kept[-1] == ["", {"dropped": 1000 - len(kept) + 1}]
    assert [said["number"] for _, said in kept[:-1]] == list(range(len(kept) - 1)), "the first ones, in their order"
    assert queue.take() == b""
    with pytest.raises(MessageError, match="set has no place in a message"):
        queue.send("", {"many": {1}})


# Real time


def rest(env, seen):
    """A step in which all rest; and how many ticks passed: resting costs a hunter 0.01 of its energy."""
    before = seen["hunter_0"][2]
    seen, rewards, *_ = env.step(dict.fromkeys(env.agents, 0))
    ticks = round(float(before - seen["hunter_0"][2]) / 0.01)
    assert rewards["hunter_1"] == pytest.approx(-0.01 * ticks), "rewards are summed"
    return seen, ticks


@each_client
def test_the_world_goes_on_while_python_thinks_if_it_is_to(kind, launch, pursuit, make):
    """A thinker's second is ten ticks at least; how many more it becomes on a busy machine nobody knows."""
    inside = kind == "python"
    env = pursuit(real_time=True) if inside else make(ZmqParallelEnv, launch=launch(kind, key=KEY), real_time=True)
    # In this one no rabbit is near a hunter.
    seen, _ = env.reset(seed=10)
    begin = time.monotonic()
    for _ in range(3):
        seen, ticks = rest(env, seen)
        assert ticks >= 1
    assert time.monotonic() - begin >= 0.2, "a step waits for its tick"
    time.sleep(1.05)
    seen, ticks = rest(env, seen)
    assert ticks >= 10


@each_client
def test_else_it_stands_still(played):
    seen, _ = played.reset(seed=10)
    for pause in (0, 0.3):
        time.sleep(pause)
        seen, ticks = rest(played, seen)
        assert ticks == 1


def test_what_the_clock_has_seen_is_made_up_for():
    """With the actions from before, and those of a step only in the tick that is due."""

    class Counted(Pursuit):
        def apply(self, actions):
            ticks.append(actions)
            super().apply(actions)

    ticks, now, inner = [], [0.0], Counted()
    shell = RealTime(inner, lambda: now[0])
    shell.reset(iter([0.5] * 10), {"real_time": True})
    left, right = dict.fromkeys(shell.agents, 1), dict.fromkeys(shell.agents, 2)
    inner.place = {name: (0.0, -1.0 if name.startswith("hunter") else 1.0) for name in inner.place}
    now[0] = 0.105
    shell.apply(left)
    assert ticks == [left]
    assert (inner.place["hunter_0"][0], shell.reward_and_end("hunter_0")["reward"]) == pytest.approx((-0.05, -0.01))
    now[0] = 0.505
    shell.apply(right)
    assert ticks == [left, left, left, left, right]
    assert inner.place["hunter_0"][0] == pytest.approx(-0.05 * 4 + 0.05)
    assert shell.reward_and_end("hunter_0")["reward"] == pytest.approx(-0.04)
    now[0] = 1000
    shell.catch_up(now[0])
    assert shell.reward_and_end("hunter_0")["terminated"] and inner.energy["hunter_0"] == 0, "and not after the end"


def test_on_the_clock_whoever_is_over_is_judged_no_more():
    """By one of the two ways; what is outcomes once stands until it is asked for."""

    class Ends(Pursuit):
        def reward_and_end(self, agent):
            outcomes.append(agent)
            ends = "terminated" if agent == "hunter_0" else "truncated" if agent == "hunter_1" else ""
            return {"reward": 1.0, "terminated": ends == "terminated", "truncated": ends == "truncated"}

    outcomes, now = [], [0.0]
    shell = RealTime(Ends(), lambda: now[0])
    shell.reset(iter([0.5] * 10), {"real_time": True})
    shell.apply(dict.fromkeys(shell.agents, 0))
    now[0] = 0.305
    shell.catch_up(now[0])
    assert (outcomes.count("hunter_0"), outcomes.count("hunter_1")) == (1, 1)
    others = [agent for agent in shell.agents if outcomes.count(agent) != 1]
    assert others and all(outcomes.count(agent) == 3 for agent in others), outcomes


# The game by its path


@pytest.mark.skipif(sys.platform == "win32", reason="Windows knows a program by its ending alone")
@pytest.mark.parametrize(
    ("system", "file"),
    [
        ("linux", "Pursuit.x86_64"),
        ("linux", "Pursuit"),
        ("darwin", "Pursuit.app/Contents/MacOS/My Game"),
        ("win32", "Pursuit.exe"),
    ],
)
def test_a_game_is_found_by_its_path(system, file, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "platform", system)
    folder = tmp_path / "Build [1]"
    program = folder / file
    with pytest.raises(FileNotFoundError, match=r"no game at .*Pursuit: there is neither this file nor .*Pursuit\."):
        game(str(folder / "Pursuit"))
    program.parent.mkdir(parents=True)
    program.write_text("#!/bin/sh\n", encoding="ascii")
    assert game(str(folder / "Pursuit")) == str(program)
    assert program.stat().st_mode & 0o111, "it was made executable"
