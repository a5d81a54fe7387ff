"""Lesson 11: observations, actions and infos with each simulator, and faults. Values are in test_11_trees.py, the page
for those who come from gymize is in test_11_from_gymize.py.
"""

import functools
import importlib
import re
import sys

import pytest
import zmq

from kitlib.docs import guide
from tests.conftest import CLIENTS
from tests.lessons.conftest import bind
from tests.lessons.test_11_trees import same
from tests.programs import ROOT

gymnasium = pytest.importorskip("gymnasium", reason="lesson 11 needs gymnasium: kit.py run 11 installs it")
np = pytest.importorskip("numpy", reason="lesson 11 needs numpy: kit.py run 11 installs it")
pytest.importorskip("pettingzoo", reason="lesson 11 needs pettingzoo: kit.py run 10 installs it")
from gymnasium import spaces  # noqa: E402
from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate  # noqa: E402
from pettingzoo.test import parallel_api_test  # noqa: E402

from netmq_example.envs import UnityParallelEnv  # noqa: E402
from netmq_example.messages import Message, MessageError  # noqa: E402
from netmq_example.wire import records, sections, trees  # noqa: E402
from netmq_example.wire.records import Record, Section  # noqa: E402
from tests.lessons.vectors import play  # noqa: E402

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


def talk(kind, start_client, context, count=3):
    """Every frame that a simulator sends in an episode of a few steps."""
    with context.socket(zmq.ROUTER) as router:
        client = start_client(kind, KEY, bind(router))
        peer, *hello = router.recv_multipart()
        said = [hello]

        def ask(request):
            router.send_multipart([peer, *request.frames()])
            said.append(router.recv_multipart()[1:])

        def record(id, order, row=b"", options=b"", count=1):
            section = Section(0, sections.seeds([7] * count), bytes([order]) * count, values=row * count)
            ask(Record(records.ASKS, id, [section], said=options))

        def info(id, value):
            ask(Message("info", id, {}, [trees.array_of(trees.write(value))]))

        router.send_multipart([peer, *Message("welcome").frames()])
        record(1, records.RESET, options=trees.write({"any": [1, "x"]}))
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
        for at, options in enumerate((trees.write(5), trees.write([]), b"x")):
            record(10 + count + at, records.RESET, options=options)
        ask(Message("close", 50))
        assert client.wait() == 0, client.output
        assert client.lines[-1] == f"done: 1 episodes, {count} steps", "a request that comes again is done once"
        return said


def test_both_languages_send_the_same_bytes(start_client, context):
    """But for the words of an error."""
    python, csharp = (talk(kind, start_client, context) for kind in ("python", "csharp"))
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


def test_a_wrong_space_is_named_with_its_place_and_the_server_goes_on(serve, start_client):
    server, endpoint = serve(KEY, "--wrong-space")
    client = start_client("csharp", KEY, endpoint)
    trouble = server.wait_for("^trouble: .*")[0]
    assert re.search(
        r"not-in-space: 'agent'@\['place'\]: float32 \[2\] array\(\[5\., 5\.\].* is not in Box\(0", trouble
    )
    server.wait_for("^waiting for a simulator", start=server.lines.index(trouble))
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


# Many at once, as a vector


def vector(count=3, **more):
    return gymnasium.make_vec("NetMQExample/Unity-v0", count, **more)


def policies(seen):
    actions = [collector.policy(one) for one in iterate(batch_space(SPACES["observation_space"], 3), seen)]
    return concatenate(collector.ACTION, actions, create_empty_array(collector.ACTION, 3))


def test_a_vector_of_agents_is_what_gymnasium_makes_of_single_ones(make, launch):
    """Observations, rewards, ends and infos, to the last bit; episodes end by the last coin, and by the time."""
    words = {"max_episode_steps": 18, **SPACES}
    ours = make(vector, launch=launch("csharp", "--agents", "3"), autoreset_mode=AutoresetMode.SAME_STEP, **words)
    singles = [lambda: gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", launch=launch("python"), **words)] * 3
    theirs = make(lambda **_: SyncVectorEnv(singles, autoreset_mode=AutoresetMode.SAME_STEP))
    again = {"seed": [3, None, 5]}, {"seed": 9, "options": {"x": [1, "y"]}}
    ends = play([ours, theirs], lambda seen, step: policies(seen), 80, {"seed": 7}, *again)
    assert ends.sum(1).min() > 1, "episodes ended both ways"


# Agents that do what they are told: tests/lessons/checks/World.cs


TOLD = spaces.Text(40, min_length=0, charset="abcdefghijklmnopqrstuvwxyz0123456789. ")
WHAT = spaces.Dict(ticks=spaces.Discrete(1000), value=spaces.Box(-9, 9, (2,), np.float32), said=spaces.Sequence(TOLD))
GIVEN = {"observation_space": WHAT, "action_space": TOLD}


@pytest.fixture(scope="module")
def world(checks):
    """world("a", "b"): the words that launch a scene of such agents."""
    return lambda *names: ["dotnet", checks, "observations", "world", *names]


@pytest.mark.filterwarnings("error", "ignore:nothing writes")
def test_pettingzoos_test_finds_nothing_by_attributes(make, world):
    # A random word of letters can be one that an agent obeys.
    action = spaces.Text(40, min_length=0, charset="0123456789. ")
    words = {"observation_spaces": dict.fromkeys("ab", WHAT), "action_spaces": dict.fromkeys("ab", action)}
    parallel_api_test(make(UnityParallelEnv, env_name="World", launch=world("a", "b", "c"), **words), num_cycles=10)


@pytest.mark.filterwarnings("ignore:nothing writes")
def test_sixteen_are_each_what_one_alone_is(make, world):
    one = make(env_name="World", launch=world("a"), **GIVEN)
    batch = batch_space(WHAT, 16)
    words = ["", "say x", "say x y", "value 3", "", "value 4", *[""] * 10]
    turns = [words, [""] * 16, ["say z"] * 16, words[::-1]]
    for name in ("a", "sure"):
        envs = make(vector, count=16, env_name="World", launch=world(*[name] * 16), **(GIVEN if name == "a" else {}))
        assert envs.single_observation_space == WHAT and envs.single_action_space == TOLD
        seen = [list(iterate(batch, envs.reset(seed=1)[0]))]
        seen += [list(iterate(batch, envs.step(tuple(turn))[0])) for turn in turns]
        for agent in range(16):
            alone = [one.reset(seed=1)[0], *(one.step(turn[agent])[0] for turn in turns)]
            assert all(same(mine[agent], its) for mine, its in zip(seen, alone, strict=True)), (name, agent)


@pytest.fixture(scope="module")
def one_world(world):
    env = gymnasium.make("NetMQExample/Unity-v0", env_name="World", agent_name="a", launch=world("a", "b"), **GIVEN)
    yield env
    env.close()


@pytest.fixture
def alone(one_world):
    """One agent, which does what it is told; whatever was done before is over."""
    one_world.reset(seed=1)
    return one_world


@pytest.mark.filterwarnings("ignore:nothing writes")
def test_what_is_said_and_earned_between_two_steps_is_told_once_or_forgotten_at_the_reset(alone):
    send = alone.unwrapped.send_info
    for word in ("reward 1", "all 7", "reward 2"):
        send(word, "a")
    assert [alone.step("")[1] for _ in range(2)] == [9, 0]
    for what, ends in (("terminate", (True, False)), ("truncate", (False, True)), ("info over", (False, False))):
        send("reward 5", "a")
        send(what, "a")
        alone.reset(seed=1)
        _, reward, *none, info = alone.step("")
        assert (reward, none, info) == (0, [False, False], {"env": [], "agent": []})
        assert alone.step(what)[2:4] == ends
        alone.reset()


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
