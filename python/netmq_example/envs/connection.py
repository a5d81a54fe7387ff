"""The connection of an environment with its simulator, which does every request exactly once.

    connection = Connection(socket, timeout=10)                 a bound ROUTER socket
    connection.wait(60, accept, ended)                          until a simulator says hello that `accept` likes
    answer = connection.ask(Record(ASKS, 0, sections))          to a Record a Record, to a Message a Message; or Lost

Each request has an id that counts. One that stays without an answer is sent again with the same id, and the simulator
answers a repeated id with what it has kept: so a retry never steps twice. A simulator that is gone is noticed when
a request is sent again, because a ROUTER socket can say that it has no way to a peer. The C# side is
EnvironmentClient.cs. It needs only pyzmq.
"""

import itertools
import time
from collections.abc import Callable
from typing import Any

import zmq

from netmq_example import arguments, check
from netmq_example.envs.common import OtherSide
from netmq_example.errors import Lost, Timeout
from netmq_example.messages import Message, MessageError
from netmq_example.one_connection import sent
from netmq_example.one_process import OneProcess
from netmq_example.wire import records
from netmq_example.wire.records import Record

# A request without an answer is sent again after so long, and then after twice as long each time, up to longest_pause.
RESEND_SECONDS = 1.0
# The answers to requests in words; other kinds of messages are ignored.
ANSWERS = {"render": "picture", "info": "told", "close": "closed"}

# Python decides when time passes, or the scene itself.
CLOCKS = ("python", "scene")

# It may return what is to be done once the simulator is welcomed.
Accept = Callable[[Message], Callable[[], None] | None]


class Connection(OneProcess):
    """A bound ROUTER socket. It waits in slices of its receive timeout: on Windows Ctrl-C interrupts no longer wait."""

    def __init__(self, socket: zmq.Socket[bytes], timeout: float) -> None:
        self.timeout = check.seconds("timeout", timeout)
        if not hasattr(socket, "recv_multipart"):
            raise TypeError(f"socket takes a bound ROUTER socket, not {socket!r:.40}")
        self.socket = arguments.blocking("socket", socket, object)
        self.other_side = socket if isinstance(socket, OtherSide) else OtherSide()
        self.endpoint = socket.getsockopt_string(zmq.LAST_ENDPOINT)
        # To send to a peer that is gone is then an error, and not silence.
        socket.router_mandatory = True
        self.peer = b""
        self.id = 0
        self.closed = False

    def wait(self, limit: float, accept: Accept, ended: Callable[[], str]) -> None:
        """Wait so many seconds for a simulator's hello, or until `ended` says that its program has ended.

        What `accept` raises is sent to the simulator as well.
        """
        self.check_process()
        self.peer = b""
        end = time.monotonic() + limit
        while not self.is_welcomed(accept):
            if why := ended():
                raise Timeout(why)
            if time.monotonic() > end:
                within = f"within {round(limit, 1):g} s"
                raise Timeout(f"no simulator came to {self.endpoint} {within}; {self.other_side.state}")

    def is_welcomed(self, accept: Accept) -> bool:
        """Whether the next message was the hello of a simulator, which then is the peer."""
        peer, hello = self.receive()
        if hello is None:
            return False
        if isinstance(hello, Message) and hello.values.get("code") == "gave-up":
            # The scene is wrong, and says so before it ends.
            raise MessageError("gave-up", str(hello.values.get("text", ""))[:200])
        if not isinstance(hello, Message) or hello.kind != "hello":
            # It was given up, and has not noticed.
            self.refuse(peer, MessageError("unknown-peer", "say hello again"))
            return False
        try:
            check_release(hello)
            then = accept(hello)
        except MessageError as error:
            self.refuse(peer, error)
            raise
        # One that has said hello and is gone already is none.
        if sent(self.socket, peer, Message("welcome", hello.id).frames()):
            self.peer = peer
            if then:
                then()
        return bool(self.peer)

    def ask(self, request: Any) -> Any:
        """The answer to a request; MessageError is the simulator's refusal, or says what is wrong with its answer.

        A Record is answered with a Record, a Message with a Message. The request gets its id here.
        """
        self.check_process()
        if self.closed:
            raise ValueError("this environment is closed")
        self.id += 1
        request.id = self.id
        frames = request.frames()
        end = time.monotonic() + self.timeout
        pause = RESEND_SECONDS
        while time.monotonic() < end:
            if not self.peer or not sent(self.socket, self.peer, frames):
                why = self.other_side.gone
                break
            answer = self.answer(min(end, time.monotonic() + pause))
            if answer:
                return checked(request, answer)
            pause = min(2 * pause, self.other_side.longest_pause)
        else:
            why = f"no answer to {name_of(request)} within {self.timeout:g} s"
        self.peer = b""
        raise Lost(why)

    def answer(self, end: float) -> Any:
        while time.monotonic() < end:
            peer, message = self.receive()
            # Another id is an answer that came twice, or too late: its request is over.
            if message and peer == self.peer and message.id == self.id:
                return message
            if message and peer != self.peer:
                self.refuse(peer, MessageError("busy", "this environment has its simulator: one at a time"))
        return None

    def receive(self) -> tuple[bytes, Any]:
        """The sender and the message or record; nothing if nothing came, or nothing that is one."""
        try:
            peer, *frames = self.socket.recv_multipart()
        except zmq.Again:
            return b"", None
        try:
            return peer, records.read_frames(records.ANSWERS, frames)
        except MessageError as error:
            self.refuse(peer, error)
            if peer == self.peer:
                raise
            return peer, None

    def refuse(self, peer: bytes, error: MessageError) -> None:
        sent(self.socket, peer, Message.refusal(error).frames())


def check_release(hello: Message) -> None:
    record, clock = hello.values.get("record", 1), hello.values.get("clock", "python")
    if record != records.RECORD or clock not in CLOCKS:
        theirs = f"the simulator speaks record {record!a:.20} by the clock {clock!a:.20}"
        ours = f"this environment {records.RECORD} by {' or '.join(CLOCKS)}"
        raise MessageError("old-record", f"{theirs}, {ours}: update the one that is older")


def name_of(request: Any) -> str:
    if isinstance(request, Record):
        if request.bits & records.SCENE_CLOCK:
            return "reset" if request.bits & records.ANEW else "step"
        return "step" if request.has(records.STEP) or request.has(records.LAST) else "reset"
    return str(request.kind)


def checked(request: Any, answer: Any) -> Any:
    if isinstance(answer, Message) and answer.kind == "error":
        code, text = (str(answer.values.get(name, "not said")) for name in ("code", "text"))
        if code == "unknown-peer":
            # Lesson 17's hub knows nobody when it has been started anew.
            raise Lost("the hub does not know this trainer: it was started anew, or the line was cut")
        raise MessageError(code[:40], text[:200])
    if isinstance(request, Record):
        if not isinstance(answer, Record):
            raise MessageError("wrong-kind", f"{answer.kind!a:.40} is no answer to {name_of(request)}")
        # By the scene's clock it is the scene that says whose turn it is.
        asked_of = [] if request.bits & records.SCENE_CLOCK else request.sections
        for asked, told in itertools.zip_longest(asked_of, answer.sections[: len(asked_of)]):
            if told is None or told.kind != asked.kind or len(told.marks) != len(asked.marks) or told.who:
                raise MessageError("wrong-agents", "the answer is not of those that were asked")
    elif not isinstance(answer, Message) or answer.kind != ANSWERS.get(request.kind, answer.kind):
        raise MessageError("wrong-kind", f"{getattr(answer, 'kind', 0)!a:.40} is no answer to {request.kind}")
    return answer
