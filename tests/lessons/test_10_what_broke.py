"""Lesson 10, what has broken once: who is away or replaced, answers that are cut, a Ctrl-C in a step, and real time."""

import types
from typing import Any

import pytest
import zmq

np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: kit.py run 10 installs it")
gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: kit.py run 10 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
from gymnasium.error import ResetNeeded  # noqa: E402
from gymnasium.spaces import Box, Discrete  # noqa: E402

from netmq_example.envs import UnityGymEnv, UnityParallelEnv, UnityVectorEnv, remote  # noqa: E402
from netmq_example.envs.infos import Infos  # noqa: E402
from netmq_example.envs.simulators import FREE_PORT, bound  # noqa: E402
from netmq_example.messages import MessageError  # noqa: E402
from netmq_example.scene import Agent, Scene, SceneSimulator  # noqa: E402
from netmq_example.wire import records  # noqa: E402
from netmq_example.wire.records import (  # noqa: E402
    ANSWERS,
    FORM,
    NOTHING,
    REAL_TIME,
    RESET,
    SEEN,
    STEP,
    Record,
    Section,
)
from netmq_example.wire.sections import rewards, with_infos  # noqa: E402
from tests.lessons.test_10_scene_rules import Asks  # noqa: E402

BOTH = np.zeros(2, int)
MODES = pytest.mark.parametrize("mode", ["NextStep", "SameStep"])


class Fish(Agent):
    """It sees its number and its steps, and has 1 for each; `on_steps` is what it does after so many."""

    observation, action = Box(-100, 100, (2,), np.float32), Discrete(2)

    def __init__(self, number=0, on_steps: Any = None):
        super().__init__("cod")
        self.number, self.on_steps, self.steps = number, on_steps or {}, 0

    def on_reset(self):
        self.steps = 0

    def on_stepped(self):
        self.steps += 1
        self.reward += 1
        self.on_steps.get(self.steps, lambda: None)()

    def observe(self):
        return [self.number, self.steps]


class Sea(Scene):
    """`plan` is what happens in the step of this number."""

    def __init__(self, agents, plan: Any = None, **more):
        super().__init__("Sea", agents, **more)
        self.plan, self.step = plan or {}, 0

    def on_stepped(self):
        self.step += 1
        self.plan.get(self.step, lambda: None)()


@pytest.fixture
def sea(inside, make):
    """sea(UnityGymEnv, scene, …): an environment of this scene."""

    def made(kind, scene, clock=None, **more):
        simulator = SceneSimulator(scene, **({"clock": clock} if clock else {}))
        words = (2, "Sea") if kind is UnityVectorEnv else ("Sea",)
        return make(kind, *words, socket=inside(simulator).socket, **more)

    return made


# Agents that are away, and that are replaced


@MODES
def test_time_away_is_no_step(mode, sea):
    one, other = Fish(), Fish()
    scene = Sea([one, other])
    scene.plan = {2: lambda: scene.remove(other), 5: lambda: scene.add(other)}
    env = sea(UnityVectorEnv, scene, max_episode_steps=4, autoreset_mode=mode)
    env.reset(seed=1)
    cut, seen = [], []
    for _ in range(10):
        now, _, _, truncated, _ = env.step(BOTH)
        cut.append(truncated.tolist())
        seen.append(now[1, 1])
    left, again = (at for at, (_, is_cut) in enumerate(cut) if is_cut)
    assert left == 1
    assert seen[again - 4 : again] == [0, 1, 2, 3], "it came back for four whole steps"


def test_who_is_replaced_is_told_first(sea):
    one = Fish(1)
    scene = Sea([one])

    def swap():
        scene.remove(one)
        scene.add(Fish(2))

    one.on_steps = {3: swap}
    env = sea(UnityGymEnv, scene)
    env.reset(seed=1)
    steps = [env.step(0) for _ in range(3)]
    assert [step[1:4] for step in steps] == [(1, False, False)] * 2 + [(1, False, True)]
    assert "it has left" in steps[2][4]["lost"]
    with pytest.raises(ResetNeeded):
        env.step(0)
    assert env.reset()[0].tolist() == [2, 0]
    assert env.step(0)[0].tolist() == [2, 1]


def test_who_leaves_while_another_one_is_reset_is_cut_once(sea):
    one, other = Fish(), Fish()
    scene = Sea([one, other])
    one.on_steps = {2: lambda: setattr(one, "terminated", True)}
    env = sea(UnityVectorEnv, scene, autoreset_mode="Disabled")
    env.reset(seed=1)
    assert [env.step(BOTH)[2].tolist() for _ in range(2)] == [[False, False], [True, False]]
    one.on_steps = {}
    one.on_reset = lambda: scene.remove(other)
    env.reset(options={"reset_mask": np.array([True, False])})
    assert env.step(BOTH)[3].tolist() == [False, True]
    env.reset(options={"reset_mask": np.array([False, True])})
    assert [env.step(BOTH)[3].tolist() for _ in range(3)] == [[False, False]] * 3


@MODES
def test_who_is_not_there_at_the_beginning_is_not_cut(mode, sea):
    one, other = Fish(), Fish()
    scene = Sea([one, other])
    one.on_reset = lambda: scene.remove(other)
    env = sea(UnityVectorEnv, scene, autoreset_mode=mode)
    env.reset(seed=1)
    assert not any(env.step(BOTH)[3].any() for _ in range(3))


# What others send


def whole():
    """An answer with a form and an info: its last 16 bytes are where the info is, and the info."""
    section = Section(0, rewards([1, 2]), bytes([SEEN] * 2), columns=FORM, form=b'"float32 [2]"', values=bytes(16))
    with_infos(section, {1: bytes(5)})
    return Record(ANSWERS, 5, [section]).frame()


HALF_A_TABLE = whole()[:-12]


def test_a_strangers_record_ends_nothing(sea, connect):
    env = sea(UnityGymEnv, Sea([Fish()]))
    env.reset(seed=1)
    stranger = connect(env.simulators.connection.endpoint)
    stranger.send(HALF_A_TABLE)
    for steps in range(1, 100):
        assert env.step(0)[0].tolist() == [0, steps]
        if stranger.poll(10):
            break
    assert b"bad-record" in stranger.recv_multipart()[0]


def test_what_is_sent_to_a_simulator_is_not_dropped_early():
    with zmq.Context() as context, bound(FREE_PORT, context) as socket, context.socket(zmq.ROUTER) as plain:
        assert socket.sndhwm == plain.sndhwm


@pytest.mark.parametrize(
    "form", [b"{", b"[" * 200, b"\xff", b'{"dict":{"a":"float32 [-1]"}}', b'{"dict":{"a":"float99 [2]"}}', b"1"]
)
def test_an_info_of_no_form_is_named(form):
    info = len(form).to_bytes(4, "little") + form + bytes(8)
    section = with_infos(Section(0, rewards([0, 0]), bytes([SEEN] * 2)), {0: info, 1: info})
    with pytest.raises(MessageError):
        Infos(2, records.read(ANSWERS, Record(ANSWERS, 1, [section]).frame()).sections[0]).gathered()


# A step that nobody has seen


def actions_of(env):
    return {UnityGymEnv: 0, UnityVectorEnv: BOTH}.get(type(env), dict.fromkeys(getattr(env, "agents", ()), 0))


@pytest.mark.parametrize("kind", [UnityGymEnv, UnityVectorEnv, UnityParallelEnv])
def test_after_a_ctrl_c_in_a_step_comes_a_reset(kind, sea, monkeypatch):
    env = sea(kind, Sea([Fish()] if kind is UnityGymEnv else [Fish(), Fish()]))
    env.reset(seed=1)
    asked = env.simulators.ask

    def ask(request):
        asked(request)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(env.simulators, "ask", ask)
        env.step(actions_of(env))
    for _ in range(2):
        with pytest.raises(ResetNeeded):
            env.step(actions_of(env))
    if kind is UnityVectorEnv:
        with pytest.raises(ResetNeeded):
            env.reset(options={"reset_mask": np.array([True, False])})
    env.reset(seed=1)
    seen = env.step(actions_of(env))[0]
    assert (seen["cod_0"] if kind is UnityParallelEnv else seen).ravel()[1] == 1


@MODES
def test_after_a_mistake_in_a_step_in_which_some_begin_comes_a_reset(mode, sea):
    def fail():
        raise RuntimeError("here")

    one, other = Fish(), Fish()
    env = sea(UnityVectorEnv, Sea([one, other]), autoreset_mode=mode)
    env.reset(seed=1)
    other.on_steps = {2: fail, 4: fail}
    one.on_steps = {3: lambda: setattr(one, "terminated", True)}
    env.step(BOTH)
    with pytest.raises(MessageError, match="error-in-simulation"):
        env.step(BOTH)
    if mode == "NextStep":
        # Nobody was to begin in it: whoever likes goes on.
        assert env.step(BOTH)[2].tolist() == [True, False]
        with pytest.raises(MessageError, match="error-in-simulation"):
            env.step(BOTH)
    with pytest.raises(ResetNeeded):
        env.step(BOTH)
    other.on_steps = {}
    env.reset(seed=1)
    assert env.step(BOTH)[0][:, 1].tolist() == [1, 1]


# Real time


@pytest.mark.parametrize("kind", [UnityGymEnv, UnityVectorEnv, UnityParallelEnv])
def test_in_real_time_a_step_waits_for_its_tick(kind, sea, monkeypatch):
    now, slept = [100.0], []

    def sleep(seconds):
        slept.append(round(seconds, 6))
        now[0] += seconds

    monkeypatch.setattr(remote, "time", types.SimpleNamespace(sleep=sleep, monotonic=lambda: now[0]))
    agents = [Fish()] if kind is UnityGymEnv else [Fish(), Fish()]
    env = sea(kind, Sea(agents, dt=0.25), clock=lambda: now[0], real_time=True)
    env.reset(seed=1)
    for thinks in (0, 0, 0.0625, 1, 0):
        now[0] += thinks
        env.step(actions_of(env))
    assert slept == [0.25, 0.25, 0.1875, 0, 0.25]


def test_a_reset_of_some_starts_the_clock_anew():
    now = [0.0]
    one, other = Fish(), Fish()
    asks = Asks(SceneSimulator(Sea([one, other], dt=0.5), clock=lambda: now[0]))
    asks.all(RESET, REAL_TIME)
    now[0] = 0.5
    asks.all(STEP, REAL_TIME)
    assert (one.steps, other.steps) == (1, 1)
    now[0] = 5.0
    asks.ask([asks.section([RESET, NOTHING])], REAL_TIME)
    now[0] = 5.5
    asks.all(STEP, REAL_TIME)
    assert (one.steps, other.steps) == (1, 2), "nothing is made up for"
    now[0] = 6.5
    asks.all(STEP, REAL_TIME)
    assert (one.steps, other.steps) == (3, 4)


def test_an_action_that_its_agent_changes_is_the_same_at_the_next_tick(sea):
    class Doubles(Fish):
        action = Box(-1, 1, (2,), np.float32)

        def on_action(self, action):
            action *= 2
            self.reward += float(action[0]) - 1

    now = [0.0]
    env = sea(UnityGymEnv, Sea([Doubles()], dt=0.001), clock=lambda: now[0], real_time=True)
    env.reset(seed=1)
    earned = []
    for ticks in (1, 3):
        now[0] += 0.001 * ticks
        earned.append(env.step(np.array([0.25, 0], np.float32))[1])
    assert earned == [0.5, 1.5]
