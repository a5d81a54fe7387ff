"""A server is frozen, and another one has its name: those clients that keep a connection leave it for the new address.

The others make a new socket, which looks the name up, for each try.
"""

import signal

import pytest

from tests.programs import MovingName, steady_port

# What the client is told, and the line by which it has found a server.
CASES = {
    "03_publish_subscribe": (["--every", "1", "--count", "100000"], "^received pose/"),
    "12_video": (["--count", "0"], " can film "),
    "13_side_channels": (["--count", "100000"], "^[0-9]+: mass "),
}


@pytest.mark.parametrize("kind", ["python", "csharp"])
@pytest.mark.parametrize("key", CASES)
def test_a_server_whose_address_changes_under_its_name(key, kind, serve, start, client_command, tmp_path):
    name = MovingName(tmp_path)
    port = steady_port()
    options, found = CASES[key]
    client_words = client_command(kind, key, f"tcp://robot:{port}", "--timeout", "60", *options)
    old, _ = serve(key, endpoint=f"tcp://127.0.0.2:{port}")
    client = start(*name.before, *client_words)
    client.wait_for(found)
    name.move("127.0.0.3")
    old.process.send_signal(signal.SIGSTOP)
    serve(key, endpoint=f"tcp://127.0.0.3:{port}")
    # What came from the old one is printed before the new one has begun.
    client.wait_for(found, limit=30, start=len(client.lines))


# Each of these makes a new socket for a try, and says that it was in vain. Two lines: served, and not.
VANISHING = {
    "02_lazy_pirate": (["--count", "100000", "--timeout", "0.2", "--tries", "1000"], "^[0-9]+: sent ", "no reply"),
    "04_background_client": (["--count", "100000", "--timeout", "0.2", "--tries", "1000"], "^[0-9]+: ", "^trouble"),
    "06_many_in_flight": (["--count", "100000", "--timeout", "0.2", "--tries", "1000"], "^[0-9]+: ", "no reply"),
}


@pytest.mark.parametrize("kind", ["python", "csharp"])
@pytest.mark.parametrize("key", VANISHING)
def test_a_name_that_nobody_knows_for_a_while(key, kind, serve, start, client_command, tmp_path):
    name = MovingName(tmp_path)
    port = steady_port()
    options, served, missed = VANISHING[key]
    client_words = client_command(kind, key, f"tcp://robot:{port}", *options)
    old, _ = serve(key, endpoint=f"tcp://127.0.0.2:{port}")
    client = start(*name.before, *client_words)
    client.wait_for(served)
    name.vanish()
    old.kill()
    client.wait_for(missed, limit=30, start=len(client.lines))
    name.move("127.0.0.3")
    serve(key, endpoint=f"tcp://127.0.0.3:{port}")
    client.wait_for(served, limit=30, start=len(client.lines))
