"""Lesson 17: a hub, simulators that come and go, and trainers that never notice."""

from __future__ import annotations

import re
import runpy
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest
import zmq

from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import bind
from tests.programs import ROOT, finished, free_port, python_runs, steady_endpoint, steady_port

gymnasium = pytest.importorskip("gymnasium", reason="lesson 17 needs gymnasium: kit.py run 17 installs it")
np = pytest.importorskip("numpy", reason="lesson 17 needs numpy: kit.py run 17 installs it")

from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402

KEY = "17_many_machines"
TRAIN = ROOT / "python" / KEY / "train.py"
import netmq_example.envs  # noqa: E402, F401
from netmq_example import messages  # noqa: E402
from netmq_example.envs.side_channels import carry  # noqa: E402
from netmq_example.fleet.hub import Hub  # noqa: E402
from netmq_example.fleet.members import Episode, Member  # noqa: E402
from netmq_example.fleet.simulator import FleetSimulator  # noqa: E402
from netmq_example.fleet.trainer import FleetSocket  # noqa: E402
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager  # noqa: E402
from netmq_example.scene.simulator import Simulator  # noqa: E402
from netmq_example.security import keys  # noqa: E402
from netmq_example.wire import records  # noqa: E402
from netmq_example.wire.records import ANSWERS, ASKS, Record, seeds  # noqa: E402
from netmq_example.wire.split_mix import draws  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402

each_client = pytest.mark.parametrize("kind", CLIENTS)
ID = "NetMQExample/CartPole-v0"
# An idle simulator goes home after 15 s, and on a busy machine others take longer to start.
STAY = ("--idle", "600")


def returns(episodes):
    """The returns that train.py reaches with each seed, played without a network."""
    world, found = CartPole(), []
    for seed in range(episodes):
        world.reset(draws(seed), {}, [])
        steps, over = 0, False
        while not over:
            world.apply(int(world.observe()[2] > 0))
            steps, over = steps + 1, world.reward_and_end()["terminated"]
        found.append(steps)
    return found


FORGOTTEN = """
import gc, sys, zmq
from netmq_example.fleet.trainer import FleetSocket
gc.disable()
for asked in (False, True):
    socket = FleetSocket(sys.argv[1], "CartPole", 1)
    if asked:
        try:
            socket.recv_multipart()
        except zmq.Again:
            pass
    socket.itself = socket
    del socket
    print(gc.collect() > 0)
"""


def test_a_socket_of_the_fleet_that_nobody_closed_may_be_forgotten():
    """In a cycle of references, as of a traceback, where its context may be the first to go."""
    done = finished([PYTHON, "-c", FORGOTTEN, f"tcp://127.0.0.1:{steady_port()}"], cwd=ROOT / "python")
    assert done.stdout == "True\nTrue\n", done


@pytest.fixture
def simulators(start_client):
    """simulators(endpoint, "python", "csharp"): started side by side, and each is in the fleet."""

    def some(endpoint, *kinds, words=()):
        programs = [start_client(kind, KEY, endpoint, *words) for kind in kinds]
        for program in programs:
            program.wait_for("^simulating CartPole")
        return programs

    return some


@pytest.fixture
def train(start):
    """train(endpoint, 2, 10): two areas, ten episodes; a running trainer."""

    def program(endpoint, areas, episodes, *words):
        numbers = ["--areas", str(areas), "--episodes", str(episodes)]
        return start(PYTHON, TRAIN, "--endpoint", endpoint, *numbers, "--each", *words)

    return program


def without_endpoint(command):
    at = command.index("--endpoint")
    return command[:at] + command[at + 2 :]


def played(trainer, code=0):
    """The return of each episode."""
    assert trainer.wait() == code, trainer.output
    return [int(steps) for steps in re.findall(r"^seed \d+: return (\d+)$", trainer.output, re.MULTILINE)]


def test_what_is_played_over_the_hub_is_what_is_played_without_also_where_a_simulator_dies(serve, simulators, train):
    """Its episode is begun anew elsewhere, and counts once."""
    hub, endpoint = serve(KEY, *STAY, "--late", "600")
    # The hub takes the one that has been free for longest.
    (mortal,) = simulators(endpoint, "python", words=["--crash-after", "20"])
    simulators(endpoint, *CLIENTS)
    assert played(train(endpoint, 3, 9)) == returns(9)
    assert mortal.wait() == 1
    assert mortal.lines[-1] == "crash after 20 steps, as told"
    hub.wait_for(r"^simulator 1 is gone: its connection is$")
    hub.wait_for(r", 1 begun anew, 0 asked elsewhere$")


@each_client
def test_a_simulator_without_work_is_sent_home_and_another_build_is_refused_by_name(kind, serve, runs):
    hub, endpoint = serve(KEY, "--build", "7", "--idle", "0.5")
    place = ["--endpoint", endpoint, "--timeout"]
    stranger, home = runs(kind, KEY, [[*place, "3", "--build", "six"], [*place, "60", "--build", "7"]])
    assert home.code == 0, home.lines
    assert home.lines[-1] == "done: 0 episodes, 0 steps" or kind == "unity"
    hub.wait_for("^simulator 1 is gone: nothing to do for 0.5 s$")
    text = "other-build: 'CartPole' of build 'six', this hub takes '7': use one build everywhere"
    hub.wait_for(f"^refused: {text}$")
    assert stranger.code == 1
    assert any("gave up: " in line and text in line for line in stranger.lines), stranger.lines
    # It has tried for three seconds.
    assert hub.lines.count(f"refused: {text}") == 1


@each_client
def test_a_client_does_as_it_is_told_and_says_hello_again_to_a_silent_hub(kind, context, start_client):
    """A hub that was started anew is silent to whoever did not notice."""
    with context.socket(zmq.ROUTER) as hub:
        place = bind(hub)
        trouble = ["--crash-after", "2", "--delay", "0.3"] if kind != "unity" else []
        client = start_client(kind, KEY, place, "--build", "7", *trouble)
        peers = set()
        for silence in (0.5, 600.0):
            peer, *frames = hub.recv_multipart()
            hello = messages.Message.read(frames)
            assert (hello.kind, hello.values["build"]) == ("hello", "7")
            hub.send_multipart([peer, *messages.Message("welcome", 0, {"silence": silence}).frames()])
            peers.add(peer)
        assert len(peers) == 2
        if kind == "unity":
            return
        for number, order in enumerate([records.RESET, *[records.STEP] * 3], 1):
            begin = time.monotonic()
            request = Record(ASKS, number, seeds([3]), [order], [bytes(8) if order == records.STEP else b""])
            hub.send_multipart([peer, request.frame()])
            if number < 4:
                assert records.read(ANSWERS, hub.recv_multipart()[1]).id == number
                assert time.monotonic() - begin > 0.29 * (order == records.STEP)
        assert client.wait() == 1
        assert client.lines[-1] == "crash after 2 steps, as told"


def test_a_trainer_waits_for_as_many_simulators_as_it_has_areas(serve, simulators, caplog):
    _, endpoint = serve(KEY, *STAY)
    simulators(endpoint, "python")
    why = "the hub has 1 simulators of 'CartPole', of which 0 are taken: 2 are needed"
    with (
        FleetSocket(endpoint, "CartPole", 2) as socket,
        pytest.raises(TimeoutError, match=f"^no simulator came to {endpoint} within 3 s; {why}$"),
    ):
        gymnasium.make_vec(ID, 2, socket=socket, wait=3)
    assert why in caplog.messages


def test_a_trainer_says_in_one_line_what_is_wrong(context):
    """With the endpoint, without a hub, and with a hub that is not the kit's."""
    with context.socket(zmq.ROUTER) as strange, ThreadPoolExecutor() as pool:
        nobody = f"tcp://127.0.0.1:{free_port()}"
        words = [["nonsense"], [bind(strange)], [nobody, "--areas", "1", "--timeout", "3"]]
        trainers = pool.submit(python_runs, TRAIN, [["--endpoint", *each] for each in words])
        peer, *_ = strange.recv_multipart()
        strange.send_multipart([peer, *messages.Message("alive").frames()])
        bad, other, alone = trainers.result()
    assert (bad.code, other.code, alone.code) == (2, 1, 1)
    assert bad.lines[-1].endswith("bad endpoint 'nonsense': write it like tcp://127.0.0.1:5567")
    # On a busy machine the hub's answer comes late.
    said = [line for line in other.lines[1:] if not line.startswith("no answer from a hub at tcp://127.0.0.1:")]
    assert said == ["gave up: missing-field: there is no 'simulators'"]
    text = f"no answer from a hub at {nobody}: is it there, without keys?"
    assert alone.lines[-2:] == [text, f"gave up: no simulator came to {nobody} within 3 s; {text}"]


def test_a_hub_that_was_killed_gets_all_back_and_no_return_changes(serve, simulators, train):
    place = steady_endpoint()
    hub, endpoint = serve(KEY, *STAY, endpoint=place)
    # So slow that it is not done before.
    simulators(endpoint, "python", "csharp", words=["--delay", "0.02"])
    trainer = train(endpoint, 2, 16)
    hub.wait_for(r"^2 simulators, \d free, 1 trainers, 1 at work, [1-9]\d* episodes")
    hub.kill()
    serve(KEY, *STAY, endpoint=place)
    assert played(trainer) == returns(16)
    assert f"asking the hub at {place} anew" in trainer.lines
    assert trainer.lines.count("the hub has given this trainer 2 simulators") == 2


def test_a_trainer_says_that_it_waits_for_another_simulator(serve, simulators, train):
    _, endpoint = serve(KEY, *STAY)
    simulators(endpoint, "python", words=["--crash-after", "20"])
    trainer = train(endpoint, 1, 3)
    trainer.wait_for("^1 of 1 episodes wait for a simulator: start one, if none comes$")
    simulators(endpoint, "python")
    assert played(trainer) == returns(3)
    assert trainer.lines.count("each episode has a simulator again") == 1


def test_an_episode_that_is_lost_while_another_begins_is_begun_anew():
    class Lost:
        """Two areas whose episodes take two and three steps; at the first reset of one, the other is lost."""

        num_envs, resets, steps = 2, 0, np.zeros(2)

        def reset(self, seed, options=None):
            mask = options["reset_mask"] if options else np.ones(2, bool)
            self.resets += 1
            lost = ~mask if self.resets == 2 else np.zeros(2, bool)
            self.steps = np.where(mask | lost, 0, self.steps)
            return np.zeros((2, 4)), {"_lost": lost, "lost": lost} if lost.any() else {}

        def step(self, actions):
            self.steps = self.steps + 1
            return np.zeros((2, 4)), np.ones(2), self.steps == [2, 3], np.zeros(2, bool), {}

    # Lesson 09 has a train.py as well.
    train = runpy.run_path(str(TRAIN))
    assert train["play"](Lost(), 3) == [2, 3, 2]


def test_deaths_by_chance_are_not_taken_for_what_ends_each_simulator():
    begun = Episode(Record(ASKS, 0, seeds([0]), [records.RESET], [b""]), lambda: None)
    for number, done in enumerate([*(i % 5 for i in range(40)), *[7] * 9]):
        run = Member(number, "CartPole", lambda message: True)
        run.lease(begun)
        run.done = done
        begun.lost_by(run)
        assert begun.lost == (1 if number < 40 else number - 39)


# Lesson 10's environment, unchanged


def test_side_channels_are_refused_by_the_hub_and_not_lost(serve, simulators):
    _, endpoint = serve(KEY, *STAY)
    simulators(endpoint, "python")
    with FleetSocket(endpoint, "CartPole", 1) as socket:
        envs = gymnasium.make_vec(ID, 1, socket=socket)
        carry(envs, SideChannelManager([]))
        with pytest.raises(messages.MessageError, match="no-side-channels: the hub hands none on: give them a connec"):
            envs.reset()
        envs.close()


def test_the_vector_environment_sees_the_same_over_the_hub(serve, simulators, client_command):
    _, endpoint = serve(KEY, *STAY)
    simulators(endpoint, "python", "python")
    launch = client_command("python", "10_many_agents", "nowhere", "--world", "CartPole", "--areas", "2")
    launch = without_endpoint(launch)
    for mode in ("NextStep", "SameStep"):
        with FleetSocket(endpoint, "CartPole", 2) as socket:
            both = [
                gymnasium.make_vec(ID, 2, autoreset_mode=mode, render_mode="rgb_array", **where)
                for where in ({"socket": socket}, {"launch": launch})
            ]
            options = {"low": -0.2, "high": 0.2}
            assert_same(*(envs.reset(seed=[3, 4], options=options) for envs in both))
            # So many that each area begins anew.
            for step in range(40):
                assert_same(*(envs.step(np.array([1, step % 2])) for envs in both))
            assert_same(*(envs.render() for envs in both))
            assert_same(*(envs.reset(options={"state": np.array([0.1, 0, 0, 0])}) for envs in both))
            for envs in both:
                with pytest.raises(messages.MessageError, match="bad-state"):
                    envs.reset(options={"state": np.zeros(3)})
                # It goes on after that.
                envs.reset(seed=1)
                envs.close()


def assert_same(ours, theirs):
    np.testing.assert_equal(plain(ours), plain(theirs))


def plain(found):
    """Without the arrays of arrays, which numpy does not compare."""
    if isinstance(found, dict):
        return {name: plain(value) for name, value in found.items()}
    nested = isinstance(found, (tuple, list)) or (isinstance(found, np.ndarray) and found.dtype == object)
    return [plain(value) for value in found] if nested else found


# Lesson 11's scenes

WALK = """
import sys
from typing import Annotated, Any

import numpy as np

from netmq_example import console
from netmq_example.fleet.simulator import FleetSimulator
from netmq_example.scene.scene import Agent, Obs, SceneSimulator
from netmq_example.scene.simulator import EnvironmentClient


class Walker(Agent):
    place: Annotated[Any, Obs()] = np.zeros(2)
    steps: Annotated[int, Obs("['walked'] = $")] = 0

    def on_reset(self):
        self.steps, self.last = 0, 3 + int(9 * next(self.rng))
        self.place = np.array([next(self.rng), self.options.get("far", 0.0)])

    def on_action(self, action):
        self.place = self.place + action
        self.reward += float(self.place[0])

    def on_tick(self, dt):
        self.steps += 1
        self.terminated = self.steps == self.last
        if self.terminated:
            self.infos.append({"at": self.place, "after": dt * self.steps})


def scene(*names):
    return SceneSimulator("Walk", 0.1, [Walker(name) for name in names])


if __name__ == "__main__":
    console.log_lines()
    EnvironmentClient(sys.argv[1], timeout=60).run(FleetSimulator(scene("agent")))
"""
SPACES = {
    "observation_space": gymnasium.spaces.Dict(
        place=gymnasium.spaces.Box(-99, 99, (2,), np.float64), walked=gymnasium.spaces.Discrete(100)
    ),
    "action_space": gymnasium.spaces.Box(-1, 1, (2,), np.float64),
}


@pytest.fixture
def scene(tmp_path):
    """scene("agent_0", "agent_1"): a simulator of walkers with these names."""
    (tmp_path / "walk.py").write_text(WALK, encoding="utf-8")
    return runpy.run_path(str(tmp_path / "walk.py"))["scene"]


def walkers(count, socket, **more):
    return gymnasium.make_vec("NetMQExample/Unity-v0", count, env_name="Walk", **SPACES, socket=socket, **more)


def test_scenes_of_a_hub_are_to_python_what_the_agents_of_one_scene_are(serve, start, scene, inside, make, tmp_path):
    """And what single environments of as many scenes are, whose infos say more."""
    _, endpoint = serve(KEY, *STAY)
    for _ in range(2):
        start(PYTHON, tmp_path / "walk.py", endpoint, PYTHONPATH=str(ROOT / "python")).wait_for("^simulating Walk")
    for mode in AutoresetMode:
        words = {"autoreset_mode": mode, "max_episode_steps": 9}
        singles = [inside(scene("agent")).socket for _ in range(2)]
        with FleetSocket(endpoint, "Walk", 2) as socket:
            ours = walkers(2, socket, **words)
            one = walkers(2, inside(scene("agent_0", "agent_1")).socket, **words)
            apart = SyncVectorEnv([partial(make_walker, make, single) for single in singles], autoreset_mode=mode)
            all_of_them, ends = [ours, one, apart], np.zeros(2, int)
            assert_walk_alike([each.reset(seed=[3, 8], options={"far": 2.5}) for each in all_of_them])
            ours.action_space.seed(4)
            for _ in range(40):
                action = ours.action_space.sample()
                seen = [each.step(action) for each in all_of_them]
                assert_walk_alike(seen)
                over = seen[0][2] | seen[0][3]
                ends += over
                if mode == AutoresetMode.DISABLED and over.any():
                    assert_walk_alike([each.reset(options={"reset_mask": over.copy()}) for each in all_of_them])
            assert min(ends) >= 3
            for each in all_of_them:
                each.close()


def make_walker(make, socket):
    return make("NetMQExample/Unity-v0", env_name="Walk", **SPACES, socket=socket, max_episode_steps=9)


def assert_walk_alike(found):
    ours, one, apart = found
    assert_same(ours, one)
    assert_same(ours[:-1], apart[:-1])


# Keys, and how a hub is found


def test_with_keys_it_is_found_by_its_own_and_lets_in_whoever_is_on_its_list(
    context, serve, start, client_command, tmp_path, train
):
    port, folder = steady_port(), tmp_path / "keys"
    endpoint = f"tcp://127.0.0.1:{port}"
    keys.example(folder)
    serve(KEY, *STAY, "--keys", str(folder), "--beacon", "hub", endpoint=f"tcp://0.0.0.0:{port}")
    for kind in ("python", "csharp"):
        words = client_command(kind, KEY, f"beacon://hub:{port}", "--keys", str(folder), "--timeout", "60")
        start(*words).wait_for("^simulating CartPole for ")
    with context.socket(zmq.DEALER) as stranger:
        stranger.connect(endpoint)
        stranger.send_multipart(messages.Message("join", 0, {"name": "CartPole", "areas": 1}).frames())
        assert played(train(endpoint, 2, 3, "--keys", str(folder))) == returns(3)
        assert not stranger.poll(0)
    # A client that is not on the list any more is not heard, though its connection is still there.
    keys.revoke(folder, "alice")
    assert played(train(endpoint, 1, 3, "--keys", str(folder), "--timeout", "1"), code=1) == []


def test_a_hub_without_the_keys_it_was_told_says_so(runs):
    nowhere, empty = runs(
        "server", KEY, [["--endpoint", "tcp://127.0.0.1:0", "--keys", folder] for folder in ("nowhere", "")]
    )
    assert nowhere.code == 1
    assert re.search(r"no key in .+nowhere.server\.key_secret; keys\.py makes keys", nowhere.lines[-1])
    assert empty.code in (1, 2) and "listening" not in str(empty.lines)


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_client_without_a_hub_says_why(kind, runs, tmp_path):
    keys.example(tmp_path)
    place = f"127.0.0.1:{free_port()}"
    table = {
        f"tcp://{place}": "this simulator's key on its list? (no connection)",
        place.replace("127.0.0.1", "beacon://hub"): "is a server with --beacon hub in this network",
    }
    found = runs(kind, KEY, [["--endpoint", each, "--keys", str(tmp_path), "--timeout", "2"] for each in table])
    for text, run in zip(table.values(), found, strict=True):
        assert run.code == 1 and text in run.lines[-1], run


class Sent(list):
    """A hub's socket: the messages that it has sent."""

    def send_multipart(self, frames, flags=0):
        self.append(messages.Message.read(frames[1:]))


def test_a_hub_that_was_away_says_first_what_is_missing():
    """On a busy machine it comes to a trainer late, and would have told it nothing but that it is alive."""
    hub = Hub(sent := Sent())
    hub.take(b"trainer", messages.Message("join", 0, {"name": "CartPole", "areas": 2}).frames())
    hub.trainers[b"trainer"].sent -= 10
    hub.tick()
    assert [(one.kind, one.values) for one in sent] == [("alive", {"simulators": 0, "taken": 0})]


def test_a_hub_that_was_stopped_sends_nobody_home():
    """As by `docker compose pause`, or on a virtual machine that was saved: all of them were asleep."""
    hub = Hub(sent := Sent())
    hub.take(b"simulator", FleetSimulator(Simulator(CartPole())).hello().frames())
    hub.tick()
    (member,) = hub.members.values()
    for clock in (vars(hub), vars(member)):
        clock |= {name: at - 100 for name, at in clock.items() if isinstance(at, float) and at > 60}
    hub.tick()
    assert hub.members and "close" not in [one.kind for one in sent]
    member.heard -= 100
    hub.ticked -= 1
    hub.tick()
    assert not hub.members and sent[-1].kind == "close", "this one was silent"
