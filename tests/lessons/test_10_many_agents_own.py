"""Lesson 10, worlds of one's own: those of the pages, as they stand there, and the same game in Python. Robots of a
page look for a ball by sixteen cameras, and a rule drives them by their pictures alone.
"""

from __future__ import annotations

import importlib
import re
import sys
import types
from pathlib import Path
from typing import Any, ClassVar

import pytest

from kitlib.docs import guide
from tests.conftest import PYTHON
from tests.programs import ROOT, elsewhere, steady_endpoint

gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: kit.py run 10 installs it")
np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: kit.py run 10 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
from gymnasium import spaces  # noqa: E402
from gymnasium.spaces import Box, Discrete  # noqa: E402
from gymnasium.utils.env_checker import data_equivalence  # noqa: E402

KEY = "10_many_agents"
from netmq_example.envs import ZmqParallelEnv, ZmqVectorEnv  # noqa: E402
from netmq_example.scene.agents import AgentSimulator  # noqa: E402
from netmq_example.scene.areas import AreaSimulator  # noqa: E402
from netmq_example.scene.simulation import AgentSimulation  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402


@pytest.fixture(autouse=True)
def in_the_kits_folder(monkeypatch):
    monkeypatch.chdir(ROOT)


def of_the_page(language, word, key=KEY):
    """The page's block in this language in which the word stands."""
    blocks = guide.blocks(ROOT / "docs" / "guide" / f"{key}.md")
    (body,) = [block.body for block in blocks if (block.language, word in block.body) == (language, True)]
    return body


# Each agent sees its own place and the other's, and moves left, not at all, or right.
SPACES = Box(-5, 5, (2,), np.float32), Discrete(3)


class Tag(AgentSimulation):
    """A cat and a mouse on a line of ten metres, as the page has it in C#."""

    name, dt = "Tag", 0.1
    agents: ClassVar = {"cat": SPACES, "mouse": SPACES}

    def reset(self, rng, options):
        self.place, self.steps = {"cat": -5, "mouse": 5 * next(rng)}, 0

    def apply(self, actions):
        self.steps += 1
        for agent, action in actions.items():
            speed = 3 if agent == "cat" else 2
            self.place[agent] = min(5, max(-5, self.place[agent] + (action - 1) * speed * self.dt))

    def observe(self, agent):
        return [self.place[agent], self.place["mouse" if agent == "cat" else "cat"]]

    def reward_and_end(self, agent):
        caught = abs(self.place["cat"] - self.place["mouse"]) < 0.3
        reward = 0 if not caught else 1 if agent == "cat" else -1
        return {"reward": reward, "terminated": caught, "truncated": self.steps == 100}


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


def test_the_pages_world_is_the_same_in_both_languages(netmq, console, start, inside, tmp_path):
    """Two games, one of them to its end."""
    (tmp_path / "Tag.cs").write_text(of_the_page("csharp", "class Tag"), encoding="utf-8")
    endpoint = steady_endpoint()
    words = ["--endpoint", endpoint, "--timeout", "200"]
    player = start(PYTHON, ROOT / "kit.py", "play", tmp_path / "Tag.cs", *words)
    here = inside(AgentSimulator(Tag())).socket
    envs = [ZmqParallelEnv("Tag", **where) for where in ({"socket": here}, {"endpoint": endpoint, "wait": 500})]
    random = np.random.default_rng(1)
    try:
        for name in envs[0].possible_agents:
            assert envs[0].observation_space(name) == envs[1].observation_space(name)
        for seed, cat in ((1, None), (2, 2)):
            assert data_equivalence(*(env.reset(seed=seed) for env in envs))
            while envs[0].agents:
                actions = {"cat": cat or random.integers(3), "mouse": random.integers(3)}
                assert data_equivalence(*(env.step(actions) for env in envs))
            assert envs[1].agents == []
    finally:
        for env in envs:
            env.close()
    assert player.wait() == 0, player.output


@pytest.fixture
def registered():
    """My/Ball-v0, as the page does it."""
    exec(of_the_page("python", "My/Ball-v0"), {"gymnasium": gymnasium})
    yield
    del gymnasium.registry["My/Ball-v0"]


def test_areas_of_a_world_of_ones_own_are_registered_as_the_page_does_it(registered, inside):
    class Ball(CartPole):
        name = "Ball"

    envs = gymnasium.make_vec("My/Ball-v0", num_envs=16, socket=areas_of(inside, Ball, 16))
    assert envs.reset(seed=1)[0].shape == (16, 4)
    envs.close()


def test_the_pages_areas_make_themselves_and_the_one_beside_them_is_none(netmq, console, start, tmp_path):
    """16, not 17, and only they connect; when Python is done the player ends, which has no --endpoint for that."""
    words = []
    for name in ("Hover", "HoverAreas"):
        words.append(tmp_path / f"{name}.cs")
        words[-1].write_text(of_the_page("csharp", f"class {name} :", "reinforcement_learning"), encoding="utf-8")
    endpoint = steady_endpoint()
    player = start(PYTHON, ROOT / "kit.py", "play", *words, "--set", f"endpoint={endpoint}")
    envs = ZmqVectorEnv(16, "Hover", endpoint=endpoint, wait=500, max_episode_steps=3)
    try:
        envs.reset(seed=1)
        assert [envs.step(np.zeros((16, 1), np.float32))[3].all() for _ in range(3)] == [False, False, True]
    finally:
        envs.close()
    assert player.wait() == 0, player.output
    assert player.output.count("asking ") == 1, player.output


def test_robots_find_what_they_see(start, netmq, tmp_path):
    pytest.importorskip("PIL", reason="the robots see pictures: kit.py run 12 installs Pillow")
    page = (ROOT / "docs" / "guide" / f"{KEY}.md").read_text(encoding="utf-8")
    # The areas of the drones, changed as the page says.
    (line,) = re.findall("^`(area.*;)`$", page, re.MULTILINE)
    areas = of_the_page("csharp", "class HoverAreas :", "reinforcement_learning").replace("Hover", "Seeker")
    areas = areas.replace("SetParent(transform);", f"SetParent(transform);\n{line}")
    (tmp_path / "SeekerAreas.cs").write_text(areas, encoding="utf-8")
    (tmp_path / "Seeker.cs").write_text(of_the_page("csharp", "class Seeker "), encoding="utf-8")
    script = Path(__file__).with_name("seek.py").read_text(encoding="utf-8")
    (tmp_path / "seek.py").write_text(elsewhere(script), encoding="utf-8")
    seek = start(PYTHON, "seek.py", folder=tmp_path)
    assert seek.wait(200) == 0, seek.output
    assert "50 balls were found" in seek.lines
    assert (tmp_path / "sixteen.gif").read_bytes()[:6] == b"GIF89a"
