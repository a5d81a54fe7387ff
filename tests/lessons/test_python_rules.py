"""Each Python client of lessons 02 to 07 says in one line which value it cannot use (in C#: test_csharp_rules.py)."""

from __future__ import annotations

import pytest
import zmq
import zmq.asyncio

from netmq_example.background_client import BackgroundClient
from netmq_example.jobs.client import JobClient
from netmq_example.lazy_pirate import LazyPirate
from netmq_example.many_requester import ManyRequester
from netmq_example.message_requester import MessageRequester
from netmq_example.mlagents_envs.carrier import Carrier, ClientCarrier
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.pose_stream import PoseSubscriber, snapshots_beside
from netmq_example.publisher import Publisher
from netmq_example.security.requester import SecureRequester
from netmq_example.server import Server
from netmq_example.topic_listener import TopicListener
from netmq_example.worker_threads import WorkerThreads

NAN, INFINITE = float("nan"), float("inf")
WHOLE: list[object] = [None, 0, -1, NAN, 1.5, ""]
WRONG: dict[str, list[object]] = {
    "context": [0, "x"],
    "stream": [0, "x"],
    "socket": [0, "x"],
    "endpoint": [None, 0, "", "127.0.0.1:5552", "tcp://127.0.0.1:99999"],
    "snapshots": [-1, "127.0.0.1:5552", "tcp://127.0.0.1:0"],
    "timeout": [None, 0, -1, NAN, INFINITE, "1"],
    "tries": WHOLE,
    "window": WHOLE,
    "capacity": WHOLE,
    "number": [*WHOLE, 100_000],
    "topic": [None, 0, b"pose/"],
    "report": [None, 0],
    "answer": [None, 0],
}
WHERE = "tcp://127.0.0.1:5552"


def needs(context, sub):
    """What each is made with, and what else it takes."""
    return [
        (LazyPirate, {"endpoint": WHERE}, ["context", "timeout", "tries"]),
        (ManyRequester, {"endpoint": WHERE}, ["context", "window", "timeout", "tries"]),
        (BackgroundClient, {"endpoint": WHERE}, ["context", "timeout", "tries", "window", "capacity"]),
        (MessageRequester, {"endpoint": WHERE}, ["context", "timeout", "tries"]),
        (Publisher, {"endpoint": "tcp://127.0.0.1:0"}, ["context"]),
        (Server, {"answer": str, "endpoint": "tcp://127.0.0.1:0"}, ["context"]),
        (TopicListener, {"endpoint": WHERE, "topic": "pose/"}, ["socket"]),
        (PoseSubscriber, {"endpoint": WHERE}, ["stream", "snapshots", "timeout"]),
        (WorkerThreads, {"number": 1, "answer": str}, []),
    ]


def test_what_a_class_cannot_use_is_named(context):
    with context.socket(zmq.SUB) as sub:
        for kind, right, more in needs(context, sub):
            for name in (*right, *more):
                for value in WRONG[name]:
                    words = {**right, name: value}
                    with pytest.raises((ValueError, TypeError), match=rf"^({name} |bad endpoint ).+$"):
                        kind(**words)


def test_what_only_one_of_them_refuses(context):
    with context.socket(zmq.REQ) as req, context.socket(zmq.SUB) as sub:
        for says, make in {
            "socket takes a SUB socket": lambda: TopicListener(WHERE, "pose/", socket=req),
            "stream takes a SUB socket, not ": lambda: PoseSubscriber(WHERE, stream=req),
            "bad endpoint 'tcp://127.0.0.1:65600'": lambda: PoseSubscriber("tcp://127.0.0.1:65500", stream=sub),
            "bad endpoint 'tcp://127.0.0.1'": lambda: snapshots_beside("tcp://127.0.0.1"),
        }.items():
            with pytest.raises(ValueError, match=f"^{says}"):
                make()


def test_what_is_of_zmq_asyncio_is_refused_with_the_cure():
    """Its classes derive from those of zmq, and a call of theirs would return a future."""
    with zmq.asyncio.Context() as context, context.socket(zmq.SUB) as sub, context.socket(zmq.ROUTER) as router:
        for make in (
            lambda: LazyPirate(WHERE, context=context),
            lambda: ManyRequester(WHERE, context=context),
            lambda: SecureRequester(WHERE, context=context),
            lambda: JobClient(WHERE, context=context),
            lambda: ClientCarrier(context, WHERE),
            lambda: TopicListener(WHERE, socket=sub),
            lambda: PoseSubscriber(WHERE, stream=sub),
            lambda: Carrier(router, SideChannelManager, print),
        ):
            with pytest.raises(TypeError, match=r"^\w+ is one of zmq.asyncio: take one of zmq, .* asyncio.to_thread$"):
                make()


def test_what_cannot_be_waited_for_is_named(context):
    with context.socket(zmq.SUB) as one, context.socket(zmq.SUB) as other:
        listener = TopicListener(WHERE, "pose/", socket=one)
        receives = (
            (listener.receive, [-1]),
            (listener.newest, [-1]),
            (PoseSubscriber(WHERE, stream=other).receive, [0, -1]),
        )
        for receive, wrong in receives:
            for timeout in (*wrong, NAN, INFINITE, "", "1"):
                with pytest.raises(ValueError, match=r"^timeout takes seconds, "):
                    receive(timeout)
