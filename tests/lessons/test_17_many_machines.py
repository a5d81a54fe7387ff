"""Lesson 17: a hub, simulators that come and go, and trainers that never notice. Cables: test_17_network.py."""

from __future__ import annotations

import re
import runpy
import socket
import sys

import pytest
import zmq

from tests.conftest import CLIENTS, PYTHON
from tests.programs import ROOT, free_port, steady_endpoint

gymnasium = pytest.importorskip("gymnasium", reason="lesson 17 needs gymnasium: pip install gymnasium")
np = pytest.importorskip("numpy", reason="lesson 17 needs numpy: pip install numpy")

KEY = "17_many_machines"
import netmq_example.envs  # noqa: E402, F401
from netmq_example import messages  # noqa: E402
from netmq_example.errors import GaveUp  # noqa: E402
from netmq_example.fleet.beacon import Beacon, find, fingerprint  # noqa: E402
from netmq_example.fleet.hub import Hub  # noqa: E402
from netmq_example.fleet.members import Episode, Member  # noqa: E402
from netmq_example.fleet.simulator import FleetSimulator  # noqa: E402
from netmq_example.fleet.trainer import FleetSocket  # noqa: E402
from netmq_example.security import keys  # noqa: E402
from netmq_example.split_mix import draws  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402

each_client = pytest.mark.parametrize("kind", CLIENTS)
ID = "NetMQExample/CartPole-v0"
# An idle simulator goes home after 15 s, and on a busy machine others take longer to start.
STAY = ("--idle", "600")


def returns(episodes):
    """What train.py reaches with each seed, played without a network."""
    world, found = CartPole(), []
    for seed in range(episodes):
        world.reset(draws(seed), {}, [])
        steps, over = 0, False
        while not over:
            world.apply(int(world.observe()[2] > 0))
            steps, over = steps + 1, world.judge()["terminated"]
        found.append(steps)
    return found


@pytest.fixture
def simulators(start, client_command):
    """simulators(endpoint, "python", "csharp"): started side by side, and each is in the fleet."""

    def some(endpoint, *kinds, words=()):
        programs = [start(*client_command(kind, KEY, endpoint, *words)) for kind in kinds]
        for program in programs:
            program.wait_for("^simulating CartPole")
        return programs

    return some


@pytest.fixture
def train(start):
    """train(endpoint, 2, 10): two areas, ten episodes; a running trainer."""

    def program(endpoint, areas, episodes, *words):
        numbers = ["--areas", str(areas), "--episodes", str(episodes)]
        return start(PYTHON, ROOT / "python" / KEY / "train.py", "--endpoint", endpoint, *numbers, "--each", *words)

    return program


def played(trainer, code=0):
    """The return of each episode."""
    assert trainer.wait() == code, trainer.output
    return [int(steps) for steps in re.findall(r"^seed \d+: return (\d+)$", trainer.output, re.MULTILINE)]


@each_client
def test_what_is_played_over_the_hub_is_what_is_played_without(kind, serve, simulators, train):
    _, endpoint = serve(KEY, *STAY)
    simulators(endpoint, kind, kind)
    assert played(train(endpoint, 2, 12)) == returns(12)


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_whose_simulator_dies_is_begun_anew_elsewhere_and_counts_once(kind, serve, simulators, train, start):
    hub, endpoint = serve(KEY, *STAY)
    simulators(endpoint, "python", "python")
    (mortal,) = simulators(endpoint, kind, words=["--crash-after", "50"])
    assert played(train(endpoint, 2, 20)) == returns(20)
    assert mortal.wait() == 1
    assert mortal.lines[-1] == "crash after 50 steps, as told"
    hub.wait_for(r"^simulator 3 is gone: its connection is$")
    hub.wait_for(r", 1 begun anew, 0 asked elsewhere$")


def test_what_a_straggler_is_late_with_is_asked_for_elsewhere(serve, simulators, train):
    hub, endpoint = serve(KEY, "--late", "0.3", *STAY)
    simulators(endpoint, "python", words=["--delay", "3600"])
    simulators(endpoint, "python")
    assert played(train(endpoint, 1, 4)) == returns(4)
    hub.wait_for(r"[1-9]\d* asked elsewhere$")


@each_client
def test_another_build_is_refused_by_name_on_both_sides(kind, serve, start, client_command):
    hub, endpoint = serve(KEY, "--build", "7")
    stranger = start(*client_command(kind, KEY, endpoint, "--timeout", "5", "--build", "six"))
    text = "other-build: 'CartPole' of build 'six', this hub takes '7': use one build everywhere"
    hub.wait_for(f"^refused: {text}$")
    assert stranger.wait() == 1
    assert any("gave up: " in line and text in line for line in stranger.lines), stranger.output
    # It has tried for five seconds.
    assert hub.lines.count(f"refused: {text}") == 1


def test_a_fleet_that_is_too_small_is_said(serve, simulators, train):
    _, endpoint = serve(KEY, "--timeout", "0.5", *STAY)
    simulators(endpoint, "python")
    simulators(endpoint, "python", words=["--crash-after", "20"])
    trainer = train(endpoint, 2, 20)
    assert played(trainer, code=1) == []
    why = "no-simulator: no simulator for an episode within 0.5 s: 1 are here, start more"
    assert trainer.lines[-1] == f"gave up: {why}"


def test_a_trainer_waits_for_as_many_simulators_as_it_has_areas(serve, simulators, train):
    _, endpoint = serve(KEY, *STAY)
    simulators(endpoint, "python")
    trainer = train(endpoint, 2, 4, "--wait", "5")
    assert played(trainer, code=1) == []
    why = "the hub has 1 simulators of 'CartPole', of which 0 are taken: 2 are needed"
    assert trainer.lines[-2:] == [why, f"gave up: no simulator came to {endpoint} within 5 s; {why}"]


def test_a_trainer_says_that_no_hub_answers(train):
    endpoint = f"tcp://127.0.0.1:{free_port()}"
    trainer = train(endpoint, 1, 1, "--wait", "3")
    assert played(trainer, code=1) == []
    text = f"no answer from a hub at {endpoint}: is it there, without keys?"
    assert trainer.lines[-2:] == [text, f"gave up: no simulator came to {endpoint} within 3 s; {text}"]


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_simulator_with_keys_that_nobody_lets_in_names_them(kind, start, client_command, tmp_path):
    keys.example(tmp_path)
    endpoint = f"tcp://127.0.0.1:{free_port()}"
    client = start(*client_command(kind, KEY, endpoint, "--keys", str(tmp_path), "--timeout", "1"))
    assert client.wait() == 1
    why = "is the server running, and has this simulator's key on its list? (no connection)"
    assert client.lines[-1] == f"gave up: no environment at {endpoint} within 1 s; {why}"


def test_who_trained_and_died_leaves_the_simulators_to_the_next(serve, simulators, train):
    hub, endpoint = serve(KEY, *STAY)
    simulators(endpoint, "python", "python")
    first = train(endpoint, 2, 100_000)
    hub.wait_for(r"^2 simulators, \d free, 1 trainers, 1 at work")
    first.kill()
    assert played(train(endpoint, 2, 6)) == returns(6)


@pytest.mark.timeout(1500)
@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_hub_that_was_killed_gets_all_back_and_no_return_changes(kind, serve, simulators, train):
    place = steady_endpoint()
    hub, endpoint = serve(KEY, *STAY, endpoint=place)
    others = simulators(endpoint, kind, kind)
    # So many that it is not done before.
    trainer = train(endpoint, 2, 400)
    for _ in range(2):
        hub.wait_for(r"^2 simulators, \d free, 1 trainers, 1 at work, [1-9]\d* episodes")
        hub.kill()
        hub, _ = serve(KEY, *STAY, endpoint=place)
    # Some 8,500 steps, each of which wakes four programs: a very busy machine takes many minutes for them.
    try:
        trainer.wait(1200)
    except AssertionError as error:
        said = "\n".join(f"{one.name}:\n{one.output}" for one in (hub, *others))
        raise AssertionError(f"{error}\n{said}") from None
    assert played(trainer) == returns(400)
    assert f"asking the hub at {place} anew" in trainer.lines
    assert trainer.lines.count("the hub has given this trainer 2 simulators") == 3


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
    train = runpy.run_path(str(ROOT / "python" / KEY / "train.py"))
    assert train["play"](Lost(), 3) == [2, 3, 2]


def test_deaths_by_chance_are_not_taken_for_what_ends_each_simulator():
    begun = Episode(messages.Message("reset"), lambda: None)
    for number, done in enumerate([*(i % 5 for i in range(40)), *[7] * 9]):
        run = Member(number, "CartPole", lambda message: True)
        run.lease(begun)
        run.done = done
        begun.lost_by(run)
        assert begun.lost == (1 if number < 40 else number - 39)


@each_client
def test_who_hears_nothing_says_hello_again(kind, context, start, client_command):
    """A hub that was started anew is silent to who did not notice."""
    with context.socket(zmq.ROUTER) as silent:
        silent.linger = 0
        port = silent.bind_to_random_port("tcp://127.0.0.1")
        start(*client_command(kind, KEY, f"tcp://127.0.0.1:{port}"))
        peers = set()
        for _ in range(2):
            assert silent.poll(100_000), "no hello"
            peer, *hello = silent.recv_multipart()
            assert messages.read(hello).kind == "hello"
            silent.send_multipart([peer, *messages.Message("welcome", 0, {"silence": 0.5}).frames()])
            peers.add(peer)
        assert len(peers) == 2


def test_who_has_no_work_is_sent_home(serve, simulators):
    hub, endpoint = serve(KEY, "--idle", "0.5")
    (idle,) = simulators(endpoint, "python")
    assert idle.wait() == 0
    assert idle.lines[-1] == "done: 0 episodes, 0 steps"
    hub.wait_for("^simulator 1 is gone: nothing to do for 0.5 s$")


# Lesson 10's environment, unchanged


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_the_vector_environment_sees_the_same_over_the_hub(mode, serve, simulators, start, client_command):
    _, endpoint = serve(KEY, *STAY)
    simulators(endpoint, "python", "python")
    launch = client_command("python", "10_many_agents", "nowhere", "--world", "CartPole", "--areas", "2")
    at = launch.index("--endpoint")
    del launch[at : at + 2]
    with FleetSocket(endpoint, "CartPole", 2) as socket:
        both = [
            gymnasium.make_vec(ID, 2, autoreset_mode=mode, render_mode="rgb_array", **where)
            for where in ({"socket": socket}, {"launch": launch})
        ]
        options = {"low": -0.2, "high": 0.2}
        assert_same(*(envs.reset(seed=[3, 4], options=options) for envs in both))
        for step in range(120):
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


# Strangers


def test_a_simulator_that_answers_nonsense_is_let_go_and_its_episode_goes_elsewhere(context, serve, simulators, train):
    hub, endpoint = serve(KEY, *STAY)
    with context.socket(zmq.DEALER) as liar:
        liar.linger = 0
        liar.connect(endpoint)
        low = np.array([-4.8, -3.4028235e38, -0.41887903, -3.4028235e38], np.float32)
        box = [messages.Array("float32", (4,), bound.tobytes()) for bound in (low, -low)]
        two = messages.Array("int64", (), np.int64(2).tobytes())
        values = {"name": "CartPole", "dt": 0.02, "observation": "box", "action": "discrete"}
        liar.send_multipart(messages.Message("hello", 0, values, [*box, two]).frames())
        assert messages.read(liar.recv_multipart()).kind == "welcome"
        trainer = train(endpoint, 1, 3)
        while (request := messages.read(liar.recv_multipart())).kind != "reset":
            pass
        wrong = messages.Array("float32", (3,), bytes(12))
        liar.send_multipart(messages.Message("state", request.id, {}, [wrong]).frames())
        hub.wait_for("^simulator 1 is gone: its answer is not what it has announced$")
        simulators(endpoint, "python")
        assert played(trainer) == returns(3)


# Keys, and how a hub is found


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_with_keys_it_lets_in_who_is_on_its_list(kind, serve, start, client_command, tmp_path, train):
    folder = tmp_path / "keys"
    keys.example(folder)
    _, endpoint = serve(KEY, *STAY, "--keys", str(folder))
    stranger = start(*client_command("python", KEY, endpoint, "--timeout", "1"))
    start(*client_command(kind, KEY, endpoint, "--keys", str(folder))).wait_for("^simulating CartPole")
    assert played(train(endpoint, 1, 3, "--keys", str(folder))) == returns(3)
    assert stranger.wait() == 1
    # Who is not on the list any more is not heard, though its connection is still there.
    keys.revoke(folder, "alice")
    assert played(train(endpoint, 1, 3, "--keys", str(folder), "--wait", "1"), code=1) == []


def test_a_hub_without_the_keys_it_was_told_says_so(start):
    hub = start(PYTHON, ROOT / "python" / KEY / "server.py", "--endpoint", "tcp://127.0.0.1:0", "--keys", "nowhere")
    assert hub.wait() == 1
    assert re.search(r"no key in .+nowhere.server\.key_secret; keys\.py makes keys", hub.lines[-1])


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has a broadcast address on its loopback")
@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_hub_is_found_by_its_beacon_and_by_its_key(kind, serve, start, console, tmp_path):
    port, folder = free_port(), tmp_path / "keys"
    keys.example(folder)
    first, _ = serve(KEY, "--announce", f"127.255.255.255:{port}")
    command = [PYTHON, ROOT / "python" / KEY / "client.py"] if kind == "python" else [*console, KEY]
    with_keys = start(*command, "--find", str(port), "--keys", str(folder), "--timeout", "10")
    without = start(*command, "--find", str(port), "--timeout", "20")
    without.wait_for("^simulating CartPole")
    # The other one passes over a hub that is not its own.
    assert with_keys.wait() == 1
    heard = f"gave up: no hub was heard on UDP port {port} within 10 s, only"
    cure = "have both sides the same server.key?"
    assert with_keys.lines[-1] == f"{heard} of another key, 127.0.0.1; {cure}"
    first.stop()
    _, endpoint = serve(KEY, "--announce", f"127.255.255.255:{port}", "--keys", str(folder))
    found = start(*command, "--find", str(port), "--keys", str(folder), "--timeout", "20")
    found.wait_for(f"^simulating CartPole for {endpoint}$")
    without = start(*command, "--find", str(port), "--timeout", "10")
    assert without.wait() == 1
    assert without.lines[-1] == f"{heard} one that has keys, 127.0.0.1; give its keys"


class NoSocket:
    def send_multipart(self, frames, flags=0):
        raise AssertionError("nothing is sent")


def test_a_hub_that_was_away_says_first_what_is_missing():
    """On a busy machine it comes to a trainer late, and would have told it nothing but that it is alive."""
    sent = []

    class Socket:
        def send_multipart(self, frames, flags=0):
            sent.append(messages.read(frames[1:]))

    hub = Hub(Socket())
    hub.take(b"trainer", messages.Message("join", 0, {"name": "CartPole", "areas": 2}).frames())
    hub.trainers[b"trainer"].sent -= 10
    hub.tick()
    assert [(one.kind, one.values) for one in sent] == [("alive", {"simulators": 0, "taken": 0})]


def test_a_trainer_says_in_one_line_what_it_cannot_read(context, start):
    """From a hub that is not the kit's."""
    router = context.socket(zmq.ROUTER)
    port = router.bind_to_random_port("tcp://127.0.0.1")
    trainer = start(PYTHON, ROOT / "python" / KEY / "train.py", "--endpoint", f"tcp://127.0.0.1:{port}")
    peer, _ = router.recv_multipart()[:2]
    router.send_multipart([peer, *messages.Message("alive").frames()])
    assert trainer.wait() == 1
    assert trainer.lines[-1] == "gave up: missing-field: there is no 'simulators'", trainer.output
    assert "Traceback" not in trainer.output


@pytest.mark.parametrize(
    ("name", "attempt"),
    [
        *(("socket", lambda it=it: Hub(it)) for it in (0, None, "x", [])),
        ("report", lambda: Hub(NoSocket(), None)),
        ("build", lambda: Hub(NoSocket(), build=1)),
        ("late", lambda: Hub(NoSocket(), late=0)),
        ("timeout", lambda: Hub(NoSocket(), timeout=float("nan"))),
        ("idle", lambda: Hub(NoSocket(), idle=None)),
        ("where", lambda: Beacon("255.255.255.256:5567", "tcp://127.0.0.1:5567")),
        ("where", lambda: Beacon("", "tcp://127.0.0.1:5567")),
        ("endpoint", lambda: Beacon(None, "tcp://127.0.0.1:0")),
        ("key", lambda: fingerprint("")),
        ("key", lambda: find(5567, None, 1)),
        ("port", lambda: find(0, b"", 1)),
        ("timeout", lambda: find(5567, b"", -1)),
        ("crash_after", lambda: FleetSimulator(CartPole(), crash_after=-1)),
        ("delay", lambda: FleetSimulator(CartPole(), delay="1")),
        ("build", lambda: FleetSimulator(CartPole(), None)),
        ("endpoint", lambda: FleetSocket(None, "CartPole", 1)),
        ("name", lambda: FleetSocket("tcp://127.0.0.1:5567", "", 1)),
        ("areas", lambda: FleetSocket("tcp://127.0.0.1:5567", "CartPole", 0)),
        ("prepare", lambda: FleetSocket("tcp://127.0.0.1:5567", "CartPole", 1, "keys")),
    ],
)
def test_what_cannot_be_is_named_at_once(name, attempt):
    with pytest.raises((TypeError, ValueError), match=rf"^(bad )?{name}\b.*$"):
        attempt()


def test_a_udp_port_that_is_taken_is_no_timeout():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("", 0))
        with pytest.raises(GaveUp, match="cannot listen on UDP port"):
            find(taken.getsockname()[1], b"", 1)
