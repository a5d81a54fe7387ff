"""Lesson 06: any order, retries, new sockets, taking turns, and everything that must not stop it."""

# ruff: noqa: F401, F811
from __future__ import annotations

import contextlib
import signal
import socket
import sys
import threading
import time

import pytest
import zmq

from netmq_example.many_requester import ManyRequester
from netmq_example.worker_threads import WorkerThreads
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.many_in_flight.peers import KEY, a_client_that_never_reads, ask, connect, memory, receive
from tests.programs import LIMIT, ROOT, steady_endpoint

each_client = pytest.mark.parametrize("kind", CLIENTS)


def sent(client):
    return [line for line in client.lines if "sent" in line]


@each_client
def test_replies_come_when_they_are_ready(kind, serve, start, client_command):
    server, endpoint = serve(KEY)
    client = start(*client_command(kind, KEY, endpoint, "--timeout", "20"))
    assert client.wait() == 0, client.output
    assert client.lines[0] == f"asking {endpoint}, 4 in flight"
    assert client.lines[-1] == "done: 6 replies"
    replies = client.lines[1:-1]
    assert sorted(replies) == [
        "1: sent sleep 0.8, received slept 0.8",
        "2: sent echo one, received one",
        "3: sent sleep 0.5, received slept 0.5",
        "4: sent echo two, received two",
        "5: sent sleep 0.2, received slept 0.2",
        "6: sent echo three, received three",
    ]
    assert replies[0].startswith("2:"), "a quick request does not wait for a slow one before it"
    assert server.stop() == 0


@each_client
def test_a_window_of_one_is_lesson_01_again(kind, serve, start, client_command):
    _, endpoint = serve(KEY)
    client = start(*client_command(kind, KEY, endpoint, "--window", "1", "--text", "sleep 0.1|echo Grüße"))
    assert client.wait() == 0, client.output
    assert [line[:2] for line in sent(client)] == ["1:", "2:", "3:", "4:", "5:", "6:"]
    assert sent(client)[1] == "2: sent echo Grüße, received Grüße"


@pytest.fixture
def rig(context, start, client_command):
    """rig(kind, *options): a client, and the server that this test is itself."""
    with context.socket(zmq.ROUTER) as router:
        router.linger = 0
        endpoint = f"tcp://127.0.0.1:{router.bind_to_random_port('tcp://127.0.0.1')}"
        yield lambda kind, *options: (router, start(*client_command(kind, KEY, endpoint, *options)))


@each_client
def test_a_retry_keeps_its_id_and_what_comes_twice_or_unasked_is_dropped(kind, rig):
    router, client = rig(
        kind, "--count", "2", "--window", "1", "--text", "echo a|echo b", "--timeout", "1", "--tries", "9"
    )
    first, again = receive(router), receive(router)
    assert first[1:] == again[1:], "the same id and the same text"
    assert first[0] != again[0], "nothing was received, so it is another socket"
    assert again[2] == b"echo a"
    # Each try, since on a busy machine one is over before its answer comes.
    asked = [again]
    while client.process.poll() is None:
        for peer, request_id, text in asked:
            answers = [[request_id, b"b"]]
            if text == b"echo a":
                odd = [b"999", b"x"], [b"\xff", b"x"], [b""], [request_id], [request_id, b"x", b"x"], [b"", b"", b""]
                answers = [*odd, [request_id, b"late \xff"], [request_id, b"twice"]]
            for frames in answers:
                router.send_multipart([peer, *frames])
        asked = [router.recv_multipart()] if router.poll(50) else []
    assert client.wait() == 0, client.output
    assert sent(client) == [
        "1: sent echo a, received late \N{REPLACEMENT CHARACTER}",
        "2: sent echo b, received b",
    ]
    assert "1: no reply within 1 s; try 2 of 9" in client.lines


@each_client
def test_while_others_are_answered_a_retry_goes_over_the_same_socket(kind, rig):
    """A new socket would lose what is under way on the old one."""
    options = ("--window", "2", "--timeout", "5", "--text", "slow" + "|quick" * 999, "--count", "1000")
    router, _ = rig(kind, *options)
    peers, slow = set(), []
    while len(slow) < 2:
        peer, request_id, text = receive(router)
        peers.add(peer)
        if text == b"slow":
            slow.append(request_id)
            continue
        # Not at once, so that the quick ones last for longer than timeout does.
        router.poll(20)
        router.send_multipart([peer, request_id, b"ok"])
    assert len(peers) == 1
    assert slow[0] == slow[1]


@each_client
def test_a_line_slower_than_the_timeout_succeeds_in_a_longer_try(kind, rig):
    """Tries of 0.5 and 1 s are in vain: what they are answered with comes when the next one has begun.

    On a busy machine they may not even be sent, and then later ones are.
    """
    router, client = rig(kind, "--count", "1", "--text", "a", "--timeout", "0.5", "--tries", "8")
    peers, waiting = [], []
    while client.process.poll() is None:
        if router.poll(10):
            waiting.append(router.recv_multipart()[:2])
            if waiting[-1][0] not in peers:
                peers.append(waiting[-1][0])
        for peer, request_id in list(waiting):
            if peer != peers[-1] or len(peers) > 2:
                waiting.remove([peer, request_id])
                router.send_multipart([peer, request_id, b"ok"])
    assert client.wait() == 0, client.output
    assert "1: no reply within 0.5 s; try 2 of 8" in client.lines
    assert "1: no reply within 1 s; try 3 of 8" in client.lines


@each_client
def test_a_new_socket_costs_a_younger_request_no_try(kind, rig):
    options = ("--count", "3", "--window", "2", "--text", "silent|b|c", "--timeout", "10", "--tries", "2")
    router, client = rig(kind, *options)
    peers = [receive(router)[0] for _ in range(2)]
    router.poll(4000)
    router.send_multipart([peers[0], b"2", b"ok"])
    # The third is sent now, 4 s after the first, which is sent again over the same socket.
    assert receive(router)[1:] == [b"3", b"c"]
    assert receive(router)[1:] == [b"1", b"silent"]
    # 10 s after the third was sent: another socket, another try of it, and the first one, which has 16 s left.
    again = [receive(router) for _ in range(2)]
    assert {peer for peer, *_ in again} != {peers[0]}
    assert sorted(request_id for _, request_id, _ in again) == [b"1", b"3"]
    for peer, request_id, _ in again:
        router.send_multipart([peer, request_id, b"ok"])
    assert client.wait() == 0, client.output
    assert [line for line in client.lines if "try" in line] == [
        "1: no reply within 10 s; try 2 of 2",
        "3: no reply within 10 s; try 2 of 2",
    ]


@each_client
def test_a_refusal_is_asked_again_over_the_same_socket_until_the_last_try(kind, rig):
    router, client = rig(kind, "--count", "1", "--text", "a", "--timeout", "4", "--tries", "3")
    tries = []
    for _ in range(3):
        tries.append(receive(router))
        router.send_multipart([*tries[-1][:2], b"error: busy, try again later"])
    assert tries[0] == tries[1] == tries[2]
    assert client.wait() == 0, client.output
    assert sent(client) == ["1: sent a, received error: busy, try again later"]


@each_client
def test_a_text_that_is_too_long_is_refused_and_only_it(kind, serve, start, client_command):
    _, endpoint = serve(KEY)
    text = "|".join(["x" * 65_537, "echo " + "ü" * 30_000, "sleep 0.3"])
    options = ("--count", "3", "--text", text, "--tries", "1", "--timeout", "60")
    client = start(*client_command(kind, KEY, endpoint, *options))
    assert client.wait() == 1, client.output
    assert sorted(sent(client)) == [
        f"1: sent {'x' * 200}…, gave up: not sent: 65537 bytes, and the limit is 65536",
        f"2: sent echo {'ü' * 195}…, received {'ü' * 200}…",
        "3: sent sleep 0.3, received slept 0.3",
    ]


@each_client
def test_a_slow_request_fails_alone(kind, serve, start, client_command):
    _, endpoint = serve(KEY)
    options = ("--count", "3", "--timeout", "3", "--tries", "2", "--text", "echo a|sleep 60|echo b")
    client = start(*client_command(kind, KEY, endpoint, *options))
    assert client.wait() == 1, client.output
    assert sorted(sent(client)) == [
        "1: sent echo a, received a",
        "2: sent sleep 60, gave up: no reply in 2 tries of up to 6 s; is the server running, or slow?",
        "3: sent echo b, received b",
    ]
    assert client.lines[-1] == f"gave up: 1 of 3 requests to {endpoint} have no reply; see above"


@each_client
def test_a_server_that_comes_late_or_again_gets_what_is_open(kind, serve, start, client_command):
    endpoint = steady_endpoint()
    options = ("--count", "40", "--timeout", "1", "--tries", "60", "--text", "sleep 0.2")
    client = start(*client_command(kind, KEY, endpoint, *options))
    client.wait_for("try 2 of 60")
    server, _ = serve(KEY, endpoint=endpoint)
    client.wait_for("sent sleep")
    server.kill()
    serve(KEY, endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert sorted(int(line.partition(":")[0]) for line in sent(client)) == list(range(1, 41))


@each_client
def test_a_client_that_met_the_wrong_server_finds_the_right_one_later(kind, serve, start, client_command):
    """After a peer of the wrong kind, such as lesson 03's publisher, libzmq does not try again."""
    endpoint = steady_endpoint()
    with socket.create_server(("127.0.0.1", int(endpoint.rpartition(":")[2]))) as wrong:
        wrong.settimeout(30)
        options = ("--count", "2", "--text", "echo a", "--timeout", "1", "--tries", "30")
        client = start(*client_command(kind, KEY, endpoint, *options))
        raw, _ = wrong.accept()
        with raw:
            raw.settimeout(30)
            raw.sendall(b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(48))
            raw.sendall(b"\x04\x19\x05READY\x0bSocket-Type\x00\x00\x00\x03PUB")
            # It reads what this is, and hangs up.
            with contextlib.suppress(ConnectionResetError):
                while raw.recv(4096):
                    pass
    serve(KEY, endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert sorted(sent(client)) == ["1: sent echo a, received a", "2: sent echo a, received a"]


@each_client
def test_a_reply_of_very_many_frames_is_dropped(kind, rig):
    # A second's work, for which a busy machine takes 20; if its time were quadratic, it would be minutes.
    router, client = rig(kind, "--count", "1", "--text", "echo a", "--timeout", "100", "--tries", "1")
    request = receive(router)[:2]
    router.send_multipart([*request, *[b""] * 200_000])
    router.send_multipart([*request, b"a"])
    assert client.wait(120) == 0, client.output
    assert sent(client) == ["1: sent echo a, received a"]


@each_client
def test_a_reply_that_is_too_large_ends_its_connection_only(kind, rig):
    router, client = rig(kind, "--count", "1", "--text", "echo a", "--timeout", "1", "--tries", "20")
    first = receive(router)
    router.send_multipart([*first[:2], b"x" * 65_537])
    again = receive(router)
    assert again[0] != first[0]
    while client.process.poll() is None:
        router.send_multipart([*again[:2], b"a"])
        # On a busy machine that try may be over before, and then there is another.
        again = router.recv_multipart() if router.poll(200) else again
    assert client.wait() == 0, client.output
    assert sent(client) == ["1: sent echo a, received a"]


WRONG: dict[str, list[object]] = {
    "context": [None, 0],
    "endpoint": [None, 0, "", "127.0.0.1:5556", "tcp://127.0.0.1:0"],
    "window": [None, 0, -1, float("nan"), 1.5, ""],
    "timeout": [None, 0, -1, float("nan"), float("inf"), "1"],
    "tries": [None, 0, -1, float("nan"), 1.5, ""],
    "report": [None, 0],
}


@pytest.mark.parametrize(("name", "values"), WRONG.items(), ids=WRONG)
def test_what_a_requester_cannot_use_is_named(name, values, context):
    for value in values:
        with pytest.raises((ValueError, TypeError), match=rf"^(bad )?{name} .+$"):
            ManyRequester(**{"context": context, "endpoint": "tcp://127.0.0.1:5556", name: value})


def test_requests_that_are_no_texts_are_named(context):
    with contextlib.closing(ManyRequester(context, steady_endpoint())) as requester:
        # A text alone would be a request for each of its letters.
        for texts in (None, 5, "echo one", [None], [b"echo one"]):
            with pytest.raises(TypeError, match=r"^texts takes a "):
                next(requester.request_many(texts))
        # Nothing is sent of these, and nothing waited for.
        outcomes = list(requester.request_many(["x" * 65_537] * 100))
    assert [number for number, _, _ in outcomes] == list(range(1, 101))
    assert {failure for _, _, failure in outcomes} == {"not sent: 65537 bytes, and the limit is 65536"}


def test_an_endpoint_that_libzmq_cannot_use_hangs_nothing():
    with zmq.Context() as context, pytest.raises(zmq.ZMQError):
        ManyRequester(context, "nonsense://x")


def test_worker_threads_name_what_they_cannot_use():
    for number in (None, 0, -1, float("nan"), 1.5, "", 100_000):
        with pytest.raises(ValueError, match=r"^number takes a whole number from 1 to 256, not "):
            WorkerThreads(number, str)
    for answer in (None, 0):
        with pytest.raises(TypeError, match=r"^answer takes a function, not "):
            WorkerThreads(1, answer)
    for request in (None, "text"):
        with pytest.raises(TypeError, match=r"^request takes a bytes, not "):
            WorkerThreads(1, str).begin("key", request)


def test_what_is_closed_says_so(context):
    requester = ManyRequester(context, steady_endpoint())
    requester.close()
    with pytest.raises(ValueError, match=r"^this requester is closed: make a new one$"):
        next(requester.request_many(["echo one"]))
    ended = zmq.Context()
    ended.term()
    with pytest.raises(ValueError, match=r"^context is closed: make a new one$"):
        ManyRequester(ended, steady_endpoint())


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
    workers.close()
    may_end.set()
    for thread in threads:
        thread.join(LIMIT)
    assert len(threads) == 2 and not any(thread.is_alive() for thread in threads)
    assert "three" not in done
    for use in (lambda: workers.begin("key", b"four"), lambda: next(workers.finished())):
        with pytest.raises(ValueError, match=r"^this pool of workers is closed: make a new one$"):
            use()


# The server


def test_a_retry_of_what_is_not_answered_yet_is_not_done_twice(serve, connect):
    _, endpoint = serve(KEY, "--workers", "1")
    client = connect(endpoint)
    for request_id, text in [(b"1", b"sleep 0.5"), (b"2", b"sleep 0.1"), (b"2", b"sleep 0.1"), (b"1", b"sleep 0.5")]:
        client.send_multipart([request_id, text])
    assert [receive(client)[0] for _ in range(2)] == [b"1", b"2"]
    # One worker: had it anything left to do, that would be done before this.
    assert ask(client, b"3", b"sleep 0") == [b"3", b"slept 0"]


def test_a_mistake_in_a_readers_own_answer_costs_no_worker(start, connect, tmp_path):
    own = "import server\ndef answer(text):\n    return text[7]\nserver.answer = answer\nserver.main()\n"
    (tmp_path / "own.py").write_text(own, encoding="utf-8")
    command = [PYTHON, tmp_path / "own.py", "--endpoint", "tcp://127.0.0.1:*", "--workers", "1"]
    server = start(*command, PYTHONPATH=str(ROOT / "python" / KEY))
    client = connect(server.wait_for(r"^listening on (\S+)")[1])
    for _ in range(3):
        request_id, text = ask(client, b"1", b"short")
        assert (request_id, text[:17]) == (b"1", b"error: IndexError")
    server.wait_for(r"own\.py\", line 3, in answer")
    assert ask(client, b"2", b"longer text") == [b"2", b"t"]
    # What is quick asks the same function.
    assert ask(client, b"3", b"echo text") == [b"3", b"x"]


def test_a_client_that_is_gone_locks_nobody_out(serve, connect, context):
    _, endpoint = serve(KEY)
    with context.socket(zmq.DEALER) as leaver:
        leaver.linger = 0
        leaver.connect(endpoint)
        for i in range(300):
            leaver.send_multipart([b"%d" % i, b"sleep 60"])
        # What is at work is known by its id, and not refused when it is asked for again.
        leaver.send_multipart([b"0", b"sleep 60"])
        leaver.send_multipart([b"last", b"echo a"])
        # Nothing but refusals and the quick one: 64 are taken.
        got = [receive(leaver) for _ in range(237)]
    assert got == [[b"%d" % i, b"error: busy, try again later"] for i in range(64, 300)] + [[b"last", b"a"]]
    other = connect(endpoint)
    assert ask(other, b"1", b"echo hi") == [b"1", b"hi"]
    # There is room for others, too, up to 256 of all.
    full = [connect(endpoint) for _ in range(3)]
    for client in full:
        for i in range(64):
            client.send_multipart([b"%d" % i, b"sleep 60"])
        assert ask(client, b"last", b"echo a") == [b"last", b"a"], "none is refused"
    assert ask(other, b"2", b"sleep 0") == [b"2", b"error: busy, try again later"]
    assert ask(other, b"3", b"echo hi") == [b"3", b"hi"]


def test_a_place_is_free_again_when_its_request_is_done(serve, connect):
    _, endpoint = serve(KEY)
    client = connect(endpoint)
    for _ in range(5):
        for i in range(64):
            client.send_multipart([b"%d" % i, b"sleep 0"])
        assert sorted(receive(client) for _ in range(64)) == sorted([b"%d" % i, b"slept 0"] for i in range(64))


def test_clients_that_come_and_go_do_not_fill_the_memory(serve, connect, context):
    server, endpoint = serve(KEY, "--workers", "1")
    before = memory(server.process)
    for _ in range(8):
        with context.socket(zmq.DEALER) as leaver:
            leaver.linger, leaver.sndhwm, leaver.rcvhwm, leaver.sndtimeo = 0, 10, 0, 5000
            leaver.connect(endpoint)
            for i in range(1000):
                leaver.send_multipart([b"%d" % i, b"sleep 30".ljust(65_000)])
            leaver.send_multipart([b"", b"echo that is all"])
            while receive(leaver)[0]:
                pass
    assert memory(server.process) - before < 100e6, "520 MB were sent"


def test_a_huge_window_does_not_starve_another_client(serve, connect):
    _, endpoint = serve(KEY, "--workers", "2")
    greedy, polite = connect(endpoint), connect(endpoint)
    for i in range(1000):
        greedy.send_multipart([b"%d" % i, b"sleep 0.01"])
    receive(greedy)
    for i in range(20):
        polite.send_multipart([b"%d" % i, b"sleep 0.01"])
    for _ in range(20):
        assert receive(polite)[1] == b"slept 0.01"


def test_a_client_that_never_reads_does_not_fill_the_servers_memory(serve, connect):
    server, endpoint = serve(KEY)
    a_client_that_never_reads(server, endpoint, connect)


BAD = {
    "no text": [b"7"],
    "three frames": [b"7", b"echo a", b"b"],
    "an unknown command": [b"7", b"hello"],
    "invalid UTF-8": [b"7", b"\xff\xfe"],
    "not a number": [b"7", b"sleep nan"],
    "digits of another script": [b"7", "sleep ٣".encode()],
    "empty frames": [b"", b""],
}


@pytest.mark.parametrize("frames", BAD.values(), ids=BAD.keys())
def test_a_bad_request_gets_an_error_and_the_next_an_answer(frames, serve, connect):
    server, endpoint = serve(KEY)
    client = connect(endpoint)
    request_id, text = ask(client, *frames)
    assert request_id == frames[0]
    assert text.startswith(b"error: expected")
    assert ask(client, b"8", b"echo b") == [b"8", b"b"]
    assert ask(client, b"9", b"sleep 0") == [b"9", b"slept 0"]
    assert server.stop() == 0


def test_a_message_that_is_too_large_ends_its_connection_only(serve, connect):
    server, endpoint = serve(KEY)
    client, other = connect(endpoint), connect(endpoint)
    assert ask(client, b"1", b"echo a") == [b"1", b"a"]
    assert ask(other, b"1", b"sleep 0") == [b"1", b"slept 0"]
    assert ask(client, b"1", b"echo " + b"x" * 65_000) == [b"1", b"x" * 65_000]
    client.send_multipart([b"2", b"echo " + b"x" * 10_000_000])
    # It connects again, and what it asks then is answered.
    client.send_multipart([b"3", b"echo c"])
    assert receive(client) == [b"3", b"c"]
    assert ask(other, b"2", b"echo b") == [b"2", b"b"]
    assert server.stop() == 0


def test_a_req_socket_is_answered_too(serve, connect):
    """REQ puts an empty frame first, which is an id like any other."""
    _, endpoint = serve(KEY)
    assert ask(connect(endpoint, zmq.REQ), b"sleep 0.1") == [b"slept 0.1"]


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to end a program with")
def test_a_server_ends_at_once_with_workers_at_work(how, serve, connect):
    server, endpoint = serve(KEY)
    client = connect(endpoint)
    for i in range(64):
        client.send_multipart([b"%d" % i, b"sleep 60" if i % 16 == 0 else b"sleep 0"])
    # The others are done, so that these are at work.
    assert receive(client)[1] == b"slept 0"
    assert server.stop(how, limit=30) == 0
    assert "Traceback" not in server.output
