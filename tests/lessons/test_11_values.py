"""Lesson 11, values: what a peer sends that is none, and what a user declares or sends that cannot be: a line each."""

from __future__ import annotations

import re
import warnings
from types import SimpleNamespace
from typing import Annotated, Any

import pytest
import zmq

from tests.lessons.test_11_trees import same
from tests.programs import LIMIT

gymnasium = pytest.importorskip("gymnasium", reason="lesson 11 needs gymnasium: kit.py run 11 installs it")
np = pytest.importorskip("numpy", reason="lesson 11 needs numpy: kit.py run 11 installs it")
pytest.importorskip("pettingzoo", reason="lesson 11 needs pettingzoo: kit.py run 11 installs it")
from gymnasium import spaces  # noqa: E402

from netmq_example import spaces as tree  # noqa: E402
from netmq_example.envs import UnityAECEnv, UnityGymEnv, UnityParallelEnv, unity_env  # noqa: E402
from netmq_example.envs import merge as fit  # noqa: E402
from netmq_example.locator import parse  # noqa: E402
from netmq_example.messages import Message, MessageError, read  # noqa: E402
from netmq_example.simulation.scene import Agent, Obs, SceneSimulator  # noqa: E402

KEY = "11_observations"
ONE = spaces.Box(-9, 9, (2,), np.float32)


class Car(Agent):
    """What it sees is what its test puts there; what it hears it says."""

    x: Annotated[Any, Obs()] = None

    def on_info(self, info):
        self.infos.append(info)


@pytest.fixture
def world(monkeypatch):
    """Makes an environment, without a wire: its simulator is in this process, and `change` alters what it answers."""

    def make(space=ONE, simulator=None, change=lambda said: said, kind=UnityGymEnv, **spaces_of):
        simulator = simulator or SceneSimulator("Cars", 0.1, [Car()])

        class Wire:
            def __init__(self, **where):
                self.connection, self.id, self.close = self, 0, lambda: None

            def find(self, accept):
                accept(read(simulator.hello().frames()))

            def begin(self, accept, ask):
                return ask(None)

            def ask(self, kind, values, arrays):
                self.id += 1
                answer = read(simulator.answer(read(Message(kind, self.id, values, arrays).frames())))
                if answer.kind == "error":
                    raise MessageError(answer.values["code"], answer.values["text"])
                if "state" in answer.values:
                    said = change(tree.read(answer.values["state"], answer.arrays))
                    answer.values["state"] = tree.write(said, answer.arrays)
                return read(answer.frames())

        monkeypatch.setattr(unity_env, "Simulators", Wire)
        declared = {"observation_space": spaces.Dict(x=space), "action_space": spaces.Discrete(2)}
        return kind("Cars", **({**declared, **spaces_of} if kind is UnityGymEnv else spaces_of))

    return make


def seeing(value):
    """An agent that sees it."""
    car = Car()
    car.x = value
    return SceneSimulator("Cars", 0.1, [car])


# From a simulator


@pytest.mark.parametrize("odd", [[1, 2], [[1, 1]], [[[1], 1]], [["a", 1, 2]], ["'agent'@['x'] = $"], 5])
def test_what_is_no_locator_with_a_value_is_named(odd, world):
    env = world(change=lambda said: {**said, "observations": odd})
    with pytest.raises(MessageError, match=r"bad-observation: .*is no locator with a value|wrong-type"):
        env.reset(seed=1)


GRAPH = spaces.Graph(spaces.Box(-9, 9, (1,), np.float32), spaces.Box(-9, 9, (1,), np.float32))
NODES, EDGES = np.zeros((2, 1), np.float32), np.zeros((1, 1), np.float32)
ODD = {
    "links that are text": (GRAPH, spaces.GraphInstance(NODES, EDGES, "x"), "not-in-space: 'agent'@"),
    "links too large": (GRAPH, spaces.GraphInstance(NODES, EDGES, [2**52]), "not-in-space: 'agent'@"),
    "links with a fraction": (
        GRAPH,
        spaces.GraphInstance(NODES, EDGES, np.array([[0, 0.7]])),
        "not-in-space: 'agent'@",
    ),
    "text for a number": (spaces.Box(0, 1, (1,), np.float32), "0.5", "bad-observation: .*'0.5' is no number"),
    "a whole number that no float has": (ONE, [2**24 + 1, 0], "bad-observation: .*would become another number"),
    "a number for a sequence": (spaces.Sequence(ONE), 5, "bad-observation|not-in-space"),
    "too many": (spaces.Sequence(spaces.Discrete(2)), np.zeros(200_000, np.int64), "too-many: 'agent'@.*200000 items"),
    "one of many": (spaces.Sequence(ONE), [np.zeros(2), np.full(2, 10.0)], r"not-in-space: 'agent'@\['x'\]\[1\]"),
}


@pytest.mark.parametrize("what", ODD)
def test_a_value_that_does_not_fit_is_named(what, world):
    space, value, said = ODD[what]
    with pytest.raises(MessageError, match=said):
        world(space, seeing(value)).reset(seed=1)


def test_an_action_with_a_part_too_few_is_named():
    pairs = spaces.Sequence(spaces.Dict(a=ONE, b=ONE), stack=True)
    with pytest.raises(MessageError, match=r"^not-in-space: go: dict "):
        fit.fitted(pairs, {"a": NODES}, "go")


def test_nothing_is_an_empty_text(world):
    assert world(spaces.Text(9, min_length=0), seeing(None)).reset(seed=1)[0]["x"] == ""


@pytest.mark.parametrize("stack", [False, True])
@pytest.mark.parametrize(
    ("feature", "items"),
    [
        (ONE, [np.array([1, 2], np.float32), [3, 4]]),
        (spaces.Box(0, 1, (), np.float32), [0.5, 1]),
        (spaces.Discrete(5, start=-2), [2, np.array([1]), -2]),
        (spaces.MultiDiscrete([2, 3]), [[0, 2], [1, 1]]),
        (spaces.MultiBinary(2), [[0, 1]]),
    ],
)
def test_items_that_are_fitted_at_once_are_what_each_of_them_is_alone(feature, items, stack):
    space = spaces.Sequence(feature, stack=stack)
    found = fit.fitted(space, items, "")
    alone = [fit.fitted(feature, item, "") for item in items]
    assert found in space and len(found) == len(alone)
    for one, other in zip(found, alone, strict=True):
        assert np.array_equal(one, other) and np.asarray(one).dtype == other.dtype
        assert stack or type(one) is type(other)


def test_the_server_names_what_is_wrong_and_goes_on(serve):
    """A state with odd observations, one without any coin and then the end, and an agent's text that is no list."""
    server, endpoint = serve(KEY)
    agent = '"agents":{"dict":{"agent":{"dict":{"reward":0.0,"terminated":%s,"truncated":false,"infos":%s}}}}'
    state = '{"dict":{%s,"infos":[],"observations":%s}}'
    for said, line in (
        ([state % (agent % ("false", "[]"), "[[1,1]]")], "^trouble: .*bad-observation: "),
        ([state % (agent % ("false", "5"), "[]")], "^trouble: .*wrong-type: "),
        ([state % (agent % (over, "[]"), "[]") for over in ("false", "true")], "^episode 1: 1 steps, return 0.00: $"),
    ):
        with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
            socket.linger, before = 0, len(server.lines)
            socket.connect(endpoint)
            socket.send_multipart(Message("hello", 0, {"name": "Coins", "dt": 0.1}).frames())
            for text in ["", *said]:
                assert socket.poll(1000 * LIMIT), server.output
                request = read(socket.recv_multipart())
                if text:
                    socket.send_multipart(Message("state", request.id, {"state": text}).frames())
            server.wait_for(line, start=before)
        server.wait_for("^waiting for a simulator", start=before)
    assert "Traceback" not in server.output


# From a user


class Own(spaces.Space):
    """A space of a user's own."""


@pytest.mark.parametrize(
    ("wrong", "where"),
    [
        ({"observation_space": spaces.Dict(a=spaces.Tuple([ONE, spaces.OneOf([ONE])]))}, "'agent'@['a'][1]: OneOf("),
        ({"observation_space": spaces.Sequence(Own())}, "'agent'@[]: "),
        ({"action_space": spaces.Dict(go=Own())}, "action of agent['go']: "),
    ],
)
def test_a_space_that_no_message_has_is_named_before_anybody_is_waited_for(wrong, where):
    declared = {"observation_space": ONE, "action_space": ONE}
    with pytest.raises(ValueError, match=f"^{re.escape(where)}.* has no place in a message"):
        UnityGymEnv("Cars", wait=0.1, endpoint="tcp://127.0.0.1:*", **{**declared, **wrong})


ENDLESS: dict[str, Any] = {}
ENDLESS["it"] = ENDLESS


@pytest.mark.parametrize("info", ["x" * 70_000, "\ud800", ENDLESS, object(), float("nan")], ids=lambda info: type(info))
def test_what_cannot_be_sent_is_named_before_it_is(info, world):
    env = world(simulator=seeing(np.zeros(2)))
    env.reset(seed=1)
    for call in (lambda: env.send_info(info), lambda: env.reset(options={"a": info})):
        with pytest.raises(ValueError, match=r"^(info|reset) cannot be sent: (too-big|bad-tree|bad-value): "):
            call()
    assert env.step(1)[2:4] == (False, False), "it goes on"


@pytest.mark.filterwarnings("ignore:.*render_mode=")
def test_a_render_mode_is_refused_before_anybody_is_waited_for():
    declared = {"observation_space": ONE, "action_space": ONE}
    for kind, spaces_of in (
        (lambda **words: gymnasium.make("NetMQExample/Unity-v0", **words), declared),
        (UnityParallelEnv, {f"{name}s": {"a": space} for name, space in declared.items()}),
    ):
        with pytest.raises(ValueError, match=r"^render_mode takes None, not 'rgb_array': lesson 12 makes films"):
            kind(env_name="Cars", render_mode="rgb_array", **spaces_of)


def test_a_wrong_seed_wrong_options_and_a_step_too_early_are_named(world):
    env = world(simulator=seeing(np.zeros(2)))
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(1)
    for seed in (2**53, 2**70):
        with pytest.raises(ValueError, match=r"^reset cannot be sent: bad-value: value 'seed' is too large"):
            env.reset(seed=seed)
    with pytest.raises(ValueError, match=r"^options must be a dict: \[1\]"):
        env.reset(seed=1, options=[1])
    env.reset(seed=2**53 - 1)


@pytest.mark.parametrize("actions", [None, {}, {"b": 1}, [1], {"agent": 1, "b": 1}])
def test_actions_of_others_than_those_that_live_are_named(actions, world):
    declared = {"observation_spaces": {"agent": spaces.Dict(x=ONE)}, "action_spaces": {"agent": spaces.Discrete(2)}}
    env = world(simulator=seeing(np.zeros(2)), kind=UnityParallelEnv, **declared)
    env.reset(seed=1)
    text = f"actions {actions}, but those that live are ['agent']"
    with pytest.raises(ValueError, match=f"^{re.escape(text)}"):
        env.step(actions)


def test_a_key_that_nothing_writes_is_named_at_reset_also_in_a_dict(world):
    deep = spaces.Dict(x=ONE, extra=ONE, deep=spaces.Dict(a=ONE, b=ONE))

    class Deep(Car):
        a: Annotated[Any, Obs(".deep.a(0)")] = 1.0

    car = Deep()
    car.x = np.zeros(2)
    env = world(simulator=SceneSimulator("Cars", 0.1, [car]), observation_space=deep)
    with pytest.warns(UserWarning) as told:
        seen, _ = env.reset(seed=1)
    places = "nothing writes 'agent'@['extra']: ", "nothing writes 'agent'@['deep']['b']: "
    assert len(told) == 2 and all(str(one.message).startswith(place) for one, place in zip(told, places, strict=True))
    assert seen["deep"]["a"].tolist() == [1, 0]
    with warnings.catch_warnings(action="error"):
        env.step(1)
        world(simulator=seeing(np.zeros(2))).reset(seed=1)


WHERE = {"endpoint": "tcp://127.0.0.1:*", "wait": 0.1}
ONE_AGENT = {"observation_space": ONE, "action_space": ONE}
TWO_AGENTS = {"observation_spaces": {"a": ONE, "b": ONE}, "action_spaces": {"a": ONE, "b": ONE}}


def gym_env(**words):
    return UnityGymEnv(**{"env_name": "Cars", **ONE_AGENT, **WHERE, **words})


def parallel_env(**words):
    return UnityParallelEnv(**{"env_name": "Cars", **TWO_AGENTS, **WHERE, **words})


def aec_env(**words):
    return UnityAECEnv(**{"env_name": "Cars", **TWO_AGENTS, **WHERE, **words})


def scene(name="Cars", dt=0.1, agents=()):
    return SceneSimulator(name, dt, agents)


@pytest.mark.parametrize(
    ("make", "words", "named"),
    [
        *(
            (kind, {"env_name": name}, "env_name")
            for kind in (gym_env, parallel_env, aec_env)
            for name in ("", None, 5)
        ),
        *(
            (kind, {"file_name": name}, "file_name")
            for kind in (gym_env, parallel_env)
            for name in ("", 0, -1, float("nan"))
        ),
        *((gym_env, {"agent_name": name}, "agent_name") for name in ("", None, -1)),
        *((gym_env, {name: 5}, "has no place in a message") for name in ONE_AGENT),
        *((gym_env, {name: None}, "has no place in a message") for name in ONE_AGENT),
        *((parallel_env, {name: wrong}, f"{name[:-7]} spaces") for name in TWO_AGENTS for wrong in (None, {}, [ONE])),
        (parallel_env, {"action_spaces": {"a": ONE}}, r"observations are \['a', 'b'\], those with actions \['a'\]"),
        (parallel_env, {"observation_spaces": {5: ONE}, "action_spaces": {5: ONE}}, "the name of an agent"),
        *((Agent, {"name": name}, "name") for name in ("", None, 0)),
        *((scene, {"name": name}, "name") for name in ("", None, 0)),
        *((scene, {"dt": dt}, "dt") for dt in (0, -1, None, float("nan"), "1")),
        *((scene, {"agents": agents}, "agents|iterable") for agents in (None, [5], [Agent], 0, "", b"", {})),
        *((Obs, {"locator": locator}, "^locator") for locator in (None, 0, b".speed")),
        *((parse, {"text": text}, "text") for text in (None, 0, b"car@")),
        (parse, {"text": "a@", "name": None}, "name"),
        (parse, {"text": "a", "scope": "car@"}, "scope"),
        (fit.merge, {"observations": {}, "locator": "car@", "value": 1, "appended": set()}, "locator"),
        *((fit.fitted, {"space": space, "value": 1, "where": "x"}, "^x: ") for space in (None, 5, Own)),
    ],
)
def test_what_nothing_can_be_made_of_is_named_at_once(make, words, named):
    with pytest.raises((ValueError, TypeError), match=named) as refusal:
        make(**words)
    assert "\n" not in str(refusal.value)


def test_the_names_are_those_of_gymize(world):
    """And its AEC class is PettingZoo's own conversion of the other one."""
    spaces_of = {"observation_spaces": {"agent": spaces.Dict(x=ONE)}, "action_spaces": {"agent": spaces.Discrete(2)}}
    env = world(simulator=seeing(np.zeros(2)), kind=UnityAECEnv, **spaces_of)
    env.reset(seed=1)
    env.send_info("one", "agent")
    assert env.agent_selection == "agent" and same(env.last()[0], {"x": np.zeros(2, np.float32)})
    env.step(1)
    assert env.infos["agent"] == {"env": [], "agent": ["one"]}


# The simulator in Python


def test_it_hears_what_is_said_to_the_environment_and_says_something_of_it(world):
    class Heard(SceneSimulator):
        def on_info(self, info):
            self.infos.append(f"heard {info}")

    env = world(simulator=Heard("Cars", 0.1, seeing(np.zeros(2)).agents.values()))
    env.reset(seed=1)
    env.send_info("all", "")
    env.send_info("one")
    assert env.step(1)[-1] == {"env": ["heard all"], "agent": ["one"]}
    assert env.step(1)[-1] == {"env": [], "agent": []}, "once"


@pytest.mark.parametrize(
    ("kind", "state"),
    [
        ("reset", "5"),
        ("reset", "[]"),
        ("reset", '{"dict":{}}'),
        ("reset", '{"dict":{"agents":5,"options":{"dict":{}}}}'),
        ("reset", '{"dict":{"agents":[[]],"options":{"dict":{}}}}'),
        ("reset", '{"dict":{"agents":["agent"],"options":[]}}'),
        ("step", '{"dict":{}}'),
        ("step", '{"dict":{"actions":5}}'),
        ("info", '{"dict":{"info":5}}'),
        ("info", '{"dict":{"to":[],"info":5}}'),
        ("info", '{"dict":{"to":"agent"}}'),
    ],
)
def test_a_request_that_is_none_is_a_line(kind, state, capfd):
    simulator = seeing(1)
    simulator.hello()
    answer = read(simulator.answer(Message(kind, 1, {"seed": 1, "state": state})))
    assert answer.kind == "error" and answer.values["code"] != "error-in-simulation", answer.values
    assert capfd.readouterr().err == ""


def test_rewards_and_ends_may_be_whole_numbers(world):
    class Gives(Car):
        def on_action(self, action):
            vars(self).update(reward=1, terminated=1, truncated=np.bool_(False))

    car = Gives()
    car.x = np.zeros(2)
    env = world(simulator=SceneSimulator("Cars", 0.1, [car]))
    env.reset(seed=1)
    assert env.step(1)[1:4] == (1.0, True, False)


def test_who_has_ended_has_no_more_ticks(world):
    class Counts(Agent):
        ticks = 0

        def on_tick(self, dt):
            self.ticks += 1
            self.terminated = self.ticks % 2 == 0

    car, other = Car(), Counts("other")
    car.x = np.zeros(2)
    env = world(simulator=SceneSimulator("Cars", 0.1, [car, other]))
    for ticks in (2, 4):
        env.reset(seed=1)
        for _ in range(4):
            env.step(1)
        assert other.ticks == ticks


def test_a_wrong_class_or_scene_is_named():
    class Speeder(Agent):
        velocity: Annotated[Any, Obs(".speed[")] = None

    class Twice(Agent):
        speed: Annotated[Any, Obs()] = 1
        other: Annotated[Any, Obs(".speed")] = 2

    for kind, said in (
        (Speeder, 'Speeder.velocity, locator ".speed[": column 8: expected a key'),
        (Twice, "Twice.speed and Twice.other go to one place: 'agent'@['speed'] = $"),
    ):
        with pytest.raises(ValueError, match=f"^{re.escape(said)}"):
            kind()
    with pytest.raises(ValueError, match=r"^two agents have one name: 'a', 'a'; each needs a name of its own"):
        SceneSimulator("Cars", 0.1, [Car("a"), Car("a")])


def test_an_agent_that_is_asked_for_twice_answers_once():
    simulator = seeing(SimpleNamespace)
    simulator.agents["agent"].x = 1
    simulator.hello()
    state = tree.write({"agents": ["agent", "agent"], "options": {}}, [])
    answer = read(simulator.answer(Message("reset", 1, {"seed": 1, "state": state})))
    assert len(tree.read(answer.values["state"], [])["observations"]) == 1
