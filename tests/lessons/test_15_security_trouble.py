"""Lesson 15: key files that are damaged, in the way or held twice, a list that is long, and a gate under strain."""

from __future__ import annotations

import contextlib
import os
import shutil
import time

import pytest
import zmq

from netmq_example.security import keys
from netmq_example.security.allow_list import AllowList
from netmq_example.security.requester import ClientKeys, SecureRequester
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.test_15_security import FOLDER, KEY, ask, ran
from tests.programs import LIMIT, finished

NO_KEY = "keys.py makes keys, and server.key is a copy of the server's"
TAKEN = "is there, and is never overwritten; rotate makes a new pair, revoke frees a name"


@pytest.fixture
def folder(tmp_path):
    """The keys of a server, and of one client, alice."""
    keys.example(tmp_path / "keys")
    return tmp_path / "keys"


@pytest.fixture
def connect(context, folder):
    """connect(endpoint): a socket with alice's keys, or with those that it is given."""
    with contextlib.ExitStack() as stack:

        def connect(endpoint, pair=None, kind=zmq.DEALER, name=b""):
            socket = stack.enter_context(context.socket(kind))
            socket.linger = 0
            socket.curve_publickey, socket.curve_secretkey = pair or keys.load(folder / "client.key_secret")
            socket.curve_serverkey = keys.load(folder / "server.key")[0]
            if name:
                socket.identity = name
            socket.connect(endpoint)
            return socket

        yield connect


# Files


PUBLIC = 'curve\n    public-key = "'


@pytest.mark.parametrize(
    "half", ["curve\n    public-key", PUBLIC, PUBLIC + "abc", "curve\n    secret-key", "curve\n  public-key : x"]
)
def test_a_half_written_key_ends_nothing(half, folder, serve, connect):
    """While a file is copied into the list, its beginning is all there is of it."""
    server, endpoint = serve(KEY, "--keys", str(folder))
    live = connect(endpoint, kind=zmq.REQ)
    assert ask(live) == "Hello alice"
    whole = (folder / "allowed" / "alice.key").read_bytes()
    (folder / "allowed" / "alice.key").write_text(half)
    assert ask(live) == "error: your key is not on the list, or not any more"
    stranger = connect(endpoint, kind=zmq.REQ)
    stranger.send(b"Hello")
    server.wait_for("^refused: key ")
    (folder / "allowed" / "alice.key").write_bytes(whole)
    # A list that takes long to read is not read for each who knocks, and who was refused does not knock again.
    for _ in range(20):
        live = connect(endpoint, kind=zmq.REQ)
        live.send(b"Hello")
        if live.poll(1000):
            break
    assert live.recv_string(zmq.NOBLOCK) == "Hello alice"
    assert "Traceback" not in server.output


def test_a_file_without_a_key_is_not_the_name_of_those_without_one(folder, serve, connect):
    (folder / "allowed" / "empty.key").write_text("")
    assert AllowList(folder).name("") == ""
    server, endpoint = serve(KEY, "--keys", str(folder), "--no-authenticator", "--any-domain")
    stranger = connect(endpoint, zmq.curve_keypair(), zmq.REQ)
    assert ask(stranger) == "error: your key is not on the list, or not any more"
    server.wait_for("^nobody knows who from")


@pytest.mark.parametrize("kind", CLIENTS)
@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("a secret file without a secret", f"no key in {{}}/client.key_secret; {NO_KEY}"),
        ("a public key alone", f"{{}}/client.key {TAKEN}"),
        ("a file in place of the folder", "{}"),
    ],
)
def test_a_client_says_in_one_line_what_is_wrong_with_its_keys(kind, what, said, tmp_path, start, client_command):
    folder = tmp_path / "own"
    if "folder" in what:
        folder.write_text("")
    else:
        keys.make(folder, "client")
        (folder / "client.key_secret").unlink()
        if "without" in what:
            shutil.copy(folder / "client.key", folder / "client.key_secret")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*.key*")}
    option = "--serverKey" if kind == "unity" else "--server-key"
    # A key may begin with two dashes, and is no option after the equals sign.
    words = ["--keys", str(folder), f"{option}=--{zmq.curve_keypair()[0].decode()[2:]}"]
    client = start(*client_command(kind, KEY, "tcp://127.0.0.1:1", *words))
    assert client.wait() == (1 if kind == "unity" else 2), client.output
    assert said.format(folder) in client.output
    assert "Unhandled" not in client.output and "Traceback" not in client.output
    assert before == {path: path.read_bytes() for path in tmp_path.rglob("*.key*")}


@pytest.mark.parametrize("program", ["server.py", "gate.py"])
def test_a_server_says_in_one_line_that_it_cannot_make_its_keys(program, tmp_path):
    (tmp_path / "file").write_text("")
    words = ["--endpoint", "tcp://127.0.0.1:0", "--keys", tmp_path / "file" / "keys"]
    words += ["--to", "tcp://127.0.0.1:1"] if program == "gate.py" else []
    done = finished([PYTHON, FOLDER / program, *words])
    assert done.returncode == 1 and done.stdout == ""
    assert done.stderr.startswith(f"cannot write {tmp_path / 'file' / 'keys'}") and done.stderr.count("\n") == 1
    assert "; --keys names another folder" in done.stderr


@pytest.mark.parametrize(
    ("to", "said"),
    [
        ("tcp://192.168.1.5:5554", "no key in "),
        ("tcp://127.0.0.1:0", "bad endpoint 'tcp://127.0.0.1:0': write it like"),
        ("tcp://127.0.0.1:99999", "bad endpoint 'tcp://127.0.0.1:99999': write it like"),
    ],
)
def test_a_gate_may_stand_before_another_machine(to, said, tmp_path):
    """It connects there; only where it listens is a matter of who may come in."""
    (tmp_path / "keys").write_text("it gets no further than this")
    words = [PYTHON, FOLDER / "gate.py", "--endpoint", "tcp://127.0.0.1:0", "--to", to]
    done = finished(words, cwd=tmp_path)
    assert (done.returncode, said in done.stderr) == (1 if said.startswith("no key") else 2, True), done.stderr


def test_a_pair_is_made_whole_or_not_at_all(tmp_path):
    """A secret key beside the public one of another pair: the client would be refused, and nobody would see why."""
    public, _ = zmq.curve_keypair()
    keys.write(tmp_path / "client.key", public)
    assert ran("make", "client", folder=tmp_path) == (1, f"{tmp_path / 'client.key'} {TAKEN}\n")
    assert os.listdir(tmp_path) == ["client.key"]


def test_a_key_is_on_the_list_under_one_name_and_a_bad_file_hides_no_other(folder):
    code, said = ran("enrol", f"bob={folder / 'client.key'}", folder=folder)
    assert (code, said) == (1, "that key is on the list already, as alice, and could be revoked by one name only\n")
    (folder / "allowed" / "bob.key").write_text("curve\n    public-key")
    alice = keys.load(folder / "client.key")[0].decode()
    assert ran("list", folder=folder) == (0, f"alice: {alice}\nbob: no key in it\n")


def test_many_strangers_do_not_wait_for_a_long_list(folder):
    """Each handshake asks; reading five hundred files for each would hold up those who may come in."""
    pairs = [zmq.curve_keypair()[0] for _ in range(200)]
    for i, public in enumerate(pairs):
        keys.write(folder / "allowed" / f"client{i}.key", public)
    allowed, read = AllowList(folder), []
    strangers = [zmq.curve_keypair()[0].decode() for _ in range(200)]
    load = keys.load

    def counted(path):
        read.append(path)
        return load(path)

    keys.load = counted  # type: ignore[assignment]
    try:
        began = time.monotonic()
        assert not any(allowed.name(key) for key in strangers)
        assert all(allowed.name(key.decode()) for key in pairs)
    finally:
        keys.load = load
    # Once for the first, and then at most as often as a tenth of the time allows.
    assert len(read) < 200 * 40, f"{len(read)} files read in {time.monotonic() - began:.2f} s"
    keys.write(folder / "allowed" / "late.key", strangers[0].encode())
    deadline = time.monotonic() + LIMIT
    while not allowed.name(strangers[0]):
        assert time.monotonic() < deadline, "who is enrolled comes in"


def secure(context, **how):
    return SecureRequester(context, how.pop("endpoint", "tcp://127.0.0.1:1"), **how)


@pytest.mark.parametrize(
    ("name", "attempt"),
    [
        ("folder", lambda folder, context: keys.make("", "server")),
        ("folder", lambda folder, context: AllowList(None)),
        ("folder", lambda folder, context: ClientKeys("", keys.load(folder / "server.key")[0].decode())),
        ("role", lambda folder, context: keys.make(folder, "../server")),
        ("role", lambda folder, context: keys.rotate(folder, None)),
        ("name", lambda folder, context: keys.enrol(folder, "../bob", "a" * 40)),
        ("name", lambda folder, context: keys.revoke(folder, "")),
        ("key takes", lambda folder, context: keys.enrol(folder, "bob", 0)),
        ("a key is", lambda folder, context: keys.checked("a" * 40)),
        ("report", lambda folder, context: AllowList(folder, None)),
        ("context", lambda folder, context: AllowList(folder).answer(None)),
        ("socket", lambda folder, context: AllowList(folder).guard(None)),
        ("frame", lambda folder, context: AllowList(folder).name_of(b"Hello")),
        ("key", lambda folder, context: AllowList(folder).name(b"a" * 40)),
        ("context", lambda folder, context: secure(None)),
        ("endpoint", lambda folder, context: secure(context, endpoint="tcp://127.0.0.1:99999")),
        ("keys", lambda folder, context: secure(context, keys="")),
        ("timeout", lambda folder, context: secure(context, timeout=0)),
        ("timeout", lambda folder, context: secure(context, timeout=float("nan"))),
        ("tries", lambda folder, context: secure(context, tries=0)),
        ("tries", lambda folder, context: secure(context, tries=None)),
        ("report", lambda folder, context: secure(context, report="print")),
        ("text", lambda folder, context: secure(context).request(None)),
    ],
)
def test_what_cannot_be_is_named_at_once(name, attempt, folder, context):
    before = sorted(folder.rglob("*"))
    with pytest.raises((TypeError, ValueError), match=rf"^(bad )?{name}\b.*$"):
        attempt(folder, context)
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("kind", ["csharp", "unity"])
def test_a_subscriber_in_csharp_hears_only_with_a_key(kind, folder, start, client_command):
    """Lesson 03's client as it is, with one option more; its PUB socket takes the keys itself."""
    said: list[str] = []
    with zmq.Context() as servers, servers.socket(zmq.PUB) as publisher:
        publisher.linger = 0
        allowed = AllowList(folder, said.append)
        allowed.answer(servers)
        allowed.guard(publisher)
        endpoint = f"tcp://127.0.0.1:{publisher.bind_to_random_port('tcp://127.0.0.1')}"
        words = client_command(kind, "03_publish_subscribe", endpoint, "--count", "3", "--every", "1", "--timeout")
        stranger, alice = start(*words, "5"), start(*words, "25", "--with-keys", str(folder))
        deadline, number = time.monotonic() + LIMIT, 0
        while alice.process.poll() is None and time.monotonic() < deadline:
            number += 1
            publisher.send_string(f"pose/ {number} {time.time():.6f} 0.0 0.5 0.0")
            time.sleep(0.01)
        assert alice.wait() == 0, alice.output
        assert len([line for line in alice.lines if line.startswith("received pose/ ")]) == 3
        stranger.process.wait(LIMIT)
        assert not [line for line in stranger.lines if line.startswith("received")], stranger.output


# A gate


@pytest.fixture
def gate(folder, start, context):
    """gate(): the program and its endpoint, and the server behind it."""
    with context.socket(zmq.ROUTER) as behind:
        behind.linger = 0
        inside = f"tcp://127.0.0.1:{behind.bind_to_random_port('tcp://127.0.0.1')}"
        program = start(PYTHON, FOLDER / "gate.py", "--to", inside, "--endpoint", "tcp://127.0.0.1:0", "--keys", folder)
        yield program, program.wait_for(r"^listening on (\S+)")[1], behind


def heard(behind):
    assert behind.poll(LIMIT * 1000)
    return behind.recv_multipart()


def test_who_is_revoked_hears_no_more_of_what_was_asked_before(gate, folder, connect):
    """Such as the progress of a long job: the client says nothing any more by which the gate would know it."""
    _, endpoint, behind = gate
    other = zmq.curve_keypair()
    keys.write(folder / "allowed" / "bob.key", other[0])
    alice, bob = connect(endpoint), connect(endpoint, other)
    alice.send(b"alice's job")
    job, _ = heard(behind)
    assert ran("revoke", "alice", folder=folder)[0] == 0
    behind.send_multipart([job, b"progress"])
    # When what came later has passed, the progress would have.
    bob.send(b"bob's question")
    behind.send_multipart([heard(behind)[0], b"bob's answer"])
    assert bob.poll(LIMIT * 1000) and bob.recv() == b"bob's answer"
    assert not alice.poll(200)


def test_an_answer_goes_to_the_key_that_has_asked(gate, folder, connect):
    """A client chooses the address of its socket itself, and it may choose that of another."""
    _, endpoint, behind = gate
    other = zmq.curve_keypair()
    keys.write(folder / "allowed" / "bob.key", other[0])
    alice = connect(endpoint, name=b"same")
    alice.send(b"alice asks")
    job, _ = heard(behind)
    alice.close()
    # An address is free when the gate has seen that its owner is gone. Until then nobody hears who comes with it; and
    # an earlier bob who asks with his last breath may be its next owner.
    for _ in range(200):
        bob = connect(endpoint, other, name=b"same")
        bob.send(b"bob comes")
        while behind.poll(100):
            behind.send_multipart([heard(behind)[0], b"welcome"])
        if bob.poll(100):
            break
        bob.close()
    assert bob.recv(zmq.NOBLOCK) == b"welcome"
    behind.send_multipart([job, b"alice's answer"])
    bob.send(b"bob asks")
    behind.send_multipart([heard(behind)[0], b"bob's answer"])
    assert bob.poll(LIMIT * 1000) and bob.recv() == b"bob's answer"


def test_a_revoked_client_that_goes_on_makes_no_flood_of_lines(gate, folder, connect):
    program, endpoint, behind = gate
    alice = connect(endpoint)
    alice.send(b"first")
    heard(behind)
    assert ran("revoke", "alice", folder=folder)[0] == 0
    for _ in range(500):
        alice.send(b"again")
    alice.send(b"last")
    key = keys.load(folder / "client.key")[0].decode()
    program.wait_for("^refused: key .* times more$")
    assert program.lines[1] == f"refused: key {key} from 127.0.0.1 is not in {folder / 'allowed'}"
    # How often is told from time to time.
    assert len(program.lines) < 6 and not behind.poll(0)
