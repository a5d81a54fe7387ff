"""Lesson 02, the client in Python: the twin of LazyPirateRequester.cs, and it prints the same lines.

    python python/02_lazy_pirate/client.py                     ten times `add 1`, each with the balance it is answered
    python python/02_lazy_pirate/client.py --text balance      only asks
    python python/02_lazy_pirate/client.py --relaxed           keeps its socket: the second way to ask again

Bytes: UTF-8 text, two frames each way: [id][text]; every retry of a request carries the same id.
Take home: this file.
"""

from __future__ import annotations

import argparse
import contextlib
import re
import sys
import uuid
from socket import getaddrinfo

import zmq


class LazyPirate:
    """Asks until it is answered, at most `tries` times, and waits `patience` seconds each time."""

    def __init__(
        self, context: zmq.Context[zmq.Socket[bytes]], endpoint: str, patience: float, tries: int, relaxed: bool
    ) -> None:
        self.context, self.endpoint = context, endpoint
        self.patience, self.tries, self.relaxed = patience, tries, relaxed
        # An id must never come twice, whoever else asks and however often this program starts: hence the uuid.
        self.name, self.number = uuid.uuid4().hex, 0
        self.socket = self.connect()

    def connect(self) -> zmq.Socket[bytes]:
        socket = self.context.socket(zmq.REQ)
        # A request that nobody fetched is dropped with its socket; waiting for its delivery could take for ever.
        socket.linger = 0
        if self.relaxed:
            # May send again without a reply, and numbers what it sends, so that only the newest try is answered.
            socket.setsockopt(zmq.REQ_RELAXED, 1)
            socket.setsockopt(zmq.REQ_CORRELATE, 1)
            # Tries pile up while no server is there. At the usual limit, a thousand, a send would wait for ever.
            socket.sndhwm = 0
        socket.connect(self.endpoint)
        return socket

    def close(self) -> None:
        self.socket.close()

    def request(self, text: str) -> str:
        """The reply to a request. TimeoutError when no try is answered: it may have been done all the same."""
        self.number += 1
        request_id = f"{self.name}-{self.number}"
        for attempt in range(1, self.tries + 1):
            self.socket.send_multipart([request_id.encode(), text.encode()])
            reply, trouble = self.receive(request_id)
            if not trouble:
                return reply
            if not self.relaxed:
                # A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
                self.close()
                self.socket = self.connect()
            if attempt < self.tries:
                how = "on the same socket" if self.relaxed else "on a new socket"
                print(f"{self.number}: {trouble}; try {attempt + 1} of {self.tries}, {how}", flush=True)
        raise TimeoutError(
            f"no reply from {self.endpoint} in {self.tries} tries of {self.patience:g} s; is the server running? "
            f"'{text}' may have been done or not"
        )

    def receive(self, request_id: str) -> tuple[str, str]:
        """The reply and an empty text, or nothing and what went wrong."""
        if not self.socket.poll(int(self.patience * 1000)):
            return "", f"no reply within {self.patience:g} s"
        frames = [frame.decode(errors="replace") for frame in self.socket.recv_multipart()]
        # A late reply to an earlier request. Taken for this one's, it would shift all that follow by one.
        if len(frames) != 2 or frames[0] != request_id:
            return "", f"dropped a reply to another request ({' '.join(frames)})"
        return frames[1], ""


def main() -> None:
    parser = argparse.ArgumentParser(description="Adds to the server's account, and asks again until it is answered.")
    parser.add_argument("--endpoint", default="tcp://127.0.0.1:5552", help="the server")
    parser.add_argument("--count", type=int, default=10, help="how many requests")
    parser.add_argument("--text", default="add 1", help="what to ask: 'add 1' or 'balance'")
    parser.add_argument("--patience", type=float, default=0.5, help="seconds to wait for each reply")
    parser.add_argument("--tries", type=int, default=20, help="how often to send a request before giving up")
    parser.add_argument("--relaxed", action="store_true", help="keep the socket: REQ_RELAXED and REQ_CORRELATE")
    options = parser.parse_args()
    # libzmq itself takes port 99999 and an unknown host without a word, and waits.
    parts = re.fullmatch(r"tcp://([^\s:]+):(\d{1,5})", options.endpoint)
    if not parts or not 0 < int(parts[2]) < 65536:
        parser.error(f"bad endpoint '{options.endpoint}': write it like tcp://127.0.0.1:5552, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except OSError:
        parser.error(f"bad endpoint '{options.endpoint}': unknown host '{parts[1]}'; check its spelling")
    if options.count < 0 or options.tries < 1 or not 0 < options.patience < 86400:
        parser.error("--count takes a whole number, --tries 1 or more, --patience seconds, and none is negative")
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context:
        pirate = LazyPirate(context, options.endpoint, options.patience, options.tries, options.relaxed)
        with contextlib.closing(pirate):
            for i in range(1, options.count + 1):
                print(f"{i}: sent {options.text}, received {pirate.request(options.text)}", flush=True)
            print(f"done: {options.count} replies")


if __name__ == "__main__":
    try:
        main()
    except TimeoutError as error:
        sys.exit(f"gave up: {error}")
    except KeyboardInterrupt:
        sys.exit("stopped")
