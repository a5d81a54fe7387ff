"""Memory has a limit, whoever sends: rows of SECURITY.md's table. What a program has taken at the most is looked at."""

import re
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
import zmq

if not Path("/proc/self/status").exists():
    pytest.skip("only Linux says how much memory a program has taken", allow_module_level=True)

from netmq_example.messages import Array, Message
from netmq_example.wire import records
from netmq_example.wire.records import ANSWERS, ASKS, Record
from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, Program

MEGABYTE = 1024 * 1024
LARGE = bytes(20 * MEGABYTE)


@contextmanager
def limited(lesson, *words, megabytes=400):
    """A server of this lesson, which has taken no more than so many megabytes when it is over."""
    path = ROOT / "python" / lesson / "server.py"
    # Each thread of C's library may take 64 MB of addresses for itself.
    server = Program([PYTHON, path, *words], MALLOC_ARENA_MAX="1", OPENBLAS_NUM_THREADS="1")
    try:
        endpoint = server.wait_for(r"^listening on (\S+)")[1]
        with taking(server, megabytes):
            yield endpoint
    finally:
        server.kill()


@contextmanager
def taking(program, megabytes):
    # Not by a limit of the system: there ZeroMQ ends a connection for which there is no memory, and goes on.
    before = addresses(program)
    yield
    assert program.process.poll() is None, program.output
    assert "Traceback" not in program.output, program.output
    assert addresses(program) - before < megabytes * MEGABYTE


def addresses(program):
    """The most that it has had, in bytes."""
    status = Path(f"/proc/{program.process.pid}/status").read_text()
    return int(re.search(r"VmPeak:\s+(\d+)", status)[1]) * 1024


@pytest.fixture
def peer():
    context = zmq.Context()
    yield lambda endpoint: connected(context, endpoint)
    context.destroy(linger=0)


def connected(context, endpoint):
    """It waits where the server reads no more."""
    socket = context.socket(zmq.DEALER)
    socket.linger, socket.sndhwm, socket.sndtimeo, socket.rcvtimeo = 0, 1, 300, int(LIMIT * 1000)
    # What it does not read stays with the server.
    socket.rcvhwm = 1
    socket.connect(endpoint)
    return socket


def floods(socket, messages):
    """As many as go."""
    for message in messages:
        try:
            socket.send_multipart(message)
        except zmq.Again:
            return


def hears(socket, *kinds):
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        frames = socket.recv_multipart()
        message = Message.read([frame for frame in frames if frame])
        if message.kind in kinds:
            return message
    raise AssertionError(f"heard none of {kinds}")


def hello(name, data=b"\0", **values):
    return Message("hello", 0, {"name": name, "dt": 0.02, **values}, [Array("uint8", (len(data),), data)]).frames()


def test_what_is_answered_and_not_read(peer):
    with limited("05_messages", "--endpoint", "tcp://127.0.0.1:0", "--quiet") as endpoint:
        echo = Message("echo", 1, {}, [Array("uint8", (len(LARGE),), LARGE)]).frames()
        floods(peer(endpoint), [[b"", *echo]] * 60)
        honest = peer(endpoint)
        honest.send_multipart([b"", *Message("echo", 2).frames()])
        assert hears(honest, "ok").id == 2


# What every socket is made with, in a program that does not come to read.
DEAF = """
import time
import zmq
from netmq_example.program import *
from netmq_example.messages import LIMIT
with listening(zmq.ROUTER, server_options("", "tcp://127.0.0.1:0").parse_args(), 4 * LIMIT):
    time.sleep(600)
"""


def test_what_waits_to_be_read(peer):
    server = Program([PYTHON, "-c", DEAF], MALLOC_ARENA_MAX="1", PYTHONPATH=str(ROOT / "python"))
    try:
        endpoint = server.wait_for(r"^listening on (\S+)")[1]
        with taking(server, 400):
            floods(peer(endpoint), [hello(f"w{number}", LARGE) for number in range(60)])
    finally:
        server.kill()


def test_what_is_subscribed_to():
    """ZeroMQ keeps each letter of it by itself."""
    words = "--endpoint", "tcp://127.0.0.1:0", "--snapshots", "tcp://127.0.0.1:0"
    with limited("07_catch_up", *words, megabytes=100) as endpoint, zmq.Context() as context:
        with context.socket(zmq.XSUB) as greedy:
            greedy.linger, greedy.sndtimeo = 0, 300
            greedy.connect(endpoint)
            floods(greedy, [[b"\1" + number.to_bytes(2, "big") * 25_000] for number in range(100)])
        with context.socket(zmq.SUB) as honest:
            honest.linger, honest.rcvtimeo = 0, int(LIMIT * 1000)
            honest.subscribe("pose/")
            honest.connect(endpoint)
            assert honest.recv().startswith(b"pose/")


def test_a_state_that_is_no_state(peer):
    """As numbers of Python it would have taken a hundred times its bytes."""
    np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")
    pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
    from netmq_example.wire import trees

    with zmq.Context() as context, context.socket(zmq.ROUTER) as trainer:
        trainer.linger, trainer.rcvtimeo = 0, int(LIMIT * 1000)
        port = trainer.bind_to_random_port("tcp://127.0.0.1")
        program = ROOT / "python/09_environment/client.py"
        command = [PYTHON, program, "--endpoint", f"tcp://127.0.0.1:{port}"]
        simulator = Program(command, MALLOC_ARENA_MAX="1", OPENBLAS_NUM_THREADS="1")
        try:
            name, *_ = trainer.recv_multipart()
            trainer.send_multipart([name, *Message("welcome").frames()])
            simulator.wait_for("^simulating")
            options = trees.write({"state": np.zeros(len(LARGE), np.uint8)})
            reset = Record(ASKS, 1, bytes(8), [records.RESET], [b""], options=options)
            with taking(simulator, 400):
                trainer.send_multipart([name, *reset.frames()])
                said = Message.read(trainer.recv_multipart()[1:]).values
            assert said == {"code": "bad-state", "text": f"a state is 4 numbers, not {len(LARGE)}"}
        finally:
            simulator.kill()


class Trainer:
    """One area of a hub, with a simulator of its own that answers whatever it is asked."""

    def __init__(self, peer, endpoint):
        self.simulator, self.socket, self.id = peer(endpoint), peer(endpoint), 0
        self.simulator.send_multipart(hello("World"))
        self.socket.send_multipart(Message("join", 0, {"name": "World", "areas": 1}).frames())
        hears(self.socket, "hello")

    def ask(self, order, row=b""):
        """What the hub answers: a Record, or an error's code."""
        self.id += 1
        self.socket.send_multipart(Record(ASKS, self.id, bytes(8), [order], [row]).frames())
        end = time.monotonic() + LIMIT
        while time.monotonic() < end:
            if self.simulator.poll(10) and records.is_record(frames := self.simulator.recv_multipart()):
                again = Record(ANSWERS, records.read(ASKS, frames[0]).id, bytes(8), [0], [bytes(4)])
                self.simulator.send_multipart(again.frames())
            if self.socket.poll(0):
                answer = records.read_frames(ANSWERS, self.socket.recv_multipart())
                if isinstance(answer, Record) or answer.kind == "error":
                    return answer if isinstance(answer, Record) else answer.values["code"]
        raise AssertionError("no answer")


def test_the_episodes_and_hellos_that_a_hub_keeps(peer):
    with limited("17_many_machines", "--endpoint", "tcp://127.0.0.1:0", megabytes=800) as endpoint:
        trainer = Trainer(peer, endpoint)
        answer = trainer.ask(records.RESET)
        for _ in range(30):
            answer = trainer.ask(records.STEP, LARGE)
            if not isinstance(answer, Record):
                break
        assert answer == "too-much"
        # Nothing else has changed: the next episode begins as ever.
        assert isinstance(trainer.ask(records.RESET), Record)
        stranger = peer(endpoint)
        floods(stranger, [hello(f"w{number}", LARGE) for number in range(60)])
        assert hears(stranger, "error").values["code"] == "too-big"
