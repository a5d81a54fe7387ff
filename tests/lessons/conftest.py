"""What the lessons' tests share: a context for peers that are not the kit's, and one request of such a peer."""

from __future__ import annotations

import pytest
import zmq


@pytest.fixture
def context():
    with zmq.Context() as context:
        yield context


def ask(context, endpoint, *frames, kind=zmq.REQ):
    """One request of a client that is not the kit's; the reply's frames."""
    with context.socket(kind) as asker:
        asker.linger = 0
        asker.connect(endpoint)
        asker.send_multipart(frames)
        assert asker.poll(20_000), f"no reply to {frames!r:.80}"
        return asker.recv_multipart()
