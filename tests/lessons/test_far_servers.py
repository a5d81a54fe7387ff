"""A far server is reached: over a line with a round trip of 600 ms, of which a new connection takes four or more. And
one that breaks ZeroMQ's protocol holds nobody.

tests/bad_peers.py has them.
"""

import contextlib

import pytest

from netmq_example.messages import Message
from tests.bad_peers import ProtocolBreaker, SlowLine
from tests.programs import places

ROUND_TRIP = 0.6
# A client's words, and the line by which it has been answered.
CASES = {
    "02_lazy_pirate": (["--tries", "20"], "^1: sent add 1, received 1$"),
    "03_publish_subscribe": (["--every", "1"], "^received pose/"),
    "04_background_client": ([], "^1: sent hello, received world$"),
    "07_catch_up": (["--every", "1"], "^[0-9]+: at "),
    "08_see_and_steer": (["--every", "1"], "^frame [0-9]+: age"),
    "09_environment": ([], "^simulating .* for "),
    "10_many_agents": ([], "^simulating .* for "),
    "11_observations": ([], "^simulating .* for "),
    "12_video": (["--count", "0"], " can film "),
    "13_side_channels": (["--timeout", "20"], "^[0-9]+: mass "),
    "14_long_jobs": ([], "^job .*: (accepted|[0-9]+ of )"),
    "17_many_machines": ([], "^simulating .* for "),
    "21_talking_character": ([], "^she: "),
}


@pytest.mark.parametrize("kind", ["python", "csharp"])
@pytest.mark.parametrize("key", CASES)
def test_a_far_server_is_reached(key, kind, serve, start, client_command):
    words, answered = CASES[key]
    server, _ = serve(key)
    with contextlib.ExitStack() as stack:
        far = {name: stack.enter_context(SlowLine(place, ROUND_TRIP)) for name, place in places(server).items()}
        others = [word for name, line in far.items() if name != "listening" for word in (f"--{name}", line.endpoint)]
        client = start(*client_command(kind, key, far["listening"].endpoint, *others, *words))
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


@pytest.mark.parametrize("kind", ["python", "csharp"])
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
