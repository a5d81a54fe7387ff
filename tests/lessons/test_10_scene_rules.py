"""Lesson 10, a scene in Python: what an agent and a scene cannot be, say or be asked; and what has broken once: who is
away or replaced, answers that are cut, a Ctrl-C in a step, and real time. The order of a step, names, who comes and
leaves are in test_10_many_agents.py, for both languages.
"""

from __future__ import annotations

import re
import types
from dataclasses import dataclass
from typing import Annotated, Any

import pytest

np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: kit.py run 10 installs it")
pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: kit.py run 10 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
from gymnasium.error import ResetNeeded  # noqa: E402
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary  # noqa: E402

from netmq_example.envs import UnityGymEnv, UnityParallelEnv, UnityVectorEnv, remote  # noqa: E402
from netmq_example.envs.infos import Infos  # noqa: E402
from netmq_example.messages import Message, MessageError  # noqa: E402
from netmq_example.scene import Agent, Obs, Scene, SceneSimulator  # noqa: E402
from netmq_example.wire import records, trees  # noqa: E402
from netmq_example.wire.records import (  # noqa: E402
    ABSENT,
    ANSWERS,
    ASKS,
    LAST,
    NEW,
    NOTHING,
    REAL_TIME,
    RESET,
    SEEN,
    STEP,
    TERMINATED,
    Record,
    Section,
    read_frames,
)
from netmq_example.wire.sections import rewards, rewards_in, seeds, with_infos, with_sizes  # noqa: E402


class OldArray(np.ndarray):  # type: ignore[name-defined]
    """As numpy 1.24 has it: an array of one number is a number."""

    def __float__(self):
        return float(self.item())


class Asks:
    """Asks a simulator as an environment does: reset and step of all agents, or of those whose orders are given."""

    def __init__(self, simulator):
        self.simulator = simulator
        self.hello = simulator.hello()
        self.kinds = trees.read(self.hello.arrays[0].data)["kinds"]
        self.id = 0

    def ask(self, sections, bits=0, **options):
        self.id += 1
        said = trees.write(options) if options else b""
        frames = self.simulator.answer(Record(ASKS, self.id, sections, bits, said))
        answer = read_frames(ANSWERS, frames)
        return f"{answer.values['code']}: {answer.values['text']}" if answer.kind == "error" else answer

    def section(self, orders, action=0, kind=0, seed=1):
        """Its agents' actions are all the same."""
        rows = [np.int64(action).tobytes()] * sum(order in (STEP, LAST) for order in orders)
        return with_sizes(Section(kind, seeds(range(seed, seed + len(orders))), bytes(orders)), rows)

    def all(self, order, bits=0, action=0, seed=1, **options):
        first = np.cumsum([0] + [len(kind["agents"]) for kind in self.kinds])
        sections = [
            self.section([order] * len(kind["agents"]), action, at, seed + int(first[at]))
            for at, kind in enumerate(self.kinds)
        ]
        return self.ask(sections, bits, **options)

    def say(self, *pair):
        self.id += 1
        arrays = [trees.array_of(trees.write(list(pair)))] if pair else []
        answer = self.simulator.answer(Message("info" if pair else "render", self.id, {}, arrays))
        return Message.read(answer)


class Fish(Agent):
    """It writes down what it does."""

    observation, action = Box(-100, 100, (2,), np.float32), Discrete(9)
    calls: Any = None

    def on_reset(self):
        self.steps = 0

    def on_action(self, action):
        if self.calls is not None:
            self.calls.append(f"{self.name} does {action}")

    def on_stepped(self):
        self.steps += 1
        self.reward += 1

    def observe(self):
        return np.array([self.steps, 0], np.float32)


def fish(*names, **more):
    made = [Fish(name) for name in names]
    for one in made:
        vars(one).update(more)
    return made


# Agents


def test_options_and_states_are_each_ones_own():
    cods = fish("cod", "cod", state_size=2)
    asks = Asks(SceneSimulator(Scene("Sea", cods)))
    asks.all(RESET, depth=[1, {"x": 2}], state=[3, 4.5])
    for each in cods:
        assert (each.state, each.options["depth"]) == ([3.0, 4.5], [1, {"x": 2}])
        each.options["depth"].append(5)
        each.state.append(1.0)
    assert asks.all(RESET, state=np.ones(3)) == "bad-state: a state is 2 numbers, not 3"
    for wrong in ("here", None, [None, 1]):
        assert asks.all(RESET, state=wrong).startswith("bad-state: a state is numbers")
    assert len(cods[0].state) == 3, "nothing has begun"
    asks.all(RESET)
    assert [each.state for each in cods] == [[], []]


@dataclass
class Equal(Agent):
    """Equal to any other one, and so not hashable."""

    size: int = 1
    observation = Box(0, 9, (), np.float32)

    def observe(self):
        return self.size


def test_an_agent_may_be_a_dataclass():
    scene = Scene("Equals", [Equal(1), Equal(2), Equal(1)])
    asks = Asks(SceneSimulator(scene))
    answer = asks.all(RESET)
    assert np.frombuffer(answer.sections[0].values, np.float32).tolist() == [1, 2, 1]
    last = scene.agents[2]
    scene.remove(last)
    assert len(scene.agents) == 2 and scene.agents[0] is not last
    assert asks.all(RESET).sections[0].marks == bytes([SEEN, SEEN, ABSENT])


def scene_of(*agents, **more):
    return lambda: SceneSimulator(Scene("Sea", agents, **more))


class Wide(Fish):
    observation = Box(0, 1, (3,))


class Marked(Agent):
    depth: Annotated[float, Obs("cod@.depth")] = 0.0


class Silent(Agent):
    observation = Box(0, 1, (3,))


COD = Fish("cod")
REFUSED = [
    (scene_of(), "Sea has no agents: give its Scene one at least"),
    (lambda: Scene("Sea", [COD], at_most=[3]), r"at_most takes a Mapping or None, not \[3\]"),
    (
        scene_of(Fish("cod_1"), Fish("cod_1")),
        "two agents have one name: 'cod_1', 'cod_1'; each needs a name of its own",
    ),
    (scene_of(Fish("cod"), Wide("cod")), "'cod' and 'cod_0' have one name, cod, and not the same observation"),
    (scene_of(*fish("cod"), *fish("cod", period=2)), "'cod' and 'cod_0' have one name, cod, and not the same period"),
    (scene_of(*fish("cod", period=0)), "period takes a whole number from 1"),
    (
        scene_of(*fish("cod", "cod"), at_most={"cod": 1}),
        "no-space: there are 2 agents of cod: write at_most={'cod': 2}",
    ),
    (scene_of(*fish("cod"), at_most={"eel": 1}), "at_most takes names of agents, and 'eel' is none of cod"),
    (scene_of(COD, COD), "two-agents: cod is in the scene twice"),
    (scene_of(Fish("cod"), Marked("eel")), "Marked.depth goes into what cod sees, whose own observe says that"),
    (scene_of(Silent("eel")), "nothing says what eel sees: write its observe, or mark fields"),
]


@pytest.mark.parametrize(("make", "said"), REFUSED)
def test_agents_that_cannot_be_in_one_scene_are_named(make, said):
    with pytest.raises((ValueError, TypeError), match=said):
        make()


def test_who_comes_back_has_its_row_and_its_name_and_a_stranger_has_none():
    cods: Any = fish("cod", "cod")
    scene = Scene("Sea", cods)
    one, other = cods
    asks = Asks(SceneSimulator(scene))
    asks.all(RESET)
    # Removed by the one before it, before its own turn.
    other.calls, one.on_action = [], lambda action: scene.remove(other)
    assert asks.all(STEP).sections[0].marks == bytes([SEEN, ABSENT]) and other.calls == []
    del one.on_action
    other.name = "eel"
    scene.add(other)
    answer = asks.all(STEP)
    assert (answer.sections[0].marks, other.name) == (bytes([SEEN, SEEN | NEW]), "cod_1")
    for stranger, said in (
        (Fish("eel"), "no-space: nobody has a row for 'eel': at the hello there were cod"),
        (Fish("cod"), "no-space: there are 2 agents of cod already, and no more may come: at_most={'cod': 3}"),
        (Fish("cod_1"), "two-agents: 2 agents are named 'cod_1': each needs a name of its own"),
        (Wide("cod"), "two-kinds: 'cod' and 'cod_0' have one name, cod, and not the same observation"),
        (one, "two-agents: cod_0 is in the scene twice"),
    ):
        scene.agents.append(stranger)
        assert asks.all(STEP).startswith(said)
        scene.agents.pop()
    assert asks.all(STEP).sections[0].marks == bytes([SEEN, SEEN])


# The infos of an agent


def told(agent, what, **more):
    """The answer to a step of a scene with this agent, after `what` was done in its on_stepped."""
    agent.on_stepped = lambda: what(agent)
    asks = Asks(SceneSimulator(Scene("Sea", [agent], **more)))
    asks.all(RESET)
    return asks.all(STEP)


def give(**values):
    return lambda agent: agent.__dict__.update(values)


SAID = [
    (
        give(reward=np.array([2.0]).view(OldArray)),
        "bad-reward: the reward of cod is OldArray([2.]), which is no number",
    ),
    (give(reward=float("nan")), "bad-reward: the reward of cod is nan"),
    (give(reward=float("-inf")), "bad-reward: the reward of cod is -inf"),
    (give(info={"seen": {1, 2}}), "bad-tree: info 'seen' cannot be sent: set has no place in a message"),
    (give(info=[1]), "bad-info: an info is a dict, not [1]"),
    (give(info={"lost": 1}), "bad-info: these names are the environment's own: 'lost'; cod has it"),
    (lambda agent: agent.send_info({1}), "bad-tree: set has no place in a message"),
    (give(observe=lambda: None), "not-in-space: float32 () nan is not in Box(-100.0, 100.0, (2,), float32)"),
    (
        give(observe=lambda: [1, 101]),
        "not-in-space: float32 (2,) [1.0, 101.0] is not in Box(-100.0, 100.0, (2,), float32)",
    ),
    (
        give(observe=lambda: "here"),
        "not-in-space: 'here' is not in Box(-100.0, 100.0, (2,), float32): 'here' is no number",
    ),
]


@pytest.mark.parametrize(("what", "said"), SAID)
def test_what_an_agent_cannot_say_is_named(what, said):
    assert told(Fish("cod"), what)[: len(said)] == said


def test_whole_numbers_and_numpys_are_numbers():
    def judge(agent):
        agent.reward, agent.terminated, agent.truncated = 1, np.bool_(False), 0

    answer = told(Fish("cod"), judge, dt=1)
    assert (rewards_in(answer.sections[0]), answer.sections[0].marks) == ((1.0,), bytes([SEEN]))
    assert type(Asks(SceneSimulator(Scene("Sea", fish("cod"), np.float32(0.5)))).hello.values["dt"]) is float


def test_what_python_asks_in_vain_is_told_with_what_there_is():
    cod: Any = Fish("cod")
    asks = Asks(SceneSimulator(Scene("Sea", [cod])))
    assert asks.say("eel", 1).values["text"] == "no agent is named 'eel'; there are: cod"
    assert asks.say().values["text"] == "Sea draws no pictures: write a render of the scene or its agents"
    cod.render = lambda: np.zeros((2, 3, 3), np.uint8)
    assert [array.shape for array in asks.say().arrays] == [(2, 3, 3)]


def test_a_mistake_in_an_agent_is_told_in_one_line_and_it_goes_on(caplog):
    cod: Any = Fish("cod")
    cod.ticks = 0
    cod.on_tick = lambda dt: 1 / cod.ticks
    asks = Asks(SceneSimulator(Scene("Sea", [cod])))
    asks.all(RESET)
    assert re.fullmatch(r"error-in-simulation: ZeroDivisionError\('.*'\)", asks.all(STEP))
    assert "1 / cod.ticks" in caplog.text and caplog.text.count("Traceback") == 1, "its author sees where it is"
    cod.ticks = 1
    assert rewards_in(asks.all(STEP).sections[0]) == (1.0,)


@pytest.mark.parametrize(
    ("seen", "said"),
    [
        ({"calls": [0, 1, 1]}, "it lacks 'floor'; the keys are calls, floor"),
        ({"calls": [0, 1, 1], "floor": 1, "door": 1}, "it has 'door'; the keys are calls, floor"),
        ({"calls": None, "floor": 1}, "['calls']: object () None is not in MultiBinary(3)"),
        ({"calls": [0, 1, 1], "floor": 7}, "['floor']: int64 () 7 is not in Discrete(3)"),
    ],
)
def test_a_part_that_is_wrong_is_named(seen, said):
    class Lift(Agent):
        observation = Dict(calls=MultiBinary(3), floor=Discrete(3))
        action = Discrete(2)

        def observe(self):
            return seen

    assert Asks(SceneSimulator(Scene("House", [Lift("lift")]))).all(RESET) == f"not-in-space: {said}"


def test_a_method_that_nobody_calls_is_no_secret():
    with pytest.warns(UserWarning, match=r"^nobody calls Lift\.on_act: Agent has on_reset, on_action, on_tick, "):

        class Lift(Agent):
            def on_act(self, action): ...

    with pytest.warns(UserWarning, match=r"^nobody calls House\.on_step: Scene has on_reset, on_tick, on_stepped, "):

        class House(Scene):
            def on_step(self): ...


def test_half_a_request_is_none():
    """Everything is looked at before anything moves."""
    calls: list[str] = []
    asks = Asks(SceneSimulator(Scene("Sea", fish("cod", "cod", "eel", calls=calls))))
    asks.all(RESET)
    calls.clear()
    good, step = asks.section([STEP, STEP]), asks.section([STEP], kind=1)
    for sections, said in (
        ([good, asks.section([STEP], kind=2)], "wrong-agents: kind 2 is none, or asked for twice: there are 2"),
        ([good, good], "wrong-agents: kind 0 is none, or asked for twice"),
        ([good, asks.section([STEP], 9, kind=1)], "not-in-space: "),
    ):
        asks.id += 1
        record = Record(ASKS, asks.id, sections)
        answer = read_frames(ANSWERS, asks.simulator.answer(record))
        assert f"{answer.values['code']}: {answer.values['text']}".startswith(said)
    assert calls == []
    assert asks.ask([good, step], 4).startswith("wrong-clock: ")
    assert asks.ask([good, step]).sections[1].marks == bytes([SEEN])


BOTH = np.zeros(2, int)
MODES = pytest.mark.parametrize("mode", ["NextStep", "SameStep"])


class Cod(Fish):
    """It sees its number and its steps; `on_steps` is what it does after so many."""

    def __init__(self, number=0, on_steps: Any = None):
        super().__init__("cod")
        self.number, self.on_steps, self.steps = number, on_steps or {}, 0

    def on_action(self, action): ...

    def on_stepped(self):
        super().on_stepped()
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
    one, other = Cod(), Cod()
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


def test_who_leaves_while_another_one_is_reset_is_cut_once(sea):
    one, other = Cod(), Cod()
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
    one, other = Cod(), Cod()
    scene = Sea([one, other])
    one.on_reset = lambda: scene.remove(other)
    env = sea(UnityVectorEnv, scene, autoreset_mode=mode)
    env.reset(seed=1)
    assert not any(env.step(BOTH)[3].any() for _ in range(3))


# What others send


def test_a_strangers_record_ends_nothing(sea, connect):
    env = sea(UnityGymEnv, Sea([Cod()]))
    env.reset(seed=1)
    stranger = connect(env.simulators.connection.endpoint)
    # Half a record.
    stranger.send(Record(ANSWERS, 5, [Section(0, rewards([1]), bytes([SEEN]))]).frame()[:-1])
    for steps in range(1, 100):
        assert env.step(0)[0].tolist() == [0, steps]
        if stranger.poll(10):
            break
    assert b"bad-record" in stranger.recv_multipart()[0]


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
    env = sea(kind, Sea([Cod()] if kind is UnityGymEnv else [Cod(), Cod()]))
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

    one, other = Cod(), Cod()
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


@pytest.mark.parametrize("kind", [UnityGymEnv, UnityVectorEnv])
def test_in_real_time_a_step_waits_for_its_tick(kind, sea, monkeypatch):
    now, slept = [100.0], []

    def sleep(seconds):
        slept.append(round(seconds, 6))
        now[0] += seconds

    monkeypatch.setattr(remote, "time", types.SimpleNamespace(sleep=sleep, monotonic=lambda: now[0]))
    agents = [Cod()] if kind is UnityGymEnv else [Cod(), Cod()]
    env = sea(kind, Sea(agents, dt=0.25), clock=lambda: now[0], real_time=True)
    env.reset(seed=1)
    for thinks in (0, 0, 0.0625, 1, 0):
        now[0] += thinks
        env.step(actions_of(env))
    assert slept == [0.25, 0.25, 0.1875, 0, 0.25]


def test_what_the_clock_has_seen_is_made_up_for():
    """With the actions from before, and those of a step only in the tick that is due. Ten seconds at most. An agent
    that is over has no more ticks until the next exchange.
    """
    now, done = [0.0], []
    one, other = Cod(), Cod()
    one.on_action = done.append
    other.on_steps = {2: lambda: setattr(other, "terminated", True)}
    asks = Asks(SceneSimulator(Sea([one, other], dt=0.25), clock=lambda: now[0]))
    asks.all(RESET, REAL_TIME)
    for now[0], action, orders, ticks in (
        (0.26, 1, [STEP, STEP], [1]),
        (1.26, 2, [STEP, STEP], [1, 1, 1, 2]),
        (1000, 3, [STEP, NOTHING], [2] * 41 + [3]),
    ):
        (section,) = asks.ask([asks.section(orders, action)], REAL_TIME).sections
        assert (done, rewards_in(section)[0], other.steps) == (ticks, len(ticks), min(len(ticks), 2))
        assert bool(section.marks[1] & TERMINATED) == (ticks[-1] == 2)
        done.clear()


def test_a_reset_of_some_starts_the_clock_anew():
    now = [0.0]
    one, other = Cod(), Cod()
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
    class Doubles(Cod):
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
