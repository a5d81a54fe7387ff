"""A server is frozen, and another one has its name: those clients that keep a connection leave it for the new address.

The others make a new socket, which looks the name up, for each try.
"""

import contextlib
import signal

import pytest
import zmq

from netmq_example.background_client import BackgroundClient
from netmq_example.camera import DriverClient
from netmq_example.jobs import JobClient
from netmq_example.lazy_pirate import LazyPirate
from netmq_example.many_requester import ManyRequester
from netmq_example.messages import Message
from netmq_example.mlagents_envs.carrier import ClientCarrier
from netmq_example.pose_stream import PoseSubscriber
from netmq_example.security import SecureRequester
from netmq_example.topic_listener import TopicListener
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


def request_in_background(context, where):
    why = []
    with contextlib.closing(BackgroundClient(where, timeout=0.1, tries=1)) as client:
        client.request("hello", why.append, why.append)
        while not why:
            client.poll()
    return why[0]


def receive_action(context, where):
    with DriverClient(where, timeout=0.1, tries=1) as client:
        client.send(Message("frame", 1))
        client.receive()


def listen(context, where):
    with context.socket(zmq.SUB) as socket:
        TopicListener(where, socket=socket).receive(3)


def exchange(context, where):
    carrier = ClientCarrier(context, where, timeout=0.1)
    while True:
        carrier.exchange(b"", 0.1)


def ask_many(context, where):
    with ManyRequester(where, timeout=0.1, tries=1) as requester:
        return str(next(requester.request_many(["a"])).error)


def snapshot(context, where):
    with context.socket(zmq.SUB) as stream:
        PoseSubscriber("tcp://127.0.0.1:5557", snapshots=where, stream=stream).ask(0.1)


UNKNOWN = {
    "LazyPirate": lambda context, where: LazyPirate(where, timeout=0.1, tries=1, context=context).request("hello"),
    "BackgroundClient": request_in_background,
    "ManyRequester": lambda context, where: str(
        next(ManyRequester(where, timeout=0.1, tries=1).request_many(["a"])).error
    ),
    "TopicListener": listen,
    "PoseSubscriber": snapshot,
    "SecureRequester": lambda context, where: SecureRequester(where, timeout=0.1, tries=1).request("hello"),
    "DriverClient": receive_action,
    "ClientCarrier": exchange,
    "JobClient": lambda context, where: list((job := JobClient(where, timeout=0.1, tries=1)).watch(job.ask("status"))),
}


@pytest.mark.parametrize("ask", UNKNOWN.values(), ids=UNKNOWN)
def test_a_name_that_nobody_knows_is_the_reason_that_is_given(ask):
    """libzmq looks a name up again and again, and does not say that it is in vain."""
    with zmq.Context() as context:
        try:
            why = ask(context, "tcp://no-such.invalid:5552")
        except TimeoutError as error:
            why = str(error)
        context.destroy()
    assert "; unknown host 'no-such.invalid': is it spelt so, and is the network there?" in why
