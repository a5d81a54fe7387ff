"""What the lessons' tests share: a context for peers that are not the kit's, one request of such a peer, and the C#
side of lesson 05's messages without a client around it.
"""

from __future__ import annotations

import pytest
import zmq

from kitlib.setup import dotnet
from tests.conftest import PYTHON
from tests.programs import ROOT


@pytest.fixture
def context():
    with zmq.Context() as context:
        yield context


@pytest.fixture(scope="session")
def messages_program(engine):
    """The command of tests/lessons/messages."""
    return ["dotnet", str(dotnet.build(PYTHON, engine, ROOT / "tests" / "lessons" / "messages"))]


def ask(context, endpoint, *frames, kind=zmq.REQ):
    """One request of a client that is not the kit's; the reply's frames."""
    with context.socket(kind) as asker:
        asker.linger = 0
        asker.connect(endpoint)
        asker.send_multipart(frames)
        assert asker.poll(20_000), f"no reply to {frames!r:.80}"
        return asker.recv_multipart()
