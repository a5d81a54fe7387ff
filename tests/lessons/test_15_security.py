"""Lesson 15: who comes in and who does not, keys that come and go while the server runs, files that are damaged, what
the wire shows, and a gate under strain."""

import contextlib
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

import pytest
import zmq
import zmq.auth

from netmq_example.security import keys
from netmq_example.security.allow_list import AllowList
from netmq_example.security.requester import ClientKeys, SecureRequester
from tests.bad_peers import SlowLine
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import bind
from tests.programs import ROOT, Run, finished, python_runs, steady_endpoint

KEY = "15_security"
FOLDER = ROOT / "python" / KEY
each_client = pytest.mark.parametrize("kind", CLIENTS)
each_side = pytest.mark.parametrize("side", ["python", "csharp"])
NOBODY = "a" * 40
# C# compiles its cryptography, and a busy machine takes its time.
PATIENT = ("--timeout", "30")
NO_KEY = "keys.py makes keys, and server.key is a copy of the server's"
TAKEN = "is there, and is never overwritten; rotate makes a new pair, revoke frees a name"
REVOKED = "error: your key is not on the list, or not any more"


def switch(kind, name):
    """An option without a value, which in Unity is a field, and has one."""
    return [name, *(["true"] if kind == "unity" else [])]


@pytest.fixture
def folder(tmp_path):
    """The keys of a server, and of one client, alice."""
    keys.example(tmp_path / "keys")
    return tmp_path / "keys"


@pytest.fixture
def alice(folder):
    return keys.load(folder / "client.key")[0].decode()


@pytest.fixture
def connect(connect, folder):
    """connect(endpoint): a socket with alice's keys, or with those that it is given."""

    def with_keys(endpoint, pair=None, kind=zmq.REQ, **options):
        public, secret = pair or keys.load(folder / "client.key_secret")
        server = keys.load(folder / "server.key")[0]
        mine = {"curve_publickey": public, "curve_secretkey": secret, "curve_serverkey": server}
        return connect(endpoint, kind, **mine, **options)

    return with_keys


def ask(asker):
    asker.send(b"Hello")
    return asker.recv().decode()


def let_in(connected):
    """Alice's connection, as soon as she may come in.

    A list that takes long to read is not read for each who knocks, and who was refused does not knock again.
    """
    for _ in range(60):
        asker = connected()
        asker.send(b"Hello")
        if asker.poll(1000):
            assert asker.recv_string() == "Hello alice"
            return asker
    raise AssertionError("alice does not come in")


def ran(*each, folder):
    """keys.py as a user runs it, once for each of these lists of words: how each run ended."""
    return python_runs(FOLDER / "keys.py", [[*map(str, words), "--keys", str(folder)] for words in each])


# Who comes in


@each_client
def test_who_is_on_the_list_comes_in_and_nobody_else(kind, folder, alice, tmp_path, serve, runs):
    server, endpoint = serve(KEY, "--keys", str(folder))
    server_key = "--serverKey" if kind == "unity" else "--server-key"
    # A refusal is told by the connection, at once. The others may have time.
    cases = {
        "": [],
        "stranger": switch(kind, "--stranger"),
        "wrong": [server_key, NOBODY],
        "plain": switch(kind, "--plain"),
    }
    always = ["--endpoint", endpoint, "--keys", str(folder), "--count", "2", *PATIENT]
    entered, *refused = runs(kind, KEY, [[*always, *options] for options in cases.values()])
    assert entered.code == 0, entered.lines
    greeting = "sent Hello, received Hello alice"
    assert entered.lines[-3:] == [f"1: {greeting}", f"2: {greeting}", "done: 2 replies"]
    strangers = []
    for name, run in zip([*cases][1:], refused, strict=True):
        assert run.code == 1, run.lines
        gave_up = next(line for line in run.lines if "gave up: " in line)
        tries = [f"1: connected and thrown out; try {i} of 3" for i in (2, 3)]
        assert [line for line in run.lines if "; try " in line] == tries
        said = f"gave up: 3 tries to ask {endpoint}, the last: connected and thrown out; "
        if name == "plain":
            assert gave_up == f"{said}a server with keys refuses who has none"
            continue
        asked = "is this client on its list, is server.key its key, and has it keys at all? This client's is "
        assert gave_up.startswith(f"{said}{asked}")
        mine = gave_up.rpartition(" ")[2]
        assert (mine == alice) == (name == "wrong")
        strangers += [mine] * (name == "stranger")
    named = [line for line in server.lines if line.startswith("refused: ") and "more" not in line]
    assert named == [f"refused: key {key} from 127.0.0.1 is not in {folder / 'allowed'}" for key in strangers]
    assert server.lines.count("alice from 127.0.0.1: 'Hello'") == 2


@each_client
def test_a_client_names_the_key_that_it_has_not_and_makes_what_it_can(kind, tmp_path, runs):
    for name in ("no secret", "public alone"):
        keys.make(tmp_path / name, "client")
        (tmp_path / name / "client.key_secret").unlink()
    shutil.copy(tmp_path / "no secret" / "client.key", tmp_path / "no secret" / "client.key_secret")
    (tmp_path / "file").write_text("")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    # A key may begin with two dashes, and is no option after the equals sign.
    server_key = f"{'--serverKey' if kind == 'unity' else '--server-key'}=--{zmq.curve_keypair()[0].decode()[2:]}"
    nowhere = ["--endpoint", "tcp://127.0.0.1:1", "--timeout", "0.3", "--tries", "1", "--keys"]
    wrong = {
        "no secret": f"no key in {tmp_path / 'no secret' / 'client.key_secret'}; {NO_KEY}",
        "public alone": f"{tmp_path / 'public alone' / 'client.key'} {TAKEN}",
        "file": str(tmp_path / "file"),
    }
    words = [[*nowhere, str(tmp_path / name), server_key] for name in (*wrong, "own")]
    *found, made, missing = runs(kind, KEY, [*words, [*nowhere, str(tmp_path / "none")]])
    # In full, because its folder is seldom the one where the keys were made.
    causes = [*wrong.values(), f"no key in {tmp_path / 'none' / 'server.key'}; {NO_KEY}"]
    for cause, run in zip(causes, [*found, missing], strict=True):
        assert run.code == (1 if kind == "unity" else 2) and cause in "\n".join(run.lines), run
        assert not [line for line in run.lines if "Unhandled" in line or "Traceback" in line]
    # Without a server it is not keys that are to be looked at.
    nobody = "gave up: 1 try to ask tcp://127.0.0.1:1, the last: no reply within 0.3 s; is the server running, or "
    assert made.code == 1 and nobody in "\n".join(made.lines)
    own = tmp_path / "own"
    assert keys.load(own / "client.key_secret")[0] == keys.load(own / "client.key")[0]
    assert before == {path: path.read_bytes() for path in before}


def test_a_server_that_makes_its_keys_says_where(tmp_path, start):
    command = [PYTHON, FOLDER / "server.py", "--endpoint", "tcp://127.0.0.1:0"]
    server = start(*command, folder=tmp_path)
    server.wait_for("^listening on ")
    assert server.lines[0] == f"keys: made {tmp_path / 'keys'}, with this server's and one client's, alice"


def test_a_server_that_may_not_listen_makes_no_keys(tmp_path):
    for program, *words in (["server.py"], ["gate.py", "--to", "tcp://127.0.0.1:5554"]):
        done = finished([PYTHON, FOLDER / program, *words, "--endpoint", "tcp://0.0.0.0:0"], cwd=tmp_path)
        assert done.returncode == 2 and "refused: 'tcp://0.0.0.0:0' would let anyone in" in done.stderr
        assert list(tmp_path.iterdir()) == []


def test_without_an_authenticator_nobody_comes_in(folder, serve, context):
    server, endpoint = serve(KEY, "--keys", str(folder), "--no-authenticator")
    asker = SecureRequester(endpoint, keys=ClientKeys(folder), timeout=30, tries=1, context=context)
    with asker, pytest.raises(TimeoutError, match="connected and thrown out"):
        asker.request("Hello")
    assert not [line for line in server.lines if "from" in line]


def test_without_an_authenticator_and_in_any_domain_everybody_does_and_each_message_tells(folder, serve, connect):
    """The mistake that the enforced domain prevents: the stranger's word arrives."""
    (folder / "allowed" / "empty.key").write_text("")
    server, endpoint = serve(KEY, "--keys", str(folder), "--no-authenticator", "--any-domain")
    assert ask(connect(endpoint, zmq.curve_keypair())) == REVOKED
    # Nor is a file without a key the name of those without one.
    server.wait_for("^nobody knows who from 127.0.0.1: 'Hello'$")


# Keys come and go


@each_side
def test_a_client_makes_its_keys_and_comes_in_as_soon_as_it_is_enrolled(side, folder, tmp_path, serve, start_client):
    _, endpoint = serve(KEY, "--keys", str(folder))
    own = tmp_path / "own"
    own.mkdir()
    (own / "server.key").write_bytes((folder / "server.key").read_bytes())
    options = ["--keys", str(own), "--tries", "1000", "--count", "2", *PATIENT]
    client = start_client(side, KEY, endpoint, *options)
    client.wait_for("^1: connected and thrown out; try 3 of 1000$")
    keys.enrol(folder, "bob", str(own / "client.key"))
    seen = len(client.lines)
    client.wait_for("^1: sent Hello, received Hello bob$")
    # A try is over at once, and a quarter of a second passes between two: two seconds.
    assert len([line for line in client.lines[seen:] if "thrown out" in line]) <= 8
    assert client.wait() == 0
    public, secret = zmq.auth.load_certificate(own / "client.key_secret")
    assert zmq.curve_public(secret) == public == zmq.auth.load_certificate(own / "client.key")[0]
    if os.name != "nt":
        assert (own / "client.key_secret").stat().st_mode & 0o777 == 0o600


PUBLIC = 'curve\n    public-key = "'


def test_a_key_taken_off_the_list_loses_its_live_connections_next_request(folder, serve, connect):
    """And so it does while its file is half written; a file that is no key ends nothing."""
    for name, content in {"empty": "", "bin": "\0" * 500, "short": f'{PUBLIC}abc"\n'}.items():
        (folder / "allowed" / f"{name}.key").write_text(content)
    server, endpoint = serve(KEY, "--keys", str(folder))
    live, file = connect(endpoint), folder / "allowed" / "alice.key"
    assert ask(live) == ask(live) == "Hello alice"
    whole = file.read_bytes()
    for half in ("curve\n    public-key", PUBLIC, f"{PUBLIC}abc", "curve\n    secret-key", "curve\n  public-key : x"):
        file.write_text(half)
        assert ask(live) == REVOKED, half
    stranger = connect(endpoint)
    stranger.send(b"Hello")
    server.wait_for("^refused: key ")
    file.write_bytes(whole)
    live = let_in(lambda: connect(endpoint))
    keys.revoke(folder, "alice")
    assert ask(live) == REVOKED
    other = zmq.curve_keypair()
    keys.enrol(folder, "alice", other[0].decode())
    known = let_in(lambda: connect(endpoint, other))
    assert ask(live) == REVOKED
    known.send(b"Bye" * 20)
    assert known.recv() == b"error: expected Hello, got '%b'" % (b"Bye" * 20)[:40]
    assert "Traceback" not in server.output


def test_the_keys_of_either_side_are_rotated_and_never_overwritten(folder, alice):
    before = {path.name: path.read_bytes() for path in folder.glob("*.key_secret")}
    for role in ("server", "client"):
        old = keys.load(folder / f"{role}.key")[0]
        made, rotated, again = ran(("make", role), ("rotate", role), ("rotate", role), folder=folder)
        assert made.code == 1 and f"{role}.key_secret is there, and is never overwritten" in made.lines[0]
        assert (rotated.code, again.code) == (0, 0)
        assert rotated.lines[0].endswith(f"; the old pair is in {folder / f'{role}.1.key_secret'}")
        assert (folder / f"{role}.1.key_secret").read_bytes() == before[f"{role}.key_secret"]
        assert (folder / f"{role}.2.key_secret").exists()
        public, secret = keys.load(folder / f"{role}.key_secret")
        assert old != public == keys.load(folder / f"{role}.key")[0] == zmq.curve_public(secret)
        assert again.lines[0].startswith(
            f"made {folder / role}.key and {role}.key_secret, public key {public.decode()}; "
        )
        if os.name != "nt":
            assert (folder / f"{role}.key_secret").stat().st_mode & 0o777 == 0o600
    file = folder / "client.key"
    taken, enrolled, twice = ran(
        ("enrol", f"alice={file}"), ("enrol", f"alice-2={file}"), ("enrol", f"bob={file}"), folder=folder
    )
    assert taken == Run(1, [f"{folder / 'allowed' / 'alice.key'} {TAKEN}"])
    assert enrolled == Run(0, [f"enrolled: alice-2, in {folder / 'allowed' / 'alice-2.key'}"])
    said = "that key is on the list already, as alice-2, and could be revoked by one name only"
    assert twice == Run(1, [said])
    assert AllowList(folder).name(keys.load(file)[0].decode()) == "alice-2"
    # A bad file hides no other. A pair is made whole or not at all: else its client would be refused, and nobody would
    # see why.
    (folder / "allowed" / "bob.key").write_text("curve\n    public-key")
    (folder / "client.key_secret").unlink()
    each = [("revoke", "alice-2"), ("list",), ("make", "client"), ("revoke", "alice"), ("revoke", "bob"), ("list",)]
    revoked, first, made, *_, nobody = ran(*each, folder=folder)
    assert revoked == Run(0, ["revoked: alice-2"])
    assert first == Run(0, [f"alice: {alice}", "bob: no key in it"])
    assert made == Run(1, [f"{file} {TAKEN}"]) and not (folder / "client.key_secret").exists()
    assert nobody == Run(0, ["nobody may come in"])


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of a file's size")
def test_a_disk_that_is_full_costs_no_pair_and_leaves_nothing_in_the_way(folder):
    before = {path: path.read_bytes() for path in folder.glob("*.key*")}
    full = ("sh", "-c", 'ulimit -f 0; exec "$@"', "sh", PYTHON, FOLDER / "keys.py")
    for words in (("rotate", "client"), ("enrol", f"bob={NOBODY}")):
        run = finished([*full, *words, "--keys", folder])
        assert run.returncode == 1 and run.stderr.startswith("cannot write "), run
    assert {path: path.read_bytes() for path in folder.glob("*.key*")} == before
    assert [path.name for path in (folder / "allowed").iterdir()] == ["alice.key"]


@pytest.mark.skipif(sys.platform != "linux" or os.getuid(), reason="only root can be another user: run it as root")
def test_a_secret_key_of_another_user_is_no_missing_one():
    """As after a first start with sudo."""
    load = (
        "import os, sys; from netmq_example.security import keys; os.setuid(65534); keys.load(keys.Path(sys.argv[1]))"
    )
    with tempfile.TemporaryDirectory() as folder:
        keys.make(Path(folder), "server")
        os.chmod(folder, 0o755)
        path = Path(folder, "server.key_secret")
        done = finished([PYTHON, "-c", load, path], cwd=ROOT / "python")
        cure = "start as the user who made it, or give it to this one"
        assert done.stderr.splitlines()[-1] == f"ValueError: this user may not read {path}; {cure}"


def test_a_key_replaced_by_one_of_the_same_time_is_revoked(folder, alice):
    """As by an archive that gives one time to all its files."""
    path = folder / "allowed" / "alice.key"
    os.utime(path, (1, 1))
    allowed = AllowList(folder)
    assert allowed.name(alice) == "alice"
    keys.revoke(folder, "alice")
    keys.enrol(folder, "alice", NOBODY)
    os.utime(path, (1, 1))
    assert not allowed.name(alice)


def test_keys_py_says_in_one_line_what_is_wrong(folder):
    wrong = {
        ("enrol", "bob"): "enrol does not take 'bob'",
        ("enrol", "../bob=" + NOBODY): "enrol does not take",
        ("enrol", "bob=nowhere.key"): f"no key in {(FOLDER / 'nowhere.key').absolute()}; enrol takes the path",
        ("enrol", "bob=" + "~" * 40): "no key: ",
        ("revoke", "bob"): "bob.key: No such file",
        ("rotate", "clients"): "rotate does not take 'clients'",
        ("sing",): "invalid choice: 'sing'",
    }
    for run, cause in zip(ran(*wrong, folder=folder), wrong.values(), strict=True):
        assert run.code in (1, 2) and cause in run.lines[-1], run
    # A list that cannot be read is none without names.
    shutil.rmtree(folder / "allowed")
    (folder / "allowed").touch()
    for run in ran(("list",), ("enrol", f"bob={NOBODY}"), folder=folder):
        assert run.code == 1 and run.lines[-1].startswith(f"{folder / 'allowed'}: "), run


def test_the_server_on_the_page_knows_its_clients(folder, tmp_path, start, connect):
    page = (ROOT / "docs" / "guide" / f"{KEY}.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    code = next(block for block in blocks if "import" in block)
    endpoint = steady_endpoint()
    assert code.count("tcp://127.0.0.1:5565") == 1
    code = code.replace("tcp://127.0.0.1:5565", endpoint)
    start(PYTHON, "-c", code, folder=tmp_path, PYTHONPATH=str(ROOT / "python")).wait_for("^listening$")
    live = connect(endpoint)
    assert ask(live) == "Hello alice"
    keys.revoke(folder, "alice")
    assert ask(live) == "error: your key is not on the list"


BAD = ("tcp://127.0.0.1:0", "tcp://127.0.0.1:99999")


def test_a_server_says_in_one_line_what_it_cannot_use(runs, tmp_path):
    (tmp_path / "file").write_text("")
    folder = tmp_path / "file" / "keys"
    always = ["--endpoint", "tcp://127.0.0.1:0", "--keys"]
    (server,) = runs("server", KEY, [[*always, str(folder)]])
    # It connects there; only where it listens is a matter of who may come in.
    elsewhere = {"tcp://192.168.1.5:5554": "no key in ", **dict.fromkeys(BAD, "bad endpoint")}
    each = [[*always, str(folder), "--to", "tcp://127.0.0.1:1"]]
    each += [[*always, str(tmp_path / "file"), "--to", to] for to in elsewhere]
    gate, *gates = python_runs(FOLDER / "gate.py", each)
    for run in (server, gate):
        assert run.code == 1
        assert run.lines[0].startswith(f"cannot write {folder}") and len(run.lines) == 1
        assert run.lines[0].endswith("; --keys names another folder")
    for run, (to, said) in zip(gates, elsewhere.items(), strict=True):
        assert run.code == (1 if said == "no key in " else 2) and said in run.lines[-1]
        assert said == "no key in " or f"'{to}': write it like" in run.lines[-1]


@each_client
def test_a_file_that_holds_no_key_of_a_clients_is_not_read(kind, folder, run):
    """A pipe would never end, and what is large would fill the memory."""
    always = ["--endpoint", "tcp://127.0.0.1:1", "--timeout", "0.3", "--tries", "1", "--keys"]
    key = (folder / "server.key").read_bytes()
    for how in ("large", *(["pipe"] if sys.platform != "win32" else [])):
        (folder / "server.key").unlink()
        if how == "large":
            # There is one in it.
            (folder / "server.key").write_bytes(key.ljust(4097))
        else:
            os.mkfifo(folder / "server.key")
        assert f"no key in {folder / 'server.key'}; {NO_KEY}" in "\n".join(run(kind, KEY, *always, str(folder)).lines)


# A gate in front of a server that knows nothing of keys


@pytest.fixture
def gate(folder, start, context):
    """The program and its endpoint, and the server behind it."""
    with context.socket(zmq.ROUTER) as behind:
        inside = bind(behind)
        words = ["--to", inside, "--endpoint", "tcp://127.0.0.1:0", "--keys", folder]
        program = start(PYTHON, FOLDER / "gate.py", *words)
        yield program, program.wait_for(r"^listening on (\S+)")[1], behind


@pytest.mark.parametrize(("key", "kind"), [("04_background_client", "unity"), ("14_long_jobs", "csharp")])
def test_clients_of_other_lessons_come_through_the_gate_with_keys(key, kind, folder, serve, start, run):
    words = ["--to", serve(key)[1], "--endpoint", "tcp://127.0.0.1:0", "--keys", folder]
    endpoint = start(PYTHON, FOLDER / "gate.py", *words).wait_for(r"^listening on (\S+)")[1]
    always = ["--endpoint", endpoint, "--count", "5"]
    without = run(kind, key, *always, "--tries", "1", "--timeout", "0.3")
    welcome = run(kind, key, *always, *PATIENT, "--with-keys", str(folder))
    assert (without.code, welcome.code) == (1, 0), (without, welcome)


def test_who_is_revoked_hears_no_more_of_what_was_asked_before(gate, folder, connect):
    """Such as the progress of a long job: the client says nothing any more by which the gate would know it."""
    _, endpoint, behind = gate
    other = zmq.curve_keypair()
    keys.write(folder / "allowed" / "bob.key", other[0])
    alice, bob = (connect(endpoint, pair, zmq.DEALER) for pair in (None, other))
    # Pictures pass as well.
    alice.send(bytes(100_000))
    job, passed = behind.recv_multipart()
    assert passed == bytes(100_000)
    keys.revoke(folder, "alice")
    behind.send_multipart([job, b"progress"])
    # When what came later has passed, the progress would have.
    bob.send(b"bob's question")
    behind.send_multipart([behind.recv_multipart()[0], bytes(100_000)])
    assert bob.recv() == bytes(100_000)
    assert not alice.poll(200)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of open files for a program")
@pytest.mark.parametrize(("limit", "crowd"), [("-Sn", 60), ("-n", 100)], ids=["that can be raised", "that cannot"])
def test_clients_that_come_and_go_take_a_gate_no_file_that_it_needs(limit, crowd, folder, serve, start, connect):
    """Often 1024 may be open, and what a client takes stays for a while when it has gone."""
    words = [PYTHON, FOLDER / "gate.py", "--to", serve("01_request_reply")[1], "--keys", folder]
    words += ["--endpoint", "tcp://127.0.0.1:0"]
    program = start("sh", "-c", f'ulimit {limit} 64; exec "$@"', "sh", *words)
    endpoint = program.wait_for(r"^listening on (\S+)")[1]
    for _ in range(crowd):
        asker = connect(endpoint)
        asker.send(b"Hello")
        if limit == "-Sn":
            assert asker.recv() == b"World"
        else:
            # As many as there is room for come in.
            asker.poll(20)
            asker.close()
    assert ask(connect(endpoint)) == "World"
    assert program.stop() == 0
    assert "Traceback" not in program.output


@pytest.mark.skipif(sys.platform != "linux", reason="nowhere else a program's limit can be set from outside")
def test_connections_of_strangers_that_take_all_files_keep_nobody_out_for_ever(folder, serve, connect):
    import resource

    server, endpoint = serve(KEY, "--keys", str(folder))
    number, limits = server.process.pid, resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE)
    # It is still one connection.
    resource.prlimit(number, resource.RLIMIT_NOFILE, (len(os.listdir(f"/proc/{number}/fd")) + 1, limits[1]))
    connect(endpoint, zmq.curve_keypair()).send(b"Hello")
    server.wait_for("^trouble: cannot read the list: Too many open files; nobody new comes in until that is over$")
    resource.prlimit(number, resource.RLIMIT_NOFILE, limits)
    let_in(lambda: connect(endpoint))
    assert "Traceback" not in server.output


def test_an_answer_goes_to_the_key_that_has_asked(gate, folder, connect):
    """A client chooses the address of its socket itself, and it may choose that of another."""
    _, endpoint, behind = gate
    other = zmq.curve_keypair()
    keys.write(folder / "allowed" / "bob.key", other[0])
    alice = connect(endpoint, None, zmq.DEALER, identity=b"same")
    alice.send(b"alice asks")
    job, _ = behind.recv_multipart()
    alice.close()
    # An address is free when the gate has seen that its owner is gone. Until then nobody hears who comes with it; and
    # an earlier bob who asks with his last breath may be its next owner.
    for _ in range(200):
        bob = connect(endpoint, other, zmq.DEALER, identity=b"same")
        bob.send(b"bob comes")
        while behind.poll(100):
            behind.send_multipart([behind.recv_multipart()[0], b"welcome"])
        if bob.poll(100):
            break
        bob.close()
    assert bob.recv(zmq.NOBLOCK) == b"welcome"
    behind.send_multipart([job, b"alice's answer"])
    bob.send(b"bob asks")
    behind.send_multipart([behind.recv_multipart()[0], b"bob's answer"])
    assert bob.recv() == b"bob's answer"


def test_a_revoked_client_that_goes_on_makes_no_flood_of_lines(gate, folder, connect):
    program, endpoint, behind = gate
    alice = connect(endpoint, None, zmq.DEALER)
    alice.send(b"first")
    behind.recv_multipart()
    keys.revoke(folder, "alice")
    for _ in range(100):
        alice.send(b"again")
    alice.send(b"last")
    key = keys.load(folder / "client.key")[0].decode()
    program.wait_for("^refused: key .* times more$")
    assert program.lines[1] == f"refused: key {key} from 127.0.0.1 is not in {folder / 'allowed'}"
    # How often is told from time to time.
    assert len(program.lines) < 6 and not behind.poll(0)


# What is seen on the wire


class Recorder(SlowLine):
    """A line that is not slow, and keeps what both sides send."""

    def __init__(self, endpoint):
        super().__init__(endpoint, 0)
        self.seen = b""

    def copy(self, source, target):
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                self.seen += data
                target.sendall(data)


@each_side
def test_nobody_on_the_wire_reads_a_word(side, folder, serve, runs):
    with Recorder(serve(KEY, "--keys", str(folder))[1]) as wire:
        (run,) = runs(side, KEY, [["--endpoint", wire.endpoint, "--keys", str(folder), "--count", "2", *PATIENT]])
        assert run.code == 0, run.lines
        assert len(wire.seen) > 800 and b"Hello" not in wire.seen and b"alice" not in wire.seen


# Many strangers


def test_a_flood_of_new_keys_is_no_flood_of_lines(folder, caplog):
    allowed = AllowList(folder)
    for _ in range(1030):
        allowed.refuse(zmq.curve_keypair()[0].decode(), "192.0.2.1")
    allowed.report_again()
    assert len(caplog.messages) == 11
    assert caplog.messages[-1] == "refused: other keys, 1020 times"


UNCLOSED = """
import sys
import zmq
from netmq_example.security.allow_list import AllowList
context = zmq.Context()
AllowList(sys.argv[1]).answer(context)
raise SystemExit("an end without closing")
"""


def test_a_program_that_closes_nothing_ends_all_the_same(folder, start):
    program = start(PYTHON, "-c", UNCLOSED, folder, PYTHONPATH=str(ROOT / "python"))
    assert program.wait() == 1
    assert program.lines == ["an end without closing"]
