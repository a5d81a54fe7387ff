"""Lesson 16's tap: the lessons run through it unchanged, trouble is what was asked for, and others are kept out."""

import contextlib
import functools
import itertools
import json
import re
import socket
import sys
import threading
import time
import urllib.error
import urllib.request

import pytest
import zmq

from tests.conftest import PYTHON
from tests.lessons.conftest import bind
from tests.programs import LIMIT, ROOT, free_port, python_runs

LESSON = ROOT / "python" / "16_web_gateway"
aiohttp = pytest.importorskip("aiohttp", reason="the tap needs aiohttp: pip install aiohttp")
from netmq_example.tap.arrows import BEGIN, END, MOST_ARROWS, MOST_BYTES, Arrows  # noqa: E402
from netmq_example.tap.page import Page  # noqa: E402
from netmq_example.tap.passing import Faults, Link  # noqa: E402
from netmq_example.tap.zmtp import GREETING, NotZeroMQ, Piece, mechanism, socket_type, take  # noqa: E402

HELLO = b"\xff" + bytes(8) + b"\x7f\x03\x01NULL".ljust(GREETING - 9, b"\0")


@pytest.fixture
def tap(start, tmp_path):
    """tap(endpoint, "--drop", "3") stands in front of a server: (program, the client's endpoint, the page)."""

    def tap(*words):
        program = start(PYTHON, LESSON / "tap.py", "--endpoint", "tcp://127.0.0.1:0", *words, folder=tmp_path)
        endpoint = program.wait_for(r"^listening on (\S+)")[1]
        return program, endpoint, program.wait_for(r"^page at (\S+)/")[1]

    return tap


def arrow(page, number):
    """The page opens a message and is told this: a dict, with the frames as bytes."""
    from base64 import b64decode

    with urllib.request.urlopen(f"{page}/arrow/{number}", timeout=20) as answer:
        told = json.load(answer)
    return {**told, "frames": [b64decode(data) for _, data in told["frames"]]}


def test_a_lesson_runs_through_it_unchanged(serve, tap, tmp_path, start_client):
    """One with two endpoints, and with topics."""
    key, words = "07_catch_up", "--count 3"
    server, endpoint = serve(key)
    others = {name: address for name, address in server.endpoints().items() if name != "endpoint"}
    program, endpoint, page = tap(*(f"{name}={address}" for name, address in others.items()), endpoint)
    for name in others:
        words += f" --{name} {program.endpoints()[name]}"
    # A second try would be for a message that the tap has lost, and for nothing else.
    client = start_client("csharp", key, endpoint, *words.split(), "--timeout", "20", folder=tmp_path)
    assert client.wait() == 0, client.output
    assert client.lines[-1].startswith("done: ") and "try 2" not in client.output
    assert arrow(page, 1)["text"].startswith("opened: ")
    assert program.lines[-1] == f"listening on {endpoint}"


def test_trouble_is_what_lesson_02_is_made_for(serve, tap, start_client, tmp_path):
    """Message 3 is the second request, and 6 the third: 1 is added all the same, and once."""
    _, endpoint = serve("02_lazy_pirate")
    tapping, endpoint, page = tap(endpoint, "--drop", "3", "--cut", "6", "--record", "seen.html")
    # The first request, which a busy machine may take long for, must need one try only.
    words = ["--count", "4", "--timeout", "4"]
    asking = start_client("csharp", "02_lazy_pirate", endpoint, *words, folder=tmp_path)
    assert asking.wait() == 0, asking.output
    assert "4: sent add 1, received 4" in asking.lines
    assert [line for line in asking.lines if "no reply" in line] == [
        "2: no reply within 4 s; try 2 of 5",
        "3: no reply within 4 s; try 2 of 5",
    ]
    assert arrow(page, 4)["text"] == "drop"
    with pytest.raises(urllib.error.HTTPError, match="404"):
        arrow(page, 10**9)
    assert tapping.stop() == 0
    assert BEGIN + END not in (tmp_path / "seen.html").read_text(encoding="utf-8")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of open files for a program")
def test_more_clients_than_files_may_be_open_keep_nobody_out_for_ever(serve, start, context):
    words = [PYTHON, ROOT / "python" / "16_web_gateway" / "tap.py", serve("01_request_reply")[1]]
    program = start("sh", "-c", 'ulimit -n 64; exec "$@"', "sh", *words, "--endpoint", "tcp://127.0.0.1:0")
    endpoint = program.wait_for(r"^listening on (\S+)")[1]
    port = int(endpoint.rpartition(":")[2])
    with contextlib.ExitStack() as crowd:
        for _ in range(60):
            crowd.enter_context(socket.create_connection(("127.0.0.1", port)))
        program.wait_for("^trouble: no room for one more client: Too many open files")
    with context.socket(zmq.REQ) as asker:
        asker.connect(endpoint)
        asker.send(b"Hello")
        assert asker.recv() == b"World"
    assert "Traceback" not in program.output


@contextlib.contextmanager
def tapped(server, arrows, faults):
    """A tap in this process: its endpoint for clients."""
    host, port = server.removeprefix("tcp://").split(":")
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def accept():
            with contextlib.suppress(OSError):
                for number in itertools.count(1):
                    run = Link(number, arrows, faults).run
                    threading.Thread(target=run, args=(listener.accept()[0], host, int(port)), daemon=True).start()

        threading.Thread(target=accept, daemon=True).start()
        yield f"tcp://127.0.0.1:{listener.getsockname()[1]}"
        with contextlib.suppress(OSError):
            listener.shutdown(socket.SHUT_RDWR)


@pytest.fixture
def line():
    """line(server, {3: "drop"}): a tap in this process: an endpoint for clients, and the arrows."""
    with contextlib.ExitStack() as taps:

        def line(server, planned=None, slow=0):
            arrows = Arrows()
            return taps.enter_context(tapped(server, arrows, Faults(planned or {}, slow=slow))), arrows

        yield line


def until(arrows, text):
    """The first arrow with this text, once it is there."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        for each in arrows.after(0, 100):
            if each.text.startswith(text):
                return each
        time.sleep(0.01)
    raise AssertionError(f"never {text!r}: {[each.text for each in arrows.after(0, 100)]}")


def pair(context, line, kinds, **how):
    """Two sockets with a tap between them: (behind it, in front of it, the arrows)."""
    behind, front = (context.socket(kind) for kind in kinds)
    endpoint, arrows = line(bind(behind), **how)
    return behind, front, endpoint, arrows


@pytest.mark.parametrize(
    ("fault", "seen"), [("drop", b"13"), ("cut", b"13"), ("double", b"1223"), ("delay", b"123"), ("slow", b"123")]
)
def test_what_trouble_makes_of_the_second_message(fault, seen, context, line):
    how = {"slow": 0.3} if fault == "slow" else {"planned": {2: fault}}
    pull, push, endpoint, arrows = pair(context, line, (zmq.PULL, zmq.PUSH), **how)
    with pull, push:
        push.connect(endpoint)
        push.send(b"1")
        assert pull.recv() == b"1"
        begin = time.monotonic()
        push.send(b"2")
        if fault == "cut":
            until(arrows, "closed")
        push.send(b"3")
        found = b"1"
        while not found.endswith(b"3"):
            found += pull.recv()
        assert found == seen
        assert time.monotonic() - begin > {"slow": 0.59, "delay": 0.99}.get(fault, 0)
    if fault != "slow":
        assert until(arrows, fault).piece.frames == [b"2"]


def test_identities_and_subscriptions_stay_the_clients_own(context, line):
    router, dealer, endpoint, arrows = pair(context, line, (zmq.ROUTER, zmq.DEALER))
    with router, dealer:
        dealer.setsockopt(zmq.IDENTITY, b"me")
        # Longer than one read of the tap, and with frames of all sizes.
        sent = [b"", b"x" * 255, b"y" * 256, bytes(range(256)) * 2000]
        dealer.connect(endpoint)
        dealer.send_multipart(sent)
        assert router.recv_multipart() == [b"me", *sent]
        router.send_multipart([b"me", b"answer"])
        assert dealer.recv_multipart() == [b"answer"]
    opening, up, down = arrows.after(0, 3)
    assert opening.text == "opened: DEALER to ROUTER"
    assert (up.piece.frames, up.way) == (sent, "up") and (down.piece.frames, down.way) == ([b"answer"], "down")
    publisher, listener, endpoint, arrows = pair(context, line, (zmq.XPUB, zmq.SUB))
    with publisher, listener:
        listener.subscribe(b"a")
        listener.connect(endpoint)
        assert publisher.recv() == b"\1a"
        publisher.send(b"b1")
        publisher.send(b"a2")
        assert listener.recv() == b"a2"
        assert [each.piece.frames for each in arrows.after(0, 10) if each.way == "down"] == [[b"a2"]]


@pytest.mark.parametrize(
    "what", [b"GET / HTTP/1.1\r\n" + b"x" * 100, b"\xff" + bytes(8) + b"\x7f\x01" + bytes(90), b""]
)
def test_what_is_no_zeromq_or_has_no_server_is_let_go_and_said(what, line):
    with socket.create_server(("127.0.0.1", 0)) as listener:
        server = f"127.0.0.1:{listener.getsockname()[1] if what else free_port()}"
        endpoint, arrows = line(f"tcp://{server}")
        with socket.create_connection(("127.0.0.1", int(endpoint.rpartition(":")[2]))) as stranger:
            stranger.settimeout(LIMIT)
            with contextlib.suppress(ConnectionError):
                stranger.sendall(what)
                while stranger.recv(4096):
                    pass
    until(arrows, "closed by the tap: this is no ZeroMQ" if what else f"no server at {server}")


def test_another_web_page_gets_nothing(tap):
    _, _, page = tap(f"tcp://127.0.0.1:{free_port()}")
    # It is shown in no frame, where its clicks could be stolen.
    with urllib.request.urlopen(page, timeout=20) as own:
        assert own.headers["Content-Security-Policy"] == "frame-ancestors 'none'"
    for headers in {"Host": "evil.example"}, {"Origin": "http://evil.example"}, {"Origin": "http://127.0.0.1:1"}:
        for path in ("", "live", "arrow/1", "recording.html"):
            with pytest.raises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen(urllib.request.Request(f"{page}/{path}", headers=headers), timeout=20)
            assert refused.value.code == 403


def test_wrong_words_and_a_taken_port_are_named():
    server = "tcp://127.0.0.1:1"
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        table = [
            ("tcp://127.0.0.1:99999", "bad endpoint 'tcp://127.0.0.1:99999': write it like tcp://127.0.0.1:5552"),
            ("ipc://x", "bad endpoint 'ipc://x'"),
            (f"{server} --endpoint tcp://0.0.0.0:0", ": the tap listens on this machine only"),
            (f"{server} --endpoint tcp://127.0.0.1:65536", ": the tap listens on this machine only"),
            (f"{server} --page 70000", "--page: it takes a whole number from 0 to 65535, not 70000"),
            (f"{server} --slow nan", "--slow: it takes seconds, 0 or more and at most a day, not nan"),
            (f"{server} --slow 60", "--slow: it takes seconds, less than 60, not '60'"),
            (f"{server} --frame http://evil.example", "--frame: it is an origin of this machine, such as http"),
            (f"{server} --drop 0", "--drop"),
            (f"x={server}", "one server has no name, as in: tap.py tcp://127.0.0.1:5557 snapshots="),
            (f"x-y={server}", "bad name 'x-y': write it like snapshots="),
            (f"{server} --record no/where.html", "cannot write 'no/where.html': "),
            ("", "the following arguments are required: SERVER"),
            (f"{server} --endpoint tcp://127.0.0.1:{port}", "; try port 0, which takes a free one"),
        ]
        found = python_runs(LESSON / "tap.py", [words.split() for words, _ in table])
    for (words, said), run in zip(table, found, strict=True):
        assert said in run.lines[-1] and run.code == (1 if str(port) in words else 2), (words, run)
    assert re.match(rf"cannot listen on 127.0.0.1:{port}: ", found[-1].lines[-1])


# ---- Its parts ----


def frame(body, flags=0):
    return bytes([flags, len(body)]) + body if len(body) < 256 else bytes([flags | 2]) + len(body).to_bytes(8) + body


def test_a_message_is_one_however_it_is_cut():
    """Each beginning of the bytes is no message yet, and what follows them stays."""
    bodies = [b"", b"a" * 255, b"b" * 256]
    raw = b"".join(frame(body, 1 if body is not bodies[-1] else 0) for body in bodies)
    for end in range(len(raw)):
        assert take(buffer := bytearray(raw[:end]), 10_000) is None and buffer == raw[:end]
    piece = take(buffer := bytearray(raw + b"\x04\x05\x04PING"), 10_000)
    assert (piece.raw, piece.frames, piece.command) == (raw, bodies, False)
    ping = take(buffer, 10_000)
    assert (ping.name, ping.command, buffer) == (b"PING", True, b"")


def test_what_is_no_zeromq_is_refused_before_it_fills_the_memory():
    """Of a peer that is one, and says nothing of use in its READY, the type stays unknown."""
    for raw in (b"\x08\x00", b"\x02" + (10_001).to_bytes(8), b"\x02" + b"\xff" * 8, b"\x47\x45T"):
        with pytest.raises(NotZeroMQ):
            take(bytearray(raw), 10_000)
    assert mechanism(HELLO) == "NULL"
    for other in (HELLO[:20], b"\x01" + HELLO[1:], HELLO[:10] + b"\x01" + HELLO[11:]):
        with pytest.raises(NotZeroMQ):
            mechanism(other)
    for ready in (b"\x05READY", b"\x05READY\xff", b"\x05READY\x0bSocket-Type\xff\xff\xff\xff"):
        assert socket_type(ready) in ("?", "")


def test_what_is_kept_has_a_limit_and_the_newest_stay():
    arrows, piece = Arrows(), Piece(b"\x00\x01x", [slice(2, 3)], False)
    for _ in range(MOST_ARROWS + 10):
        arrows.add(1, "up", piece)
    assert [each.number for each in arrows.after(0, 5)] == list(range(MOST_ARROWS + 6, MOST_ARROWS + 11))
    assert arrows.find(10) is None and arrows.find(11).number == 11 and arrows.find(MOST_ARROWS + 11) is None
    large = Piece(bytes(MOST_BYTES // 2), [slice(0, MOST_BYTES // 2)], False)
    for _ in range(5):
        arrows.add(1, "down", large)
    assert len(arrows.kept) == 2 and arrows.totals["down"] == 5 and arrows.after(MOST_ARROWS + 15, 5) == []


def test_messages_that_do_not_end_have_a_limit_of_all_connections(line, monkeypatch):
    """Eight that announced 290 MB and sent 200 filled the memory."""
    monkeypatch.setattr("netmq_example.tap.arrows.MOST_HELD", 3_000_000)
    size = 2_000_000
    said = HELLO + b"\x02" + size.to_bytes(8, "big")
    with socket.create_server(("127.0.0.1", 0)) as listener, contextlib.ExitStack() as ends:
        endpoint, kept = line(f"tcp://127.0.0.1:{listener.getsockname()[1]}")

        def client(count):
            one = ends.enter_context(socket.create_connection(("127.0.0.1", int(endpoint.rpartition(":")[2]))))
            behind = ends.enter_context(listener.accept()[0])
            behind.settimeout(LIMIT)
            with contextlib.suppress(ConnectionError):
                one.sendall(said + bytes(count))
            return one, behind

        unfinished = [client(size - 1) for _ in range(2)]
        until(kept, "closed by the tap: what waits here to be passed on is more than 3,000,000 bytes")
        for each in itertools.chain(*unfinished):
            each.close()
        # The room of a closed connection is free again, sooner or later.
        end = time.monotonic() + LIMIT
        came = b""
        while len(came) < len(said) + size:
            assert time.monotonic() < end
            one, behind = client(size)
            one.shutdown(socket.SHUT_WR)
            came = b"".join(iter(functools.partial(behind.recv, 65536), b""))


def test_what_is_no_wish_of_the_page_changes_nothing():
    faults = Faults()
    slow = [f'{{"slow": {slow}}}' for slow in ("NaN", -1, '"x"', "9" * 400, 10.5)]
    for text in ("", "[]", "7", "[" * 999, '{"fault": "drop"}', '{"way": "up"}', *slow):
        Page(Arrows(), faults, "").ask(text)
        assert (faults.asked, faults.slow) == ("", 0), text
    Page(Arrows(), faults, "").ask('{"fault": "cut", "way": "down"}')
    assert (faults.asked, faults.way) == ("cut", "down")
