"""Lesson 11: observations, actions and infos with each simulator, and faults. Values are in test_11_trees.py, the page
for those who come from gymize is in test_11_from_gymize.py.
"""

from __future__ import annotations

import functools
import importlib
import inspect
import re
import sys

import pytest
import zmq

from kitlib.docs import guide
from tests.conftest import CLIENTS
from tests.lessons.test_11_trees import same
from tests.programs import LIMIT, ROOT

gymnasium = pytest.importorskip("gymnasium", reason="lesson 11 needs gymnasium: kit.py run 11 installs it")
np = pytest.importorskip("numpy", reason="lesson 11 needs numpy: kit.py run 11 installs it")
pytest.importorskip("pettingzoo", reason="lesson 11 needs pettingzoo: kit.py run 10 installs it")
from gymnasium import spaces  # noqa: E402
from gymnasium.utils.env_checker import check_env, data_equivalence  # noqa: E402
from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate  # noqa: E402
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test  # noqa: E402

from netmq_example.envs import UnityAECEnv, UnityParallelEnv  # noqa: E402
from netmq_example.messages import Message, MessageError  # noqa: E402
from netmq_example.scene.scene import Agent, SceneSimulator  # noqa: E402
from netmq_example.wire import records, trees  # noqa: E402

KEY = "11_observations"
sys.path.append(str(ROOT / "python" / KEY))
collector = importlib.import_module("collector")
SPACES = {"observation_space": collector.seen_space(False), "action_space": collector.ACTION}


@pytest.fixture
def launch(launch):
    """launch("csharp"): the words for an environment that starts this lesson's simulator by itself."""
    return functools.partial(launch, key=KEY)


@pytest.fixture
def make(make):
    """make(…), or make(UnityParallelEnv, …): an environment of this lesson's world, or of another one."""
    return lambda kind="NetMQExample/Unity-v0", **where: make(kind, **({"env_name": "Coins"} | where))


# An environment like any other


@pytest.mark.filterwarnings("error", "ignore:.*different from the unwrapped.*", "ignore:.*flatten.*", "ignore:.*Box.*")
def test_gymnasiums_checker_finds_nothing(make, launch):
    # To be rendered it would need a ViewRecorder: test_11_films.py has one.
    check_env(make(launch=launch("csharp"), **SPACES).unwrapped, skip_render_check=True)


def test_both_languages_see_the_same_to_the_last_bit(make, launch):
    """And the same rewards and infos. Unity's picture is its own: a camera has taken it."""
    envs = [make(launch=launch(kind), **SPACES) for kind in CLIENTS]
    # Of the first one the beginning is enough.
    for episode in (1, 0):
        seen = [env.reset(seed=episode)[0] for env in envs]
        over = False
        while not over:
            pictures = [each.pop("camera") for each in seen]
            assert same(pictures[0], pictures[1]) or len(CLIENTS) < 3
            assert all(same(seen[0], other) for other in seen[1:])
            action = collector.policy(seen[0])
            said = list(zip(*(env.step(action) for env in envs), strict=True))
            seen = list(said.pop(0))
            assert all(other == one for one, *others in said for other in others)
            over = said[1][0] or episode == 1
    assert said[3][0]["agent"] == [seen[0]["says"]] and re.fullmatch(r"coin 3 after \d+ steps", seen[0]["says"])


def talk(kind, start, client_command, count=3):
    """Every frame that a simulator sends in an episode of a few steps."""
    with zmq.Context() as context, context.socket(zmq.ROUTER) as router:
        router.linger, router.rcvtimeo = 0, int(1000 * LIMIT)
        endpoint = f"tcp://127.0.0.1:{router.bind_to_random_port('tcp://127.0.0.1')}"
        client = start(*client_command(kind, KEY, endpoint))
        peer, *hello = router.recv_multipart()
        said = [hello]

        def ask(request):
            router.send_multipart([peer, *request.frames()])
            said.append(router.recv_multipart()[1:])

        def record(id, order, row=b"", options=b"", count=1):
            orders, rows = [order] * count, [row] * count
            ask(records.Record(records.ASKS, id, records.seeds([7] * count), orders, rows, options=options))

        def info(id, value):
            ask(Message("info", id, {}, [trees.array_of(trees.write(value))]))

        router.send_multipart([peer, *Message("welcome").frames()])
        record(1, records.RESET, options=trees.write({"agents": ["agent"], "options": {"any": [1, "x"]}}))
        action = trees.write({"push": np.array([0.3, -1], np.float32), "boost": 1})
        for id in [*range(2, 2 + count), 1 + count]:
            record(id, records.STEP, action)
        info(3 + count, ["agent", {"a": [None, True]}])
        record(4 + count, records.NOTHING)
        info(5 + count, ["bus", 1])
        info(6 + count, {"to": "agent"})
        ask(Message("jump", 7 + count))
        record(8 + count, records.STEP, b"{")
        record(9 + count, records.STEP, action, count=2)
        for at, options in enumerate((trees.write({"agents": ["bus"], "options": {}}), trees.write([]), b"")):
            record(10 + count + at, records.RESET, options=options)
        ask(Message("close", 50))
        assert client.wait() == 0, client.output
        assert client.lines[-1] == f"done: 1 episodes, {count} steps", "a request that comes again is done once"
        return said


def test_both_languages_send_the_same_bytes(start, client_command):
    """But for the words of an error."""
    python, csharp = (talk(kind, start, client_command) for kind in ("python", "csharp"))
    assert len(python) == len(csharp)
    codes = []
    for mine, other in zip(python, csharp, strict=True):
        errors = [Message.read(each) for each in (mine, other) if each[0].startswith(b'{"kind":"error"')]
        if errors:
            codes += [error.values["code"] for error in errors]
        else:
            assert mine == other
    assert codes[::2] == codes[1::2] and len(codes) == 16
    assert python[5] == python[4], "kept"


def test_the_lines_of_the_page_are_the_classs_own():
    (block,) = [block for block in guide.blocks(ROOT / f"docs/guide/{KEY}.md") if "each line with it" in block.source]
    code = (ROOT / f"unity/Assets/NetMQExample/{KEY}/CoinCar.cs").read_text(encoding="utf-8")
    assert [line for line in block.body.splitlines() if line not in code] == []


def test_a_wrong_space_is_named_with_its_place_and_the_server_goes_on(serve, start, client_command):
    server, endpoint = serve(KEY, "--wrong-space")
    client = start(*client_command("csharp", KEY, endpoint))
    trouble = server.wait_for("^trouble: .*")[0]
    assert re.search(
        r"not-in-space: 'agent'@\['place'\]: float32 \[2\] array\(\[5\., 5\.\].* is not in Box\(0", trouble
    )
    server.wait_for("^waiting for a simulator", start=len(server.lines))
    client.stop()
    assert "Traceback" not in server.output


# A camera's pictures


def test_a_camera_sensor_sees_the_scene_upright(make, launch):
    env = make(launch=launch("unity"), **SPACES)
    seen, _ = env.reset(seed=3)
    for _ in range(4):
        picture = seen["camera"].astype(int)
        assert picture.shape == (48, 64, 3)
        red = (picture[..., 0] > 150) & (picture[..., 1] < 100)
        rows, columns = np.nonzero(red)
        assert rows.mean() == pytest.approx(47 * (1 - seen["place"][1] / 10), abs=4), "north is up"
        assert columns.mean() == pytest.approx(8 + 47 * seen["place"][0] / 10, abs=4)
        seen, *_ = env.step({"push": np.array([0.5, 1], np.float32), "boost": 1})


# A lost one


def test_a_killed_simulator_ends_the_episode_and_the_next_reset_starts_another(make, launch):
    env = make(launch=launch("csharp"), **SPACES)
    seen, _ = env.reset(seed=7)
    process = env.unwrapped.agents.simulators.process
    process.kill()
    process.wait()
    last, *said = env.step(collector.policy(seen))
    assert said == [0, False, True, {"env": [], "agent": [], "lost": "the simulator is gone"}]
    assert all(same(last[key], seen[key]) for key in seen)
    again, _ = env.reset(seed=7)
    assert all(same(again[key], seen[key]) for key in seen)


def test_a_game_that_is_not_there_is_named(make, tmp_path):
    """Which endings a build has, a test of lesson 10 knows."""
    with pytest.raises(FileNotFoundError, match=r"no game at .*NoGame"):
        make(file_name=str(tmp_path / "NoGame"), **SPACES)


# Several agents, and agents that do what they are told: tests/lessons/checks/World.cs


@pytest.fixture(scope="module")
def world(checks):
    """The words that launch a scene with the agents a, b and c, each of which does what its action says."""
    return ["dotnet", checks, "observations", "world"]


TOLD = spaces.Text(40, min_length=0, charset="abcdefghijklmnopqrstuvwxyz0123456789. ")
WHAT = spaces.Dict(ticks=spaces.Discrete(1000), value=spaces.Box(-9, 9, (2,), np.float32), said=spaces.Sequence(TOLD))


def told(names="ab", action=TOLD, **where):
    return {
        "env_name": "World",
        "observation_spaces": dict.fromkeys(names, WHAT),
        "action_spaces": dict.fromkeys(names, action),
        **where,
    }


def test_pettingzoos_tests_find_nothing(make, world):
    # A random word of letters can be one that an agent obeys.
    action = spaces.Text(40, min_length=0, charset="0123456789. ")
    env = make(UnityParallelEnv, launch=world, **told(action=action))
    parallel_api_test(env, num_cycles=10)
    assert env.observation_space("a") is env.observation_space("a")
    # PettingZoo 1.24 decides by itself how many.
    cycles = {"num_cycles": 3} if "num_cycles" in inspect.signature(parallel_seed_test).parameters else {}
    # PettingZoo 1.24 looks into every Dict for a mask of actions.
    if cycles:
        api_test(make(UnityAECEnv, launch=world, **told(action=action)), num_cycles=10)
    parallel_seed_test(lambda: make(UnityParallelEnv, launch=world, **told("a", action)), **cycles)


def test_a_step_waits_for_all_who_act(make, world):
    """Agent b takes three ticks for a step, the others one."""
    env = make(UnityParallelEnv, launch=world, **told("abc"))
    seen, infos = env.reset(seed=1)
    assert list(seen) == list(infos) == ["a", "b", "c"]
    seen, rewards, *_ = env.step({"a": "reward 1.5", "b": "", "c": ""})
    assert [seen[name]["ticks"] for name in "abc"] == [3, 3, 3]
    assert rewards == {"a": 1.5, "b": 0, "c": 0}
    env.agents = ["a"]
    assert env.step({"a": ""})[0]["a"]["ticks"] == 4


def test_who_has_ended_has_no_more_ticks(make, world):
    env = make(UnityParallelEnv, launch=world, **told())
    env.reset(seed=1)
    seen, rewards, ends, *_ = env.step({"a": "", "b": "until 2"})
    assert (seen["a"]["ticks"], seen["b"]["ticks"], rewards["b"], ends["b"]) == (3, 2, 1, True)


def test_agents_end_leave_and_come(make, world):
    env = make(UnityParallelEnv, launch=world, **told())
    env.reset(seed=1)
    *_, ends, cuts, _ = env.step({"a": "terminate", "b": ""})
    assert (ends, cuts, env.agents) == ({"a": True, "b": False}, {"a": False, "b": False}, ["b"])
    *_, cuts, infos = env.step({"b": "leave"})
    assert cuts == {"b": True} and infos["b"]["lost"] == "agent b has left the scene" and env.agents == []
    with pytest.raises(MessageError, match="unknown-agent: no agent is named 'b'; there are: a, c"):
        env.reset(seed=1)
    env.scene.send_info("come b", "a")
    seen, _ = env.reset(seed=1)
    assert list(seen) == ["a", "b"], "late"
    env.scene.send_info("come a", "b")
    with pytest.raises(MessageError, match="two-agents: 2 agents are named 'a': each needs a name of its own"):
        env.reset(seed=1)


def test_one_after_the_other(make, world):
    """The last observation can be asked for as often as one likes."""
    env = make(UnityAECEnv, launch=world, **told())
    env.reset(seed=1)
    env.send_info("one", "a")
    for step in range(1, 4):
        for name in "ab":
            assert env.agent_selection == name
            seen = [env.last()[0] for _ in range(3)]
            assert same(seen[0], seen[1]) and same(seen[1], seen[2])
            env.step(f"reward {step}")
        assert env.infos["a"]["agent"] == (["one"] if step == 1 else [])
    assert env.last()[0]["ticks"] == 9


# Many at once, as a vector


def vector(count=3, **more):
    return gymnasium.make_vec("NetMQExample/Unity-v0", count, **more)


def policies(seen):
    """The actions of all cars by hand, together."""
    actions = [collector.policy(one) for one in iterate(batch_space(SPACES["observation_space"], 3), seen)]
    return concatenate(collector.ACTION, actions, create_empty_array(collector.ACTION, 3))


@pytest.mark.parametrize("mode", AutoresetMode)
@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_vector_of_agents_is_what_gymnasium_makes_of_single_ones(kind, mode, make, launch):
    """Observations, rewards, ends and infos, to the last bit; episodes end by the last coin, and by the time."""
    words = {"max_episode_steps": 18, **SPACES}
    launched = launch(kind, "--agents", "3")
    ours = make(vector, launch=launched, autoreset_mode=mode, **words)
    singles = [lambda: gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", launch=launch(kind), **words)] * 3
    theirs = make(lambda **_: SyncVectorEnv(singles, autoreset_mode=mode))
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"] == mode
    assert (ours.observation_space, ours.action_space) == (theirs.observation_space, theirs.action_space)

    def alike(mine, other):
        assert data_equivalence(mine, other, exact=True), (mine, other)
        return mine

    seen, _ = alike(ours.reset(seed=7), theirs.reset(seed=7))
    ends = [0, 0]
    for _ in range(80):
        actions = policies(seen)
        seen, _, *over, _ = alike(ours.step(actions), theirs.step(actions))
        ends = [count + each.sum() for count, each in zip(ends, over, strict=True)]
        again = {"reset_mask": over[0] | over[1]}
        if mode == AutoresetMode.DISABLED and again["reset_mask"].any():
            seen, _ = alike(ours.reset(options=dict(again)), theirs.reset(options=dict(again)))
    assert min(ends) > 1, "episodes ended both ways"
    seeds = [3, None, 5]
    for again in ({"seed": seeds}, {"seed": 9, "options": {"x": [1, "y"]}}):
        alike(ours.reset(**again), theirs.reset(**again))


def test_an_agent_of_a_vector_that_leaves_is_truncated_and_says_why(make, world):
    told = {"observation_space": WHAT, "action_space": TOLD}
    launched = [*world, "agent_0", "agent_1", "other"]
    envs = make(vector, count=2, env_name="World", launch=launched, **told, max_episode_steps=4)
    envs.reset(seed=1)
    seen, rewards, *over, infos = envs.step(("reward 2", "leave"))
    assert [one["ticks"] for one in iterate(envs.observation_space, seen)] == [1, 0], "what it has seen last"
    assert rewards.tolist() == [2, 0] and [each.tolist() for each in over] == [[False] * 2, [False, True]]
    assert infos["lost"].tolist() == [None, "it has left the scene"] and infos["agent"].tolist() == [[], []]
    with pytest.raises(MessageError, match="unknown-agent: no agent is named 'agent_1'; there are: agent_0, other"):
        envs.step(("", ""))
    with pytest.raises(ValueError, match=r"^num_envs .*0"):
        vector(count=0, env_name="World", launch=launched, **told)


def test_a_vector_whose_simulator_is_killed_is_truncated_and_begins_in_the_next_one(make, launch):
    envs = make(vector, launch=launch("python", "--agents", "3"), **SPACES)
    seen, _ = envs.reset(seed=7)
    process = envs.unwrapped.areas.simulators.process
    process.kill()
    process.wait()
    last, rewards, terminated, truncated, infos = envs.step(policies(seen))
    assert data_equivalence(last, seen, exact=True)
    assert (rewards.any(), terminated.any(), truncated.all()) == (False, False, True)
    assert infos["lost"].tolist() == ["the simulator is gone"] * 3 and infos["env"].tolist() == [[]] * 3
    again, *_ = envs.step(policies(seen))
    assert not data_equivalence(again, seen, exact=True), "by the seeds that come next"
    again, _ = envs.reset(seed=7)
    assert data_equivalence(again, seen, exact=True)


@pytest.fixture(scope="module")
def one_world(world):
    env = gymnasium.make(
        "NetMQExample/Unity-v0",
        env_name="World",
        agent_name="a",
        launch=world,
        observation_space=WHAT,
        action_space=TOLD,
    )
    yield env
    env.close()


@pytest.fixture
def alone(one_world):
    """One agent, which does what it is told; whatever was done before is over."""
    one_world.reset(seed=1)
    return one_world


def test_reset_clears_rewards_ends_and_infos(alone):
    for what, ends in (("terminate", (True, False)), ("truncate", (False, True)), ("info over", (False, False))):
        alone.unwrapped.send_info("reward 5", "a")
        alone.unwrapped.send_info(what, "a")
        alone.reset(seed=1)
        _, reward, *none, info = alone.step("")
        assert (reward, none, info) == (0, [False, False], {"env": [], "agent": []})
        assert alone.step(what)[2:4] == ends
        alone.reset()


def test_a_seed_reaches_those_whom_python_does_not_ask(alone):
    """A scripted opponent draws its place, too."""
    drawn = []
    for seed in (5, 6, 5):
        alone.reset(seed=seed)
        drawn += alone.step("draw c")[-1]["agent"]
    assert drawn[0] == drawn[2] != drawn[1]
    one, other = Agent("a"), Agent("c")
    options = trees.write({"agents": ["a"], "options": {"x": 1}})
    reset = records.Record(records.ASKS, 1, records.seeds([5]), [records.RESET], [b""], options=options)
    SceneSimulator("World", 0.5, [one, other]).do(reset)
    assert (other.rng, other.options) == (one.rng, {"x": 1}), "and in Python"


def test_rewards_add_up_until_they_are_told(alone):
    for told in ("reward 1", "reward 2"):
        alone.unwrapped.send_info(told, "a")
    assert alone.step("")[1] == 3
    alone.unwrapped.send_info("reward 1", "a")
    alone.unwrapped.send_info("all 7", "a")
    assert [alone.step("")[1] for _ in range(2)] == [7, 0]


def test_infos_go_both_ways(alone):
    env = alone.unwrapped
    info = {"a": [1, 2.5, None, True, {"b": "c"}], "array": np.arange(3, dtype=np.int32), "é": ()}
    env.send_info(info, "a")
    env.send_info("to the environment")
    env.send_info(7, "b")
    said = alone.step("info one")[-1]
    assert said["env"] == ["heard to the environment"], "and what b heard is b's own"
    heard, one = said["agent"]
    assert same(heard, {"a": [1, 2.5, None, True, {"b": "c"}], "array": np.arange(3, dtype=np.int32), "é": []})
    assert one == "one"
    assert alone.step("")[-1] == {"env": [], "agent": []}, "once"
    with pytest.raises(MessageError, match="unknown-agent: no agent is named 'bus'; there are: a, b, c"):
        env.send_info(1, "bus")


def test_options_and_seed_reach_the_agents(alone):
    _, info = alone.reset(seed=3, options={"level": [1, {"x": "y"}]})
    drawn = info["agent"][0]
    assert same(info["agent"][1], {"level": [1, {"x": "y"}]})
    assert alone.reset(seed=3)[1]["agent"][0] == drawn != alone.reset(seed=4)[1]["agent"][0]


def test_observations_are_copies_and_begin_with_nothing(alone):
    first, _ = alone.reset(seed=1)
    assert same(first["said"], ()), "no sample"
    assert same(first["value"], np.zeros(2, np.float32)), "what nothing writes is zero"
    first["value"][:] = 5
    seen, *_ = alone.step("say one two")
    assert same(seen["value"], np.zeros(2, np.float32)) and seen["said"] == ("one", "two")
    kept = seen["value"].copy()
    seen, *_ = alone.step("value 3")
    assert same(kept, np.zeros(2, np.float32)) and seen["value"].tolist() == [0, 3], "a part of it"
    seen["value"][:] = 7
    seen, *_ = alone.step("say x")
    assert seen["value"].tolist() == [0, 3] and seen["said"] == ("x",), "the message before is cleared"


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("value 10", r"not-in-space: 'a'@\['value'\]: float32 \[2\] array\(\[ ?0., 10.\].* is not in Box\(-9"),
        ("value nan", r"not-in-space: 'a'@\['value'\]: float32 \[2\] array\(\[ ?0., nan\].* is not in Box"),
        ("wide", r"not-in-space: 'a'@\['value'\]: float32 \[3\] array.* is not in Box"),
        ("text", r"bad-observation: 'a'@\['value'\] = \$: 'text' is no number"),
        ("key", r"bad-observation: 'a'@\['nowhere'\] = \$: there is no 'nowhere'"),
        ("number", r"bad-value: Odd.Number: NaN is not finite"),
        ("type", r"no-space: Odd.Number: no space takes a Version"),
        ("throw", r"error-in-simulation: InvalidOperationException: as it was told"),
    ],
)
def test_what_is_wrong_is_one_clear_line_and_the_next_episode_is_fine(what, said, alone):
    with pytest.raises(MessageError) as refusal:
        alone.step(what)
    assert re.match(said, str(refusal.value)), str(refusal.value)
    assert what == "throw" or "\n" not in str(refusal.value)
    alone.reset(seed=1)
    assert alone.step("")[0]["ticks"] == 1


def test_an_action_that_is_not_in_its_space_is_not_sent(alone):
    with pytest.raises(MessageError, match="not-in-space: action of a: str 'NO' is not in Text"):
        alone.unwrapped.step("NO")
    assert alone.step("")[0]["ticks"] == 1
