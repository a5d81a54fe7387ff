"""Lesson 04: frames go on whatever the server does, each request ends once, and the main thread pays nothing for it."""

from __future__ import annotations

import contextlib
import random
import re
import socket
import threading
import time
from http.server import BaseHTTPRequestHandler

import pytest
import zmq

from kitlib.setup import dotnet
from netmq_example.background_client import BackgroundClient
from tests.bad_peers import SlowLine, web_server
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import ask
from tests.programs import LIMIT, ROOT, steady_endpoint, steady_port

KEY = "04_background_client"
FRAMES = r"frames: (\d+), the longest took (\d+) ms"
clients = pytest.mark.parametrize("kind", CLIENTS)


def received(numbers):
    return [f"{i}: sent hello, received world" for i in numbers]


def silence(i, attempt, tries=20, timeout=1.0):
    """What is said before this try of a request: each waits twice as long as the one before, at most 8 times."""
    return f"{i}: no reply within {timeout * 2 ** min(attempt - 2, 3):g} s; try {attempt} of {tries}"


def lost(endpoint, timeout, tries=3):
    return (
        f"{tries} tries to ask {endpoint}, the last: no reply within {timeout:g} s; "
        "is the right server running, or the line slow? 'hello' may have been done or not"
    )


def trouble(client):
    return [line.removeprefix("trouble: ") for line in client.lines if line.startswith("trouble: ")]


def replies(client):
    return [line for line in client.lines if "received" in line]


def frames(client):
    """How many frames there were, by the client's own last lines."""
    return int(client.wait_for(FRAMES)[1])


@pytest.fixture
def check(request, start, netmq):
    """check("refusal", endpoint) runs one of the checks in tests/lessons/checks/BackgroundClientChecks.cs."""

    def check(name, endpoint):
        dll = dotnet.build(netmq, ROOT / "tests" / "lessons" / "checks")
        return start("dotnet", dll, "background", name, endpoint)

    return check


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


# --- the happy path


@clients
def test_ten_requests(kind, serve, start, client_command):
    server, endpoint = serve(KEY)
    # Patient, so that none is sent twice: the server's lines are counted below.
    client = start(*client_command(kind, KEY, endpoint, "--timeout", "30"))
    assert client.wait() == 0, client.output
    assert client.lines[0] == f"asking {endpoint}"
    assert replies(client) == received(range(1, 11))
    # In Unity another component counts the frames, after it is done.
    assert re.fullmatch(FRAMES, client.lines[-1 if kind == "unity" else -2])
    assert "done: 10 replies" in client.lines
    # The server prints after it has replied: its last line may come later than the client's end.
    server.wait_for("^10: sent")
    assert server.stop() == 0
    assert server.lines == [f"listening on {endpoint}", *(f"{i}: sent b'world'" for i in range(1, 11))]


@clients
def test_the_bytes_of_a_client(kind, start, client_command, context):
    """Against a plain REP: two frames, an id that every retry repeats and no other request has, UTF-8 both ways."""
    with context.socket(zmq.REP) as rep:
        rep.linger = 0
        endpoint = f"tcp://127.0.0.1:{rep.bind_to_random_port('tcp://127.0.0.1')}"
        options = ["--count", "3", "--text", "echo grün ✓", "--timeout", "20"]
        client = start(*client_command(kind, KEY, endpoint, *options))
        seen = []
        for answer in ([b"W\xc3\xb6rld"], None, [b"one", b"two"], [b"1", b"2", b"3"], None, None):
            assert rep.poll(100_000)
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
    assert trouble(client)
    assert all(
        re.match(r"[12]: dropped a reply to another request.*; try [23] of 20$", line) for line in trouble(client)
    )


# --- trouble on command


@clients
def test_a_slow_answer_stops_no_frame(kind, serve, start, client_command):
    _, endpoint = serve(KEY, "--slow-on", "3")
    client = start(*client_command(kind, KEY, endpoint, "--count", "5", "--timeout", "0.8"))
    assert client.wait() == 0, client.output
    assert replies(client) == received(range(1, 6))
    assert "done: 5 replies" in client.lines
    # The third message is that of a request before the third one, if that was sent twice on a busy machine.
    assert {silence(i, 2, timeout=0.8) for i in (1, 2, 3)} & set(trouble(client))
    # More than one for each reply.
    assert frames(client) > 5, "the frames stood still"


@clients
def test_the_server_is_killed_while_requests_are_under_way(kind, serve, start, client_command):
    endpoint = steady_endpoint()
    server, _ = serve(KEY, endpoint=endpoint)
    options = ["--count", "200", "--tries", "60", "--timeout", "0.5"]
    client = start(*client_command(kind, KEY, endpoint, *options))
    for i in (10, 60, 110):
        client.wait_for(f"^{i}: sent")
        server.kill()
        server, _ = serve(KEY, endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert replies(client) == received(range(1, 201))


def gives_up(kind, endpoint, start, client_command):
    """The frames go on, and in the end there is a line that says what is wrong."""
    client = start(*client_command(kind, KEY, endpoint, "--timeout", "0.5", "--tries", "3"))
    assert client.wait() == 1, client.output
    assert not replies(client)
    assert f"gave up: {lost(endpoint, 2)}" in client.lines
    assert "Unhandled" not in client.output
    assert "Traceback" not in client.output
    # Some 200, on a busy machine far fewer; a client that waits where the frames are made has one, or three.
    assert frames(client) > 5
    return client


@clients
def test_without_a_server(kind, start, client_command):
    endpoint = steady_endpoint()
    client = gives_up(kind, endpoint, start, client_command)
    said = [silence(1, attempt, tries=3, timeout=0.5) for attempt in (2, 3)]
    # What is shown is what a frame saw: on a busy machine there may be none for a second.
    assert trouble(client) in (said, said[:1], said[1:])


# Unity's is the same C# client; the web server below shows it the like.
@pytest.mark.parametrize("kind", ["python", "csharp"])
@pytest.mark.parametrize("behave", STRANGERS.values(), ids=STRANGERS.keys())
def test_a_port_that_another_program_has(kind, behave, start, client_command, request, capsys):
    with stranger(behave) as endpoint:
        gives_up(kind, endpoint, start, client_command)
    if re.search("half a frame|half a message|2 GB", request.node.name):
        assert "came as far as half a reply" in capsys.readouterr().out


@clients
def test_a_web_server_on_the_port(kind, start, client_command):
    with web_server(Page, steady_port()) as port:
        gives_up(kind, f"tcp://127.0.0.1:{port}", start, client_command)


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
        client = start(*client_command(kind, KEY, endpoint, "--timeout", "0.5", "--tries", "3", "--count", "1"))
        answered = 0
        # Three times, but for a try that is over before its connection is made.
        while client.process.poll() is None:
            if router.poll(50):
                router.send_multipart([router.recv_multipart()[0], b"no empty frame"])
                answered += 1
        assert client.wait() == 1, client.output
    assert answered
    assert f"gave up: {lost(endpoint, 2)}" in client.lines


@clients
def test_a_far_server_answers(kind, serve, start, client_command):
    """With a round trip of 400 ms, and the timeout that the client has when nobody sets it."""
    _, endpoint = serve(KEY)
    with SlowLine(endpoint, 0.4) as far:
        client = start(*client_command(kind, KEY, far.endpoint, "--count", "3"))
        assert client.wait() == 0, client.output
    assert replies(client) == received(range(1, 4))


IN_PYTHON = """
import sys
from netmq_example.background_client import BackgroundClient
ends = []
client = BackgroundClient(sys.argv[1], timeout=20)
"""


@pytest.mark.parametrize(
    ("code", "printed"),
    [
        (
            # What is under way when the client is closed; one more was refused.
            "for i in range(64): assert client.request('hello', ends.append, ends.append)\n"
            "assert not client.request('hello', ends.append, ends.append)\nclient.close()\n"
            "assert not client.request('hello', ends.append, ends.append)",
            ["64", "the client was disposed"],
        ),
        (
            # A text that is too long is not sent.
            "client.request('x' * 70000, ends.append, ends.append)\nclient.close()",
            ["1", "a text of more than 65536 bytes"],
        ),
        (
            # A callback that closes the client, while others wait to be run.
            "def bad(why):\n    ends.append(why)\n    client.close()\n"
            "for i in range(3): client.request('x' * 70000, bad, bad)\n"
            "while client.done.qsize() < 3: pass\nclient.poll()",
            ["3", "a text of more than 65536 bytes"],
        ),
        (
            # A callback that raises keeps no other from running.
            "def bad(why):\n    ends.append(why)\n    raise LookupError(why)\n"
            "for i in range(5): client.request('hello', bad, bad)\n"
            "try: client.close()\nexcept LookupError: pass",
            ["5", "the client was disposed"],
        ),
    ],
    ids=["closed with 64 under way", "a text that is too long", "closed by a callback", "callbacks that raise"],
)
def test_each_request_to_the_python_client_ends_once(code, printed, start):
    with stranger(silent) as endpoint:
        folder = str(ROOT / "python")
        program = start(
            PYTHON, "-c", f"{IN_PYTHON}{code}\nprint(len(ends))\nprint(ends[-1])", endpoint, PYTHONPATH=folder
        )
        assert program.wait() == 0, program.output
        assert program.lines == printed


WRONG = {
    "endpoint": [None, 0, "", "127.0.0.1:5554", "tcp://127.0.0.1:0"],
    "timeout": [None, 0, -1, float("nan"), float("inf"), "1"],
    "tries": [None, 0, -1, float("nan"), 1.5, ""],
    "capacity": [None, 0, -1, float("nan"), 1.5, ""],
}


@pytest.mark.parametrize(("name", "values"), WRONG.items(), ids=WRONG)
def test_what_the_python_client_cannot_use_is_named(name, values):
    for value in values:
        with pytest.raises((ValueError, TypeError), match=rf"^(bad )?{name} .+$"):
            BackgroundClient(**{"endpoint": "tcp://127.0.0.1:5554", name: value})


def test_a_wrong_request_to_the_python_client_takes_no_place():
    """It is named where it is made, and not a frame later."""
    with contextlib.closing(BackgroundClient("tcp://127.0.0.1:5554", capacity=1)) as client:
        for number, name in enumerate(("text", "reply", "error")):
            for value in (None, 0, b"hello"):
                words = ["hello", print, print]
                words[number] = value
                with pytest.raises(TypeError, match=f"^{name} takes a "):
                    client.request(*words)
        assert client.under_way == 0


def test_an_endpoint_that_libzmq_cannot_use_is_the_error_of_a_request():
    errors = []
    with contextlib.closing(BackgroundClient("nonsense://x")) as client:
        for number in (1, 2):
            client.request("hello", errors.append, errors.append)
            while len(errors) < number:
                client.poll()
    assert [zmq.strerror(zmq.EPROTONOSUPPORT) in error for error in errors] == [True, True]


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_the_naive_way_stops_the_frames(kind, serve, start, client_command):
    """What the lesson cures: if this were smooth too, the other tests would show nothing."""
    _, endpoint = serve(KEY, "--slow-on", "3")
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
    program = check("stop", steady_endpoint())
    assert program.wait() == 0, program.output


def test_an_unknown_host_is_the_error_of_a_request(check):
    """What is wrong with its form the constructor says: test_csharp_rules.py."""
    program = check("look-up", "tcp://no-such-host.invalid:5554")
    assert program.wait() == 0, program.output


def test_the_state_says_what_is_known(context, check):
    """The first try of the second request is not answered, and the other one when its state was seen."""
    with context.socket(zmq.ROUTER) as router:
        router.linger = 0
        program = check("state", f"tcp://127.0.0.1:{router.bind_to_random_port('tcp://127.0.0.1')}")
        for number, attempt in ((1, 1), (2, 1), (2, 2), (3, 1), (4, 1)):
            assert router.poll(1000 * LIMIT)
            peer, empty, name, _ = router.recv_multipart()
            assert name.startswith(b"%d-" % number)
            if attempt == 2:
                program.wait_for("^Retrying")
            if (number, attempt) != (2, 1):
                router.send_multipart([peer, empty, name, b"world"])
        assert program.wait() == 0, program.output
    trouble = silence(2, 2, tries=3, timeout=4)
    assert program.lines[:4] == ["Connecting ", "Connected ", f"Retrying {trouble}", f"Connected {trouble}"]


def test_every_request_ends_once_while_the_server_is_killed_again_and_again(serve, check):
    endpoint = steady_endpoint()
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


def test_a_retry_is_answered_from_memory(start, context):
    """Also where the answer is an exception: nothing is done twice, and the next request is answered as before."""
    code = (
        "import itertools, server\n"
        "numbers = itertools.count(1)\n"
        "def answer(text): return [str(next(numbers))][text == 'boom']\n"
        "server.answer = answer; server.main()"
    )
    folder = str(ROOT / "python" / KEY)
    server = start(PYTHON, "-c", code, "--endpoint", "tcp://127.0.0.1:0", PYTHONPATH=folder)
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    for i in [1, *range(1, 1101), 1100]:
        assert ask(context, endpoint, b"%d" % i, b"") == [b"%d" % i, b"%d" % i]
    # It is bounded: what is older than a thousand requests is forgotten.
    assert ask(context, endpoint, b"1", b"") == [b"1", b"1101"]
    for _ in range(2):
        assert ask(context, endpoint, b"x", b"boom") == [b"x", b"error: IndexError('list index out of range')"]
    assert ask(context, endpoint, b"y", b"") == [b"y", b"1103"]
    server.wait_for("sent b'1103'$")
    assert server.output.count("Traceback") == 1


REQUESTS = {
    "hello": ([b"1", b"hello"], [b"1", b"world"]),
    "echo": ([b"1", "echo grün ✓".encode()], [b"1", "grün ✓".encode()]),
    "an empty echo": ([b"1", b"echo "], [b"1", b""]),
    "sixty kilobytes": ([b"1", b"echo " + b"x" * 60_000], [b"1", b"x" * 60_000]),
    "another text": ([b"1", b"Hello"], [b"1", b"error: expected hello or echo TEXT, got 'Hello'"]),
    "bytes that are no UTF-8": ([b"1", b"echo \xff\xfe"], [b"1", "\ufffd\ufffd".encode()]),
    "an empty id": ([b"", b"hello"], [b"", b"world"]),
    "one frame": ([b"hello"], [b"", b"error: expected hello or echo TEXT, got ''"]),
    "three frames": ([b"1", b"2", b"3"], [b"", b"error: expected hello or echo TEXT, got ''"]),
}


def test_what_the_server_answers(serve, context):
    server, endpoint = serve(KEY)
    for request, reply in REQUESTS.values():
        assert ask(context, endpoint, *request) == reply
    assert server.stop() == 0
    assert "Traceback" not in server.output


def test_numbers_and_text_are_the_same_under_a_german_locale(start, client_command):
    endpoint = steady_endpoint()
    command = client_command("csharp", KEY, endpoint, "--timeout", "0.5", "--tries", "1")
    client = start(*command, LANG="de_DE.UTF-8", LC_ALL="de_DE.UTF-8")
    assert client.wait(LIMIT) == 1
    assert client.lines[-1] == f"gave up: {lost(endpoint, 0.5, tries=1)}"
