"""Lesson 17: a hub, simulators that come and go, and trainers that never notice."""

import re
import runpy
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
import zmq

from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import bind
from tests.programs import ROOT, finished, free_port, python_runs, steady_endpoint, steady_port

gymnasium = pytest.importorskip("gymnasium", reason="lesson 17 needs gymnasium: kit.py run 17 installs it")
np = pytest.importorskip("numpy", reason="lesson 17 needs numpy: kit.py run 17 installs it")

KEY = "17_many_machines"
TRAIN = ROOT / "python" / KEY / "train.py"
import netmq_example.envs  # noqa: E402, F401
from netmq_example import messages  # noqa: E402
from netmq_example.fleet.trainer import FleetSocket  # noqa: E402
from netmq_example.security import keys  # noqa: E402
from netmq_example.wire.records import ANSWERS, ASKS, RESET, STEP, Record, Section, read  # noqa: E402
from netmq_example.wire.sections import seeds  # noqa: E402
from tests.lessons.poles import returns  # noqa: E402

each_client = pytest.mark.parametrize("kind", CLIENTS)
ID = "NetMQExample/CartPole-v0"
# An idle simulator goes home after 15 s, and on a busy machine others take longer to start.
STAY = ("--idle", "600")


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


def played(trainer, code=0):
    """The return of each episode."""
    assert trainer.wait() == code, trainer.output
    return [int(steps) for steps in re.findall(r"^seed \d+: return (\d+)$", trainer.output, re.MULTILINE)]


def test_what_is_played_over_the_hub_is_what_is_played_without_also_where_a_simulator_dies(serve, simulators, train):
    """Its episode is begun anew elsewhere, and counts once; the trainer says that it waits for that."""
    hub, endpoint = serve(KEY, *STAY, "--late", "600")
    # The hub takes the one that has been free for longest.
    (mortal,) = simulators(endpoint, "python", words=["--crash-after", "20"])
    simulators(endpoint, *CLIENTS[1:])
    trainer = train(endpoint, 3, 9)
    assert mortal.wait() == 1
    assert mortal.lines[-1] == "crash after 20 steps, as told"
    hub.wait_for(r"^simulator 1 is gone: its connection is$")
    trainer.wait_for("^1 of 3 episodes wait for a simulator: start one, if none comes$")
    simulators(endpoint, "python")
    assert played(trainer) == returns(9)
    assert trainer.lines.count("each episode has a simulator again") == 1
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
        for number, order in enumerate([RESET, *[STEP] * 3], 1):
            began = time.monotonic()
            section = Section(0, seeds([3]), bytes([order]), values=bytes(8 * (order == STEP)))
            hub.send_multipart([peer, Record(ASKS, number, [section]).frame()])
            if number < 4:
                assert read(ANSWERS, hub.recv_multipart()[1]).id == number
                assert time.monotonic() - began > 0.29 * (order == STEP)
        assert client.wait() == 1
        assert client.lines[-1] == "crash after 2 steps, as told"


def test_a_trainer_waits_for_as_many_simulators_as_it_has_areas(serve, simulators, caplog):
    _, endpoint = serve(KEY, *STAY)
    simulators(endpoint, "python")
    why = "the hub has 1 simulators of 'CartPole', of which 0 are taken: 2 are needed"
    with (
        FleetSocket(endpoint, "CartPole", 2) as fleet,
        pytest.raises(TimeoutError, match=f"^no simulator came to {endpoint} within 3 s; {why}$"),
    ):
        gymnasium.make_vec(ID, 2, fleet=fleet, wait=3)
    assert why in caplog.messages


def test_a_trainer_says_in_one_line_what_is_wrong(context):
    """With the endpoint, without a hub, and with a hub that is not the kit's."""
    with context.socket(zmq.ROUTER) as strange, ThreadPoolExecutor() as pool:
        nobody = f"tcp://127.0.0.1:{free_port()}"
        there = bind(strange)
        words = [["nonsense"], [there], [there], [nobody, "--areas", "1", "--timeout", "3"]]
        trainers = pool.submit(python_runs, TRAIN, [["--endpoint", *each] for each in words])
        said = {}
        while len(said) < 2:
            peer, *_ = strange.recv_multipart()
            answer = messages.Message("error", 0, {"code": "several-agents", "text": "it is one scene"})
            said[peer] = strange.send_multipart([peer, *(answer if said else messages.Message("alive")).frames()])
        bad, one, other, alone = trainers.result()
    assert (bad.code, one.code, other.code, alone.code) == (2, 1, 1, 1)
    assert bad.lines[-1].endswith("bad endpoint 'nonsense': write it like tcp://127.0.0.1:5567")
    ends = "gave up: missing-field: there is no 'simulators'", "gave up: several-agents: it is one scene"
    assert {one.lines[-1], other.lines[-1]} == {*ends}
    text = f"no answer from a hub at {nobody}: is it there, without keys?"
    assert alone.lines[-2:] == [text, f"gave up: no simulator came to {nobody} within 3 s; {text}"]


def test_a_hub_that_was_killed_gets_all_back_and_no_return_changes(serve, simulators, train):
    place = steady_endpoint()
    hub, endpoint = serve(KEY, *STAY, endpoint=place)
    # So slow that it is not done before.
    simulators(endpoint, "python", "csharp", words=["--delay", "0.02"])
    trainer = train(endpoint, 2, 10)
    hub.wait_for(r"^2 simulators, \d free, 1 trainers, 1 at work, [1-9]\d* episodes")
    hub.kill()
    serve(KEY, *STAY, endpoint=place)
    assert played(trainer) == returns(10)
    assert f"asking the hub at {place} anew" in trainer.lines
    assert trainer.lines.count("the hub has given this trainer 2 simulators") == 2


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


# Keys, and how a hub is found


def test_with_keys_it_is_found_by_its_own_and_lets_in_its_list(context, serve, start_client, tmp_path, train):
    port, folder = steady_port(), tmp_path / "keys"
    endpoint = f"tcp://127.0.0.1:{port}"
    keys.example(folder)
    serve(KEY, *STAY, "--keys", str(folder), "--beacon", "hub", endpoint=f"tcp://0.0.0.0:{port}")
    for kind in ("python", "csharp"):
        client = start_client(kind, KEY, f"beacon://hub:{port}", "--keys", str(folder), "--timeout", "60")
        client.wait_for("^simulating CartPole for ")
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


# As far as ray_train.py goes where Ray cannot start.
NO_RAY = """
import sys, types
def init(*words, **more): raise Exception("The current node timed out.\\n\\nThe raylet died: see its log")
ray = types.SimpleNamespace(init=init, shutdown=print, remote=lambda **words: lambda kind: kind)
ray.exceptions = types.SimpleNamespace(RayError=RuntimeError)
sys.modules["ray"] = ray
import runpy
del sys.argv[0]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def test_a_ray_that_cannot_start_is_one_line():
    done = finished([PYTHON, "-c", NO_RAY, TRAIN.with_name("ray_train.py")])
    assert (done.returncode, done.stderr.splitlines()) == (1, ["gave up: The raylet died: see its log"])


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
