"""Lesson 09, what can go wrong: simulators that are lost, slow or wrong, two at once, and what may be left behind."""

from __future__ import annotations

import contextlib
import gc
import os
import re
import signal
import socket as sockets
import subprocess
import threading
import time
from pathlib import Path

import pytest
import zmq

from tests.conftest import CLIENTS, PYTHON
from tests.programs import LIMIT, PATIENT, ROOT, Mark, finds_processes, free_port, steady_endpoint, steady_port

gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: pip install gymnasium")
np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: pip install numpy")

KEY, ID = "09_environment", "NetMQExample/CartPole-v0"
LESSON = ROOT / "python" / KEY
from netmq_example.messages import Message, MessageError, read  # noqa: E402
from netmq_example.simulation.simulator import Simulator  # noqa: E402
from netmq_example.spaces import to_array  # noqa: E402
from netmq_example.split_mix import draws  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402

each_client = pytest.mark.parametrize("kind", CLIENTS)


class Fake(threading.Thread):
    """A simulator of the test's own: says hello, and answers each request as it is told."""

    def __init__(self, endpoint, answer=None, hello=None):
        super().__init__(daemon=True)
        self.endpoint, self.answer, self.asked, self.over = endpoint, answer or self.state, [], threading.Event()
        self.hello = hello or Simulator(CartPole()).hello()
        self.start()

    @staticmethod
    def state(request, seen=None, **values):
        fine = {"reward": 1.0, "terminated": False, "truncated": False, **values}
        seen = np.zeros(4, np.float32) if seen is None else seen
        return [Message("state", request.id, fine, [to_array(seen, seen.dtype)]).frames()]

    def run(self):
        with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
            socket.linger = 0
            socket.connect(self.endpoint)
            socket.send_multipart(self.hello.frames())
            while not self.over.is_set():
                if socket.poll(50):
                    self.asked.append(read(socket.recv_multipart()))
                    if self.asked[-1].kind in ("reset", "step"):
                        for frames in self.answer(self.asked[-1]):
                            socket.send_multipart(frames)


@pytest.fixture
def faked(make):
    """An environment with a simulator of the test's own."""
    fakes = []

    def faked_env(answer=None, hello=None, **where):
        endpoint = steady_endpoint()
        fakes.append(Fake(endpoint, answer, hello))
        return make(endpoint=endpoint, disable_env_checker=True, **where), fakes[-1]

    yield faked_env
    for fake in fakes:
        fake.over.set()
        fake.join(LIMIT)


def process(env):
    return env.unwrapped.simulators.process


@each_client
def test_a_killed_simulator_ends_the_episode_and_the_next_reset_starts_another(kind, make, launch):
    env = make(launch=launch(kind))
    begin, _ = env.reset(seed=7)
    seen, *_ = env.step(1)
    first = process(env)
    kept, seen[:] = seen.copy(), 9
    first.kill()
    first.wait()
    last, reward, terminated, truncated, info = env.step(1)
    assert (reward, terminated, truncated, info) == (0, False, True, {"lost": "the simulator is gone"})
    assert np.array_equal(last, kept), "nobody knows what came after; and what was given out is the user's"
    again, _ = env.reset(seed=7)
    assert process(env).pid != first.pid
    assert np.array_equal(again, begin)
    assert env.step(1)[4] == {}


@each_client
def test_a_request_that_comes_again_is_not_done_again(kind, start, client_command):
    with zmq.Context() as context, context.socket(zmq.ROUTER) as router:
        router.linger, router.rcvtimeo = 0, int(1000 * LIMIT)
        endpoint = f"tcp://127.0.0.1:{router.bind_to_random_port('tcp://127.0.0.1')}"
        client = start(*client_command(kind, KEY, endpoint))
        peer, *_ = router.recv_multipart()

        def ask(kind, id, *arrays, **values):
            router.send_multipart([peer, *Message(kind, id, values, list(arrays)).frames()])
            return router.recv_multipart()[1:]

        router.send_multipart([peer, *Message("welcome").frames()])
        ask("reset", 1, seed=7)
        first = [ask("step", 2, to_array(1, np.int64)) for _ in range(4)]
        assert all(answer == first[0] for answer in first)
        assert ask("step", 3, to_array(1, np.int64)) != first[0]
        # What is no request, and what is not in a space, is named, and the simulator goes on.
        refused = read(ask("step", 4, to_array(2, np.int64))).values
        assert refused["code"] == "not-in-space" and refused["text"].endswith("is not in Discrete(2)")
        assert read(ask("jump", 5)).values["code"] == "unknown-kind"
        assert read(ask("reset", 6, to_array([1.0], np.float64), seed=1)).values["code"] == "bad-state"
        seen = read(ask("step", 7, to_array(0, np.int64))).arrays[0].numpy()
        assert read(ask("close", 8)).kind == "closed"
        assert client.wait() == 0
        assert client.lines[-1] == "done: 1 episodes, 3 steps", "a refused one is none"
    world = CartPole()
    world.reset(draws(7), {}, [])
    for action in (1, 1, 0):
        world.apply(action)
    assert world.observe() == pytest.approx(seen, abs=1e-6)


class Cable(threading.Thread):
    """Passes on each connection to a port, until it is cut; the next one finds it whole."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.port, self.ends = port, []
        self.listener = sockets.create_server(("127.0.0.1", 0))
        self.endpoint = f"tcp://127.0.0.1:{self.listener.getsockname()[1]}"
        self.start()

    def run(self):
        with contextlib.suppress(OSError):
            while True:
                near = self.listener.accept()[0]
                far = sockets.create_connection(("127.0.0.1", self.port))
                self.ends += [near, far]
                for ways in (near, far), (far, near):
                    threading.Thread(target=self.carry, args=ways, daemon=True).start()

    def carry(self, one, other):
        with contextlib.suppress(OSError):
            while data := one.recv(65536):
                other.sendall(data)
        for end in one, other:
            end.close()

    def cut(self):
        for end in self.ends:
            with contextlib.suppress(OSError):
                end.shutdown(sockets.SHUT_RDWR)
        self.ends.clear()


@each_client
def test_a_connection_that_was_cut_is_not_taken_up_without_a_hello(kind, start, client_command):
    """Python would wait for a hello, and the simulator for a request, each on a connection that is whole."""
    with zmq.Context() as context, context.socket(zmq.ROUTER) as trainer:
        trainer.linger, trainer.rcvtimeo = 0, int(1000 * LIMIT)
        cable = Cable(trainer.bind_to_random_port("tcp://127.0.0.1"))
        client = start(*client_command(kind, KEY, cable.endpoint, *PATIENT))
        for _ in range(10):
            peer, *hello = trainer.recv_multipart()
            assert read(hello).kind == "hello"
            told = len(client.lines)
            trainer.send_multipart([peer, *Message("welcome", read(hello).id).frames()])
            client.wait_for("^simulating", start=told)
            cable.cut()
        cable.listener.close()


def test_a_slow_simulator_is_asked_again_and_late_answers_are_left_alone(faked):
    """More than a second for a step: it is sent again. And everything is answered twice."""

    def steps():
        return [request.id for request in fake.asked if request.kind == "step"]

    def answer(request):
        if steps() == [2]:
            return []
        return 2 * Fake.state(request, np.full(4, request.id / 100, np.float32))

    env, fake = faked(answer)
    env.reset()
    for id in range(2, 10):
        assert env.step(0)[0][0] == pytest.approx(id / 100)
    # On a busy machine others are sent again as well.
    assert steps()[:2] == [2, 2] and sorted(set(steps())) == list(range(2, 10))


def test_a_silent_simulator_is_lost_after_the_timeout(faked):
    env, _ = faked(lambda request: Fake.state(request) if request.kind == "reset" else [])
    env.reset()
    # From here on only: to come and to begin takes longer on a busy machine.
    env.unwrapped.simulators.wait = env.unwrapped.connection.timeout = 0.3
    assert env.step(0)[3:] == (True, {"lost": "no answer to step within 0.3 s"})
    with pytest.raises(TimeoutError, match=r"no simulator came to tcp://127.0.0.1:\d+ within 0.3 s; is it running\?"):
        env.reset()


WRONG = {
    "NaN": (lambda request: [[frame.replace(b"1.0", b"NaN") for frame in Fake.state(request)[0]]], "bad-json"),
    "no reward": (lambda request: Fake.state(request, reward="much"), "wrong-type: 'reward' must be float"),
    "shape": (lambda request: Fake.state(request, np.zeros(3, np.float32)), r"not-in-space: float32 \(3,\) .* Box\("),
    "dtype": (lambda request: Fake.state(request, np.zeros(4, np.float64)), r"not-in-space: float64 \(4,\) .* Box\("),
    "NaN seen": (lambda request: Fake.state(request, np.full(4, np.nan, np.float32)), r"not-in-space: .* Box\("),
    "none": (lambda request: [Message("state", request.id).frames()], "not-in-space: 0 arrays are not one of Box"),
    "hello": (lambda request: [Message("hello", request.id).frames()], "wrong-kind: 'hello' is no answer to step"),
    "refused": (lambda request: [Message("error", request.id, {"code": "x", "text": "y"}).frames()], "^x: y$"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_answer_is_named(what, faked):
    wrong, text = WRONG[what]
    env, _ = faked(lambda request: Fake.state(request) if request.id == 1 else wrong(request))
    env.reset()
    with pytest.raises(MessageError, match=text):
        env.step(0)


HELLOS = {
    "unknown-space: space 'graph' is none of box, discrete": {"observation": "graph"},
    "bad-space": {"action": "box"},
    "wrong-name: this environment is CartPole, the simulator's is 'Car'": {"name": "Car"},
    "wrong-type: 'dt' must be float": {"dt": "fast"},
}


@pytest.mark.parametrize("text", HELLOS)
def test_a_wrong_hello_is_named_to_both_sides(text, faked):
    hello = Simulator(CartPole()).hello()
    hello.values |= HELLOS[text]
    fake = Fake(f"tcp://127.0.0.1:{(port := steady_port())}", hello=hello)
    with pytest.raises(MessageError, match=text):
        gymnasium.make(ID, endpoint=f"tcp://127.0.0.1:{port}")
    end = time.monotonic() + LIMIT
    while not fake.asked and time.monotonic() < end:
        time.sleep(0.01)
    fake.over.set()
    fake.join(LIMIT)
    assert [answer.kind for answer in fake.asked] == ["error"]


def test_a_reward_that_is_no_number_is_the_simulations_mistake():
    class Broken(CartPole):
        def judge(self):
            return {"reward": float("nan"), "terminated": False, "truncated": False}

    request = Message("step", 1, {}, [to_array(1, np.int64)])
    answer = read(Simulator(Broken()).answer(request))
    assert (answer.kind, answer.values["code"]) == ("error", "bad-reward")


def test_an_action_outside_its_space_is_refused(make, launch):
    env = make(launch=launch("python"), disable_env_checker=True)
    env.reset()
    for action in (2, -1, 0.5, "left", np.array([1])):
        with pytest.raises(ValueError, match=r"is not in Discrete\(2\)"):
            env.step(action)
    assert env.step(np.int64(1))[4] == {}


def test_a_simulator_that_ends_before_its_hello_is_not_waited_for():
    begin = time.monotonic()
    with pytest.raises(TimeoutError, match="the launched simulator ended with code 0, and never came to tcp"):
        gymnasium.make(ID, launch=[str(PYTHON), "-c", "pass"], wait=LIMIT)
    with pytest.raises(FileNotFoundError, match=r"no game\.exe"):
        gymnasium.make(ID, launch="Build/no game.exe")
    assert time.monotonic() - begin < LIMIT, "the limit is not waited for"


def test_half_a_hello_is_none(make):
    """A peer that leaves in the middle of a message; and one that sends what is no message."""
    endpoint = steady_endpoint()
    greeting = b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(16 + 32)
    ready = b"\x04\x1a\x05READY\x0bSocket-Type\x00\x00\x00\x06DEALER"
    half = b"\x01" + bytes([200]) + Simulator(CartPole()).hello().frames()[0][:100]

    def come_and_leave():
        for rest in (half, b"\x00\x05hello"):
            while True:
                try:
                    raw = sockets.create_connection(("127.0.0.1", int(endpoint.rpartition(":")[2])), timeout=5)
                    break
                except ConnectionRefusedError:
                    time.sleep(0.01)
            with raw:
                raw.sendall(greeting + ready.replace(b"\x1a", bytes([len(ready) - 2])) + rest)
        Fake(endpoint)

    threading.Thread(target=come_and_leave, daemon=True).start()
    env = make(endpoint=endpoint, disable_env_checker=True)
    env.reset()
    assert env.step(1)[1] == 1


def test_a_second_simulator_is_told_that_there_is_one(make, launch, start, client_command):
    env = make(launch=launch("python"))
    env.reset(seed=1)
    endpoint = env.unwrapped.connection.endpoint
    second = start(*client_command("python", KEY, endpoint, "--timeout", "5"))
    while second.process.poll() is None:
        if any(env.step(env.action_space.sample())[2:4]):
            env.reset()
    assert second.wait() == 1
    second.wait_for(rf"^gave up: no environment at {endpoint} within 5 s.*busy: this environment has its simulator")


def test_a_second_trainer_on_one_port_is_told_so(make, launch):
    env = make(launch=launch("python"))
    with pytest.raises(OSError, match=r"cannot listen on tcp://127.0.0.1:\d+: .*; if another trainer has it"):
        gymnasium.make(ID, endpoint=env.unwrapped.connection.endpoint)


def test_who_leaves_after_some_episodes_is_lost(make, launch):
    env = make(launch=launch("python", "--count", "2"))
    begun = [process(env).pid for _ in range(5) if env.reset()]
    assert len(set(begun)) == 3


def test_by_hand_it_plays_without_python(start, client_command):
    """Nobody presses a key: the pole falls, and the next episode begins."""
    client = start(*client_command("unity", KEY, f"tcp://127.0.0.1:{free_port()}", "--byHand", "true"))
    for _ in range(2):
        steps = re.match(
            r"by hand: (\d+) steps, return \1.0$", client.wait_for("^by hand: .*", start=len(client.lines))[0]
        )
        assert 7 < int(steps[1]) < 12
    assert "asking" not in client.output
    assert "Physics.Simulate" not in client.output, "it is the script that simulates"


# Nothing is left


def unhurried(env):
    """Its simulator's process, which is killed only after LIMIT: a busy machine may need more than two seconds."""
    running = process(env)
    running.wait = lambda limit=None: subprocess.Popen.wait(running, LIMIT)
    return running


def test_it_may_be_closed_twice_or_forgotten(make, launch):
    env = make(launch=launch("python"))
    # So it has been there: one that was welcomed a second too late is not asked to end.
    env.reset()
    running = unhurried(env)
    env.close()
    env.close()
    assert running.poll() == 0, "it was asked to end, and did"
    with pytest.raises(ValueError, match="this environment is closed"):
        env.unwrapped.connection.ask("reset", {}, [])
    env = gymnasium.make(ID, launch=launch("python"))
    env.reset()
    running = unhurried(env)
    del env
    gc.collect()
    assert running.poll() == 0


@finds_processes
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
@each_client
def test_a_trainer_that_ends_leaves_no_simulator(kind, how, start, launch):
    mark = Mark()
    words = ["--generations", "1000000", "--launch", *launch(kind, "--timeout", "1")]
    trainer = start(PYTHON, LESSON / "train.py", *words, **mark.environment)
    trainer.wait_for("^generation 1")
    assert len(mark.processes()) == 2
    trainer.stop(how)
    assert "Traceback" not in trainer.output
    end = time.monotonic() + LIMIT
    while mark.processes() and time.monotonic() < end:
        time.sleep(0.05)
    assert mark.processes() == {}


@finds_processes
def test_a_thousand_resets_leave_nothing_behind(make, launch):
    env = make(launch=launch("python"))

    def held():
        pages = Path(f"/proc/{process(env).pid}/statm").read_text(encoding="ascii").split()[1]
        return len(os.listdir("/proc/self/fd")), len(os.listdir(f"/proc/{process(env).pid}/fd")), int(pages)

    for number in range(1200):
        env.reset(seed=number)
        if number == 200:
            before = held()
    after = held()
    assert after[:2] == before[:2]
    assert after[2] - before[2] < 500, "pages of 4 kB"
