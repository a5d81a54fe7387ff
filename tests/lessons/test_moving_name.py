"""A server is frozen, and another one has its name: those clients that keep a connection leave it for the new address.

The others make a new socket, which looks the name up, for each try.
"""

import signal

import pytest

from tests.lessons.uses import USES
from tests.programs import MovingName, steady_port

# The client's words, and the line by which it has found a server. Those of the first half keep a connection. Those of
# the second make a new socket for a try, and have a line about one in vain: there nobody knows the name for a while.
RETRIES = "--count 100000 --timeout 0.2 --tries 1000"
CASES = {
    "03_publish_subscribe": ("--count 100000 --timeout 60 --every 1", "^received pose/", ""),
    "12_video": ("--count 0 --timeout 60", " can film ", ""),
    "13_side_channels": ("--count 100000 --timeout 60", "^[0-9]+: mass ", ""),
    "02_lazy_pirate": (RETRIES, "^[0-9]+: sent ", "no reply"),
    "04_background_client": (RETRIES, "^[0-9]+: ", "^trouble"),
    "06_many_in_flight": (RETRIES, "^[0-9]+: ", "no reply"),
}


BOTH = ["python", "csharp"]


@pytest.mark.parametrize(
    ("key", "kinds"),
    # Lesson 12's server has one game at a time.
    [*((key, BOTH) for key in CASES if key != "12_video"), *(("12_video", [kind]) for kind in BOTH)],
)
def test_a_server_whose_address_changes_under_its_name(key, kinds, serve, start, client_command, tmp_path):
    name = MovingName(tmp_path)
    port = steady_port()
    words, found, missed = CASES[key]
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
