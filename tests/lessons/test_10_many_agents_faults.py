"""Lesson 10, what can go wrong: simulators that are lost, too many or wrong, and what may be left behind."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
import zmq

from tests.conftest import CLIENTS
from tests.programs import finds_processes, free_port

gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: pip install gymnasium")
np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: pip install numpy")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: pip install pettingzoo")

KEY = "10_many_agents"
import netmq_example.envs  # noqa: E402, F401
from netmq_example.envs.connection import Lost  # noqa: E402
from netmq_example.envs.parallel_env import RemoteAgents, ZmqParallelEnv  # noqa: E402
from netmq_example.envs.vector_env import RemoteAreas  # noqa: E402
from netmq_example.infos import LONGEST, pack  # noqa: E402
from netmq_example.messages import Message, MessageError, read  # noqa: E402
from netmq_example.simulation.agents import AgentSimulator  # noqa: E402
from netmq_example.simulation.areas import AreaSimulator  # noqa: E402
from netmq_example.spaces import to_array  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402
from netmq_example.worlds.pursuit import Pursuit  # noqa: E402

each_client = pytest.mark.parametrize("kind", CLIENTS)
each_terminal = pytest.mark.parametrize("kind", ["python", "csharp"])


@pytest.fixture
def made(launch):
    """made("areas", "python") or made("agents", "csharp"): what was made is closed at the end of the test."""
    environments = []

    def make(form, kind="python", count=3, told=None, **where):
        words = ["--world", "CartPole", "--areas", str(told or count)] if form == "areas" else []
        where = {"launch": launch(kind, *words, key=KEY), **where}
        environments.append(
            gymnasium.make_vec("NetMQExample/CartPole-v0", count, **where)
            if form == "areas"
            else ZmqParallelEnv(**where)
        )
        return environments[-1]

    yield make
    for environment in environments:
        environment.close()


def process(environment):
    remote = environment.areas if hasattr(environment, "areas") else environment.remote
    return remote.simulators.process


def kill(environment):
    process(environment).kill()
    process(environment).wait()


# Lost


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_a_killed_simulator_ends_all_areas_and_they_begin_anew_in_another(mode, made):
    envs = made("areas", autoreset_mode=mode)
    begin, _ = envs.reset(seed=7)
    seen, *_ = envs.step(np.ones(3, int))
    kill(envs)
    last, rewards, terminated, truncated, infos = envs.step(np.ones(3, int))
    assert (rewards.tolist(), terminated.any(), truncated.all()) == ([0, 0, 0], False, True)
    if mode == "SameStep":
        assert all(np.array_equal(*pair) for pair in zip(infos["final_obs"], seen, strict=True))
        infos, again = infos["final_info"], last
    else:
        assert np.array_equal(last, seen), "nobody knows what came after"
        whole = {"options": {"reset_mask": np.ones(3, bool)}}
        again = envs.reset(**whole)[0] if mode == "Disabled" else envs.step(np.ones(3, int))[0]
    assert infos["lost"].tolist() == ["the simulator is gone"] * 3 and infos["_lost"].all()
    assert abs(again).max() <= 0.05, "all of them began"
    *_, truncated, infos = envs.step(np.ones(3, int))
    assert not truncated.any() and infos == {}
    assert np.array_equal(envs.reset(seed=7)[0], begin)


def test_who_is_lost_when_only_some_begin_anew_ends_as_well(made):
    envs = made("areas", autoreset_mode="Disabled")
    envs.reset(seed=1)
    kill(envs)
    _, infos = envs.reset(options={"reset_mask": np.array([True, False, False])})
    assert infos["_lost"].tolist() == [False, True, True]


def test_who_is_lost_between_a_step_and_the_reset_in_it_ends_as_well(made):
    """The first area's time is up, and then the simulator is gone."""
    envs = made("areas", autoreset_mode="SameStep", max_episode_steps=2)
    envs.reset(seed=1)
    envs.areas.steps[0] = 1
    ask = envs.areas.ask

    def ask_and_kill(*request):
        answer = ask(*request)
        if request[0] == "step":
            kill(envs)
        return answer

    envs.areas.ask = ask_and_kill
    seen, _, _, truncated, infos = envs.step(np.ones(3, int))
    assert truncated.all() and infos["_final_obs"].tolist() == [True, False, False]
    assert infos["_lost"].tolist() == [False, True, True]
    assert abs(seen).max() <= 0.05


@each_client
def test_a_killed_simulator_ends_the_game_and_the_next_one_starts_another(kind, made):
    env = made("agents", kind)
    begin, _ = env.reset(seed=7)
    kill(env)
    actions = dict.fromkeys(env.agents, 0)
    seen, rewards, terminated, truncated, infos = env.step(actions)
    assert all(np.array_equal(seen[agent], begin[agent]) for agent in actions)
    assert (set(rewards.values()), set(terminated.values()), set(truncated.values())) == ({0.0}, {False}, {True})
    assert set(map(str, infos.values())) == {"{'lost': 'the simulator is gone'}"} and env.agents == []
    with pytest.raises(ConnectionError, match="the simulator is gone"):
        env.send_info({"anybody": "there"})
    again, _ = env.reset(seed=7)
    assert all(np.array_equal(again[agent], begin[agent]) for agent in actions)


def test_who_is_lost_at_the_reset_as_well_begins_once_more(made, monkeypatch):
    """Such as when lesson 17's hub is started anew twice; and whom each reset ends is given up."""
    envs = made("areas", "python")
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


@each_terminal
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


@each_terminal
def test_a_simulator_of_areas_tells_a_single_environment_what_it_is(kind, made, make, launch):
    env = make(launch=launch(kind, "--world", "CartPole", "--areas", "4", key=KEY))
    with pytest.raises(MessageError, match=r"no-mask: this simulator has 4 areas: make_vec\(…, num_envs=4\)"):
        env.reset()


@each_terminal
def test_actions_outside_their_space_are_refused_and_nobody_has_moved(kind, made):
    envs = made("areas", kind)
    seen, _ = envs.reset(seed=1)
    for actions in (np.array([0, 1, 2]), np.array([0, 1]), np.zeros(3)):
        with pytest.raises(ValueError, match=r"are not in MultiDiscrete\(\[2 2 2\]\)"):
            envs.step(actions)
    # And when they come all the same, the simulator refuses them.
    actions = to_array([1, 1, 2], np.int64)
    with pytest.raises(MessageError, match=r"not-in-space: .* is not in Discrete\(2\)"):
        envs.areas.ask("step", {}, [actions])
    with pytest.raises(MessageError, match="wrong-areas"):
        envs.areas.ask("step", {}, [to_array([1, 1], np.int64)])
    mask, seeds = to_array([0, 0, 0], np.uint8), to_array([0, 0, 0], np.int64)
    assert np.array_equal(envs.areas.read(envs.areas.ask("reset", {}, [mask, seeds]))[0], seen)


def test_a_wrong_mask_or_seed_is_named(made):
    envs = made("areas", autoreset_mode="Disabled", max_episode_steps=1)
    envs.reset(seed=1)
    for mask in (np.zeros(3, bool), np.ones(2, bool), [1, 0, 1]):
        with pytest.raises(ValueError, match="reset_mask must be 3 times true or false, one of them true"):
            envs.reset(options={"reset_mask": mask})
    with pytest.raises(ValueError, match="2 seeds are not one for each of 3 areas"):
        envs.reset(seed=[1, 2])
    envs.step(np.ones(3, int))
    with pytest.raises(ValueError, match=r"areas \[0 1 2\] are over: reset"):
        envs.step(np.ones(3, int))


@each_client
def test_an_agent_nobody_knows_and_an_action_outside_its_space(kind, made):
    env = made("agents", kind)
    env.reset(seed=1)
    fine = dict.fromkeys(env.agents, 0)
    for wrong in ({**fine, "ghost": 0}, {"hunter_0": 0}):
        with pytest.raises(ValueError, match=r"actions \{'hunter_0'.*, but those that live are \['hunter_0', "):
            env.step(wrong)
    with pytest.raises(ValueError, match=r"action 5 of rabbit_1 is not in Discrete\(5\)"):
        env.step({**fine, "rabbit_1": 5})
    with pytest.raises(MessageError, match=r"not-in-space: .* is not in Discrete\(5\)"):
        env.remote.ask("step", {}, [to_array(0, np.int64)] * 4 + [to_array(5, np.int64)])
    with pytest.raises(MessageError, match="wrong-agents: 4 actions, but 5 agents live"):
        env.remote.ask("step", {}, [to_array(0, np.int64)] * 4)
    with pytest.raises(MessageError, match=r"unknown-agent: .*ghost"):
        env.remote.ask("info", {"infos": pack([("ghost", {})])}, [])
    with pytest.raises(MessageError, match="bad-infos"):
        env.remote.ask("info", {"infos": '{"a": [1]}'}, [])
    with pytest.raises(ValueError, match="agent 'ghost' is none of"):
        env.send_info({}, "ghost")
    with pytest.raises(ValueError, match=f"at most {LONGEST} characters"):
        env.send_info({"long": "x" * LONGEST})
    assert set(env.step(fine)[0]) == set(fine), "it goes on"


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


# By hand, and nothing is left


def test_by_hand_it_plays_without_python(start, client_command):
    """Nobody presses a key: all rest until no hunter has energy, after 100 steps."""
    client = start(*client_command("unity", KEY, f"tcp://127.0.0.1:{free_port()}", "--byHand", "true"))
    assert re.match(r"by hand: \d+ steps, return -?\d", client.wait_for("^by hand: .*")[0])
    assert "asking" not in client.output


@pytest.mark.parametrize("form", ["areas", "agents"])
def test_it_may_be_closed_twice(form, made):
    environment = made(form)
    running = process(environment)
    environment.close()
    environment.close()
    assert running.poll() is not None


@finds_processes
@pytest.mark.long
@each_terminal
@pytest.mark.parametrize("form", ["areas", "agents"])
def test_a_thousand_resets_leave_nothing_behind(form, kind, made):
    environment = made(form, kind)

    def held():
        pages = Path(f"/proc/{process(environment).pid}/statm").read_text(encoding="ascii").split()[1]
        return len(os.listdir("/proc/self/fd")), int(pages)

    # What .NET has compiled and collected by then, it keeps.
    for number in range(3000):
        environment.reset(seed=number)
        if number == 2000:
            before = held()
    after = held()
    assert after[0] == before[0]
    assert after[1] - before[1] < 1500, "pages of 4 kB"
