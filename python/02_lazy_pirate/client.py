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
import time
import uuid
from socket import getaddrinfo

import zmq

# Seconds before a request is sent again after a wrong reply: without them, 5 tries are over in a millisecond.
PAUSE = 0.25


class LazyPirate:
    """Asks until it is answered, at most `tries` times: waits `patience` seconds, then twice as long, up to 8 times."""

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
        # A peer that announces more is disconnected before it is in memory.
        socket.maxmsgsize = 65536
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
            # A new connection takes several round trips. On a slow line only a longer wait ever succeeds.
            patience = self.patience * 2 ** min(attempt - 1, 3)
            how = "on the same socket" if self.relaxed else "on a new socket"
            try:
                frames = self.exchange(request_id, text, patience)
                if len(frames) == 2 and frames[0] == request_id:
                    return frames[1]
                # A late reply to an earlier request. Taken for this one's, it would shift all that follow by one.
                trouble = f"dropped a reply to another request ({short(' '.join(frames))})"
                hint = "is it the right server?"
                # It may have come at once, and so may the next.
                time.sleep(PAUSE)
            except TimeoutError as error:
                trouble, hint = str(error), "is the server running, or the line slow?"
            if not self.relaxed:
                # A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
                self.close()
                self.socket = self.connect()
            if attempt < self.tries:
                print(f"{self.number}: {trouble}; try {attempt + 1} of {self.tries}, {how}", flush=True)
        raise TimeoutError(
            f"{self.tries} tries to ask {self.endpoint}, the last: {trouble}; {hint} '{text}' may have been done or not"
        )

    def exchange(self, request_id: str, text: str, patience: float) -> list[str]:
        """One try: the frames of a reply, whichever it is, or TimeoutError."""
        limit = time.monotonic() + patience
        request = [request_id.encode(), text.encode(errors="replace")]
        try:
            self.socket.send_multipart(request, zmq.NOBLOCK)
        except zmq.Again:
            # Nothing to send it on: after a peer that broke the protocol, libzmq does not connect again.
            self.close()
            self.socket = self.connect()
            self.socket.send_multipart(request, zmq.NOBLOCK)
        while True:
            try:
                # Without waiting, even when poll() saw a reply: a socket that correlates throws a late one away here.
                return [frame.decode(errors="replace") for frame in self.socket.recv_multipart(zmq.NOBLOCK)]
            except zmq.Again:
                left = limit - time.monotonic()
                if left <= 0:
                    raise TimeoutError(f"no reply within {patience:g} s") from None
                # In slices, because on Windows Ctrl-C does not interrupt a longer wait.
                self.socket.poll(min(200, int(left * 1000) + 1))


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def short(text: str) -> str:
    """A reply with its id, as it is printed: of the long random number, the beginning is enough."""
    return re.sub(r"^([0-9a-f]{8})[0-9a-f]{24}-", r"\1…-", printable(text))


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Adds to the server's account, and asks again until it is answered.")
    parser.add_argument("--endpoint", default="tcp://127.0.0.1:5552", help="the server")
    parser.add_argument("--count", type=int, default=10, help="how many requests")
    parser.add_argument("--text", default="add 1", help="what to ask: 'add 1' or 'balance'")
    parser.add_argument("--patience", type=float, default=0.5, help="seconds to wait, for the first try")
    parser.add_argument("--tries", type=int, default=5, help="how often to send a request before giving up")
    parser.add_argument("--relaxed", action="store_true", help="keep the socket: REQ_RELAXED and REQ_CORRELATE")
    options = parser.parse_args()
    # libzmq itself takes port 99999 and an unknown host without a word, and waits.
    parts = re.fullmatch(r"tcp://([^\s:]+):(\d{1,5})", options.endpoint)
    if not parts or not 0 < int(parts[2]) < 65536:
        parser.error(f"bad endpoint '{options.endpoint}': write it like tcp://127.0.0.1:5552, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        parser.error(f"bad endpoint '{options.endpoint}': unknown host '{parts[1]}'; check its spelling")
    if options.count < 0 or options.tries < 1 or not 0 < options.patience < 86400:
        parser.error("--count takes a whole number from 0, --tries 1 or more, --patience seconds, more than 0")
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context:
        pirate = LazyPirate(context, options.endpoint, options.patience, options.tries, options.relaxed)
        with contextlib.closing(pirate):
            for i in range(1, options.count + 1):
                reply = printable(pirate.request(options.text))
                print(f"{i}: sent {options.text}, received {reply}", flush=True)
            print(f"done: {options.count} replies")


if __name__ == "__main__":
    try:
        main()
    except TimeoutError as error:
        sys.exit(f"gave up: {error}")
    except KeyboardInterrupt:
        sys.exit("stopped")
