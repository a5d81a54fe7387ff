"""Memory has a limit, whoever sends: each row of SECURITY.md's table. A program gets little more memory than it has."""

# ruff: noqa: E402
from __future__ import annotations

import re
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
import zmq

resource = pytest.importorskip("resource")
if not hasattr(resource, "prlimit"):
    pytest.skip("only Linux takes memory from a program that runs", allow_module_level=True)

from netmq_example import records
from netmq_example.messages import Array, Message, read
from netmq_example.records import ANSWERS, ASKS, Record
from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, Program

MEGABYTE = 1024 * 1024
LARGE = bytes(20 * MEGABYTE)


@contextmanager
def limited(lesson, *words, megabytes=400, program="server.py"):
    """A server of this lesson that ends as soon as it takes so many megabytes more than at its start."""
    path = ROOT / "python" / lesson / program
    # Each thread of C's library may take 64 MB of addresses for itself.
    server = Program([PYTHON, path, *words], MALLOC_ARENA_MAX="1", OPENBLAS_NUM_THREADS="1")
    try:
        yield server, lambda: confine(server, megabytes)
        assert server.process.poll() is None, server.output
        assert "Traceback" not in server.output, server.output
    finally:
        server.kill()


def confine(server, megabytes):
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    size = int(re.search(r"VmSize:\s+(\d+)", Path(f"/proc/{server.process.pid}/status").read_text())[1]) * 1024
    resource.prlimit(server.process.pid, resource.RLIMIT_AS, (size + megabytes * MEGABYTE,) * 2)
    return endpoint


@pytest.fixture
def peer():
    context = zmq.Context()
    yield lambda endpoint: connected(context, endpoint)
    context.destroy(linger=0)


def connected(context, endpoint):
    """It waits where the server reads no more."""
    socket = context.socket(zmq.DEALER)
    socket.linger, socket.sndhwm, socket.sndtimeo, socket.rcvtimeo = 0, 1, 300, int(LIMIT * 1000)
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
        message = read([frame for frame in frames if frame])
        if message.kind in kinds:
            return message
    raise AssertionError(f"heard none of {kinds}")


def hello(name, data=b"\0", **values):
    return Message("hello", 0, {"name": name, "dt": 0.02, **values}, [Array("uint8", (len(data),), data)]).frames()


def test_what_is_answered_and_not_read(peer):
    with limited("05_messages", "--endpoint", "tcp://127.0.0.1:0", "--quiet") as (_, confined):
        endpoint = confined()
        echo = Message("echo", 1, {}, [Array("uint8", (len(LARGE),), LARGE)]).frames()
        floods(peer(endpoint), [[b"", *echo]] * 60)
        honest = peer(endpoint)
        honest.send_multipart([b"", *Message("echo", 2).frames()])
        assert hears(honest, "ok").id == 2


@pytest.mark.parametrize(("lesson", "module"), [("09_environment", "gymnasium"), ("12_video", "PIL.Image")])
def test_hellos_that_wait_to_be_read(lesson, module, peer):
    pytest.importorskip(module)
    with limited(lesson, "--endpoint", "tcp://127.0.0.1:0") as (_, confined):
        endpoint = confined()
        floods(peer(endpoint), [hello(f"w{number}", LARGE) for number in range(60)])
        honest = peer(endpoint)
        honest.send_multipart(hello("another"))
        assert hears(honest, "error").values["code"] in ("wrong-name", "missing-field")


def test_a_state_that_is_no_state(peer):
    """As numbers of Python it would have taken a hundred times its bytes."""
    np = pytest.importorskip("numpy")
    pytest.importorskip("gymnasium")
    from netmq_example import trees

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
            size = int(re.search(r"VmSize:\s+(\d+)", Path(f"/proc/{simulator.process.pid}/status").read_text())[1])
            resource.prlimit(simulator.process.pid, resource.RLIMIT_AS, (size * 1024 + 400 * MEGABYTE,) * 2)
            options = trees.write({"state": np.zeros(len(LARGE), np.uint8)})
            trainer.send_multipart([name, *Record(ASKS, 1, bytes(8), [records.RESET], [b""], options=options).frames()])
            said = read(trainer.recv_multipart()[1:]).values
            assert said == {"code": "bad-state", "text": f"a state is 4 numbers, not {len(LARGE)}"}
        finally:
            simulator.kill()


def test_answers_of_a_job_that_nobody_reads(peer, tmp_path):
    pytest.importorskip("numpy")
    words = ["--endpoint", "tcp://127.0.0.1:0", "--journal", tmp_path / "jobs.sqlite3"]
    with limited("14_long_jobs", *words, megabytes=100) as (_, confined):
        endpoint = confined()
        asker = peer(endpoint)
        values = {"job": "one", "kind": "picture", "count": 60, "text": ""}
        asker.send_multipart(Message("goal", 0, values).frames())
        hears(asker, "result")
        status = Message("status", 0, {"job": "one"}).frames()
        for greedy in [peer(endpoint) for _ in range(4)]:
            floods(greedy, [status] * 1000)
        asker.send_multipart(status)
        assert hears(asker, "result").values["done"] == 60


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
    with limited("17_many_machines", "--endpoint", "tcp://127.0.0.1:0", megabytes=800) as (_, confined):
        endpoint = confined()
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
