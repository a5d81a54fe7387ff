"""Lesson 07: the exact state after joining late, loss and a restart; and all that goes wrong."""

import contextlib
import re
import time

import pytest
import zmq

from tests.conftest import CLIENTS
from tests.lessons.conftest import answering, ask, bind, on_the_circle
from tests.programs import LIMIT, PATIENT, free_port, two_ports

KEY = "07_catch_up"
GERMAN = {"LANG": "de_DE.UTF-8", "LC_ALL": "de_DE.UTF-8"}
# In this order: C# may have to be built first, and the other one would give up meanwhile.
TERMINAL = ["csharp", "python"]
JOINED = r"^joined run (\w+) at (\d+), checksum (\d+)$"


@pytest.fixture
def publish(serve):
    """Starts the server: the program, the stream's endpoint and the snapshots'."""

    def publish(*options, **where):
        server, endpoint = serve(KEY, *options, **where)
        return server, endpoint, server.wait_for(r"^snapshots on (\S+)")[1]

    return publish


@pytest.fixture
def follow(start_client):
    """Starts a client against both endpoints."""

    def follow(kind, endpoint, snapshots, *options, **environment):
        return start_client(kind, KEY, endpoint, "--snapshots", snapshots, *options, **environment)

    return follow


def numbers(lines, pattern):
    """All matches of the pattern in a client's lines, each as a list of its whole numbers."""
    found = (re.search(pattern, line) for line in lines)
    return [[int(word) for word in match.groups() if word.isdecimal()] for match in found if match]


def while_running(clients):
    """Counts from 1 as long as one of them runs."""
    deadline = time.monotonic() + LIMIT
    number = 0
    while any(client.process.poll() is None for client in clients) and time.monotonic() < deadline:
        number += 1
        yield number


def add(checksum, message):
    return (31 * checksum + sum(message)) % 2**32


def snapshot_of(reply):
    """Checksum and number."""
    checksum, _, _, number = reply.split(b" ")[:4]
    return int(checksum), int(number)


# With the real server


def test_joining_late(publish, runs):
    server, endpoint, snapshots = publish("--interval", "0.005")
    for kind in CLIENTS:
        words = ["--endpoint", endpoint, "--snapshots", snapshots, "--count"]
        (code, lines), (empty, said) = runs(kind, KEY, [[*words, "120", *PATIENT], [*words, "0"]])
        assert (code, lines[0]) == (0, f"following {endpoint}, snapshots from {snapshots}"), lines
        run, joined, checksum = re.search(JOINED, lines[1]).groups()
        server.wait_for(f"^snapshot at {joined}, checksum {checksum}$")
        # On a busy machine a second may pass without a pose, and the snapshot that is asked for then skips some.
        gaps = numbers(lines, r"^missed (\d+) to (\d+)$")
        missed = sum(last - first + 1 for first, last in gaps)
        begin, end = int(joined), int(joined) + 120 + missed
        places = numbers(lines, r"^(\d+): at -?[0-2]\.\d{4} 0\.0000 -?[0-2]\.\d{4}$")
        assert gaps or places == [[begin], [begin + 60], [end]]
        assert lines[-1].startswith(f"done: received 120, missed {missed}; run {run} at {end}, checksum ")
        assert len(lines) == 3 + len(gaps) + len(places)
        assert empty == 0 and said[-1].startswith("done: received 0, missed 0; "), said


def test_who_comes_when_all_is_said_has_the_state_too(publish, runs):
    server, endpoint, snapshots = publish("--interval", "0", "--count", "1000")
    checksum = server.wait_for(r"^published 1000, checksum (\d+)")[1]
    for kind in CLIENTS:
        words = ["--endpoint", endpoint, "--snapshots", snapshots, *PATIENT]
        ended, over = runs(kind, KEY, [[*words, "--until", "1000"], [*words, "--seconds", "0"]])
        run = re.search(JOINED, ended.lines[1])[1]
        assert ended.lines[-1] == f"done: received 0, missed 0; run {run} at 1000, checksum {checksum}"
        assert over.lines[1:] == ["done: received 0, missed 0; run  at 0, checksum 0"], "there is no time for one"
        assert ended.code == over.code == 0


# With a publisher of the test's own, which decides on every message


class FakePublisher:
    """An XPUB, which sees subscriptions come, and a ROUTER, which answers a request when the test says so."""

    def __init__(self, context, endpoint="tcp://127.0.0.1:*", snapshots="tcp://127.0.0.1:*"):
        self.stream, self.router = context.socket(zmq.XPUB), context.socket(zmq.ROUTER)
        self.endpoint, self.snapshots = bind(self.stream, endpoint), bind(self.router, snapshots)

    def close(self):
        self.stream.close()
        self.router.close()

    def request(self):
        """The next request: who asks, and what."""
        who, empty, *frames = self.router.recv_multipart()
        assert empty == b""
        return who, frames

    def reply(self, who, frame):
        self.router.send_multipart([who, b"", frame])

    def asked_for_a_snapshot(self, frame):
        who, frames = self.request()
        assert frames == [b"pose/"]
        self.reply(who, frame)

    def answers(self, frame, client, line="^(done|gave up): "):
        """Answers with it until the client has printed the line, however often that asks: one of the two may have had
        no processor for a second, and then it asks again. The lines before its request are looked at first."""
        for _ in range(int(10 * LIMIT)):
            with contextlib.suppress(AssertionError):
                return client.wait_for(line, 0.1)
            if self.router.poll(0):
                self.asked_for_a_snapshot(frame)
        return client.wait_for(line)


@pytest.fixture
def fake(context):
    publisher = FakePublisher(context)
    yield publisher
    publisher.close()


def pose(run, number):
    return f"pose/ {run} {number} {number}.5 -0.25 1234.0625 0.0000 0.7071 0.0000 -0.7071".encode()


def place(number):
    return f"{number}: at {number}.5000 -0.2500 1234.0625"


def wrong_poses(number):
    """They are no poses in any language, though some library of some language takes them."""
    good, digits = pose("one", number).decode(), str(number)
    for odd in (f"1_{digits[1:]}", f"-{digits}", f"+{digits}", "١٢", "9" * 5000, "1e1", ""):
        yield good.replace(f" {digits} ", f" {odd} ", 1)
    for odd in ("nan", "inf", "-Infinity", "1e39", "1_0.5", "٣", "0x1", "\t1", "1,5"):
        yield good.replace("1234.0625", odd)
    yield from ("pose/ hello", "pose/", f"{good} 1")


@pytest.mark.parametrize("kind", CLIENTS)
def test_nothing_lost_and_nothing_twice(kind, fake, follow):
    """Byte for byte as the server's header says; numbers have a point under a German locale, too."""
    words = ("--count", "8", "--every", "1", "--timeout", "30")
    client = follow(kind, fake.endpoint, fake.snapshots, *words, **GERMAN)
    assert fake.stream.recv() == b"\x01pose/"
    fake.stream.send(pose("one", 5))
    # The first request gets lost. REQ drops a reply without the empty frame in front: there is something to receive,
    # and then there is not.
    fake.request()
    who, _ = fake.request()
    fake.router.send_multipart([who, b"no empty frame"])
    who, frames = fake.request()
    assert frames == [b"pose/"]
    # 6 to 8 are on their way when the snapshot, which contains 6, is made.
    for number in (6, 7, 8, 8):
        fake.stream.send(pose("one", number))
    fake.reply(who, b"4000000000 " + pose("one", 6))
    fake.answers(b"4000000000 " + pose("one", 6), client, "^8: at")
    # 9 is lost. That is noticed at once: from then on the stream is never silent for long.
    for last in range(10, 200):
        fake.stream.send(pose("one", last))
        if fake.router.poll(100):
            break
    else:
        pytest.fail("nobody asked for a snapshot")
    fake.answers(b"17 " + pose("one", last), client, f"^{last}: at")
    fake.stream.send(pose("one", last + 1))
    fake.answers(b"17 " + pose("one", last), client, f"^{last + 1}: at")
    # Anything else than a pose is checked against a snapshot, and changes nothing.
    for noise in (
        *([word.encode()] for word in wrong_poses(last + 2)),
        [b"pose/", pose("one", last + 2)],
        [b"pose/ \xff"],
    ):
        fake.stream.send_multipart(noise)
        fake.asked_for_a_snapshot(b"99 " + pose("one", last + 1))
    # The publisher was restarted. A message of its first run comes late.
    checksum, snapshot = 2**32 - 1, b"4294967295 " + pose("two", 4)
    fake.stream.send(pose("two", 3))
    fake.asked_for_a_snapshot(snapshot)
    fake.stream.send(pose("one", last + 2))
    fake.asked_for_a_snapshot(snapshot)
    fake.stream.send(pose("two", 4))
    for number in range(5, 10):
        fake.stream.send(pose("two", number))
        checksum = add(checksum, pose("two", number))
    fake.answers(snapshot, client)
    assert client.wait() == 0, client.output
    assert client.lines == [
        f"following {fake.endpoint}, snapshots from {fake.snapshots}",
        "joined run one at 6, checksum 4000000000",
        *map(place, (6, 7, 8)),
        f"missed 9 to {last}",
        *map(place, (last, last + 1)),
        f"missed run one from {last + 2} on, and run two up to 4",
        *map(place, range(4, 10)),
        f"done: received 8, missed {last - 8 + 4}; run two at 9, checksum {checksum}",
    ]


@pytest.mark.parametrize("kind", TERMINAL)
def test_a_lost_last_message_is_noticed_by_the_silence(kind, fake, follow):
    client = follow(kind, fake.endpoint, fake.snapshots, "--until", "4", "--every", "1", "--timeout", "30")
    fake.stream.recv()
    fake.stream.send(pose("one", 2))
    fake.stream.send(pose("one", 3))
    fake.answers(b"1 " + pose("one", 2), client, JOINED)
    fake.answers(b"1 " + pose("one", 4), client)
    assert client.wait() == 0, client.output
    assert client.lines[-3:] == ["missed 4 to 4", place(4), "done: received 1, missed 1; run one at 4, checksum 1"]


def test_a_stream_that_never_comes_is_said(fake, follow):
    """Such as a firewall that lets only the snapshots through."""
    nowhere = f"tcp://127.0.0.1:{free_port()}"
    clients = [follow(kind, nowhere, fake.snapshots, "--timeout", "30") for kind in TERMINAL]
    for number in while_running(clients):
        if fake.router.poll(50):
            fake.asked_for_a_snapshot(b"1 " + pose("one", number))
    for client in clients:
        assert client.wait() == 1, client.output
        assert client.lines[-1] == f"gave up: no pose came over {nowhere}; is that the publisher, and its port open?"


NO_SNAPSHOTS = [
    b"error: expected Hello",
    b"",
    b"-1 " + pose("one", 1),
    pose("one", 1),
    b"1" * 5000 + b" " + pose("one", 1),
    b"4294967296 " + pose("one", 1),
    "٣ ".encode() + pose("one", 1),
    b"1 " + pose("\x1b[2J\u2028", 1),
    b"\x1b[2J\r\n\a" + b"x" * 60_000,
]


@pytest.mark.parametrize("kind", TERMINAL)
def test_what_is_no_snapshot_ends_the_client_with_one_line(kind, context, runs):
    """Each has a server of its own: a client without a processor asks twice."""
    with contextlib.ExitStack() as stack:
        servers = [answering(context, lambda frames, reply=reply: [reply]) for reply in NO_SNAPSHOTS]
        places = [stack.enter_context(server) for server in servers]
        words = ["--endpoint", f"tcp://127.0.0.1:{free_port()}", "--timeout", "30", "--snapshots"]
        found = runs(kind, KEY, [[*words, place] for place in places])
    for where, (code, lines) in zip(places, found, strict=True):
        assert code == 1, lines
        assert lines[-1].startswith(f"gave up: what answers at {where} gives no snapshots:")
        assert len(lines) == 2
        # Fit for a terminal: of a readable length, and without what would clear the screen.
        assert len(lines[-1]) < 400
        assert lines[-1].isprintable()


def test_a_publisher_that_repeats_itself_holds_nobody(fake, follow):
    """Such as a frozen robot that sends its last pose again and again."""
    # On a busy machine two seconds may be over before it has begun.
    for limit in ("2", "40"):
        words = [fake.endpoint, fake.snapshots, "--seconds", limit, "--count", "9", *PATIENT]
        clients = [follow(kind, *words) for kind in TERMINAL]
        for number in while_running(clients):
            fake.stream.send(pose("one", 4 + number % 2))
            if fake.router.poll(10):
                fake.asked_for_a_snapshot(b"7 " + pose("one", 5))
        assert [client.wait() for client in clients] == [0, 0]
        if all(len(client.lines) > 2 for client in clients):
            break
    assert {client.lines[-1] for client in clients} == {"done: received 0, missed 0; run one at 5, checksum 7"}


# The server by itself


BAD_REQUESTS = [[b""], [b"pose"], [b"pose/", b"pose/"], [b"\xff\xfe"], [b"x" * 900], [b"", b""]]


def test_the_bytes_of_the_stream_and_of_a_snapshot(publish, context, connect):
    """From one snapshot, with the stream, to exactly what the next snapshot says."""
    place = two_ports()
    server, endpoint, snapshots = publish("--interval", "0.005", endpoint=place, **GERMAN)
    host, port = place.rsplit(":", 1)
    assert (endpoint, snapshots) == (place, f"{host}:{int(port) + 100}")
    for frames in BAD_REQUESTS:
        assert ask(context, snapshots, *frames)[0].startswith(b"error: expected pose/")
    stream, rude = connect(endpoint, zmq.SUB, ""), connect(snapshots)
    assert stream.poll(100_000)
    checksum, at = snapshot_of(*ask(context, snapshots, b"pose/"))
    # REP drops a request without the empty frame in front: there is something to receive, and then there is not.
    for _ in range(3):
        rude.send(b"no empty frame in front")
    last, target, runs, ahead = 0, None, set(), None
    while not target or last < target[1]:
        (frame,) = stream.recv_multipart()
        topic, run, number, body = frame.decode().split(" ", 3)
        assert (topic, int(number)) == ("pose/", last + 1 if last else int(number))
        last = int(number)
        runs.add(run)
        ahead = on_the_circle(body, ahead)
        if last > at:
            checksum = add(checksum, frame)
        if last == at + 100:
            target = snapshot_of(*ask(context, snapshots, b"pose/"))
    assert (checksum, len(runs)) == (target[0], 1)
    assert server.stop() == 0


def test_where_100_higher_is_no_port_it_says_so(runs):
    for kind in ("server", *TERMINAL):
        ((code, lines),) = runs(kind, KEY, [["--endpoint", "tcp://127.0.0.1:65500"]])
        assert code == 2, kind
        assert "bad endpoint 'tcp://127.0.0.1:65600'" in lines[-1]
