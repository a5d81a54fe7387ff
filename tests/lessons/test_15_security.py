"""Lesson 15: who comes in and who does not, keys that come and go while the server runs, and what the wire shows."""

from __future__ import annotations

import contextlib
import os
import re
import socket
import time
from pathlib import Path

import pytest
import zmq
import zmq.auth

from netmq_example.security import keys
from netmq_example.security.allow_list import AllowList
from tests.bad_peers import SlowLine
from tests.conftest import CLIENTS, PYTHON
from tests.programs import ROOT, finished, steady_endpoint

KEY = "15_security"
FOLDER = ROOT / "python" / KEY
clients = pytest.mark.parametrize("kind", CLIENTS)
NOBODY = "a" * 40
# C# compiles its cryptography, and a busy machine takes its time.
PATIENT = ("--timeout", "30")
HELLO = ["1: sent Hello, received Hello alice", "2: sent Hello, received Hello alice", "done: 2 replies"]


def words(kind, *options):
    """The option as this client spells it: in Unity it is a field's name."""
    return [{"--server-key": "--serverKey"}.get(each, each) if kind == "unity" else each for each in options]


@pytest.fixture
def folder(tmp_path):
    """The keys of a server, and of one client, alice."""
    keys.example(tmp_path / "keys")
    return tmp_path / "keys"


@pytest.fixture
def connect(context, folder):
    """connect(endpoint): a REQ socket with alice's keys, or with those that it is given."""
    with contextlib.ExitStack() as stack:

        def connect(endpoint, pair=None):
            asker = stack.enter_context(context.socket(zmq.REQ))
            asker.linger = 0
            asker.curve_publickey, asker.curve_secretkey = pair or keys.load(folder / "client.key_secret")
            asker.curve_serverkey = keys.load(folder / "server.key")[0]
            asker.connect(endpoint)
            return asker

        yield connect


def ask(asker):
    asker.send(b"Hello")
    assert asker.poll(100_000), "no reply"
    return asker.recv().decode()


def ran(*arguments, folder):
    """keys.py as a user runs it: its exit code, and what it printed."""
    done = finished([PYTHON, FOLDER / "keys.py", *arguments, "--keys", folder])
    assert "Traceback" not in done.stderr
    return done.returncode, done.stdout + done.stderr


# Who comes in


@clients
def test_who_is_on_the_list_comes_in_and_nobody_else(kind, folder, serve, start, client_command):
    server, endpoint = serve(KEY, "--keys", str(folder))
    cases = {"": [], "stranger": ["--stranger"], "wrong": ["--server-key", NOBODY], "plain": ["--plain"]}
    if kind == "unity":
        cases |= {"stranger": ["--stranger", "true"], "plain": ["--plain", "true"]}
    programs = {}
    for name, options in cases.items():
        # Who is refused is told by the connection, at once. The others may have time.
        options = words(kind, "--keys", str(folder), "--count", "2", *PATIENT, *options)
        programs[name] = start(*client_command(kind, KEY, endpoint, *options))
    codes = {name: program.wait() for name, program in programs.items()}
    assert codes.pop("") == 0
    assert programs.pop("").lines[-3:] == HELLO
    alice = keys.load(folder / "client.key")[0].decode()
    for name, program in programs.items():
        assert codes[name] == 1, program.output
        gave_up = next(line for line in program.lines if "gave up: " in line)
        said = f"3 tries to ask {endpoint}, the last: connected and thrown out; "
        if name == "plain":
            assert gave_up == f"gave up: {said}a server with keys refuses who has none"
        else:
            asked = "is this client on its list, is server.key its key, and has it keys at all? This client's is "
            assert gave_up.startswith(f"gave up: {said}{asked}")
            assert (gave_up.rpartition(" ")[2] == alice) == (name == "wrong")
    stranger = next(line for line in programs["stranger"].lines if "gave up" in line).rpartition(" ")[2]
    named = [line for line in server.lines if line.startswith("refused: ") and "more" not in line]
    assert named == [f"refused: key {stranger} from 127.0.0.1 is not in {folder / 'allowed'}"]
    assert server.lines.count("alice from 127.0.0.1: 'Hello'") == 2


@clients
def test_a_client_without_the_servers_key_is_told_where_it_belongs(kind, tmp_path, start, client_command):
    """In full, because its folder is seldom the one where the keys were made."""
    client = start(*client_command(kind, KEY, "tcp://127.0.0.1:1", "--keys", "own"), folder=tmp_path)
    assert client.wait() == (1 if kind == "unity" else 2)
    cure = "keys.py makes keys, and server.key is a copy of the server's"
    assert any(f"no key in {tmp_path / 'own' / 'server.key'}; {cure}" in line for line in client.lines), client.output
    assert not (tmp_path / "own" / "client.key_secret").exists()


def test_a_server_that_makes_its_keys_says_where(tmp_path, start):
    command = [PYTHON, FOLDER / "server.py", "--endpoint", "tcp://127.0.0.1:0"]
    server = start(*command, folder=tmp_path)
    server.wait_for("^listening on ")
    assert server.lines[0] == f"keys: made {tmp_path / 'keys'}, with this server's and one client's, alice"


def test_without_an_authenticator_nobody_comes_in(folder, serve, start, client_command):
    server, endpoint = serve(KEY, "--keys", str(folder), "--no-authenticator")
    client = start(*client_command("python", KEY, endpoint, "--keys", str(folder), *PATIENT))
    assert client.wait() == 1
    assert "connected and thrown out" in client.lines[-1]
    assert not [line for line in server.lines if "from" in line]


def test_without_an_authenticator_and_in_any_domain_everybody_does_and_each_message_tells(folder, serve, connect):
    """The mistake that the enforced domain prevents: the stranger's word arrives."""
    server, endpoint = serve(KEY, "--keys", str(folder), "--no-authenticator", "--any-domain")
    assert ask(connect(endpoint, zmq.curve_keypair())) == "error: your key is not on the list, or not any more"
    server.wait_for("^nobody knows who from 127.0.0.1: 'Hello'$")


# Keys come and go


@clients
def test_a_client_makes_its_keys_and_comes_in_as_soon_as_it_is_enrolled(
    kind, folder, tmp_path, serve, start, client_command
):
    _, endpoint = serve(KEY, "--keys", str(folder))
    own = tmp_path / "own"
    own.mkdir()
    (own / "server.key").write_bytes((folder / "server.key").read_bytes())
    options = ["--keys", str(own), "--tries", "1000", "--count", "2", *PATIENT]
    client = start(*client_command(kind, KEY, endpoint, *options))
    client.wait_for("^1: connected and thrown out; try 3 of 1000$")
    assert ran("enrol", f"bob={own / 'client.key'}", folder=folder)[0] == 0
    seen = len(client.lines)
    client.wait_for("^1: sent Hello, received Hello bob$")
    # A try is over at once, and a quarter of a second passes between two: two seconds.
    assert len([line for line in client.lines[seen:] if "thrown out" in line]) <= 8
    assert client.wait() == 0
    public, secret = zmq.auth.load_certificate(own / "client.key_secret")
    assert zmq.curve_public(secret) == public == zmq.auth.load_certificate(own / "client.key")[0]
    if os.name != "nt":
        assert (own / "client.key_secret").stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("how", ["revoked", "another key"])
def test_a_key_taken_off_the_list_loses_its_live_connections_next_request(how, folder, serve, connect):
    _, endpoint = serve(KEY, "--keys", str(folder))
    alice = connect(endpoint)
    assert ask(alice) == ask(alice) == "Hello alice"
    assert ran("revoke", "alice", folder=folder)[0] == 0
    if how == "another key":
        other = zmq.curve_keypair()
        assert ran("enrol", f"alice={other[0].decode()}", folder=folder)[0] == 0
        assert ask(connect(endpoint, other)) == "Hello alice"
    assert ask(alice) == "error: your key is not on the list, or not any more"
    again = connect(endpoint)
    again.send(b"Hello")
    assert not again.poll(1000)


def test_the_keys_of_either_side_are_rotated_and_never_overwritten(folder, serve, start, client_command):
    before = {path.name: path.read_bytes() for path in folder.glob("*.key_secret")}
    for role in ("server", "client"):
        code, said = ran("make", role, folder=folder)
        assert code == 1 and f"{role}.key_secret is there, and is never overwritten" in said
        assert ran("rotate", role, folder=folder)[0] == 0
        assert (folder / f"{role}.1.key_secret").read_bytes() == before[f"{role}.key_secret"]
        assert (folder / f"{role}.key_secret").read_bytes() != before[f"{role}.key_secret"]
        if os.name != "nt":
            assert (folder / f"{role}.key_secret").stat().st_mode & 0o777 == 0o600
    assert ran("enrol", f"alice={folder / 'client.key'}", folder=folder)[0] == 1, "the name is taken"
    assert ran("enrol", f"alice-2={folder / 'client.key'}", folder=folder)[0] == 0
    _, endpoint = serve(KEY, "--keys", str(folder))
    client = start(*client_command("python", KEY, endpoint, "--keys", str(folder), "--count", "1", *PATIENT))
    assert client.wait() == 0
    assert client.lines[-2] == "1: sent Hello, received Hello alice-2"


def test_the_server_on_the_page_knows_its_clients(folder, tmp_path, start, connect):
    page = (ROOT / "docs" / "guide" / f"{KEY}.md").read_text(encoding="utf-8")
    code = next(
        block for block in re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE) if "import" in block
    )
    endpoint = steady_endpoint()
    assert code.count("tcp://127.0.0.1:5565") == 1
    program = start(
        PYTHON, "-c", code.replace("tcp://127.0.0.1:5565", endpoint), folder=tmp_path, PYTHONPATH=str(ROOT / "python")
    )
    program.wait_for("^listening$")
    live = connect(endpoint)
    assert ask(live) == "Hello alice"
    assert ran("revoke", "alice", folder=folder)[0] == 0
    assert ask(live) == "error: your key is not on the list"


def test_keys_py_says_in_one_line_what_is_wrong(folder):
    for arguments, cause in {
        ("enrol", "bob"): "enrol does not take 'bob'",
        ("enrol", "../bob=" + NOBODY): "enrol does not take",
        ("enrol", "bob=nowhere.key"): f"no key in {Path('nowhere.key').absolute()}; enrol takes the path",
        ("enrol", "bob=" + "~" * 40): "no key: ",
        ("revoke", "bob"): "bob.key: No such file",
        ("rotate", "clients"): "rotate does not take 'clients'",
    }.items():
        code, said = ran(*arguments, folder=folder)
        assert code in (1, 2) and cause in said.splitlines()[-1], said
    assert ran("list", folder=folder) == (0, f"alice: {keys.load(folder / 'client.key')[0].decode()}\n")


def test_a_key_enrolled_in_another_folder_of_the_same_name_can_be_noticed(tmp_path, start):
    """The server has its folder in one place, and keys.py its own in another."""
    for place in "ab":
        (tmp_path / place).mkdir()
        keys.example(tmp_path / place / "keys")
    enrol = [PYTHON, FOLDER / "keys.py", "enrol", f"bob={zmq.curve_keypair()[0].decode()}"]
    said = finished(enrol, cwd=tmp_path / "a").stdout
    assert said == f"enrolled: bob, in {tmp_path / 'a' / 'keys' / 'allowed' / 'bob.key'}\n"
    told = []
    before = os.getcwd()
    try:
        os.chdir(tmp_path / "b")
        AllowList(Path("keys"), told.append).refuse("x", "127.0.0.1")
    finally:
        os.chdir(before)
    assert told == [f"refused: key x from 127.0.0.1 is not in {tmp_path / 'b' / 'keys' / 'allowed'}"]


def test_a_file_that_is_no_key_lets_nobody_in_and_keeps_nobody_out(folder, serve, connect):
    for name, content in {"empty": "", "bin": "\0" * 500, "short": 'curve\n    public-key = "abc"\n'}.items():
        (folder / "allowed" / f"{name}.key").write_text(content)
    server, endpoint = serve(KEY, "--keys", str(folder))
    assert ask(connect(endpoint)) == "Hello alice"
    assert "Traceback" not in server.output


# A gate in front of a server that knows nothing of keys


@pytest.mark.parametrize("kind", ["csharp", "unity"])
@pytest.mark.parametrize("key", ["04_background_client", "08_see_and_steer", "14_long_jobs"])
def test_the_clients_of_other_lessons_come_through_the_gate_with_keys(
    key, kind, folder, tmp_path, serve, start, client_command
):
    if key.startswith("08"):
        pytest.importorskip("numpy", reason="lesson 08 needs numpy: pip install numpy")
    _, inside = serve(key)
    gate = start(PYTHON, FOLDER / "gate.py", "--to", inside, "--endpoint", "tcp://127.0.0.1:0", "--keys", folder)
    endpoint = gate.wait_for(r"^listening on (\S+)")[1]
    command = client_command(kind, key, endpoint, "--count", "5")
    with_keys = start(*command, *PATIENT, "--with-keys", str(folder))
    assert with_keys.wait() == 0, with_keys.output
    tries = ["--tries", "1", "--timeout", "0.3"]
    without = start(*command, *tries)
    assert without.wait() == 1, without.output
    assert ran("revoke", "alice", folder=folder)[0] == 0
    revoked = start(*command, *tries, "--with-keys", str(folder))
    assert revoked.wait() == 1, revoked.output


def test_who_is_revoked_is_not_passed_on_any_more(folder, serve, start, connect):
    _, inside = serve("01_request_reply")
    gate = start(PYTHON, FOLDER / "gate.py", "--to", inside, "--endpoint", "tcp://127.0.0.1:0", "--keys", folder)
    alice = connect(gate.wait_for(r"^listening on (\S+)")[1])
    for _ in range(3):
        alice.send(b"Hello")
        assert alice.poll(100_000)
        assert alice.recv() == b"World"
    assert ran("revoke", "alice", folder=folder)[0] == 0
    alice.send(b"Hello")
    gate.wait_for("^refused: key .* is not in ")
    assert not alice.poll(500)


# What is seen on the wire


class Recorder(SlowLine):
    """A line that is not slow, and keeps what is sent to the server and what comes back."""

    def __init__(self, endpoint):
        super().__init__(endpoint, 0)
        self.there, self.back = b"", b""

    def copy(self, source, target):
        there = source.getsockname() == self.socket.getsockname()
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                if there:
                    self.there += data
                else:
                    self.back += data
                target.sendall(data)


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_nobody_on_the_wire_reads_a_word_and_a_recording_opens_nothing(kind, folder, serve, start, client_command):
    server, endpoint = serve(KEY, "--keys", str(folder))
    with Recorder(endpoint) as wire:
        command = client_command(kind, KEY, wire.endpoint, "--keys", str(folder), "--count", "2", *PATIENT)
        assert start(*command).wait() == 0
        assert len(wire.there) > 400
        assert b"Hello" not in wire.there + wire.back and b"alice" not in wire.there + wire.back
    _, plain = serve("01_request_reply")
    with Recorder(plain) as open_wire:
        command = client_command(kind, "01_request_reply", open_wire.endpoint, "--count", "2", *PATIENT)
        assert start(*command).wait() == 0
        assert open_wire.there.count(b"Hello") == open_wire.back.count(b"World") == 2
    # The recording again: the server's half of the handshake is new each time, so it fits nothing.
    heard = len(server.lines)
    with socket.create_connection(("127.0.0.1", int(endpoint.rpartition(":")[2])), timeout=20) as replayed:
        replayed.sendall(wire.there)
        with contextlib.suppress(ConnectionResetError):
            while replayed.recv(65536):
                pass
    assert start(*client_command(kind, KEY, endpoint, "--keys", str(folder), "--count", "1", *PATIENT)).wait() == 0
    server.wait_for("alice from", start=heard)
    assert server.lines[heard:] == ["alice from 127.0.0.1: 'Hello'"]


# Many strangers


def asked(asker, seconds):
    """How often in this time."""
    end, count = time.monotonic() + seconds, 0
    while time.monotonic() < end:
        assert ask(asker) == "Hello alice"
        count += 1
    return count


# What comes to the server, and the seconds in which the honest client's requests are counted.
# A rate beside a rate: what else the machine does, as beside other tests, is in both.
CROWDS = [
    pytest.param("half handshakes", 0.5, marks=pytest.mark.long, id="half"),
    # Their handshakes alone keep two cores busy for a moment: with them is compared what is asked in three seconds.
    pytest.param("strangers", 3, marks=pytest.mark.long, id="strangers"),
]
STRANGERS = """
import sys, threading, zmq
endpoint, server_key = sys.argv[1:]
context, pair = zmq.Context(), zmq.curve_keypair()
context.max_sockets = 2000
for _ in range(1000):
    stranger = context.socket(zmq.DEALER)
    stranger.curve_publickey, stranger.curve_secretkey = pair
    stranger.curve_serverkey = server_key.encode()
    stranger.connect(endpoint)
threading.Event().wait(120)
"""


@pytest.mark.parametrize(("crowd", "seconds"), CROWDS)
def test_a_crowd_does_not_slow_an_honest_client_by_more_than_half(crowd, seconds, folder, serve, start, connect):
    """The better of two times each, so that another program's moment does not count."""
    server, endpoint = serve(KEY, "--keys", str(folder))
    alice = connect(endpoint)
    alone = max(asked(alice, seconds) for _ in range(2))
    address = "127.0.0.1", int(endpoint.rpartition(":")[2])
    greeting = b"\xff" + bytes(8) + b"\x7f\x03\x00CURVE" + bytes(15 + 32)
    with contextlib.ExitStack() as stack:
        if crowd == "strangers":
            start(PYTHON, "-c", STRANGERS, endpoint, keys.load(folder / "server.key")[0].decode())
            crowded = asked(alice, seconds)
            server.wait_for(r"^refused: key \S{40} from 127.0.0.1 is not in ")
        else:
            for number in range(300):
                half = stack.enter_context(socket.create_connection(address, timeout=20))
                half.sendall(greeting[: 5 + number % 60])
            crowded = max(asked(alice, seconds) for _ in range(2))
        assert ask(connect(endpoint)) == "Hello alice"
    assert crowded > alone / 2
    refused = [line for line in server.lines if line.startswith("refused: ")]
    assert all(re.fullmatch(r"refused: key \S{40} \d+ times more", line) for line in refused[1:])


def test_a_flood_of_new_keys_is_no_flood_of_lines(folder):
    said = []
    allowed = AllowList(folder, said.append)
    for _ in range(3000):
        allowed.refuse(zmq.curve_keypair()[0].decode(), "192.0.2.1")
    allowed.report_again()
    assert len(said) == 11
    assert said[-1] == "refused: other keys, 2990 times"


def test_a_subscriber_too_is_known_by_its_key(folder, context):
    allowed = AllowList(folder)
    with zmq.Context() as servers, servers.socket(zmq.PUB) as publisher, context.socket(zmq.SUB) as subscriber:
        publisher.linger = subscriber.linger = 0
        allowed.answer(servers)
        allowed.guard(publisher)
        port = publisher.bind_to_random_port("tcp://127.0.0.1")
        subscriber.curve_publickey, subscriber.curve_secretkey = keys.load(folder / "client.key_secret")
        subscriber.curve_serverkey = keys.load(folder / "server.key")[0]
        subscriber.subscribe(b"pose")
        subscriber.connect(f"tcp://127.0.0.1:{port}")
        for _ in range(400):
            publisher.send(b"pose 1")
            if subscriber.poll(50):
                break
        assert subscriber.recv(zmq.NOBLOCK) == b"pose 1"
