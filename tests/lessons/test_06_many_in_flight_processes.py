"""Lesson 06's second server: worker processes that die, a queue for each client, refusal, heartbeats."""

# ruff: noqa: F401, F811
from __future__ import annotations

import json
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
import zmq

from tests.conftest import CLIENTS, PYTHON
from tests.lessons.many_in_flight.peers import KEY, a_client_that_never_reads, ask, connect, memory, receive
from tests.programs import ROOT

SERVER = ROOT / "python" / KEY / "server_processes.py"
CROWD = ROOT / "tests" / "lessons" / "many_in_flight" / "crowd.py"
HAS_STOP = pytest.mark.skipif(sys.platform == "win32", reason="Windows cannot stop a process and let it go on")
each_pool = pytest.mark.parametrize("pool", [[], ["--processes"]], ids=["threads", "processes"])


@pytest.fixture
def serve(start):
    """serve("--queue", "5") starts this server on a free port: (program, endpoint)."""

    def serve(*options, endpoint="tcp://127.0.0.1:0"):
        server = start(PYTHON, SERVER, "--endpoint", endpoint, *options)
        return server, server.wait_for(r"^listening on (\S+)")[1]

    return serve


OWN = """
import server_processes

def work(text):
    if text == b"a str":
        return "text"
    if text == b"a large one":
        return bytes(65_537)
    raise ValueError("my own\\n" + "mistake")

server_processes.work = work
if __name__ == "__main__":
    server_processes.main()
"""


@each_pool
def test_a_mistake_in_a_readers_own_work_is_a_reply_and_a_traceback(pool, start, connect, tmp_path):
    for path in (ROOT / "python" / KEY).glob("*.py"):
        shutil.copy(path, tmp_path)
    (tmp_path / "own.py").write_text(OWN, encoding="utf-8")
    server = start(PYTHON, tmp_path / "own.py", "--endpoint", "tcp://127.0.0.1:*", *pool)
    client = connect(server.wait_for(r"^listening on (\S+)")[1])
    assert ask(client, b"1", b"x") == [b"1", b"error: ValueError: my own?mistake"]
    server.wait_for(r"own\.py\", line \d+, in work")
    request_id, text = ask(client, b"2", b"a str")
    assert (request_id, text[:17]) == (b"2", b"error: TypeError:")
    assert ask(client, b"3", b"a large one") == [b"3", b"error: the reply has 65537 bytes, the limit is 65536"]


def test_clients_that_come_and_go_do_not_fill_the_memory(serve, connect, context):
    server, endpoint = serve("--workers", "1")
    survivor = connect(endpoint)
    survivor.send_multipart([b"1", b"sleep 60"])
    assert ask(survivor, b"2", b"echo a") == [b"2", b"a"]
    before = memory(server.process)
    refusals = set()
    for _ in range(8):
        with context.socket(zmq.DEALER) as leaver:
            leaver.linger = 0
            leaver.sndhwm = leaver.rcvhwm = 0
            leaver.connect(endpoint)
            for i in range(500):
                leaver.send_multipart([b"%d" % i, b"x" * 65_000])
            leaver.send_multipart([b"", b"echo that is all"])
            while (reply := receive(leaver))[0]:
                refusals.add(reply[1].partition(b" bytes")[2])
    assert memory(server.process) - before < 200e6, "260 MB were sent, and 100 MB may wait"
    assert refusals == {b" of requests wait already"}
    assert ask(survivor, b"2", b"echo a") == [b"2", b"a"]


def test_what_waits_is_counted_down_again(serve, connect):
    """Eight times what may wait at once, one after the other: none of it is refused for what was there before."""
    _, endpoint = serve()
    client = connect(endpoint)
    for _ in range(8):
        for i in range(1000):
            client.send_multipart([b"%d" % i, b"sleep 0" + b" " * 65_000])
        for _ in range(1000):
            assert receive(client)[1].startswith(b"error: expected")


def test_clients_that_come_and_go_make_no_flood_of_lines(serve, connect):
    server, endpoint = serve()
    begin = time.monotonic()
    for _ in range(300):
        with socket.create_connection(("127.0.0.1", int(endpoint.rpartition(":")[2]))):
            pass
    assert ask(connect(endpoint), b"1", b"echo a") == [b"1", b"a"]
    server.wait_for("^clients: 1$")
    said = sum(line.startswith("clients") for line in server.lines)
    assert said <= time.monotonic() - begin + 2


def test_a_huge_window_does_not_starve_another_client(serve, connect):
    _, endpoint = serve("--workers", "2", "--queue", "1000")
    greedy, polite = connect(endpoint), connect(endpoint)
    for i in range(1000):
        greedy.send_multipart([b"%d" % i, b"sleep 0.02"])
    receive(greedy)
    for i in range(20):
        polite.send_multipart([b"%d" % i, b"sleep 0.02"])
    for _ in range(20):
        receive(polite)
    got = 1
    while greedy.poll(0):
        receive(greedy)
        got += 1
    # In turn that is about 20; a queue for all would have made it a thousand.
    assert got < 300


def test_a_full_queue_is_refused_and_only_to_its_owner(serve, connect):
    _, endpoint = serve("--workers", "1", "--queue", "5")
    greedy, polite = connect(endpoint), connect(endpoint)
    for i in range(50):
        greedy.send_multipart([b"%d" % i, b"sleep 0.5"])
    refused, done = [], []
    while len(refused) + len(done) < 50:
        request_id, text = receive(greedy)
        (refused if text == b"error: busy: 5 requests of yours wait already" else done).append(request_id)
        if len(refused) == 1:
            assert ask(polite, b"", b"echo polite") == [b"", b"polite"]
            polite.send_multipart([b"1", b"sleep 0"])
    assert receive(polite) == [b"1", b"slept 0"]
    assert 5 <= len(done) <= 20
    assert len({*refused, *done}) == 50


def test_a_client_that_never_reads_does_not_fill_the_servers_memory(serve, connect):
    server, endpoint = serve()
    a_client_that_never_reads(server, endpoint, connect)


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
    server = start(*inside, PYTHON, SERVER, "--endpoint", f"tcp://{there}:*")
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


def crowded(kinds, crowds, clients, requests, each, kill_every, serve, start, client_command):
    """Many clients while workers die. Returns the requests, the kills, and the server's memory over the run."""
    server, endpoint = serve("--processes", "--workers", "4", "--kill-workers", kill_every)
    texts = "primes 300|echo x|sleep 0.001|primes 100"
    groups = [start(PYTHON, CROWD, endpoint, clients, requests, 16, texts) for _ in range(crowds)]
    options = ("--count", str(each), "--window", "64", "--text", texts, "--patience", "60")
    others = [start(*client_command(kind, KEY, endpoint, *options)) for kind in kinds]
    sizes = []
    for thousand in range(1000, clients * requests, 1000):
        groups[0].wait_for(f"^replies: {thousand}$", limit=120)
        if Path("/proc").exists():
            sizes.append(memory(server.process))
    seen = {}
    for group in groups:
        assert group.wait(300) == 0, group.output
        for name, count in json.loads(group.lines[-1]).items():
            seen[name] = seen.get(name, 0) + count
    for other in others:
        assert other.wait(300) == 0, other.output
        assert other.lines[-1] == f"done: {each} replies"
    # The workers' deaths are counted as long as the server prints them.
    server.wait_for("^killed worker")
    kills = sum(line.startswith("killed worker") for line in server.lines)
    assert server.stop() == 0
    return seen, kills, sizes


def check_crowd(seen, kills, total, crowd_size):
    assert (seen["twice"], seen["missing"], seen["wrong"]) == (0, 0, 0), seen
    assert seen["answered"] + seen["worker died"] == total
    assert seen["worker died"] <= kills, "a worker takes one request with it, and no more"
    assert seen["clients out of order"] == crowd_size, "replies come in another order than the requests"


@pytest.mark.timeout(200)
def test_a_crowd_while_workers_die(serve, start, client_command):
    seen, kills, _ = crowded(["python", "csharp"], 2, 10, 200, 300, "0.2", serve, start, client_command)
    print(seen, f"{kills} workers killed")
    check_crowd(seen, kills, 4000, 20)


@pytest.mark.long
@pytest.mark.timeout(900)
def test_200_clients_and_100_000_requests_while_workers_die(serve, start, client_command):
    kinds = ["python", "csharp", "unity", "csharp", "python", "unity", "csharp", "python"]
    since = time.monotonic()
    seen, kills, sizes = crowded(kinds, 4, 48, 500, 500, "0.25", serve, start, client_command)
    print(seen, f"{kills} workers killed, {time.monotonic() - since:.0f} s, memory {[s // 1024 for s in sizes]} KB")
    check_crowd(seen, kills, 96_000, 192)
    assert kills >= 20
    assert seen["worker died"] > 0
    if not sizes:
        pytest.skip("all but the server's memory: this system has no /proc to read it from")
    assert sizes[-1] - sizes[len(sizes) // 5] < 5e6, f"the server's memory grew: {sizes}"


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
@each_pool
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to end a program with")
def test_a_server_ends_at_once_with_workers_at_work(how, pool, serve, connect):
    server, endpoint = serve(*pool)
    client = connect(endpoint)
    client.send_multipart([b"1", b"sleep 60"])
    # Behind it in the same pipe, so that the first one is at work.
    assert ask(client, b"2", b"sleep 0") == [b"2", b"slept 0"]
    children = Path(f"/proc/{server.process.pid}/task/{server.process.pid}/children")
    pids = children.read_text().split() if children.exists() else []
    assert server.stop(how, limit=5) == 0
    assert "Traceback" not in server.output
    deadline = time.monotonic() + 10
    while any(Path(f"/proc/{pid}/cmdline").exists() and Path(f"/proc/{pid}/cmdline").read_text() for pid in pids):
        assert time.monotonic() < deadline, "a worker process was left behind"
    again, _ = serve(endpoint=endpoint)
    assert again.stop() == 0


def test_no_socket_is_made_after_the_ready_line(start, connect):
    """A Ctrl-C in the middle of making one would leave a socket that the context waits for, for ever."""
    noting = (
        "import runpy, sys, zmq\n"
        "make = zmq.Context.socket\n"
        "def noting(context, kind):\n"
        "    print('makes', zmq.SocketType(kind).name, flush=True)\n"
        "    return make(context, kind)\n"
        "zmq.Context.socket = noting\n"
        "del sys.argv[0]\n"
        "sys.path.insert(0, sys.argv[0].rpartition('/')[0])\n"
        "runpy.run_path(sys.argv[0], run_name='__main__')\n"
    )
    server = start(PYTHON, "-c", noting, str(SERVER), "--endpoint", "tcp://127.0.0.1:*")
    endpoint = server.wait_for("^listening on (.*)")[1]
    assert ask(connect(endpoint), b"1", b"echo x") == [b"1", b"x"]
    assert server.lines[:3] == ["makes ROUTER", "makes PAIR", f"listening on {endpoint}"]
    assert not [line for line in server.lines[3:] if line.startswith("makes")]


@pytest.mark.parametrize(
    "options",
    [["--workers", "0"], ["--queue", "0"], ["--kill-workers", "1"], ["--processes", "--kill-workers", "0"]],
    ids=" ".join,
)
def test_wrong_usage_of_the_server(options, start):
    server = start(PYTHON, SERVER, *options)
    assert server.wait() == 2
    assert options[-2] in server.lines[-1]
