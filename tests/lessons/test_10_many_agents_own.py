"""Lesson 10 for Stable-Baselines3: netmq_example.sb3, also where that is not installed."""

from __future__ import annotations

import importlib
import sys
import types
from typing import Any

import pytest

from tests.programs import ROOT

gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: kit.py run 10 installs it")
np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: kit.py run 10 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
from gymnasium import spaces  # noqa: E402

KEY = "10_many_agents"
from netmq_example.scene.areas import AreaSimulator  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402


@pytest.fixture(autouse=True)
def in_the_kits_folder(monkeypatch):
    monkeypatch.chdir(ROOT)


def areas_of(inside, world, count):
    """Where so many of them are found."""
    return inside(AreaSimulator([world() for _ in range(count)])).socket


class VecEnv:
    """As Stable-Baselines3 2.9 has it, around the methods of a class derived from it."""

    get_attr: Any
    step_async: Any
    step_wait: Any

    def __init__(self, num_envs, observation_space, action_space):
        self.num_envs, self.observation_space, self.action_space = num_envs, observation_space, action_space
        self._reset_seeds()
        assert set(self.get_attr("render_mode")) == {None}

    def _get_indices(self, indices):
        return range(self.num_envs) if indices is None else indices

    def _reset_seeds(self):
        self._seeds = [None] * self.num_envs

    def seed(self, seed):
        self._seeds = [seed + number for number in range(self.num_envs)]

    def set_options(self, options):
        self._options = options if isinstance(options, list) else [options] * self.num_envs

    def step(self, actions):
        self.step_async(actions)
        return self.step_wait()


@pytest.fixture
def bridge(monkeypatch):
    """netmq_example.sb3, where there is no Stable-Baselines3."""
    for name in ("", ".common", ".common.vec_env"):
        module = types.ModuleType(f"stable_baselines3{name}")
        monkeypatch.setitem(sys.modules, module.__name__, module)
        module.__dict__["VecEnv"] = VecEnv
    monkeypatch.delitem(sys.modules, "netmq_example.sb3", raising=False)
    yield importlib.import_module("netmq_example.sb3")
    sys.modules.pop("netmq_example.sb3", None)


def test_what_is_plain_for_stable_baselines3(bridge):
    """Spaces that its policies take stay as they are; whatever they choose of the others is in its space."""
    seen = spaces.Dict(
        place=spaces.Box(0, 1, (2,)),
        coins=spaces.Sequence(spaces.Box(1, 2, (2,))),
        last=spaces.Dict(push=spaces.Box(-1, 1, (1,)), says=spaces.Text(5)),
    )
    done = spaces.Dict(
        arm=spaces.Box(-4.6, 2.7, (1,)),
        small=spaces.Box(-128, 127, (2,), np.int8),
        open=spaces.Box(0, np.inf, (1,)),
        gear=spaces.Discrete(3, start=-1),
        keys=spaces.Tuple([spaces.MultiDiscrete([3, 2]), spaces.MultiBinary(2)]),
    )
    plain = bridge.Plain(seen, done)
    assert {*plain.observation_space} == {"place", "coins", "last_push"}
    for seed in range(5):
        seen.seed(seed)
        assert plain.look(seen.sample()) in plain.observation_space
    ends = [plain.choose(np.full(plain.numbers, end)) for end in (-1, 1)]
    assert [end["arm"][0] for end in ends] == [np.float32(-4.6), np.float32(2.7)]
    assert [end["small"].tolist() for end in ends] == [[-128, -128], [127, 127]]
    for action in [
        *ends,
        *(plain.choose(3 * number) for number in np.random.default_rng(1).normal(size=(99, plain.numbers))),
    ]:
        assert action in done
    for space in (spaces.Box(0, 1, (2,)), spaces.MultiDiscrete([3, 3]), spaces.Discrete(3)):
        assert bridge.Plain(spaces.Dict(a=space), space).action_space is space
    with pytest.raises(ValueError, match="no policy of Stable-Baselines3 does what is in Text"):
        bridge.Plain(seen, spaces.Dict(a=spaces.Text(3)))


def test_the_bridge_to_stable_baselines3(inside, bridge):
    """Beside the environment that it wraps. An end by the world and one by time are told apart."""
    words = {"autoreset_mode": "SameStep", "max_episode_steps": 12}
    plain, wrapped = (
        gymnasium.make_vec("NetMQExample/CartPole-v0", 4, socket=areas_of(inside, CartPole, 4), **words)
        for _ in range(2)
    )
    areas = bridge.Areas(wrapped)
    areas.seed(7)
    assert np.array_equal(areas.reset(), plain.reset(seed=[7, 8, 9, 10])[0])
    ends = set()
    for step in range(60):
        # Two are pushed over, and two are kept up until their time is over.
        actions = np.array([1, 0, step % 2, step % 2], np.int32)
        seen, rewards, over, said = areas.step(actions)
        theirs, gains, terminated, truncated, infos = plain.step(actions)
        assert np.array_equal(seen, theirs) and np.array_equal(over, terminated | truncated)
        assert np.array_equal(rewards, gains) and rewards.dtype == np.float32
        for area in range(4):
            assert ("terminal_observation" in said[area]) == over[area]
            if over[area]:
                assert np.array_equal(said[area]["terminal_observation"], infos["final_obs"][area])
                assert said[area]["TimeLimit.truncated"] == truncated[area] != terminated[area]
                ends.add(said[area]["TimeLimit.truncated"])
    assert ends == {True, False}
    # An area that was lost while the others began anew: nobody knows what it would have seen.
    wrapped.reset = lambda seed, options: (np.ones((4, 4)), {})
    wrapped.step = lambda actions: (np.zeros((4, 4)), np.zeros(4), np.zeros(4, bool), np.arange(4) == 2, {})
    areas.reset()
    assert areas.reset_infos == [{}] * 4
    *_, said = areas.step(actions)
    assert np.array_equal(said[2].pop("terminal_observation"), np.ones(4))
    assert said == [{}, {}, {"TimeLimit.truncated": True}, {}]
    # The world's infos of each arrive, also with its last step.
    infos = {"metres": np.array([1.5, 0, 0, 0]), "_metres": np.arange(4) == 0, "_final_info": np.arange(4) == 2}
    infos |= {"seed": np.arange(4), "_seed": np.arange(4) == 2}
    infos["final_info"] = {"lost": np.array(["", "", "why", ""], object), "_lost": np.arange(4) == 2}
    wrapped.step = lambda actions: (np.zeros((4, 4)), np.zeros(4), np.zeros(4, bool), np.arange(4) == 2, infos)
    *_, said = areas.step(actions)
    assert said[0] == {"metres": 1.5} and said[2]["lost"] == "why" and said[1] == said[3] == {}
    assert areas.reset_infos == [{}, {}, {"seed": 2}, {}], "of the episode that has begun"
    areas.close()
    plain.close()


def test_options_for_stable_baselines3_are_for_one_reset(inside, bridge):
    socket = areas_of(inside, CartPole, 2)
    areas = bridge.Areas(gymnasium.make_vec("NetMQExample/CartPole-v0", 2, socket=socket, autoreset_mode="SameStep"))
    begun = [{"state": np.full(4, 0.01 * number)} for number in (1, 2)]
    areas.set_options([begun[0], {"state": np.full(4, 0.01)}])
    assert np.array_equal(areas.reset(), np.full((2, 4), 0.01, np.float32))
    assert not np.array_equal(areas.reset(), np.full((2, 4), 0.01, np.float32))
    areas.set_options(begun)
    with pytest.raises(ValueError, match="the areas are one simulator: set_options takes one dict for all of them"):
        areas.reset()
    areas.close()
