"""Lesson 10, what can go wrong: simulators that are lost, too many or wrong, and what cannot be sent to them."""

from __future__ import annotations

import gc
import re
import warnings

import pytest
import zmq

from tests.programs import LIMIT, free_port

gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: kit.py run 10 installs it")
np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: kit.py run 10 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")

KEY = "10_many_agents"
from netmq_example.envs import ZmqParallelEnv, ZmqVectorEnv  # noqa: E402
from netmq_example.envs.connection import Lost  # noqa: E402
from netmq_example.envs.parallel_env import RemoteAgents  # noqa: E402
from netmq_example.envs.vector_env import RemoteAreas  # noqa: E402
from netmq_example.infos import LONGEST, pack, unpack  # noqa: E402
from netmq_example.messages import EXACT, Message, MessageError, read  # noqa: E402
from netmq_example.simulation.agents import AgentSimulator  # noqa: E402
from netmq_example.simulation.areas import AreaSimulator  # noqa: E402
from netmq_example.simulation.simulation import RealTime  # noqa: E402
from netmq_example.spaces import to_array  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402
from netmq_example.worlds.pursuit import Pursuit  # noqa: E402

ONE = np.ones(3, int)


@pytest.fixture
def areas(inside):
    """areas(…): three of them in this process; `simulator` of what it gives is there to be lost."""
    made = []

    def make(**more):
        simulator = inside(AreaSimulator([CartPole() for _ in range(3)]))
        made.append(gymnasium.make_vec("NetMQExample/CartPole-v0", 3, socket=simulator.socket, **more))
        made[-1].simulator = simulator
        return made[-1]

    yield make
    for envs in made:
        envs.close()


@pytest.fixture
def game(inside):
    simulator = inside(AgentSimulator(Pursuit()))
    env = ZmqParallelEnv(socket=simulator.socket)
    env.simulator = simulator
    env.reset(seed=1)
    yield env
    env.close()


# Lost


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_a_lost_simulator_ends_all_areas_and_they_begin_anew_in_another(mode, areas):
    envs = areas(autoreset_mode=mode)
    begin, _ = envs.reset(seed=7)
    seen, *_ = envs.step(ONE)
    kept, seen[:] = seen.copy(), 9
    envs.simulator.lose()
    last, rewards, terminated, truncated, infos = envs.step(ONE)
    assert (rewards.tolist(), terminated.any(), truncated.all()) == ([0, 0, 0], False, True)
    if mode == "SameStep":
        assert all(np.array_equal(*pair) for pair in zip(infos["final_obs"], kept, strict=True))
        infos, again = infos["final_info"], last
    else:
        assert np.array_equal(last, kept), "nobody knows what came after; and what was given out is the user's"
        whole = {"options": {"reset_mask": np.ones(3, bool)}}
        again = envs.reset(**whole)[0] if mode == "Disabled" else envs.step(ONE)[0]
    assert infos["lost"].tolist() == ["the simulator is gone"] * 3 and infos["_lost"].all()
    assert abs(again).max() <= 0.05, "all of them began"
    *_, truncated, infos = envs.step(ONE)
    assert not truncated.any() and infos == {}
    assert np.array_equal(envs.reset(seed=7)[0], begin)


def test_who_is_lost_when_only_some_begin_anew_ends_as_well(areas):
    envs = areas(autoreset_mode="Disabled")
    envs.reset(seed=1)
    envs.simulator.lose()
    _, infos = envs.reset(options={"reset_mask": np.array([True, False, False])})
    assert infos["_lost"].tolist() == [False, True, True]


def test_who_is_lost_between_a_step_and_the_reset_in_it_ends_as_well(areas):
    """The first area's time is up, and then the simulator is gone."""
    envs = areas(autoreset_mode="SameStep", max_episode_steps=2)
    envs.reset(seed=1)
    envs.areas.steps[0] = 1
    ask = envs.areas.ask

    def ask_and_kill(*request):
        answer = ask(*request)
        if request[0] == "step":
            envs.simulator.lose()
        return answer

    envs.areas.ask = ask_and_kill
    seen, _, _, truncated, infos = envs.step(ONE)
    assert truncated.all() and infos["_final_obs"].tolist() == [True, False, False]
    assert infos["_lost"].tolist() == [False, True, True]
    assert abs(seen).max() <= 0.05


def test_a_lost_simulator_ends_the_game_and_the_next_one_starts_in_another(game):
    begin, _ = game.reset(seed=7)
    kept = {agent: seen.copy() for agent, seen in begin.items()}
    for seen in begin.values():
        seen[:] = 9
    game.simulator.lose()
    actions = dict.fromkeys(game.agents, 0)
    seen, rewards, terminated, truncated, infos = game.step(actions)
    assert all(np.array_equal(seen[agent], kept[agent]) for agent in actions)
    assert (set(rewards.values()), set(terminated.values()), set(truncated.values())) == ({0.0}, {False}, {True})
    assert set(map(str, infos.values())) == {"{'lost': 'the simulator is gone'}"} and game.agents == []
    with pytest.raises(ConnectionError, match="the simulator is gone"):
        game.send_info({"anybody": "there"})
    again, _ = game.reset(seed=7)
    assert all(np.array_equal(again[agent], kept[agent]) for agent in actions)


def test_a_film_goes_on_when_the_simulator_is_lost(areas, inside):
    envs = areas(render_mode="rgb_array")
    simulator = inside(AgentSimulator(Pursuit()))
    env = ZmqParallelEnv(socket=simulator.socket, render_mode="rgb_array")
    for each, one in (envs, envs.simulator), (env, simulator):
        each.reset(seed=1)
        before = each.render()
        one.lose()
        assert np.array_equal(each.render(), before)
    env.close()


def test_who_is_lost_at_the_reset_as_well_begins_once_more(areas, monkeypatch):
    """Such as when lesson 17's hub is started anew twice; and whom each reset ends is given up."""
    envs = areas()
    seen, _ = envs.reset(seed=1)
    ask, fates = envs.areas.ask, ["lost", "lost", "answered", *3 * ["lost"]]
    monkeypatch.setattr(envs.areas.simulators, "find", lambda accept: None)

    def lossy(*request):
        if fates.pop(0) == "lost":
            raise Lost("it is gone")
        return ask(*request)

    envs.areas.ask = lossy
    again, infos = envs.reset(seed=1, options={"reset_mask": np.array([True, False, False])})
    assert np.array_equal(again, seen), "all of them begin"
    assert infos["_lost"].tolist() == [False, True, True], "and those that were not asked to were lost"
    with pytest.raises(Lost, match="it is gone"):
        envs.reset(seed=1)
    assert not fates


# Wrong


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_another_number_of_areas_is_one_clear_line(kind, serve, start, client_command):
    server, endpoint = serve(KEY, "--world", "CartPole", "--areas", "16")
    words = ["--world", "CartPole", "--areas", "8", "--timeout", "5"]
    client = start(*client_command(kind, KEY, endpoint, *words))
    cure = "put 16 areas below it, in lesson 10 by --world CartPole --areas 16"
    text = f"wrong-areas: num_envs is 16, the simulator has 8: {cure}"
    assert client.wait() == 1
    # At once, and not again at each try.
    assert client.lines[1:-1] == [f"trouble: {text}"]
    client.wait_for(f"^gave up: .*{text}")
    server.wait_for(f"^trouble: '{text}'$")


def test_a_wrong_mask_or_seed_is_named(areas):
    envs = areas(autoreset_mode="Disabled", max_episode_steps=1)
    envs.reset(seed=1)
    for mask in (np.zeros(3, bool), np.ones(2, bool), [1, 0, 1]):
        with pytest.raises(ValueError, match="reset_mask must be 3 times true or false, one of them true"):
            envs.reset(options={"reset_mask": mask})
    with pytest.raises(ValueError, match="2 seeds are not one for each of 3 areas"):
        envs.reset(seed=[1, 2])
    envs.step(ONE)
    with pytest.raises(ValueError, match=r"areas \[0 1 2\] are over: reset"):
        envs.step(ONE)


def answered(remote, message):
    """What a remote makes of an answer that a simulator of the test's own gives."""
    remote.ask = lambda *request: message
    return remote


FINE = {"infos": "[]"}
ONES = [to_array(np.zeros((2, 4)), np.float32), to_array([1, 1], np.float64), *[to_array([0, 0], np.uint8)] * 2]
AREAS = {
    "NaN": ({1: to_array([1, np.nan], np.float64)}, "not-in-space: float64"),
    "NaN seen": ({0: to_array(np.full((2, 4), np.nan), np.float32)}, "not-in-space: float32"),
    "shape": ({0: to_array(np.zeros((3, 4)), np.float32)}, r"not-in-space: float32 \(3, 4\)"),
    "flags": ({2: to_array([0, 2], np.uint8)}, r"not-in-space: uint8 \(2,\)"),
}


@pytest.mark.parametrize("what", AREAS)
def test_a_wrong_state_of_areas_is_named(what):
    wrong, text = AREAS[what]
    arrays = [wrong.get(number, array) for number, array in enumerate(ONES)]
    with pytest.raises(MessageError, match=text):
        areas_that_answer(Message("state", 1, FINE, arrays)).step(np.zeros(2, int), np.zeros(2, bool))


@pytest.mark.parametrize(
    "infos", ["[[2,{}]]", "[[-1,{}]]", '[["x",{}]]', "[[[],{}]]", "[[0,{}", "[0]", '[[0,{"a":[1]}]]', 7]
)
def test_wrong_infos_of_areas_are_named(infos):
    with pytest.raises(MessageError, match="bad-infos"):
        areas_that_answer(Message("state", 1, {"infos": infos}, ONES)).step(np.zeros(2, int), np.zeros(2, bool))


def areas_that_answer(message):
    with zmq.Context() as context, context.socket(zmq.ROUTER) as socket:
        remote = RemoteAreas(2, "CartPole", 10, socket=socket, endpoint=bound(socket))
        remote.accept(AreaSimulator([CartPole(), CartPole()]).hello())
        return answered(remote, message)


def bound(socket):
    socket.bind("tcp://127.0.0.1:*")
    return socket.last_endpoint.decode()


@pytest.mark.parametrize("wrong", ["[]", '[["hunter_0",{}]]', "nothing"])
def test_a_state_of_other_agents_is_named(wrong):
    with zmq.Context() as context, context.socket(zmq.ROUTER) as socket:
        remote = RemoteAgents("Pursuit", socket=socket, endpoint=bound(socket))
        simulator = AgentSimulator(Pursuit())
        remote.accept(simulator.hello())
        state = read(simulator.answer(Message("reset", 1, {"seed": 1})))
        state.values["infos"] = wrong
        with pytest.raises(MessageError, match=r"wrong-agents|bad-infos"):
            remote.read(state, list(remote.spaces))


def test_a_reward_that_is_no_number_is_the_simulations_mistake():
    class Broken(Pursuit):
        def judge(self, agent):
            return {"reward": float("nan"), "terminated": False, "truncated": False}

    simulator = AgentSimulator(Broken())
    simulator.answer(Message("reset", 1, {"seed": 1}))
    answer = read(simulator.answer(Message("step", 2, {}, [to_array(0, np.int64)] * 5)))
    assert (answer.kind, answer.values["code"]) == ("error", "bad-reward")


INFOS = {
    "a list": '[["hunter_0",[]]]',
    "a number": '[["hunter_0",5]]',
    "nobody": "[[[],{}]]",
    "an area": "[[0,{}]]",
    "too large": f'[["hunter_0",{{"a":{EXACT}}}]]',
    "infinite": '[["hunter_0",{"a":1e400}]]',
    "half a character": '[["hunter_0",{"a":"\\ud800"}]]',
    "its own word": '[["hunter_0",{"told":5}]]',
}


def test_infos_that_are_none_are_named():
    for text in INFOS.values():
        with pytest.raises(MessageError, match=r"^bad-infos: these are no infos: "):
            unpack(text, reserved=("told", "lost"))


class Peer:
    """A simulator with another value in each message of one kind."""

    def __init__(self, socket, simulator, *change):
        self.socket, self.simulator, self.change = socket, simulator, change

    def say(self, frames):
        message, (kind, name, value) = read(frames), self.change
        if message.kind == kind:
            message.values[name] = value
        self.socket.send_multipart(message.frames())

    def run(self, requests):
        """Says hello, and answers so many requests."""
        self.say(self.simulator.hello().frames())
        for _ in range(requests):
            assert self.socket.poll(1000 * LIMIT), "no request came"
            if (request := read(self.socket.recv_multipart())).kind == "error":
                return
            if request.kind != "welcome":
                self.say(self.simulator.answer(request))


def agent(name):
    return f'[["{name}",{{"observation":"box","action":"discrete"}}]]'


AGENTS = {
    "no dict": ("state", "infos", '[["hunter_0",[]],["hunter_1",{}],["hunter_2",{}],["rabbit_0",{}],["rabbit_1",{}]]'),
    "its own word": ("state", "infos", '[["hunter_0",{"told":5}]]'),
    "told nothing": ("state", "told", '[["",[]]]'),
    "an agent env": ("hello", "agents", agent("env")),
    "a nameless one": ("hello", "agents", agent("")),
    "a number": ("hello", "agents", '[[5,{"observation":"box","action":"discrete"}]]'),
    "one twice": ("hello", "agents", "[" + ",".join([agent("a")[1:-1]] * 2) + "]"),
}


def test_the_server_of_a_game_names_what_is_wrong_and_goes_on(serve):
    server, endpoint = serve(KEY)
    for change in AGENTS.values():
        with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
            socket.linger, before = 0, len(server.lines)
            socket.connect(endpoint)
            Peer(socket, AgentSimulator(Pursuit()), *change).run(3)
            server.wait_for("^trouble: .*bad-(infos|agents): ", start=before)
            server.wait_for("^waiting for a simulator", start=len(server.lines))
    assert "Traceback" not in server.output


def test_areas_that_no_message_can_hold_are_refused():
    with zmq.Context() as context, context.socket(zmq.ROUTER) as socket:
        remote = RemoteAreas(1024, "CartPole", socket=socket, endpoint=bound(socket))
        hello = AreaSimulator([CartPole()] * 1024).hello()
        hello.arrays[:2] = [to_array(np.full(4_000_000, end), np.float32) for end in (-1, 1)]
        text = "too-big: 16384000000 bytes of 1024 areas are more than a message has, 67108864"
        with pytest.raises(MessageError, match=text):
            remote.accept(hello)


# What a user gives

NAN = float("nan")
NO_NAME = (0, -1, None, NAN, "")
# What is called, a parameter of it, values that this cannot have, and the other parameters.
WRONG = [
    (ZmqVectorEnv, "num_envs", (0, -1, None, NAN, "", "3", 0.5), {"name": "CartPole"}),
    (ZmqVectorEnv, "name", NO_NAME, {"num_envs": 2}),
    (ZmqVectorEnv, "max_episode_steps", (0, -2, NAN, "", 0.5), {"num_envs": 2, "name": "CartPole"}),
    (ZmqVectorEnv, "wait", (0, None), {"num_envs": 2, "name": "CartPole"}),
    (ZmqParallelEnv, "name", NO_NAME, {}),
    (ZmqParallelEnv, "real_time", (0, None, NAN, "", "yes"), {}),
    (ZmqParallelEnv, "launch", (0, NAN), {}),
    (AreaSimulator, "areas", (0, None, NAN, "", [], [None], CartPole()), {}),
    (AgentSimulator, "game", (0, None, "", CartPole()), {}),
    (RealTime, "clock", (0, None, ""), {"game": Pursuit()}),
]


@pytest.mark.parametrize(("call", "name", "values", "words"), WRONG)
@pytest.mark.filterwarnings("error")
def test_what_a_class_cannot_use_it_names_in_one_line(call, name, values, words):
    """And forgets in silence what could not be made."""
    with warnings.catch_warnings(action="ignore"):
        # What tests before this one have left is no mistake of these.
        gc.collect()
    for value in values:
        with pytest.raises((ValueError, TypeError), match=rf"^(bad )?{name} .*[^\n]$"):
            call(**words, **{name: value})
    gc.collect()


def test_options_that_are_no_dict_are_named(areas, game):
    envs = areas()
    for options in (0, "abc", [1], NAN):
        for each in envs, game:
            with pytest.raises(ValueError, match=r"^options must be a dict, without seed"):
                each.reset(options=options)
    with pytest.raises(ValueError, match=r"^state cannot be sent: a game begins by chance"):
        game.reset(options={"state": [1]})


UNSENDABLE = {
    "no dict": ([1], "is no dict"),
    "a list": ({"a": [1]}, "'a' of '' must be text, a number, true or false"),
    "a number for a name": ({5: 1}, "5 of '' must be text, a number, true or false"),
    "too large": ({"a": 2**70}, "'a' of '' is too large to be exact"),
    "half a character": ({"a": "\ud800"}, "surrogates not allowed"),
    "no number": ({"a": float("nan")}, "not JSON compliant"),
}


def test_an_info_that_cannot_be_sent_is_named_before_it_is(game):
    for info, said in UNSENDABLE.values():
        with pytest.raises(ValueError, match=said):
            game.send_info(info)
    with pytest.raises(ValueError, match=f"at most {LONGEST} characters"):
        game.send_info({"long": "x" * LONGEST})
    assert len(game.step(dict.fromkeys(game.agents, 0))[0]) == 5, "it goes on"


def test_infos_take_numpys_numbers():
    info = {"a": np.float32(0.5), "b": np.int32(3), "c": np.bool_(True)}
    assert unpack(pack([("", info)])) == [("", {"a": 0.5, "b": 3, "c": True})]


def test_actions_that_are_no_dict_are_named(game):
    for actions in (None, [0] * 5, 0, {}):
        text = f"actions {actions}, but those that live are ['hunter_0', "
        with pytest.raises(ValueError, match=f"^{re.escape(text)}"):
            game.step(actions)


def test_actions_of_another_dtype_are_those_of_the_space(areas):
    envs = areas()
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(np.ones(3, int))
    seen, _ = envs.reset(seed=1)
    seen, *_ = envs.step(np.ones(3, np.int32))
    envs.reset(seed=1)
    assert np.array_equal(envs.step(np.ones(3, np.int64))[0], seen)


def test_a_seed_that_no_simulator_could_read_is_named(areas):
    envs = areas()
    for seed in (EXACT, EXACT - 1, 2**63, [1, None, 2**70], -1, "abc", [1, NAN, 2]):
        with pytest.raises(ValueError, match=r"3 seeds are not one for each of 3 areas, below 2\*\*53"):
            envs.reset(seed=seed)
    with pytest.raises(ValueError, match=r"^1 seeds are not one for each of 3 areas"):
        envs.reset(seed=0.5)
    envs.reset(seed=np.array([1, 2, 3]))
    assert envs.np_random_seed == (1, 2, 3)
    envs.reset(seed=EXACT - 3)
    assert envs.np_random_seed == (EXACT - 3, EXACT - 2, EXACT - 1)
    assert len(envs.np_random) == 3


@pytest.mark.parametrize("mode", ["rgb_array_list", "human"])
def test_a_render_mode_that_would_draw_nothing_is_refused_before_anybody_is_waited_for(mode):
    for kind in ZmqParallelEnv, lambda **words: gymnasium.make_vec("NetMQExample/CartPole-v0", 2, **words):
        with pytest.raises(ValueError, match=f"^render_mode takes 'rgb_array' or None, not '{mode}'"):
            kind(render_mode=mode)


def test_render_without_a_render_mode_says_why_there_is_no_picture(areas, game):
    for env in areas(), game:
        with pytest.warns(UserWarning, match=r"render gives no picture: make the environment with render_mode="):
            assert env.render() is None


def test_it_may_be_closed_twice(areas, game):
    envs = areas()
    for each in envs, game:
        each.close()
        each.close()
        assert [request.kind for request in each.simulator.asked].count("close") == 1


# By hand


def test_by_hand_it_plays_without_python(start, client_command):
    """Nobody presses a key: all rest until no hunter has energy, after 100 steps."""
    client = start(*client_command("unity", KEY, f"tcp://127.0.0.1:{free_port()}", "--byHand", "true"))
    assert client.wait_for("^by hand: .*")[0] == "by hand: 100 steps, return -1.0"
    assert "asking" not in client.output
