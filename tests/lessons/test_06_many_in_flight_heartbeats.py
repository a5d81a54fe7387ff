"""Lesson 06's second server: by heartbeats it knows which clients are there."""

# ruff: noqa: F401, F811
from __future__ import annotations

import shutil
import signal
import socket
import subprocess
import sys
import time

import pytest

from tests.conftest import CLIENTS, PYTHON
from tests.lessons.many_in_flight.peers import KEY, ask, connect
from tests.programs import ROOT

SERVER = ROOT / "python" / KEY / "server_heartbeats.py"
HAS_STOP = pytest.mark.skipif(sys.platform == "win32", reason="Windows cannot stop a process and let it go on")


@pytest.fixture
def serve(start):
    """serve("--workers", "5") starts this server on a free port: (program, endpoint)."""

    def serve(*options, endpoint="tcp://127.0.0.1:0"):
        server = start(PYTHON, SERVER, "--endpoint", endpoint, *options)
        return server, server.wait_for(r"^listening on (\S+)")[1]

    return serve


def test_clients_that_come_and_go_make_no_flood_of_lines(serve, connect):
    server, endpoint = serve()
    begin = time.monotonic()
    for _ in range(300):
        with socket.create_connection(("127.0.0.1", int(endpoint.rpartition(":")[2]))):
            pass
    assert ask(connect(endpoint), b"1", b"echo a") == [b"1", b"a"]
    server.wait_for("^clients: 1$")
    said = sum(line.startswith("clients") for line in server.lines)
    assert said <= 5 * (time.monotonic() - begin) + 2


@HAS_STOP
@pytest.mark.parametrize("kind", CLIENTS)
def test_a_dead_client_is_known_within_2_s_and_a_busy_one_is_not_dead(kind, serve, start, client_command):
    server, endpoint = serve()
    client = start(*client_command(kind, KEY, endpoint, "--count", "100", "--window", "2", "--text", "sleep 2"))
    server.wait_for("^clients: 1")
    client.wait_for("sent sleep 2")
    assert "clients: 0" not in server.lines
    since = time.monotonic()
    client.process.send_signal(signal.SIGSTOP)
    server.wait_for("^clients: 0")
    # 2 s is the promise; the rest is for this test to hear of it on a busy machine.
    assert time.monotonic() - since < 2.5
    start_line = len(server.lines)
    client.process.send_signal(signal.SIGCONT)
    server.wait_for("^clients: 1", start=start_line)


@pytest.fixture
def cable():
    """A second network with a cable between: (address here, address there, how to start a program there)."""
    if not shutil.which("ip"):
        pytest.skip("this system has no `ip netns` to make a network with")
    name, here, there = "netmqexample", "10.213.7.1", "10.213.7.2"

    def ip(*words, inside=False):
        command = ["ip", *(["-n", name] if inside else []), *words]
        return subprocess.run(command, capture_output=True, text=True, timeout=20)

    # Before the try: one that is there already is another run's, and not to be taken away at the end.
    if (made := ip("netns", "add", name)).returncode:
        pytest.skip(f"no network namespace here: {made.stderr.strip()}")
    try:
        for words in (["link", "add", f"{name}0", "type", "veth", "peer", "name", "eth0", "netns", name],):
            if (made := ip(*words)).returncode:
                pytest.skip(f"no virtual cable here: {made.stderr.strip()}")
        ip("addr", "add", f"{here}/30", "dev", f"{name}0")
        ip("link", "set", f"{name}0", "up")
        ip("addr", "add", f"{there}/30", "dev", "eth0", inside=True)
        ip("link", "set", "eth0", "up", inside=True)
        yield there, ["ip", "netns", "exec", name], lambda state: ip("link", "set", "eth0", state, inside=True)
    finally:
        ip("link", "del", f"{name}0")
        ip("netns", "del", name)


# There is one cable.
@pytest.mark.xdist_group("cable")
@pytest.mark.parametrize("kind", CLIENTS)
def test_a_pulled_cable_is_known_within_2_s(kind, cable, start, client_command):
    there, inside, set_cable = cable
    server = start(*inside, PYTHON, SERVER, "--endpoint", f"tcp://{there}:*", "--open-to-anyone")
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    options = ("--count", "6", "--window", "2", "--text", "sleep 1", "--patience", "2", "--tries", "30")
    client = start(*client_command(kind, KEY, endpoint, *options))
    server.wait_for("^clients: 1")
    # There are heartbeats only once both have greeted each other; a connection without that ends after 30 s.
    client.wait_for("sent sleep 1")
    since = time.monotonic()
    set_cable("down")
    server.wait_for("^clients: 0")
    assert time.monotonic() - since < 2.5
    set_cable("up")
    assert client.wait() == 0, client.output
    assert client.lines[-1] == "done: 6 replies"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to end a program with")
def test_it_ends_at_once(serve, connect):
    server, endpoint = serve()
    client = connect(endpoint)
    client.send_multipart([b"1", b"sleep 60"])
    assert ask(client, b"2", b"echo x") == [b"2", b"x"]
    assert server.stop(signal.SIGTERM, limit=5) == 0
    assert "Traceback" not in server.output
