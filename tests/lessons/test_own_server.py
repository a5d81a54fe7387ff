"""A server of one's own, and clients for threads and for asyncio: what a program has that is none of the lessons'."""

import asyncio
import contextlib
import gc
import logging
import os
import select
import signal
import sys
import threading
import time
from concurrent.futures import CancelledError, ThreadPoolExecutor
from typing import Any

import pytest
import zmq
import zmq.asyncio

from netmq_example import (
    Array,
    BackgroundClient,
    Closed,
    Journal,
    LazyPirate,
    ManyRequester,
    Message,
    MessageError,
    MessageRequester,
    PoseSubscriber,
    Publisher,
    Refused,
    Server,
    Timeout,
    TopicListener,
)
from netmq_example.errors import ListenError
from netmq_example.security.allow_list import AllowList
from netmq_example.security.keys import make
from netmq_example.security.requester import ClientKeys
from tests.lessons.conftest import ask, server_of
from tests.programs import LIMIT, ROOT, finished, steady_endpoint

PATIENT = 60


class Work:
    """An answer that counts what it does; `go` ends those that wait."""

    def __init__(self):
        self.done = []
        self.go = threading.Event()
        # A class of its own: of the same mistake in the same place there is one traceback in a process.
        self.mistake = type("Mistake", (Exception,), {})

    def __call__(self, text):
        self.done.append(text)
        if text.startswith("wait"):
            assert self.go.wait(LIMIT)
        if text == "bad":
            raise self.mistake("speed")
        return text.upper()


@pytest.fixture
def work():
    work = Work()
    yield work
    work.go.set()


@pytest.fixture(params=[0, 4], ids=["no workers", "4 workers"])
def server(request, work):
    with Server(work, workers=request.param) as server:
        yield server
        work.go.set()


# Server


REQUESTS = {
    "01_request_reply": ["Hello", "Hello\0", "", "Häße", "x" * 65_536],
    "04_background_client": ["hello", "echo hi", "echo", "", "ä"],
    "06_many_in_flight": ["echo hi", "sleep 0", "sleep x", "ä"],
}


@pytest.mark.parametrize("key", REQUESTS)
def test_a_lessons_answer_gives_the_same_bytes_behind_it(key, serve, context):
    _, there = serve(key)
    with Server(server_of(key).answer) as server:
        for text in REQUESTS[key]:
            frames = [b"7", text.encode()] if key != "01_request_reply" else [text.encode()]
            assert ask(context, server.endpoint, *frames) == ask(context, there, *frames), text


def test_a_mistake_in_answer_goes_to_the_client_and_to_the_log(server, work, caplog):
    with LazyPirate(server.endpoint, timeout=PATIENT) as pirate:
        assert pirate.request("bad") == "error: Mistake('speed')"
        assert pirate.request("good") == "GOOD"
    (record,) = [each for each in caplog.records if each.exc_info]
    assert (record.name, record.levelno) == ("netmq_example.server", logging.ERROR)
    assert record.exc_info[0] is work.mistake


class Unprintable(Exception):
    def __repr__(self):
        raise ValueError


MISTAKES: dict[str, Any] = {
    "SystemExit": lambda: SystemExit(3),
    "KeyboardInterrupt": KeyboardInterrupt,
    "Unprintable": Unprintable,
    "an id that is none": lambda: MessageError("wrong", "why", "7"),
    "half a character": lambda: MessageError("\ud800", "why \ud800"),
}


@pytest.mark.parametrize("kind", ["text", "workers", "messages", "messages with workers", "journal"])
@pytest.mark.parametrize("mistake", MISTAKES)
def test_no_mistake_in_answer_ends_a_thread(mistake, kind, tmp_path, monkeypatch):
    # pytest sends the lines that it has captured to another process, which half a character would end.
    monkeypatch.setattr(logging.getLogger("netmq_example.server"), "disabled", True)

    def answer(*words):
        if getattr(words[-1], "kind", words[-1]) == "bad":
            raise MISTAKES[mistake]()
        return words[-1]

    messages, workers = "messages" in kind, int("workers" in kind)
    kinds: Any = (MessageRequester, Message) if messages else (LazyPirate, str)
    ask, form = kinds
    with (
        Journal(tmp_path / "journal.sqlite3") as journal,
        Server(answer, messages=messages, workers=workers, journal=journal if kind == "journal" else None) as server,
        ask(server.endpoint, timeout=PATIENT) as client,
    ):
        if messages:
            with pytest.raises(Refused):
                client.request(form("bad"))
        else:
            assert client.request("bad").startswith("error: ")
        assert client.request(form("good")) == form("good")


def test_a_request_that_comes_again_is_not_done_again(server, work, connect):
    id, dealer, other = b"1" * 16, connect(server.endpoint), connect(server.endpoint)
    # Not before the first is at work: which connection's message comes first, nobody says.
    for socket in (dealer, other):
        socket.send_multipart([id, b"wait"])
        while not work.done:
            time.sleep(0.001)
    work.go.set()
    assert other.recv_multipart() == [id, b"WAIT"]
    # Of an id that is not long enough to be nobody else's, each connection has its own.
    for socket in (dealer, other, dealer):
        socket.send_multipart([b"1", b"short"])
        while (frames := socket.recv_multipart())[0] == id:
            pass
        assert frames == [b"1", b"SHORT"]
    assert work.done == ["wait", "short", "short"]


def test_a_request_may_have_an_id_or_an_empty_frame_or_none(server, context):
    assert ask(context, server.endpoint, b"1", b"a") == [b"1", b"A"]
    assert ask(context, server.endpoint, b"a", b"b", b"c") == [b"A B C"]
    assert ask(context, server.endpoint, b"1", b"a", kind=zmq.DEALER) == [b"1", b"A"]
    assert ask(context, server.endpoint, b"a", kind=zmq.DEALER) == [b"A"]


def test_behind_a_broker_each_client_has_its_own_short_ids(server, work, connect):
    broker = connect(server.endpoint)
    for client in (b"a", b"b" * 1001, b"a"):
        broker.send_multipart([client, b"", b"1", b"add 1"])
        assert broker.recv_multipart() == [client, b"", b"1", b"ADD 1"]
    assert work.done == ["add 1", "add 1"]
    # However long its way is, it is not kept.
    assert "bbb" not in str(server.known)


def test_more_than_its_workers_can_do_is_refused_at_once(work, connect):
    with Server(work, workers=1) as server:
        dealer = connect(server.endpoint)
        for number in range(300):
            dealer.send_multipart([b"%d" % number, b"wait %d" % number])
        assert dealer.recv_multipart()[1] == b"error: busy, try again later"
        work.go.set()


def test_what_has_a_journal_needs_ids_and_has_no_workers(tmp_path, context):
    with Journal(tmp_path / "visits.sqlite3") as journal:
        with Server(lambda db, text: text, journal=journal) as server:
            assert ask(context, server.endpoint, b"me")[0].startswith(b"error: expected [id][text]")
        with pytest.raises(ValueError, match=r"^a journal takes neither messages nor workers"):
            Server(str, journal=journal, workers=1)


def test_a_port_that_is_taken_is_one_error_with_its_cure(server):
    with pytest.raises(ListenError, match=r"^cannot listen on .*: Address already in use; end the server that has it"):
        Server(str.upper, server.endpoint)
    with pytest.raises(ListenError):
        Publisher(server.endpoint)


def test_only_this_machine_may_ask_unless_it_is_said():
    for make_one in (Server, lambda _, endpoint, **words: Publisher(endpoint, **words)):
        with pytest.raises(ValueError, match=r"^'tcp://0\.0\.0\.0:0' would let anyone in"):
            make_one(str.upper, "tcp://0.0.0.0:0")
        make_one(str.upper, "tcp://0.0.0.0:0", open_to_anyone=True).close()
    with pytest.raises(ValueError, match=r"^beacon takes 1 to 32 letters"):
        Server(str.upper, "tcp://0.0.0.0:0", open_to_anyone=True, beacon="my lab")


def test_close_in_answer_ends_run():
    own: Any = Server(lambda text: own.close() or text)
    thread = threading.Thread(target=own.run)
    thread.start()
    with LazyPirate(own.endpoint, timeout=0.2, tries=1) as pirate, pytest.raises(Timeout):
        pirate.request("hi", within=0.2)
        pirate.request("hi", within=0.2)
    thread.join(LIMIT)
    assert not thread.is_alive()


@pytest.mark.parametrize("use", ["not run", "not asked", "asked"])
def test_close_returns_when_the_port_is_free(use):
    for _ in range(10):
        server = Server(str.upper)
        thread = threading.Thread(target=server.run if use != "not run" else server.close)
        thread.start()
        if use == "asked":
            with LazyPirate(server.endpoint, timeout=PATIENT) as pirate:
                pirate.request("hi")
        server.close()
        server.close()
        Server(str.upper, server.endpoint).close()
        with Publisher(server.endpoint):
            pass
        thread.join(LIMIT)
        assert not thread.is_alive()
        for again in (server.run, server.__enter__):
            with pytest.raises(Closed):
                again()


def test_what_ctrl_c_ended_is_closed():
    def answer(text):
        raise KeyboardInterrupt

    server = Server(answer)
    with BackgroundClient(server.endpoint) as client:
        client.submit("hi")
        with pytest.raises(KeyboardInterrupt):
            server.run()
    with pytest.raises(Closed):
        server.run()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_child_that_closes_what_its_parent_has_costs_the_parent_nothing(work):
    with Server(work) as server, BackgroundClient(server.endpoint, timeout=PATIENT) as client:
        assert client.submit("a").result(LIMIT) == "A"
        child = os.fork()
        if not child:
            client.close()
            server.close()
            os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
        assert client.submit("b").result(LIMIT) == "B"
        assert not select.select([server.wake_reader], [], [], 0)[0]


SERVE = """
from netmq_example import serve
import logging
logging.basicConfig(level="INFO", format="%(message)s")
serve(str.upper, "tcp://127.0.0.1:0")
print("and on")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C cannot be sent there")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_serve_and_the_program_goes_on(how, start):
    program = start(sys.executable, "-c", SERVE, folder=ROOT / "python")
    with LazyPirate(program.wait_for(r"^listening on (\S+)$")[1], timeout=PATIENT) as pirate:
        assert pirate.request("hi") == "HI"
    assert program.stop(how) == 0
    assert program.lines[1:] == ["and on"]


# Each program prints this, and nothing else, and ends.
END_BY_THEMSELVES = {
    "Ctrl-C while serve begins": """
import signal, zmq
from netmq_example import serve
original = zmq.Context.socket
def socket(*words):
    made = original(*words)
    signal.raise_signal(signal.SIGINT)
    return made
zmq.Context.socket = socket
serve(str.upper, "tcp://127.0.0.1:0")
print("the end")
""",
    "Ctrl-C where its exception is dropped, as in pyzmq's end of a frame": """
import signal, threading, weakref
from netmq_example.console import listen
listen(signal.SIGINT)
class Frame:
    pass
frame = Frame()
end = weakref.ref(frame, lambda _: signal.raise_signal(signal.SIGINT))
try:
    del frame
    threading.Event().wait(60)
except KeyboardInterrupt:
    print("the end")
""",
    "threads that are left": """
import threading
from netmq_example import BackgroundClient, Server
server = Server(lambda text: threading.Event().wait(), workers=2).__enter__()
client = BackgroundClient(server.endpoint, window=2)
client.submit("for ever")
print("the end")
""",
}


@pytest.mark.parametrize("script", END_BY_THEMSELVES.values(), ids=END_BY_THEMSELVES)
def test_a_program_ends_in_spite_of(script):
    done = finished([sys.executable, "-W", "error", "-c", script], cwd=ROOT / "python")
    assert (done.returncode, done.stdout, done.stderr) == (0, "the end\n", "")


@pytest.fixture
def alice(tmp_path):
    """The keys of a server, those of the one client that it lets in, and the file by which it does."""
    folder = tmp_path / "keys"
    make(folder, "server")
    own = ClientKeys(folder)
    (folder / "allowed").mkdir(exist_ok=True)
    return AllowList(folder), own, (folder / "client.key").replace(folder / "allowed" / "alice.key")


def test_its_keys_let_in_only_those_on_the_list(alice):
    keys, own, _ = alice
    with Server(str.upper, keys=keys) as server:
        with BackgroundClient(server.endpoint, timeout=PATIENT, keys=own) as client:
            assert client.submit("hi").result(LIMIT) == "HI"
        with ManyRequester(server.endpoint, timeout=PATIENT, keys=own) as requester:
            assert [each.reply for each in requester.request_many(["hi"])] == ["HI"]
        with LazyPirate(server.endpoint, timeout=0.2, tries=1) as stranger, pytest.raises(Timeout):
            stranger.request("hi")


@pytest.mark.parametrize("kind", ["text", "messages", "journal"])
def test_a_revoked_key_is_refused_from_then_on(kind, alice, tmp_path):
    keys, own, file = alice
    asked = []

    def answer(*words):
        asked.append(words[-1])
        return words[-1]

    messages = kind == "messages"
    kinds: Any = (MessageRequester, Message("look", 1, {}, [Array("uint8", (3,), b"abc")]))
    ask, request = kinds if messages else (LazyPirate, "hi")
    with (
        Journal(tmp_path / "journal.sqlite3") as journal,
        Server(answer, messages=messages, keys=keys, journal=journal if kind == "journal" else None) as server,
        ask(server.endpoint, timeout=PATIENT, keys=own) as requester,
    ):
        assert requester.request(request)
        file.unlink()
        if messages:
            with pytest.raises(Refused, match=r"^refused: your key is not on the list"):
                requester.request(request)
        else:
            assert requester.request(request).startswith("error: your key is not on the list")
    assert len(asked) == 1


# Clients for threads


def test_each_of_8_threads_gets_its_own_replies_at_any_switch_interval():
    """Replies that came to another request's callback were found so."""
    each, before = 500, sys.getswitchinterval()
    got: list[tuple[str, str]] = []
    with (
        Server(str.upper) as server,
        BackgroundClient(server.endpoint, timeout=PATIENT, window=4, capacity=8 * each) as client,
        ThreadPoolExecutor(8) as pool,
    ):

        def ask(thread):
            for number in range(each):
                text = f"a{thread}-{number}"
                assert client.request(text, lambda reply, text=text: got.append((text, reply)), print)
                yield text, client.submit(text)

        sys.setswitchinterval(1e-6)
        try:
            every = [pair for pairs in pool.map(lambda thread: [*ask(thread)], range(8)) for pair in pairs]
            assert all(future.result(LIMIT) == text.upper() for text, future in every)
        finally:
            sys.setswitchinterval(before)
        while client.under_way:
            client.poll()
    assert len(every) == len(got) == 8 * each
    assert all(reply == text.upper() for text, reply in got)


def test_a_request_is_taken_back_until_it_is_sent(work):
    with Server(work) as server, BackgroundClient(server.endpoint, timeout=PATIENT) as client:
        first, second = client.submit("wait"), client.submit("second")
        while not work.done:
            time.sleep(0.001)
        assert second.cancel()
        assert not first.cancel()
        late = client.submit("late", within=0.05)
        time.sleep(0.06)
        work.go.set()
        assert (first.result(LIMIT), client.submit("third").result(LIMIT)) == ("WAIT", "THIRD")
        with pytest.raises(CancelledError):
            second.result(LIMIT)
        with pytest.raises(Timeout, match=r"^not sent to .* in time: the requests before it took too long$"):
            late.result(LIMIT)
    assert work.done == ["wait", "third"]


def test_what_the_futures_raise():
    nobody = steady_endpoint()
    with Server(lambda text: "error: expected hello") as server, BackgroundClient(server.endpoint) as client:
        with pytest.raises(Refused, match=r"^error: expected hello$") as refused:
            client.submit("x").result(LIMIT)
        assert (refused.value.code, refused.value.text) == ("error", "expected hello")
        with pytest.raises(MessageError, match=r"^a text of 65537 bytes"):
            client.submit("x" * 65_537)
    # Time enough for a busy machine to begin the first try.
    with BackgroundClient(nobody, timeout=5) as client, pytest.raises(Timeout, match=r"^1 try within [\d.]+ s to ask "):
        client.submit("x", within=1).result(LIMIT)
    with BackgroundClient(nobody, timeout=0.05, tries=2) as client:
        with pytest.raises(Timeout, match=r"^2 tries to ask ") as late:
            client.submit("x").result(LIMIT)
        assert isinstance(late.value, TimeoutError)
        waiting = [client.submit("x"), client.submit("y")]
    for each in waiting:
        with pytest.raises((Closed, Timeout)):
            each.result(LIMIT)
    assert not any(thread.is_alive() for thread in client.threads)


def test_all_tries_together_take_no_longer_than_within():
    with (
        LazyPirate(steady_endpoint(), timeout=0.2, tries=100) as pirate,
        pytest.raises(Timeout, match=r"^2 tries within [\d.]+ s to "),
    ):
        pirate.request("x", within=0.3)


def test_a_future_that_closes_its_client_ends_it(server):
    client = BackgroundClient(server.endpoint, timeout=PATIENT)
    closed = threading.Event()
    future = client.submit("hi")
    future.add_done_callback(lambda _: (client.close(), closed.set()))
    assert future.result(LIMIT) == "HI"
    assert closed.wait(LIMIT)


class Mistake(BaseException):
    pass


def test_mistakes_in_callbacks_end_no_thread_and_no_close(server):
    def mistake(_):
        raise Mistake

    client = BackgroundClient(server.endpoint, timeout=PATIENT, capacity=2000)
    client.submit("a").add_done_callback(mistake)
    assert client.submit("b").result(LIMIT) == "B"
    ran = []
    for _ in range(1500):
        assert client.request("c", lambda text: ran.append(text) or mistake(text), mistake)
    client.submit("last").result(LIMIT)
    with pytest.raises(Mistake):
        client.close()
    assert (len(ran), client.under_way) == (1500, 0)


# and for asyncio


def test_no_try_follows_once_its_task_is_cancelled():
    async def main():
        with BackgroundClient(steady_endpoint(), timeout=0.1, tries=10_000) as client:
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.15):
                    await client.ask("x")
            # The one connection is free for the next.
            with pytest.raises(Timeout, match=r"^\d+ tr\w+ within [\d.]+ s to ask "):
                await client.ask("y", within=2)

    asyncio.run(main())


# Messages


def look(request):
    if request.kind == "look":
        return Message("ok", request.id, {"mean": float(request.arrays[0].numpy().mean())})
    raise MessageError("unknown-kind", f"kind {request.kind}")


@pytest.mark.parametrize("workers", [0, 2])
def test_a_message_is_answered_or_refused_by_code_and_text(workers):
    np = pytest.importorskip("numpy")
    picture = np.array([[1, 2], [3, 4]], "uint8")
    with (
        Server(look, messages=True, workers=workers) as server,
        MessageRequester(server.endpoint, timeout=PATIENT) as requester,
    ):
        assert requester.request(Message("look", 1, {}, [Array.of(picture)])).values == {"mean": 2.5}
        with pytest.raises(Refused) as refused:
            requester.request(Message("touch", 7))
        assert (refused.value.code, refused.value.text, refused.value.id) == ("unknown-kind", "kind touch", 7)
        with pytest.raises(MessageError, match=r"^bad-value"):
            requester.request(Message("look", -1))
        assert requester.request(Message("look", 2, {}, [Array.of(picture[::-1, 1])])).values == {"mean": 3.0}


def test_a_message_that_nobody_answers_is_asked_again(caplog):
    with MessageRequester(steady_endpoint(), timeout=0.05, tries=2) as requester, pytest.raises(Timeout):
        requester.request(Message("look"))
    assert [record.getMessage() for record in caplog.records] == ["look: no reply within 0.05 s; try 2 of 2"]


def test_an_array_of_numpy_is_taken_as_it_is_or_refused():
    np = pytest.importorskip("numpy")
    for dtype in ("uint8", "uint16", "int32", "int64", "float32", "float64"):
        numbers = np.arange(6, dtype=dtype).reshape(2, 3)
        for each in (numbers, numbers.T, numbers[:, ::2], numbers[0, 0], numbers[:0]):
            array = Array.of(each)
            assert (array.dtype, array.shape) == (dtype, each.shape)
            assert array.numpy().tolist() == each.tolist()
    for wrong, cure in {"int8": "float32", "bool": "float32", "complex64": "float32", ">f4": "float32"}.items():
        with pytest.raises(MessageError, match=rf"^bad-dtype: .*; write array\.astype\('{cure}'\)$"):
            Array.of(np.zeros(3, wrong))


def test_an_array_that_the_server_uses_again_goes_out_as_it_was(connect):
    np = pytest.importorskip("numpy")
    buffer = np.zeros(4_000_000, "uint8")

    def answer(request):
        buffer[:] += 1
        return Message("ok", request.id, {}, [Array.of(buffer)])

    with Server(answer, messages=True) as server:
        dealer = connect(server.endpoint)
        for number in range(8):
            dealer.send_multipart(Message("next", number).frames())
        for number in range(8):
            (array,) = Message.read_reply(dealer.recv_multipart()).arrays
            assert np.unique(array.numpy()).tolist() == [number + 1]


# A publisher of one's own


def test_what_is_published_comes_as_text():
    texts = set()
    with Publisher() as publisher, TopicListener(publisher.endpoint, "a/", timeout=0.05) as listener:
        while len(texts) < 3:
            publisher.send("b/", "not for this one")
            for body in ("text", b"\xff", Message("pose", 3)):
                publisher.send("a/", body)
                with contextlib.suppress(Timeout):
                    texts.add(listener.receive())
        assert {"a/ text", "a/ (1 bytes)"} < texts
        listener.stop()
        with pytest.raises(Closed):
            listener.receive()


def test_a_wrong_word_leaves_no_socket_open(recwarn):
    for make_one, wrong in (TopicListener, {"high_watermark": -1}), (PoseSubscriber, {"timeout": 0}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            make_one(steady_endpoint(), **wrong)
    gc.collect()
    assert [str(each.message) for each in recwarn] == []


def test_a_frame_that_listeners_do_not_take_is_refused():
    with Publisher() as publisher:
        for body in ("x" * 65_536, b"x" * 65_537, Message("a", 0, {}, [Array("uint8", (70_000,), bytes(70_000))])):
            with pytest.raises(MessageError, match=r"^too-big: a frame of \d+ bytes, more than 65536: give "):
                publisher.send("a/", body)
    with (
        Publisher(largest=100_000) as publisher,
        TopicListener(publisher.endpoint, "a/", largest=100_000, timeout=0.05) as listener,
    ):
        heard = None
        while not heard:
            publisher.send("a/", b"x" * 70_000)
            with contextlib.suppress(Timeout):
                heard = listener.receive_frames()
    assert heard == [b"a/", b"x" * 70_000]
