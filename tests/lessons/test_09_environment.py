"""Lesson 09: Gymnasium and its users expect so much of an environment, with each simulator; and what users get wrong:
options, actions, words of launch and of the trainer. Faults are in test_09_environment_faults.py.
"""

import importlib.util
import itertools
import os
import re
import warnings
from typing import Any

import pytest

from tests.conftest import CLIENTS, PYTHON
from tests.programs import EACH_RUN, ROOT, InTurn, finished, python_runs

gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")
from gymnasium.utils.env_checker import check_env  # noqa: E402

KEY, ID = "09_environment", "NetMQExample/CartPole-v0"
LESSON = ROOT / "python" / KEY
from netmq_example.envs import UnityGymEnv  # noqa: E402
from netmq_example.envs.connection import name_of  # noqa: E402
from netmq_example.messages import MessageError  # noqa: E402
from netmq_example.scene import Scene, SceneSimulator  # noqa: E402
from netmq_example.scene.agent import begin  # noqa: E402
from netmq_example.wire import trees  # noqa: E402
from netmq_example.wire.records import Record  # noqa: E402
from netmq_example.wire.sections import seeds  # noqa: E402
from netmq_example.wire.split_mix import draws  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402
from netmq_example.worlds.road_car import RoadCar  # noqa: E402
from tests.lessons.conftest import simulated  # noqa: E402
from tests.lessons.poles import timeless, trained  # noqa: E402

# The state of seed 7, as float32; and what is seen 25 steps later, of right and left in turn.
GOLDEN_START = ["-0x1.6901820000000p-7", "-0x1.8bd8d60000000p-5", "0x1.484d9c0000000p-5", "0x1.0fbef80000000p-7"]
GOLDEN_END = [0.009156497, 0.1373327, 0.02900436, -0.07556468]
each_client = pytest.mark.parametrize("kind", CLIENTS)


@pytest.fixture
def env(kind, kept, launch):
    if kind not in kept:
        kept[kind] = gymnasium.make(ID, launch=launch(kind), render_mode="rgb_array")
    return kept[kind]


# An environment like any other


def lean(seen, step):
    """Push the cart to where the pole falls."""
    return int(seen[2] + seen[3] > 0)


@each_client
def test_its_trajectories_are_those_of_gymnasiums_own_cartpole(env):
    """Sine and cosine differ in the last bit between systems, and a pole makes much of little: from each 50th state on,
    both begin anew. The pole stays up, falls, or leaves the track on either side.
    """
    theirs = gymnasium.make("CartPole-v1")
    ends = []
    for state, policy in (
        (None, lean),
        (None, lambda seen, step: step % 2),
        ([2.3, 1, 0, 0], lean),
        ([-2.3, -1, 0, 0], lean),
    ):
        theirs.reset(seed=1)
        if state:
            theirs.unwrapped.state = np.array(state)
        for step in range(110):
            if step % 50 == 0:
                seen = np.array(theirs.unwrapped.state, np.float32)
                mine, _ = env.reset(options={"state": theirs.unwrapped.state})
            assert mine == pytest.approx(seen, abs=1e-6)
            action = policy(seen, step)
            (seen, *said, _), (mine, *ours_said, _) = theirs.step(action), env.step(action)
            assert ours_said == said
            if said[1]:
                break
        ends.append(said[1])
    assert ends == [False, True, True, True]


@each_client
def test_a_seed_gives_the_golden_trajectory(env):
    seen, _ = env.reset(seed=7)
    # From here on the numbers of a seed must never change. They come about by whole numbers and one multiplication.
    assert [float(number).hex() for number in seen] == GOLDEN_START
    for step in range(25):
        seen, *_ = env.step((step + 1) % 2)
    assert seen == pytest.approx(GOLDEN_END, abs=1e-6)
    random = [env.reset()[0] for _ in range(3)]
    assert not np.array_equal(random[0], random[1])
    env.reset(seed=7)
    assert np.array_equal([env.reset()[0] for _ in range(2)], random[:2]), "a seed decides what follows as well"
    # The options of a reset arrive, and what is wrong with them comes back.
    low, _ = env.reset(seed=7, options={"low": 0.01, "high": 0.02})
    assert (low >= 0.01).all() and (low <= 0.02).all()
    with pytest.raises(MessageError, match=r"^bad-option: low and high are numbers"):
        env.reset(options={"high": "abc"})


@each_client
def test_a_picture_shows_the_cart_where_it_is(env):
    for place in (-1.5, 1.5):
        env.reset(options={"state": [place, 0, 0.1 * place, 0]})
        picture = env.render()
        assert (picture.shape, picture.dtype) == ((200, 300, 3), np.uint8)
        columns = np.nonzero((picture == (40, 60, 90)).all(axis=2))[1]
        assert columns.mean() == pytest.approx(150 + 60 * place, abs=2)
        pole = np.nonzero((picture == (200, 140, 80)).all(axis=2))
        assert pole[0].min() < 30, "the pole is up, and the first row is the highest"
        assert (pole[1].max() if place > 0 else 300 - pole[1].min()) > 255, "and it leans outwards"
    assert env.metadata["render_fps"] == 50


# The car of lesson 08


def test_the_car_may_see_pictures(make, launch):
    env = make("NetMQExample/Car-v0", launch=launch("csharp", "--world", "Car", "--picture"), render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True, skip_close_check=True)
    seen, _ = env.reset(options={"state": [100]})
    assert seen.shape == (240, 320, 3)
    assert tuple(seen[100, 0]) != tuple(seen[239, 160]), "the sky is above the road"
    assert np.array_equal(env.render(), seen)
    world = RoadCar()
    begin(world, draws(0), {}, [100.0])
    world.on_reset()
    assert np.array_equal(world.render(), seen), "in both languages"


# Its name

MAKE = f"""
import gymnasium, sys
env = gymnasium.make("netmq_example.envs:{ID}", launch=sys.argv[1:])
made = type(env.unwrapped).__name__, env.spec.max_episode_steps, env.spec.vector_entry_point
env.close()
print(*made)
sys.modules["netmq_example.envs"].register()
print([name for name in gymnasium.registry if "NetMQExample" in name])
"""


def test_it_is_registered_once_and_needs_no_pettingzoo(launch, tmp_path):
    (tmp_path / "pettingzoo.py").write_text("raise ImportError('nobody has asked for it')", encoding="utf-8")
    path = os.pathsep.join(map(str, (tmp_path, ROOT / "python")))
    words = [PYTHON, "-W", "error", "-c", MAKE, *launch("python")]
    done = finished(words, env={**os.environ, "PYTHONPATH": path})
    assert done.returncode == 0, done.stderr
    assert "UnityGymEnv 500 netmq_example.envs:UnityVectorEnv\n" in done.stdout
    last = done.stdout.splitlines()[-1]
    assert last == "['NetMQExample/CartPole-v0', 'NetMQExample/Car-v0', 'NetMQExample/Unity-v0']"


# Training


def test_the_trainer_learns_the_same_from_the_same_seed(start, launch, caplog, tmp_path):
    """Wherever the world is; and where there is matplotlib it draws what it has learned when."""
    curve = tmp_path / "curve.svg"
    plot = ["--plot", curve] if importlib.util.find_spec("matplotlib") else []
    trainer = start(PYTHON, LESSON / "train.py", "--seed", "16", *plot, "--launch", *launch("python"))
    # 2,447 steps, from one process to another.
    assert trainer.wait(500) == 0, trainer.output
    lines, _ = trained(caplog, 16, 50)
    assert timeless(trainer.lines) == lines and len(lines) == 3
    assert float(re.search(r"mean (\S+) of 200", lines[-2])[1]) >= 195, "its goal"
    assert trained(caplog, 17, 1)[0][0] != lines[0]
    if plot:
        drawn = re.findall(r"<text [^>]*>(.*?)</text>", curve.read_text(encoding="utf-8"))
        labels = {"generation", "steps until the pole falls", "mean of a generation", "good enough"}
        assert labels < {*drawn} and {"0", "200"} < {*drawn}, "from 0 on"


CLIENT = [str(PYTHON), str(LESSON / "client.py"), "--timeout", "30"]


# Options and actions

# Tests of lesson 11 know what no message takes.
REFUSED = [
    ({"seed": 2**63}, r"a seed is a whole number from 0 to 2\*\*53 - 1, not 9223372036854775808"),
    ({"options": {"t": "x" * 2**24}}, "options of 167772.. bytes cannot be sent: at most 16777216"),
    ({"options": {"\ud800": 1}}, r"option '\\ud800' cannot be sent: it is no text"),
    ({"options": {"low": {"a": {3}}}}, "option 'low' cannot be sent: set has no place in a message"),
    ({"options": "abc"}, "options must be a dict"),
    ({"options": {"seed": 3}}, "options have no seed: write reset"),
]
SENT = {"none": None, "list": [1, 2.5, True], "float32": np.float32(0.5), "long": "x" * 70_000, "dict": {"ä": ["ö"]}}


def test_what_no_simulator_could_read_is_refused_by_name_before_it_is_sent(inside, make):
    simulator = inside(simulated())
    env = make(socket=simulator.socket, disable_env_checker=True)
    for words, text in REFUSED:
        with pytest.raises(ValueError, match=f"^{text}"):
            env.reset(**words)
    assert asked(simulator) == []
    env.reset(seed=2**53 - 1, options={**SENT, "array": np.arange(6.0).reshape(2, 3)})
    (request,) = [one for one in simulator.asked if isinstance(one, Record)]
    options = trees.read(request.said)
    assert options.pop("array").tolist() == [[0, 1, 2], [3, 4, 5]]
    assert options == SENT and request.sections[0].numbers == seeds([2**53 - 1])


def asked(simulator):
    return [name_of(request) for request in simulator.asked if request.kind != "welcome"]


def test_an_action_outside_its_space_is_named_in_one_line(inside, make):
    simulator = inside(simulated())
    env = make(socket=simulator.socket, disable_env_checker=True)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.unwrapped.step(1)
    env.reset()
    for action in (2, -1, 0.5, "left", np.array([1])):
        with pytest.raises(ValueError, match=r"^action .* is not in Discrete\(2\)$"):
            env.step(action)
    assert env.step(np.int64(1))[4] == {"env": [], "agent": []}
    # What is numbers of its dtype, the simulator refuses, before anything moves.
    assert asked(simulator)[-1] == "step" and simulator.simulator.steps == 1
    env = make("NetMQExample/Car-v0", socket=inside(simulated("Car")).socket, disable_env_checker=True)
    env.reset()
    with pytest.raises(ValueError, match=r"^action float32 array\(.* is not in Box\(-1.0, 1.0, \(2,\), float32\)$"):
        env.step(np.zeros((9, 9), np.float32))


# The trainer


TRAINERS = [
    (["--seed", "-1"], 2, "--seed: it takes a whole number from 0 to 2147483647, not -1"),
    (["--generations", "x"], 2, "--generations: it takes a whole number from 0 to 2147483647, not 'x'"),
    (["--plot", "no/such/folder/curve.svg"], 2, "--plot: cannot write 'no/such/folder/curve.svg'"),
    (["--plot", "."], 2, "--plot: cannot write '.'"),
    (["--launch"], 2, "--launch: expected at least one argument"),
    (["--endpoint", "tcp://127.0.0.1:99999"], 2, "--endpoint: bad endpoint 'tcp://127.0.0.1:99999'"),
    (["--launch", "no/such/game"], 1, "gave up: no game at no/such/game"),
    (["--generations", "0", "--launch", *CLIENT], 1, "gave up: no generation reached 195"),
]


def test_what_the_trainer_cannot_do_it_says_at_once():
    ended = python_runs(LESSON / "train.py", [words for words, _, _ in TRAINERS])
    for (words, code, text), run in zip(TRAINERS, ended, strict=True):
        assert run.code == code, (words, run)
        if "--plot" in words and not importlib.util.find_spec("matplotlib"):
            text = "--plot: it needs matplotlib: "
        assert text in run.lines[-1] and "Traceback" not in "".join(run.lines)


INTERRUPTED = """
import sys
class Interrupts:
    def find_spec(name, *_):
        if name == "numpy":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupts)
"""


def test_ctrl_c_while_a_program_imports_numpy_is_no_traceback():
    with InTurn([PYTHON, "-c", INTERRUPTED + EACH_RUN]) as run:
        for key in (KEY, "10_many_agents", "11_observations", "12_video"):
            for name, ended in (("server", (0, [])), ("client", (1, ["stopped"]))):
                assert run(ROOT / "python" / key / f"{name}.py") == ended, key


def test_chance_is_splitmix64_as_everybody_has_it():
    """Its first numbers from 0 are those of its authors' own program; a negative seed is its 64 bits."""
    first = [int(number * 2**53) for number in itertools.islice(draws(0), 3)]
    assert first == [bits >> 11 for bits in (0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F)]
    assert next(draws(-5)) == next(draws(2**64 - 5))


# Simulators of somebody else's


def test_a_space_that_nobody_plays_by_hand_does_not_end_the_server(serve, run, connect):
    server, endpoint = serve(KEY)
    odd = CartPole()
    odd.action = gymnasium.spaces.Discrete(3)
    connect(endpoint).send_multipart(SceneSimulator(Scene("CartPole", [odd])).hello().frames())
    server.wait_for("^trouble: no policy")
    assert run("python", KEY, "--endpoint", endpoint, "--count", "1").code == 0
    assert "Traceback" not in server.output


# The words of an environment, and the error that says what is wrong with them. TorchRL tries frameskip, and looks for
# Python's own words.
MISMADE: list[tuple[dict[str, Any], str]] = [
    (
        {"launch": "ball.py"},
        r"^launch cannot start \S*ball\.py: .+; a script needs its program: launch=\[sys\.executable, 'ball\.py'\]$",
    ),
    ({"launch": "Build/no game.exe"}, r"no game\.exe"),
    (
        {"launch": [str(PYTHON), "-S", "-c", "raise SystemExit(3)"], "wait": 1000},
        r"ended with code 3: in \S+, .*python.* --endpoint tcp\S+ shows why",
    ),
    (
        {"lunch": ["ball"]},
        r"^an environment got an unexpected keyword argument 'lunch'; where its simulator is, say endp",
    ),
    ({"update_seconds": 0.1, "agent_names": ["ball"]}, r"^an environment got .* 'update_seconds'; leave it out"),
]


def test_what_no_environment_can_be_made_of_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.py").write_text("print(1)\n", encoding="utf-8")
    for words, says in MISMADE:
        with pytest.raises(OSError if "launch" in words else TypeError, match=says):
            UnityGymEnv("Ball", **words)
