"""Memory has a limit, whoever sends: rows of SECURITY.md's table. The most that a program has taken is looked at."""

import re
from contextlib import contextmanager
from pathlib import Path

import pytest
import zmq

if not Path("/proc/self/status").exists():
    pytest.skip("only Linux says how much memory a program has taken", allow_module_level=True)

from netmq_example.messages import Array, Message
from netmq_example.wire import records
from netmq_example.wire.records import ASKS, Record
from tests.conftest import PYTHON
from tests.lessons.conftest import bind
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
def peer(connect):
    """peer(endpoint): it waits where the server reads no more, and leaves with the server all that it does not read."""

    def peer(endpoint):
        return connect(endpoint, sndhwm=1, rcvhwm=1, sndtimeo=300)

    return peer


def floods(socket, messages):
    """As many as go."""
    for message in messages:
        try:
            socket.send_multipart(message)
        except zmq.Again:
            return


def hello(name, data=b"\0", **values):
    return Message("hello", 0, {"name": name, "dt": 0.02, **values}, [Array("uint8", (len(data),), data)]).frames()


def test_what_is_answered_and_not_read(peer):
    with limited("05_messages", "--endpoint", "tcp://127.0.0.1:0", "--quiet") as endpoint:
        echo = Message("echo", 1, {}, [Array("uint8", (len(LARGE),), LARGE)]).frames()
        floods(peer(endpoint), [[b"", *echo]] * 60)
        honest = peer(endpoint)
        honest.send_multipart([b"", *Message("echo", 2).frames()])
        assert Message.read(honest.recv_multipart()[1:]).id == 2


def test_what_is_subscribed_to(connect):
    """ZeroMQ keeps each letter of it by itself."""
    words = "--endpoint", "tcp://127.0.0.1:0", "--snapshots", "tcp://127.0.0.1:0"
    with limited("07_catch_up", *words, megabytes=100) as endpoint:
        greedy = connect(endpoint, zmq.XSUB, sndtimeo=300)
        floods(greedy, [[b"\1" + number.to_bytes(2, "big") * 25_000] for number in range(100)])
        assert connect(endpoint, zmq.SUB, "pose/").recv().startswith(b"pose/")


def test_a_state_that_is_no_state(context):
    """As numbers of Python it would have taken a hundred times its bytes."""
    np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")
    pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
    from netmq_example.wire import trees

    with context.socket(zmq.ROUTER) as trainer:
        trainer.rcvtimeo = int(LIMIT * 1000)
        program = ROOT / "python/09_environment/client.py"
        command = [PYTHON, program, "--endpoint", bind(trainer)]
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
