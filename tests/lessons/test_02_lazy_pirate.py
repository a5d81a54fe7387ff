"""Lesson 02: lost, late and repeated replies, a server that is killed and comes back, and a sum that stays exact."""

from __future__ import annotations

import os
import random
import re
import signal
import socket
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

from tests.bad_peers import ProtocolBreaker, SlowLine
from tests.conftest import CLIENTS, PYTHON
from tests.programs import LIMIT, ROOT, steady_port

KEY = "02_lazy_pirate"
SERVER = ROOT / "python" / KEY / "server.py"
# Throwing the socket away, and keeping it. For the player, --relaxed is a field and needs a value.
WAYS = [
    ("python", ()),
    ("python", ("--relaxed",)),
    ("csharp", ()),
    ("csharp", ("--relaxed",)),
    ("unity", ()),
    ("unity", ("--relaxed", "true")),
]
ways = pytest.mark.parametrize(("kind", "way"), WAYS, ids=[" ".join([kind, *way[:1]]) for kind, way in WAYS])


def received(numbers):
    return [f"{i}: sent add 1, received {i}" for i in numbers]


def retry(i, attempt, way=(), tries=5, patience=0.5):
    """What a client says before this try: each has waited twice as long as the one before, at most 8 times."""
    patience = f"{patience * 2 ** min(attempt - 2, 3):g}"
    return f"{i}: no reply within {patience} s; try {attempt} of {tries}, on {'the same' if way else 'a new'} socket"


def replies(client):
    return [line for line in client.lines if "received" in line]


def fate(server, word):
    """The request, as the client counts them, of which the server says this.

    The server's own count goes by tries, of which there are more on a busy machine.
    """
    return int(server.wait_for(rf"…-(\d+): \d+(?:, from the journal)?, {word}")[1])


@pytest.fixture
def journal(tmp_path):
    return tmp_path / "journal.sqlite3"


@pytest.fixture
def pirate_server(serve, journal):
    """Like serve(), with a journal of this test's own, which the next server of the test opens again."""

    def pirate_server(*options, endpoint="tcp://127.0.0.1:*"):
        return serve(KEY, "--journal", str(journal), *options, endpoint=endpoint)

    return pirate_server


@pytest.fixture
def context():
    with zmq.Context() as context:
        yield context


def ask(context, endpoint, *frames, kind=zmq.REQ):
    """One request of a client that is not the kit's; the reply's frames."""
    with context.socket(kind) as asker:
        asker.linger = 0
        asker.connect(endpoint)
        asker.send_multipart(frames)
        assert asker.poll(20_000), f"no reply to {frames!r:.80}"
        return asker.recv_multipart()


def balance(context, endpoint):
    return int(ask(context, endpoint, os.urandom(8).hex().encode(), b"balance")[1])


@ways
def test_ten_additions(kind, way, pirate_server, start, client_command):
    server, endpoint = pirate_server()
    client = start(*client_command(kind, KEY, endpoint, "--patience", "20", *way))
    assert client.wait() == 0, client.output
    assert client.lines == [f"asking {endpoint}", *received(range(1, 11)), "done: 10 replies"]
    assert server.stop() == 0
    assert re.fullmatch(r"journal \S*journal\.sqlite3, balance 0", server.lines[0])
    assert server.lines[1] == f"listening on {endpoint}"
    matches = [re.fullmatch(r"request (\d+), ([0-9a-f]{8})…-(\d+): (\d+)", line) for line in server.lines[2:]]
    assert [(m[1], m[3], m[4]) for m in matches] == [(str(i),) * 3 for i in range(1, 11)]
    assert len({m[2] for m in matches}) == 1


@ways
def test_a_lost_reply_is_asked_for_again_and_nothing_is_done_twice(kind, way, pirate_server, start, client_command):
    server, endpoint = pirate_server("--drop", "2")
    client = start(*client_command(kind, KEY, endpoint, "--count", "3", *way))
    assert client.wait() == 0, client.output
    i = fate(server, "dropped")
    assert retry(i, 2, way) in client.lines
    assert replies(client) == received([1, 2, 3])
    assert f"-{i}: {i}, from the journal" in server.output


@ways
def test_a_slow_reply_comes_with_a_later_try(kind, way, pirate_server, start, client_command):
    server, endpoint = pirate_server("--slow-on", "2", "--delay", "2.2")
    client = start(*client_command(kind, KEY, endpoint, "--count", "3", *way))
    assert client.wait() == 0, client.output
    i = fate(server, "2.2 s late")
    assert {retry(i, 2, way), retry(i, 3, way)} < set(client.lines)
    assert replies(client) == received([1, 2, 3])
    # Every try reached the server, those of thrown away sockets too.
    assert server.output.count(f"-{i}: {i}, from the journal") >= 2


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_late_reply_to_an_earlier_request_is_dropped(kind, pirate_server, start, client_command):
    _, endpoint = pirate_server("--late", "2")
    client = start(*client_command(kind, KEY, endpoint, "--count", "4", "--patience", "20"))
    assert client.wait() == 0, client.output
    dropped = client.lines.pop(3)
    assert re.fullmatch(
        r"3: dropped a reply to another request \([0-9a-f]{8}…-2 2\); try 2 of 5, on a new socket", dropped
    )
    assert client.lines[1:] == [*received([1, 2, 3, 4]), "done: 4 replies"]


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_relaxed_socket_drops_a_late_reply_itself(kind, pirate_server, start, client_command):
    server, endpoint = pirate_server("--late", "2")
    client = start(*client_command(kind, KEY, endpoint, "--count", "4", "--patience", "20", "--relaxed"))
    assert client.wait() == 0, client.output
    assert client.lines[1:] == [*received([1, 2, 3, 4]), "done: 4 replies"]
    assert "request 2 is answered once more" in server.lines


@ways
def test_a_crash_between_the_work_and_the_reply(kind, way, pirate_server, start, client_command):
    endpoint = f"tcp://127.0.0.1:{steady_port()}"
    server, _ = pirate_server("--crash-on", "3", endpoint=endpoint)
    client = start(*client_command(kind, KEY, endpoint, "--count", "5", *way))
    assert server.wait() == 1
    i = fate(server, "crash")
    again, _ = pirate_server(endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert again.lines[0].endswith(f"balance {i}"), "the crash came after the commit"
    assert again.lines[2].endswith(f"-{i}: {i}, from the journal")
    assert replies(client) == received(range(1, 6))
    assert retry(i, 2, way) in client.lines


@pytest.mark.parametrize("kind", CLIENTS)
def test_without_a_server_it_gives_up(kind, start, client_command):
    endpoint = f"tcp://127.0.0.1:{steady_port()}"
    client = start(*client_command(kind, KEY, endpoint, "--patience", "0.25", "--tries", "3"))
    assert client.wait() == 1, client.output
    assert client.lines[1:] == [
        retry(1, 2, tries=3, patience=0.25),
        retry(1, 3, tries=3, patience=0.25),
        f"gave up: 3 tries to ask {endpoint}, the last: no reply within 1 s; is the server running, or the line slow? "
        "'add 1' may have been done or not",
    ]


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_client_that_starts_before_its_server(kind, pirate_server, start, client_command):
    endpoint = f"tcp://127.0.0.1:{steady_port()}"
    client = start(*client_command(kind, KEY, endpoint, "--count", "2"))
    client.wait_for("try 2 of 5")
    pirate_server(endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert replies(client) == received([1, 2])


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_more_retries_than_a_queue_holds_on_a_relaxed_socket(kind, start, client_command):
    """A thousand requests fill the queue of a connection that nobody answers; the next send would wait for ever."""
    options = ["--patience", "0.0002", "--tries", "1200", "--relaxed"]
    client = start(*client_command(kind, KEY, f"tcp://127.0.0.1:{steady_port()}", *options))
    assert client.wait() == 1, client.output
    assert "gave up: 1200 tries" in client.lines[-1]


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_server_that_speaks_otherwise(kind, serve, start, client_command):
    """Lesson 01's server: its answer is shown, so that the reader sees what is wrong."""
    _, endpoint = serve("01_request_reply")
    client = start(*client_command(kind, KEY, endpoint, "--tries", "2", "--patience", "20"))
    assert client.wait() == 1, client.output
    assert client.lines[1].startswith(
        "1: dropped a reply to another request (error: expected one frame, got 2); try 2 of 2"
    )
    assert client.lines[-1] == (
        f"gave up: 2 tries to ask {endpoint}, the last: dropped a reply to another request "
        "(error: expected one frame, got 2); is it the right server? 'add 1' may have been done or not"
    )


@pytest.mark.parametrize("kind", CLIENTS)
def test_wrong_replies_do_not_use_up_all_tries_at_once(kind, serve, start, client_command):
    """The server that is not the right one may be a late reply, or be replaced in a moment."""
    _, endpoint = serve("01_request_reply")
    client = start(*client_command(kind, KEY, endpoint))
    client.wait_for("try 2 of 5")
    began = time.monotonic()
    assert client.wait() == 1, client.output
    assert sum(" try " in line for line in client.lines) == 4
    assert time.monotonic() - began > 0.5


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_relaxed_client_does_not_wait_for_ever_for_what_it_dropped(kind, start, client_command, context):
    """A late reply to an older try makes its socket readable, and is dropped while it is read."""
    with context.socket(zmq.ROUTER) as router:
        router.linger = 0
        port = router.bind_to_random_port("tcp://127.0.0.1")
        options = ["--relaxed", "--patience", "0.3", "--tries", "4"]
        client = start(*client_command(kind, KEY, f"tcp://127.0.0.1:{port}", *options))
        assert router.poll(20_000)
        first = router.recv_multipart()
        assert router.poll(20_000)
        router.recv_multipart()
        router.send_multipart(first)
        assert client.wait() == 1, client.output
    assert client.lines[-1].startswith("gave up: 4 tries to ask ")


@ways
def test_a_far_server_is_reached_with_the_defaults(kind, way, pirate_server, start, client_command):
    """A round trip of 400 ms. A new connection takes several of them, so that a try of 0.5 s never succeeds."""
    _, endpoint = pirate_server()
    with SlowLine(endpoint, 0.4) as line:
        client = start(*client_command(kind, KEY, line.endpoint, "--count", "2", *way))
        assert client.wait() == 0, client.output
    assert replies(client) == received([1, 2])


@ways
def test_a_client_survives_a_peer_that_breaks_the_protocol(kind, way, start, client_command):
    """There may be no connection left to send the next request on, nor to get one again: only a new socket helps."""
    with ProtocolBreaker(lambda frames: [frames[0], b"1"]) as peer:
        client = start(*client_command(kind, KEY, peer.endpoint, "--count", "5", *way))
        assert client.wait() == 0, client.output
    assert replies(client) == [f"{i}: sent add 1, received 1" for i in range(1, 6)]


@pytest.mark.parametrize("kind", CLIENTS)
def test_the_bytes_of_a_client(kind, start, client_command, context):
    """Against a plain REP: two frames, an id that every retry repeats and no other request has, UTF-8 both ways."""
    with context.socket(zmq.REP) as rep:
        rep.linger = 0
        port = rep.bind_to_random_port("tcp://127.0.0.1")
        options = ["--count", "3", "--text", "füge ✓ hinzu", "--patience", "20"]
        client = start(*client_command(kind, KEY, f"tcp://127.0.0.1:{port}", *options))
        seen = []
        for answer in ([b"W\xc3\xb6rld"], None, [b"one", b"two"], None):
            assert rep.poll(20_000)
            request_id, text = rep.recv_multipart()
            assert text.decode() == "füge ✓ hinzu"
            seen.append(request_id.decode())
            # Whatever is not [id][text] with the request's own id is no reply to it.
            rep.send_multipart([request_id, "grün".encode()] if answer is None else answer)
        assert rep.poll(20_000)
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


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_patience_is_more_than_none(kind, start, client_command):
    client = start(*client_command(kind, KEY, "tcp://127.0.0.1:5552", "--patience", "0"))
    assert client.wait() == 2, client.output
    assert "patience" in client.lines[-1]


GARBAGE = {
    "one frame": [b"add 1"],
    "three frames": [b"1", b"add 1", b""],
    "two empty frames": [b"", b""],
    "no id": [b"", b"add 1"],
    "an endless id": [b"i" * 101, b"add 1"],
    "sixty thousand bytes": [b"1", b"x" * 60_000],
    "an id of sixty thousand bytes": [b"i" * 60_000, b"add 1"],
    "invalid UTF-8": [b"\xff\xfe", b"\xff\xfe"],
    "nothing to add": [b"1", b"add "],
    "less": [b"1", b"add -1"],
    "a part": [b"1", b"add 1.5"],
    "more than all": [b"1", b"add 99999999999999999999"],
    "other digits": [b"1", "add \N{ARABIC-INDIC DIGIT ONE}".encode()],
    "a closing zero": [b"1", b"add 1\0"],
    "two lines": [b"1", b"add 1\n"],
}


@pytest.mark.parametrize("frames", GARBAGE.values(), ids=GARBAGE.keys())
def test_a_bad_request_gets_an_error_and_changes_nothing(frames, pirate_server, context):
    server, endpoint = pirate_server()
    reply = ask(context, endpoint, *frames)
    assert len(reply) == 2
    assert reply[1].startswith(b"error: expected ")
    assert ask(context, endpoint, b"first", b"add 2") == [b"first", b"2"]
    assert balance(context, endpoint) == 2
    assert server.stop() == 0
    assert "Traceback" not in server.output


def test_peers_that_leave_half_way_and_envelopes_that_are_none(pirate_server, context):
    server, endpoint = pirate_server()
    port = int(endpoint.rpartition(":")[2])
    greeting = b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(16 + 32)
    for noise in [b"GET / HTTP/1.1\r\n\r\n", b"\0" * 5000, greeting[:20], greeting + b"\x04\xff" + bytes(40)]:
        with socket.create_connection(("127.0.0.1", port)) as raw:
            raw.sendall(noise)
    # Without REQ's empty frame there is no way back; REP would drop such a message.
    for frames in ([b"1", b"add 1"], [b"add 1"], [b""], [b"", b"", b""]):
        with context.socket(zmq.DEALER) as dealer:
            dealer.linger = 1000
            dealer.connect(endpoint)
            dealer.send_multipart(frames)
    assert ask(context, endpoint, b"", b"x", b"add 1", kind=zmq.DEALER) == [b"", b"x", b"1"]
    # A longer way back, as brokers make it, is returned whole.
    assert ask(context, endpoint, b"hop", b"hip", b"", b"y", b"add 1", kind=zmq.DEALER) == [
        b"hop",
        b"hip",
        b"",
        b"y",
        b"2",
    ]
    assert server.stop() == 0


def test_an_id_is_answered_from_the_journal_whoever_asks_and_whenever(pirate_server, context):
    server, endpoint = pirate_server()
    assert ask(context, endpoint, b"a", b"add 5") == [b"a", b"5"]
    assert ask(context, endpoint, b"b", b"add 5") == [b"b", b"10"]
    assert ask(context, endpoint, b"a", b"add 5") == [b"a", b"5"]
    server.kill()
    _, endpoint = pirate_server()
    assert ask(context, endpoint, b"a", b"add 5") == [b"a", b"5"]
    assert balance(context, endpoint) == 10


def test_the_journal_does_not_grow_for_ever(start, journal, context):
    short = (
        f"import runpy, sys; sys.path.insert(0, {str(SERVER.parent)!r}); import server; server.KEEP = 10; server.main()"
    )
    server = start(PYTHON, "-c", short, "--endpoint", "tcp://127.0.0.1:*", "--journal", journal)
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    for i in range(25):
        assert ask(context, endpoint, b"%d" % i, b"add 1") == [b"%d" % i, b"%d" % (i + 1)]
    # The newest ten are known still, an older one is not.
    assert ask(context, endpoint, b"15", b"add 1") == [b"15", b"16"]
    assert ask(context, endpoint, b"14", b"add 1") == [b"14", b"26"]
    server.stop()
    with sqlite3.connect(journal) as db:
        assert db.execute("SELECT count(*) FROM journal").fetchone() == (10,)
    db.close()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to end a program with")
@pytest.mark.parametrize("signal_", [signal.SIGINT, signal.SIGTERM])
def test_a_busy_server_ends_at_once_and_leaves_its_port(signal_, pirate_server, context):
    server, endpoint = pirate_server("--slow-on", "1", "--delay", "60")
    with context.socket(zmq.REQ) as asker:
        asker.linger = 1000
        asker.connect(endpoint)
        asker.send_multipart([b"1", b"add 1"])
    server.wait_for("60 s late")
    # The contract says half a second; the rest is the interpreter's own end on a busy machine.
    assert server.stop(signal_, limit=5) == 0
    assert "Traceback" not in server.output
    _, same = pirate_server(endpoint=endpoint)
    assert same == endpoint


@pytest.mark.parametrize(
    "options",
    [["--delay", "-1"], ["--delay", "nan"], ["--crash-on", "x"], ["--journal", ""], ["--journal", ":memory:"]],
    ids="=".join,
)
def test_wrong_usage_of_the_server(options, start, journal):
    server = start(PYTHON, SERVER, "--endpoint", "tcp://127.0.0.1:*", "--journal", journal, *options)
    assert server.wait() == 2
    assert options[0] in server.lines[-1]


def test_a_journal_that_is_none_is_named_with_its_cure(start, tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("not a database, but long enough to be taken for the header of one\n" * 20)
    alien = tmp_path / "alien.sqlite3"
    with sqlite3.connect(alien) as db:
        db.execute("CREATE TABLE journal (page TEXT)")
    db.close()
    for path in (text, alien, tmp_path, tmp_path / "nowhere" / "journal.sqlite3"):
        server = start(PYTHON, SERVER, "--endpoint", "tcp://127.0.0.1:*", "--journal", path)
        assert server.wait() == 1
        assert server.lines[-1].startswith(f"cannot use the journal {path}: ")
        assert server.lines[-1].endswith("; try --journal another.sqlite3")
        assert "Traceback" not in server.output
    assert text.read_text().startswith("not a database")


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_locked_journal_is_waited_for(kind, pirate_server, journal, start, client_command):
    server, endpoint = pirate_server()
    other = sqlite3.connect(journal, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    client = start(*client_command(kind, KEY, endpoint, "--count", "3", "--tries", "20"))
    server.wait_for(rf"^request 1, [0-9a-f]{{8}}…-1: no reply, cannot use the journal {journal}: database is locked$")
    other.execute("ROLLBACK")
    other.close()
    assert client.wait() == 0, client.output
    assert replies(client) == received([1, 2, 3])
    assert server.stop() == 0
    assert "Traceback" not in server.output


@pytest.mark.skipif(not hasattr(resource, "prlimit"), reason="only Linux takes a running program's disk away")
def test_a_full_disk_is_waited_for(pirate_server, journal, start, client_command, context):
    server, endpoint = pirate_server()
    assert ask(context, endpoint, b"first", b"add 1") == [b"first", b"1"]
    # No file may grow: to SQLite a disk on which nothing can be written any more.
    _, hard = resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (1, resource.RLIM_INFINITY))
    client = start(*client_command("python", KEY, endpoint, "--count", "3", "--tries", "20"))
    server.wait_for(rf"^request \d+, [0-9a-f]{{8}}…-1: no reply, cannot use the journal {journal}: disk I/O error$")
    resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (hard, hard))
    assert client.wait() == 0, client.output
    assert replies(client) == [f"{i}: sent add 1, received {i + 1}" for i in (1, 2, 3)]
    assert server.stop() == 0
    assert "Traceback" not in server.output


@pytest.mark.skipif(sys.platform == "win32", reason="Windows keeps a file that is open from being deleted")
@pytest.mark.parametrize("end", ["", "-wal"], ids=["the journal", "its newest part"])
def test_a_deleted_journal_is_noticed(end, pirate_server, journal, tmp_path, start, client_command, context):
    server, endpoint = pirate_server()
    assert ask(context, endpoint, b"first", b"add 1") == [b"first", b"1"]
    gone = journal.with_name(journal.name + end)
    gone.rename(tmp_path / "elsewhere")
    client = start(*client_command("python", KEY, endpoint, "--count", "1", "--tries", "20"))
    said = server.wait_for(r"^request 2, [0-9a-f]{8}…-1: no reply, cannot use the journal (.*)$")[1]
    assert said == f"{journal}: it was deleted or replaced; put it back, or start the server again"
    # Another file in its place is not it.
    gone.write_bytes((tmp_path / "elsewhere").read_bytes())
    client.wait_for("try 3 of 20")
    (tmp_path / "elsewhere").rename(gone)
    assert client.wait() == 0, client.output
    assert replies(client) == ["1: sent add 1, received 2"]
    server.kill()
    again, endpoint = pirate_server()
    assert again.lines[0].endswith("balance 2"), "nothing is lost"


def test_what_a_client_sends_is_printed_without_harm(serve, journal, context):
    poor = {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    server, endpoint = serve(KEY, "--journal", str(journal), **poor)
    for request_id in (b"\xff", b"\x1b[2J\r\nfake\x07", "grün ✓".encode(), b"x" * 100):
        assert ask(context, endpoint, request_id, b"add 1")[0] == request_id
    assert ask(context, endpoint, b"z" * 60_000, b"add 1")[1].startswith(b"error: ")
    assert server.stop() == 0
    assert server.lines[2:] == [
        "request 1, \ufffd: 1",
        "request 2, ?[2J??fake?: 2",
        "request 3, grün ✓: 3",
        f"request 4, {'x' * 100}: 4",
        f"request 5, {'z' * 200}…: error: expected two frames, an id of 1 to 100 bytes and 'add 1' or 'balance'",
    ]


def test_a_request_that_is_too_large_is_not_read(pirate_server, context):
    server, endpoint = pirate_server()
    with context.socket(zmq.REQ) as rude:
        rude.linger = 0
        # It is disconnected when the server has met what it announces.
        monitor = rude.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        rude.connect(endpoint)
        rude.send_multipart([b"i" * 10_000_000, b"add 1"])
        assert monitor.poll(20_000), "it is still connected"
        assert ask(context, endpoint, b"1", b"add 1") == [b"1", b"1"]
        rude.disable_monitor()
    assert server.stop() == 0
    assert len(server.lines) == 3


def test_a_flood_of_bad_requests_is_no_flood_of_lines(pirate_server, context):
    server, endpoint = pirate_server()
    rude = 0
    with context.socket(zmq.REQ) as asker:
        asker.linger = 0
        asker.connect(endpoint)
        deadline = time.monotonic() + LIMIT
        while "more in the last second" not in server.output:
            assert time.monotonic() < deadline, server.output[-1000:]
            asker.send(b"rude")
            assert asker.poll(20_000)
            asker.recv_multipart()
            rude += 1
    assert server.stop() == 0
    assert rude > 10
    assert len(server.lines) <= 2 + 2 * LIMIT, "two lines a second at most"


def test_a_mistake_in_ones_own_answer_is_told_to_both_sides(start, journal, context):
    code = (
        f"import sys; sys.path.insert(0, {str(SERVER.parent)!r}); import server\n"
        "right = server.answer\n"
        "def answer(db, request_id, text):\n"
        "    if request_id == b'bad':\n"
        "        raise KeyError('no such\\nkey')\n"
        "    return right(db, request_id, text)\n"
        "server.answer = answer; server.main()"
    )
    server = start(PYTHON, "-c", code, "--endpoint", "tcp://127.0.0.1:0", "--journal", journal)
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    assert ask(context, endpoint, b"bad", b"add 1") == [b"bad", b"error: KeyError: 'no such\\nkey'"]
    server.wait_for("^Traceback")
    assert ask(context, endpoint, b"good", b"add 1") == [b"good", b"1"]


class Storm:
    """A server that is killed again and again, and clients that want their additions done."""

    def __init__(self, start, journal, command, clients, adds, mean):
        self.start, self.journal, self.mean = start, journal, mean
        self.endpoint = f"tcp://127.0.0.1:{steady_port()}"
        self.kills = 0
        # Of each restart, the seconds until every client had its next answer.
        self.delays = []
        self.servers = [self.begin()]
        self.ready()
        self.clients = [start(*command(self.endpoint, "--count", str(adds), "--tries", "20")) for _ in range(clients)]

    def begin(self):
        return self.start(PYTHON, SERVER, "--endpoint", self.endpoint, "--journal", self.journal)

    def ready(self):
        return self.servers[-1].wait_for(r"^listening on ")

    def running(self):
        return [client for client in self.clients if client.process.poll() is None]

    def rage(self):
        """Kill and restart until every client has ended."""
        while self.running():
            self.let_it_serve(random.randrange(2 * self.mean))
            self.kill()
            # Now and then in its first moments, while it opens the journal that the last kill left.
            if random.random() < 0.2:
                self.servers.append(self.begin())
                try:
                    self.servers[-1].process.wait(random.uniform(0, 0.3))
                except subprocess.TimeoutExpired:
                    pass
                self.kill()
            self.servers.append(self.begin())
            self.ready()
            self.measure()

    def kill(self):
        self.servers[-1].kill()
        self.kills += 1

    def let_it_serve(self, requests):
        """Wait until this server's life has so many requests more, or nobody is left to ask."""
        server = self.servers[-1]
        wanted = len(server.lines) + requests
        deadline = time.monotonic() + LIMIT
        while len(server.lines) < wanted and self.running():
            assert time.monotonic() < deadline, f"stuck; {[client.lines[-1] for client in self.clients]}"
            try:
                server.wait_for("", limit=0.05, start=wanted - 1)
            except AssertionError:
                assert server.process.poll() is None, server.output

    def measure(self):
        """Sometimes wait until each client is answered; at other times the next kill may come before."""
        if random.random() < 0.2:
            return
        began = time.monotonic()
        seen = {client: len(client.lines) for client in self.running()}
        for client, lines in seen.items():
            try:
                client.wait_for("received", start=lines)
            except AssertionError:
                assert client.wait() == 0, client.output
        if seen:
            self.delays.append(time.monotonic() - began)

    @property
    def repeats(self):
        return sum(line.endswith("from the journal") for server in self.servers for line in server.lines)

    def figures(self):
        requests = sum(line.startswith("request ") for server in self.servers for line in server.lines)
        retries = sum(" try " in line for client in self.clients for line in client.lines)
        return (
            f"{self.kills} kills, {requests} requests, {retries} retries, {self.repeats} answered from the journal; "
            f"answer after a restart: {sorted(self.delays)[len(self.delays) // 2]:.2f} s in the middle, "
            f"{max(self.delays):.2f} s at most, of {len(self.delays)}"
        )


def weather(storm, adds, context):
    """A storm, and what must hold after it."""
    storm.rage()
    for client in storm.clients:
        assert client.wait() == 0, client.output
        assert client.lines[-1] == f"done: {adds} replies"
        balances = [int(line.rpartition(" ")[2]) for line in replies(client)]
        assert len(balances) == adds
        assert balances == sorted(set(balances)), "each addition is answered with the balance after it"
    assert balance(context, storm.endpoint) == adds * len(storm.clients)
    # A request that the killed server had is sent again when its try is over: the first lasts half a second, and the
    # longest, of a client that was unlucky again and again, four.
    assert sorted(storm.delays)[len(storm.delays) // 2] < 1
    assert max(storm.delays) < 8


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_sum_stays_exact_while_the_server_is_killed(kind, start, journal, client_command, context):
    storm = Storm(start, journal, lambda *words: client_command(kind, KEY, *words), clients=4, adds=100, mean=20)
    weather(storm, 100, context)
    assert storm.kills >= 5, storm.figures()


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_long_storm(kind, start, journal, client_command, context, capsys):
    began = time.monotonic()
    storm = Storm(start, journal, lambda *words: client_command(kind, KEY, *words), clients=4, adds=2000, mean=35)
    weather(storm, 2000, context)
    with capsys.disabled():
        print(f"\n4 {kind} clients, 8000 additions in {time.monotonic() - began:.0f} s: {storm.figures()}")
    assert storm.kills >= 100
    assert storm.repeats, "no kill came between the work and the reply"
