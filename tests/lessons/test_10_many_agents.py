"""Lesson 10: many agents as Gymnasium's vectors and as PettingZoo's environments, with each simulator, the same to the
last bit; in which order a scene is asked; and faults.
"""

import contextlib
import inspect
import re
import sys
import time
import warnings
from typing import Any

import pytest

from tests.lessons.conftest import simulated
from tests.programs import ROOT, steady_endpoint

gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: kit.py run 10 installs it")
np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: kit.py run 10 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
from gymnasium.spaces import Box  # noqa: E402
from gymnasium.utils.env_checker import data_equivalence  # noqa: E402
from gymnasium.vector import SyncVectorEnv  # noqa: E402
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test  # noqa: E402

KEY, AREAS = "10_many_agents", 4
sys.path.append(str(ROOT / "python" / KEY))
from players import drive, policy  # noqa: E402

from netmq_example import envs as doors  # noqa: E402
from netmq_example import scene  # noqa: E402
from netmq_example.envs import UnityAECEnv, UnityGymEnv, UnityParallelEnv, UnityVectorEnv  # noqa: E402
from netmq_example.envs.remote import LONGEST_INFO  # noqa: E402
from netmq_example.errors import Lost  # noqa: E402
from netmq_example.messages import EXACT, Message, MessageError  # noqa: E402
from netmq_example.scene import Scene, SceneSimulator  # noqa: E402
from netmq_example.wire import trees  # noqa: E402
from netmq_example.wire.records import (  # noqa: E402
    ANSWERS,
    ASKS,
    ENDED,
    LAST,
    NOTHING,
    RESET,
    SEEN,
    STEP,
    WHO,
    Record,
    Section,
    read_frames,
)
from netmq_example.wire.sections import rewards, with_infos, with_sizes  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402
from netmq_example.worlds.pursuit import Pursuit  # noqa: E402
from tests.lessons.office import VALUES, office  # noqa: E402
from tests.lessons.vectors import play  # noqa: E402

MODES = ["NextStep", "SameStep", "Disabled"]


@pytest.fixture
def pursuit(inside, make):
    """The game in this process."""
    return lambda kind=UnityParallelEnv, **more: make(
        kind, "Pursuit", socket=inside(SceneSimulator(Pursuit())).socket, **more
    )


@pytest.fixture
def csharp_areas(kept, launch):
    if "areas" not in kept:
        words = launch("csharp", "--world", "CartPole", "--areas", str(AREAS), key=KEY)
        kept["areas"] = gymnasium.make_vec("NetMQExample/CartPole-v0", AREAS, launch=words)
    return kept["areas"]


@pytest.fixture
def played(kind, kept, launch):
    if kind not in kept:
        kept[kind] = UnityParallelEnv("Pursuit", launch=launch(kind, key=KEY), render_mode="rgb_array")
    return kept[kind]


@pytest.fixture(params=["python", "csharp"])
def at_work(request, inside, make):
    """at_work(UnityParallelEnv, "ann ann bob:2", ann=3): an environment of tests/lessons/office.py, in each language;
    its `asked` are the requests of a simulator in this process.
    """

    def made(kind, names, *words, most=(), **more):
        if request.param == "python":
            simulator = inside(SceneSimulator(office(names, **dict(most))))
            env = make(kind, *words, env_name="Office", socket=simulator.socket, **more)
            env.asked = simulator.asked
            return env
        command = ["dotnet", request.getfixturevalue("checks"), "office", names]
        command.append(" ".join(f"{name} {count}" for name, count in dict(most).items()))
        return make(kind, *words, env_name="Office", launch=command, **more)

    return made


def steps(*numbers, kind=0):
    """A section in which so many step, each with the number of a discrete action."""
    count = len(numbers)
    return Section(kind, bytes(8 * count), bytes([STEP] * count), values=np.array(numbers, "<i8").tobytes())


def info(value):
    return Message("info", 0, {}, [trees.array_of(trees.write(value))])


# The same everywhere


@pytest.mark.parametrize("mode", MODES)
def test_one_environment_is_the_same_to_the_last_bit_wherever_it_is(mode, launch, inside, make):
    """In this process and launched, in Python and in C#, and as Gymnasium has so many single ones. Cars leave the road,
    and others' time is up.
    """
    words = "--world", "Car", "--areas", str(AREAS)
    wheres = ({"socket": inside(simulated("Car", AREAS)).socket}, {"launch": launch("csharp", *words, key=KEY)})
    more = {"max_episode_steps": 110}
    ours = [
        make(gymnasium.make_vec, "NetMQExample/Car-v0", AREAS, autoreset_mode=mode, **more, **where) for where in wheres
    ]

    def single():
        return gymnasium.make("NetMQExample/Car-v0", socket=inside(simulated("Car")).socket, **more)

    def act(seen, step):
        action = np.array([[1, 1], [-1, 1], *drive(seen)[2:]], np.float32)
        action[2, 0] *= np.float32(0.1 * (step % 10))
        return action

    envs = [*ours, make(SyncVectorEnv, [single] * AREAS, autoreset_mode=mode)]
    ends = play(envs, act, 230, {"seed": 5}, {"seed": [7, 8, 9, 10]}, {"seed": 5, "options": {"state": [30.0]}})
    assert (ends.sum(1) > 3).all(), "both ways"


def test_agent_number_i_has_the_seed_and_i_in_every_class(at_work):
    """Numbers go on from one kind to the next; the scene itself begins as agent 0."""
    names = ["ann_0", "ann_1", "bob"]
    alone = at_work(UnityGymEnv, "ann")
    drawn = [alone.reset(seed=5 + number)[0]["drawn"][0] for number in range(3)]
    assert alone.reset(seed=5)[0]["drawn"].tolist() == [drawn[0]] * 2
    scene = "ann ann bob"
    seen, _ = at_work(UnityParallelEnv, scene).reset(seed=5)
    assert [seen[name]["drawn"].tolist() for name in names] == [[one, drawn[0]] for one in drawn]
    assert at_work(UnityGymEnv, scene, agent_name="ann_1").reset(seed=5)[0]["drawn"][0] == drawn[1]
    for kind, numbers in ("ann", [0, 1]), ("bob", [2]):
        envs = at_work(UnityVectorEnv, scene, num_envs=len(numbers), agent_name=kind)
        assert envs.reset(seed=5)[0]["drawn"][:, 0].tolist() == [drawn[number] for number in numbers]


# In which order


def done(env, answer):
    """The calls in the scene, in order."""
    infos = answer[-1]
    said = next(iter(infos.values()))["env"] if isinstance(env, UnityParallelEnv) else infos["env"][0]
    return [*said]


def of(names, what):
    return [f"{name} {what}" for name in names.split()]


def test_the_order_of_a_step(at_work):
    env = at_work(UnityParallelEnv, "ann ann bob:2")
    first = ["office begins", *of("ann_0 ann_1 bob", "begins"), *of("ann_0 ann_1 bob", "sees")]
    assert done(env, env.reset(seed=1)) == first
    answer = env.step({"ann_0": "earn 2", "ann_1": "end soon", "bob": "end late"})
    # Those that have ended are seen a last time, before the others are.
    assert done(env, answer) == [
        *("ann_0 does earn 2", "ann_1 does end soon", "bob does end late"),
        *(*of("ann_0 ann_1 bob", "ticks"), "office ticks", "bob ticks", "office ticks"),
        *(*of("ann_0 ann_1 bob", "stepped"), "office stepped"),
        *of("ann_1 bob ann_0", "sees"),
    ]
    assert answer[1] == {"ann_0": 2.25, "ann_1": 0.25, "bob": 0.25}
    assert answer[2] == {"ann_0": False, "ann_1": True, "bob": True}
    # An agent that is over has no ticks, and is asked for nothing; nothing after an end belongs to a step.
    assert env.agents == ["ann_0"]
    answer = env.step({"ann_0": "end"})
    assert done(env, answer) == ["ann_0 does end", "ann_0 stepped", "office stepped", "ann_0 sees"]
    assert env.agents == [] and env.step({}) == ({}, {}, {}, {}, {}), "wrappers step once more"


def test_a_new_episode_begins_in_the_same_exchange(at_work):
    """SAME_STEP: with its last observation and its first one. The scene itself begins when all do."""
    envs = at_work(UnityVectorEnv, "ann ann", num_envs=2, autoreset_mode="SameStep", max_episode_steps=3)
    envs.reset(seed=1)
    exchanges = [envs.step(actions) for actions in (("end", ""), ("", "end"), ("", ""), ("", ""))]
    ticks, stepped = of("ann_0 ann_1", "ticks"), [*of("ann_0 ann_1", "stepped"), "office stepped"]
    both = of("ann_0 ann_1", "sees")
    assert [done(envs, each)[2:] for each in exchanges] == [
        ["ann_1 ticks", "office ticks", *stepped, "ann_0 sees", "ann_0 begins", *both],
        ["ann_0 ticks", "office ticks", *stepped, "ann_1 sees", "ann_1 begins", *both],
        [*ticks, "office ticks", *stepped, *both],
        # The time of the first one is up, by Python's count.
        [*ticks, "office ticks", *stepped, "ann_0 sees", "ann_0 begins", *both],
    ]
    assert [each[2].tolist() for each in exchanges] == [[True, False], [False, True], [False] * 2, [False] * 2]
    assert [each[3].tolist() for each in exchanges] == [[False] * 2] * 3 + [[True, False]]
    ticks = [each[0]["ticks"][:, 0].tolist() for each in exchanges]
    assert ticks == [[0, 1], [1, 0], [2, 1], [0, 2]] and exchanges[3][4]["final_obs"][0]["ticks"].tolist() == [3]
    *_, infos = envs.step(("end", "end"))
    assert done(envs, [infos])[-5:] == ["office begins", *of("ann_0 ann_1", "begins"), *of("ann_0 ann_1", "sees")]
    if hasattr(envs, "asked"):
        orders = [list(one.sections[0].marks) for one in envs.asked if isinstance(one, Record)]
        assert orders == [[RESET] * 2, *[[STEP] * 2] * 3, [LAST, STEP], [STEP, LAST]], "each step is one exchange"


def test_those_whom_nobody_asks_for_stand_still(at_work, caplog, capfd):
    """And one line says so."""
    env = at_work(UnityParallelEnv, "ann bob cat", observation_spaces={"bob": office("bob").agents[0].observation})
    asked = done(env, env.reset(seed=1)) + done(env, env.step({"bob": ""})) + done(env, env.step({"bob": ""}))
    assert {one.split()[0] for one in asked} == {"office", "bob"}
    env.close()
    said = caplog.text + "".join(capfd.readouterr())
    assert said.count("ann, cat") == 1 and said.count("stand still") == 1


# Who is there


def test_agents_come_leave_and_come_back(at_work, capfd):
    env = at_work(UnityParallelEnv, "ann bob", most={"ann": 3})
    assert env.possible_agents == ["ann_0", "ann_1", "ann_2", "bob"]
    env.reset(seed=5)
    assert env.agents == ["ann_0", "bob"]
    alone = at_work(UnityGymEnv, "ann")
    seen, *_, infos = env.step({"ann_0": "hire ann", "bob": ""})
    assert env.agents == ["ann_0", "ann_1", "bob"]
    assert infos["bob"]["env"][-3:] == ["ann_0 sees", "ann_1 sees", "bob sees"]
    # With the next free number, and the last seed and that number.
    assert seen["ann_1"]["drawn"][0] == alone.reset(seed=6)[0]["drawn"][0] and seen["ann_1"]["ticks"] == [0]
    before = env.step({"ann_0": "", "ann_1": "earn 3", "bob": ""})[0]["ann_1"]
    seen, rewards, terminated, truncated, infos = env.step({"ann_0": "", "ann_1": "leave", "bob": ""})
    assert env.agents == ["ann_0", "bob"] and data_equivalence(seen["ann_1"], before)
    assert (rewards["ann_1"], terminated["ann_1"], truncated["ann_1"]) == (0, False, True)
    assert infos["ann_1"]["lost"] == "it has left the scene" and "lost" not in infos["bob"]
    # Another one gets the number that nobody has had; then the first one comes back to its own.
    env.step({"ann_0": "hire ann", "bob": "recall"})
    assert env.agents == ["ann_0", "ann_1", "ann_2", "bob"]
    # In a scene of Unity it goes on without the one who is too many.
    full = pytest.raises(MessageError, match=r"^no-space: .*At Most in GymManager")
    with full if hasattr(env, "asked") else contextlib.nullcontext():
        env.step({**dict.fromkeys(env.agents, ""), "bob": "hire ann"})
    if not hasattr(env, "asked"):
        env.step(dict.fromkeys(env.agents, ""))
        assert len(env.agents) == 4
        env.close()
        assert "there are 3 agents of the name 'ann' already: raise At Most" in capfd.readouterr().out


@pytest.mark.parametrize("mode", MODES)
def test_who_leaves_in_the_step_of_its_end_is_seen_in_it(mode, at_work):
    envs = at_work(UnityVectorEnv, "ann ann", num_envs=2, autoreset_mode=mode)
    envs.reset(seed=1)
    seen, _, terminated, truncated, infos = envs.step(("", "leave bye"))
    last = infos["final_obs"][1]["letters"] if mode == "SameStep" else seen["letters"][1]
    assert (last, terminated.tolist(), truncated.any()) == (("bye",), [False, True], False)
    if mode != "Disabled":
        # It has no episode that could end once more.
        assert not envs.step(("", ""))[2].any()


def test_an_end_after_the_step_belongs_to_the_next_one(at_work):
    """In another one's reset, or where an agent is seen."""
    envs = at_work(UnityVectorEnv, "ann ann", num_envs=2, autoreset_mode="SameStep")
    envs.reset(seed=1)
    for actions, ends in (
        (("doom 1", ""), [True, False]),
        (("", ""), [False, True]),
        (("", "end last"), [False, False]),
        (("", ""), [False, True]),
        (("", ""), [False, False]),
    ):
        assert envs.step(actions)[2].tolist() == ends


def test_who_leaves_when_its_time_is_up_is_seen_in_that_step(at_work):
    envs = at_work(UnityVectorEnv, "ann ann", num_envs=2, autoreset_mode="SameStep", max_episode_steps=1)
    envs.reset(seed=1)
    *_, truncated, infos = envs.step(("", "go late"))
    assert truncated.all() and [seen["ticks"].tolist() for seen in infos["final_obs"]] == [[1], [1]]


def test_who_comes_for_another_one_begins_when_python_knows_that_it_has_left(at_work):
    env = at_work(UnityParallelEnv, "ann bob")
    env.reset(seed=1)
    env.step({"ann": "", "bob": ""})
    _, rewards, terminated, truncated, infos = env.step({"ann": "swap ann", "bob": ""})
    assert (rewards["ann"], terminated["ann"], truncated["ann"]) == (1, False, True)
    assert infos["ann"]["lost"] == "it has left the scene" and env.agents == ["bob"]
    answer = env.step({"bob": ""})
    assert env.agents == ["ann", "bob"] and "ann begins" in done(env, answer) and answer[0]["ann"]["ticks"] == [0]
    envs = at_work(UnityVectorEnv, "ann ann", num_envs=2)
    envs.reset(seed=1)
    answers = [envs.step((first, "")) for first in ("swap ann", "", "", "")]
    assert [each[3].tolist() for each in answers] == [[True, False], *[[False] * 2] * 3]
    assert [each[0]["ticks"][0].tolist() for each in answers[1:]] == [[0], [1], [2]]


def test_who_comes_back_where_another_has_its_number_gets_a_free_one(at_work):
    env = at_work(UnityParallelEnv, "ann ann bob")
    env.reset(seed=1)
    for first, second, third in (("", "leave", ""), ("", "", "hire ann"), ("go late", "", ""), ("", "", "recall")):
        plans = {"ann_0": first, "ann_1": second, "bob": third}
        env.step({agent: plans[agent] for agent in env.agents})
    assert env.agents == ["ann_0", "ann_1", "bob"]


def test_in_a_vector_who_is_away_has_no_rewards_and_no_ends(at_work):
    envs = at_work(UnityVectorEnv, "ann ann", num_envs=2)
    envs.reset(seed=1)
    envs.step(("", "earn 3"))
    _, rewards, _, truncated, infos = envs.step(("", "leave"))
    assert (rewards.tolist(), truncated.tolist()) == ([0.25, 0], [False, True])
    assert infos["lost"].tolist() == [None, "it has left the scene"]
    for _ in range(2):
        # What is given to those who are away is told to nobody.
        seen, rewards, terminated, truncated, infos = envs.step(("haunt", ""))
        assert (rewards.tolist(), seen["ticks"][1].tolist()) == ([0.25, 0], [1])
        assert not terminated.any() and not truncated.any()
        assert infos["_lost"].tolist() == [False, True]
    seen, rewards, terminated, truncated, infos = envs.step(("recall", ""))
    assert rewards.tolist() == [0.25, 0] and not terminated.any()
    assert (truncated.any(), seen["ticks"].tolist(), "lost" in infos) == (False, [[5], [0]], False)
    assert envs.step(("", ""))[1].tolist() == [0.25, 0.25]


def test_one_object_may_have_several_agents(start, checks, make):
    """In Unity: each is a component, with a row of its own, and may be switched off alone."""
    endpoint = steady_endpoint()
    start("dotnet", checks, "scene", "Twins", endpoint)
    env = make(UnityParallelEnv, "Twins", endpoint=endpoint)
    assert env.reset()[0] == {"agent_0": [0], "agent_1": [0]}
    seen, rewards, *_ = env.step({"agent_0": 1, "agent_1": 2})
    assert (seen, rewards) == ({"agent_0": [1], "agent_1": [2]}, {"agent_0": 1, "agent_1": 2})
    _, _, _, truncated, infos = env.step({"agent_0": 1, "agent_1": 2})
    assert truncated == {"agent_0": False, "agent_1": True} and infos["agent_1"] == {"lost": "it has left the scene"}
    assert env.step({"agent_0": 1})[0] == {"agent_0": [3]}


def test_a_second_gym_manager_is_named_and_does_nothing(start, checks, make):
    """With a hello of its own it would take the agents' rows from the first one: Python would lose them."""
    endpoint = steady_endpoint()
    program = start("dotnet", checks, "scene", "Twins", endpoint, "twice")
    program.wait_for(r"^gave up: scene and scene\(Clone\) have a GymManager each: remove one$")
    env = make(UnityParallelEnv, "Twins", endpoint=endpoint)
    env.reset()
    assert env.step({"agent_0": 1, "agent_1": 2})[1] == {"agent_0": 1, "agent_1": 2}
    assert program.lines.count(f"asking {endpoint}") == 1


def test_what_agents_are_called(at_work):
    names = "ann ann_1 ann bob cat_3 dog_ eel_07 fox"
    env = at_work(UnityParallelEnv, names, most={"bob": 2, "fox": 1})
    assert env.possible_agents == ["ann_0", "ann_1", "ann_2", "bob_0", "bob_1", "cat_3", "dog_", "eel_07", "fox"]
    env.reset(seed=1)
    assert len(env.agents) == len(names.split())


# Infos


def test_each_info_is_what_was_sent(at_work):
    """Where two differ in type or in shape an array has them as objects, and none becomes another one."""
    envs = at_work(UnityVectorEnv, "ann ann", num_envs=2)
    envs.reset(seed=1)
    for words in (
        "nothing part",
        "false part",
        "none one",
        "one two",
        "text list",
        "dict part",
        "part part",
        "two two",
    ):
        first, second = words.split()
        *_, infos = envs.step((f"say {first}", f"say {second}"))
        for agent, word in enumerate((first, second)):
            told = infos["value0"][agent]
            assert data_equivalence(envs.infos[agent]["value0"], VALUES[word], exact=True), words
            assert np.array_equal(told, VALUES[word]) or told == VALUES[word], words
        assert infos["_value0"].all() and (infos["value0"].dtype == object) == (first != second)
    *_, infos = envs.step(("say one part", ""))
    assert infos["_value1"].tolist() == [True, False] and infos["value1"].tolist() == [0.75, 0]
    assert set(envs.infos[0]) == {"env", "value0", "value1"} and set(envs.infos[1]) == {"env"}


def test_infos_go_both_ways_and_too_many_are_counted(at_work):
    env = at_work(UnityParallelEnv, "ann bob")
    env.reset(seed=1)
    nested = {"a": [1, {"b": "c"}], "d": [], "e": {"f": None}, "on": True, "at": 1.5}
    env.send_info(nested)
    env.send_info(nested, "bob")
    env.send_info(7, "bob")
    *_, infos = env.step({"ann": "shout", "bob": ""})
    assert infos["bob"]["agent"] == [nested, 7] and infos["ann"]["env"][:3] == [nested, *of("bob bob", "hears")]
    *kept, dropped = infos["ann"]["agent"]
    assert dropped == {"dropped": 1000 - len(kept)} and 0 < len(kept) < 1000
    assert [one["number"] for one in kept] == [*range(len(kept))], "the first ones, in their order"
    *_, infos = env.step({"ann": "", "bob": ""})
    assert "agent" not in infos["ann"] and "agent" not in infos["bob"], "once"


# Areas


def test_areas_name_what_is_wrong_and_none_of_them_moves(csharp_areas, areas):
    """Golden bytes of lesson 09 have all that a simulator refuses."""
    for envs in csharp_areas, areas(AREAS):
        seen, _ = envs.reset(seed=1)
        # To Gymnasium 1.1, numbers with a fraction are in a MultiDiscrete: then it is one agent's that is refused.
        wrong = r"are not in MultiDiscrete\(\[2 2 2 2\]\)|^not-in-space: .*0\.5.* is not in Discrete\(2\)"
        for actions in np.array([0, 1]), np.full(AREAS, 0.5), np.array([0, 1, 2, 1]):
            with pytest.raises((ValueError, MessageError), match=wrong):
                envs.step(actions)
        with pytest.raises(MessageError, match=r"not-in-space: .* is not in Discrete\(2\)"):
            envs.simulators.ask(Record(ASKS, 0, [steps(1, 1, 1, 2)]))
        nobody = envs.simulators.ask(
            Record(ASKS, 0, [Section(0, bytes(8 * AREAS), bytes([NOTHING] * AREAS))])
        ).sections[0]
        assert (bytes(nobody.marks), len(nobody.values)) == (bytes(AREAS), 0)
        # Had anybody moved, this were another place.
        still = envs.step(np.ones(AREAS, np.int32))[0]
        envs.reset(seed=1)
        assert np.array_equal(envs.step(np.ones(AREAS, int))[0], still) and not np.array_equal(still, seen)


def test_an_action_that_rounding_took_out_of_its_space_is_in_it(launch, inside, make):
    """By few steps of its dtype; and no further."""
    words = launch("csharp", "--world", "Car", "--areas", "2", key=KEY)
    for where in {"socket": inside(simulated("Car", 2)).socket}, {"launch": words}:
        envs = make(gymnasium.make_vec, "NetMQExample/Car-v0", 2, **where)
        most = np.ones((2, 2), np.float32)
        envs.reset(seed=1)
        seen = envs.step(most)[0]
        envs.reset(seed=1)
        near = most.copy()
        near[1, 1] += 4 * np.spacing(np.float32(1))
        assert near not in envs.action_space and np.array_equal(envs.step(near)[0], seen)
        near[1, 1] += np.spacing(np.float32(1))
        for wrong in near, most * np.nan, most * 2:
            with pytest.raises(ValueError, match="are not in Box"):
                envs.step(wrong)


# Agents


@pytest.mark.parametrize("kind", ["csharp"])
def test_pettingzoos_tests_pass_without_a_warning(played, pursuit):
    aec = pursuit(UnityAECEnv, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(played, num_cycles=200)
        api_test(aec, num_cycles=200)
    # PettingZoo 1.24 decides by itself how many.
    cycles = {"num_cycles": 100} if "num_cycles" in inspect.signature(parallel_seed_test).parameters else {}
    parallel_seed_test(pursuit, **cycles)


@pytest.mark.parametrize(("kind", "seeds"), [("csharp", [9, 2]), ("unity", [9])])
def test_a_game_is_the_same_everywhere(kind, seeds, played, pursuit):
    """To the last bit: what is seen, rewards, ends and infos; agents end early and late. In the first game both rabbits
    are caught, and everybody hears of it.
    """
    envs = [pursuit(), played]
    early, survivors, told = set(), [], []
    for seed in seeds:
        states = [env.reset(seed=seed) for env in envs]
        while envs[0].agents:
            assert data_equivalence(*states, exact=True)
            before = list(envs[0].agents)
            actions = {agent: policy(agent, states[0][0][agent]) for agent in before}
            states = [env.step(actions) for env in envs]
            assert envs[0].agents == envs[1].agents
            ended = set(before) - set(envs[0].agents)
            early |= ended if envs[0].agents else set()
            told += states[1][4][before[0]].get("env", [])
        assert data_equivalence(*states, exact=True)
        survivors.append(len(before))
    assert {info["caught"] for info in told[:2]} == {"rabbit_0", "rabbit_1"}
    assert {info["by"][:6] for info in told} == {"hunter"}
    if kind == "csharp":
        assert {name[:6] for name in early} == {"hunter", "rabbit"} and survivors == [5, 3]


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_picture_shows_who_is_in_the_game(played):
    seen, _ = played.reset(seed=4)
    picture = played.render()
    assert (picture.shape, picture.dtype) == ((200, 200, 3), np.uint8)
    for name, colour in (("rabbit_0", (240, 240, 240)), ("hunter_0", (180, 40, 40))):
        x, y, _ = seen[name][:3]
        assert tuple(picture[199 - int((1 + y) * 99.5), int((1 + x) * 99.5)]) == colour
    assert played.metadata["render_fps"] == 10


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_an_agent_nobody_knows_and_an_action_outside_its_space(played):
    played.reset(seed=1)
    fine = dict.fromkeys(played.agents, 0)
    for wrong in ({**fine, "ghost": 0}, {"hunter_0": 0}, None, [0] * 5, 0, {}):
        text = re.escape(f"{wrong!s:.60}"[:60])
        with pytest.raises(ValueError, match=rf"^actions {text}.*, but those that live are \['hunter_0', "):
            played.step(wrong)
    with pytest.raises(ValueError, match=r"action 5 is not in Discrete\(5\), agent rabbit_1"):
        played.step({**fine, "rabbit_1": 5})
    with pytest.raises(ValueError, match="no agent is named 'ghost'; the scene has 5 agents named hunter_0, "):
        played.send_info({}, "ghost")
    for request, text in (
        (info(["ghost", {}]), "unknown-agent: .*ghost"),
        (info({"a": [1]}), "bad-info"),
        (info(["hunter_0"]), "bad-info"),
        (info([1, {}]), "bad-info"),
        (Message("info"), "bad-info"),
    ):
        with pytest.raises(MessageError, match=text):
            played.simulators.ask(request)
    assert set(played.step(fine)[0]) == set(fine), "it goes on"


def test_a_batch_that_is_none_is_named(at_work):
    """Of texts Gymnasium makes no array, and takes it for a space that it does not know."""
    envs = at_work(UnityVectorEnv, "ann ann", num_envs=2)
    envs.reset(seed=1)
    for wrong in (None, 1, ("",)):
        with pytest.raises(ValueError, match=r"^actions .* are not in Tuple\(Text"):
            envs.step(wrong)


# Real time


@pytest.mark.parametrize("kind", ["csharp", "unity"])
def test_the_world_goes_on_while_python_thinks_if_it_is_to(kind, launch, make):
    """A thinker's second is ten ticks at least; how many more it becomes on a busy machine nobody knows."""
    env = make(UnityParallelEnv, "Pursuit", launch=launch(kind, key=KEY), real_time=True)
    # In this one no rabbit is near a hunter, whom a tick of resting costs 0.01 of its energy.
    seen, _ = env.reset(seed=10)
    for thinks, least in ((0, 1), (0, 1), (1.15, 10)):
        time.sleep(thinks)
        before = seen["hunter_0"][2]
        seen, rewards, *_ = env.step(dict.fromkeys(env.agents, 0))
        ticks = round(float(before - seen["hunter_0"][2]) / 0.01)
        assert rewards["hunter_1"] == pytest.approx(-0.01 * ticks), "rewards are summed"
        assert ticks >= least


# Simulators that are lost, too many or wrong, and words that cannot be sent to them


ONE = np.ones(3, int)


@pytest.fixture
def game(inside, make):
    simulator = inside(SceneSimulator(Pursuit()))
    env = make(UnityParallelEnv, "Pursuit", socket=simulator.socket)
    env.simulator = simulator
    env.reset(seed=1)
    return env


# Lost


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_a_lost_simulator_ends_all_areas_and_they_begin_anew_in_another(mode, areas):
    envs = areas(autoreset_mode=mode)
    begin, _ = envs.reset(seed=7)
    seen, *_ = envs.step(ONE)
    kept, seen[:] = seen.copy(), 9
    envs.simulator.lose()
    last, rewards, terminated, truncated, infos = envs.step(ONE)
    assert (rewards.tolist(), terminated.any(), truncated.all()) == ([0, 0, 0], False, True)
    if mode == "SameStep":
        assert all(np.array_equal(*pair) for pair in zip(infos["final_obs"], kept, strict=True))
        infos, again = infos["final_info"], last
    else:
        assert np.array_equal(last, kept), "nobody knows what came after; and what was given out is the user's"
        whole = {"options": {"reset_mask": np.ones(3, bool)}}
        again = envs.reset(**whole)[0] if mode == "Disabled" else envs.step(ONE)[0]
    assert infos["lost"].tolist() == ["the simulator is gone"] * 3 and infos["_lost"].all()
    assert abs(again).max() <= 0.05, "all of them began"
    *_, truncated, infos = envs.step(ONE)
    assert not truncated.any() and infos == {}
    assert np.array_equal(envs.reset(seed=7)[0], begin)


def test_a_lost_simulator_ends_the_game_and_the_next_one_starts_in_another(game):
    begin, _ = game.reset(seed=7)
    kept = {agent: seen.copy() for agent, seen in begin.items()}
    for seen in begin.values():
        seen[:] = 9
    game.simulator.lose()
    actions = dict.fromkeys(game.agents, 0)
    seen, rewards, terminated, truncated, infos = game.step(actions)
    assert all(np.array_equal(seen[agent], kept[agent]) for agent in actions)
    assert (set(rewards.values()), set(terminated.values()), set(truncated.values())) == ({0.0}, {False}, {True})
    assert set(map(str, infos.values())) == {"{'lost': 'the simulator is gone'}"} and game.agents == []
    with pytest.raises(ConnectionError, match="the simulator is gone"):
        game.send_info({"anybody": "there"})
    again, _ = game.reset(seed=7)
    assert all(np.array_equal(again[agent], kept[agent]) for agent in actions)


def test_who_is_lost_at_the_reset_as_well_begins_once_more(areas, monkeypatch):
    """Such as when lesson 17's hub is started anew twice; and whom each reset ends is given up."""
    envs, others = areas(), areas()
    for each in others, envs:
        seen, _ = each.reset(seed=1)
    ask, fates = envs.simulators.ask, ["lost", "lost", "answered", *3 * ["lost"]]
    monkeypatch.setattr(envs.simulators, "find", lambda *_: None)

    def lossy(*request):
        if fates.pop(0) == "lost":
            raise Lost("it is gone")
        return ask(*request)

    envs.simulators.ask = lossy
    again, infos = envs.reset(seed=1, options={"reset_mask": np.array([True, False, False])})
    assert np.array_equal(again[0], seen[0])
    assert np.array_equal(again[1:], others.reset()[0][1:]), "all of them begin, by the seeds that come next"
    assert infos["_lost"].tolist() == [False, True, True], "and those that were not asked to were lost"
    with pytest.raises(Lost, match="it is gone"):
        envs.reset(seed=1)
    assert not fates


# Wrong


def test_another_number_of_areas_is_one_clear_line(serve, start_client, run):
    server, endpoint = serve(KEY, "--world", "CartPole", "--areas", "16")
    words = ["--world", "CartPole", "--areas", "8", "--timeout", "3"]
    client = start_client("csharp", KEY, endpoint, *words)
    text = (
        "wrong-scene: num_envs is 16, and the scene has 8 agents named agent_0 … agent_7: "
        "write num_envs=8, or change their number in the scene"
    )
    assert client.wait() == 1
    # At once, and not again at each try.
    assert client.lines[1:-1] == [f"trouble: {text}"]
    client.wait_for(f"^gave up: .*{text}")
    server.wait_for(f"^trouble: {text}$")
    assert run("python", KEY, "--endpoint", endpoint, "--world", "CartPole", "--areas", "16").code == 0, "it goes on"


def test_a_wrong_mask_is_named(areas):
    envs = areas(autoreset_mode="Disabled", max_episode_steps=1)
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(ONE)
    envs.reset(seed=1)
    for mask in (np.zeros(3, bool), np.ones(2, bool), [1, 0, 1]):
        with pytest.raises(ValueError, match="reset_mask must be 3 times true or false, one of them true"):
            envs.reset(options={"reset_mask": mask})
    envs.step(ONE)
    with pytest.raises(ValueError, match=r"agents \[0 1 2\] are over: reset"):
        envs.step(ONE)


# Tests of lessons 09 and 11 have what records.py, infos.py and trees.py refuse.
WRONG_ANSWERS = {
    "NaN": ({"numbers": rewards([1, float("nan")])}, "bad-reward: the rewards are"),
    "NaN seen": ({"rows": [bytes(16), np.full(4, np.nan, "<f4").tobytes()]}, "not-in-space: float32"),
    "too short": ({"rows": [bytes(16), bytes(12)]}, r"not-in-space: 28 bytes are not 2 of Box"),
    "its own word": ({"infos": {1: trees.write({"final_obs": 1})}}, "bad-info: these names are the environment's own"),
    "a stranger": ({"ended": 7}, "bad-record: agent 7 of 2 cannot have ended"),
}


@pytest.mark.parametrize("what", WRONG_ANSWERS)
def test_a_wrong_answer_of_many_is_named(what, inside, make):
    """Which the environment asks for, and its simulator gives by hand."""
    wrong, text = WRONG_ANSWERS[what]

    def answer(request):
        given: Any = wrong if request.has(STEP) else {}
        now = Section(0, given.get("numbers", rewards([1, 1])), bytes([SEEN] * 2))
        with_infos(with_sizes(now, given.get("rows", [bytes(16)] * 2)), given.get("infos", {}))
        ended = with_sizes(Section(0, rewards([1]), bytes([SEEN]), columns=ENDED | WHO), [bytes(16)])
        ended.who = given.get("ended", 0).to_bytes(4, "little")
        return [Record(ANSWERS, request.id, [now, ended] if "ended" in given else [now]).frames()]

    simulator = inside(simulated(count=2), answer)
    envs = make(gymnasium.make_vec, "NetMQExample/CartPole-v0", 2, socket=simulator.socket, autoreset_mode="SameStep")
    envs.reset(seed=1)
    with pytest.raises(MessageError, match=text):
        envs.step(np.zeros(2, int))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda record: setattr(record.sections[0], "values", b""), "not-in-space: 0 bytes"),
        (lambda record: with_infos(record.sections[1], {1: trees.write({"lost": 1})}), "bad-info: .*own: lost"),
        (lambda record: setattr(record, "said", trees.write({"env": 1})), "bad-info: the infos of a scene are a list"),
        (lambda record: record.sections.reverse(), "wrong-agents: the answer is not of those that were asked"),
        (lambda record: record.sections.pop(), "wrong-agents: the answer is not of those that were asked"),
    ],
)
def test_a_wrong_answer_of_a_game_is_named(change, text, inside, make):
    simulator = SceneSimulator(Pursuit())

    def answer(request):
        record = read_frames(ANSWERS, simulator.answer(request))
        change(record)
        return [record.frames()]

    env = make(UnityParallelEnv, "Pursuit", socket=inside(simulator, answer).socket)
    with pytest.raises(MessageError, match=text):
        env.reset(seed=1)


def test_areas_that_no_message_can_hold_are_refused(inside):
    class Large(CartPole):
        observation = Box(-1, 1, (4_000_000,))

    simulator = inside(SceneSimulator(Scene("CartPole", [Large() for _ in range(1024)])))
    text = "^wrong-scene: 16384000000 bytes of 1024 agents are more than a message has, 67108864"
    with pytest.raises(MessageError, match=text):
        gymnasium.make_vec("NetMQExample/CartPole-v0", 1024, socket=simulator.socket)


@pytest.mark.parametrize(
    ("names", "most", "text"),
    [
        ("ann ann:2", "", "'ann_1' and 'ann_0' have one name, ann, and not the same period: give them two names"),
        ("ann_1 ann_1", "", "two agents are named 'ann_1': each needs a name of its own"),
        ("ann ann", "ann 1", "there are 1 agents of the name 'ann' already: raise At Most of 'ann' in GymManager"),
    ],
)
def test_agents_that_cannot_be_in_one_scene_of_csharp_are_named_to_python(names, most, text, checks):
    """At once. In Python it is test_10_scene_rules.py."""
    with pytest.raises(MessageError, match=f"^gave-up: {text}"):
        UnityParallelEnv("Office", launch=["dotnet", checks, "office", names, most])


# Wrong words of a user: their types are those of test_12_words.py


def test_options_that_are_no_dict_are_named(areas, game):
    envs = areas()
    for options in (0, "abc", [1]):
        for each in envs, game:
            with pytest.raises(ValueError, match=r"^options must be a dict, not "):
                each.reset(options=options)
            with pytest.raises(ValueError, match=r"^options have no seed: write reset\(seed=…\)$"):
                each.reset(options={"seed": 1})
            with pytest.raises(ValueError, match=r"^option 'what' cannot be sent: set has no place in a message$"):
                each.reset(options={"what": {1}})


def test_an_info_that_cannot_be_sent_is_named_before_it_is(game):
    with pytest.raises(ValueError, match=r"^the info cannot be sent: .*set has no place in a message"):
        game.send_info({"a": {1}})
    with pytest.raises(ValueError, match=f"an info has at most {LONGEST_INFO} bytes"):
        game.send_info({"long": "x" * LONGEST_INFO})
    assert len(game.step(dict.fromkeys(game.agents, 0))[0]) == 5, "it goes on"


def test_a_seed_that_no_simulator_could_read_is_named(areas):
    envs = areas()
    for seed in (EXACT, EXACT - 1, 2**63, [1, None, 2**70], -1, "abc", [1, float("nan"), 2]):
        with pytest.raises(ValueError, match=r"^\d seeds are not one for each of 3 agents, below 2\*\*53"):
            envs.reset(seed=seed)
    with pytest.raises(ValueError, match=r"^1 seeds are not one for each of 3 agents"):
        envs.reset(seed=0.5)
    envs.reset(seed=np.array([1, 2, 3]))
    assert envs.np_random_seed == (1, 2, 3)
    envs.reset(seed=EXACT - 3)
    assert envs.np_random_seed == (EXACT - 3, EXACT - 2, EXACT - 1)
    assert len(envs.np_random) == 3


def test_what_version_0_3_called_otherwise():
    for name in "GymEnv", "VectorEnv", "ParallelEnv":
        with pytest.warns(DeprecationWarning, match=f" is Unity{name} now"):
            assert getattr(doors, f"Zmq{name.removeprefix('Gym')}") is getattr(doors, f"Unity{name}")
    for name in "Simulation", "AgentSimulation", "Simulator", "AreaSimulator", "AgentSimulator":
        with pytest.raises(AttributeError, match=f"^{name} is gone: (derive from Agent|write SceneSimulator)"):
            getattr(scene, name)
