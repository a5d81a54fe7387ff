"""Each Python client that keeps a socket: how it is made for an endpoint, and one use of it, which soon gives up."""

from collections.abc import Callable
from functools import partial
from itertools import count
from typing import Any

import zmq

from netmq_example.background_client import BackgroundClient
from netmq_example.camera.client import DriverClient
from netmq_example.jobs.client import JobClient
from netmq_example.lazy_pirate import LazyPirate
from netmq_example.many_requester import ManyRequester
from netmq_example.message_requester import MessageRequester
from netmq_example.messages import Message
from netmq_example.mlagents_envs.carrier import ClientCarrier
from netmq_example.pose_stream import PoseSubscriber
from netmq_example.security.requester import SecureRequester
from netmq_example.topic_listener import TopicListener

SOON: dict[str, Any] = {"timeout": 0.1, "tries": 1}
USES: dict[str, tuple[Callable[..., Any], Callable[[Any], object]]] = {
    "LazyPirate": (partial(LazyPirate, **SOON), lambda it: it.request("hello")),
    "BackgroundClient": (partial(BackgroundClient, **SOON), lambda it: it.submit("hello").result(60)),
    "ManyRequester": (partial(ManyRequester, **SOON), lambda it: next(it.request_many(["hello"]))),
    "MessageRequester": (partial(MessageRequester, **SOON), lambda it: it.request(Message("look"))),
    "SecureRequester": (partial(SecureRequester, **SOON), lambda it: it.request("hello")),
    "DriverClient": (partial(DriverClient, **SOON), lambda it: (it.send(Message("frame", 1)), it.receive())),
    "JobClient": (partial(JobClient, **SOON), lambda it: [*it.watch(it.ask("status"))]),
    "TopicListener": (TopicListener, lambda it: it.receive(3)),
    "PoseSubscriber": (partial(PoseSubscriber, timeout=0.1), lambda it: it.receive(0.1)),
    "ClientCarrier": (
        lambda where: ClientCarrier(zmq.Context.instance(), where, timeout=0.1),
        lambda it: [it.exchange(b"", 0.1) for _ in count()],
    ),
}
