"""Each Python client of lessons 02 to 08 says in one line what it cannot do, and each class and function of a door,
and each C# class, what it cannot use.
"""

import asyncio
import inspect
import re
from collections.abc import Callable
from importlib import import_module

import pytest
import zmq
import zmq.asyncio

from netmq_example.background_client import BackgroundClient
from netmq_example.errors import Closed, Error, MessageError
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
        with made(kind) as it, pytest.raises(MessageError, match=r"a (text|frame) of \d+ bytes, more than 65536"):
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


# The argument of a door is named. A new door's is found, too.

DOORS = ["netmq_example", "netmq_example.camera", "netmq_example.jobs", "netmq_example.security"]
NAN = float("nan")
# An object is wrong for each argument, and these are by its name. The first few try all rules of check.py and
# arguments.py.
WRONG: dict[str, list[object]] = {
    "endpoint": [None, "", "127.0.0.1:5552", "tcp://127.0.0.1:99999"],
    "timeout": [0, -1, NAN, float("inf"), "1"],
    "TopicListener timeout": [-1, NAN],
    "receive timeout": [-1, NAN, float("inf"), "", "1"],
    "newest timeout": [-1, NAN],
    "text": [0, b"bytes"],
    # One text would be a request for each of its letters.
    "texts": [None, "echo one"],
    "tries": [None, 0, -1, NAN, 1.5, ""],
    "window": [0],
    "capacity": [0],
    "done": [-1, 2**53],
    "folder": [""],
    "grace": [-1],
    "job": ["", "../x", "x" * 65],
    "journal": [":memory:", "no/such/folder", "a\0b"],
    "kinds": [{"count": print}],
    "most": [-1],
    "name": ["../bob"],
    "picture": [[[[0.5]]]],
    "role": ["../server"],
    "snapshots": [-1, "127.0.0.1:5552", "tcp://127.0.0.1:0"],
    "workers": [-1, 100_000],
    # An AllowList takes those of zmq.asyncio as well.
    "answer context": [],
    "guard socket": [],
}
# These take anything, or say only later what is wrong with it.
LATER = {
    *["Action values", "Message kind", "Message id", "Message values", "Message arrays", "json_answer answer"],
    *["Publisher open_to_anyone", "Server open_to_anyone", "Server messages", "load cure"],
}
# Plain data that the package makes; and what answers whatever comes.
LEFT_OUT = {"Pose", "Row", "message_reply", "reply_to"}
METHODS = {
    "AllowList": {"answer": "context", "guard": "socket", "name_of": "frame", "name": "key"},
    "BackgroundClient": {"request": "text reply error", "submit": "text"},
    "DriverClient": {"send": "frame", "receive": "until"},
    "JobClient": {"goal": "kind count text", "ask": "verb", "watch": "request"},
    "LazyPirate": {"request": "text"},
    "ManyRequester": {"request_many": "texts"},
    "PoseSubscriber": {"receive": "timeout"},
    "Recorder": {"add": "frame"},
    "SecureRequester": {"request": "text"},
    "TopicListener": {"receive": "timeout", "newest": "timeout"},
}


def nothing(total, finished, text):
    yield from ()


@pytest.fixture
def right(tmp_path):
    """A value that fits each argument, by its name."""
    from netmq_example.jobs import Journal, Kind
    from netmq_example.security import ClientKeys, keys

    folder = tmp_path / "keys"
    keys.example(folder)
    book = Journal(tmp_path / "journal.sqlite3")
    values = {"answer": str, "folder": folder, "journal": book, "keys": ClientKeys(folder), "topic": "pose/"}
    values |= {"kinds": {"nothing": Kind(nothing, most=1)}, "path": tmp_path / "other.sqlite3", "work": nothing}
    values |= {"dtype": "uint8", "shape": (1,), "data": b"x", "frames": [b"x"], "request": b"x", "name": "bob"}
    values |= {"action": Message("action"), "role": "server", "kind": "count", "text": "hi", "key": "a" * 40}
    values |= {"reply": print, "error": print}
    numbers = ["frame", "throttle", "brake", "steer", "milliseconds", "total", "most", "done", "count"]
    return values | dict.fromkeys(numbers, 1)


def words_of(call, right):
    """The arguments that it needs, and the names of all."""
    name = getattr(call, "__name__", "")
    known = {**right, "endpoint": "tcp://127.0.0.1:0" if name in ("Server", "Publisher") else WHERE}
    parameters = [*inspect.signature(call).parameters.values()]
    named = [one for one in parameters if one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD)]
    words = {one.name: known.get(one.name, object()) for one in named if one.default is one.empty}
    return words, [one.name for one in named]


def calls(module, right):
    """Each call of a door, with its name and those of its arguments."""
    for name in sorted({*module.__all__} - LEFT_OUT):
        call = getattr(module, name)
        if not callable(call) or (inspect.isclass(call) and issubclass(call, BaseException)):
            continue
        words, names = words_of(call, right)
        yield call, words, [one for one in names if f"{name} {one}" not in LATER]
        if name in METHODS:
            it = call(**words)
            for method, asked in METHODS[name].items():
                own = getattr(it, method)
                yield own, words_of(own, right)[0], asked.split()
            getattr(it, "close", str)()


def refused(call, words):
    """Why, or nothing."""
    try:
        made = call(**words)
        if inspect.isgenerator(made):
            next(made)
        if inspect.iscoroutine(made):
            asyncio.run(made)
    except (Error, ValueError, TypeError) as error:
        return str(error)
    return ""


@pytest.mark.parametrize("door", DOORS)
def test_what_a_call_cannot_use_is_named(door, right, connect, tmp_path, monkeypatch):
    pytest.importorskip("numpy", reason="lesson 08 needs numpy: kit.py run 8 installs it")
    pytest.importorskip("PIL", reason="lesson 08 needs Pillow: kit.py run 8 installs it")
    monkeypatch.chdir(tmp_path)
    before = sorted(right["folder"].rglob("*"))
    with zmq.asyncio.Context() as context, context.socket(zmq.SUB) as socket:
        # Those of asyncio derive from those of zmq, and a call of theirs would return a future.
        sockets = [socket, connect(WHERE, zmq.REQ)]
        all_wrong = {**WRONG, "context": [context], "socket": sockets, "stream": sockets}
        for call, words, names in calls(import_module(door), right):
            for name in names:
                wrong = all_wrong.get(f"{call.__name__} {name}", all_wrong.get(name, []))
                for value in (object(), *wrong):
                    refusal = refused(call, {**words, name: value})
                    assert re.search(rf"\b{name}\b|^bad endpoint ", refusal), (call, name, value, refusal)
                    assert "\n" not in refusal and len(refusal) < 200, (call, name)
    assert sorted(right["folder"].rglob("*")) == before
