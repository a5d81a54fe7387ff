"""Lesson 04: frames go on whatever the server does, each request ends once, and the main thread pays nothing for it."""

import contextlib
import itertools
import json
import random
import re
import shutil
import time

import pytest
import zmq

from netmq_example.background_client import BackgroundClient
from tests.bad_peers import Listener, greeting, ready
from tests.conftest import CLIENTS
from tests.lessons.conftest import answering, ask, bind, retry, server_of
from tests.programs import LIMIT, steady_endpoint

KEY = "04_background_client"
FRAMES = r"frames: (\d+), the longest took (\d+) ms"


def lost(endpoint, timeout, tries=3):
    return (
        f"{tries} tries to ask {endpoint}, the last: no reply within {timeout:g} s; "
        "is the right server running, the line slow, or the reply over 64 KB? 'hello' may have been done or not"
    )


def frames(run):
    """How many frames there were, and how long the longest took, by the client's own last lines."""
    return [int(number) for number in re.search(FRAMES, "\n".join(run.lines)).groups()]


def until(true, *clients):
    """Frames until something is true."""
    end = time.monotonic() + LIMIT
    while not true():
        assert time.monotonic() < end, [client.status for client in clients]
        for client in clients:
            client.poll()
        time.sleep(0.005)


@pytest.fixture
def check(start, checks):
    """check("Stop Randomly", endpoint) runs checks of tests/lessons/checks/BackgroundClientChecks.cs, in this order."""

    def check(names, endpoint, *more):
        return start("dotnet", checks, "background", *(f"{name}={endpoint}" for name in names.split()), *more)

    return check


def no_reply_at_all(peer):
    """REQ drops a reply without the empty frame in front: there is something to receive, and then there is not."""
    stream = peer.makefile("rb")
    peer.sendall(greeting() + ready(b"ROUTER"))
    stream.read(64)
    assert stream.read(stream.read(2)[1])[:6] == b"\x05READY"
    while True:
        for _ in range(3):
            stream.read(stream.read(2)[1])
        peer.sendall(b"\x00\x0eno empty frame")


class Stranger(Listener):
    """Has the port and is not the server: it behaves so with each connection."""

    def __init__(self, serve):
        self.serve = serve


def noise(peer):
    peer.sendall(random.Random(4).randbytes(100_000))
    while peer.recv(65_536):
        pass


# --- the clients in a terminal and in Unity


def oddly():
    """Answers six requests of each client in this way; lesson 02's test looks at their ids."""
    # No reply has other frames than [id][text], with the request's own id.
    answers = itertools.cycle([[b"W\xc3\xb6rld"], None, [b"one", b"two"], [b"1", b"2", b"3"], None, None])
    numbers = itertools.count(1)

    def answer(frames):
        name, text = frames
        if next(numbers) % 6 == 0:
            # Not a wait for something: the frames go on meanwhile.
            time.sleep(1)
        return next(answers) or [name, "größer".encode() if text.decode() == "echo grün ✓" else text]

    return answer


@pytest.mark.parametrize("kind", CLIENTS)
def test_clients_in_a_terminal_and_in_unity(kind, serve, runs, context, monkeypatch):
    """Each is started in a German's terminal: numbers and texts are the same."""
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    server, endpoint = serve(KEY)
    _, slow = serve(KEY, "--slow-on", "3")
    nowhere = steady_endpoint()
    with answering(context, oddly()) as odd:
        done, retried, alone, *naive = runs(
            kind,
            KEY,
            [
                # Patient, so that none is sent twice: the server's lines are counted below.
                ["--endpoint", endpoint, "--timeout", "30"],
                ["--endpoint", odd, "--count", "3", "--text", "echo grün ✓", "--timeout", "20"],
                ["--endpoint", nowhere, "--timeout", "0.5", "--tries", "3"],
                *([["--endpoint", slow, "--naive"]] if kind != "unity" else []),
            ],
        )
    assert done.code == 0, done.lines
    *replies, last, before = [line for line in done.lines if "now true" not in line]
    # In Unity another component counts the frames, after it is done.
    assert re.fullmatch(FRAMES, before if kind == "unity" else last) and "done: 10 replies" in (last, before)
    assert replies == [f"asking {endpoint}", *(f"{i}: sent hello, received world" for i in range(1, 11))]
    # The server prints after it has replied: its last line may come later than the client's end.
    server.wait_for("^10: sent")
    assert server.lines[1:] == [f"{i}: sent b'world'" for i in range(1, 11)]
    assert retried.code == 0, retried.lines
    replies = [line for line in retried.lines if "received" in line]
    assert replies == [f"{i}: sent echo grün ✓, received größer" for i in (1, 2, 3)]
    # A frame shows what it saw; a retry between two frames may stay unseen.
    trouble = [line for line in retried.lines if line.startswith("trouble: ")]
    dropped = "trouble: [12]: dropped a reply to another request.*; try [23] of 20"
    assert trouble and all(re.fullmatch(dropped, line) for line in trouble)
    assert len(set(trouble)) == len(trouble)
    assert frames(retried)[0] > 15, "more than one for each reply: a slow answer stops none"
    assert alone.code == 1
    assert alone.lines.count(f"gave up: {lost(nowhere, 2)}") == 1
    # On a busy machine there may be no frame for a second.
    trouble = [line for line in alone.lines if line.startswith("trouble: ")]
    said = [f"trouble: {retry(1, attempt, tries=3, timeout=0.5)}" for attempt in (2, 3)]
    assert trouble in (said, said[:1], said[1:])
    # Some 200, on a busy machine far fewer; a client that waits where the frames are made has one, or three.
    assert frames(alone)[0] > 5
    for run in naive:
        # The lesson cures this: if it were smooth too, the others would show nothing.
        assert run.code == 0
        assert frames(run)[0] == 10 and frames(run)[1] >= 1000


@pytest.mark.parametrize("side", ["python", "csharp"])
def test_no_stranger_is_taken_for_the_server(side, runs):
    with contextlib.ExitStack() as stack:
        silent_and_others = Listener(), Stranger(noise), Stranger(no_reply_at_all)
        strangers = [stack.enter_context(each).endpoint for each in silent_and_others]
        words = ["--count", "1", "--timeout", "0.3", "--tries", "3", "--endpoint"]
        found = runs(side, KEY, [[*words, endpoint] for endpoint in strangers])
    for endpoint, run in zip(strangers, found, strict=True):
        assert f"gave up: {lost(endpoint, 1.2)}" in run.lines, run


# --- what a user may do in code, in Python


def test_requests_under_way_survive_the_servers_end(serve):
    endpoint = steady_endpoint()
    server, _ = serve(KEY, endpoint=endpoint)
    with contextlib.closing(BackgroundClient(endpoint, timeout=0.5, tries=60)) as client:
        replies: list[str] = []
        errors: list[str] = []
        assert client.status == ("Connecting", "")
        for number in range(10):
            assert client.request(f"echo {number}", replies.append, errors.append)
            if number == 4:
                until(lambda: client.under_way == 0, client)
                assert client.status[0] == "Connected"
                server.kill()
        until(lambda: client.status[0] == "Retrying", client)
        serve(KEY, endpoint=endpoint)
        until(lambda: client.under_way == 0, client)
    assert (replies, errors) == ([str(number) for number in range(10)], [])
    assert client.status[0] == "Disposed" and client.status[1].endswith(" of 60")


def test_each_request_to_the_python_client_ends_once():
    with Listener() as nobody:
        endpoint = nobody.endpoint
        client, ends = BackgroundClient(endpoint, timeout=20), []
        for _ in range(64):
            assert client.request("hello", ends.append, ends.append)
        assert not client.request("hello", ends.append, ends.append), "it is full"
        client.close()
        assert not client.request("hello", ends.append, ends.append), "it is closed"
        assert ends == ["the client was closed"] * 64 and not client.threads[0].is_alive()

        def closes(why):
            ends.append(why)
            client.close()

        # A text that is too long is not sent; and a callback closes the client, while others wait to be run.
        client, ends = BackgroundClient(endpoint, timeout=20), []
        for _ in range(3):
            client.request("x" * 70_000, closes, closes)
        until(lambda: client.done.qsize() == 3)
        client.poll()
        assert ends == ["a text of 70000 bytes, more than 65536: lesson 05 carries more"] * 3


def test_a_callback_that_asks_again_does_not_make_one_frame_last_for_ever():
    with contextlib.closing(BackgroundClient("tcp://127.0.0.1:5554")) as client:
        ends: list[str] = []

        def again(why):
            ends.append(why)
            if client.request("x" * 70_000, again, again):
                until(lambda: not client.done.empty())

        client.request("x" * 70_000, again, again)
        until(lambda: not client.done.empty())
        client.poll()
        assert len(ends) == 1


def test_a_python_client_that_nobody_polls_says_so_once(serve, caplog):
    client = BackgroundClient(serve(KEY)[1])
    heard = []
    for number in range(2):
        client.request("hello", heard.append, heard.append)
        end = time.monotonic() + LIMIT
        while client.done.qsize() <= number or not caplog.messages:
            assert time.monotonic() < end
            time.sleep(0.01)
    client.close()
    assert heard == ["world"] * 2
    assert [line.partition(":")[0] for line in caplog.messages] == ["BackgroundClient"]


# --- and in C#


def test_in_code_with_a_server(serve, check):
    # The first wants NetMQ as it is at the beginning, and the last one leaves a thread behind for a while.
    names = "NoSocket AllocatesNothing OneAfterAnother Why Await Throwing Nested Cleanup"
    program = check(f"{names} NeverPolled Stuck", serve(KEY)[1])
    assert program.wait() == 0, program.output
    assert program.lines[-1] == "Stuck: ok"


NOBODY = ("Refusal", "Cancelled", "Asleep", "ListenerStops", "Within")


def test_in_code_with_nobody_who_answers(check, context):
    """The first try of the second request is not answered, and the other one when its state was seen."""
    with context.socket(zmq.ROUTER) as router, Listener() as stranger:
        nobody = stranger.endpoint
        program = check(
            "State",
            bind(router),
            *(f"{each}={nobody}" for each in NOBODY),
            # A form that is wrong is refused by the constructor: test_rules.py.
            "LookUp=tcp://no-such-host.invalid:5554",
        )
        for number, attempt in ((1, 1), (2, 1), (2, 2), (3, 1), (4, 1)):
            peer, empty, name, _ = router.recv_multipart()
            assert name.startswith(b"%d-" % number)
            if attempt == 2:
                program.wait_for("^Retrying")
            if (number, attempt) != (2, 1):
                router.send_multipart([peer, empty, name, b"world"])
        assert program.wait() == 0, program.output
        trouble = retry(2, 2, tries=3, timeout=4)
        assert program.lines[:4] == ["Connecting ", "Connected ", f"Retrying {trouble}", f"Connected {trouble}"]
        limited = [line for line in program.lines if " within 0.1 s to ask " in line or " within 1.5 s to ask " in line]
        # A try that waits longer than is left is cut.
        for line, tries in zip(limited, ("1 try within 0.1 s", "[234] tries within 1.5 s"), strict=True):
            assert re.match(rf"{tries} to ask {nobody}, the last: no reply within (0|0\.\d+) s; is the right ", line)
        assert program.lines[-1] == "LookUp: ok"


def test_every_request_ends_once_while_the_server_is_killed_again_and_again(serve, check):
    endpoint = steady_endpoint()
    server, _ = serve(KEY, endpoint=endpoint)
    program = check("Randomly", endpoint)
    kills = 0
    rng = random.Random(4)
    while program.process.poll() is None and kills < 100:
        # Not a wait for something: the pause is the trouble.
        time.sleep(rng.random() / 2)
        server.kill()
        kills += 1
        server, _ = serve(KEY, endpoint=endpoint)
    assert program.wait() == 0, program.output
    assert program.lines[-1] == "Randomly: ok"
    assert kills >= 2


# --- the server


def test_a_retry_is_answered_from_memory(monkeypatch, printed):
    """Also where the answer is an exception: nothing is done twice, and the next request is answered as before."""
    server = server_of(KEY)
    texts: list[str] = []

    def answer(text):
        texts.append(text)
        return [str(len(texts))][text == "boom"]

    monkeypatch.setattr(server, "answer", answer)
    for i in [1, *range(1, 1002), 1001, 2]:
        assert server.remembered(b"%d" % i, b"") == b"%d" % i
    # It is bounded: what is older than a thousand requests is forgotten.
    assert server.remembered(b"1", b"") == b"1002"
    for _ in range(2):
        assert server.remembered(b"x", b"boom") == b"error: IndexError('list index out of range')"
    assert server.remembered(b"y", b"") == b"1004"
    assert printed.readouterr().err.count("Traceback") == 1


REQUESTS = {
    "sixty kilobytes": ([b"1", b"echo " + b"x" * 60_000], [b"1", b"x" * 60_000]),
    "another text": ([b"1", b"H" * 41], [b"1", b"error: expected hello or echo TEXT, got '%b'" % (b"H" * 40)]),
    "bytes that are no UTF-8": ([b"1", b"\xff"], [b"1", b"error: expected hello or echo TEXT, got '(1 bytes)'"]),
    # By it nobody's retry could be known from another's request.
    "an empty id": ([b"", b"hello"], [b"error: expected two frames, [id][text]"]),
    "one frame": ([b"hello"], [b"error: expected two frames, [id][text]"]),
    "three frames": ([b"1", b"2", b"3"], [b"error: expected two frames, [id][text]"]),
    "an id again": ([b"1", b"echo the first"], [b"1", b"the first"]),
    "with another text": ([b"1", b"echo the last"], [b"1", b"the last"]),
}


def test_what_the_server_answers(serve, connect):
    server, endpoint = serve(KEY)
    asker = connect(endpoint, zmq.REQ)
    for request, reply in REQUESTS.values():
        asker.send_multipart(request)
        assert asker.recv_multipart() == reply
    # It prints after it has replied; and what is an error to its client is no line here, except for an answer's own.
    server.wait_for("the last")
    assert len(server.lines) == 1 + sum(not reply.startswith(b"error") for _, (*_, reply) in REQUESTS.values())
    assert max(map(len, server.lines)) < 100 and "Traceback" not in server.output


# --- with JSON: objects of one's own both ways


TOLD = """
def answer(text):
    import json
    reply = json.loads(text)["reply"]
    return json.dumps({"say": text}) if reply == "the state" else reply
"""


def test_classes_of_ones_own_in_csharp(serve_own, check):
    program = check("Ask", serve_own(KEY, TOLD)[1])
    assert program.wait() == 0, program.output
    assert program.lines == ["Ask: ok"]


JSON = """
from netmq_example.replies import json_answer

seen = []


@json_answer
def answer(state: dict) -> dict:
    seen.append(state["guest"])
    if state.get("mistake"):
        return {}["mine"]
    if "result" in state:
        return {"nan": {"x": float("nan")}, "set": {"x": {1}}, "list": [], "key": {(1, 2): 1}}[state["result"]]
    return {"seen": seen, "x": state["place"]["x"]}
"""
ASKED = {
    '{"guest": "Ada", "place": {"x": 1}}': '{"seen": ["Ada"], "x": 1}',
    '{"guset": "Ada", "place": {"x": 1}}': "error: the request has no 'guest'; it has 'guset', 'place'",
    '{"guest": "Bo", "place": {}}': "error: the request has no 'x'; it has nothing",
    "{}": "error: the request has no 'guest'; it has nothing",
    "[1]": "error: the request '[1]' is no JSON object: send a class with fields",
    "null": "error: the request 'null' is no JSON object: send a class with fields",
    '{"guest": NaN}': "error: the request '{\"guest\": NaN}' is no JSON: NaN is not JSON",
    "hello\n": "error: the request 'hello?' is no JSON: Expecting value: line 1 column 1 (char 0)",
    "[" * 60_000: f"error: the request '{'[' * 80}…' is no JSON: it nests more than 64 levels deep",
    '{"guest": "Cy", "result": "list"}': "error: answer returned []: return a dict",
    '{"guest": "Cy", "result": "nan"}': "error: answer returned what JSON cannot have: Out of range float values",
    '{"guest": "Cy", "result": "set"}': "error: answer returned what JSON cannot have: Object of type set is not JSON",
    '{"guest": "Cy", "result": "key"}': "error: answer returned what JSON cannot have: keys must be str",
    '{"guest": "Cy", "mistake": true}': "error: KeyError('mine')",
}


def test_a_dict_in_and_a_dict_out_in_python(serve_own, context):
    server, endpoint = serve_own(KEY, JSON)
    for id, (request, wanted) in enumerate(ASKED.items()):
        # Asked twice, as by a retry.
        for _ in range(2):
            reply = ask(context, endpoint, b"%d" % id, request.encode())[1].decode()
            assert reply.startswith(wanted), reply
            if reply[0] == "{":
                assert json.loads(reply) == json.loads(wanted)
    server.wait_for(r"KeyError: 'mine'")
    # In one line, and how many there were meanwhile; only a mistake that is the answer's own has a traceback.
    assert "trouble: the request has no 'guest'; it has 'guset', 'place'" in server.lines
    # Asked twice.
    assert server.output.count("Traceback") == 1


# --- a game that serves: unity/Assets/NetMQExample/04_background_client/Server.cs


LONG = b"w" * 1001


def test_a_game_does_nothing_twice_and_says_what_is_wrong(game, connect):
    server, endpoint = game()
    one, other, req = connect(endpoint), connect(endpoint), connect(endpoint, zmq.REQ)
    unique = b"1-" + b"ab" * 16
    # The peer, its frames, and those with which the reply begins.
    for peer, frames, reply in [
        (one, [unique, b"count"], [unique, b"1"]),
        (one, [unique, b"count"], [unique, b"1"]),
        # After a retry on a new connection.
        (other, [b"", unique, b"count"], [b"", unique, b"1"]),
        (req, [unique, b"count"], [unique, b"1"]),
        (one, [unique, b"echo hi"], [unique, b"hi"]),
        # Two clients may count their requests from 1.
        (one, [b"1", b"count"], [b"1", b"2"]),
        (one, [b"1", b"count"], [b"1", b"2"]),
        (other, [b"1", b"count"], [b"1", b"3"]),
        # Without an id every request is a new one, and so it is behind a way that is too long to be kept.
        (one, [b"count"], [b"4"]),
        (one, [b"count"], [b"5"]),
        (one, [LONG, b"", b"1", b"count"], [LONG, b"", b"1", b"6"]),
        (one, [LONG, b"", b"1", b"count"], [LONG, b"", b"1", b"7"]),
        (req, [b"echo "], [b""]),
        (req, [b"\xff\xfe"], [b"error: expected hello or echo TEXT, got '(2 bytes)'"]),
        (req, [b"", b"count"], [b"error: expected hello or echo TEXT, got ' count'"]),
        (req, [b"echo a", b"b", b"c"], [b"a b c"]),
        (one, [b"echo a", b"b", b"c"], [b"a b c"]),
        (req, [b"9", b"throw"], [b"9", b"error: InvalidOperationException: no such thing?xxx"]),
        (req, [b"7", b"null"], [b"7", b"error: ArgumentNullException: answer's reply must not be null"]),
        (req, [b"8", b"long"], [b"8", b"error: ArgumentException: answer's reply has more than 65536 bytes"]),
        (req, [b"hello"], [b"world"]),
    ]:
        peer.send_multipart(frames)
        found = peer.recv_multipart()
        assert len(found[-1]) < 1020, found
        assert [*found[:-1], found[-1][: len(reply[-1])]] == reply, (frames, found)
    # The first mistake with all that is known of it; those in the same second are counted later.
    server.wait_for("answer threw System.InvalidOperationException: no such thing")
    server.wait_for("ServerChecks")


def test_a_game_that_ends_and_begins_again(start, checks):
    """Also on Mono, the runtime nearest to Unity's, where there is one."""
    for runtime in ["dotnet", *filter(shutil.which, ["mono"])]:
        done = start(runtime, checks, "server", "alone")
        assert done.wait() == 0, done.output
        taken, elsewhere, anyone, frames, disposed, ok = done.lines
        assert re.fullmatch(r"cannot listen on tcp://127.0.0.1:\d+: the port is taken; end the server .*", taken)
        assert elsewhere.startswith("cannot listen on tcp://192.0.2.1:0: AddressNotAvailable; is that an address of ")
        assert anyone == "endpoint 'tcp://0.0.0.0:5554' would let anyone in: take 127.0.0.1, or pass openToAnyone: true"
        assert frames == "0 bytes in a frame"
        assert disposed.endswith(" is disposed; make a new one")
        assert ok == "ok"
