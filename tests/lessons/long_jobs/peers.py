"""The tests of lesson 14 have these in common: clients that are not the kit's, and a server that comes back."""

from __future__ import annotations

import time
import uuid

import pytest
import zmq

from netmq_example.messages import Message as Message
from tests.programs import LIMIT, steady_endpoint

read = Message.read
KEY = "14_long_jobs"


class Peer:
    """A client that is not the kit's: one job, and all that was said about it."""

    def __init__(self, context, endpoint, job=""):
        self.job, self.heard, self.asked_again = job or uuid.uuid4().hex, [], 0
        self.socket = context.socket(zmq.DEALER)
        self.socket.connect(endpoint)

    def ask(self, verb, **values):
        self.socket.send_multipart(Message(verb, values={"job": self.job, **values}).frames())
        return self

    def goal(self, kind="count", count=100):
        return self.ask("goal", kind=kind, count=count)

    def hear(self, *kinds, until=lambda news: True, limit=LIMIT):
        """The first message of these kinds of which that is true; asks again as clients do."""
        end = time.monotonic() + limit
        while time.monotonic() < end:
            if self.socket.poll(1000):
                self.heard.append(read(self.socket.recv_multipart()))
                if self.heard[-1].kind in kinds and until(self.heard[-1]):
                    return self.heard[-1]
            else:
                self.ask("status")
                self.asked_again += 1
        raise AssertionError(f"no {kinds}; heard {[(news.kind, news.values) for news in self.heard][-5:]}")

    def result(self, status=None):
        news = self.hear("result")
        assert status in (None, news.values["status"]), news.values
        return news

    def at(self, done):
        return self.hear("feedback", until=lambda news: news.values["done"] >= done)


@pytest.fixture
def peer(context):
    made = []

    def peer(endpoint, job=""):
        made.append(Peer(context, endpoint, job))
        return made[-1]

    yield peer
    for one in made:
        one.socket.close()


@pytest.fixture
def jobs_server(serve, tmp_path):
    """Like serve(), with a journal that the next server of the test opens again, on the same port."""
    endpoint = steady_endpoint()

    def jobs_server(*options):
        return serve(KEY, "--journal", str(tmp_path / "journal.sqlite3"), *options, endpoint=endpoint)

    return jobs_server


def units(result):
    """What is finished: each unit of `count` has its byte, in order, if each was done once."""
    found = bytes(result.arrays[0].data) if result.arrays else b""
    assert found == bytes(unit % 256 for unit in range(1, len(found) + 1))
    return len(found)
