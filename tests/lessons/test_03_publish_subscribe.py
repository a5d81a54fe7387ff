"""Lesson 03: topics, the newest only, and a publisher that is far, wrong at first, or sends what is no pose."""

import re
import time

import pytest
import zmq

from netmq_example.topic_listener import TopicListener
from tests.conftest import CLIENTS
from tests.lessons.conftest import on_the_circle, where
from tests.programs import LIMIT, MovingName

KEY = "03_publish_subscribe"
GERMAN = {"LANG": "de_DE.UTF-8", "LC_ALL": "de_DE.UTF-8"}
# In this order: C# may have to be built first, and the other one would give up meanwhile.
TERMINAL = ["csharp", "python"]


@pytest.mark.parametrize("kind", CLIENTS)
def test_listening_from_some_message_on_with_german_numbers(kind, serve, start_client):
    """The slow joiner: what was sent before the publisher knew of the listener is lost, and after that nothing is."""
    _, endpoint = serve(KEY, "--interval", "0.005", **GERMAN)
    client = start_client(kind, KEY, endpoint, "--count", "121", **GERMAN)
    assert client.wait() == 0, client.output
    assert client.lines[0] == f"listening to 'pose/' from {endpoint}"
    assert client.lines[-1] == "done: received 121"
    heard = [re.fullmatch(r"received pose/ (\d+)( -?\d\.\d{4}){7}", line) for line in client.lines[1:-1]]
    assert all(heard), client.output
    first, *_, last = (int(match[1]) for match in heard)
    assert len(heard) == 3
    # Unity takes the newest, which on a busy machine skips some.
    assert last - first == 120 or (kind == "unity" and last - first > 120)


@pytest.mark.parametrize("kind", TERMINAL)
def test_a_topic_is_a_prefix_and_a_delimiter_cures_it(kind, serve, run):
    _, endpoint = serve(KEY, "--interval", "0.001")
    heard = {}
    for topic in "news", "news/":
        client = run(kind, KEY, "--endpoint", endpoint, "--count", "8", "--every", "1", "--topic", topic)
        assert client.code == 0, client
        assert client.lines[0] == f"listening to '{topic}' from {endpoint}"
        heard[topic] = {line.split()[1] for line in client.lines[1:-1]}
    assert heard == {"news": {"news/", "newsflash/"}, "news/": {"news/"}}


# With a publisher of the test's own, which decides on every message


def test_a_high_watermark_is_that_of_the_socket(context):
    """The limits of a listener leave it alone, also that of a socket of the user's own."""
    endpoint = "tcp://127.0.0.1:9"
    with TopicListener(endpoint, high_watermark=7, context=context) as listener:
        assert listener.socket.rcvhwm == 7
    with context.socket(zmq.SUB) as socket:
        socket.rcvhwm = 3
        with TopicListener(endpoint, socket=socket):
            assert socket.rcvhwm == 3


def test_newest_only(fake, start_client):
    """While each listener works on 1, the others arrive; it then takes the last of them."""
    # Each one's subscription is shown.
    fake.xpub_verbose = True
    words = [where(fake), "--count", "2", "--every", "1", "--work", "3"]
    how = ("csharp", "--newest"), ("python", "--newest"), ("python", "--conflate")
    clients = [start_client(kind, KEY, *words, option) for kind, option in how]
    assert [fake.recv() for _ in clients] == [b"\x01pose/"] * 3
    fake.send(b"pose/ 1")
    for client in clients:
        client.wait_for("^received pose/ 1$")
    for number in range(2, 501):
        fake.send(b"pose/ %d" % number)
    for client in clients:
        assert client.wait() == 0, client.output
        assert client.lines[1:] == ["received pose/ 1", "received pose/ 500", "done: received 2"]


def test_a_publisher_that_is_only_slow_keeps_its_listener(fake, start, client_command, tmp_path):
    name = MovingName(tmp_path, "127.0.0.1")
    endpoint = where(fake).replace("127.0.0.1", "robot")
    client = start(*name.before, *client_command("csharp", KEY, endpoint, "--count", "2", "--timeout", str(LIMIT)))
    fake.recv()
    fake.send(b"pose/ 1")
    client.wait_for("^received pose/ 1$")
    # It looks the name up after 2 s, and then once more.
    assert not fake.poll(6000), "it has made another connection"
    fake.send(b"pose/ 2")
    assert client.wait() == 0, client.output


def test_a_listener_prints_all_frames_in_one_line_and_takes_nothing_endless(fake, start_client):
    fake.xpub_verbose = True
    words = [where(fake), "--topic", "", "--count", "2", "--every", "1", "--timeout", "25"]
    clients = [start_client(kind, KEY, *words, *mode) for kind in TERMINAL for mode in ([], ["--newest"])]
    for _ in clients:
        fake.recv()
    fake.send(b"x" * 100_000)
    # ZeroMQ closes the connections for it. Each listener makes another.
    deadline = time.monotonic() + LIMIT
    while any(client.process.poll() is None for client in clients) and time.monotonic() < deadline:
        fake.send_multipart(["\x1b[2Jgrün ✓\n\xad\x85".encode(), b'{"n": 1}', b"\xff\xd8\xff", b"y" * 1000])
        time.sleep(0.01)
    text = f'?[2Jgrün ✓??? {{"n": 1}} (3 bytes) {"y" * 1000}'
    line = f"received {text[:200]}…"
    for client in clients:
        assert client.wait() == 0, client.output
        assert client.lines[1:] == [line, line, "done: received 2"]


def test_in_unity_what_is_no_pose_moves_nothing(fake, start_client):
    client = start_client("unity", KEY, where(fake), "--count", "8", "--every", "1")
    fake.recv()
    numbers = ["1", "2", "3", "0", "0", "0", "1"]
    for number, odd in enumerate(("nan", "1e99", "1,5", "x", "", "1 1", "1"), start=1):
        message = " ".join(["pose/", str(number), odd, *numbers[1:]])
        fake.send_string(message)
        said = "" if odd == "1" else ": no pose, which has a number and 7 decimals"
        client.wait_for(f"^received {re.escape(message)}{said}$")
    fake.send_multipart([b"pose/", b"8 1 2 3 0 0 0 1"])
    assert client.wait() == 0, client.output
    assert client.lines[-2:] == ["received pose/ 8 1 2 3 0 0 0 1", "done: received 8"]


# The server by itself


def test_the_bytes_of_the_stream(serve, connect):
    server, endpoint = serve(KEY, "--interval", "0.002", **GERMAN)
    stream = connect(endpoint, zmq.SUB, "")
    topics, ahead, last = set(), None, 0
    while not topics >= {"pose/", "news/", "newsflash/"}:
        (frame,) = stream.recv_multipart()
        topic, number, body = frame.decode().split(" ", 2)
        topics.add(topic)
        if topic == "pose/":
            assert int(number) == last + 1 or not last, "numbers follow one another"
            ahead, last = on_the_circle(body, ahead), int(number)
    assert server.stop() == 0
