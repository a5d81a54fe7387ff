"""Memory has a limit, whoever sends: rows of SECURITY.md's table. Some numbers are lowered, and those of sockets are
looked at.
"""

import json
import os
import re
import sys
import tracemalloc
from pathlib import Path

import pytest
import zmq

pytest.importorskip("numpy", reason="lesson 17 needs numpy: kit.py run 17 installs it")

from kitlib.lessons import Lesson
from netmq_example import arguments
from netmq_example.fleet import hub, members
from netmq_example.json_text import shallow
from netmq_example.messages import Message
from netmq_example.mlagents_envs import carrier
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.wire import records
from tests.conftest import PYTHON
from tests.lessons.conftest import bind
from tests.lessons.fleets import Hall, asks, kinds, state
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
# The largest frame, and how many messages wait to be read and to be sent. Of large ones eight.
TEXTS, ARRAYS = (64 * KILOBYTE, 1000, 1000), (256 * MEGABYTE, 8, 1000)
SOCKETS = {
    # A subscription is short.
    **dict.fromkeys(["03_publish_subscribe", "07_catch_up", "20_body_tracking"], (1000, 1000, 1000)),
    "05_messages": (256 * MEGABYTE, 8, 10),
    "13_side_channels": (16 * MEGABYTE, 8, 1000),
    "14_long_jobs": (64 * KILOBYTE, 1000, 10),
    "17_many_machines": (256 * MEGABYTE, 8, 2),
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
    assert "67108864 8 1000" in found.lines, found


def test_what_the_gate_takes(tmp_path, looked_at):
    words = ["--to", "tcp://127.0.0.1:9", "--endpoint", "tcp://127.0.0.1:0", *secrets("15_security", tmp_path)]
    (found,) = python_runs("python/15_security/gate.py", [words])
    assert "67108864 8 1000" in found.lines, found


@pytest.fixture
def hall(monkeypatch):
    return Hall(monkeypatch)


def test_the_hellos_of_all_names_have_a_limit(hall, monkeypatch):
    monkeypatch.setattr(hub, "MOST_HELLO_BYTES", 10_000)
    large = kinds("Pole", space="x" * 3000)
    codes = [hall.simulator(b"%d" % number, large, name=f"World {number}") for number in range(4)]
    assert codes == [hall, hall, "too-many-worlds", "too-many-worlds"]
    # Another one of a name that is here takes no more room.
    assert hall.simulator(b"5", large, name="World 0") is hall
    monkeypatch.setattr(members, "LARGEST_HELLO_BYTES", 4000)
    assert hall.simulator(b"6", kinds("Pole", space="x" * 5000), name="World 6") == "too-big"


def test_the_episodes_of_all_trainers_have_a_limit(hall, monkeypatch):
    monkeypatch.setattr(hub, "MOST_BYTES", 10_000)
    peers = b"one", b"two", b"three"
    for peer in peers:
        hall.simulator(b"of " + peer, name=peer.decode())
        assert hall.trainer(peer, name=peer.decode()) == "hello"
    large = asks(records.RESET)
    large.said = bytes(4000)
    assert [hall.code(peer, large, 1) for peer in peers] == [None, None, "too-much"]
    # The room of a trainer that leaves is free again.
    hall.say(b"one", Message("close"), 2)
    hall.wait()
    assert hall.code(b"three", large, 2) is None


def test_areas_whose_answers_are_more_than_a_message_begin_anew(hall, monkeypatch):
    hall.simulator(b"1").simulator(b"2").trainer(areas=2)
    monkeypatch.setattr(records, "LIMIT", 10_000)
    for id, size, code in (1, 4000, None), (2, 6000, "too-big"), (3, 4000, None):
        hall.say(b"trainer", asks(records.RESET, records.RESET), id)
        for peer in b"1", b"2":
            hall.answer(peer, state(bytes(size)))
        assert hall.last(b"trainer").id == id
        assert (hall.last(b"trainer").kind == "error") == bool(code)


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
            reset = asks(records.RESET, id=1)
            reset.said = options
            before = most_taken(simulator)
            trainer.send_multipart([name, *reset.frames()])
            said = Message.read(trainer.recv_multipart()[1:]).values
            assert most_taken(simulator) - before < 400 * MEGABYTE
            assert said == {"code": "bad-state", "text": f"a state is 4 numbers, not {20 * MEGABYTE}"}
        finally:
            simulator.kill()


def test_a_long_json_text_takes_little_memory_to_be_looked_at():
    text = json.dumps(["a" * 4_000_000, "\n" * 1_000_000, *[[]] * 100])
    tracemalloc.start()
    try:
        began = tracemalloc.get_traced_memory()[0]
        assert shallow(text) is text
        assert tracemalloc.get_traced_memory()[1] - began < 32_000_000
    finally:
        tracemalloc.stop()


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
