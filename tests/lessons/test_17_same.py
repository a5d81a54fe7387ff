"""Lesson 17: over a hub everything is the same as without one, to the last bit, whichever simulators die meanwhile.

The hub, its simulators and the trainer's socket are in this process, without a network.
"""

from __future__ import annotations

import functools
from collections import deque
from typing import Annotated, Any

import pytest

gymnasium = pytest.importorskip("gymnasium", reason="lesson 17 needs gymnasium: kit.py run 17 installs it")
np = pytest.importorskip("numpy", reason="lesson 17 needs numpy: kit.py run 17 installs it")

from gymnasium.utils.env_checker import data_equivalence  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402

import netmq_example.envs  # noqa: E402
from netmq_example.envs.common import OtherSide  # noqa: E402
from netmq_example.envs.side_channels import carry  # noqa: E402
from netmq_example.fleet.simulator import FleetSimulator  # noqa: E402
from netmq_example.messages import Message, MessageError  # noqa: E402
from netmq_example.mlagents_envs.side_channel import (  # noqa: E402
    EnvironmentParametersChannel,
    SideChannelManager,
    StatsSideChannel,
)
from netmq_example.mlagents_envs.unity_channels import EnvironmentParameters, StatsRecorder  # noqa: E402
from netmq_example.scene import Agent, Obs, Scene, SceneSimulator, SideChannelSimulator  # noqa: E402
from netmq_example.wire import records  # noqa: E402
from netmq_example.worlds.cart_pole import DT, CartPole  # noqa: E402
from netmq_example.worlds.pursuit import Pursuit  # noqa: E402
from tests.lessons.fleets import Hall  # noqa: E402
from tests.lessons.vectors import alike, play  # noqa: E402


class Fleet(Hall, OtherSide):
    """A hub's socket and a trainer's at once. At these requests a simulator dies, and another one comes."""

    def __init__(self, monkeypatch, make, areas, deaths=()):
        super().__init__(monkeypatch)
        self.make, self.deaths, self.asked, self.came = make, deaths, 0, 0
        self.simulators, self.unanswered = {}, deque()
        for _ in range(areas + bool(deaths)):
            self.come()
        self.say(b"trainer", Message("join", 0, {"name": self.simulators[b"1"].name, "areas": areas}))

    def come(self):
        self.came += 1
        peer = b"%d" % self.came
        self.simulators[peer] = FleetSimulator(self.make())
        self.say(peer, self.simulators[peer].hello())

    def send_multipart(self, frames, flags=0):
        peer, *message = frames
        if peer == b"hub":
            self.hub.take(b"trainer", message)
        elif peer in self.simulators:
            self.unanswered.append((peer, message))
        else:
            super().send_multipart(frames)

    def recv_multipart(self):
        while not self.said[b"trainer"]:
            if not self.unanswered:
                self.wait()
                continue
            peer, message = self.unanswered.popleft()
            request = records.read_frames(records.ASKS, message)
            if request.kind == records.ASKS or request.kind in ("render", "info"):
                self.asked += 1
                if self.asked in self.deaths:
                    del self.simulators[peer]
                    self.hub.lose(peer, "told")
                    self.come()
                else:
                    self.hub.take(peer, self.simulators[peer].answer(request))
        return [b"hub", *self.said[b"trainer"].pop(0).frames()]

    def getsockopt_string(self, option):
        return "tcp://127.0.0.1:5567"


@pytest.fixture
def fleet(monkeypatch):
    return functools.partial(Fleet, monkeypatch)


class Walker(Agent):
    """By attributes, and with infos."""

    name = "walker"
    place: Annotated[Any, Obs()] = np.zeros(2)
    steps: Annotated[int, Obs("['walked'] = $")] = 0
    said: Annotated[str, Obs()] = ""

    def on_reset(self):
        self.steps, self.last = 0, 3 + int(9 * self.rng())
        self.place = np.array([self.rng(), self.options.get("far", 0.0)])
        self.said = "begun" * int(3 * self.rng())
        if self.last > 6:
            self.info = {"last": self.last}

    def on_action(self, action):
        self.place = self.place + action
        self.said = "on"

    def on_tick(self, dt):
        self.steps += 1

    def on_stepped(self):
        self.reward += float(self.place[0])
        self.terminated = self.steps == self.last
        if self.terminated:
            self.info = {"at": self.place, "after": 0.1 * self.steps}

    def on_info(self, info):
        self.place = self.place + info


SPACES = {
    "observation_space": gymnasium.spaces.Dict(
        place=gymnasium.spaces.Box(-99, 99, (2,), np.float64),
        walked=gymnasium.spaces.Discrete(100),
        said=gymnasium.spaces.Text(20, min_length=0),
    ),
    "action_space": gymnasium.spaces.Box(-1, 1, (2,), np.float64),
}


def walk(*agents):
    return SceneSimulator(Scene("Walk", agents or [Walker()], 0.1))


def poles(*agents):
    return SceneSimulator(Scene("CartPole", agents or [CartPole()], DT))


WORLDS = {
    "poles": (poles, CartPole, {"env_name": "CartPole", "render_mode": "rgb_array"}),
    "walkers": (walk, Walker, {"env_name": "Walk", **SPACES}),
}


@pytest.mark.parametrize("deaths", [(), range(23, 9999, 23)])
@pytest.mark.parametrize("mode", AutoresetMode)
@pytest.mark.parametrize("world", WORLDS)
def test_scenes_of_a_hub_are_to_python_what_the_agents_of_one_scene_are(world, mode, deaths, fleet, inside, make):
    simulator, agent, words = WORLDS[world]
    words = {**words, "autoreset_mode": mode, "max_episode_steps": 9}
    fleet = fleet(simulator, 3, deaths)
    where = {"fleet": fleet}, {"socket": inside(simulator(agent(), agent(), agent())).socket}
    both = [make(netmq_example.envs.UnityVectorEnv, 3, **words, **each) for each in where]
    options = {"far": 2.5} if world == "walkers" else {"low": -0.2, "high": 0.2}
    both[0].action_space.seed(4)

    def act(seen, step):
        assert data_equivalence(*(list(envs.infos) for envs in both), exact=True)
        if world == "poles" and step % 8 == 0:
            assert data_equivalence(*(envs.render() for envs in both), exact=True)
        elif step % 8 == 0:
            for envs in both:
                envs.send_info(np.ones(2), "walker_1")
                envs.send_info(0.5, f"walker_{step % 3}")
        return both[0].action_space.sample()

    ends = play(both, act, 40, {"seed": [3, 8, 4], "options": options})
    assert ends.sum(0).min() >= 3
    assert not deaths or fleet.hub.count["begun anew"] > 3
    assert not [line for line in fleet.lines if "goes another way" in line]
    if world == "poles":
        for envs in both:
            with pytest.raises(MessageError, match="bad-state"):
                envs.reset(options={"state": np.zeros(3)})
        # It goes on after that.
        alike(both, "reset", options={"state": np.array([0.1, 0, 0, 0])})


@pytest.mark.parametrize("deaths", [(), (30, 99, 180)])
def test_a_scene_of_several_kinds_is_one_episode_of_a_hub(deaths, fleet, inside, make):
    pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
    fleet = fleet(lambda: SceneSimulator(Pursuit()), 1, deaths)
    where = {"fleet": fleet}, {"socket": inside(SceneSimulator(Pursuit())).socket}
    both = [make(netmq_example.envs.UnityParallelEnv, "Pursuit", **each) for each in where]
    random = np.random.default_rng(1)
    for seed in range(2):
        assert data_equivalence(*(env.reset(seed=seed) for env in both), exact=True)
        while both[0].agents:
            actions = {agent: int(random.integers(5)) for agent in both[0].agents}
            assert data_equivalence(*(env.step(actions) for env in both), exact=True)
    # Of the episode before nothing is kept.
    assert fleet.hub.count["episodes"] == 2 and bool(fleet.hub.count["begun anew"]) == bool(deaths)


class Windy(Agent):
    """Its observation is a parameter; it tells the channels of each step, and the scene of each begin."""

    name = "leaf"
    scene: Any = None
    observation, action = gymnasium.spaces.Box(-99, 99, (), np.float64), gymnasium.spaces.Discrete(2)
    steps = 0

    def __init__(self, parameters, stats):
        super().__init__()
        self.parameters, self.stats = parameters, stats

    def on_reset(self):
        self.steps = 0
        self.scene.send_info("begun")

    def on_stepped(self):
        self.steps += 1
        self.terminated = self.steps == 3
        self.stats.add("steps", float(self.steps))

    def observe(self):
        return self.parameters.get_with_default("wind", 0.0) + self.steps


def windy():
    parameters, stats = EnvironmentParameters(), StatsRecorder()
    leaf = Windy(parameters, stats)
    leaf.scene = Scene("Leaf", [leaf])
    return SideChannelSimulator(SceneSimulator(leaf.scene), SideChannelManager([parameters, stats]))


def test_side_channels_and_infos_of_the_scene_go_through_the_hub(fleet, make):
    """A simulator that comes later knows what was set before, and nothing is told twice."""
    fleet = fleet(windy, 2, range(11, 99, 11))
    envs = make(netmq_example.envs.UnityVectorEnv, 2, "Leaf", autoreset_mode="SameStep", fleet=fleet)
    parameters, stats = EnvironmentParametersChannel(), StatsSideChannel()
    carry(envs, SideChannelManager([parameters, stats]))
    parameters.set_float_parameter("wind", 10.0)
    seen, infos = envs.reset(seed=1)
    assert seen.tolist() == [10, 10] and infos["env"].tolist() == [["begun"]] * 2
    for step in range(1, 13):
        if step == 7:
            parameters.set_float_parameter("wind", 20.0)
        seen, _, terminated, _, infos = envs.step(np.array([0, 1]))
        assert seen.tolist() == [step % 3 + (10 if step < 7 else 20)] * 2
        assert terminated.all() == (step % 3 == 0) and ("env" in infos) == terminated.all()
    counted = [value for value, _ in stats.get_and_reset_stats()["steps"]]
    assert sorted(counted) == sorted([1.0, 2.0, 3.0] * 8) and fleet.came > 5


def test_what_a_hub_has_not_is_refused_in_a_line(fleet, make):
    said = Message.read(fleet(lambda: walk(Walker(), Walker()), 3).recv_multipart()[1:]).values
    cure = "take FleetSocket(…, 1) for an environment of these agents, and several of both"
    assert said == {"code": "several-agents", "text": f"a scene of 2 agents is no row of 3: {cure}"}
    fleet = fleet(poles, 2)
    make(netmq_example.envs.UnityVectorEnv, 2, "CartPole", fleet=fleet)
    wrong = (4, 2, "scenes-clock"), (8, 2, "real-time"), (0, 3, "wrong-areas")
    for id, (bits, rows, code) in enumerate(wrong, 20):
        section = records.Section(0, bytes(8 * rows), bytes([records.RESET] * rows))
        assert fleet.code(b"trainer", records.Record(records.ASKS, 0, [section], bits), id) == code
