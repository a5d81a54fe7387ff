"""Lesson 09, the simulators: where they come from, by hand or launched, and that none is left behind.

Lesson 09, a launched simulator: found by its path, and ended with all that it has started.

It needs only Python.

Lesson 09, the connection: one simulator at a time, and every request is done exactly once.

Each request has an id that counts. One that stays without an answer is sent again with the same id, and the simulator
answers a repeated id with what it has kept: so a retry never steps twice. A simulator that is gone is noticed within
a second, because a ROUTER socket can say that it has no way to a peer.
"""

import contextlib
import glob
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import zmq

from netmq_example.messages import LIMIT, Array, Message, MessageError, read


def game(path: str) -> str:
    """The program that is meant by a build's path: each system has an ending, or a folder, of its own for it."""
    if program := shutil.which(path):
        return os.path.abspath(program)
    ending = {"win32": ".exe", "darwin": ".app/Contents/MacOS/*"}.get(sys.platform, ".x86_64")
    for way in (glob.escape(path), glob.escape(path) + ending):
        for found in filter(os.path.isfile, sorted(glob.glob(way))):
            # What was unpacked from an archive may have forgotten that it is a program.
            if not os.access(found, os.X_OK):
                os.chmod(found, 0o755)
            return os.path.abspath(found)
    raise FileNotFoundError(f"no game at {path}: there is neither this file nor {path}{ending}")


def start_program(words: Sequence[str]) -> subprocess.Popen[bytes]:
    """In a session of its own, so that all of it can be ended; Ctrl-C is then for Python alone, which ends it."""
    return subprocess.Popen(words, start_new_session=True)


def end_program(process: subprocess.Popen[bytes]) -> None:
    """Let it end by itself for a moment, then end what is left: the simulator may be a child, as of `dotnet run`."""
    try:
        process.wait(2)
    except subprocess.TimeoutExpired:
        pass
    finally:
        if sys.platform == "win32":
            subprocess.run(["taskkill", "/T", "/F", "/PID", str(process.pid)], capture_output=True, check=False)
        else:
            # Nobody may be left.
            with contextlib.suppress(OSError):
                os.killpg(process.pid, signal.SIGKILL)
        process.wait()


# Seconds after which a request is sent again.
AGAIN = 1.0
# What Gymnasium's requests are answered with. Other lessons have others.
ANSWERS = {"reset": "state", "step": "state", "render": "picture"}


class Lost(ConnectionError):
    """The simulator is gone, or has not answered for too long."""


class Connection:
    """A bound ROUTER socket. It waits in slices of its receive timeout: on Windows Ctrl-C interrupts no longer wait."""

    def __init__(self, socket: zmq.Socket[bytes], timeout: float) -> None:
        self.socket, self.timeout, self.endpoint = socket, timeout, socket.getsockopt_string(zmq.LAST_ENDPOINT)
        # To send to a peer that is gone is then an error, and not silence.
        socket.router_mandatory = True
        self.peer, self.id, self.closed = b"", 0, False

    def wait(self, limit: float, accept: Callable[[Message], None], ended: Callable[[], int | None]) -> None:
        """Wait for a simulator's hello, until its program has ended. What `accept` raises, it is told as well."""
        self.peer, end = b"", time.monotonic() + limit
        while not self.peer:
            peer, hello = self.receive()
            if hello and hello.kind == "hello":
                try:
                    accept(hello)
                except MessageError as error:
                    self.refuse(peer, error)
                    raise
                # One that has said hello and is gone already is none.
                self.peer = peer if self.send(peer, "welcome", hello.id) else b""
            elif hello:
                # It was given up, and has not noticed.
                self.refuse(peer, MessageError("unknown-peer", "say hello again"))
            if not self.peer and (code := ended()) is not None:
                raise TimeoutError(f"the launched simulator ended with code {code}, and never came to {self.endpoint}")
            if not self.peer and time.monotonic() > end:
                why = getattr(self.socket, "told", "is it running?")
                raise TimeoutError(f"no simulator came to {self.endpoint} within {limit:g} s; {why}")

    def ask(self, kind: str, values: dict[str, Any], arrays: list[Array]) -> Message:
        """The answer to a request; MessageError is the simulator's refusal, or says what is wrong with its answer."""
        if self.closed:
            raise ValueError("this environment is closed")
        self.id += 1
        end, why = time.monotonic() + self.timeout, f"no answer to {kind} within {self.timeout:g} s"
        while time.monotonic() < end:
            if not self.peer or not self.send(self.peer, kind, self.id, values, arrays):
                why = getattr(self.socket, "gone", "the simulator is gone")
                break
            if answer := self.answer(min(end, time.monotonic() + AGAIN)):
                if answer.kind == "error":
                    code, text = (str(answer.values.get(name, "not said")) for name in ("code", "text"))
                    # Lesson 17's hub knows nobody when it has been started anew.
                    raise Lost("the hub is new") if code == "unknown-peer" else MessageError(code[:40], text[:200])
                if answer.kind != ANSWERS.get(kind, answer.kind):
                    raise MessageError("wrong-kind", f"{answer.kind!a:.40} is no answer to {kind}")
                return answer
        self.peer = b""
        raise Lost(why)

    def answer(self, end: float) -> Message | None:
        while time.monotonic() < end:
            peer, message = self.receive()
            # Another id is an answer that came twice, or too late: its request is over.
            if message and peer == self.peer and message.id == self.id:
                return message
            if message and peer != self.peer:
                self.refuse(peer, MessageError("busy", "this environment has its simulator: one at a time"))
        return None

    def receive(self) -> tuple[bytes, Message | None]:
        """Who sent something, and the message: none if nothing came, or nothing that is a message."""
        try:
            peer, *frames = self.socket.recv_multipart()
        except zmq.Again:
            return b"", None
        try:
            return peer, read(frames)
        except MessageError as error:
            self.refuse(peer, error)
            if peer == self.peer:
                raise
            return peer, None

    def refuse(self, peer: bytes, error: MessageError) -> None:
        self.send(peer, "error", error.id, {"code": error.code, "text": error.text})

    def send(self, peer: bytes, kind: str, id: int, values: Any = None, arrays: Any = None) -> bool:
        """False if the peer is gone, or takes nothing any more."""
        try:
            self.socket.send_multipart([peer, *Message(kind, id, values or {}, arrays or []).frames()], zmq.NOBLOCK)
        except zmq.ZMQError:
            return False
        return True


ENDPOINT, FREE = "tcp://127.0.0.1:5559", "tcp://127.0.0.1:*"


def bound(endpoint: str) -> zmq.Socket[bytes]:
    # libzmq itself would listen on port 99999 - 65536 without a word.
    port = re.fullmatch(r"tcp://[\w.*-]+:(\*|\d{1,5})", endpoint, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise ValueError(f"bad endpoint '{endpoint}': write it like {ENDPOINT}, port 0 to 65535")
    context = zmq.Context()
    socket = context.socket(zmq.ROUTER)
    # Who announces more than the largest message is disconnected before it is in memory. One answer is under way; what
    # others send while nobody listens must not fill the memory.
    socket.maxmsgsize, socket.rcvhwm = 4 * LIMIT, 10
    # At its end so many milliseconds for what it has said last, such as why it refused a simulator.
    socket.linger, socket.rcvtimeo = 500, 200
    try:
        socket.bind(endpoint)
    except zmq.ZMQError as error:
        context.destroy()
        cure = f"if another trainer has it, give this one its own endpoint, such as {FREE}"
        raise OSError(f"cannot listen on {endpoint}: {zmq.strerror(error.errno or 0)}; {cure}") from None
    return socket


class Simulators:
    """`launch` is a path as `game` takes it, or a list: a program and its first words; `--endpoint` follows. Without it
    one waits for Play.

    `wait` is how many seconds for a simulator, `timeout` how many for each answer. A socket that is given is not
    closed.
    """

    def __init__(
        self,
        endpoint: str = "",
        launch: str | os.PathLike[str] | Sequence[str] | None = (),
        wait: float = 60,
        timeout: float = 10,
        socket: zmq.Socket[bytes] | None = None,
        default: str = ENDPOINT,
    ) -> None:
        for name, seconds in ("wait", wait), ("timeout", timeout):
            if not isinstance(seconds, int | float) or not 0 < seconds <= 86400:
                raise ValueError(f"{name} takes seconds, more than 0 and at most a day, not {seconds!r:.40}")
        words = [launch] if isinstance(launch, str | os.PathLike) else list(launch or ())
        self.launch = [game(os.fspath(words[0])), *words[1:]] if launch else []
        self.limit, self.own, self.pid = wait, socket is None, os.getpid()
        # Each one that launches has a port of its own: several environments at once are no trouble.
        self.connection = Connection(socket or bound(endpoint or (FREE if launch else default)), timeout)
        self.process: subprocess.Popen[bytes] | None = None

    def find(self, accept: Callable[[Message], None]) -> None:
        """Wait for a simulator that `accept` likes."""
        endpoint = self.connection.endpoint
        if not self.launch:
            print(f"waiting for a simulator on {endpoint}: press Play", flush=True)
        else:
            # One that was lost may still be there, and hang.
            self.end()
            self.process = start_program([*self.launch, "--endpoint", endpoint])
        self.connection.wait(self.limit, accept, lambda: self.process.poll() if self.process else None)

    def begin(self, accept: Callable[[Message], None], ask: Callable[[Lost | None], Any]) -> Any:
        """What `ask` for a reset returns, in another simulator if one is lost; it is told what was lost before.

        The next one may be lost as well: lesson 17's hub is started anew just then. Or each one ends of a reset, so
        that after three it is over.
        """
        lost = None
        for _ in range(2):
            try:
                return ask(lost)
            except Lost as why:
                lost = why
                self.find(accept)
        return ask(lost)

    def end(self) -> None:
        if process := self.process:
            self.process = None
            end_program(process)

    def close(self) -> None:
        if self.connection.closed or os.getpid() != self.pid:
            # A process that was forked has a copy of this, and the simulator is not its own.
            return
        self.connection.timeout = min(2, self.connection.timeout)
        try:
            # It answers: a connection that ends right after a message may take the message with it.
            self.connection.ask("close", {}, [])
        except (Lost, MessageError):
            pass
        finally:
            self.connection.closed = True
            self.end()
            if self.own:
                self.connection.socket.context.destroy()
