"""Lesson 07: the exact state after joining late, loss and a restart; and all that goes wrong."""

from __future__ import annotations

import contextlib
import re
import signal
import sys
import threading
import time

import pytest
import zmq

from netmq_example.errors import GaveUp
from netmq_example.pose_stream import PoseSubscriber, snapshots_beside
from tests.bad_peers import SlowLine
from tests.conftest import CLIENTS, PYTHON
from tests.programs import LIMIT, ROOT, free_port, steady_endpoint, two_ports

KEY = "07_catch_up"
GERMAN = {"LANG": "de_DE.UTF-8", "LC_ALL": "de_DE.UTF-8"}
TERMINAL = ["python", "csharp"]
JOINED = r"^joined run (\w+) at (\d+), checksum (\d+)$"
DONE = r"^done: received (\d+), missed (\d+); run (\w+) at (\d+), checksum (\d+)$"


@pytest.fixture
def publish(serve):
    """Starts the server: the program, the stream's endpoint and the snapshots'."""

    def publish(*options, **where):
        server, endpoint = serve(KEY, *options, **where)
        return server, endpoint, server.wait_for(r"^snapshots on (\S+)")[1]

    return publish


@pytest.fixture
def follow(start, client_command):
    """Starts a client against both endpoints."""

    def follow(kind, endpoint, snapshots, *options, **environment):
        return start(*client_command(kind, KEY, endpoint, "--snapshots", snapshots, *options), **environment)

    return follow


def numbers(client, pattern):
    """All matches of the pattern in the client's lines, each as a list of its whole numbers."""
    found = (re.search(pattern, line) for line in client.lines)
    return [[int(word) for word in match.groups() if word.isdecimal()] for match in found if match]


def request(context, endpoint, *frames):
    with context.socket(zmq.REQ) as asker:
        asker.linger = 0
        asker.connect(endpoint)
        asker.send_multipart(frames)
        assert asker.poll(100_000), f"no reply to {frames!r:.80}"
        (reply,) = asker.recv_multipart()
        return reply


def add(checksum, message):
    return (31 * checksum + sum(message)) % 2**32


# With the real server


@pytest.mark.parametrize("kind", CLIENTS)
def test_following(kind, publish, follow):
    server, endpoint, snapshots = publish("--interval", "0.002")
    client = follow(kind, endpoint, snapshots, "--count", "120")
    assert client.wait() == 0, client.output
    assert client.lines[0] == f"following {endpoint}, snapshots from {snapshots}"
    run, joined, checksum = re.search(JOINED, client.lines[1]).groups()
    server.wait_for(f"^snapshot at {joined}, checksum {checksum}$")
    # On a busy machine a second may pass without a pose, and the snapshot that is asked for then skips some.
    gaps = numbers(client, r"^missed (\d+) to (\d+)$")
    missed = sum(last - first + 1 for first, last in gaps)
    begin, end = int(joined), int(joined) + 120 + missed
    places = numbers(client, r"^(\d+): at -?[0-2]\.\d{4} 0\.0000 -?[0-2]\.\d{4}$")
    assert gaps or places == [[begin], [begin + 60], [end]]
    assert re.fullmatch(rf"done: received 120, missed {missed}; run {run} at {end}, checksum \d+", client.lines[-1])
    assert len(client.lines) == 3 + len(gaps) + len(places)


@pytest.mark.parametrize("frozen", [False, True], ids=["", "frozen meanwhile"])
@pytest.mark.parametrize("kind", TERMINAL)
def test_joining_late_and_losing_messages_the_state_is_exact(kind, frozen, publish, start, client_command):
    """Frozen, a subscriber takes nothing until the queues are full, and the publisher drops what does not fit."""
    if frozen and sys.platform == "win32":
        pytest.skip("Windows has no signals to freeze a program with")
    total, endpoint = 400_000 if frozen else 30_000, two_ports()
    # The client is there before the publisher begins: on a busy machine all may be said before it has started.
    words = ("--count", str(total), "--until", str(total), "--every", "1000", "--timeout", "60", "--seconds", "500")
    client = start(*client_command(kind, KEY, endpoint, *words))
    client.wait_for("^following")
    interval = "0.00003" if frozen else "0.0003"
    server, _, _ = publish("--interval", interval, "--count", str(total), endpoint=endpoint)
    joined = int(client.wait_for(JOINED)[2])
    assert 0 < joined < total, "the client did not join in the middle"
    if frozen:
        # Not before the stream has come: after the line about the pose of the snapshot there is another one.
        client.wait_for(r"^\d+: at ", start=3)
        client.process.send_signal(signal.SIGSTOP)
    published = server.wait_for(rf"^published {total}, checksum (\d+)", 250)[1]
    if frozen:
        client.process.send_signal(signal.SIGCONT)
    assert client.wait() == 0, client.output
    received, missed, _, last, checksum = client.wait_for(DONE).groups()
    gaps = numbers(client, r"^missed (\d+) to (\d+)$")
    # Who joins late has so little left to miss that the queues hold it.
    assert gaps or not frozen or total - joined < 200_000
    assert sum(last - first + 1 for first, last in gaps) == int(missed)
    assert int(received) + int(missed) == int(last) - joined == total - joined
    assert checksum == published


@pytest.mark.parametrize("kind", CLIENTS)
def test_after_a_restart_the_subscriber_goes_on_and_says_what_it_missed(kind, publish, follow):
    # So slow that a client which takes half a minute to start still comes before number 1500.
    first, endpoint, snapshots = publish("--interval", "0.02")
    options = ["--count", "1000000", "--until", "1500", "--every", "30", "--timeout", "20"]
    client = follow(kind, endpoint, snapshots, *options)
    run = client.wait_for(JOINED)[1]
    client.wait_for(r"^\d+: at ", start=3)
    first.kill()
    second, _, _ = publish("--interval", "0.003", "--count", "1500", "--snapshots", snapshots, endpoint=endpoint)
    said = client.wait_for(rf"^missed run {run} from (\d+) on, and run (\w+) up to (\d+)$")
    assert said[2] != run
    assert client.wait() == 0, client.output
    received, missed, last_run, last, checksum = client.wait_for(DONE).groups()
    assert (last_run, last) == (said[2], "1500")
    assert second.wait_for(r"^published 1500, checksum (\d+)")[1] == checksum
    # Each number of both runs was either received or missed, and none was both.
    joined = int(client.wait_for(JOINED)[2])
    within = sum(last - first + 1 for first, last in numbers(client, r"^missed (\d+) to (\d+)$"))
    assert int(missed) == int(said[3]) + within
    assert int(received) + within == int(said[1]) - 1 - joined + 1500 - int(said[3])


@pytest.mark.parametrize("kind", CLIENTS)
def test_who_comes_when_all_is_said_has_the_state_too(kind, publish, follow):
    server, endpoint, snapshots = publish("--interval", "0", "--count", "1000")
    checksum = server.wait_for(r"^published 1000, checksum (\d+)")[1]
    client = follow(kind, endpoint, snapshots, "--until", "1000")
    assert client.wait() == 0, client.output
    run = client.wait_for(JOINED)[1]
    assert client.lines[-1] == f"done: received 0, missed 0; run {run} at 1000, checksum {checksum}"


# With a publisher of the test's own, which decides on every message


class FakePublisher:
    """An XPUB, which sees subscriptions come, and a ROUTER, which answers a request when the test says so."""

    def __init__(self, context):
        self.stream, self.router = context.socket(zmq.XPUB), context.socket(zmq.ROUTER)
        for end in (self.stream, self.router):
            end.linger = 0
        self.endpoint = f"tcp://127.0.0.1:{self.stream.bind_to_random_port('tcp://127.0.0.1')}"
        self.snapshots = f"tcp://127.0.0.1:{self.router.bind_to_random_port('tcp://127.0.0.1')}"

    def close(self):
        self.stream.close()
        self.router.close()

    def subscribed(self):
        assert self.stream.poll(100_000), "nobody subscribed"
        return self.stream.recv()

    def request(self):
        """The next request: who asks, and what."""
        assert self.router.poll(100_000), "nobody asked for a snapshot"
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
        no processor for a second, and then it asks again. What was printed before it asked is looked at first."""
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


@pytest.mark.parametrize("environment", [{}, GERMAN], ids=["", "german"])
@pytest.mark.parametrize("kind", CLIENTS)
def test_nothing_lost_and_nothing_twice(kind, environment, fake, follow):
    """Byte for byte as the server's header says; numbers have a point under a German locale, too."""
    words = ("--count", "4", "--every", "1", "--timeout", "30")
    client = follow(kind, fake.endpoint, fake.snapshots, *words, **environment)
    assert fake.subscribed() == b"\x01pose/"
    fake.stream.send(pose("one", 5))
    who, frames = fake.request()
    assert frames == [b"pose/"]
    # 6 to 8 are on their way when the snapshot, which contains 6, is made.
    for number in (6, 7, 8, 8):
        fake.stream.send(pose("one", number))
    fake.reply(who, b"4000000000 " + pose("one", 6))
    fake.answers(b"4000000000 " + pose("one", 6), client, "^8: at")
    # 9 is lost.
    fake.stream.send(pose("one", 10))
    fake.stream.send(pose("one", 11))
    fake.answers(b"17 " + pose("one", 10), client, "^11: at")
    # What is no pose is checked against a snapshot, and changes nothing.
    for noise in (
        [b"pose/ hello"],
        [b"pose/", pose("one", 12)],
        [b"pose/ \xff"],
        [pose("one", 12) + b" 1"],
        [b"pose/"],
    ):
        fake.stream.send_multipart(noise)
        fake.asked_for_a_snapshot(b"99 " + pose("one", 11))
    # The publisher was restarted. A message of its first run comes late.
    fake.stream.send(pose("two", 3))
    fake.asked_for_a_snapshot(b"0 " + pose("two", 4))
    fake.stream.send(pose("one", 12))
    fake.asked_for_a_snapshot(b"0 " + pose("two", 4))
    fake.stream.send(pose("two", 4))
    fake.stream.send(pose("two", 5))
    fake.answers(b"0 " + pose("two", 4), client)
    assert client.wait() == 0, client.output
    assert client.lines == [
        f"following {fake.endpoint}, snapshots from {fake.snapshots}",
        "joined run one at 6, checksum 4000000000",
        place(6),
        place(7),
        place(8),
        "missed 9 to 10",
        place(10),
        place(11),
        "missed run one from 12 on, and run two up to 4",
        place(4),
        place(5),
        f"done: received 4, missed 6; run two at 5, checksum {add(0, pose('two', 5))}",
    ]


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_gap_is_noticed_at_once_and_not_by_silence(kind, fake, follow):
    client = follow(kind, fake.endpoint, fake.snapshots, "--count", "1", "--every", "0", "--timeout", "30")
    fake.subscribed()
    fake.stream.send(pose("one", 1))
    fake.answers(b"0 " + pose("one", 1), client, JOINED)
    # 2 is lost, and from then on the stream is never silent for long.
    for number in range(3, 200):
        fake.stream.send(pose("one", number))
        if fake.router.poll(100):
            break
    else:
        pytest.fail("nobody asked for a snapshot")
    fake.answers(b"0 " + pose("one", number), client, f"^missed 2 to {number}$")
    fake.stream.send(pose("one", number + 1))
    fake.answers(b"0 " + pose("one", number), client)
    assert client.wait() == 0, client.output


@pytest.mark.parametrize("kind", CLIENTS)
def test_every_message_counts_in_the_checksum(kind, fake, follow):
    client = follow(kind, fake.endpoint, fake.snapshots, "--count", "20", "--every", "0", "--timeout", "30")
    fake.subscribed()
    fake.stream.send(pose("one", 1))
    checksum = 4294967295
    for number in range(2, 22):
        fake.stream.send(pose("one", number))
        checksum = add(checksum, pose("one", number))
    fake.answers(b"4294967295 " + pose("one", 1), client)
    assert client.wait() == 0, client.output
    assert client.lines[-1] == f"done: received 20, missed 0; run one at 21, checksum {checksum}"


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_lost_last_message_is_noticed_by_the_silence(kind, fake, follow):
    client = follow(kind, fake.endpoint, fake.snapshots, "--until", "4", "--timeout", "30")
    fake.subscribed()
    fake.stream.send(pose("one", 2))
    fake.stream.send(pose("one", 3))
    fake.answers(b"1 " + pose("one", 2), client, JOINED)
    fake.answers(b"1 " + pose("one", 4), client)
    assert client.wait() == 0, client.output
    assert client.lines[-2:] == ["missed 4 to 4", "done: received 1, missed 1; run one at 4, checksum 1"]


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_request_that_got_lost_is_asked_again(kind, fake, follow):
    client = follow(kind, fake.endpoint, fake.snapshots, "--until", "2", "--timeout", "30")
    fake.subscribed()
    fake.request()
    fake.answers(b"1 " + pose("one", 2), client)
    assert client.wait() == 0, client.output
    assert client.lines[-1] == "done: received 0, missed 0; run one at 2, checksum 1"


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_stream_that_never_comes_is_said(kind, fake, follow):
    """Such as a firewall that lets only the snapshots through."""
    nowhere = f"tcp://127.0.0.1:{free_port()}"
    client = follow(kind, nowhere, fake.snapshots, "--timeout", "30")
    number, deadline = 0, time.monotonic() + LIMIT
    while client.process.poll() is None and time.monotonic() < deadline:
        if fake.router.poll(50):
            number += 1
            fake.asked_for_a_snapshot(b"1 " + pose("one", number))
    assert client.wait() == 1, client.output
    assert client.lines[-1] == f"gave up: no pose came over {nowhere}; is that the publisher, and its port open?"


@pytest.mark.parametrize("kind", TERMINAL)
@pytest.mark.parametrize(
    "answer",
    [
        b"error: expected Hello",
        b"",
        b"\xff\xfe",
        b"-1 " + pose("one", 1),
        pose("one", 1),
        b"1" * 5000 + b" " + pose("one", 1),
        b"4294967296 " + pose("one", 1),
        "٣ ".encode() + pose("one", 1),
        b"1 " + pose("\x1b[2J\u2028", 1),
        b"\x1b[2J\r\n\a" + b"x" * 60_000,
    ],
    ids=lambda answer: repr(answer)[:20],
)
def test_what_is_no_snapshot_ends_the_client_with_one_line(kind, answer, fake, follow):
    client = follow(kind, fake.endpoint, fake.snapshots, "--timeout", "30")
    fake.answers(answer, client)
    assert client.wait() == 1, client.output
    assert client.lines[-1].startswith(f"gave up: what answers at {fake.snapshots} gives no snapshots: ")
    assert len(client.lines) == 2
    # Fit for a terminal: of a readable length, and without what would clear the screen.
    assert len(client.lines[-1]) < 400
    assert client.lines[-1].isprintable()


def wrong_poses(number):
    """They are no poses in any language, though some library of some language takes them."""
    good, digits = pose("one", number).decode(), str(number)
    for odd in (f"1_{digits[1:]}", f"-{digits}", f"+{digits}", "١٢", "9" * 5000, "1e1", ""):
        yield good.replace(f" {digits} ", f" {odd} ", 1)
    for odd in ("nan", "inf", "-Infinity", "1e39", "1_0.5", "٣", "0x1", "\t1", "1,5"):
        yield good.replace("1234.0625", odd)


@pytest.mark.parametrize("kind", CLIENTS)
def test_only_plain_numbers_are_numbers(kind, fake, follow):
    client = follow(kind, fake.endpoint, fake.snapshots, "--count", "1", "--every", "1", "--timeout", "30")
    fake.subscribed()
    fake.stream.send(pose("one", 11))
    fake.answers(b"7 " + pose("one", 11), client, JOINED)
    for noise in wrong_poses(12):
        fake.stream.send(noise.encode())
        fake.asked_for_a_snapshot(b"7 " + pose("one", 11))
    fake.stream.send(pose("one", 12))
    fake.answers(b"7 " + pose("one", 11), client)
    assert client.wait() == 0, client.output
    assert client.lines[1:] == [
        "joined run one at 11, checksum 7",
        place(11),
        place(12),
        f"done: received 1, missed 0; run one at 12, checksum {add(7, pose('one', 12))}",
    ]


@pytest.mark.parametrize("kind", CLIENTS)
@pytest.mark.parametrize("number", [5, 4], ids=["the same", "a lower one"])
def test_a_publisher_that_repeats_itself_holds_nobody(kind, number, fake, follow):
    """Such as a frozen robot that sends its last pose again and again."""
    client = follow(kind, fake.endpoint, fake.snapshots, "--seconds", "3", "--count", "9", "--timeout", "30")
    fake.subscribed()
    deadline = time.monotonic() + LIMIT
    while client.process.poll() is None and time.monotonic() < deadline:
        fake.stream.send(pose("one", number))
        if fake.router.poll(5):
            fake.asked_for_a_snapshot(b"7 " + pose("one", 5))
    assert client.wait() == 0, client.output
    assert client.lines[-1] == "done: received 0, missed 0; run one at 5, checksum 7"


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_broken_reply_is_waited_for_no_longer_than_another(kind, fake, follow):
    """REQ drops a reply without the empty frame in front: there is something to receive, and then there is not."""
    client = follow(kind, fake.endpoint, fake.snapshots, "--timeout", "20")
    fake.subscribed()
    who, _ = fake.request()
    fake.router.send_multipart([who, b"no empty frame"])
    assert client.wait() == 1, client.output
    assert client.lines[-1].startswith(f"gave up: no snapshot from {fake.snapshots} within 20 s")


@pytest.mark.parametrize("kind", CLIENTS)
def test_the_wrong_server_first_and_then_the_right_one(kind, publish, serve, follow):
    """After a peer that is no publisher, libzmq never connects again by itself."""
    endpoint, snapshots = (steady_endpoint() for _ in range(2))
    wrong = [serve("01_request_reply", endpoint=where)[0] for where in (endpoint, snapshots)]
    client = follow(kind, endpoint, snapshots, "--count", "50", "--until", "0", "--timeout", "25", "--every", "0")
    client.wait_for("^following")
    # Lesson 01's server answers whoever asks it for a snapshot, and the client says so and ends. So it gets no answer.
    for server in wrong[1:]:
        server.kill()
    time.sleep(0.5)
    wrong[0].kill()
    publish("--interval", "0.005", "--snapshots", snapshots, endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert client.wait_for(DONE)[1] == "50"


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_far_publisher_is_followed(kind, publish, follow):
    """With a round trip of 400 ms, and the timeout that the client has when nobody sets it."""
    _, endpoint, snapshots = publish()
    with SlowLine(endpoint, 0.4) as far, SlowLine(snapshots, 0.4) as far_snapshots:
        client = follow(kind, far.endpoint, far_snapshots.endpoint, "--count", "30")
        assert client.wait() == 0, client.output
    assert client.wait_for(DONE)[1] == "30"


# The server by itself


def snapshot_of(reply):
    """Checksum and number."""
    checksum, _, _, number = reply.split(b" ")[:4]
    return int(checksum), int(number)


def test_the_bytes_of_the_stream_and_of_a_snapshot(publish, context):
    """From one snapshot, with the stream, to exactly what the next snapshot says."""
    _, endpoint, snapshots = publish("--interval", "0.002", **GERMAN)
    with context.socket(zmq.SUB) as stream:
        stream.linger = 0
        stream.subscribe("")
        stream.connect(endpoint)
        assert stream.poll(100_000)
        checksum, at = snapshot_of(request(context, snapshots, b"pose/"))
        last, target, runs = 0, None, set()
        while not target or last < target[1]:
            assert stream.poll(100_000)
            (frame,) = stream.recv_multipart()
            topic, run, number, body = frame.decode().split(" ", 3)
            assert (topic, int(number)) == ("pose/", last + 1 if last else int(number))
            last = int(number)
            runs.add(run)
            assert re.fullmatch(r"(-?\d\.\d{4} ){6}-?\d\.\d{4}", body), body
            x, y, z, *turn = map(float, body.split(" "))
            assert (x * x + z * z, y) == (pytest.approx(4, abs=0.01), 0)
            assert sum(value * value for value in turn) == pytest.approx(1, abs=0.001)
            if last > at:
                checksum = add(checksum, frame)
            if last == at + 100:
                target = snapshot_of(request(context, snapshots, b"pose/"))
        assert (checksum, len(runs)) == (target[0], 1)


def test_facing_forward(context, publish):
    """Unity's forward, (0, 0, 1) turned by the rotation, points to where the next pose is."""
    poses = []
    for count in ("1", "2"):
        server, _, snapshots = publish("--interval", "0", "--count", count)
        server.wait_for("^published")
        poses.append([float(word) for word in request(context, snapshots, b"pose/").split(b" ")[4:]])
    (x, _, z, qx, qy, qz, qw), (next_x, _, next_z, *_) = poses
    forward = 2 * (qx * qz + qw * qy), 1 - 2 * (qx * qx + qy * qy)
    assert (x + forward[0] / 30, z + forward[1] / 30) == pytest.approx((next_x, next_z), abs=0.001)


@pytest.mark.parametrize("frames", [[b""], [b"pose"], [b"pose/", b"pose/"], [b"\xff\xfe"], [b"x" * 900], [b"", b""]])
def test_a_bad_request_gets_an_error_and_the_next_one_a_snapshot(frames, publish, context):
    server, _, snapshots = publish()
    assert request(context, snapshots, *frames).startswith(b"error: expected pose/")
    assert re.match(rb"\d+ pose/ \w+ \d+ ", request(context, snapshots, b"pose/"))
    assert server.stop() == 0


def test_a_broken_request_does_not_hold_the_stream(publish, context):
    """REP drops a request without the empty frame in front: there is something to receive, and then there is not."""
    server, endpoint, snapshots = publish("--interval", "0.002")
    with context.socket(zmq.SUB) as stream, context.socket(zmq.DEALER) as rude:
        stream.linger = rude.linger = 0
        stream.subscribe("pose/")
        stream.connect(endpoint)
        assert stream.poll(100_000)
        rude.connect(snapshots)
        for _ in range(3):
            rude.send(b"no empty frame in front")
        # Those that wait here were sent before; a second of poses was not.
        for _ in range(1200):
            assert stream.poll(10_000), "the publisher is held"
            stream.recv()
    assert server.stop() == 0


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to end a program with")
def test_a_server_that_never_waits_ends_at_once(how, publish):
    server, _, _ = publish("--interval", "0")
    assert server.stop(how, limit=30) == 0
    assert "Traceback" not in server.output


def test_where_100_higher_is_no_port_it_says_so(start):
    server = start(PYTHON, ROOT / "python" / KEY / "server.py", "--endpoint", "tcp://127.0.0.1:65500")
    assert server.wait() == 2, server.output
    assert "bad endpoint 'tcp://127.0.0.1:65600'" in server.lines[-1]


def test_a_client_whose_snapshots_are_at_no_port_says_so(start):
    client = start(PYTHON, ROOT / "python" / KEY / "client.py", "--endpoint", "tcp://127.0.0.1:65500")
    assert client.wait() == 2, client.output
    assert "bad endpoint 'tcp://127.0.0.1:65600'" in client.lines[-1]


@pytest.mark.parametrize("kind", CLIENTS)
def test_no_pose_at_all_may_be_asked_for(kind, publish, follow):
    _, endpoint, snapshots = publish()
    client = follow(kind, endpoint, snapshots, "--count", "0")
    assert client.wait() == 0, client.output
    assert client.lines[-1].startswith("done: received 0, missed 0; ")


def test_without_its_own_option_the_snapshots_are_100_higher(serve):
    place = two_ports()
    server, endpoint = serve(KEY, endpoint=place)
    assert endpoint == place
    host, port = place.rsplit(":", 1)
    assert server.wait_for(r"^snapshots on (\S+)")[1] == f"{host}:{int(port) + 100}"


# The class, without a program around it

WRONG = {
    "stream": lambda stream, where: PoseSubscriber(None, where),
    "report": lambda stream, where: PoseSubscriber(stream, where, report=0),
    "bad endpoint ''": lambda stream, where: PoseSubscriber(stream, ""),
    "bad endpoint 'None'": lambda stream, where: PoseSubscriber(stream, None),
    "bad endpoint '-1'": lambda stream, where: PoseSubscriber(stream, where, -1),
    "bad endpoint 'tcp://127.0.0.1:65600'": lambda stream, where: PoseSubscriber(stream, "tcp://127.0.0.1:65500"),
    "bad endpoint 'tcp://127.0.0.1'": lambda stream, where: snapshots_beside("tcp://127.0.0.1"),
    **{
        f"timeout takes seconds, .* not {timeout!r}": lambda stream, where, timeout=timeout: PoseSubscriber(
            stream, where
        ).receive(timeout)
        for timeout in (0, -1, None, float("nan"), "5")
    },
}


@pytest.mark.parametrize(("says", "call"), WRONG.items(), ids=WRONG)
def test_what_a_subscriber_cannot_use_is_named(says, call, context):
    with context.socket(zmq.SUB) as stream, pytest.raises((ValueError, TypeError), match=says) as refusal:
        call(stream, "tcp://127.0.0.1:5557")
    assert "\n" not in str(refusal.value)


def test_a_socket_that_cannot_subscribe_is_named(context):
    with context.socket(zmq.REQ) as socket, pytest.raises(ValueError, match="stream takes a SUB socket"):
        PoseSubscriber(socket, "tcp://127.0.0.1:5557")


def test_what_is_no_publisher_is_no_timeout(context):
    """Two exceptions: nothing came in time, and what came is no snapshot."""
    with context.socket(zmq.SUB) as stream, context.socket(zmq.ROUTER) as router:
        router.linger = 0
        endpoint = f"tcp://127.0.0.1:{router.bind_to_random_port('tcp://127.0.0.1')}"
        subscriber = PoseSubscriber(stream, endpoint, endpoint)
        with pytest.raises(TimeoutError, match="no snapshot from"):
            subscriber.receive(0.1)
        who, *_ = router.recv_multipart()
        thread = threading.Thread(target=answer_wrongly, args=(router, who))
        thread.start()
        with pytest.raises(GaveUp, match="gives no snapshots"):
            subscriber.receive(100)
        thread.join()


def answer_wrongly(router, before):
    """Also after a subscription has come."""
    while True:
        who, *rest = router.recv_multipart()
        if rest[-1:] == [b"pose/"] and who != before:
            return router.send_multipart([who, b"", b"Hello"])
