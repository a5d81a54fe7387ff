"""Lesson 04: frames go on whatever the server does, each request ends once, and the main thread pays nothing for it."""

from __future__ import annotations

import contextlib
import os
import random
import re
import signal
import socket
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
import zmq

from kitlib.setup import dotnet
from tests.bad_peers import SlowLine
from tests.conftest import CLIENTS, PYTHON
from tests.programs import LIMIT, ROOT, steady_port

KEY = "04_background_client"
FRAMES = r"frames: (\d+), the longest took (\d+) ms"
clients = pytest.mark.parametrize("kind", CLIENTS)


def received(numbers):
    return [f"{i}: sent hello, received world" for i in numbers]


def silence(endpoint, attempt, tries=3, patience="1"):
    """The second try waits twice as long as the first, all others four times."""
    within = f"{float(patience) * (1, 2, 4)[min(attempt, 3) - 1]:g} s"
    cause = "is the server running, or the line slow?"
    return f"no reply from {endpoint} within {within}; {cause} (try {attempt} of {tries})"


def garbage(endpoint, attempt, tries=3):
    return f"garbage from {endpoint}: not [id][text] in two frames; is it the right server? (try {attempt} of {tries})"


def trouble(client):
    return [line.removeprefix("trouble: ") for line in client.lines if line.startswith("trouble: ")]


def replies(client):
    return [line for line in client.lines if "received" in line]


def frames(client):
    """How many frames there were, by the client's own last lines."""
    return int(client.wait_for(FRAMES)[1])


@pytest.fixture
def context():
    with zmq.Context() as context:
        yield context


@pytest.fixture
def check(request, start, engine):
    """check("refusal", endpoint) runs one of the checks in tests/lessons/background_client."""

    def check(name, endpoint):
        dll = dotnet.build(PYTHON, engine, ROOT / "tests" / "lessons" / "background_client")
        return start("dotnet", dll, name, endpoint)

    return check


def ask(context, endpoint, *parts, kind=zmq.REQ):
    with context.socket(kind) as asker:
        asker.linger = 0
        asker.connect(endpoint)
        asker.send_multipart(parts)
        assert asker.poll(20_000), f"no reply to {parts!r:.80}"
        return asker.recv_multipart()


def silent(peer, rest):
    """Takes the connection and says nothing."""
    rest.wait()


def handshake(peer):
    """ZMTP 3.0 (rfc.zeromq.org/spec/23) up to the first request."""
    stream = peer.makefile("rb")
    peer.sendall(b"\xff" + bytes(7) + b"\x01\x7f" + b"\x03\x00" + b"NULL".ljust(20, b"\0") + bytes(32))
    stream.read(64)
    ready = b"\x05READY" + b"\x0bSocket-Type" + (6).to_bytes(4, "big") + b"ROUTER"
    peer.sendall(bytes([4, len(ready)]) + ready)
    assert stream.read(stream.read(2)[1])[:6] == b"\x05READY"
    return stream


def answer_and_break(peer, rest):
    """One good reply, and with it a frame as no ZeroMQ program sends it: after that the client has no connection."""
    stream = handshake(peer)
    _, name, _ = (stream.read(stream.read(2)[1]) for _ in range(3))
    peer.sendall(b"\x01\x00\x01" + bytes([len(name)]) + name + b"\x00\x05world" + b"\xff" * 9)
    rest.wait()


def zmtp(peer, rest, then):
    """Up to the request, then the id as first frame of the reply, and then `then`."""
    stream = handshake(peer)
    delimiter, name, text = (stream.read(stream.read(2)[1]) for _ in range(3))
    assert (delimiter, text) == (b"", b"hello")
    peer.sendall(b"\x01\x00\x01" + bytes([len(name)]) + name + then)
    print("came as far as half a reply")
    if then:
        rest.wait()


# How the port can be taken by something that is not the server.
STRANGERS = {
    "silent": silent,
    "closing": lambda peer, rest: peer.close(),
    "noise": lambda peer, rest: (peer.sendall(random.Random(4).randbytes(100_000)), rest.wait()),
    "zeros": lambda peer, rest: (peer.sendall(bytes(1000)), rest.wait()),
    "old ZMTP": lambda peer, rest: (peer.sendall(b"\x01\x00\x06\x00hello\x06\x00world"), rest.wait()),
    "half a greeting": lambda peer, rest: (peer.sendall(b"\xff" + bytes(7)), rest.wait()),
    "half a frame": lambda peer, rest: zmtp(peer, rest, b"\x00\xc8half of two hundred bytes"),
    "half a message": lambda peer, rest: zmtp(peer, rest, b""),
    "a frame of 2 GB": lambda peer, rest: zmtp(peer, rest, b"\x02" + (2**31 - 60).to_bytes(8, "big") + b"and so on"),
}


@contextlib.contextmanager
def stranger(behave):
    """A program that listens, and does `behave` with each connection, as long as the with block lasts."""
    rest = threading.Event()
    with socket.create_server(("127.0.0.1", steady_port())) as listener:

        def one(peer):
            with peer, contextlib.suppress(OSError, IndexError):
                behave(peer, rest)

        def accept():
            with contextlib.suppress(OSError):
                while True:
                    threading.Thread(target=one, args=(listener.accept()[0],), daemon=True).start()

        threading.Thread(target=accept, daemon=True).start()
        try:
            yield f"tcp://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            rest.set()
            with contextlib.suppress(OSError):
                listener.shutdown(socket.SHUT_RDWR)


class Page(BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200)
        self.end_headers()

    def log_message(self, *arguments):
        pass


@contextlib.contextmanager
def web_server():
    with ThreadingHTTPServer(("127.0.0.1", steady_port()), Page) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"tcp://127.0.0.1:{server.server_port}"
        server.shutdown()
        thread.join()


# --- the happy path


@clients
def test_ten_requests(kind, serve, start, client_command):
    server, endpoint = serve(KEY)
    client = start(*client_command(kind, KEY, endpoint))
    assert client.wait() == 0, client.output
    assert client.lines[0] == f"asking {endpoint}"
    assert replies(client) == received(range(1, 11))
    assert re.fullmatch(FRAMES, client.lines[-2])
    assert client.lines[-1] == "done: 10 replies"
    assert server.stop() == 0
    assert server.lines == [f"listening on {endpoint}", *(f"{i}: sent b'world'" for i in range(1, 11))]


@clients
def test_the_bytes_of_a_client(kind, start, client_command, context):
    """Against a plain REP: two frames, an id that every retry repeats and no other request has, UTF-8 both ways."""
    with context.socket(zmq.REP) as rep:
        rep.linger = 0
        endpoint = f"tcp://127.0.0.1:{rep.bind_to_random_port('tcp://127.0.0.1')}"
        options = ["--count", "3", "--text", "echo grün ✓", "--patience", "20"]
        client = start(*client_command(kind, KEY, endpoint, *options))
        seen = []
        for answer in ([b"W\xc3\xb6rld"], None, [b"one", b"two"], [b"1", b"2", b"3"], None, None):
            assert rep.poll(20_000)
            name, text = rep.recv_multipart()
            assert text.decode() == "echo grün ✓"
            seen.append(name.decode())
            # Whatever is not [id][text] with the request's own id is no reply to it.
            rep.send_multipart([name, "größer".encode()] if answer is None else answer)
        assert client.wait() == 0, client.output
    assert seen[0] == seen[1] != seen[2] == seen[3] == seen[4] != seen[5]
    assert len(set(seen)) == 3
    assert replies(client) == [f"{i}: sent echo grün ✓, received größer" for i in (1, 2, 3)]
    # What is shown is what a frame saw; a retry between two frames may stay unseen.
    assert set(trouble(client)) <= {garbage(endpoint, 1, tries=20), garbage(endpoint, 2, tries=20)}


# --- trouble on command


@clients
@pytest.mark.parametrize(
    ("options", "first", "again"),
    [
        (["--drop", "3"], "3: sent b''", "4: sent b'world' again"),
        (["--slow-on", "3", "--delay", "1.6"], "3: sent b'world'", "4: sent b'world' again"),
        (["--garbage-on", "3"], r"3: sent b'\x80\x81'", "4: sent b'world' again"),
        (["--half-on", "3"], "3: sent b''", "4: sent b'world' again"),
    ],
    ids=["drop", "slow", "garbage", "half"],
)
def test_trouble_is_over_with_the_next_try(kind, options, first, again, serve, start, client_command):
    server, endpoint = serve(KEY, *options)
    client = start(*client_command(kind, KEY, endpoint, "--count", "5", "--patience", "0.8"))
    assert client.wait() == 0, client.output
    assert replies(client) == received(range(1, 6))
    assert client.lines[-1] == "done: 5 replies"
    assert first in server.lines
    assert again in server.lines, "done twice"
    if options[0] in ("--drop", "--slow-on"):
        assert trouble(client)[0] == silence(endpoint, 1, tries=20, patience="0.8")
        assert frames(client) > 20, "the frames stood still"


@clients
def test_the_server_crashes_and_is_started_again(kind, serve, start, client_command):
    endpoint = f"tcp://127.0.0.1:{steady_port()}"
    server, _ = serve(KEY, "--crash-on", "3", endpoint=endpoint)
    client = start(*client_command(kind, KEY, endpoint, "--count", "5", "--tries", "30", "--patience", "0.5"))
    assert server.wait() == 1
    assert server.lines[-1] == "3: left without a reply"
    client.wait_for("trouble: .*try 1 of 30")
    again, _ = serve(KEY, endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert replies(client) == received(range(1, 6))
    # The new server knows nothing of the requests before.
    assert again.lines[1] == "1: sent b'world'"


@clients
def test_the_server_is_killed_while_requests_are_under_way(kind, serve, start, client_command):
    endpoint = f"tcp://127.0.0.1:{steady_port()}"
    server, _ = serve(KEY, endpoint=endpoint)
    options = ["--count", "200", "--tries", "60", "--patience", "0.5"]
    client = start(*client_command(kind, KEY, endpoint, *options))
    for i in (10, 60, 110):
        client.wait_for(f"^{i}: sent")
        server.kill()
        server, _ = serve(KEY, endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert replies(client) == received(range(1, 201))


@clients
def test_a_client_that_starts_before_its_server(kind, serve, start, client_command):
    endpoint = f"tcp://127.0.0.1:{steady_port()}"
    client = start(*client_command(kind, KEY, endpoint, "--tries", "60", "--patience", "0.5"))
    client.wait_for("trouble: .*try 2 of 60")
    serve(KEY, endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert replies(client) == received(range(1, 11))


def gives_up(kind, endpoint, start, client_command, why=silence):
    """The frames go on, and in the end there is a line that says what is wrong."""
    client = start(*client_command(kind, KEY, endpoint, "--patience", "0.5", "--tries", "3"))
    assert client.wait() == 1, client.output
    assert not replies(client)
    last = why(endpoint, 3, patience="0.5") if why is silence else why(endpoint, 3)
    assert f"gave up: {last}" in client.lines
    assert "Unhandled" not in client.output
    assert "Traceback" not in client.output
    return client


@clients
def test_without_a_server(kind, start, client_command):
    endpoint = f"tcp://127.0.0.1:{steady_port()}"
    client = gives_up(kind, endpoint, start, client_command)
    assert trouble(client) == [silence(endpoint, i, patience="0.5") for i in (1, 2)]
    # 90 at 60 a second; a client that waits where the frames are made has one, or three.
    assert frames(client) > 30


@clients
@pytest.mark.parametrize("behave", STRANGERS.values(), ids=STRANGERS.keys())
def test_a_port_that_another_program_has(kind, behave, start, client_command, request, capsys):
    with stranger(behave) as endpoint:
        client = gives_up(kind, endpoint, start, client_command)
        assert frames(client) > 30
    if re.search("half a frame|half a message|2 GB", request.node.name):
        assert "came as far as half a reply" in capsys.readouterr().out


@clients
def test_a_web_server_on_the_port(kind, start, client_command):
    with web_server() as endpoint:
        client = gives_up(kind, endpoint, start, client_command)
        assert frames(client) > 30


@clients
def test_another_lessons_server(kind, serve, start, client_command):
    """Lesson 01's server answers in one frame."""
    _, endpoint = serve("01_request_reply")
    gives_up(kind, endpoint, start, client_command, why=garbage)


@clients
def test_a_server_that_breaks_the_protocol_after_each_reply(kind, start, client_command):
    """The next send finds no connection: it is a try in vain, and no more than that."""
    with stranger(answer_and_break) as endpoint:
        client = start(*client_command(kind, KEY, endpoint, "--count", "5"))
        assert client.wait() == 0, client.output
    assert replies(client) == received(range(1, 6))


@clients
def test_broken_replies_count_as_none(kind, start, client_command, context):
    """REQ drops a reply without the empty frame in front: there is something to receive, and then there is not."""
    with context.socket(zmq.ROUTER) as router:
        router.linger = 0
        endpoint = f"tcp://127.0.0.1:{router.bind_to_random_port('tcp://127.0.0.1')}"
        client = start(*client_command(kind, KEY, endpoint, "--patience", "0.5", "--tries", "3", "--count", "1"))
        for _ in range(3):
            assert router.poll(20_000)
            router.send_multipart([router.recv_multipart()[0], b"no empty frame"])
        assert client.wait() == 1, client.output
    assert f"gave up: {silence(endpoint, 3, patience='0.5')}" in client.lines


@clients
def test_what_is_printed_is_fit_for_a_terminal(kind, start, client_command, context):
    with context.socket(zmq.REP) as rep:
        rep.linger = 0
        endpoint = f"tcp://127.0.0.1:{rep.bind_to_random_port('tcp://127.0.0.1')}"
        client = start(*client_command(kind, KEY, endpoint, "--count", "1", "--patience", "20"))
        assert rep.poll(20_000)
        name, _ = rep.recv_multipart()
        rep.send_multipart([name, "grün\x1b[2J\r\n".encode() + b"\xff" + b"x" * 5000])
        assert client.wait() == 0, client.output
    assert replies(client) == [f"1: sent hello, received grün?[2J??\ufffd{'x' * 189}…"]


@clients
def test_a_far_server_answers(kind, serve, start, client_command):
    """With a round trip of 400 ms, and the patience that the client has when nobody sets it."""
    _, endpoint = serve(KEY)
    with SlowLine(endpoint, 0.4) as far:
        client = start(*client_command(kind, KEY, far.endpoint, "--count", "3"))
        assert client.wait() == 0, client.output
    assert replies(client) == received(range(1, 4))


# Runs inside the lesson's folder, where `from client import BackgroundClient` finds the class to take home.
IN_PYTHON = """
import sys, time
from client import BackgroundClient
ends = []
def until(number):
    limit = time.monotonic() + 30
    while len(ends) < number and time.monotonic() < limit:
        client.poll()
        time.sleep(0.01)
client = BackgroundClient(sys.argv[1], patience=20)
"""


@pytest.mark.parametrize(
    ("code", "printed"),
    [
        (
            # What is under way when the client is closed.
            "for i in range(64): assert client.request('hello', ends.append, ends.append)\nclient.close()",
            ["64", "the client was disposed"],
        ),
        (
            # A text that is none, and one that is too long: the thread goes on.
            "client.request('\\ud800', ends.append, ends.append)\nuntil(1)\n"
            "client.request('x' * 70000, ends.append, ends.append)\nuntil(2)\nclient.close()",
            ["2", "ValueError('a text has at most 65536 bytes')"],
        ),
        (
            # A callback that raises keeps no other from running.
            "def bad(why):\n    ends.append(why)\n    raise LookupError(why)\n"
            "for i in range(5): client.request('hello', bad, bad)\n"
            "try: client.close()\nexcept LookupError: pass",
            ["5", "the client was disposed"],
        ),
    ],
    ids=["closed with 64 under way", "texts that cannot be sent", "callbacks that raise"],
)
def test_each_request_to_the_python_client_ends_once(code, printed, start):
    with stranger(silent) as endpoint:
        folder = str(ROOT / "python" / KEY)
        program = start(
            PYTHON, "-c", f"{IN_PYTHON}{code}\nprint(len(ends))\nprint(ends[-1])", endpoint, PYTHONPATH=folder
        )
        assert program.wait() == 0, program.output
        assert program.lines == printed


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_more_requests_than_have_room(kind, start, client_command):
    client = start(
        *client_command(
            kind, KEY, f"tcp://127.0.0.1:{steady_port()}", "--count", "1000", "--tries", "1", "--patience", "5"
        )
    )
    assert client.wait() == 1, client.output
    assert "refused: 64 requests are under way already" in trouble(client)


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_the_naive_way_stops_the_frames(kind, serve, start, client_command):
    """What the lesson cures: if this were smooth too, the other tests would show nothing."""
    _, endpoint = serve(KEY, "--drop", "3")
    client = start(*client_command(kind, KEY, endpoint, "--naive"))
    assert client.wait() == 0, client.output
    assert int(client.wait_for(FRAMES)[2]) >= 1000
    assert frames(client) == 10


# --- what a user may do in code


@pytest.mark.parametrize(
    "name",
    [
        "stop-answered",
        "stuck",
        "one-after-another",
        "why",
        "forgotten",
        "many",
        "await",
        "throwing",
        "nested",
        "cleanup",
        "too-long",
        "no-socket",
        "never-polled",
        "allocates-nothing",
    ],
)
def test_in_code(name, serve, check):
    _, endpoint = serve(KEY)
    program = check(name, endpoint)
    assert program.wait() == 0, program.output
    assert program.lines[-1] == "ok"


@pytest.mark.parametrize("name", ["refusal", "stop", "asleep", "pairs", "listener-stops"])
def test_in_code_with_nobody_who_answers(name, check):
    with stranger(silent) as endpoint:
        program = check(name, endpoint)
        assert program.wait() == 0, program.output
        assert program.lines[-1] == "ok"


def test_stop_while_there_is_no_server(check):
    program = check("stop", f"tcp://127.0.0.1:{steady_port()}")
    assert program.wait() == 0, program.output


@pytest.mark.parametrize("endpoint", ["127.0.0.1:5554", "tcp://127.0.0.1:0", "tcp://no-such-host.invalid:5554"])
def test_a_bad_endpoint_is_the_error_of_a_request(endpoint, check):
    program = check("look-up", endpoint)
    assert program.wait() == 0, program.output


def test_the_state_says_what_is_known(serve, check):
    _, endpoint = serve(KEY, "--drop", "2", "--garbage-on", "5")
    program = check("state", endpoint)
    assert program.wait() == 0, program.output
    lost = silence(endpoint, 1)
    assert program.lines[:3] == ["Connecting ", "Connected ", f"Retrying {lost}"]
    assert program.lines[3] == f"Connected {lost}"
    assert f"Connected {garbage(endpoint, 1)}" in program.lines[4:]


def test_every_request_ends_once_while_the_server_is_killed_again_and_again(serve, check):
    endpoint = f"tcp://127.0.0.1:{steady_port()}"
    server, _ = serve(KEY, endpoint=endpoint)
    program = check("random", endpoint)
    kills = 0
    rng = random.Random(4)
    while program.process.poll() is None and kills < 200:
        # Not a wait for something: the pause is the trouble.
        time.sleep(rng.random())
        server.kill()
        kills += 1
        server, _ = serve(KEY, endpoint=endpoint)
    assert program.wait() == 0, program.output
    assert program.lines[-1] == "ok"
    assert kills >= 5


# --- the server


def test_a_repeated_request_is_answered_from_memory(serve, context):
    server, endpoint = serve(KEY)
    for number, again in enumerate(("", " again", " again"), start=1):
        assert ask(context, endpoint, b"id-1", b"hello") == [b"id-1", b"world"]
        server.wait_for(rf"^{number}: sent b'world'{again}$")
    assert [line.endswith("again") for line in server.lines[1:]] == [False, True, True]
    assert ask(context, endpoint, b"id-2", b"hello") == [b"id-2", b"world"]
    server.wait_for("^4: sent b'world'$")


def test_the_memory_is_bounded(serve, context):
    server, endpoint = serve(KEY)
    with context.socket(zmq.DEALER) as dealer:
        dealer.linger = 0
        dealer.connect(endpoint)
        for i in range(3000):
            dealer.send_multipart([b"", b"id-%d" % i, b"hello"])
        for _ in range(3000):
            assert dealer.poll(20_000)
            dealer.recv_multipart()
    ask(context, endpoint, b"id-2999", b"hello")
    server.wait_for("^3001: sent b'world' again$")
    ask(context, endpoint, b"id-0", b"hello")
    server.wait_for("^3002: sent b'world'$")


def memory(program):
    """What a process occupies, in MB."""
    status = Path(f"/proc/{program.process.pid}/status")
    if not status.exists():
        pytest.skip("only Linux says how much memory another process occupies")
    return int(re.search(r"VmRSS:\s+(\d+) kB", status.read_text(encoding="utf-8"))[1]) / 1000


def test_large_messages_are_refused_and_not_kept(serve, context):
    server, endpoint = serve(KEY)
    before = memory(server)
    for i in range(40):
        with context.socket(zmq.DEALER) as dealer:
            # What is refused is sent no more when the connection is made again.
            dealer.linger = 0
            dealer.connect(endpoint)
            dealer.send_multipart([b"", b"id-%d" % i, b"echo " + b"x" * 5_000_000])
            dealer.poll(50)
    assert ask(context, endpoint, b"1", b"hello") == [b"1", b"world"]
    assert memory(server) < before + 150
    # It prints after it has sent. A message that was taken would stand before this line, and have its number.
    server.wait_for("sent b'world'")
    assert [line for line in server.lines if "sent" in line] == ["1: sent b'world'"]


def test_a_flood_of_bad_messages_is_no_flood_of_lines(serve, context):
    server, endpoint = serve(KEY)
    with context.socket(zmq.DEALER) as dealer:
        dealer.linger = 0
        dealer.connect(endpoint)
        sent, deadline = 0, time.monotonic() + LIMIT
        while "more in the last second" not in server.output:
            assert time.monotonic() < deadline
            for _ in range(100):
                dealer.send_multipart([b"", b"only one"])
                sent += 1
            for _ in range(100):
                assert dealer.poll(20_000)
                dealer.recv_multipart()
    assert sent > 200
    assert len(server.lines) < 10
    assert server.stop() == 0


def test_an_exception_in_ones_own_answer_is_a_reply(start, context, tmp_path):
    """And a traceback in the server's terminal; the next request is answered as before."""
    code = (ROOT / "python" / KEY / "server.py").read_text(encoding="utf-8")
    copy = tmp_path / "server.py"
    own = '    if text == b"boom":\n        raise LookupError("no\\nplan")\n    if text == b"hello":'
    copy.write_text(code.replace('    if text == b"hello":', own), encoding="utf-8")
    server = start(PYTHON, copy, "--endpoint", "tcp://127.0.0.1:0")
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    for _ in range(2):
        assert ask(context, endpoint, b"1", b"boom") == [b"1", b"error: LookupError: no plan"]
    assert ask(context, endpoint, b"2", b"hello") == [b"2", b"world"]
    server.wait_for("^Traceback")
    # It was not done, so its retry is no repetition.
    server.wait_for("^2: sent b'error: LookupError: no plan'$")
    assert server.stop() == 0


REQUESTS = {
    "hello": ([b"1", b"hello"], [b"1", b"world"]),
    "echo": ([b"1", "echo grün ✓".encode()], [b"1", "grün ✓".encode()]),
    "an empty echo": ([b"1", b"echo "], [b"1", b""]),
    "sixty kilobytes": ([b"1", b"echo " + b"x" * 60_000], [b"1", b"x" * 60_000]),
    "more than is sent in one frame": (
        [b"1", b"echo " + b"\xff" * 30_000],
        [b"1", b"error: the answer has 90000 bytes, more than 65536"],
    ),
    "another text": ([b"1", b"Hello"], [b"1", b"error: expected hello or echo TEXT, got b'Hello'"]),
    "an empty text": ([b"1", b""], [b"1", b"error: expected hello or echo TEXT, got b''"]),
    "bytes that are no UTF-8": ([b"1", b"echo \xff\xfe"], [b"1", "\ufffd\ufffd".encode()]),
    "an empty id": ([b"", b"hello"], [b"", b"world"]),
    "one frame": ([b"hello"], [b"", b"error: expected two frames, [id][text], got 1"]),
    "one empty frame": ([b""], [b"", b"error: expected two frames, [id][text], got 1"]),
    "three frames": ([b"1", b"2", b"3"], [b"", b"error: expected two frames, [id][text], got 3"]),
}


@pytest.mark.parametrize(("request_frames", "reply"), REQUESTS.values(), ids=REQUESTS.keys())
def test_what_the_server_answers(request_frames, reply, serve, context):
    server, endpoint = serve(KEY)
    assert ask(context, endpoint, *request_frames) == reply
    assert ask(context, endpoint, b"next", b"hello") == [b"next", b"world"]
    assert server.stop() == 0
    assert "Traceback" not in server.output


def test_noise_on_the_port_and_clients_that_leave_half_way(serve, context):
    server, endpoint = serve(KEY)
    port = int(endpoint.rpartition(":")[2])
    for noise in [b"GET / HTTP/1.1\r\n\r\n", bytes(5000), b"\xff" * 64, b"\xff" + bytes(8) + b"\x7f\x03"]:
        with socket.create_connection(("127.0.0.1", port)) as raw:
            raw.sendall(noise)
        assert ask(context, endpoint, noise[:4] or b"?", b"hello")[1] == b"world"
    for _ in range(20):
        with context.socket(zmq.REQ) as leaver:
            leaver.linger = 100
            leaver.connect(endpoint)
            leaver.send_multipart([os.urandom(8), b"hello"])
    with context.socket(zmq.DEALER) as dealer:
        dealer.linger = 0
        dealer.connect(endpoint)
        for frames_of_a_dealer in ([b""], [b"", b""], [b"hello"], [b"id", b"hello"], [b"", b"id", b"hello"]):
            dealer.send_multipart(frames_of_a_dealer)
            assert dealer.poll(20_000), frames_of_a_dealer
            last = dealer.recv_multipart()
        assert last == [b"", b"id", b"world"]
    assert server.stop() == 0
    assert "Traceback" not in server.output


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to end a program with")
def test_a_busy_server_ends_at_once_and_leaves_its_port(how, serve, context):
    server, endpoint = serve(KEY, "--slow-on", "1", "--delay", "60")
    with context.socket(zmq.REQ) as asker:
        asker.linger = 1000
        asker.connect(endpoint)
        asker.send_multipart([b"1", b"hello"])
    assert server.stop(how, limit=5) == 0
    assert "Traceback" not in server.output
    again, same = serve(KEY, endpoint=endpoint)
    assert same == endpoint
    assert again.stop() == 0


def test_numbers_and_text_are_the_same_under_a_german_locale(start, client_command):
    endpoint = f"tcp://127.0.0.1:{steady_port()}"
    command = client_command("csharp", KEY, endpoint, "--patience", "0.5", "--tries", "1")
    client = start(*command, LANG="de_DE.UTF-8", LC_ALL="de_DE.UTF-8")
    assert client.wait(LIMIT) == 1
    assert client.lines[-1] == f"gave up: {silence(endpoint, 1, tries=1, patience='0.5')}"
