"""What the tests of lesson 06 have in common: clients that are not the kit's, and the server's memory."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

import pytest
import zmq

KEY = "06_many_in_flight"


@pytest.fixture
def connect(context):
    """connect(endpoint): a client that is not the kit's."""
    with contextlib.ExitStack() as stack:

        def connect(endpoint, kind=zmq.DEALER):
            client = stack.enter_context(context.socket(kind))
            client.linger = 0
            client.sndhwm = client.rcvhwm = 0
            client.connect(endpoint)
            return client

        yield connect


def receive(client, limit=20):
    assert client.poll(limit * 1000), f"no message within {limit} s"
    return client.recv_multipart()


def ask(client, *frames):
    client.send_multipart(frames)
    return receive(client)


def memory(process):
    """Resident memory in bytes."""
    status = Path(f"/proc/{process.pid}/status")
    if not status.exists():
        pytest.skip("this system has no /proc to read the server's memory from")
    return int(re.search(r"VmRSS:\s+(\d+) kB", status.read_text())[1]) * 1024


def a_client_that_never_reads(server, endpoint, connect):
    """Asks for much, and takes no reply in; the server's memory must not grow by them."""
    silent, other = connect(endpoint), connect(endpoint)
    # It takes nothing in, so that its replies stay on the server's side.
    silent.setsockopt(zmq.RCVHWM, 1)
    text = b"echo " + b"x" * 1000
    ask(other, b"1", text)
    before = memory(server.process)
    for i in range(100_000):
        silent.send_multipart([b"%d" % i, text])
        if i % 1000 == 0:
            ask(other, b"1", text)
    for _ in range(100):
        ask(other, b"1", text)
    assert memory(server.process) - before < 30e6, "a hundred million bytes of replies were due"
