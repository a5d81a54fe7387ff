"""Lesson 09, what its users get wrong: options, actions, words of launch and of the trainer; scenes of their own."""

from __future__ import annotations

import importlib.util
import itertools

import pytest

from tests.conftest import PYTHON
from tests.programs import EACH_RUN, ROOT, InTurn, python_runs

gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")

KEY = "09_environment"
LESSON = ROOT / "python" / KEY
from netmq_example.envs import UnityGymEnv  # noqa: E402
from netmq_example.envs.connection import name_of  # noqa: E402
from netmq_example.scene import Scene, SceneSimulator  # noqa: E402
from netmq_example.wire import trees  # noqa: E402
from netmq_example.wire.records import Record  # noqa: E402
from netmq_example.wire.sections import seeds  # noqa: E402
from netmq_example.wire.split_mix import draws  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402
from tests.lessons.conftest import simulated  # noqa: E402

CLIENT = [str(PYTHON), str(LESSON / "client.py"), "--timeout", "30"]


# Options and actions

# What no message takes, tests of lesson 11 know.
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


def test_a_script_that_cannot_be_launched_is_named_with_its_cure(tmp_path):
    script = tmp_path / "ball.py"
    script.write_text("print(1)\n", encoding="utf-8")
    words = r"^launch cannot start \S+ball\.py: .+; a script needs its program: launch=\[sys\.executable, 'ball\.py'\]$"
    with pytest.raises(OSError, match=words):
        UnityGymEnv("Ball", launch=script)


def test_a_word_that_an_environment_does_not_know_is_named():
    """In Python's words: TorchRL tries frameskip, and looks for these."""
    with pytest.raises(
        TypeError, match=r"^an environment got an unexpected keyword argument 'lunch'; where its simulator is, say endp"
    ):
        UnityGymEnv("Ball", lunch=["ball"])
    with pytest.raises(TypeError, match=r"^an environment got .* 'update_seconds'; leave it out"):
        UnityGymEnv("Ball", update_seconds=0.1, agent_names=["ball"])
