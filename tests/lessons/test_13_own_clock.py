"""A scene by its own clock, as ML-Agents' are, behind the classes for Gymnasium, PettingZoo and Stable-Baselines3."""

import os

import pytest

from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT

pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from netmq_example.envs import UnityGymEnv, UnityVectorEnv, carry
from netmq_example.messages import MessageError
from netmq_example.mlagents_envs.side_channel import EnvironmentParametersChannel, SideChannelManager
from netmq_example.mlagents_envs.unity_channels import EnvironmentParameters
from tests.lessons.scene_clock import Arena, ArenaSimulator, Walker


@pytest.fixture
def world(served):
    """world(make, *walkers, **words): an environment of `make`, and its scene, which goes by its own clock."""
    made = []

    def connect(make, *walkers, channels=None, **words):
        arena = Arena(*walkers)
        endpoint = f"tcp://127.0.0.1:{served(ArenaSimulator(arena, channels))}"
        made.append(make(env_name="Arena", endpoint=endpoint, wait=LIMIT, **words))
        return made[-1], arena

    yield connect
    for env in made:
        env.close()


@pytest.mark.parametrize("interrupted", [False, True])
def test_a_step_is_one_decision_and_an_end_comes_at_once(interrupted, world):
    env, arena = world(UnityGymEnv, Walker("Ball", period=5, length=12, interrupted=interrupted))
    check_env(env, skip_render_check=True, skip_close_check=True)
    assert env.observation_space.shape == (4,) and env.action_space.shape == (2,) and env.agent_name == "Ball"
    env.reset()
    steps = [env.step(np.array([0.5, -2], np.float32)) for _ in range(3)]
    assert [(seen[1], *rest) for seen, *rest, _ in steps] == [
        (5, 5, False, False),
        (10, 5, False, False),
        (12, 2, not interrupted, interrupted),
    ]
    assert arena.walkers[0].done[-1] == ((0.5, -2.0), ())
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(env.action_space.sample())
    # As ML-Agents' own wrapper: its episode has begun already, and begins once more.
    before = len(arena.resets)
    with pytest.warns(UserWarning, match="options of a reset do not reach"):
        env.reset(seed=3, options={"level": 2})
    assert arena.resets[0] == {"seed": 0} and arena.resets[before:] == [{}]


def ends(results):
    seen, rewards, terminated, truncated, _ = results
    return seen[:, :2].tolist(), rewards.tolist(), (terminated | truncated).tolist()


def test_many_agents_begin_anew_in_each_way(world):
    def two():
        return Walker("Ball", period=2, length=3), Walker("Ball", period=2, length=5)

    actions = np.zeros((2, 2), np.float32)
    envs, _ = world(UnityVectorEnv, *two(), num_envs=2)
    seen, _ = envs.reset()
    assert seen[:, :2].tolist() == [[0, 0], [1, 0]] and envs.kind.agents == ("Ball_0", "Ball_1")
    assert ends(envs.step(actions)) == ([[0, 2], [1, 2]], [2, 2], [False, False])
    assert ends(envs.step(actions)) == ([[0, 3], [1, 4]], [1, 2], [True, False])
    # The first has begun by itself, and has had a whole episode since.
    assert ends(envs.step(actions)) == ([[0, 0], [1, 5]], [0, 1], [False, True])
    envs, _ = world(UnityVectorEnv, Walker("Ball", length=2), Walker("Ball"), num_envs=2)
    envs.reset()
    assert [ends(envs.step(actions))[1] for _ in range(3)][1:] == [[1, 1], [0, 1]], "a step that begins has no reward"
    envs, _ = world(UnityVectorEnv, *two(), num_envs=2, autoreset_mode=AutoresetMode.SAME_STEP)
    envs.reset()
    envs.step(actions)
    results = envs.step(actions)
    assert ends(results) == ([[0, 1], [1, 4]], [1, 2], [True, False])
    assert results[4]["final_obs"][0][:2].tolist() == [0, 3] and results[4]["final_obs"][1] is None
    envs, _ = world(UnityVectorEnv, *two(), num_envs=2, autoreset_mode=AutoresetMode.DISABLED)
    envs.reset()
    envs.step(actions)
    with pytest.raises(MessageError, match="begins anew with all others"):
        envs.reset(options={"reset_mask": np.array([False, True])})
    envs.reset()
    envs.step(actions)
    envs.step(actions)
    seen, _ = envs.reset(options={"reset_mask": np.array([True, False])})
    assert seen[:, :2].tolist() == [[0, 1], [1, 4]]


def test_pettingzoo_takes_them(world):
    pytest.importorskip("pettingzoo", reason="needs pettingzoo: pip install pettingzoo")
    from pettingzoo.test import api_test, parallel_api_test

    from netmq_example.envs import UnityAECEnv, UnityParallelEnv

    both, arena = world(UnityParallelEnv, Walker("Ball", length=4), Walker("Goal", team=1, length=7))
    assert both.possible_agents == ["Ball", "Goal?team=1"]
    with pytest.warns(UserWarning, match="options"):
        parallel_api_test(both, 50)
    both.reset()
    for _ in range(4):
        both.step({agent: np.full(2, 0.5, np.float32) for agent in both.agents})
    assert both.agents == ["Goal?team=1"]
    both.step({"Goal?team=1": np.ones(2, np.float32)})
    assert [one.done[-1] for one in arena.walkers] == [((0, 0), ()), ((1, 1), ())], "of those that are over, zeros"
    turns, _ = world(UnityAECEnv, Walker("Ball", length=4), Walker("Ball", length=7))
    api_test(turns, 20)


def test_stable_baselines3_learns_from_them(world):
    pytest.importorskip("stable_baselines3", reason="needs stable-baselines3: pip install stable-baselines3")
    from stable_baselines3 import PPO

    from netmq_example.sb3 import UnityVecEnv

    def make(**words):
        return UnityVecEnv("NetMQExample/Unity-v0", 2, **words)

    envs, arena = world(make, Walker("Ball", length=5), Walker("Ball", length=7, interrupted=True))
    PPO("MlpPolicy", envs, n_steps=16, batch_size=8, n_epochs=1).learn(32)
    assert len(arena.walkers[0].done) == 16
    envs.reset()
    for _ in range(7):
        _, _, over, infos = envs.step(np.zeros((2, 2), np.float32))
    assert over.tolist() == [False, True] and infos[1]["TimeLimit.truncated"]
    assert infos[1]["terminal_observation"][1] == 7


def test_masks_pictures_and_mixed_actions(world):
    walker = Walker("Ball", floats=1, branches=(3, 2), forbidden=(1,), picture=True)
    env, _ = world(UnityGymEnv, walker)
    seen, info = env.reset()
    assert [*seen] == ["VectorSensor_size4", "Eye"] and seen in env.observation_space
    assert seen["Eye"].ravel().tolist() == [0, 51, 102, 153, 204, 255]
    assert [mask.tolist() for mask in info["action_mask"]] == [[1, 0, 1], [1, 1]]
    assert env.action_space.sample(mask=(None, info["action_mask"])) in env.action_space
    env.step((np.array([0.5], np.float32), np.array([2, 1])))
    assert walker.done == [((0.5,), (2, 1))]
    env, _ = world(UnityGymEnv, Walker("Ball", floats=0, branches=(3,)))
    assert "action_mask" not in env.reset()[1] and env.action_space == gymnasium.spaces.Discrete(3)
    assert env.step(2)[0][3] == 2


def test_an_agent_that_leaves_is_cut_and_another_one_takes_its_place(world):
    words = {"num_envs": 2, "autoreset_mode": AutoresetMode.SAME_STEP}
    envs, arena = world(UnityVectorEnv, Walker("Ball"), Walker("Ball", leaves=2), Walker("Ball", comes=4), **words)
    envs.reset()
    actions = np.ones((2, 2), np.float32)
    trace = []
    for _ in range(5):
        seen, rewards, terminated, _, _ = envs.step(actions)
        trace.append((seen[:, :2].tolist(), rewards.tolist(), terminated.tolist()))
    assert trace[1] == ([[0, 2], [1, 1]], [1, 1], [False, True])
    assert trace[2][1:] == ([1, 0], [False, False])
    assert trace[4][0] == [[0, 5], [2, 1]] and arena.walkers[2].done == [((1, 1), ())]


REFUSED = {
    "the agents of 'Ball' do not all decide at the same time": (Walker("Ball"), Walker("Ball", period=2)),
    "the agents of 'Goal' do not all decide .*, or have come later": (Walker("Ball"), Walker("Goal", comes=2)),
}


@pytest.mark.parametrize("why", REFUSED)
def test_agents_that_decide_at_different_times_are_refused_in_one_line(why, world):
    env, _ = world(UnityVectorEnv, *REFUSED[why], num_envs=2 - ("Goal" in why), agent_name="Ball")
    env.reset()
    with pytest.raises(MessageError, match=f"^scene-clock: {why}.*: take UnityEnvironment of ") as caught:
        for _ in range(3):
            env.step(env.action_space.sample())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("words", [{"real_time": True}, {"max_episode_steps": 1}])
def test_what_is_pythons_alone_is_refused(words, world):
    envs, _ = world(UnityVectorEnv, Walker("Ball"), num_envs=1, **words)
    with pytest.raises(MessageError, match=r"^scene-clock: real_time and max_episode_steps are for Python's clock"):
        for _ in range(2):
            envs.reset()
            envs.step(envs.action_space.sample())


def test_it_has_no_infos_and_no_pictures(world):
    env, _ = world(UnityGymEnv, Walker("Ball"), render_mode="rgb_array")
    env.reset()
    for call, word in ((lambda: env.send_info("fast"), "info"), (env.render, "render")):
        with pytest.raises(MessageError, match=f"a scene of this clock knows no {word}$"):
            call()


def test_side_channels_go_with_the_decisions(world):
    parameters, settings = EnvironmentParameters(), EnvironmentParametersChannel()
    env, _ = world(UnityGymEnv, Walker("Ball", period=3, length=4), channels=SideChannelManager([parameters]))
    carry(env, SideChannelManager([settings]))
    env.reset()
    for gravity in (1.5, 2.5):
        settings.set_float_parameter("gravity", gravity)
        env.step(env.action_space.sample())
        assert parameters.get_with_default("gravity", 0) == gravity


def test_another_simulator_begins_with_the_same_agents(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", f"{ROOT}:{ROOT / 'python'}".replace(":", os.pathsep))
    words = [str(PYTHON), "-m", "tests.lessons.scene_clock"]
    env = UnityGymEnv("Arena", launch=words, agent_name="Ball_1", wait=LIMIT, timeout=LIMIT)
    try:
        env.reset()
        env.simulators.process.kill()
        env.simulators.process.wait()
        *_, truncated, info = env.step(env.action_space.sample())
        assert truncated and "is gone" in info["lost"]
        assert env.reset()[0].tolist()[:2] == [1, 0]
        assert env.step(env.action_space.sample())[0].tolist()[:2] == [1, 1]
    finally:
        env.close()
