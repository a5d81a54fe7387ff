"""Lesson 10: simulators that are lost, too many or wrong, and words that cannot be sent to them."""

from typing import Any

import pytest

gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: kit.py run 10 installs it")
np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: kit.py run 10 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")

KEY = "10_many_agents"
from gymnasium.spaces import Box  # noqa: E402

from netmq_example import envs, scene  # noqa: E402
from netmq_example.envs import UnityParallelEnv  # noqa: E402
from netmq_example.envs.remote import LONGEST_INFO  # noqa: E402
from netmq_example.errors import Lost  # noqa: E402
from netmq_example.messages import EXACT, MessageError  # noqa: E402
from netmq_example.scene import Scene, SceneSimulator  # noqa: E402
from netmq_example.wire import trees  # noqa: E402
from netmq_example.wire.records import ANSWERS, ENDED, SEEN, STEP, WHO, Record, Section, read_frames  # noqa: E402
from netmq_example.wire.sections import rewards, with_infos, with_sizes  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402
from netmq_example.worlds.pursuit import Pursuit  # noqa: E402
from tests.lessons.conftest import simulated  # noqa: E402

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
            assert getattr(envs, f"Zmq{name.removeprefix('Gym')}") is getattr(envs, f"Unity{name}")
    for name in "Simulation", "AgentSimulation", "Simulator", "AreaSimulator", "AgentSimulator":
        with pytest.raises(AttributeError, match=f"^{name} is gone: (derive from Agent|write SceneSimulator)"):
            getattr(scene, name)
