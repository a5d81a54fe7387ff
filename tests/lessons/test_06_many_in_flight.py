"""Lesson 06: any order, retries, new sockets, taking turns, and everything that must not stop it."""

import contextlib
import itertools
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest
import zmq

from netmq_example import many_requester
from netmq_example.many_requester import ManyRequester
from netmq_example.worker_threads import WorkerThreads
from tests.bad_peers import greeting, ready
from tests.conftest import CLIENTS
from tests.lessons.conftest import bind
from tests.programs import LIMIT, steady_endpoint

KEY = "06_many_in_flight"
each_side = pytest.mark.parametrize("side", ["python", "csharp"])


def sent(run):
    return [line for line in run.lines if "sent" in line]


def ask(client, *frames):
    client.send_multipart(frames)
    return client.recv_multipart()


# The clients with the lesson's server


@pytest.mark.parametrize("kind", CLIENTS)
def test_replies_come_when_they_are_ready_and_a_slow_request_fails_alone(kind, serve, runs):
    _, endpoint = serve(KEY)
    long = "|".join(["x" * 65_537, "echo " + "ü" * 300, "sleep 60", "echo b"])
    all_at_once, one_by_one, failing = runs(
        kind,
        KEY,
        [
            ["--endpoint", endpoint, "--timeout", "20"],
            ["--endpoint", endpoint, "--window", "1", "--text", "sleep 0.1|echo Grüße", "--count", "4"],
            ["--endpoint", endpoint, "--count", "4", "--timeout", "2", "--tries", "2", "--text", long],
        ],
    )
    assert all_at_once.code == 0, all_at_once.lines
    first, *replies, last = all_at_once.lines
    assert (first, last) == (f"asking {endpoint}, 4 in flight", "done: 6 replies")
    assert sorted(replies) == [
        "1: sent sleep 0.8, received slept 0.8",
        "2: sent echo one, received one",
        "3: sent sleep 0.5, received slept 0.5",
        "4: sent echo two, received two",
        "5: sent sleep 0.2, received slept 0.2",
        "6: sent echo three, received three",
    ]
    assert replies[0].startswith("2:"), "a quick request does not wait for a slow one before it"
    # A window of one is lesson 01 again.
    assert one_by_one.code == 0, one_by_one.lines
    texts = ["sleep 0.1, received slept 0.1", "echo Grüße, received Grüße"] * 2
    assert sent(one_by_one) == [f"{number}: sent {text}" for number, text in enumerate(texts, 1)]
    assert failing.code == 1
    assert sorted(sent(failing)) == [
        f"1: sent {'x' * 200}…, gave up: not sent: 65537 bytes, and the limit is 65536",
        f"2: sent echo {'ü' * 195}…, received {'ü' * 200}…",
        "3: sent sleep 60, gave up: no reply in 2 tries of up to 4 s; "
        "is the server running, slow, or its reply over 64 KB?",
        "4: sent echo b, received b",
    ]
    assert "3: no reply within 2 s; try 2 of 2" in failing.lines and "done: 2 replies" in failing.lines
    assert failing.lines[-1] == f"gave up: 2 of 4 requests to {endpoint} have no reply; see above"


@each_side
def test_a_client_that_is_started_again_is_given_no_answer_from_before(side, serve, run):
    """Lesson 02's server remembers by the id alone."""
    _, endpoint = serve("02_lazy_pirate")
    for balance in 1, 2:
        done = run(side, KEY, "--endpoint", endpoint, "--count", "1", "--text", "add 1")
        assert f"1: sent add 1, received {balance}" in done.lines, done


# The clients with a server by hand. Each scene plays that, and returns the lines that its client must have about the
# requests, or None, and about the tries; on a busy machine there may be more tries.


def asked(router, over):
    """The client's requests from now on."""
    while not over.is_set():
        if router.poll(100):
            yield router.recv_multipart()


def retries(router, endpoint, over):
    """A retry keeps its id, and what comes twice or unasked is dropped."""
    first, again = router.recv_multipart(), router.recv_multipart()
    assert first[1:] == again[1:], "the same id and the same text"
    assert first[0] != again[0], "nothing was received, so it is another socket"
    assert again[2] == b"echo a"
    # Each try, since on a busy machine one is over before its answer comes.
    for peer, request_id, text in itertools.chain([again], asked(router, over)):
        answers = [[request_id, b"b"]]
        if text == b"echo a":
            odd = [b"999", b"x"], [b"\xff", b"x"], [b""], [request_id], [request_id, b"x", b"x"], [b"", b"", b""]
            answers = [*odd, [request_id, b"late \xff"], [request_id, b"twice"]]
        for frames in answers:
            router.send_multipart([peer, *frames])
    return ["1: sent echo a, received (6 bytes)", "2: sent echo b, received b"], ["1: no reply within 1 s; try 2 of 9"]


def same_socket(router, endpoint, over):
    """While others are answered a retry goes over the same one: a new socket would lose what is under way."""
    peers, slow = set(), []
    while len(slow) < 2:
        peer, request_id, text = router.recv_multipart()
        peers.add(peer)
        if text == b"slow":
            slow.append(request_id)
            continue
        # Not at once, so that the quick ones last for longer than timeout does.
        router.poll(50)
        router.send_multipart([peer, request_id, b"ok"])
    assert len(peers) == 1
    assert slow[0] == slow[1]
    for request in itertools.chain([[peer, slow[0], b""]], asked(router, over)):
        router.send_multipart([*request[:2], b"ok"])
    return None, []


def slow_line(router, endpoint, over):
    """Tries of 0.5 and 1 s are in vain: what they are answered with comes when the next one has begun.

    On a busy machine they may not even be sent, and then later ones are.
    """
    peers, waiting = [], []
    for peer, request_id, _ in asked(router, over):
        waiting.append((peer, request_id))
        peers.append(peer)
        for late in waiting if len({*peers}) > 2 else [one for one in waiting if one[0] != peer]:
            router.send_multipart([*late, b"ok"])
        waiting = [] if len({*peers}) > 2 else [one for one in waiting if one[0] == peer]
    return ["1: sent a, received ok"], [f"1: no reply within {n} s; try {i} of 8" for i, n in ((2, 0.5), (3, 1))]


def refuses(router, endpoint, over):
    """A refusal is asked again over the same socket until the last try."""
    tries = []
    for _ in range(2):
        tries.append(router.recv_multipart())
        router.send_multipart([*tries[-1][:2], b"error: busy, try again later"])
    assert tries[0] == tries[1]
    return ["1: sent a, received error: busy, try again later"], ["1: no reply within 3 s; try 2 of 2"]


def bind_when_free(router, endpoint):
    end = time.monotonic() + LIMIT
    while True:
        try:
            return router.bind(endpoint)
        except zmq.ZMQError:
            assert time.monotonic() < end
            time.sleep(0.01)


def wrong_first(router, endpoint, over):
    """After a peer of the wrong kind, such as lesson 03's publisher, libzmq does not try again. The right one is
    started anew in between."""
    with socket.create_server(("127.0.0.1", int(endpoint.rpartition(":")[2]))) as wrong:
        wrong.settimeout(LIMIT)
        raw, _ = wrong.accept()
        with raw:
            raw.settimeout(30)
            raw.sendall(greeting() + ready(b"PUB"))
            # It reads what this is, and hangs up.
            with contextlib.suppress(ConnectionResetError):
                while raw.recv(4096):
                    pass
    for number in (b"1", b"2"):
        with router.context.socket(zmq.ROUTER) as right:
            right.linger = 1000
            bind_when_free(right, endpoint)
            while (request := right.recv_multipart())[1].split(b"-")[0] != number:
                right.send_multipart([*request[:2], b"a"])
            right.send_multipart([*request[:2], b"a"])
    return ["1: sent echo a, received a", "2: sent echo a, received a"], []


SCENES = {
    retries: "--count 2 --window 1 --text echo_a|echo_b --timeout 1 --tries 9",
    same_socket: f"--count 100 --window 2 --timeout 2 --text slow{'|quick' * 99}",
    slow_line: "--count 1 --text a --timeout 0.5 --tries 8",
    refuses: "--count 1 --text a --timeout 3 --tries 2",
    wrong_first: "--count 2 --window 1 --text echo_a --timeout 1 --tries 12",
}


@each_side
def test_against_a_server_by_hand(side, context, runs):
    """All clients in one process, one after the other, and each server on a thread of its own."""
    over = threading.Event()
    with contextlib.ExitStack() as stack, ThreadPoolExecutor(len(SCENES)) as pool:
        stack.callback(over.set)
        played, clients = [], []
        for play, words in SCENES.items():
            router = stack.enter_context(context.socket(zmq.ROUTER))
            endpoint = steady_endpoint()
            if play is not wrong_first:
                router.bind(endpoint)
            clients.append(["--endpoint", endpoint, *(word.replace("_", " ") for word in words.split())])
            played.append(pool.submit(play, router, endpoint, over))
        found = runs(side, KEY, clients)
        over.set()
        for play, future, run in zip(SCENES, played, found, strict=True):
            replies, tries = future.result(LIMIT)
            assert run.code == 0, (play, run.lines)
            assert replies in (None, sent(run)), (play, run.lines)
            said = [line for line in run.lines if "; try " in line]
            assert said[: len(tries)] == tries, (play, said)
            assert said == tries or play is not refuses


# The Python client in code


def test_a_caller_that_takes_its_time_gets_every_reply(context, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(many_requester, "time", SimpleNamespace(monotonic=lambda: now[0]))
    with (
        context.socket(zmq.ROUTER) as router,
        ManyRequester(bind(router), window=2, tries=1, context=context) as requester,
        ThreadPoolExecutor(1) as pool,
    ):
        outcomes = requester.request_many(["a", "b"])
        first = pool.submit(next, outcomes)
        (*one, _), (*other, _) = router.recv_multipart(), router.recv_multipart()
        router.send_multipart([*one, b"A"])
        assert first.result(LIMIT) == (1, "A", None)
        router.send_multipart([*other, b"B"])
        assert requester.socket.poll(LIMIT * 1000)
        # The caller was busy so long.
        now[0] += 60
        assert [*outcomes] == [(2, "B", None)]


def test_worker_threads_that_are_closed_end():
    """One that is at work goes on to its end, and what waits is not begun."""
    begun, may_end, done = threading.Event(), threading.Event(), []

    def answer(text):
        begun.set()
        may_end.wait(LIMIT)
        done.append(text)
        return text

    before = set(threading.enumerate())
    workers = WorkerThreads(2, answer)
    threads = set(threading.enumerate()) - before
    for text in (b"one", b"two", b"three"):
        workers.begin("key", text)
    assert begun.wait(LIMIT)
    workers.close()
    may_end.set()
    for thread in threads:
        thread.join(LIMIT)
    assert len(threads) == 2 and not any(thread.is_alive() for thread in threads)
    assert "three" not in done


# The server


def test_a_retry_of_what_is_not_answered_yet_is_not_done_twice(serve, connect):
    _, endpoint = serve(KEY, "--workers", "1")
    client = connect(endpoint)
    for request_id, text in [(b"1", b"sleep 0.5"), (b"2", b"sleep 0.1"), (b"2", b"sleep 0.1"), (b"1", b"sleep 0.5")]:
        client.send_multipart([request_id, text])
    assert [client.recv_multipart()[0] for _ in range(2)] == [b"1", b"2"]
    # One worker: had it anything left to do, that would be done before this.
    assert ask(client, b"3", b"sleep 0") == [b"3", b"slept 0"]


BAD = {
    "no text": [b"7"],
    "an unknown command": [b"7", b"hello"],
    "a long one": [b"7", b"x" * 41],
    "not a number": [b"7", b"sleep nan"],
    "digits of another script": [b"7", "sleep ٣".encode()],
}


def test_what_the_server_answers_and_whom_it_refuses(serve, connect):
    server, endpoint = serve(KEY)
    client, other = connect(endpoint), connect(endpoint)
    for name, frames in BAD.items():
        *way, text = ask(client, *frames)
        assert way == frames[:-1][:2], name
        assert text.startswith(b"error: expected an id and 'echo TEXT' or 'sleep 0.5', got '"), name
        assert text.endswith(b"'") and len(text) < 120
    assert ask(client, b"8", b"echo b") == [b"8", b"b"]
    # Each is answered as it has asked: with REQ's empty frame, or without an id.
    assert ask(client, b"", b"8", b"sleep 0.01") == [b"", b"8", b"slept 0.01"]
    assert ask(connect(endpoint, zmq.REQ), b"8", b"echo b") == [b"8", b"b"]
    assert ask(connect(endpoint, zmq.REQ), b"sleep 0.01") == [b"slept 0.01"]

    # Bytes that are no UTF-8 become their number, so no answer is longer than its request.
    assert ask(client, b"9", b"echo " + b"\xff" * 30_000)[1].endswith(b", got '(30005 bytes)'")
    assert "Traceback" not in server.output

    # The longest request, and what was sent behind one that is too long, over another connection.
    assert ask(client, b"1", b"echo " + b"x" * 65_000) == [b"1", b"x" * 65_000]
    client.send_multipart([b"2", b"echo " + b"x" * 10_000_000])
    assert ask(client, b"3", b"echo c") == [b"3", b"c"]

    # A place is free again when its request is done.
    for _ in range(2):
        for i in range(64):
            client.send_multipart([b"%d" % i, b"sleep 0"])
        assert sorted(client.recv_multipart() for _ in range(64)) == sorted([b"%d" % i, b"slept 0"] for i in range(64))

    # A client that is gone locks nobody out.
    leaver = connect(endpoint)
    for i in range(100):
        leaver.send_multipart([b"%d" % i, b"sleep 60"])
    # A request at work is known by its id, and not refused when it is asked for again.
    leaver.send_multipart([b"0", b"sleep 60"])
    leaver.send_multipart([b"last", b"echo a"])
    # Nothing but refusals and the quick one: 64 are taken.
    got = [leaver.recv_multipart() for _ in range(37)]
    leaver.close()
    assert got == [[b"%d" % i, b"error: busy, try again later"] for i in range(64, 100)] + [[b"last", b"a"]]
    assert ask(other, b"1", b"echo hi") == [b"1", b"hi"]
    # There is room for others, too, up to 256 of all.
    for full in [connect(endpoint) for _ in range(3)]:
        for i in range(64):
            full.send_multipart([b"%d" % i, b"sleep 60"])
        assert ask(full, b"last", b"echo a") == [b"last", b"a"], "none is refused"
    assert ask(other, b"2", b"sleep 0") == [b"2", b"error: busy, try again later"]
    assert ask(other, b"3", b"echo hi") == [b"3", b"hi"]

    # It ends at once with all its workers at work.
    assert server.stop(limit=30) == 0
    assert "Traceback" not in server.output
