"""The lessons' tests share peers that are not the kit's, the C# side of lesson 05's messages without a client around
it, and environments, with the simulators that they launch, or that answer in the test's own process.
"""

import contextlib
import importlib
import logging
import re
import shutil
import subprocess
import sys
import threading

import pytest
import zmq

from kitlib.setup import dotnet
from netmq_example import console
from netmq_example.messages import Message
from netmq_example.wire import records
from tests.machines import Machines
from tests.programs import LIMIT, ROOT, steady_port


def bind(socket, endpoint="tcp://127.0.0.1:*"):
    """Let it listen: where that is."""
    socket.bind(endpoint)
    return where(socket)


def where(socket):
    """The endpoint where it listens."""
    return socket.last_endpoint.decode()


@pytest.fixture
def fake(context):
    """An XPUB, which sees subscriptions come."""
    with context.socket(zmq.XPUB) as stream:
        bind(stream)
        yield stream


@pytest.fixture
def start_client(start, client_command):
    """start_client("python", "03_publish_subscribe", endpoint, LANG="de_DE.UTF-8"): the running program."""
    return lambda *words, **environment: start(*client_command(*words), **environment)


@pytest.fixture
def connect(context):
    """connect(endpoint): a client that is not the kit's. A message for which it would wait for ever fails the test."""
    with contextlib.ExitStack() as stack:

        def connect(endpoint, kind=zmq.DEALER, subscribe=None, **options):
            client = stack.enter_context(context.socket(kind))
            for name, value in {"sndhwm": 0, "rcvhwm": 0, **options}.items():
                setattr(client, name, value)
            if subscribe is not None:
                client.subscribe(subscribe)
            client.connect(endpoint)
            return client

        yield connect


@pytest.fixture
def printed(capsys):
    """capsys of a program: what the package logs is among its lines."""
    log = logging.getLogger("netmq_example")
    before = log.handlers, log.level
    console.log_lines()
    yield capsys
    log.handlers, log.level = before


@pytest.fixture(scope="session")
def checks(netmq):
    """tests/lessons/checks, for `dotnet` and for `mono`."""
    return str(dotnet.build(netmq, ROOT / "tests" / "lessons" / "checks"))


@pytest.fixture(scope="session")
def messages_program(checks):
    """The command of tests/lessons/checks/MessageChecks.cs."""
    return ["dotnet", checks, "messages"]


def server_of(key):
    """The module of this lesson's server."""
    sys.path.insert(0, str(ROOT / "python" / key))
    try:
        return importlib.import_module("server")
    finally:
        sys.path.pop(0)
        sys.modules.pop("server", None)


@pytest.fixture
def game(start, request):
    """game(): a C# program that serves, and its endpoint. Its answers are in tests/lessons/checks/ServerChecks.cs."""

    def game(*words):
        server = start("dotnet", request.getfixturevalue("checks"), "server", "serve", *words)
        return server, server.wait_for(r"^listening on (tcp://127\.0\.0\.1:\d+)$")[1]

    return game


@pytest.fixture(scope="module")
def machines():
    if not shutil.which("ip"):
        pytest.skip("this system has no `ip netns` to make machines with")
    machines = Machines()
    try:
        if why := machines.make():
            pytest.skip(f"no network namespaces or virtual cables here, which root can make: {why.strip()}")
        yield machines
    finally:
        machines.remove()


def ask(context, endpoint, *frames, kind=zmq.REQ):
    """One request of a client that is not the kit's; the reply's frames."""
    with context.socket(kind) as asker:
        asker.connect(endpoint)
        asker.send_multipart(frames)
        return asker.recv_multipart()


@contextlib.contextmanager
def answering(context, answer, kind=zmq.REP, prepare=lambda socket: None):
    """A server by hand on a thread of its own, with the reply's frames for a request's, or none; and where it is."""
    over = threading.Event()

    def serve():
        with rep:
            while not over.is_set():
                if rep.poll(50) and (reply := answer(rep.recv_multipart())):
                    rep.send_multipart(reply)

    rep = context.socket(kind)
    prepare(rep)
    endpoint = bind(rep)
    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield endpoint
    finally:
        over.set()
        thread.join()


def retry(i, attempt, tries, timeout):
    """A client's line before this try: each has waited twice as long as the one before, at most 8 times."""
    return f"{i}: no reply within {timeout * 2 ** min(attempt - 2, 3):g} s; try {attempt} of {tries}"


def on_the_circle(body, ahead):
    """Where the pose after this one is, of lessons 03 and 07, if this one is where the one before it said."""
    assert re.fullmatch(r"(-?\d\.\d{4} ){6}-?\d\.\d{4}", body), body
    x, y, z, qx, qy, qz, qw = map(float, body.split(" "))
    assert (x * x + z * z, y) == (pytest.approx(4, abs=0.01), 0)
    assert qx * qx + qy * qy + qz * qz + qw * qw == pytest.approx(1, abs=0.001)
    assert ahead is None or (x, z) == pytest.approx(ahead, abs=0.001)
    # Unity's forward is (0, 0, 1) turned by the rotation.
    return x + (qx * qz + qw * qy) / 15, z + (1 - 2 * (qx * qx + qy * qy)) / 30


@pytest.fixture
def launch(client_command):
    """launch("csharp", "--count", "3"): the words for an environment that starts its simulator by itself."""

    def words(kind, *options, key="09_environment"):
        command = client_command(kind, key, "nowhere", *options)
        at = command.index("--endpoint")
        return command[:at] + command[at + 2 :]

    return words


class Inside(threading.Thread):
    """A simulator in a thread of the test: no program has to start. `asked` has all that an environment has sent.

    It answers as its simulator does, or as `answer` says: lists of frames for a request.
    """

    def __init__(self, simulator, answer=None, hello=None):
        super().__init__(daemon=True)
        from netmq_example.envs.simulators import FREE_PORT, bound

        self.simulator, self.hello, self.asked = simulator, hello, []
        self.answer = answer or (lambda request: [simulator.answer(request)])
        # The environment's.
        self.socket = bound(FREE_PORT)
        self.endpoint = self.socket.getsockopt_string(zmq.LAST_ENDPOINT)
        self.over, self.gone, self.left = threading.Event(), threading.Event(), threading.Event()
        self.start()

    def lose(self):
        """It is gone, as if it were killed, and comes again."""
        self.left.clear()
        self.gone.set()
        assert self.left.wait(LIMIT)

    def run(self):
        while not self.over.is_set():
            self.gone.clear()
            with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
                socket.linger = 1000
                socket.connect(self.endpoint)
                self.serve(socket)
            self.left.set()

    def serve(self, socket):
        socket.send_multipart((self.hello or self.simulator.hello()).frames())
        while not self.over.is_set() and not self.gone.is_set():
            if not socket.poll(10):
                continue
            request = records.read_frames(records.ASKS, socket.recv_multipart())
            self.asked.append(request)
            if request.kind == "close":
                socket.send_multipart(Message("closed", request.id).frames())
                self.over.set()
            elif request.kind == "error":
                # Not welcome, or not any more.
                self.gone.set()
            elif request.kind != "welcome":
                for frames in self.answer(request):
                    socket.send_multipart(frames)


def simulated(world="CartPole", count=1, **more):
    """The simulator of a scene with so many poles or cars."""
    from netmq_example.scene import Scene, SceneSimulator
    from netmq_example.worlds.cart_pole import CartPole
    from netmq_example.worlds.road_car import RoadCar

    kind = {"CartPole": CartPole, "Car": RoadCar}[world]
    return SceneSimulator(Scene(world, [kind() for _ in range(count)], 0.02, **more))


@pytest.fixture
def inside():
    """make(socket=inside(simulated()).socket): an environment whose simulator is in this process."""
    started = []

    def start(*simulator, **more):
        started.append(Inside(*simulator, **more))
        return started[-1]

    yield start
    for one in started:
        one.over.set()
        one.join(LIMIT)
        one.socket.context.destroy(0)


# It needs `inside` so that what it made is closed before the simulator is gone.
@pytest.fixture
def make(inside):
    """gymnasium.make, or a class, and what it made is closed at the end of the test."""
    gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
    import netmq_example.envs  # noqa: F401

    made = []

    def make_env(kind="NetMQExample/CartPole-v0", *words, **where):
        made.append(kind(*words, **where) if callable(kind) else gymnasium.make(kind, *words, **where))
        return made[-1]

    yield make_env
    for env in made:
        env.close()


@pytest.fixture
def served():
    """served(simulator): the port on which it asks for an environment, in a thread of this process."""
    from netmq_example.scene import EnvironmentClient

    threads = []

    def serve(client, simulator):
        # One that is refused looks for another environment for a while.
        with contextlib.suppress(TimeoutError):
            client.run(simulator)

    def served(simulator, timeout=5):
        port = steady_port()
        client = EnvironmentClient(f"tcp://127.0.0.1:{port}", timeout=timeout)
        threads.append(threading.Thread(target=serve, args=(client, simulator), daemon=True))
        threads[-1].start()
        return port

    yield served
    for thread in threads:
        thread.join(LIMIT)


@pytest.fixture(scope="module")
def kept():
    """Environments by what simulates, each for several tests."""
    kept = {}
    yield kept
    for env in kept.values():
        running = env.unwrapped.simulators.process
        # A busy machine may need more than two seconds, after which it would be killed.
        running.wait = lambda limit=None, running=running: subprocess.Popen.wait(running, LIMIT)
        env.close()
        assert running.poll() == 0, "it was asked to end, and did"


@pytest.fixture
def areas(inside, make):
    """areas(4): so many poles in this process; `simulator` of what it gives is there to be lost."""
    gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")

    def made(count=3, **more):
        simulator = inside(simulated(count=count))
        envs = make(gymnasium.make_vec, "NetMQExample/CartPole-v0", count, socket=simulator.socket, **more)
        envs.simulator = simulator
        return envs

    return made
