"""A server is found by its name, on machines that are network namespaces here."""

import contextlib
import random
import re
import signal
import socket
import threading

import pytest

from netmq_example.beacon import answering
from netmq_example.errors import Error
from tests.conftest import CLIENTS, PYTHON
from tests.machines import HUB
from tests.programs import LIMIT, ROOT, free_port

PORT = 5567
BOTH = ["python", "csharp"]
# A client's words, and the line by which it has found a server.
CASES = {
    "03_publish_subscribe": (["--every", "1", "--count", "100000"], "^received pose/"),
    "04_background_client": (["--count", "100000"], "^[0-9]+: sent hello, received world"),
    "08_see_and_steer": (["--every", "1", "--count", "100000"], "^frame [0-9]+: age"),
    "14_long_jobs": ([], "^job .*: accepted"),
    "17_many_machines": ([], "^simulating CartPole for "),
    "20_body_tracking": (["--every", "1", "--count", "0"], "^person 0: pose"),
}
# One that answers every question by other things.
STRANGER = """
import os, socket
ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
ear.bind(("", 5567))
other = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
print("listening on UDP", flush=True)
asked = set()
while True:
    heard, sender = ear.recvfrom(100)
    for size in (0, 1, 10, 60_000):
        ear.sendto(os.urandom(size), sender)
    for words in (b"2 lab?", b"2 lab!!", b"2 lab!" + bytes(200), b"1 lab!", b"2 den!", b"2 LAB!"):
        ear.sendto(b"NMQX" + words, sender)
    other.sendto(b"NMQX2 lab!", sender)
    asked.add(sender)
    print("asked", len(asked), flush=True)
"""


@pytest.fixture
def server(machines, start):
    """server("hub", "04_background_client", "--beacon", "lab"): on that machine, and for everybody."""

    def begin(role, key, *words, host="0.0.0.0"):
        endpoint = f"tcp://{host}:{PORT}"
        command = [PYTHON, ROOT / "python" / key / "server.py", "--endpoint", endpoint, "--open-to-anyone", *words]
        program = start(*machines.inside(role), *command)
        program.wait_for("^listening on ")
        return program

    return begin


@pytest.fixture
def client(machines, start, client_command):
    """client("python", "04_background_client"): one that looks for lab for a minute, on the machine of simulators."""

    def begin(kind, key):
        words = client_command(kind, key, f"beacon://lab:{PORT}", "--timeout", "60", *CASES[key][0])
        return start(*machines.inside("simulators"), *words)

    return begin


@pytest.mark.parametrize("key", CASES)
def test_a_server_is_found_by_its_name(key, server, client, tmp_path):
    """Another one has the same port, on the clients' own machine. There is no router."""
    server("simulators", "01_request_reply", "--beacon", "den").wait_for(f"^found as beacon://den:{PORT}$")
    own = ["--journal", tmp_path / "own.sqlite3"] if key == "14_long_jobs" else []
    server("hub", key, "--beacon", "lab", *own)
    for each in [client(kind, key) for kind in CLIENTS]:
        each.wait_for(CASES[key][1])


@pytest.mark.parametrize("key", ["03_publish_subscribe", "04_background_client", "08_see_and_steer"])
def test_a_client_goes_after_a_server_that_has_moved(key, server, machines, start, client_command):
    old = server("hub", key, "--beacon", "lab")
    options, found = CASES[key]
    clients = []
    for kind in BOTH:
        words = client_command(kind, key, f"beacon://lab:{PORT}", *options)
        clients.append(start(*machines.inside("simulators"), *words))
        clients[-1].wait_for(found)
    old.process.send_signal(signal.SIGSTOP)
    server("simulators", key, "--beacon", "lab")
    for client in clients:
        client.wait_for(found, start=len(client.lines))


@pytest.mark.parametrize("key", ["03_publish_subscribe", "04_background_client"])
def test_a_server_that_comes_later_is_found_although_strangers_answer(key, server, client, machines, start):
    stranger = start(*machines.inside("simulators"), PYTHON, "-c", STRANGER)
    stranger.wait_for("^listening on UDP$")
    late = [client(kind, key) for kind in BOTH]
    stranger.wait_for("^asked 2$")
    server("hub", key, "--beacon", "lab")
    for each in late:
        each.wait_for(CASES[key][1])


# A plain cable, without a router, is a /16. A server with an address of its own hears no broadcast: each neighbour is
# asked. Behind a second cable it is asked after all neighbours of the first network, which may be more than a system
# takes at once.
PLACES = {
    "without broadcasts": (None, "hub", HUB),
    "a plain cable": (("169.254.10.1/16", "169.254.77.2/16"), "trainer", "0.0.0.0"),
    "a second network": (("192.168.50.7/24", "192.168.50.9/24"), "trainer", "192.168.50.9"),
}


@pytest.mark.parametrize("place", PLACES)
def test_a_server_is_found_wherever_it_listens(place, server, client, machines):
    cable, role, host = PLACES[place]
    with machines.second_cable(*cable) if cable else contextlib.nullcontext():
        server(role, "04_background_client", "--beacon", "lab", host=host)
        for each in [client(kind, "04_background_client") for kind in BOTH]:
            each.wait_for(CASES["04_background_client"][1])


@pytest.mark.parametrize("kind", ["python", "csharp"])
@pytest.mark.parametrize(
    "key", ["03_publish_subscribe", "04_background_client", "08_see_and_steer", "14_long_jobs", "15_security"]
)
def test_a_client_that_finds_none_says_what_to_look_at(kind, key, run):
    words = {"03": [], "15": ["--plain", "--tries", "2"]}.get(key[:2], ["--tries", "2"])
    ended = run(kind, key, "--endpoint", f"beacon://lab:{free_port()}", "--timeout", "0.3", *words)
    assert ended.code == 1
    if key[:2] == "04":
        assert "trouble: 1: nobody answers to this name within 0.3 s; try 2 of 2" in ended.lines
    assert re.search(
        r"asked 255\.255\.255\.255(, [0-9.]+)* and [1-9][0-9]* single addresses: "
        "is a server with --beacon lab in this network, and that no guest network",
        ended.lines[-1],
    )


def test_a_client_with_two_ports_gives_up_in_one_line(run):
    """Lesson 07's, whose Python client takes no beacon."""
    ended = run("csharp", "07_catch_up", "--endpoint", "beacon://nobody:5557", "--timeout", "0.5")
    assert ended.code == 1 and ended.lines[-1].startswith("gave up: no snapshot from beacon://nobody:5657 "), ended


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_an_endpoint_that_names_nobody_is_refused(kind, runs):
    wrong = ["beacon://lab", "beacon://lab:0", "beacon://lab:70000", "beacon://:5554", f"beacon://{'x' * 33}:5554"]
    for place, ended in zip(
        wrong, runs(kind, "04_background_client", [["--endpoint", each] for each in wrong]), strict=True
    ):
        assert ended.code == 2 and f"bad endpoint '{place}'" in ended.lines[-1], ended


def test_a_server_that_others_cannot_reach_says_so(runs):
    words = ["--endpoint", "tcp://127.0.0.1:0", "--beacon"]
    alone, nameless = runs("server", "04_background_client", [[*words, "lab"], [*words, "my lab"]])
    assert alone.code == 1
    assert "which no other machine reaches: give the endpoint tcp://0.0.0.0:" in alone.lines[-1]
    assert nameless.code == 2 and "argument --beacon: it takes 1 to 32 letters" in nameless.lines[-1]


def test_a_beacon_answers_its_own_question_and_nothing_else():
    port = free_port()
    chance = random.Random(1)
    asker, stranger = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    with asker, stranger, answering("lab", f"tcp://0.0.0.0:{port}"):
        for strange in [
            b"",
            b"NMQX2 den?",
            b"NMQX2 lab!",
            b"NMQX2 lab?" + bytes(91),
            *map(chance.randbytes, range(60)),
        ]:
            stranger.sendto(strange, ("127.0.0.1", port))
        asker.settimeout(LIMIT)
        asker.sendto(b"NMQX2 lab?", ("127.0.0.1", port))
        assert asker.recv(1000) == b"NMQX2 lab!"
        stranger.setblocking(False)
        with pytest.raises(BlockingIOError):
            stranger.recv(1000)
        second = answering("lab", f"tcp://0.0.0.0:{port}")
        with pytest.raises(Error, match=f"no beacon on UDP port {port}: .+; give --endpoint another port"), second:
            pass
    # The port is free again, and no thread is left.
    with answering("lab", f"tcp://0.0.0.0:{port}"):
        pass
    assert not [thread for thread in threading.enumerate() if "beacon" in thread.name]
