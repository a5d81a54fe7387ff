"""Memory has a limit, whoever sends: rows of SECURITY.md's table. Some numbers are lowered, and those of sockets are
looked at.
"""

import os
import re
import sys
from pathlib import Path

import pytest
import zmq

from kitlib.lessons import Lesson
from netmq_example import arguments
from netmq_example.fleet import hub, members, trainers
from netmq_example.fleet.hub import Hub
from netmq_example.messages import Array, Message
from netmq_example.mlagents_envs import carrier
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.wire import records
from netmq_example.wire.records import ANSWERS, ASKS, Record
from tests.conftest import PYTHON
from tests.lessons.conftest import bind
from tests.lessons.test_contract import KEYS, secrets
from tests.programs import ROOT, Program, python_runs

KILOBYTE, MEGABYTE = 1024, 1024 * 1024

# A program ends where its socket would listen or connect.
LOOKED_AT = """
import zmq
class LookedAt(zmq.Socket):
    def bind(self, endpoint):
        if not endpoint.startswith("tcp://"):
            return super().bind(endpoint)
        print(self.maxmsgsize, self.rcvhwm, self.sndhwm, flush=True)
        raise SystemExit(0)
    connect = bind
zmq.Context._socket_class = LookedAt
"""
# The largest frame, and how many messages wait to be read and to be sent. Of large ones two.
TEXTS, ARRAYS = (64 * KILOBYTE, 1000, 1000), (256 * MEGABYTE, 2, 1000)
SOCKETS = {
    # A subscription is short.
    **dict.fromkeys(["03_publish_subscribe", "07_catch_up", "20_body_tracking"], (1000, 1000, 1000)),
    "05_messages": (256 * MEGABYTE, 2, 10),
    "13_side_channels": (16 * MEGABYTE, 4, 1000),
    "14_long_jobs": (64 * KILOBYTE, 1000, 10),
    "17_many_machines": (256 * MEGABYTE, 2, 2),
    "21_talking_character": (64 * KILOBYTE, 1000, 10),
    **dict.fromkeys(["08_see_and_steer", "09_environment", "10_many_agents", "11_observations", "12_video"], ARRAYS),
}


@pytest.fixture
def looked_at(tmp_path, monkeypatch):
    """The programs of this test are."""
    (tmp_path / "sitecustomize.py").write_text(LOOKED_AT, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    # For their journals.
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("key", [key for key in KEYS if Lesson(key).scheme == "tcp"])
def test_what_a_servers_socket_takes_and_keeps(key, run, tmp_path, looked_at):
    found = run("server", key, "--endpoint", Lesson(key).anywhere, *secrets(key, tmp_path))
    assert " ".join(map(str, SOCKETS.get(key, TEXTS))) in found.lines, found


@pytest.mark.parametrize("key", ["14_long_jobs", "21_talking_character"])
def test_what_the_client_of_a_job_takes(key, run, looked_at):
    found = run("python", key, "--endpoint", "tcp://127.0.0.1:9")
    assert "67108864 2 1000" in found.lines, found


def test_what_the_gate_takes(tmp_path, looked_at):
    words = ["--to", "tcp://127.0.0.1:9", "--endpoint", "tcp://127.0.0.1:0", *secrets("15_security", tmp_path)]
    (found,) = python_runs("python/15_security/gate.py", [words])
    assert "67108864 2 1000" in found.lines, found


class Fleet:
    """A hub, its socket, and what it has sent to whom."""

    def __init__(self):
        self.sent = {}
        self.hub = Hub(self, report=lambda line: None)

    def send_multipart(self, frames, flags=0):
        peer, *message = frames
        self.sent[peer] = records.read_frames(message[0][0], message)

    def takes(self, peer, message):
        """The code of the error that it says to this peer now, if it does."""
        self.sent.pop(peer, None)
        self.hub.take(peer, message.frames())
        self.hub.ticked = 0
        self.hub.tick()
        return self.code(peer)

    def code(self, peer):
        said = self.sent.get(peer)
        return said.values["code"] if isinstance(said, Message) and said.kind == "error" else None


@pytest.fixture
def fleet():
    return Fleet()


def hello(name, size=1):
    return Message("hello", 0, {"name": name, "dt": 0.02}, [Array("uint8", (size,), bytes(size))])


def asks(id, order, size, areas=1):
    return Record(ASKS, id, bytes(8 * areas), [order] * areas, [bytes(size)] * areas)


def test_the_hellos_of_all_names_have_a_limit(fleet, monkeypatch):
    monkeypatch.setattr(hub, "MOST_HELLO_BYTES", 10_000)
    codes = [fleet.takes(b"%d" % number, hello(f"World {number}", 3000)) for number in range(4)]
    assert codes == [None, None, "too-many-worlds", "too-many-worlds"]
    # Another one of a name that is here takes no more room.
    assert fleet.takes(b"5", hello("World 0", 3000)) is None
    monkeypatch.setattr(members, "LARGEST_HELLO_BYTES", 4000)
    assert fleet.takes(b"6", hello("World 6", 5000)) == "too-big"


def begun(fleet, peer, areas=1):
    """A trainer of a name of its own whose first request is to come, and its simulators."""
    simulators = [b"%s %d" % (peer, number) for number in range(areas)]
    for each in simulators:
        assert fleet.takes(each, hello(peer.decode())) is None
    assert fleet.takes(peer, Message("join", 0, {"name": peer.decode(), "areas": areas})) is None
    assert fleet.sent[peer].kind == "hello"
    return simulators


def test_the_episodes_of_all_trainers_have_a_limit(fleet, monkeypatch):
    monkeypatch.setattr(hub, "MOST_BYTES", 10_000)
    for peer in b"one", b"two", b"three":
        begun(fleet, peer)
    codes = [fleet.takes(peer, asks(1, records.RESET, 4000)) for peer in (b"one", b"two", b"three")]
    assert codes == [None, None, "too-much"]
    # The room of a trainer that leaves is free again.
    fleet.takes(b"one", Message("close", 2))
    assert fleet.takes(b"three", asks(2, records.RESET, 4000)) is None


def test_an_areas_answer_has_its_part_of_a_message(fleet, monkeypatch):
    monkeypatch.setattr(trainers, "LIMIT", 10_000)
    for size, code in (4000, None), (6000, "too-big"):
        peer = b"trainer %d" % size
        simulators = begun(fleet, peer, areas=2)
        fleet.takes(peer, asks(1, records.RESET, 0, areas=2))
        for each in simulators:
            fleet.takes(each, Record(ANSWERS, fleet.sent[each].id, bytes(8), [0], [bytes(size)]))
        assert fleet.sent[peer].id == 1
        assert fleet.code(peer) == code


@pytest.fixture
def one_simulator(context, connect):
    """(carrier, reports, socket): lesson 13's server with no channels, and a simulator that reads nothing."""
    reports = []
    with context.socket(zmq.ROUTER) as ours:
        ours.rcvtimeo = 20_000
        # All that the system's own buffers do not take waits in the carrier.
        ours.sndhwm = 1
        its = connect(bind(ours), rcvhwm=1)
        yield carrier.Carrier(ours, lambda: SideChannelManager([]), reports.append), reports, its


def test_what_waits_of_a_simulator_has_a_limit(one_simulator, monkeypatch):
    server, reports, simulator = one_simulator
    monkeypatch.setattr(carrier, "MOST_UNREAD_BYTES", 100_000)
    simulator.send(bytes(100_001))
    server.exchange()
    assert reports == ["a simulator sends faster than this side reads, and was forgotten"] and not server.peers


def test_what_waits_for_a_simulator_has_a_limit(one_simulator, monkeypatch):
    server, reports, simulator = one_simulator
    monkeypatch.setattr(carrier, "MOST_UNSENT_BYTES", 100_000)
    simulator.send(b"")
    server.exchange()
    (peer,) = server.peers.values()
    peer.unsent += [bytes(50_000)] * 1000
    server.send()
    assert reports == ["a simulator does not read what is sent, and was forgotten"] and not server.peers


# Of a message that was read


def most_taken(program):
    """The most addresses that it has had, in bytes."""
    status = Path(f"/proc/{program.process.pid}/status").read_text()
    return int(re.search(r"VmPeak:\s+(\d+)", status)[1]) * 1024


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="only Linux says how much memory has been taken")
def test_a_state_that_is_no_state(context):
    """As numbers of Python it would have taken a hundred times its bytes."""
    np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")
    pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
    from netmq_example.wire import trees

    with context.socket(zmq.ROUTER) as trainer:
        program = ROOT / "python/09_environment/client.py"
        command = [PYTHON, program, "--endpoint", bind(trainer)]
        simulator = Program(command, MALLOC_ARENA_MAX="1", OPENBLAS_NUM_THREADS="1")
        try:
            name, *_ = trainer.recv_multipart()
            trainer.send_multipart([name, *Message("welcome").frames()])
            simulator.wait_for("^simulating")
            options = trees.write({"state": np.zeros(20 * MEGABYTE, np.uint8)})
            reset = Record(ASKS, 1, bytes(8), [records.RESET], [b""], options=options)
            before = most_taken(simulator)
            trainer.send_multipart([name, *reset.frames()])
            said = Message.read(trainer.recv_multipart()[1:]).values
            assert most_taken(simulator) - before < 400 * MEGABYTE
            assert said == {"code": "bad-state", "text": f"a state is 4 numbers, not {20 * MEGABYTE}"}
        finally:
            simulator.kill()


# Files


READERS = {
    "camera.recording": ("metadata.csv", lambda module, path: [*module.recorded(path.parent)]),
    "body.people": ("poses.csv", lambda module, path: module.read(path)),
}


@pytest.mark.timeout(20)
@pytest.mark.parametrize("how", ["large", *(["pipe"] if sys.platform != "win32" else [])])
@pytest.mark.parametrize("what", READERS)
def test_a_file_is_a_regular_one_and_has_a_limit(what, how, tmp_path, monkeypatch):
    name, reads = READERS[what]
    module = pytest.importorskip(f"netmq_example.{what}", reason="lesson 08 needs numpy: kit.py run 8 installs it")
    monkeypatch.setattr(module, "LARGEST_BYTES", 1000)
    if how == "large":
        (tmp_path / name).write_bytes(bytes(1001))
    else:
        os.mkfifo(tmp_path / name)
    why = f"{name}' must be a regular file of at most 1000 bytes"
    with pytest.raises((OSError, ValueError), match=why):
        reads(module, tmp_path / name)


def test_a_file_of_the_most_bytes_is_one(tmp_path):
    (tmp_path / "file").write_bytes(bytes(1000))
    assert arguments.regular_file(tmp_path / "file", 1000) == tmp_path / "file"
    for wrong in tmp_path / "file", tmp_path, Path(os.devnull):
        with pytest.raises(OSError, match="must be a regular file of at most 999 bytes"):
            arguments.regular_file(wrong, 999)
    with pytest.raises(FileNotFoundError):
        arguments.regular_file(tmp_path / "none", 1000)
