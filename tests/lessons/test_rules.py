"""Each Python client of lessons 02 to 08 says in one line what it cannot do, and each C# class what it cannot use."""

from collections.abc import Callable

import pytest
import zmq
import zmq.asyncio

from netmq_example.background_client import BackgroundClient
from netmq_example.errors import Closed, MessageError
from netmq_example.lazy_pirate import LazyPirate
from netmq_example.many_requester import ManyRequester
from netmq_example.message_requester import MessageRequester
from netmq_example.messages import Message
from netmq_example.publisher import Publisher
from netmq_example.server import Server
from netmq_example.topic_listener import TopicListener
from netmq_example.worker_threads import WorkerThreads
from tests.lessons.uses import USES
from tests.programs import LIMIT

WHERE = "tcp://127.0.0.1:5552"


# Each is asked so, by what goes.
ASKS: dict[type, Callable[..., object]] = {
    LazyPirate: lambda it, text="hello": it.request(text),
    BackgroundClient: lambda it, text="hello": it.submit(text).result(LIMIT),
    MessageRequester: lambda it: it.request(Message("look")),
    ManyRequester: lambda it: next(it.request_many(["hello"])),
    Publisher: lambda it, text="hello": it.send("a/", text),
    Server: lambda it: it.run(),
    WorkerThreads: lambda it: it.begin("key", b"hello"),
}


def made(kind):
    right = {Publisher: ["tcp://127.0.0.1:0"], Server: [str, "tcp://127.0.0.1:0"], WorkerThreads: [1, str]}
    return kind(*right.get(kind, [WHERE]))


def test_a_request_that_cannot_be_sent_is_refused_at_once():
    for kind in (LazyPirate, BackgroundClient, Publisher):
        with (
            made(kind) as it,
            pytest.raises(MessageError, match=r"a (text|frame) of \d+ bytes, more than 65536"),
        ):
            ASKS[kind](it, "x" * 65_537)
    with ManyRequester(WHERE) as requester:
        # One that is sent, and left alone. Nothing is sent of the others, and nothing waited for.
        left = requester.request_many(["echo one", "ü" * 32_769])
        assert next(left).number == 2
        del left
        outcomes = list(requester.request_many(["ü" * 32_769] * 100))
        assert [number for number, _, _ in outcomes] == list(range(1, 101))
        assert {str(error) for _, _, error in outcomes} == {"not sent: 65538 bytes, and the limit is 65536"}
    with BackgroundClient(WHERE, capacity=1) as client:
        with pytest.raises(TypeError, match=r"^reply takes a "):
            client.request("hello", None, print)
        assert client.under_way == 0, "a wrong request takes no place"


def test_what_is_closed_says_so(context):
    for kind, ask in ASKS.items():
        it = made(kind)
        it.close()
        it.close()
        with pytest.raises((Closed, ValueError), match=r"^th(is|e) [\w ]+ (is|was) closed"):
            ask(it)
    sub = context.socket(zmq.SUB)
    listener = TopicListener(WHERE, socket=sub)
    sub.close()
    ended = zmq.Context()
    pirate = LazyPirate(WHERE, tries=1, timeout=0.1, context=ended)
    with pytest.raises(TimeoutError, match=r"^1 try to ask "):
        pirate.request("add 1")
    ended.term()
    for use in (
        lambda: listener.receive(1),
        lambda: listener.newest(1),
        lambda: TopicListener(WHERE, socket=sub),
        lambda: pirate.request("add 1"),
        lambda: LazyPirate(WHERE, context=ended),
        lambda: ManyRequester(WHERE, context=ended),
    ):
        with pytest.raises(ValueError, match=r"^(this listener's socket|socket|context) is closed: make a new one$"):
            use()


def test_what_is_at_work_is_not_asked_beside(context):
    """Two at once would read each other's replies."""
    with ManyRequester(WHERE, context=context) as requester:
        left = requester.request_many(["ü" * 32_769, "echo one"])
        assert next(left).number == 1
        with pytest.raises(RuntimeError, match=r"^this ManyRequester has not ended what it does: wait "):
            next(requester.request_many(["echo two"]))
        del left
        assert [number for number, _, _ in requester.request_many(["ü" * 32_769])] == [1]
    for name in ("LazyPirate", "ManyRequester", "MessageRequester", "SecureRequester", "JobClient"):
        make, use = USES[name]
        with make(WHERE) as it, it.at_work, pytest.raises(RuntimeError) as refused:
            use(it)
        assert str(refused.value) == f"this {name} has not ended what it does: wait for that, or make a second {name}"


def test_an_endpoint_that_libzmq_cannot_use_hangs_nothing(context):
    with pytest.raises(zmq.ZMQError):
        ManyRequester("nonsense://x", context=context)
    with BackgroundClient("nonsense://x") as client:
        for _ in range(2):
            with pytest.raises(zmq.ZMQError):
                client.submit("hello").result(LIMIT)


def test_csharp_classes_name_what_they_cannot_use(checks, start):
    """checks/RuleChecks.cs finds their constructors."""
    program = start("dotnet", checks, "rules")
    assert program.wait() == 0, program.output
    assert [line for line in program.lines if not line.endswith(": refused")] == []
    assert len(program.lines) > 200
