"""Libraries copy and pickle the environments of lessons 09, 10 and 11, ask for all that Gymnasium's and PettingZoo's
own have, and end in whatever way, after which no simulator may be left.
"""

from __future__ import annotations

import copy
import pickle
import signal
import sys
import time

import pytest

from tests.conftest import CLIENTS, PYTHON
from tests.programs import LIMIT, ROOT, Mark, finds_processes

gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
from gymnasium.utils.env_checker import data_equivalence  # noqa: E402
from gymnasium.vector import SyncVectorEnv, VectorEnv  # noqa: E402
from pettingzoo import AECEnv, ParallelEnv  # noqa: E402

sys.path.append(str(ROOT / "python" / "11_observations"))
from collector import ACTION, seen_space  # noqa: E402

from netmq_example import envs  # noqa: E402
from netmq_example.scene.simulator import Simulator  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402

ID = "NetMQExample/CartPole-v0"
posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals")
# Lesson 11's scene, with as many cars as its words say.
SCENE = f"""
import sys
sys.path.append({str(ROOT / "python")!r})
from netmq_example.scene.scene import SceneSimulator
from netmq_example.scene.simulator import EnvironmentClient
from netmq_example.worlds.coin_car import CoinCar
*names, _, endpoint = sys.argv[1:]
EnvironmentClient(endpoint, timeout=60).run(SceneSimulator("Coins", 0.1, [CoinCar(name) for name in names]))
"""
SEEN = seen_space(False)
BOTH = {"observation_space": SEEN, "action_space": ACTION}
CARS = ("agent_0", "agent_1")
EACH = {"observation_spaces": dict.fromkeys(CARS, SEEN), "action_spaces": dict.fromkeys(CARS, ACTION)}
# Of each class the lesson whose client it launches, with its words; or those of a scene; and what it is made of.
MADE = {
    "ZmqEnv": (["09_environment"], {"name": "CartPole"}),
    "ZmqVectorEnv": (
        ["10_many_agents", "--world", "CartPole", "--areas", "3"],
        {"num_envs": 3, "name": "CartPole", "max_episode_steps": 9},
    ),
    "ZmqParallelEnv": (["10_many_agents"], {"name": "Pursuit"}),
    "UnityGymEnv": (["11_observations"], {"env_name": "Coins", **BOTH}),
    "UnityVectorEnv": (CARS, {"num_envs": 2, "env_name": "Coins", **BOTH}),
    "UnityParallelEnv": (CARS, {"env_name": "Coins", **EACH}),
    "UnityAECEnv": (CARS, {"env_name": "Coins", **EACH}),
}
WAYS = [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))]
each_class = pytest.mark.parametrize("name", MADE)


@pytest.fixture
def mark(monkeypatch):
    """It finds what this test launches, or would."""
    mark = Mark()
    monkeypatch.setenv("KIT_TEST_MARK", mark.environment["KIT_TEST_MARK"])
    return mark


@pytest.fixture
def made(make, tmp_path):
    """made("ZmqEnv"): one with a simulator of its own."""
    (tmp_path / "scene.py").write_text(SCENE, encoding="utf-8")

    def made(name):
        (first, *more), words = MADE[name]
        program = ROOT / "python" / first / "client.py"
        launch = [program, *more, "--timeout", "60"] if program.exists() else [tmp_path / "scene.py", first, *more]
        return make(getattr(envs, name), **words, launch=[PYTHON, *launch])

    return made


def simulators(mark):
    # The first is the time that one takes which was asked to end.
    return [pid for pid, command in mark.processes().items() if "--endpoint" in command]


def becomes(count, mark):
    end = time.monotonic() + LIMIT
    while len(simulators(mark)) != count and time.monotonic() < end:
        time.sleep(0.05)
    return len(simulators(mark)) == count


def action(env, agent=None):
    """Always the same for the same agent."""
    space = env.action_space if agent is None else env.action_space(agent)
    space.seed(1)
    return space.sample()


def step(env):
    if isinstance(env, AECEnv):
        agent = env.agent_selection
        env.step(action(env, agent))
        return agent, env.observe(agent), env.rewards
    if isinstance(env, ParallelEnv):
        return env.step({agent: action(env, agent) for agent in env.agents})
    return env.step(action(env))


def played(env):
    return [env.reset(seed=3), *(step(env) for _ in range(5))]


@finds_processes
@pytest.mark.parametrize("way", WAYS)
@each_class
def test_a_copy_is_an_environment_of_its_own(name, way, made, make, mark):
    env = made(name)
    first = played(env)
    other = make(way, env)
    assert type(other) is type(env) and len(simulators(mark)) == 2
    assert data_equivalence(played(other), first, exact=True)
    # And it goes on where it was, as if there had been no other.
    again = step(env)
    assert data_equivalence(again, step(other), exact=True)
    other.close()
    assert becomes(1, mark)
    assert data_equivalence(played(env), first, exact=True)
    env.close()
    assert becomes(0, mark)


@finds_processes
def test_a_copy_of_what_make_returns_is_as_it_was_made(launch, mark):
    """With its wrappers, and its spec, by which libraries make more of them."""
    env = gymnasium.make(ID, launch=launch("python"), max_episode_steps=2)
    for way in WAYS:
        other = way(env)
        assert other.spec == env.spec and other.unwrapped.spec == env.unwrapped.spec
        other.reset(seed=1)
        assert [other.step(0)[3] for _ in range(2)] == [False, True]
        more = gymnasium.make(other.spec)
        more.reset()
        assert len(simulators(mark)) == 3
        more.close()
        other.close()
        assert becomes(1, mark)
    env.close()


def test_one_with_a_given_socket_refuses_a_copy(inside):
    env = envs.ZmqEnv("CartPole", socket=inside(Simulator(CartPole())).socket)
    env.reset(seed=1)
    for way in WAYS:
        with pytest.raises(TypeError) as refused:
            way(env)
        assert str(refused.value) == "ZmqEnv has a socket that it was given: no second one can have it as well"
    assert env.step(0)[4] == {}
    env.close()


class Least(gymnasium.Env):  # type: ignore[name-defined]
    """Has what every environment has."""

    observation_space, action_space = gymnasium.spaces.Discrete(2), gymnasium.spaces.Discrete(2)


def public(kind, *others):
    """All names that they have, or are declared to have."""
    names = {name for one in kind.__mro__ for name in vars(one).get("__annotations__", ())}
    return {name for name in names.union(dir(kind), *map(dir, others)) if not name.startswith("_")}


# Of SyncVectorEnv: what it makes its environments of, and how it keeps them.
OWN = {"copy", "env_fns", "envs"}


@pytest.mark.filterwarnings("ignore:.*dictionary is deprecated")
@each_class
def test_it_has_what_gymnasiums_and_pettingzoos_own_have(name, made):
    env = made(name)
    if isinstance(env, VectorEnv):
        needed = public(SyncVectorEnv, SyncVectorEnv([Least])) - OWN
    elif isinstance(env, gymnasium.Env):
        needed = public(Least, Least())
    else:
        needed = public(AECEnv if isinstance(env, AECEnv) else ParallelEnv)
    # Before that PettingZoo's own have not all of them.
    env.reset()
    assert sorted(one for one in needed if not hasattr(env, one)) == []


# The end of a script


SCRIPT = """
import os, sys, time
sys.path.append({path!r})
import gymnasium, netmq_example.envs
if __name__ == "__main__":
    many, how, *launch = sys.argv[1:]
    if many == "async":
        env = gymnasium.make_vec({id!r}, 2, vectorization_mode="async", launch=launch)
    else:
        env = gymnasium.make({id!r}, launch=launch)
    env.reset()
    env.step(env.action_space.sample())
    print("ready", flush=True)
    if how == "exit":
        os._exit(3)
    if how == "raise":
        raise ValueError("it is over")
    if how != "end":
        time.sleep(1000)
"""
ENDS = {
    "end": None,
    "raise": None,
    "exit": None,
    "terminated": signal.SIGTERM,
    "interrupted": signal.SIGINT,
    "killed": getattr(signal, "SIGKILL", None),
}


@posix
@finds_processes
@pytest.mark.parametrize("many", ["single", "async"])
@pytest.mark.parametrize("kind", CLIENTS)
def test_no_simulator_is_left_however_a_script_ends(kind, many, start, launch, tmp_path):
    """They would wait for ten minutes, if nobody ended them."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.format(path=str(ROOT / "python"), id=ID), encoding="utf-8")
    words = launch(kind, "--timeout", "600")
    # All at once: it takes long to start each of them.
    scripts = {}
    for how in ENDS:
        mark = Mark()
        scripts[how] = mark, start(PYTHON, script, many, how, *words, **mark.environment)
    for how, (mark, program) in scripts.items():
        program.wait_for("^ready")
        # A script that ends at once may be gone by now.
        if ENDS[how]:
            assert len(simulators(mark)) == (2 if many == "async" else 1)
            program.process.send_signal(ENDS[how])
    for how, (mark, program) in scripts.items():
        program.wait()
        assert becomes(0, mark), (how, mark.processes())
