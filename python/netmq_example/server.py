"""A server of your own: a function that answers, over an endpoint.

    def answer(text: str) -> str:
        return text.upper()

    serve(answer, "tcp://127.0.0.1:5554")               until Ctrl-C

    with Server(answer) as server:                      on a thread of its own, and on a free port: for a test
        LazyPirate(server.endpoint).request("hello")

Clients of lessons 01, 02, 04 and 06 can ask it, and with `messages` those of lesson 05. A mistake in `answer` is
logged, and its client gets it as an error.
"""

import contextlib
import logging
import os
import socket as sockets
import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, Protocol, Self, TypedDict, Unpack

import zmq

from netmq_example import arguments, check
from netmq_example.beacon import answering, beacon_name
from netmq_example.errors import Closed, MessageError
from netmq_example.finalizers import ended_by_sigterm, undisturbed
from netmq_example.journal import LONGEST_ID_BYTES, Connection, Journal
from netmq_example.messages import LIMIT, Message, message_reply
from netmq_example.one_process import OneProcess, one_at_a_time
from netmq_example.program import (
    LARGEST_BYTES,
    SLICE_MS,
    Context,
    Socket,
    bind,
    limit,
    not_for_anyone,
    reply_to,
    text_of,
)
from netmq_example.replies import id_and_text
from netmq_example.worker_threads import WorkerThreads

# So many requests are read at a time, and so many may be at work or wait for a worker. More are refused at once.
MOST_MESSAGES = 100
MOST_BEGUN = 256
# An id of so many bytes is taken to be nobody else's. A shorter one, such as 1, is its connection's.
LEAST_UNIQUE = 16
CLOSE_SECONDS = 5.0

log = logging.getLogger("netmq_example.server")
Answer = Callable[[str], str] | Callable[[Message], Message] | Callable[[Connection, str], str]


class ServerKeys(Protocol):
    """AllowList of netmq_example.security: only clients whose keys it has may come in."""

    def answer(self, context: Context) -> None: ...
    def guard(self, socket: Socket) -> None: ...
    def name_of(self, frame: zmq.Frame) -> str: ...


class Server(OneProcess):
    """Answers over a ROUTER socket: on a thread of its own by `with`, or on this one by run().

    close() may be called on any thread. It ends the server at once, or when the answer under way is made.
    """

    def __init__(
        self,
        answer: Answer,
        endpoint: str = "tcp://127.0.0.1:0",
        *,
        messages: bool = False,
        workers: int = 0,
        remember: int = 1000,
        journal: Journal | None = None,
        keys: ServerKeys | None = None,
        open_to_anyone: bool = False,
        beacon: str | None = None,
        context: Context | None = None,
    ) -> None:
        """It listens from now on. Port 0 takes a free one, and `endpoint` says which. ListenError: it is taken.

        `answer` takes a text and returns one, or with `messages` a Message and a Message. Without `workers` it runs on
        the server's thread, one request after the other; else on so many threads. A request that is sent again, with
        the same id, is not done twice, as long as it is among the last to `remember`. With a `journal`, which survives
        a crash, `answer` takes its database as well, and whoever asks must send an id.

        Only programs of this machine may ask, unless there are `keys`, or it is `open_to_anyone`; by its `beacon`'s
        name clients can look for it.
        """
        self.answer: Any = arguments.function("answer", answer)
        self.messages = messages
        self.remember = check.count("remember", remember, least=0)
        self.keys = arguments.keys(keys, "guard", "AllowList(folder)")
        self.journal: Journal | None = check.instance("journal", journal, Journal, type(None))
        if journal and (messages or workers):
            raise ValueError("a journal takes neither messages nor workers: it does one text after the other")
        not_for_anyone(check.endpoint(endpoint, "tcp://127.0.0.1:5554", lowest_port=0), open_to_anyone or keys)
        self.workers: WorkerThreads[Any] | None = None
        # The answers of the last requests, and the way back to whoever asks for one that is at work.
        self.known: OrderedDict[Any, list[Any]] = OrderedDict()
        self.begun: dict[Any, list[Any]] = {}
        self.stopped = threading.Event()
        self.thread: threading.Thread | None = None
        self.runner: threading.Thread | None = None
        with contextlib.ExitStack() as stack:
            # Whatever ends it.
            stack.callback(self.stopped.set)
            # The end of a context of its own waits until the port is free; and libzmq asks one authenticator in each.
            context = stack.enter_context(zmq.Context()) if context is None else arguments.context(context)
            self.socket: Socket = stack.enter_context(context.socket(zmq.ROUTER))
            limit(self.socket, 4 * LIMIT if messages else LARGEST_BYTES)
            if messages:
                # More large answers are dropped: a client that reads none fills no memory.
                self.socket.sndhwm = 10
            if keys:
                keys.answer(context)
                keys.guard(self.socket)
            self.endpoint = bind(self.socket, endpoint)
            stack.enter_context(answering(None if beacon is None else beacon_name("beacon", beacon), self.endpoint))
            # A byte through this pair wakes the thread with the ZeroMQ socket, on every system.
            self.wake_reader, self.wake_writer = map(stack.enter_context, sockets.socketpair())
            if workers:
                self.workers = WorkerThreads(workers, self.answer, self.made)
                stack.callback(self.workers.close)
            self.stack = stack.pop_all()
        log.info("listening on %s", self.endpoint)

    def run(self) -> None:
        """Answer until close(), or until Ctrl-C, which it passes on. Closed: it was closed before."""
        self.check_open()
        try:
            self.serve()
        except RuntimeError:
            # close() on another thread may have come first.
            self.check_open()
            raise

    def check_open(self) -> None:
        if self.stopped.is_set():
            raise Closed("this server is closed: make a new one")

    @one_at_a_time
    def serve(self) -> None:
        self.runner = threading.current_thread()
        if self.stopped.is_set():
            return
        poller = zmq.Poller()
        for each in filter(None, (self.socket, self.wake_reader, self.workers)):
            poller.register(each, zmq.POLLIN)
        with self.stack:
            while not self.stopped.is_set():
                # With a limit: on Windows Ctrl-C is heard only between two waits.
                poller.poll(SLICE_MS)
                for key, reply in self.workers.finished() if self.workers else ():
                    self.done(key, self.begun.pop(key), reply)
                # The message that is there may be a broken one, which the socket drops.
                with contextlib.suppress(zmq.Again):
                    for _ in range(MOST_MESSAGES):
                        # A Ctrl-C while pyzmq says that there is none would be lost.
                        if self.stopped.is_set() or not int(self.socket.getsockopt(zmq.EVENTS)) & zmq.POLLIN:
                            break
                        self.take(self.socket.recv_multipart(zmq.NOBLOCK, copy=not (self.messages or self.keys)))

    def take(self, frames: list[Any]) -> None:
        welcome = not self.keys or self.keys.name_of(frames[-1])
        if not self.messages and self.keys:
            frames = [frame.bytes for frame in frames]
        # An object of its own, which no other request has.
        key: Any = object()
        if self.messages:
            # An array may be empty as well: REQ's empty frame is the second one.
            start = 2 if len(frames) > 2 and not len(frames[1]) else 1
            way, id, body = frames[:start], b"", frames[start:]
        else:
            way, id, text = id_and_text(frames)
            body = [text]
            if id:
                # A way is kept as a number: it may be as long as its peer likes.
                key = (0 if len(id) >= LEAST_UNIQUE else hash(tuple(way)), id, text)
        if not welcome:
            self.send(way, self.refusal("refused", "your key is not on the list, or not any more"))
        elif self.journal:
            self.write_down(self.journal, way, id, body[0])
        elif key in self.known:
            self.send(way, self.known[key])
        elif not self.workers:
            self.done(key, way, self.made(self.answer, body))
        elif key in self.begun or len(self.begun) < MOST_BEGUN:
            if key not in self.begun:
                self.workers.begin(key, body)
            # The newest one: where a try before it came from, nobody listens any more.
            self.begun[key] = way
        else:
            self.send(way, self.refusal("busy", "busy, try again later"))

    def write_down(self, journal: Journal, way: list[Any], id: bytes, text: bytes) -> None:
        """Do it once. While the journal cannot be used there is no answer: whoever asks tries again."""
        with journal.watched():
            if not 0 < len(id) <= LONGEST_ID_BYTES:
                self.send(way, self.refusal("bad-id", f"expected [id][text], an id of 1 to {LONGEST_ID_BYTES} bytes"))
                return
            reply = journal.find(id) or journal.do(id, text_of(text), self.answer)
            self.send(way, [reply.encode()])

    def made(self, answer: Any, body: list[Any]) -> list[Any]:
        return message_reply(answer, body)[2] if self.messages else [reply_to(answer, body[0])]

    def refusal(self, code: str, text: str) -> list[Any]:
        if self.messages:
            return Message.refusal(MessageError(code, text)).frames()
        return [f"error: {text}".encode()]

    def done(self, key: Any, way: list[Any], reply: list[Any]) -> None:
        if isinstance(key, tuple) and self.remember:
            self.known[key] = reply
            if len(self.known) > self.remember:
                self.known.popitem(last=False)
        self.send(way, reply)

    def send(self, way: list[Any], reply: list[Any]) -> None:
        # Of a message its header: the arrays may be large.
        log.debug("%s: %s", self.endpoint, reply[:1])
        # It never waits: ROUTER drops the reply to a client that has gone, or does not read.
        # The next answer may use the memory of an array again, and so that is copied.
        self.socket.send_multipart([*way, *reply], zmq.NOBLOCK)

    def __enter__(self) -> Self:
        self.check_process()
        self.check_open()
        if self.thread:
            raise RuntimeError("this server has a thread already: make a second server")
        self.thread = threading.Thread(target=self.serve, name=f"netmq_example {self!r}", daemon=True)
        self.thread.start()
        return self

    def close(self) -> None:
        """End it, and give the port back. Twice is once."""
        # After a fork the thread, and what wakes it, are the parent's.
        if os.getpid() != self.process_id:
            return
        self.stopped.set()
        with contextlib.suppress(OSError):
            self.wake_writer.send(b"!")
        # In its answer, or in a signal's handler: it ends after that.
        if self.runner is threading.current_thread():
            return
        if self.thread:
            self.thread.join(CLOSE_SECONDS)
        if self.at_work.acquire(timeout=0 if self.thread else CLOSE_SECONDS):
            # Nobody runs it, who would have closed it at the end.
            self.stack.close()
            self.at_work.release()
        else:
            log.warning("%s is closed when its answer under way is made", self.endpoint)


class ServerOptions(TypedDict, total=False):
    """serve() takes these as Server does."""

    messages: bool
    workers: int
    remember: int
    journal: Journal | None
    keys: ServerKeys | None
    open_to_anyone: bool
    beacon: str | None
    context: Context | None


def serve(answer: Answer, endpoint: str, **options: Unpack[ServerOptions]) -> None:
    """Answer over this endpoint until Ctrl-C or SIGTERM, which end it without a traceback. The options are those of
    Server.
    """
    made: list[Server] = []
    with contextlib.suppress(KeyboardInterrupt), ended_by_sigterm():
        # A Ctrl-C while it is made would leave a socket that nobody closes, for which the end of its context waits.
        undisturbed(lambda: made.append(Server(answer, endpoint, **options)))
        with contextlib.closing(made[0]) as server:
            server.run()
