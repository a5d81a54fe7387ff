"""Lesson 17, what the hub is told: seconds, a place to announce itself at, and the keys of whom it lets in."""

import argparse
import functools
import re
import sys
from pathlib import Path
from typing import Any

import zmq

from netmq_example.security.allow_list import AllowList


def keys_for(
    context: zmq.Context[zmq.Socket[bytes]], socket: zmq.Socket[bytes], folder: str | None
) -> AllowList | None:
    """Lesson 15's, before the socket listens: whoever comes first must be asked about already."""
    # An empty one, as of a variable that is not set, is a mistake, and opens nothing.
    if folder is None:
        return None
    try:
        allowed = AllowList(Path(folder), functools.partial(print, flush=True))
    except ValueError as error:
        sys.exit(str(error))
    allowed.answer(context)
    allowed.guard(socket)
    return allowed


def receive(socket: zmq.Socket[bytes], allowed: AllowList | None) -> tuple[bytes, list[Any]]:
    """Who sent something, and its frames; none of whoever is not on the list any more, which is asked with each
    message: a handshake may have been long ago."""
    if not allowed:
        peer, *texts = socket.recv_multipart()
        return peer, texts
    way, *frames = socket.recv_multipart(copy=False)
    return way.bytes, frames if frames and allowed.name_of(frames[-1]) else []


def seconds(text: str) -> float:
    """The type of an option."""
    if not re.fullmatch(r"\d{1,5}(\.\d{1,6})?", text, re.ASCII) or not 0 < float(text) <= 86400:
        raise argparse.ArgumentTypeError(f"'{text}' is no number of seconds, more than 0 and at most a day")
    return float(text)


def place(text: str) -> tuple[str, int]:
    """The type of an option."""
    parts = re.fullmatch(r"(\d{1,3}(?:\.\d{1,3}){3}):(\d{1,5})", text, re.ASCII)
    if not parts or not 0 < int(parts[2]) < 65536 or max(map(int, parts[1].split("."))) > 255:
        raise argparse.ArgumentTypeError(f"'{text}' is no address and port: write it like 255.255.255.255:5567")
    return parts[1], int(parts[2])
