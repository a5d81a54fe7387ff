"""What every program of this kit does besides its lesson: options, limits, the ready line, Ctrl-C. It needs only pyzmq.

    def main() -> None:
        options = server_options(__doc__, "tcp://127.0.0.1:5551").parse_args()
        with listening(zmq.REP, options) as socket:             binds, and prints: listening on tcp://127.0.0.1:5551
            while True:
                socket.send_multipart(receive(socket))

    run(main)

A client has client_options, connected and run(main, stopped="stopped"). Shared/NetMQConnection.cs is its C# version.
"""

import argparse
import contextlib
import io
import math
import os
import re
import signal
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import zmq

from netmq_example import check, interrupts
from netmq_example.beacon import answering, cure
from netmq_example.console import log_lines, printable, show, unhindered
from netmq_example.errors import Error, ListenError, MessageError, Timeout
from netmq_example.options import (
    Options,
    a_name,
    at_least_one,
    client_endpoint,
    client_options,
    option,
    positive_seconds,
    seconds,
    server_endpoint,
    server_options,
    whole,
    wrong_usage,
)

__all__ = [
    "LARGEST_BYTES",
    "SLICE_MS",
    "Context",
    "Options",
    "Socket",
    "a_name",
    "at_least_one",
    "bind",
    "client_endpoint",
    "client_options",
    "connected",
    "encoded",
    "few_answers_wait",
    "importing",
    "limit",
    "listening",
    "more_files",
    "not_for_anyone",
    "option",
    "positive_seconds",
    "printable",
    "receive",
    "receive_frames",
    "run",
    "seconds",
    "server_endpoint",
    "server_options",
    "show",
    "text_of",
    "whole",
    "wrong_usage",
]

Context = zmq.Context[zmq.Socket[bytes]]
Socket = zmq.Socket[bytes]
T = TypeVar("T")

if sys.platform != "win32":
    import resource

# The longest wait in one piece, in milliseconds: on Windows Ctrl-C is heard only between two waits.
SLICE_MS = 200
# The largest frame of a text message, in bytes. A peer that announces a larger one is disconnected before it arrives.
LARGEST_BYTES = 65_536
# What waits on a connection to be read, or two messages: ZeroMQ itself counts only messages, up to 1000.
WAITING_BYTES = 64 * 1024 * 1024
# More open files than that no program of this kit needs.
MOST_FILES = 8192
# With fewer libzmq ends a program in the middle of its work, without a word of ours.
LEAST_FILES = 32
# The port is taken, most often by an older start of the same server.
IN_USE = "end the server that has it in another terminal"
LOOPBACK = re.compile(r"tcp://(localhost|127\.[\d.]+):|(ipc|inproc)://")


@contextlib.contextmanager
def listening(
    kind: int,
    options: argparse.Namespace,
    largest: int = LARGEST_BYTES,
    prepare: Callable[[Context, Socket], object] | None = None,
    endpoint: str = "",
    word: str = "listening",
) -> Iterator[Socket]:
    """A bound socket of this kind, such as zmq.REP, and the ready line.

    `prepare` gets the context and the socket before it listens, as a lesson with keys needs it. A second socket has its
    own `endpoint`, and another `word` in its line; without a word there is no line.
    """
    endpoint = endpoint or options.endpoint
    try:
        not_for_anyone(endpoint, options.open_to_anyone or getattr(options, "keys", None), "add --open-to-anyone")
    except ValueError as error:
        print(f"refused: {error}", file=sys.stderr)
        sys.exit(2)
    with zmq.Context() as context, context.socket(kind) as socket:
        limit(socket, largest)
        socket.rcvtimeo = SLICE_MS
        if prepare:
            prepare(context, socket)
        try:
            bound = bind(socket, endpoint, "try --endpoint tcp://127.0.0.1:0, which takes a free port")
        except ListenError as error:
            # Printed here: in a thread nobody would hear of it.
            print(error, file=sys.stderr)
            sys.exit(1)
        with answering(getattr(options, "beacon", None), bound):
            if word:
                print(f"{word} on {bound}", flush=True)
            yield socket


def not_for_anyone(endpoint: str, allowed: Any, cure: str = "say open_to_anyone=True") -> None:
    """ValueError for a server's endpoint that other machines reach, unless it is allowed."""
    if not (LOOPBACK.match(endpoint) or allowed):
        raise ValueError(f"'{endpoint}' would let anyone in, who could end it; use lesson 15's keys, or {cure}")


def cannot_listen(endpoint: str, error: zmq.ZMQError, cure: str) -> ListenError:
    return ListenError(error.errno, f"cannot listen on {endpoint}: {zmq.strerror(error.errno or 0)}; {cure}")


def bind(socket: Socket, endpoint: str, cure: str = "tcp://127.0.0.1:0 takes a free port") -> str:
    """Bind it, and say where: port 0 and * have become a free one. ListenError says why it cannot, with the cure."""
    try:
        socket.bind(endpoint)
    except zmq.ZMQError as error:
        if error.errno == zmq.EADDRINUSE:
            cure = f"{IN_USE}, or {cure}"
        raise cannot_listen(endpoint, error, cure) from None
    return socket.getsockopt_string(zmq.LAST_ENDPOINT)


@contextlib.contextmanager
def connected(kind: int, options: argparse.Namespace, largest: int = LARGEST_BYTES) -> Iterator[Socket]:
    """A connected socket of this kind. Timeout says that nothing came, or that there was nowhere to send to."""
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context, context.socket(kind) as socket:
        limit(socket, largest)
        # Sending does not wait: without a connection it raises zmq.Again, and queues nothing.
        socket.rcvtimeo, socket.sndtimeo = SLICE_MS, 0
        socket.connect(options.endpoint)
        try:
            yield socket
        except zmq.Again:
            why = cure(options.endpoint, f"is the server running, or its reply over {largest >> 10} KB?")
            raise Timeout(f"no reply from {options.endpoint} within {options.timeout:g} s; {why}") from None


def limit(socket: Socket, largest: int = LARGEST_BYTES) -> None:
    """The limits of every socket: what nobody fetched goes at the end, and neither a frame nor many fill the memory."""
    socket.linger = 0
    socket.maxmsgsize = largest
    if largest > LARGEST_BYTES:
        socket.rcvhwm = max(2, WAITING_BYTES // largest)


def few_answers_wait(context: Context, socket: Socket) -> None:
    """To `prepare` a server with large answers. More are dropped: a client that reads none fills no memory."""
    socket.sndhwm = 10


def more_files() -> int:
    """How many files this program may have open from now on. A client of a gateway or a gate takes three: its
    connection, its ZeroMQ socket, and that one's connection. Often 1024 are allowed."""
    if sys.platform == "win32":
        # There is no such limit.
        return MOST_FILES
    now, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = most if 0 < most < MOST_FILES else MOST_FILES
    if 0 < now < wanted:
        try:
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, most))
        except (ValueError, OSError):
            # Where it cannot be raised, it stays as it is.
            return now
    return wanted


def receive(socket: Socket, timeout: float = math.inf) -> list[bytes]:
    """The frames of the next message; zmq.Again if none comes within `timeout` seconds."""
    return next_message(socket.recv_multipart, timeout)


def receive_frames(socket: Socket, timeout: float = math.inf) -> list[zmq.Frame]:
    """The same, not copied into bytes: for large frames, and where it counts who sent one."""
    return next_message(lambda: socket.recv_multipart(copy=False), timeout)


def next_message(recv_multipart: Callable[[], list[T]], timeout: float) -> list[T]:
    end = time.monotonic() + timeout
    while True:
        try:
            return recv_multipart()
        except zmq.Again:
            if time.monotonic() >= end:
                raise


def encoded(text: str, errors: str = "replace") -> bytes:
    """In UTF-8, to be sent in one frame. MessageError if it is too long: the peer would hang up, without a word."""
    data = check.instance("text", text, str).encode(errors=errors)
    if len(data) > LARGEST_BYTES:
        raise MessageError(f"a text of {len(data)} bytes, more than {LARGEST_BYTES}: lesson 05 carries more")
    return data


def text_of(frame: bytes) -> str:
    """Its text; of one that is no UTF-8 how long it is, in brackets. The text of a message is that of all its frames,
    with a blank between them.
    """
    with contextlib.suppress(UnicodeDecodeError):
        return frame.decode()
    return f"({len(frame)} bytes)"


@contextlib.contextmanager
def importing(needs: str, stopped: str | None = None) -> Iterator[None]:
    """Around the imports of large packages. One that is missing is named with its cure, and Ctrl-C is heard already."""
    try:
        yield
    except ImportError as error:
        # Beyond the colon stands how it is installed without the kit.
        why = str(error).partition(": ")[0] if isinstance(error, ModuleNotFoundError) else error
        raise SystemExit(f"{why}: this lesson needs {needs}") from None
    except KeyboardInterrupt:
        raise SystemExit(stopped) from None


def run(main: Callable[[], None], stopped: str | None = None) -> None:
    """Run a program to its end. Ctrl-C ends a server with code 0, and a client with `stopped` and code 1.

    Its end is `from None`: in a notebook %run shows every error that one was raised from.
    """
    if stopped is None:
        sys.stdout, sys.stderr = unhindered(sys.stdout), unhindered(sys.stderr)
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program. A program that
    # was started without a console has no output at all.
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(encoding="utf-8", errors="replace")
    # SIGTERM, which kill and process managers send, ends a program as Ctrl-C does; on Windows that is SIGBREAK.
    interrupts.listen(signal.SIGINT, getattr(signal, "SIGBREAK", signal.SIGTERM))
    log_lines()
    try:
        if (files := more_files()) < LEAST_FILES:
            raise OSError(f"it may open {files} files, and needs {LEAST_FILES}: allow more, as by ulimit -n 1024")
        main()
    except ListenError as error:
        raise SystemExit(str(error)) from None
    except (TimeoutError, Error) as error:
        raise SystemExit(f"gave up: {printable(str(error), most=1000)}") from None
    except KeyboardInterrupt:
        raise SystemExit(stopped) from None
    except BrokenPipeError:
        # Nobody reads any more, as behind `| head -1`. What is still to be written goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(1) from None
    except OSError as error:
        raise SystemExit(f"failed: {error}") from None
