"""Lesson 10, values: what a peer sends that is none, and what a user gives that cannot be sent, as a line each."""

from __future__ import annotations

import gc
import re

import pytest
import zmq

from tests.programs import LIMIT

gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: pip install gymnasium")
np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: pip install numpy")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: pip install pettingzoo")

KEY = "10_many_agents"
from netmq_example.envs import ZmqParallelEnv, ZmqVectorEnv  # noqa: E402
from netmq_example.infos import pack, unpack  # noqa: E402
from netmq_example.messages import EXACT, MessageError, read  # noqa: E402
from netmq_example.simulation.agents import AgentSimulator  # noqa: E402
from netmq_example.simulation.areas import AreaSimulator  # noqa: E402
from netmq_example.simulation.simulation import RealTime  # noqa: E402
from netmq_example.spaces import to_array  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402
from netmq_example.worlds.pursuit import Pursuit  # noqa: E402


@pytest.fixture
def areas(launch):
    """Three of them, in one simulator."""
    words = ["--world", "CartPole", "--areas", "3"]
    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", 3, launch=launch("python", *words, key=KEY))
    yield envs
    envs.close()


@pytest.fixture
def game(launch):
    env = ZmqParallelEnv(launch=launch("python", key=KEY))
    env.reset(seed=1)
    yield env
    env.close()


# From a simulator

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


@pytest.mark.parametrize("what", INFOS)
def test_infos_that_are_none_are_named(what):
    with pytest.raises(MessageError, match=r"^bad-infos: these are no infos: "):
        unpack(INFOS[what], reserved=("told", "lost"))


class Peer:
    """A simulator that answers as its test wants: what is changed is a value of each message of this kind."""

    def __init__(self, socket, simulator, kind, name, value, arrays=None):
        self.socket, self.simulator, self.change = socket, simulator, (kind, name, value, arrays)

    def say(self, frames):
        message, (kind, name, value, arrays) = read(frames), self.change
        if message.kind == kind:
            message.values[name] = value
            message.arrays = arrays or message.arrays
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


HUGE = [to_array(np.full(4_000_000, end), np.float32) for end in (-1, 1)]
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


def test_areas_that_no_message_can_hold_are_refused(serve):
    server, endpoint = serve(KEY, "--world", "CartPole", "--areas", "1024")
    simulator = AreaSimulator([CartPole() for _ in range(1024)])
    with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
        socket.linger = 0
        socket.connect(endpoint)
        Peer(socket, simulator, "hello", "areas", 1024, HUGE + simulator.hello().arrays[2:]).run(1)
        server.wait_for("^trouble: 'too-big: 16384000000 bytes of 1024 areas are more than a message has, 67108864'")
    assert "Traceback" not in server.output


# From an environment


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_simulator_names_a_wrong_mask_or_seed(kind, launch, capfd):
    words = launch(kind, "--world", "CartPole", "--areas", "3", key=KEY)
    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", 3, launch=words)
    flat, seeds = to_array([1, 1, 1], np.uint8), to_array([1, 2, 3], np.int64)
    for wrong in (
        [to_array(np.zeros((3, 2)), np.uint8), seeds],
        [flat, to_array([np.nan] * 3, np.float64)],
        [flat, to_array([1, 2, 3], np.float64)],
    ):
        with pytest.raises(MessageError, match=r"wrong-areas|bad-dtype"):
            envs.areas.ask("reset", {}, wrong)
    envs.close()
    assert "Traceback" not in capfd.readouterr().err


# From a user

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
    for value in values:
        with pytest.raises((ValueError, TypeError), match=rf"^(bad )?{name} .*[^\n]$"):
            call(**words, **{name: value})
        gc.collect()


def test_options_that_are_no_dict_are_named(areas):
    for options in (0, "abc", [1], NAN):
        with pytest.raises(ValueError, match=r"^options must be a dict, without seed"):
            areas.reset(options=options)


UNSENDABLE = {
    "no dict": ([1], "is no dict"),
    "a list": ({"a": [1]}, "'a' of '' must be text, a number, true or false"),
    "a number for a name": ({5: 1}, "5 of '' must be text, a number, true or false"),
    "too large": ({"a": 2**70}, "'a' of '' is too large to be exact"),
    "half a character": ({"a": "\ud800"}, "surrogates not allowed"),
    "no number": ({"a": float("nan")}, "not JSON compliant"),
}


@pytest.mark.parametrize("what", UNSENDABLE)
def test_an_info_that_cannot_be_sent_is_named_before_it_is(what, game):
    info, said = UNSENDABLE[what]
    with pytest.raises(ValueError, match=said):
        game.send_info(info)
    assert len(game.step(dict.fromkeys(game.agents, 0))[0]) == 5, "it goes on"


def test_infos_take_numpys_numbers():
    info = {"a": np.float32(0.5), "b": np.int32(3), "c": np.bool_(True)}
    assert unpack(pack([("", info)])) == [("", {"a": 0.5, "b": 3, "c": True})]


@pytest.mark.parametrize("actions", [None, [0] * 5, 0, {}])
def test_actions_that_are_no_dict_are_named(actions, game):
    text = f"actions {actions}, but those that live are ['hunter_0', "
    with pytest.raises(ValueError, match=f"^{re.escape(text)}"):
        game.step(actions)


def test_actions_of_another_dtype_are_those_of_the_space(areas):
    with pytest.raises(gymnasium.error.ResetNeeded):
        areas.step(np.ones(3, int))
    seen, _ = areas.reset(seed=1)
    seen, *_ = areas.step(np.ones(3, np.int32))
    areas.reset(seed=1)
    assert np.array_equal(areas.step(np.ones(3, np.int64))[0], seen)


def test_a_seed_that_no_simulator_could_read_is_named(areas):
    for seed in (EXACT, EXACT - 1, 2**63, [1, None, 2**70], -1, "abc", [1, NAN, 2]):
        with pytest.raises(ValueError, match=r"3 seeds are not one for each of 3 areas, below 2\*\*53"):
            areas.reset(seed=seed)
    with pytest.raises(ValueError, match=r"^1 seeds are not one for each of 3 areas"):
        areas.reset(seed=0.5)
    areas.reset(seed=np.array([1, 2, 3]))
    assert areas.np_random_seed == (1, 2, 3)
    areas.reset(seed=EXACT - 3)
    assert areas.np_random_seed == (EXACT - 3, EXACT - 2, EXACT - 1)
    assert len(areas.np_random) == 3


@pytest.mark.parametrize("mode", ["rgb_array_list", "human"])
def test_a_render_mode_that_would_draw_nothing_is_refused_before_anybody_is_waited_for(mode):
    for kind in ZmqParallelEnv, lambda **words: gymnasium.make_vec("NetMQExample/CartPole-v0", 2, **words):
        with pytest.raises(ValueError, match=f"^render_mode takes 'rgb_array' or None, not '{mode}'"):
            kind(render_mode=mode)


def test_render_without_a_render_mode_says_why_there_is_no_picture(areas, game, make, launch):
    for env in areas, game, make(launch=launch("python")):
        env.reset(seed=1)
        with pytest.warns(UserWarning, match=r"render gives no picture: make the environment with render_mode="):
            assert env.render() is None


def test_what_was_seen_last_is_the_environments_own(areas, game):
    """A user who changes what was given out changes nothing else."""
    seen, _ = areas.reset(seed=1)
    kept = seen.copy()
    seen[:] = 9
    areas.areas.simulators.process.kill()
    areas.areas.simulators.process.wait()
    assert np.array_equal(areas.step(np.ones(3, int))[0], kept)
    seen, _ = game.reset(seed=1)
    kept = {name: one.copy() for name, one in seen.items()}
    for one in seen.values():
        one[:] = 9
    game.remote.simulators.process.kill()
    game.remote.simulators.process.wait()
    last, *_ = game.step(dict.fromkeys(game.agents, 0))
    assert all(np.array_equal(last[name], kept[name]) for name in kept)
