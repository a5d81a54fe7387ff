"""A client's program does this besides its lesson: its socket, its words where nothing comes, and rarer options.

options = client_options("Says Hello.", "tcp://127.0.0.1:5551", timeout=2.5).parse_args()
with connected(zmq.REQ, options) as socket:
    socket.send(b"Hello")
    print(receive(socket, options.timeout))
"""

import argparse
import contextlib
from collections.abc import Callable, Iterator

import zmq

from netmq_example import check
from netmq_example.errors import Error, Timeout
from netmq_example.program import LARGEST_BYTES, SLICE_MS, Options, Socket, checked, limit, option
from netmq_example.trouble import cure, unknown_host


def client_options(about: str, endpoint: str, timeout: float, beacon: bool = False) -> argparse.ArgumentParser:
    """The options of every client. `timeout` is the default of --timeout, in seconds.

    With `beacon` the endpoint may be beacon://NAME:PORT, for which the client has a BeaconSearch.
    """
    parser = Options(description=about)
    parser.add_argument("--endpoint", type=client_endpoint(endpoint, beacon), default=endpoint, help="the server")
    parser.add_argument("--timeout", type=positive_seconds, default=timeout, help="seconds to wait for each reply")
    return parser


def client_endpoint(example: str, beacon: bool = False) -> Callable[[str], str]:
    """The type of an endpoint to connect to. Its host must be known: libzmq would wait for one that does not exist."""

    def known(text: str) -> str:
        if unknown := unknown_host(checked(text, example, 1, beacon)):
            raise argparse.ArgumentTypeError(f"bad endpoint '{text}': {unknown}; check it")
        return text

    return known


def positive_seconds(text: str) -> float:
    """More than 0, at most a day."""
    return option(check.seconds, text, float)


def at_least_one(text: str) -> int:
    """A whole number, 1 or more."""
    return option(check.count, text, int)


@contextlib.contextmanager
def wrong_usage(parser: argparse.ArgumentParser, before: str = "", after: str = "") -> Iterator[None]:
    """Put it around the use of options: a wrong one is named in one line, and the exit code is 2."""
    try:
        yield
    except (ValueError, Error) as error:
        parser.error(f"{before}{error}{after}")


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
