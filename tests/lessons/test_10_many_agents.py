"""Lesson 10: areas as Gymnasium's vectors, agents as PettingZoo's, each with each simulator. What can go wrong is in
test_10_many_agents_faults.py.
"""

from __future__ import annotations

import importlib
import sys
import time
import warnings

import pytest

from tests.conftest import CLIENTS
from tests.programs import ROOT

gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: pip install gymnasium")
np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: pip install numpy")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: pip install pettingzoo")
from gymnasium.utils.env_checker import data_equivalence  # noqa: E402
from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402
from gymnasium.wrappers.vector import RecordEpisodeStatistics  # noqa: E402
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test  # noqa: E402
from pettingzoo.utils.conversions import parallel_to_aec  # noqa: E402

KEY, AREAS = "10_many_agents", 4
sys.path.append(str(ROOT / "python" / KEY))
from netmq_example.envs import ZmqParallelEnv  # noqa: E402
from netmq_example.envs.launch import game  # noqa: E402
from netmq_example.infos import InfoQueue, pack, unpack  # noqa: E402

policy = importlib.import_module("players").policy
each_client = pytest.mark.parametrize("kind", CLIENTS)
# Unity's scene of this lesson has agents; areas are for terminals.
each_terminal = pytest.mark.parametrize("kind", ["python", "csharp"])
MODES = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED]


@pytest.fixture
def vectors(launch):
    """Areas of one simulator, and what was made is closed at the end of the test."""
    made = []

    def make_areas(kind="python", world="CartPole", count=AREAS, words=(), **where):
        words = launch(kind, "--world", world, "--areas", str(count), *words, key=KEY)
        made.append(gymnasium.make_vec(f"NetMQExample/{world}-v0", count, launch=words, **where))
        return made[-1]

    yield make_areas
    for envs in made:
        envs.close()


@pytest.fixture
def pursuit(launch):
    """The game, and what was made is closed at the end of the test."""
    made = []

    def make_game(kind="python", words=(), **where):
        made.append(ZmqParallelEnv(launch=launch(kind, *words, key=KEY), **where))
        return made[-1]

    yield make_game
    for env in made:
        env.close()


# Areas


def same(ours, theirs):
    assert data_equivalence(ours[0], theirs[0]), "observations"
    for mine, other in zip(ours[1:-1], theirs[1:-1], strict=True):
        assert np.array_equal(mine, other) and mine.dtype == other.dtype
    assert data_equivalence(ours[-1], theirs[-1]), f"{ours[-1]} {theirs[-1]}"


@pytest.mark.parametrize("mode", MODES)
def test_areas_are_what_gymnasiums_own_vector_makes_of_as_many_environments(mode, vectors, launch):
    """The same numbers and the same infos, also through many ends; the pole falls at once, or time is up."""
    ours = vectors(autoreset_mode=mode, max_episode_steps=12)

    def single():
        return gymnasium.make("NetMQExample/CartPole-v0", launch=launch("python"), max_episode_steps=12)

    theirs = SyncVectorEnv([single] * AREAS, autoreset_mode=mode)
    try:
        assert ours.metadata["autoreset_mode"] == mode == theirs.metadata["autoreset_mode"]
        assert (ours.observation_space, ours.action_space) == (theirs.observation_space, theirs.action_space)
        same(ours.reset(seed=7), theirs.reset(seed=7))
        actions, ends = np.random.default_rng(1), [0, 0]
        for _ in range(80):
            action = np.where(np.arange(AREAS) < 2, 1, actions.integers(2, size=AREAS))
            mine = ours.step(action)
            same(mine, theirs.step(action))
            ends = [ends[0] + mine[2].sum(), ends[1] + mine[3].sum()]
            if mode == AutoresetMode.DISABLED and (over := mine[2] | mine[3]).any():
                same(*(envs.reset(options={"reset_mask": over.copy()}) for envs in (ours, theirs)))
        assert min(ends) > 3, "episodes ended both ways"
        # Once more from a seed for each, and from a state.
        seeds = list(range(10, 10 + AREAS))
        same(ours.reset(seed=seeds), theirs.reset(seed=seeds))
        state = {"state": [0.1, 0, 0, 0]}
        same(ours.reset(options=state), theirs.reset(options=state))
    finally:
        theirs.close()


def test_infos_of_a_simulation_come_from_each_area(vectors, launch):
    """The car says how many metres it has come; a road is left sooner or later."""
    from netmq_example.messages import Message, read
    from netmq_example.simulation.areas import AreaSimulator
    from netmq_example.spaces import to_array
    from netmq_example.worlds.road_car import RoadCar

    simulator = AreaSimulator([RoadCar(), RoadCar()])
    lots = [to_array([1, 1], np.uint8), to_array([1, 2], np.int64)]
    first = read(simulator.answer(Message("reset", 1, {}, lots)))
    assert (first.arrays[0].shape, unpack(first.values["infos"], int)) == ((2, 5), [])
    lots[0] = to_array([0, 1], np.uint8)
    actions = to_array([[0, 1], [0, 1]], np.float32)
    second = read(simulator.answer(Message("step", 2, {}, [actions, *lots])))
    assert [(area, list(info)) for area, info in unpack(second.values["infos"], int)] == [(0, ["metres"])], (
        "one was reset"
    )


@each_terminal
def test_both_languages_step_areas_alike(kind, vectors):
    """Not to the last bit: a pole needs sines."""
    ours, other = vectors(kind), vectors("python")
    assert ours.reset(seed=3)[0] == pytest.approx(other.reset(seed=3)[0], abs=0)
    for step in range(30):
        (mine, *said, _), (seen, *others_said, _) = (envs.step(np.arange(AREAS) % 2) for envs in (ours, other))
        assert mine == pytest.approx(seen, abs=1e-6), step
        assert np.array_equal(said, others_said)


@pytest.mark.parametrize("mode", MODES[:2])
def test_gymnasiums_vector_wrappers_work(mode, vectors):
    envs = RecordEpisodeStatistics(vectors("csharp", autoreset_mode=mode, max_episode_steps=5))
    envs.reset(seed=1)
    lengths = []
    for _ in range(20):
        *_, infos = envs.step(np.arange(AREAS) % 2)
        if "episode" in infos:
            lengths += list(infos["episode"]["l"][infos["_episode"]])
    assert set(lengths) == {5} and len(lengths) >= 3 * AREAS


def test_each_area_has_its_picture(vectors):
    envs = vectors("csharp", count=2, render_mode="rgb_array")
    envs.reset(seed=[1, 2])
    pictures = envs.render()
    assert [picture.shape for picture in pictures] == [(200, 300, 3)] * 2
    assert not np.array_equal(*pictures)


def test_agent_steps_a_second(vectors):
    envs = vectors("csharp", count=16)
    seen, _ = envs.reset(seed=1)
    begin, steps = time.perf_counter(), 2000
    for _ in range(steps):
        seen, *_ = envs.step((seen[:, 2] + seen[:, 3] > 0).astype(np.int64))
    print(f"\n{16 * steps / (time.perf_counter() - begin):,.0f} agent steps a second in 16 areas")


# Agents


@each_client
@pytest.mark.parametrize(
    "test", [parallel_api_test, lambda env: api_test(parallel_to_aec(env))], ids=["parallel", "aec"]
)
def test_pettingzoos_tests_pass_without_a_warning(kind, test, pursuit):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        test(pursuit(kind, render_mode="rgb_array"))


@each_terminal
def test_pettingzoos_seed_test_passes(kind, pursuit):
    parallel_seed_test(lambda: pursuit(kind))


@pytest.mark.parametrize("kind", ["csharp", "unity"])
def test_a_game_is_the_same_in_both_languages(kind, pursuit):
    """To the last bit: what is seen, rewards, ends and infos; agents end early and late."""
    envs = [pursuit(), pursuit(kind)]
    early, survivors = set(), []
    for number in range(12):
        states = [env.reset(seed=number) for env in envs]
        while envs[0].agents:
            assert data_equivalence(*states)
            before = list(envs[0].agents)
            actions = {agent: policy(agent, states[0][0][agent]) for agent in before}
            states = [env.step(actions) for env in envs]
            assert envs[0].agents == envs[1].agents
            ended = set(before) - set(envs[0].agents)
            early |= ended if envs[0].agents else set()
        assert data_equivalence(*states)
        survivors.append(len(before))
    assert {name[:6] for name in early} == {"hunter", "rabbit"}
    assert len(set(survivors)) > 1


@each_client
def test_a_picture_shows_who_is_in_the_game(kind, pursuit):
    env = pursuit(kind, render_mode="rgb_array")
    seen, _ = env.reset(seed=4)
    picture = env.render()
    assert (picture.shape, picture.dtype) == ((200, 200, 3), np.uint8)
    x, y, _ = seen["rabbit_0"][:3]
    assert tuple(picture[199 - int((1 + y) * 99.5), int((1 + x) * 99.5)]) in ((240, 240, 240), (180, 40, 40))
    assert env.metadata["render_fps"] == 10


# Infos


@each_client
def test_infos_go_both_ways(kind, pursuit):
    """A rabbit is caught in the seventh game of both hand-written players; then the environment hears of it."""
    env = pursuit(kind)
    seen, _ = env.reset(seed=7)
    assert env.unwrapped.send_info({"weather": "rain", "at": 1.5, "on": True, "n": 3}) == {}
    assert env.send_info({"you": "run"}, "rabbit_0") == {}
    told = []
    while env.agents:
        seen, _, _, _, infos = env.step({agent: policy(agent, seen[agent]) for agent in env.agents})
        told += next(iter(infos.values())).get("told", {}).get("env", [])
    assert {info["caught"] for info in told} == {"rabbit_0", "rabbit_1"}
    assert {info["by"][:6] for info in told} == {"hunter"}


def test_a_game_hears_and_says_at_any_time():
    from netmq_example.messages import Message, read
    from netmq_example.simulation.agents import AgentSimulator
    from netmq_example.worlds.pursuit import Pursuit

    class Talkative(Pursuit):
        def on_info(self, agent, info):
            self.infos.send(agent, {"heard": str(info)})

    simulator = AgentSimulator(Talkative())
    said = Message("info", 1, {"infos": pack([("rabbit_1", {"a": 1}), ("", {})])})
    answer = read(simulator.answer(said)).values["told"]
    assert unpack(answer) == [("rabbit_1", {"heard": "{'a': 1}"}), ("", {"heard": "{}"})]
    assert read(simulator.answer(said)).values["told"] == answer, "asked again it is not said twice"
    assert unpack(read(simulator.answer(Message("info", 2, {"infos": "[]"}))).values["told"]) == []


def test_the_queue_of_infos_is_bounded_and_says_so():
    queue = InfoQueue()
    for number in range(1000):
        queue.send("hunter_0", {"number": number, "text": 'é"' * 20})
    kept = unpack(queue.take())
    assert kept[-1] == ("", {"dropped": 1000 - len(kept) + 1})
    assert [info["number"] for _, info in kept[:-1]] == list(range(len(kept) - 1)), "the first ones, in their order"
    assert queue.take() == "[]"
    with pytest.raises(ValueError, match="info 'list' of '' must be text, a number, true or false"):
        queue.send("", {"list": [1]})


# Real time


def rest(env, seen):
    """A step in which all rest; and how many ticks passed: resting costs a hunter 0.01 of its energy."""
    before = seen["hunter_0"][2]
    seen, rewards, *_ = env.step(dict.fromkeys(env.agents, 0))
    ticks = round(float(before - seen["hunter_0"][2]) / 0.01)
    assert rewards["hunter_1"] == pytest.approx(-0.01 * ticks), "rewards are summed"
    return seen, ticks


@each_client
def test_the_world_goes_on_while_python_thinks_if_it_is_to(kind, pursuit):
    """A thinker's second is ten ticks at least; how many more it becomes on a busy machine nobody knows."""
    env = pursuit(kind, real_time=True)
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
def test_else_it_stands_still(kind, pursuit):
    env = pursuit(kind)
    seen, _ = env.reset(seed=10)
    for pause in (0.3, 0, 0.3):
        time.sleep(pause)
        seen, ticks = rest(env, seen)
        assert ticks == 1


def test_what_the_clock_has_seen_is_made_up_for():
    """With the actions from before, and those of a step only in the tick that is due."""
    from netmq_example.simulation.simulation import RealTime
    from netmq_example.worlds.pursuit import Pursuit

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
    assert (inner.place["hunter_0"][0], shell.judge("hunter_0")["reward"]) == pytest.approx((-0.05, -0.01))
    now[0] = 0.505
    shell.apply(right)
    assert ticks == [left, left, left, left, right]
    assert inner.place["hunter_0"][0] == pytest.approx(-0.05 * 4 + 0.05)
    assert shell.judge("hunter_0")["reward"] == pytest.approx(-0.04)
    now[0] = 1000
    shell.catch_up(now[0])
    assert shell.judge("hunter_0")["terminated"] and inner.energy["hunter_0"] == 0, "and not after the end"


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


@pytest.mark.skipif(sys.platform == "win32", reason="there a script is no program")
def test_a_game_is_started_by_its_path(launch, tmp_path):
    words = " ".join(f"'{word}'" for word in launch("python", key=KEY))
    (tmp_path / "Pursuit.x86_64").write_text(f'#!/bin/sh\nexec {words} "$@"\n', encoding="utf-8")
    env = ZmqParallelEnv(launch=str(tmp_path / "Pursuit"))
    try:
        assert list(env.reset(seed=1)[0]) == env.possible_agents
    finally:
        env.close()
