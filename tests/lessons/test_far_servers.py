"""Servers that are far, break ZeroMQ's protocol, are another's or move are no trouble: tests/bad_peers.py has the
first two.

The far one is behind a line with a round trip of 600 ms, of which a new connection takes four or more.
"""

import contextlib
import signal
import time

import pytest

from netmq_example.messages import Message
from tests.bad_peers import ProtocolBreaker, SlowLine
from tests.lessons.uses import USES
from tests.programs import MovingName, places, steady_port, two_ports

ROUND_TRIP = 0.6
# In this order: C# may have to be built first, and the other one would give up meanwhile.
BOTH = ["csharp", "python"]
# A client's words, and the line by which it has been answered. Lessons 10 and 11 have the client of 09, and 21 that of
# 14.
CASES = {
    "02_lazy_pirate": (["--tries", "20"], "^1: sent add 1, received [12]$"),
    "03_publish_subscribe": (["--every", "1"], "^received pose/"),
    "04_background_client": ([], "^1: sent hello, received world$"),
    "07_catch_up": (["--every", "1"], "^[0-9]+: at "),
    "08_see_and_steer": (["--every", "1"], "^frame [0-9]+: age"),
    "09_environment": ([], "^simulating .* for "),
    "12_video": (["--count", "0"], " can film "),
    "13_side_channels": (["--timeout", "20"], "^[0-9]+: mass "),
    "14_long_jobs": ([], "^job .*: (accepted|[0-9]+ of )"),
    "17_many_machines": ([], "^simulating .* for "),
}


# The servers of 09 and 12 have one game at a time.
ALONE = ["09_environment", "12_video"]


@pytest.mark.parametrize(
    ("key", "kinds"),
    [*((key, BOTH) for key in CASES if key not in ALONE), *((key, [kind]) for key in ALONE for kind in BOTH)],
)
def test_a_far_server_is_reached(key, kinds, serve, start_client):
    words, answered = CASES[key]
    server, _ = serve(key)
    with contextlib.ExitStack() as stack:
        far = {name: stack.enter_context(SlowLine(place, ROUND_TRIP)) for name, place in places(server).items()}
        others = [word for name, line in far.items() if name != "listening" for word in (f"--{name}", line.endpoint)]
        for client in [start_client(kind, key, far["listening"].endpoint, *others, *words) for kind in kinds]:
            client.wait_for(answered)


# A server's answer before it breaks the protocol, and the client's line about that.
BROKEN = {
    "01_request_reply": (lambda frames: [b"World"], "1: sent Hello, received World"),
    "02_lazy_pirate": (lambda frames: [frames[0], b"1"], "1: sent add 1, received 1"),
    "05_messages": (
        lambda frames: Message("ok", 1, {"a": 1}).frames(),
        "1: sent frame 1, 230400 bytes; brightest at a 1",
    ),
}


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize("key", BROKEN)
def test_a_server_that_breaks_the_protocol_holds_no_client(key, kind, run):
    """There may be no connection any more to send the next request on, for which a client must not wait for ever."""
    answer, first = BROKEN[key]
    with ProtocolBreaker(answer) as peer:
        client = run(kind, key, "--endpoint", peer.endpoint, "--count", "5", "--timeout", "2")
    assert client.lines[1] == first
    # NetMQ connects to such a peer again, libzmq does not. Lesson 02 makes a new socket.
    end = ["done: 5 replies", f"gave up: no reply from {peer.endpoint} within 2 s; is the server running, or "]
    assert client.lines[-1].startswith(end[client.code]), client
    assert client.code == 0 or key != "02_lazy_pirate"


@pytest.mark.parametrize("key", ["03_publish_subscribe", "07_catch_up"])
def test_the_right_publisher_is_found_after_the_wrong_server(key, serve, start_client):
    """After a peer that is no publisher, libzmq never connects again by itself."""
    endpoint = two_ports()
    wrong, _ = serve("01_request_reply", endpoint=endpoint)
    words = [key, endpoint, "--count", "3", "--timeout", "25"]
    clients = [start_client(kind, *words) for kind in BOTH]
    for client in clients:
        client.wait_for("^(listening|following) ")
    # Not a wait for something: that long the wrong server has the port.
    time.sleep(0.5)
    wrong.kill()
    serve(key, endpoint=endpoint)
    for client in clients:
        assert client.wait() == 0, client.output
        assert client.lines[-1].startswith("done: received 3")


# A server is frozen, and another one has its name: those clients that keep a connection leave it for the new address.
# The others make a new socket, which looks the name up, for each try.


# The client's words, and the line by which it has found a server. Those of the first half keep a connection. Those of
# the second make a new socket for a try, and have a line about one in vain: there nobody knows the name for a while.
RETRIES = "--count 100000 --timeout 0.2 --tries 1000"
MOVING = {
    "03_publish_subscribe": ("--count 100000 --timeout 60 --every 1", "^received pose/", ""),
    "12_video": ("--count 0 --timeout 60", " can film ", ""),
    "13_side_channels": ("--count 100000 --timeout 60", "^[0-9]+: mass ", ""),
    "02_lazy_pirate": (RETRIES, "^[0-9]+: sent ", "no reply"),
    "04_background_client": (RETRIES, "^[0-9]+: ", "^trouble"),
    "06_many_in_flight": (RETRIES, "^[0-9]+: ", "no reply"),
}


@pytest.mark.parametrize(
    ("key", "kinds"),
    # Lesson 12's server has one game at a time.
    [*((key, BOTH) for key in MOVING if key != "12_video"), *(("12_video", [kind]) for kind in BOTH)],
)
def test_a_server_whose_address_changes_under_its_name(key, kinds, serve, start, client_command, tmp_path):
    name = MovingName(tmp_path)
    port = steady_port()
    words, found, missed = MOVING[key]
    commands = [client_command(kind, key, f"tcp://robot:{port}", *words.split()) for kind in kinds]
    old, _ = serve(key, endpoint=f"tcp://127.0.0.2:{port}")
    clients = [start(*name.before, *command) for command in commands]
    for client in clients:
        client.wait_for(found)
    if missed:
        name.vanish()
        old.kill()
        for client in clients:
            client.wait_for(missed, limit=30, start=len(client.lines))
        name.move("127.0.0.3")
    else:
        name.move("127.0.0.3")
        old.process.send_signal(signal.SIGSTOP)
    serve(key, endpoint=f"tcp://127.0.0.3:{port}")
    # The old one's last messages are printed before the new one has begun.
    for client in clients:
        client.wait_for(found, limit=30, start=len(client.lines))


@pytest.mark.parametrize(("make", "use"), USES.values(), ids=USES)
def test_a_name_that_nobody_knows_is_the_reason_that_is_given(make, use):
    """libzmq looks a name up again and again, and does not say that it is in vain."""
    with make("tcp://no-such.invalid:5552") as client:
        try:
            why = str(use(client))
        except TimeoutError as error:
            why = str(error)
    assert "; unknown host 'no-such.invalid': is it spelt so, and is the network there?" in why
