"""Every program of this kit has this besides its lesson: options, limits, the ready line, Ctrl-C. It needs only pyzmq.

    def main() -> None:
        options = server_options(__doc__, "tcp://127.0.0.1:5551").parse_args()
        with listening(zmq.REP, options) as socket:             binds, and prints: listening on tcp://127.0.0.1:5551
            while True:
                socket.send(reply_to(answer, receive(socket)[0]))

    run(main)

A client has asking.py besides. Shared/NetMQConnection.cs is the C# version of both.
"""

import argparse
import contextlib
import functools
import io
import math
import os
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeVar

import zmq

from netmq_example import check, console
from netmq_example.console import printable as printable
from netmq_example.console import show as show
from netmq_example.errors import Error, ListenError, MessageError, Misfit

Context = zmq.Context[zmq.Socket[bytes]]
Socket = zmq.Socket[bytes]
T = TypeVar("T")

# The longest wait in one piece, in milliseconds: on Windows Ctrl-C is heard only between two waits.
SLICE_MS = 200
# The largest frame of a text message, in bytes. A peer that announces a larger one is disconnected before it arrives.
LARGEST_BYTES = 65_536
# So many bytes, or eight messages, may wait on a connection to be read: ZeroMQ itself counts only messages, up to 1000.
# Of fewer than eight it tells its other thread too often that one was read, which takes as long as a small message.
WAITING_BYTES = 64 * 1024 * 1024
# No program of this kit needs more open files; and with fewer than the least libzmq ends it without a word of ours.
MOST_FILES = 8192
LEAST_FILES = 32
# The port is taken, most often by an older start of the same server.
IN_USE = "end the server that has it in another terminal"
LOOPBACK = re.compile(r"tcp://(localhost|127\.[\d.]+):|(ipc|inproc)://")


class Options(argparse.ArgumentParser):
    """In a thread of another program, or in a notebook, a server has its defaults: the words are that program's."""

    def parse_args(self, words: Any = None, namespace: Any = None) -> Any:
        # A notebook has no file, and the words are those of its kernel. A program of python -c has its own.
        is_program = hasattr(sys.modules["__main__"], "__file__") or sys.argv[:1] == ["-c"]
        if words is None and not (is_program and threading.current_thread() is threading.main_thread()):
            words = []
        found = super().parse_args(words, namespace)
        if getattr(found, "until_eof", False):
            from netmq_example.trouble import at_eof

            threading.Thread(target=at_eof, daemon=True).start()
        return found


def server_options(about: str | None, endpoint: str) -> argparse.ArgumentParser:
    """The options of every server. `about` is the program's docstring, whose first line its --help shows."""
    parser = Options(description=(about or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=server_endpoint(endpoint), default=endpoint, help="port 0 takes a free one")
    parser.add_argument("--open-to-anyone", action="store_true", help="other machines too: each can end the server")
    parser.add_argument("--beacon", type=beacon, metavar="NAME", help="clients may look for it as beacon://NAME:PORT")
    parser.add_argument("--until-eof", action="store_true", help="end when standard input does: with what started it")
    return parser


def beacon(text: str) -> Callable[[str], contextlib.AbstractContextManager[None]]:
    try:
        from netmq_example.beacon import answering, beacon_name
    except ModuleNotFoundError:
        raise argparse.ArgumentTypeError("this copy lacks it: kit.py copy netmq_example.beacon FOLDER") from None
    return functools.partial(answering, option(beacon_name, text, str))


def seconds(text: str) -> float:
    """From 0 to a day."""
    return option(lambda name, value: check.seconds(name, value, zero=True), text, float)


def whole(text: str) -> int:
    """A whole number, 0 or more."""
    return option(lambda name, value: check.count(name, value, least=0), text, int)


def option(rule: Callable[[str, Any], T], text: str, kind: Callable[[str], Any]) -> T:
    """A text that keeps to this rule of check.py. argparse itself names the option."""
    value: Any = text
    with contextlib.suppress(ValueError):
        value = kind(text)
    try:
        return rule("it", value)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def server_endpoint(example: str) -> Callable[[str], str]:
    """The type of an endpoint to bind: port 0 and * stand for a free port."""
    return lambda text: checked(text, example, lowest_port=0)


def checked(text: str, example: str, lowest_port: int, beacon: bool = False) -> str:
    # With a scheme of its own libzmq would be asked: a program has only what its example has.
    if not text.startswith((example.partition("//")[0], "beacon:")):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {example}")
    return option(lambda _, value: check.endpoint(value, example, lowest_port, beacon), text, str)


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
    announced = getattr(options, "beacon", None) or contextlib.nullcontext
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
        with announced(bound):
            if word:
                print(f"{word} on {bound}", flush=True)
            yield socket


def not_for_anyone(endpoint: str, allowed: Any, cure: str = "say open_to_anyone=True") -> None:
    """ValueError for a server's endpoint that other machines reach, unless it is allowed."""
    if not (LOOPBACK.match(endpoint) or allowed):
        raise ValueError(f"'{endpoint}' would let anyone in, who could end it; use lesson 15's keys, or {cure}")


def cannot_listen(endpoint: str, error: zmq.ZMQError | OSError, cure: str, why: str | None = None) -> ListenError:
    return ListenError(error.errno, f"cannot listen on {endpoint}: {why or zmq.strerror(error.errno or 0)}; {cure}")


def bind(socket: Socket, endpoint: str, cure: str = "tcp://127.0.0.1:0 takes a free port") -> str:
    """Bind it, and say where: port 0 and * have become a free one. ListenError says why it cannot, with the cure."""
    try:
        socket.bind(endpoint)
    except zmq.ZMQError as error:
        if error.errno == zmq.EADDRINUSE:
            cure = f"{IN_USE}, or {cure}"
        raise cannot_listen(endpoint, error, cure) from None
    return socket.getsockopt_string(zmq.LAST_ENDPOINT)


def limit(socket: Socket, largest: int = LARGEST_BYTES) -> None:
    """The limits of every socket: what nobody fetched goes at the end, and neither a frame nor many fill the memory."""
    socket.linger = 0
    socket.maxmsgsize = largest
    if largest > LARGEST_BYTES:
        socket.rcvhwm = max(8, WAITING_BYTES // largest)


def receive(socket: Socket, timeout: float = math.inf, take: Any = zmq.Socket.recv_multipart) -> list[Any]:
    """The frames of the next message, as `take` takes them; zmq.Again if none comes within `timeout` seconds."""
    end = time.monotonic() + timeout
    while True:
        try:
            return take(socket)  # type: ignore[no-any-return]
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


def reply_to(answer: Callable[[str], str], request: bytes) -> bytes:
    """The reply that `answer` gives to a request. A mistake in it is reported to both sides, and ends neither."""
    try:
        return sendable(answer(text_of(request)))
    except BaseException as error:
        # Most servers never need it.
        try:
            from netmq_example.trouble import told
        except OSError as lacking:
            return encoded(f"error: {lacking}")
        return encoded(told(error))


def sendable(text: str) -> bytes:
    """The answer in UTF-8. Misfit says why it cannot be sent, which may lie in the request."""
    if not isinstance(text, str):
        raise Misfit(f"answer returned {text!r:.40}: return a text")
    try:
        return encoded(text, "strict")
    except ValueError as error:
        raise Misfit(f"answer returned what cannot be sent: {error}") from None


def more_files() -> int:
    """How many files this program may have open from now on. A client of a gateway or a gate takes three: its
    connection, its ZeroMQ socket, and that one's connection. Often 1024 are allowed."""
    if sys.platform == "win32":
        # There is no such limit.
        return MOST_FILES
    import resource

    now, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = most if 0 < most < MOST_FILES else MOST_FILES
    if 0 < now < wanted:
        # Where it cannot be raised, it stays as it is.
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, most))
        return resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return wanted


def run(main: Callable[[], None], stopped: str | None = None) -> None:
    """Run a program to its end. Ctrl-C ends a server with code 0, and a client with `stopped` and code 1.

    Its end is `from None`: in a notebook %run shows every error that one was raised from.
    """
    if stopped is None:
        sys.stdout, sys.stderr = console.unhindered(sys.stdout), console.unhindered(sys.stderr)
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program. A program that
    # was started without a console has no output at all.
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(encoding="utf-8", errors="replace")
    # SIGTERM, which kill and process managers send, ends a program as Ctrl-C does; on Windows that is SIGBREAK.
    console.listen(signal.SIGINT, getattr(signal, "SIGBREAK", signal.SIGTERM))
    console.log_lines()
    try:
        if (files := more_files()) < LEAST_FILES:
            raise OSError(f"it may open {files} files, and needs {LEAST_FILES}: allow more, as by ulimit -n 1024")
        main()
    except ListenError as error:
        raise SystemExit(str(error)) from None
    except (TimeoutError, Error) as error:
        raise SystemExit(f"gave up: {console.printable(str(error), most=1000)}") from None
    except KeyboardInterrupt:
        raise SystemExit(stopped) from None
    except BrokenPipeError:
        # Nobody reads any more, as behind `| head -1`. What is still to be written goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(1) from None
    except OSError as error:
        raise SystemExit(f"failed: {error}") from None


# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:

    def __getattr__(name):
        # Each import asks for __path__.
        if name.startswith("__"):
            raise AttributeError(name)
        try:
            from netmq_example.former import from_program
        except ModuleNotFoundError:
            raise AttributeError(name) from None
        return from_program(name)
