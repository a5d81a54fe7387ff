"""The options of the kit's programs, and their types. A wrong one is named in one line, and the exit code is 2."""

import argparse
import contextlib
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from netmq_example import check, interrupts
from netmq_example.beacon import beacon_name, unknown_host
from netmq_example.errors import Error

T = TypeVar("T")


class Options(argparse.ArgumentParser):
    """In a thread of another program, or in a notebook, a server has its defaults: the words are that program's."""

    def parse_args(self, words: Any = None, namespace: Any = None) -> Any:
        foreign = (
            threading.current_thread() is not threading.main_thread()
            # A notebook has no file, and the words are those of its kernel. What python -c runs has its own.
            or not (hasattr(sys.modules["__main__"], "__file__") or sys.argv[:1] == ["-c"])
        )
        found = super().parse_args([] if words is None and foreign else words, namespace)
        if getattr(found, "until_eof", False):
            threading.Thread(target=interrupts.at_eof, daemon=True).start()
        return found


@contextlib.contextmanager
def wrong_usage(parser: argparse.ArgumentParser, before: str = "", after: str = "") -> Iterator[None]:
    """Around what makes use of options: what is wrong with them is named in one line, and the exit code is 2."""
    try:
        yield
    except (ValueError, Error) as error:
        parser.error(f"{before}{error}{after}")


def server_options(about: str | None, endpoint: str) -> argparse.ArgumentParser:
    """The options of every server. `about` is the program's docstring, whose first line its --help shows."""
    parser = Options(description=(about or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=server_endpoint(endpoint), default=endpoint, help="port 0 takes a free one")
    parser.add_argument("--open-to-anyone", action="store_true", help="other machines too: each can end the server")
    parser.add_argument("--beacon", type=a_name, metavar="NAME", help="clients may look for it as beacon://NAME:PORT")
    parser.add_argument("--until-eof", action="store_true", help="end when standard input does: with what started it")
    return parser


def client_options(about: str, endpoint: str, timeout: float, beacon: bool = False) -> argparse.ArgumentParser:
    """The options of every client. `timeout` is the default of --timeout, in seconds.

    With `beacon` the endpoint may be beacon://NAME:PORT, for which the client has a BeaconSearch.
    """
    parser = Options(description=about)
    parser.add_argument("--endpoint", type=client_endpoint(endpoint, beacon), default=endpoint, help="the server")
    parser.add_argument("--timeout", type=positive_seconds, default=timeout, help="seconds to wait for each reply")
    return parser


def seconds(text: str) -> float:
    """From 0 to a day."""
    return option(check.seconds_or_none, text, float)


def positive_seconds(text: str) -> float:
    """More than 0, at most a day."""
    return option(check.seconds, text, float)


def whole(text: str) -> int:
    """A whole number, 0 or more."""
    return option(lambda name, value: check.count(name, value, least=0), text, int)


def at_least_one(text: str) -> int:
    """A whole number, 1 or more."""
    return option(check.count, text, int)


def a_name(text: str) -> str:
    """What a server's beacon answers to."""
    return option(beacon_name, text, str)


def option(rule: Callable[[str, Any], T], text: str, kind: Callable[[str], Any]) -> T:
    """A text that keeps to this rule of check.py. argparse itself names the option."""
    try:
        value: Any = kind(text)
    except ValueError:
        value = text
    try:
        return rule("it", value)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def server_endpoint(example: str) -> Callable[[str], str]:
    """The type of an endpoint to bind: port 0 and * stand for a free port."""
    return lambda text: checked(text, example, lowest_port=0)


def client_endpoint(example: str, beacon: bool = False) -> Callable[[str], str]:
    """The type of an endpoint to connect to. Its host must be known: libzmq would wait for one that does not exist."""

    def known(text: str) -> str:
        if unknown := unknown_host(checked(text, example, 1, beacon)):
            raise argparse.ArgumentTypeError(f"bad endpoint '{text}': {unknown}; check it")
        return text

    return known


def checked(text: str, example: str, lowest_port: int, beacon: bool = False) -> str:
    # With a scheme of its own libzmq would be asked: a program has only what its example has.
    if not text.startswith((example.partition("//")[0], "beacon:")):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {example}")
    try:
        return check.endpoint(text, example, lowest_port, beacon)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
