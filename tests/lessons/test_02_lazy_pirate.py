"""Lesson 02: lost, late and repeated replies, a server that is killed and comes back, and a sum that stays exact."""

import contextlib
import os
import random
import re
import sqlite3
import subprocess
import sys
import time

import pytest
import zmq

try:
    import resource
except ImportError:
    resource = None  # Windows has none.

from netmq_example.journal import Journal
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import ask, bind, retry
from tests.programs import ROOT, steady_endpoint

KEY = "02_lazy_pirate"
SERVER = ROOT / "python" / KEY / "server.py"
clients = pytest.mark.parametrize("kind", CLIENTS)


def received(numbers):
    return [f"{i}: sent add 1, received {i}" for i in numbers]


def replies(client):
    return [line for line in client.lines if "received" in line]


def fate(server, word):
    """The request, as the client counts them, of which the server says this.

    The server's own count goes by tries, of which there are more on a busy machine.
    """
    return int(server.wait_for(rf"b'(\d+)-\w+': '\d+'(?:, from the journal)?, {word}")[1])


@pytest.fixture
def journal(tmp_path):
    return tmp_path / "journal.sqlite3"


@pytest.fixture
def pirate_server(serve, journal):
    """Like serve(), with a journal of this test's own, which the next server of the test opens again."""

    def pirate_server(*options, endpoint="tcp://127.0.0.1:*"):
        return serve(KEY, "--journal", str(journal), *options, endpoint=endpoint)

    return pirate_server


def balance(context, endpoint):
    return int(ask(context, endpoint, os.urandom(8).hex().encode(), b"balance")[1])


def test_a_crash_between_the_work_and_the_reply(pirate_server, start_client):
    """The other clients have servers that are killed, below."""
    endpoint = steady_endpoint()
    server, _ = pirate_server("--crash-on", "3", endpoint=endpoint)
    # The next server may need longer to begin than five tries last.
    client = start_client("unity", KEY, endpoint, "--count", "5", "--tries", "20")
    assert server.wait() == 1
    i = fate(server, "crash")
    again, _ = pirate_server(endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert again.lines[0].endswith(f"balance {i}"), "the crash came after the commit"
    again.wait_for("^request 1, ")
    assert re.fullmatch(rf"request 1, b'{i}-\w+': '{i}', from the journal", again.lines[2])
    assert replies(client) == received(range(1, 6))
    assert retry(i, 2, tries=20, timeout=0.5) in client.lines


def test_only_new_work_crashes_the_server(context, pirate_server):
    """While it starts on a busy machine, a client asks the same more than once: it must not crash again at that."""
    _, endpoint = pirate_server("--crash-on", "2")
    assert [ask(context, endpoint, b"1", b"add 1")[1] for _ in range(3)] == [b"1"] * 3


@clients
def test_a_server_that_speaks_otherwise(kind, serve, run):
    """Its answer is shown, so that the reader sees what is wrong; and a wrong answer does not use up all tries at once,
    because the right server may be there in a moment."""
    _, endpoint = serve("01_request_reply")
    began = time.monotonic()
    client = run(kind, KEY, "--endpoint", endpoint, "--tries", "4", "--timeout", "20")
    assert client.code == 1, client
    # A pause before each of the three retries, and no wait for what was answered.
    assert time.monotonic() - began > 3 * 0.25
    wrong = r"dropped a reply to another request \(error: expected Hello, got .*\)"
    for line, attempt in zip(client.lines[1:4], (2, 3, 4), strict=True):
        assert re.fullmatch(rf"1: {wrong}; try {attempt} of 4", line)
    assert re.fullmatch(
        rf"gave up: 4 tries to ask {endpoint}, the last: {wrong}; is the right server .*", client.lines[-1]
    )


@clients
def test_the_bytes_of_a_client(kind, context, start_client):
    """Against a plain REP: two frames, an id that every retry repeats and no other request has, UTF-8 both ways."""
    with context.socket(zmq.REP) as rep:
        options = ["--count", "3", "--text", "füge ✓ hinzu", "--timeout", "20"]
        client = start_client(kind, KEY, bind(rep), *options)
        seen = []
        for answer in ([b"W\xc3\xb6rld"], None, [b"one", b"two"], None):
            request_id, text = rep.recv_multipart()
            assert text.decode() == "füge ✓ hinzu"
            seen.append(request_id.decode())
            # No reply has other frames than [id][text], with the request's own id.
            rep.send_multipart([request_id, "grün".encode()] if answer is None else answer)
        last = rep.recv_multipart()[0]
        rep.send_multipart([last, b"3"])
        assert client.wait() == 0, client.output
    assert seen[0] == seen[1] != seen[2] == seen[3] != last.decode()
    assert replies(client) == [
        "1: sent füge ✓ hinzu, received grün",
        "2: sent füge ✓ hinzu, received grün",
        "3: sent füge ✓ hinzu, received 3",
    ]
    assert "dropped a reply to another request (Wörld)" in client.lines[1]
    assert "dropped a reply to another request (one two)" in client.lines[3]


GARBAGE = {
    "an endless id": [b"i" * 101, b"add 1"],
    "an id of sixty thousand bytes": [b"i" * 60_000, b"add 1"],
    "nothing to add": [b"1", b"add "],
    "less": [b"1", b"add -1"],
    "a part": [b"1", b"add 1.5"],
    "more than all": [b"1", b"add 99999999999999999999"],
    "other digits": [b"1", "add \N{ARABIC-INDIC DIGIT ONE}".encode()],
    "a closing zero": [b"1", b"add 1\0"],
    "two lines": [b"1", b"add 1\n"],
}


def test_a_bad_request_gets_an_error_and_changes_nothing(serve, context):
    """And what is printed of a good one does no harm to a poor terminal."""
    server, endpoint = serve(KEY, PYTHONIOENCODING="ascii", PYTHONUTF8="0")
    assert ask(context, endpoint, b"first", b"add 2") == [b"first", b"2"]
    for name, frames in GARBAGE.items():
        reply = ask(context, endpoint, *frames)
        assert reply[-1].startswith(b"error: expected "), name
        assert reply[:-1] == frames[:1], name
        assert balance(context, endpoint) == 2, name
    # The longest id, and the largest addition.
    assert ask(context, endpoint, b"i" * 100, b"add 999999999") == [b"i" * 100, b"1000000001"]
    for request_id in (b"\xff", b"\x1b[2J\r\nfake\x07", "grün ✓".encode()):
        assert ask(context, endpoint, request_id, b"add 1")[0] == request_id
    server.wait_for("'1000000004'$")
    assert server.stop() == 0
    assert "Traceback" not in server.output
    said = [re.sub("^request [0-9]+, ", "", line) for line in server.lines if "balance" not in line]
    assert said[-4:] == [
        "b'iiiiiiiiii': '1000000001'",
        r"b'\xff': '1000000002'",
        r"b'\x1b[2J\r\nfake': '1000000003'",
        r"b'gr\xc3\xbcn \xe2\x9c\x93': '1000000004'",
    ]


def test_the_journal_does_not_grow_for_ever(serve_own, journal, context):
    short = "from netmq_example import journal\njournal.KEPT_ENTRIES = 10"
    server, endpoint = serve_own(KEY, short, "--journal", journal)
    for i in range(25):
        assert ask(context, endpoint, b"%d" % i, b"add 1") == [b"%d" % i, b"%d" % (i + 1)]
    # The newest ten are known still, an older one is not.
    assert ask(context, endpoint, b"15", b"add 1") == [b"15", b"16"]
    assert ask(context, endpoint, b"14", b"add 1") == [b"14", b"26"]
    server.stop()
    with sqlite3.connect(journal) as db:
        assert db.execute("SELECT count(*) FROM journal").fetchone() == (10,)
    db.close()


def test_a_journal_that_is_none_is_named_with_its_cure(run, tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("not a database, but long enough to be taken for the header of one\n" * 20)
    alien = tmp_path / "alien.sqlite3"
    with sqlite3.connect(alien) as db:
        db.execute("CREATE TABLE journal (page TEXT)")
    db.close()
    for path in text, alien, tmp_path, tmp_path / "nowhere" / "journal.sqlite3", "", ":memory:":
        server = run("server", KEY, "--endpoint", "tcp://127.0.0.1:*", "--journal", str(path))
        assert server.code == 2, server
        assert f"--journal: cannot use the journal {path}: " in server.lines[-1]
        assert server.lines[-1].endswith("; try another file")
    assert text.read_text().startswith("not a database")


@contextlib.contextmanager
def locked(journal, server):
    other = sqlite3.connect(journal, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    yield "database is locked"
    other.close()


@contextlib.contextmanager
def full(journal, server):
    """No file may grow: to SQLite a disk on which nothing can be written any more."""
    if not hasattr(resource, "prlimit"):
        pytest.skip("only Linux takes a running program's disk away")
    limits = resource.prlimit(server, resource.RLIMIT_FSIZE, (1, resource.RLIM_INFINITY))
    yield "disk I/O error"
    resource.prlimit(server, resource.RLIMIT_FSIZE, limits)


@contextlib.contextmanager
def moved(journal, server, end="", replaced=False):
    """Another file in its place is not it."""
    if sys.platform == "win32":
        pytest.skip("Windows keeps a file that is open from being deleted")
    gone, elsewhere = journal.with_name(journal.name + end), journal.with_name("elsewhere")
    gone.rename(elsewhere)
    if replaced:
        gone.write_bytes(elsewhere.read_bytes())
    yield "it was deleted or replaced; put it back, or start the server again"
    elsewhere.rename(gone)


TROUBLES = {
    "locked": locked,
    "on a full disk": full,
    "deleted": moved,
    "without its newest part": lambda *where: moved(*where, end="-wal"),
    "replaced": lambda *where: moved(*where, replaced=True),
}


@pytest.mark.parametrize("trouble", TROUBLES.values(), ids=TROUBLES)
def test_a_journal_that_cannot_be_used_is_waited_for(trouble, pirate_server, journal, context, start_client):
    server, endpoint = pirate_server()
    assert ask(context, endpoint, b"first", b"add 1") == [b"first", b"1"]
    with trouble(journal, server.process.pid) as why:
        client = start_client("python", KEY, endpoint, "--count", "3", "--tries", "20")
        server.wait_for(f"^cannot use the journal {journal}: {why}; no replies until this is fixed$")
        # Said once, however often it is asked meanwhile.
        client.wait_for("try 3 of 20")
    assert client.wait() == 0, client.output
    server.wait_for(f"^the journal {journal} can be used again$")
    assert sum("cannot use" in line for line in server.lines) == 1
    assert replies(client) == [f"{i}: sent add 1, received {i + 1}" for i in (1, 2, 3)]
    server.kill()
    again, _ = pirate_server()
    assert again.lines[0].endswith("balance 4"), "nothing is lost"


def test_a_journal_refuses_what_it_could_not_keep(journal, caplog, monkeypatch):
    monkeypatch.setattr("netmq_example.trouble.again", {})
    book = Journal(str(journal), schema="CREATE TABLE account (balance); INSERT INTO account VALUES (0);")
    for request_id in (None, "1", b"", b"i" * 101):
        for use in (book.find, lambda request_id: book.do(request_id, "", lambda db, text: "1")):
            with pytest.raises((ValueError, TypeError), match=r"^request_id takes "):
                use(request_id)
    # A mistake in the work: nobody would be answered, the first time and ever after.
    for reply in (None, 5, ""):
        assert book.do(b"1", "", lambda db, text, reply=reply: reply).startswith("error: answer returned ")

    def raises(db, text):
        db.execute("UPDATE account SET balance = 7")
        raise KeyError("no such\nkey")

    assert book.do(b"1", "", raises) == "error: KeyError('no such\\nkey')"
    assert book.do(b"1", "", lambda db, text: str(db.execute("SELEKT 1"))).startswith("error: OperationalError(")
    # One for each place, and none for what is too long to be sent.
    assert book.do(b"1", "x" * 66_000, lambda db, text: text).startswith("error: answer returned what cannot be sent: ")
    assert len(book.do(b"1", "x" * 66_000, lambda db, text: dict[str, str]()[text])) < 1100
    assert sum(bool(record.exc_info) for record in caplog.records) == 3
    assert book.db.execute("SELECT balance FROM account").fetchone() == (0,), "what it changed is taken back"

    def refuses(db, text):
        db.execute("UPDATE account SET balance = 7")
        return "error: no"

    # Nor is a refusal kept, of which a flood would drive out what was done.
    assert book.do(b"1", "", refuses) == "error: no"
    assert book.db.execute("SELECT balance FROM account").fetchone() == (0,)
    assert book.find(b"1") == ""
    assert book.do(b"1", "", lambda db, text: "1") == book.find(b"1") == "1"
    with pytest.raises(sqlite3.IntegrityError):
        book.do(b"1", "", lambda db, text: "2")
    book.close()
    book.close()


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_sum_stays_exact_while_the_server_is_killed(kind, pirate_server, journal, start, context, start_client):
    endpoint = steady_endpoint()
    server, _ = pirate_server(endpoint=endpoint)
    clients = [start_client(kind, KEY, endpoint, "--count", "25", "--tries", "20") for _ in range(3)]

    def asking():
        return any(client.process.poll() is None for client in clients)

    kills = 0
    while asking():
        wanted = len(server.lines) + random.randrange(20)
        while len(server.lines) < wanted and asking():
            time.sleep(0.01)
        server.kill()
        kills += 1
        # Now and then once more in its first moments, while it opens the journal that the last kill left.
        if random.random() < 0.2:
            early = start(PYTHON, SERVER, "--endpoint", endpoint, "--journal", journal)
            with contextlib.suppress(subprocess.TimeoutExpired):
                early.process.wait(random.uniform(0, 0.3))
            early.kill()
        server, _ = pirate_server(endpoint=endpoint)
    assert kills > 2
    for client in clients:
        assert client.wait() == 0, client.output
        assert client.lines[-1] == "done: 25 replies"
        balances = [int(line.rpartition(" ")[2]) for line in replies(client)]
        assert len(balances) == 25
        assert balances == sorted(set(balances)), "each addition is answered with the balance after it"
    assert balance(context, endpoint) == 25 * len(clients)
