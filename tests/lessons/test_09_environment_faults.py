"""Lesson 09: simulators that are lost, slow or wrong, two at once, and processes that may be left behind."""

import _thread
import gc
import os
import signal
import socket as sockets
import subprocess
import sys
import threading
import time

import pytest
import zmq

from tests.bad_peers import SlowLine
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import bind, simulated
from tests.programs import LIMIT, PATIENT, ROOT, Mark, finds_processes, free_port, steady_endpoint

gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")

from gymnasium.spaces import Dict, Discrete  # noqa: E402

KEY, ID = "09_environment", "NetMQExample/CartPole-v0"
LESSON = ROOT / "python" / KEY
from netmq_example.envs import UnityGymEnv  # noqa: E402
from netmq_example.envs.simulators import bound  # noqa: E402
from netmq_example.messages import Array, Message, MessageError  # noqa: E402
from netmq_example.scene import EnvironmentClient  # noqa: E402
from netmq_example.wire import trees  # noqa: E402
from netmq_example.wire.records import (  # noqa: E402
    ABSENT,
    ANSWERS,
    ASKS,
    RESET,
    SEEN,
    STEP,
    TERMINATED,
    Record,
    Section,
    read_frames,
)
from netmq_example.wire.sections import rewards, seeds, with_infos, with_sizes  # noqa: E402
from netmq_example.wire.space_bytes import Bytes  # noqa: E402
from netmq_example.wire.spaces import described  # noqa: E402
from netmq_example.worlds.cart_pole import CartPole  # noqa: E402
from tests.lessons.poles import Bare  # noqa: E402

each_client = pytest.mark.parametrize("kind", CLIENTS)
NOTHING_SAID: dict[str, list[object]] = {"env": [], "agent": []}
posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals")


@pytest.fixture
def here(inside, make):
    """here(…): an environment, and a simulator in this process that answers as the test says."""

    def make_env(answer=None, hello=None, **where):
        simulator = inside(simulated(), answer, hello)
        return make(socket=simulator.socket, disable_env_checker=True, **where), simulator

    return make_env


def state(request, *seen, reward=1.0, mark=SEEN, info=b"", said=b"", kind=0):
    """The answer to a request: what is seen of each agent, or of one that sees zeros."""
    rows = [array.tobytes() for array in seen or [np.zeros(4, np.float32)]]
    count = len(rows)
    section = Section(kind, rewards([reward] * count), bytes([mark] * count))
    with_infos(section, {0: info} if info else {})
    return [Record(ANSWERS, request.id, [with_sizes(section, rows if mark & SEEN else [])], said=said).frames()]


def is_step(request):
    return request.kind == ASKS and request.has(STEP)


def process(env):
    return env.unwrapped.simulators.process


def reset(id, seed, options=b""):
    return Record(ASKS, id, [Section(0, seeds([seed]), bytes([RESET]))], said=options)


def step(id, *rows):
    section = Section(0, bytes(8 * len(rows)), bytes([STEP] * len(rows)))
    return Record(ASKS, id, [with_sizes(section, rows)])


def number(action):
    return np.int64(action).tobytes()


def answered(frames):
    return read_frames(ANSWERS, frames)


# Lost, slow, twice


def test_a_killed_simulator_ends_the_episode_and_the_next_reset_starts_another(make, launch):
    env = make(launch=launch("python"), render_mode="rgb_array")
    begin, _ = env.reset(seed=7)
    seen, *_ = env.step(1)
    picture = env.render()
    first = process(env)
    kept, seen[:] = seen.copy(), 9
    first.kill()
    first.wait()
    last, reward, terminated, truncated, info = env.step(1)
    assert (reward, terminated, truncated, info) == (0, False, True, {**NOTHING_SAID, "lost": "the simulator is gone"})
    assert np.array_equal(last, kept), "nobody knows what came after; and what was given out is the user's"
    assert np.array_equal(env.render(), picture), "a film goes on"
    again, _ = env.reset(seed=7)
    assert process(env).pid != first.pid
    assert np.array_equal(again, begin)
    assert env.step(1)[4] == NOTHING_SAID


@each_client
def test_a_simulator_does_each_request_once_and_says_hello_on_each_connection(kind, start, client_command, context):
    """Else Python would wait for a hello, and the simulator for a request, each on a connection that is whole."""
    with context.socket(zmq.ROUTER) as router, SlowLine(bind(router), 0) as cable:
        client = start(*client_command(kind, KEY, cable.endpoint, *PATIENT))

        def heard(*words, kind="welcome", **values):
            """A hello, and what it is answered with."""
            peer, *hello = router.recv_multipart()
            assert Message.read(hello).kind == "hello"
            router.send_multipart([peer, *Message(kind, Message.read(hello).id, values).frames()])
            return peer

        # As long as this one has another simulator, and is at work.
        router.recv_multipart()
        client.wait_for("^trouble: it is there and says nothing: has it another scene, or is it busy\\?$")
        # Refused, and when that was nothing new, it is said no more.
        for text in ("it is odd", "it is odd", "it is even"):
            heard(kind="error", code="bad-space", text=text)
        client.wait_for("^trouble: bad-space: it is even$")
        assert client.output.count("it is odd") == 1
        for _ in range(2):
            told = len(client.lines)
            heard()
            client.wait_for("^simulating CartPole", start=told)
            cable.cut()
            client.wait_for("^trouble: the environment is gone, or silent", start=told)
        peer = heard()

        def ask(request):
            router.send_multipart([peer, *request.frames()])
            return router.recv_multipart()[1:]

        assert Message.read(ask(step(0, number(1)))).kind == "hello"
        ask(reset(1, 7))
        first = [ask(step(2, number(1))) for _ in range(3)]
        assert all(answer == first[0] for answer in first)
        last = ask(step(3, number(1)))
        assert last != first[0] and ask(step(2, number(1))) == last, "what it has done already it does not do again"
        # What is no request, and what is not in a space, is named, and the simulator goes on.
        refused = Message.read(ask(step(4, number(2)))).values
        assert refused["code"] == "not-in-space" and refused["text"].endswith("is not in Discrete(2)")
        wrong = {
            "not-in-space": [step(0, number(-1)), step(0, np.int32(1).tobytes()), step(0, number(1) * 2), step(0, b"")],
            "unknown-kind": [Message("jump", 0)],
            "wrong-agents": [step(0, number(1), number(1)), Record(ASKS, 0, step(0, number(1)).sections * 2)],
            "wrong-clock": [Record(ASKS, 0, step(0, number(1)).sections, 4)],
            "bad-state": [reset(0, 1, trees.write({"state": state})) for state in (np.ones(1), [1.0], "here", None)],
            "bad-options": [reset(0, 1, trees.write([]))],
            "bad-tree": [reset(0, 1, b"?"), reset(0, 1, trees.write({}) + b"?")],
        }
        id = 5
        for code, requests in wrong.items():
            for request in requests:
                request.id = id = id + 1
                assert Message.read(ask(request)).values["code"] == code
        seen = Bytes(CartPole.observation).read(answered(ask(step(100, number(0)))).sections[0].values)
        # Half a record has no id that could be answered: hello again.
        router.send_multipart([peer, reset(101, 1).frame()[:30]])
        client.wait_for("^trouble: bad-record: this is no reset")
        peer = heard()
        assert Message.read(ask(Message("close", 1))).kind == "closed"
        assert client.wait() == 0
        assert client.lines[-1] == "done: 1 episodes, 3 steps", "a refused one is none"
    bare = Bare()
    bare.reset(seed=7)
    assert [bare.step(action)[0] for action in (1, 1, 0)][-1] == pytest.approx(seen, abs=1e-6)


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_server_that_is_back_before_a_step_is_over_hears_hello_first(kind, start, client_command):
    """A library that connects again by itself would send it the step's answer, and both would wait for each other."""
    endpoint = steady_endpoint()
    for requests in [Message("welcome", 0), reset(1, 7), step(2, number(1))], []:
        # The end of its context is the end of its port.
        with zmq.Context() as context, context.socket(zmq.ROUTER) as router:
            router.linger, router.rcvtimeo = 0, int(1000 * LIMIT)
            router.bind(endpoint)
            if requests:
                start(*client_command(kind, "17_many_machines", endpoint, "--delay", "2", *PATIENT))
            peer, *hello = router.recv_multipart()
            assert Message.read(hello).kind == "hello"
            for request in requests:
                router.send_multipart([peer, *request.frames()])
            if requests:
                answered(router.recv_multipart()[1:])


def test_a_slow_simulator_is_asked_again_and_late_answers_are_left_alone(here):
    """More than a second for a step: it is sent again. And everything is answered twice."""

    def steps():
        return [request.id for request in simulator.asked if is_step(request)]

    def answer(request):
        if steps() == [2]:
            return []
        return 2 * state(request, np.full(4, request.id / 100, np.float32))

    env, simulator = here(answer)
    env.reset()
    for id in range(2, 6):
        assert env.step(0)[0][0] == pytest.approx(id / 100)
    # On a busy machine others are sent again as well.
    assert steps()[:2] == [2, 2] and sorted(set(steps())) == [2, 3, 4, 5]


def test_a_silent_simulator_is_lost_after_the_timeout(make, inside, monkeypatch):
    monkeypatch.setattr("netmq_example.envs.connection.RESEND_SECONDS", 0.1)
    simulator = inside(simulated(), lambda request: [] if is_step(request) else state(request))
    env = make(socket=simulator.socket, disable_env_checker=True)
    env.reset()
    # From here on only: to come and to begin takes longer on a busy machine.
    env.unwrapped.simulators.wait = env.unwrapped.simulators.connection.timeout = 1
    assert env.step(0)[3:] == (True, {**NOTHING_SAID, "lost": "no answer to step within 1 s"})
    # So many times its queue would be full, and ZeroMQ hears no heartbeat then.
    assert sum(map(is_step, simulator.asked)) < 5
    simulator.over.set()
    simulator.join(LIMIT)
    with pytest.raises(TimeoutError, match=r"no simulator came to tcp://127.0.0.1:\d+ within 1 s; is it running, or "):
        env.reset()


def test_a_second_simulator_is_told_that_there_is_one(here):
    with zmq.Context() as context, context.socket(zmq.DEALER) as second:
        second.linger = 0

        def answer(request):
            if is_step(request):
                second.connect(simulator.endpoint)
                second.send_multipart(simulator.simulator.hello().frames())
                assert second.poll(1000 * LIMIT)
                told.append(Message.read(second.recv_multipart()).values)
            return state(request)

        told = []
        env, simulator = here(answer, timeout=LIMIT)
        env.reset()
        assert env.step(1)[4] == NOTHING_SAID
    assert told == [{"code": "busy", "text": "this environment has its simulator: one at a time"}]


def test_by_hand_it_plays_without_python(start, client_command):
    """Nobody presses a key: the pole falls, and the next episode begins."""
    client = start(*client_command("unity", KEY, f"tcp://127.0.0.1:{free_port()}", "--byHand", "true"))
    for _ in range(2):
        client.wait_for(r"^by hand: (8|9|10|11) steps, return \1\.0$", start=len(client.lines))
    assert "asking" not in client.output
    assert "Physics.Simulate" not in client.output, "it is the script that simulates"


# Wrong

WRONG = {
    "NaN": (lambda request: state(request, reward=np.nan), "^bad-reward: the reward is nan"),
    "endless": (lambda request: state(request, reward=-np.inf), "^bad-reward: the reward is -inf"),
    "mark": (lambda request: state(request, mark=64 | SEEN), "^bad-record: "),
    "cut": (lambda request: [[state(request)[0][0][:-8]]], "^bad-record: .*: it ends too early"),
    "old": (lambda request: [[b"\2" + state(request)[0][0][1:]]], "^old-record: .*older kit: update "),
    "info": (lambda request: state(request, info=b"?"), "^bad-tree: "),
    "no info": (lambda request: state(request, info=trees.write([1])), r"^bad-info: an info is a dict, not \[1\]"),
    "its own": (lambda request: state(request, info=trees.write({"lost": 1})), "^bad-info: .* environment's own: lost"),
    "the scene's": (lambda request: state(request, said=trees.write({})), "^bad-info: the infos of a scene are a list"),
    "agents": (lambda request: state(request, *np.zeros((2, 4), np.float32)), "^wrong-agents: the answer is not of"),
    "kind": (lambda request: state(request, kind=1), "^wrong-agents: the answer is not of those that were asked"),
    "shape": (lambda request: state(request, np.zeros(3, np.float32)), r"^not-in-space: 12 bytes are not .* Box\("),
    "NaN seen": (lambda request: state(request, np.full(4, np.nan, np.float32)), r"^not-in-space: .* Box\("),
    "hello": (lambda request: [Message("hello", request.id).frames()], "^wrong-kind: 'hello' is no answer to step"),
    "refused": (lambda request: [Message("error", request.id, {"code": "x", "text": "y"}).frames()], "^x: y$"),
}


def test_a_wrong_answer_is_named_and_the_next_one_counts(here):
    answers = []
    env, _ = here(lambda request: answers[-1](request) if is_step(request) else state(request))
    for wrong, text in WRONG.values():
        answers.append(wrong)
        env.reset()
        with pytest.raises(MessageError, match=text):
            env.step(0)


def test_a_picture_that_is_none_is_named(here):
    arrays = []
    env, _ = here(lambda request: [Message("picture", request.id, {}, arrays).frames()], render_mode="rgb_array")
    wrong = [np.zeros((2, 2, 3), np.float32)], [np.zeros((2, 3), np.uint8)], [np.zeros((2, 2, 4), np.uint8)]
    for pictures, text in (
        *((each, r".* is not uint8 \[height, width, 3\]$") for each in wrong),
        ([], "0 pictures are neither one of all nor one of each agent$"),
        ([np.zeros((2, 2, 3), np.uint8)] * 2, "2 pictures are "),
    ):
        arrays[:] = [Array(one.dtype.name, one.shape, one.tobytes()) for one in pictures]
        with pytest.raises(MessageError, match=f"^bad-picture: {text}"):
            env.unwrapped.render()


def hello_with(kind=None, *kinds, **values):
    """CartPole's, but for some of its values, of what is said of its agents, or all of that."""
    hello = simulated().hello()
    (usual,) = trees.read(hello.arrays[0].data)["kinds"]
    said = {"kinds": [{**usual, **(kind or {})}, *kinds]} if kind is None or type(kind) is dict else kind
    return Message("hello", 0, {**hello.values, **values}, [trees.array_of(trees.write(said))])


NO_KINDS = {
    r"unknown-space: space \['cube'\] is none of box, discrete": {"observation": ["cube"]},
    r"unknown-space: space \['box', 3\] is none": {"observation": ["tuple", [["box", 3]]]},
    "bad-space: .* makes no space: n .*have to be positive": {"action": ["discrete", 0, 0, "int64"]},
    "bad-space: .* makes no space: ": {"action": ["box", "int42", np.zeros(1), np.ones(1)]},
    "wrong-scene: nobody says what the action of agent is: give action_space": {"action": None},
    r"bad-kind: the agents of a kind are names, not \[\]": {"agents": []},
    r"bad-kind: the agents of a kind are names, not \[5\]": {"agents": [5]},
    r"bad-kind: the agents of a kind are names, not \[''\]": {"agents": [""]},
    "two-agents: two agents are named 'a'": {"agents": ["a", "a"]},
    "bad-kind: a step has at least one tick, not 0": {"period": 0},
    "wrong-type: 'period' must be int": {"period": None},
    "wrong-scene: the scene has 2 agents named a, b: say which with agent_name": {"agents": ["a", "b"]},
    "no-spaces: what describes the agents is no dict": [],
}
HELLOS = {
    **{text: hello_with(described) for text, described in NO_KINDS.items()},
    "bad-kind: a kind of agents is a dict, not 5": hello_with(None, 5),
    "wrong-name: this environment is CartPole, the simulator's is 'Car'": hello_with(name="Car"),
    "wrong-type: 'dt' must be float": hello_with(dt="fast"),
    "old-record: the simulator speaks record 1 by the clock 'python', this environment 2 by": hello_with(record=1),
    "old-record: the simulator speaks record 2 by the clock 'sundial'": hello_with(clock="sundial"),
    "no-spaces: a hello of CartPole has one array": Message("hello", 0, {**hello_with().values}),
    "no-agents: CartPole has no agents: put one": Message(
        "hello", 0, hello_with().values, [trees.array_of(trees.write({"kinds": []}))]
    ),
    "bad-tree": Message("hello", 0, hello_with().values, [Array("uint8", (1,), b"?")]),
}


@pytest.mark.parametrize("text", HELLOS)
def test_a_wrong_hello_is_named_to_both_sides(text, inside):
    simulator = inside(None, hello=HELLOS[text])
    with pytest.raises(MessageError, match=f"^{text}"):
        gymnasium.make(ID, socket=simulator.socket)
    end = time.monotonic() + LIMIT
    while not simulator.asked and time.monotonic() < end:
        time.sleep(0.01)
    assert {answer.kind for answer in simulator.asked} == {"error"}


def test_spaces_that_both_sides_say_agree(inside, make):
    """The first place is named where they differ."""
    pole = CartPole.observation
    fine = {"observation_space": pole, "action_space": CartPole.action}
    assert make(UnityGymEnv, "CartPole", socket=inside(simulated()).socket, **fine).observation_space == pole
    for wrong, text in (
        ({"action_space": Discrete(3)}, r"the action of agent is Discrete\(2\) in the scene and Discrete\(3\) here$"),
        (
            {"observation_space": Dict(a=pole)},
            r"the observation of agent is Box\(.* in the scene and Dict\('a': .* here$",
        ),
    ):
        with pytest.raises(MessageError, match=f"^wrong-scene: {text}"):
            UnityGymEnv("CartPole", socket=inside(simulated()).socket, **wrong)
    hello = hello_with({"observation": described(Dict(a=Dict(b=Discrete(2)), c=pole))})
    given = Dict(a=Dict(b=Discrete(2, start=1)), c=pole)
    with pytest.raises(MessageError, match=r"Discrete\(2, start=1\) here, at \['a'\]\['b'\]$"):
        UnityGymEnv("CartPole", given, socket=inside(simulated(), hello=hello).socket)


@pytest.mark.parametrize(("dt", "fps"), [(0.02, 50), (0.0, 1000), (-1.0, 1000), (5.0, 0.2), (0.03, 33)])
def test_a_film_has_pictures_whatever_a_worlds_step_is(dt, fps, inside, make):
    env = make(UnityGymEnv, "CartPole", socket=inside(simulated(), hello=hello_with(dt=dt)).socket)
    assert env.metadata["render_fps"] == fps


def test_a_simulator_with_other_spaces_does_not_take_the_place_of_one_that_was_lost(here):
    env, simulator = here()
    env.reset()
    simulator.hello = hello_with({"action": ["discrete", 3, 0, "int64"]})
    simulator.lose()
    with pytest.raises(MessageError, match=r"^other-spaces: the simulator before this one had "):
        env.reset()


def test_half_a_hello_is_none(make, inside):
    """A peer that leaves in the middle of a message; and one that sends what is no message."""
    socket = bound("tcp://127.0.0.1:*")
    endpoint = socket.getsockopt_string(zmq.LAST_ENDPOINT)
    greeting = b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(16 + 32)
    ready = b"\x04\x1a\x05READY\x0bSocket-Type\x00\x00\x00\x06DEALER"
    half = b"\x01" + bytes([200]) + simulated().hello().frames()[0][:100]

    def come_and_leave():
        for rest in (half, b"\x00\x05hello"):
            with sockets.create_connection(("127.0.0.1", int(endpoint.rpartition(":")[2])), timeout=LIMIT) as raw:
                raw.sendall(greeting + ready.replace(b"\x1a", bytes([len(ready) - 2])) + rest)
        EnvironmentClient(endpoint, timeout=LIMIT).run(simulated())

    threading.Thread(target=come_and_leave, daemon=True).start()
    env = make(socket=socket, disable_env_checker=True)
    env.reset()
    assert env.step(1)[1] == 1
    env.close()
    socket.context.destroy()


def test_what_strangers_send_while_the_trainer_thinks_does_not_fill_the_memory(here):
    env, simulator = here()
    env.reset()
    with zmq.Context() as context, context.socket(zmq.DEALER) as stranger:
        stranger.linger, stranger.sndhwm = 0, 1
        stranger.connect(simulator.endpoint)
        sent, most = 0, 300
        while sent < most and stranger.poll(1000, zmq.POLLOUT):
            stranger.send(bytes(1 << 20))
            sent += 1
    assert 0 < sent < most / 3, "the rest must wait at the stranger's"
    assert env.step(1)[4] == NOTHING_SAID


# Closed, forgotten, forked


@pytest.mark.parametrize(("mark", "ends"), [(SEEN | TERMINATED, (True, False)), (ABSENT, (False, True))])
def test_a_step_beyond_the_end_is_refused(mark, ends, here):
    """The world ended its episode, or is not there any more."""
    env, _ = here(lambda request: state(request, mark=mark if is_step(request) else SEEN))
    for _ in range(2):
        env.reset()
        assert env.step(0)[2:4] == ends
        with pytest.raises(gymnasium.error.ResetNeeded, match=r"^no episode is under way: call reset before step$"):
            env.unwrapped.step(0)


def test_a_closed_environment_says_so(here):
    env, simulator = here()
    env.reset()
    env.close()
    env.close()
    assert [request.kind for request in simulator.asked].count("close") == 1
    for use in env.unwrapped.reset, lambda: env.unwrapped.step(1):
        with pytest.raises(ValueError, match="this environment is closed"):
            use()


def test_a_forgotten_environment_ends_its_simulator(launch):
    env = gymnasium.make(ID, launch=launch("python"))
    # So it has been there: one that was welcomed a second too late is not asked to end.
    env.reset()
    running = process(env)
    # It is killed only after LIMIT: a busy machine may need more than two seconds.
    running.wait = lambda limit=None: subprocess.Popen.wait(running, LIMIT)
    del env
    gc.collect()
    assert running.poll() == 0, "it was asked to end, and did"


def test_an_environment_that_an_interrupted_cell_has_left_ends_before_the_next_is_launched(make, launch):
    """Nobody can close it any more: the traceback holds it, and itself. Meanwhile the next cell is interrupted."""
    env = gymnasium.make(ID, launch=launch("python"))
    env.reset()
    running = process(env)

    def interrupted(limit=None):
        _thread.interrupt_main()
        return subprocess.Popen.wait(running, LIMIT)

    running.wait = interrupted
    gc.disable()
    try:
        env.unwrapped.traceback = [env]
        del env
        assert running.poll() is None
        with pytest.raises(KeyboardInterrupt):
            make(launch=launch("python"))
            time.sleep(LIMIT)
        assert running.poll() == 0
    finally:
        gc.enable()


@posix
def test_a_second_ctrl_c_while_it_closes_leaves_no_simulator(make, launch, monkeypatch):
    env = make(launch=launch("python"))
    running = process(env)

    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(env.unwrapped.simulators.connection, "ask", interrupted)
        with pytest.raises(KeyboardInterrupt):
            env.close()
    assert running.poll() is not None


@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_fork_that_lets_go_of_an_environment_leaves_it_alone(here):
    env, _ = here()
    env.reset()
    child = os.fork()
    if not child:
        env.env.env = None
        gc.collect()
        os._exit(7)
    end, ended = time.monotonic() + LIMIT, (0, 0)
    while not ended[0] and time.monotonic() < end:
        ended = os.waitpid(child, os.WNOHANG)
        time.sleep(0.01)
    if not ended[0]:
        os.kill(child, signal.SIGKILL)
    assert os.waitstatus_to_exitcode(ended[1]) == 7
    assert env.step(1)[4] == NOTHING_SAID


# Nothing is left


@finds_processes
def test_a_trainer_that_is_terminated_ends_a_simulator_that_hangs(start, launch):
    mark = Mark()
    words = ["--generations", "99999", "--launch", *launch("python")]
    trainer = start(PYTHON, LESSON / "train.py", *words, **mark.environment)
    trainer.wait_for("^generation 1")
    (hanging,) = [pid for pid, command in mark.processes().items() if "train.py" not in command]
    os.kill(hanging, signal.SIGSTOP)
    assert trainer.stop(signal.SIGTERM) == 1
    assert trainer.lines[-1] == "stopped"
    assert mark.gone()


@finds_processes
def test_what_a_launched_program_has_started_ends_with_it(monkeypatch):
    """As `dotnet run` does, whose child the simulator is."""
    mark = Mark()
    for name, value in mark.environment.items():
        monkeypatch.setenv(name, value)
    with pytest.raises(TimeoutError, match="no simulator came"):
        gymnasium.make(ID, launch=["sh", "-c", "sleep 77; true"], wait=0.3)
    assert mark.gone()


@finds_processes
def test_resets_leave_nothing_open(make, launch):
    env = make(launch=launch("python"))

    def held():
        return [len(os.listdir(f"/proc/{pid}/fd")) for pid in ("self", process(env).pid)]

    env.reset()
    before = held()
    for number in range(50):
        env.reset(seed=number)
    # The simulator's first try to connect may still have been closing then.
    assert all(now <= then for now, then in zip(held(), before, strict=True))
