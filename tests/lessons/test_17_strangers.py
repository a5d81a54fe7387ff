"""Lesson 17: strangers at the hub, who answer nonsense, take what is not theirs, or come by the thousand."""

from __future__ import annotations

import os
import re
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

import pytest
import zmq

from netmq_example import messages
from tests.conftest import PYTHON
from tests.lessons.test_17_many_machines import KEY
from tests.programs import ROOT, free_port

Array, Message = messages.Array, messages.Message
# What a trainer with one area sends.
RESET = [Array("uint8", (1,), b"\1"), Array("int64", (1,), bytes(8))]
ACTION = [Array("int64", (1,), bytes(8))]
SEEN = Array("float32", (1,), bytes(4))
STATE = Message("state", 0, {"reward": 1.0, "terminated": False, "truncated": False}, [SEEN])


class Peer:
    """Whoever it wants to be, frame by frame."""

    def __init__(self, socket, hub):
        self.socket, self.asked = socket, 0
        socket.linger = 0
        socket.connect(hub)

    def say(self, kind, values=None, arrays=(), id=0):
        self.socket.send_multipart(Message(kind, id, values or {}, list(arrays)).frames())

    def hear(self, *kinds):
        """The next message of one of these kinds; what the hub repeats is passed over."""
        end = time.monotonic() + 20
        while time.monotonic() < end and self.socket.poll(20_000):
            message = messages.read(self.socket.recv_multipart())
            if message.kind in kinds and (message.id > self.asked or not message.id):
                self.asked = message.id
                return message
        raise AssertionError(f"heard none of {kinds}")

    def answer(self, request, answer):
        self.say(answer.kind, answer.values, answer.arrays, request.id)

    def hello(self, name="World", **values):
        values = {"name": name, "dt": 0.02, "observation": "box", "action": "discrete", **values}
        self.say("hello", values, [SEEN, SEEN, Array("int64", (), bytes(8))])
        assert self.hear("welcome").values == {"silence": 3.0}
        return self

    def join(self, areas=1, wait=True):
        self.say("join", {"name": "World", "areas": areas})
        if wait:
            self.hear("hello")
        return self


@pytest.fixture
def peer(context):
    """peer(endpoint): a new one, connected."""
    sockets = []

    def one(endpoint):
        sockets.append(context.socket(zmq.DEALER))
        return Peer(sockets[-1], endpoint)

    yield one
    for each in sockets:
        each.close()


def picture(*arrays):
    return Message("picture", 0, {}, list(arrays))


NONSENSE = {
    "a reward in words": ("step", Message("state", 0, {"reward": "much"}, [SEEN])),
    "a reward that says NaN": ("step", Message("state", 0, {"reward": "nan"}, [SEEN])),
    "a picture for a reset": ("reset", picture(SEEN)),
    "a kind of its own for a reset": ("reset", Message("fine")),
    "a picture of nothing": ("render", picture()),
    "two pictures": ("render", picture(SEEN, SEEN)),
}


@pytest.mark.parametrize("what", NONSENSE)
def test_whoever_answers_nonsense_is_let_go_and_the_hub_stays(what, serve, peer):
    hub, endpoint = serve(KEY)
    asked, nonsense = NONSENSE[what]
    liar, trainer = peer(endpoint).hello(), peer(endpoint).join()
    trainer.say("reset", {}, RESET, 1)
    if asked != "reset":
        liar.answer(liar.hear("reset"), STATE)
        trainer.hear("state")
        trainer.say(asked, {}, ACTION if asked == "step" else (), 2)
    liar.answer(liar.hear(asked), nonsense)
    hub.wait_for("^simulator 1 is gone: its answer is not what it has announced$")
    honest = peer(endpoint).hello()
    honest.answer(honest.hear("reset"), STATE)
    if asked != "reset":
        honest.answer(honest.hear(asked), picture(SEEN) if asked == "render" else STATE)
    assert trainer.hear("state", "picture", "error").kind == ("picture" if asked == "render" else "state")


def test_a_hello_without_spaces_is_refused(serve, peer):
    _, endpoint = serve(KEY)
    stranger = peer(endpoint)
    stranger.say("hello", {"name": "World", "dt": 0.02, "observation": "box", "action": "box"})
    assert stranger.hear("welcome", "error").values["code"] == "no-spaces"


def test_a_simulator_of_many_areas_is_refused(serve, start, client_command):
    hub, endpoint = serve(KEY)
    areas = start(*client_command("python", "10_many_agents", endpoint, "--world", "CartPole", "--timeout", "5"))
    hub.wait_for("^refused: areas-here: ")
    assert areas.wait() == 1
    assert "trouble: areas-here: a simulator of the hub is one world, and not many areas" in areas.lines


def test_a_trainer_that_was_not_admitted_gets_no_simulator(serve, peer):
    _, endpoint = serve(KEY)
    simulator, hasty = peer(endpoint).hello(), peer(endpoint).join(2, wait=False)
    hasty.say("reset", {}, [Array("uint8", (2,), b"\1\1"), Array("int64", (2,), bytes(16))], 1)
    assert hasty.hear("error").values["code"] == "unknown-peer"
    trainer = peer(endpoint).join()
    trainer.say("reset", {}, RESET, 1)
    simulator.answer(simulator.hear("reset"), STATE)
    trainer.hear("state")


def test_a_trainer_that_has_closed_leaves_its_simulators_to_the_next_though_it_is_still_connected(serve, peer):
    _, endpoint = serve(KEY)
    peer(endpoint).hello()
    first = peer(endpoint).join()
    first.say("close", id=1)
    first.hear("closed")
    peer(endpoint).join()


def test_an_episode_waits_from_the_death_of_its_simulator_on(serve, peer):
    hub, endpoint = serve(KEY, "--timeout", "1")
    dying, trainer = peer(endpoint).hello(), peer(endpoint).join()
    trainer.say("reset", {}, RESET, 1)
    # It is asked again each half second: longer than the timeout for a simulator.
    for _ in range(4):
        assert messages.read(dying.socket.recv_multipart()).kind in ("welcome", "reset")
    spare = peer(endpoint).hello()
    dying.socket.close()
    hub.wait_for("^simulator 1 is gone")
    spare.answer(spare.hear("reset"), STATE)
    assert trainer.hear("state", "error").kind == "state"


def test_a_spare_simulator_is_not_sent_home_while_a_trainer_may_need_it(serve, peer):
    _, endpoint = serve(KEY, "--idle", "0.3")
    trainer, spare = peer(endpoint).join(2, wait=False), peer(endpoint).hello()
    for _ in range(3):
        # Said once more each half second.
        spare.hear("welcome")
    trainer.socket.close()
    spare.hear("close")


def test_an_episode_that_ends_each_simulator_is_given_up(serve, peer):
    _, endpoint = serve(KEY)
    first, trainer = peer(endpoint).hello(), peer(endpoint).join()
    trainer.say("reset", {}, RESET, 1)
    for victim in [first, *(peer(endpoint).hello() for _ in range(9))]:
        victim.answer(victim.hear("reset"), Message("state"))
    error = trainer.hear("error")
    assert error.values == {
        "code": "no-simulator",
        "text": "10 simulators, one after the other, were lost at request 1 of an episode: see what they say",
    }


def test_a_simulator_that_goes_another_way_is_told_of(serve, peer):
    hub, endpoint = serve(KEY)
    first, trainer = peer(endpoint).hello(), peer(endpoint).join()
    trainer.say("reset", {}, RESET, 1)
    first.answer(first.hear("reset"), STATE)
    trainer.hear("state")
    first.socket.close()
    trainer.say("step", {}, ACTION, 2)
    other = peer(endpoint).hello()
    other.answer(other.hear("reset"), Message("state", 0, {}, [Array("float32", (1,), b"abcd")]))
    hub.wait_for("^simulator 2 goes another way than the one before it: use one build everywhere$")
    other.answer(other.hear("step"), STATE)
    trainer.hear("state")


@pytest.mark.skipif(sys.platform != "linux", reason="reads the memory of a process from /proc")
def test_names_that_nobody_has_any_more_take_no_memory(serve, peer):
    hub, endpoint = serve(KEY)

    def memory():
        return int(re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{hub.process.pid}/status").read_text())[1]) // 1024

    before = memory()
    for number in range(40):
        stranger = peer(endpoint)
        space = Array("uint8", (2**22,), bytes(2**22))
        stranger.say("hello", {"name": f"World {number}", "observation": "box", "action": "box"}, 2 * [space])
        stranger.hear("welcome")
        stranger.socket.close()
        hub.wait_for(f"^simulator {number + 1} is gone")
    assert memory() < before + 150


def test_a_flood_of_bad_messages_makes_no_flood_of_lines(serve, peer):
    hub, endpoint = serve(KEY)
    stranger = peer(endpoint)
    for number in range(3000):
        stranger.say("hello", {"name": "World", "build": f"other {number}"}, [SEEN])
    hub.wait_for(r"^\d+ lines more$")
    assert len(hub.lines) < 1500


def test_keys_without_a_folder_let_nobody_in(start):
    words = "--endpoint", "tcp://0.0.0.0:0", "--keys", ""
    hub = start(PYTHON, ROOT / "python" / KEY / "server.py", *words)
    assert hub.wait() in (1, 2), hub.output
    assert "listening" not in hub.output


def test_a_trainer_says_what_is_wrong_with_an_endpoint(start):
    trainer = start(PYTHON, ROOT / "python" / KEY / "train.py", "--endpoint", "nonsense")
    assert trainer.wait() == 2
    assert trainer.lines[-1].endswith("bad endpoint 'nonsense': write it like tcp://127.0.0.1:5567")


# How it is shown, and found


def test_the_table_is_not_wider_or_higher_than_its_terminal(peer):
    pty, fcntl, termios = (pytest.importorskip(name, reason="Unix has them") for name in ("pty", "fcntl", "termios"))
    ours, its = pty.openpty()
    fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("4H", 5, 30, 0, 0))
    words = [PYTHON, ROOT / "python" / KEY / "server.py", "--endpoint", "tcp://127.0.0.1:0"]
    environment = {name: text for name, text in os.environ.items() if name not in ("COLUMNS", "LINES")}
    with subprocess.Popen(words, stdout=its, env=environment) as hub, open(ours, "rb", 0) as terminal:
        try:
            shown = ""
            while not (found := re.search(r"listening on (\S+)\r\n", shown)):
                shown += terminal.read(1000).decode()
            fleet = [peer(found[1]).hello() for _ in range(8)]
            # What stands between two signs that take the table off is the table.
            while not (tables := [part for part in shown.split("\x1b[J")[1:-1] if "8 simulators" in part]):
                shown += terminal.read(1000).decode()
        finally:
            hub.kill()
    rows = tables[0].partition("\x1b")[0].splitlines()
    assert fleet and len(rows) == 4 and max(map(len, rows)) == 29, rows


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_beacon_with_a_port_that_is_none_is_passed_over(kind, start, client_command):
    port = free_port()
    command = client_command(kind, KEY, "nowhere", "--find", str(port), "--timeout", "2")
    at = command.index("--endpoint")
    del command[at : at + 2]
    client = start(*command)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        while client.process.poll() is None:
            for told in (b"NMQX1 99999 -", b"NMQX1 0 -", b"NMQX1 5567", bytes(100)):
                stranger.sendto(told, ("127.0.0.1", port))
            time.sleep(0.05)
    assert client.wait() == 1
    assert client.lines[-1].startswith(f"gave up: no hub was heard on UDP port {port} within 2 s"), client.output
