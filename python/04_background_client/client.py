"""Lesson 04, the client in Python: the twin of BackgroundClient.cs, and it prints the same lines.

    python python/04_background_client/client.py              ten times hello, one a frame
    python python/04_background_client/client.py --naive      the same without the thread, to see the frames stop

Start the server with `--drop 3`, or stop it while the client runs: the frames go on, as the last lines say.
Bytes: a request is two frames, [id][text], and so is its reply; all UTF-8. The client makes the id, a new one for each
request and the same one for its retries. Take home: this file.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import queue
import re
import sys
import threading
import time
import uuid
from collections.abc import Callable
from socket import getaddrinfo

import zmq

Callback = Callable[[str], None]
# How many milliseconds a wait for the network lasts before it looks whether the client was closed; how long a text is.
SLICE, MAX_BYTES = 50, 65536
ENDED, SILENT = "the client was disposed", "is the server running, or the line slow?"


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


class BackgroundClient:
    """Asks a server without ever making the calling thread wait. Each client has its own thread."""

    def __init__(self, endpoint: str, patience: float = 1.0, tries: int = 3, capacity: int = 64) -> None:
        """Patience is for the first try; each one after it waits twice as long, up to 8 times: on a far line the
        connection alone takes four round trips."""
        self.endpoint, self.patience, self.tries, self.capacity = endpoint, patience, tries, capacity
        # State and last error, in one variable: a reader never gets those of two moments. Only a reply proves that the
        # server is there: Connecting, Connected, Retrying, Lost, Disposed.
        self.status, self.round_trip = ("Connecting", ""), 0.0
        self._stopped, self._under_way, self._gate = False, 0, threading.Lock()
        self._waiting: queue.SimpleQueue[tuple[str, Callback, Callback] | None] = queue.SimpleQueue()
        self._done: queue.SimpleQueue[tuple[Callback, str]] = queue.SimpleQueue()
        self._ids = (f"{uuid.uuid4().hex}-{number}".encode() for number in itertools.count(1))
        self._socket: zmq.Socket[bytes] | None = None
        self._thread = threading.Thread(target=self._talk, daemon=True)
        self._thread.start()

    def request(self, text: str, reply: Callback, error: Callback) -> bool:
        """Have one of the callbacks run in a later poll(). False if refused: neither will, and status says why."""
        if self._stopped or self._under_way == self.capacity:
            # While the server is silent, that silence is the cause, and stays.
            if self._stopped or self.status[0] != "Retrying":
                self._note("", ENDED if self._stopped else f"refused: {self.capacity} requests are under way already")
            return False
        self._under_way += 1
        self._waiting.put((text, reply, error))
        return True

    def poll(self) -> None:
        """Run the callbacks of what has ended. Call it once a frame, on the thread that calls request()."""
        for _ in range(self._done.qsize()):
            callback, text = self._done.get()
            self._under_way -= 1
            callback(text)

    def close(self) -> None:
        """End the thread. The error callback of every request that has no reply yet runs before this returns."""
        self._stopped = True
        self._waiting.put(None)
        self._thread.join(1)
        self._note("Disposed")
        try:
            self.poll()
        finally:
            # A callback raised: the others run all the same.
            if self._done.qsize():
                self.close()

    def _note(self, state: str = "", error: str = "") -> None:
        with self._gate:
            self.status = state or self.status[0], error or self.status[1]

    def _talk(self) -> None:
        """The network thread. The socket is made, used and closed here."""
        with zmq.Context() as context:
            # Sleeps, which costs nothing, until request() or close() puts something there.
            while call := self._waiting.get():
                text, reply, error = call
                try:
                    self._done.put((reply, self._ask(context, [next(self._ids), text.encode()])))
                except Exception as failure:
                    # Whatever it is, this thread goes on, and the caller gets to know.
                    self._close_socket()
                    why = str(failure) if isinstance(failure, TimeoutError | InterruptedError) else repr(failure)
                    self._note("Lost", why)
                    self._done.put((error, why))
            self._close_socket()

    def _ask(self, context: zmq.Context[zmq.Socket[bytes]], request: list[bytes]) -> str:
        if len(request[1]) > MAX_BYTES:
            raise ValueError(f"a text has at most {MAX_BYTES} bytes")
        for attempt in range(1, self.tries + 1):
            if self._stopped:
                raise InterruptedError(ENDED)
            if not self._socket:
                self._socket = context.socket(zmq.REQ)
                # A request that nobody fetched is dropped at the end; waiting for its delivery could take for ever.
                self._socket.linger, self._socket.maxmsgsize = 0, MAX_BYTES
                self._socket.connect(self.endpoint)
            try:
                return self._try(self._socket, request, self.patience * 2 ** min(attempt - 1, 3))
            except TimeoutError as error:
                failure = f"{error} (try {attempt} of {self.tries})"
            # A REQ socket that waits for a reply takes no other request. A new one also never gets a late reply.
            self._close_socket()
            if attempt < self.tries:
                self._note("Retrying", failure)
        raise TimeoutError(failure)

    def _try(self, socket: zmq.Socket[bytes], request: list[bytes], limit: float) -> str:
        start = time.monotonic()
        try:
            socket.send_multipart(request, zmq.NOBLOCK)
            while not socket.poll(SLICE):
                if self._stopped:
                    raise InterruptedError(ENDED)
                if time.monotonic() - start >= limit:
                    raise zmq.Again
            reply = socket.recv_multipart(zmq.NOBLOCK)
        except zmq.Again:
            # So end two errors of the peer's as well: a socket without a connection does not send, and poll also sees
            # a broken message, which recv drops. The next socket has another connection.
            raise TimeoutError(f"no reply from {self.endpoint} within {limit:g} s; {SILENT}") from None
        if len(reply) != 2 or reply[0] != request[0]:
            # It may have come at once, and so may the next: without a pause all tries are over in a millisecond.
            time.sleep(0.25)
            raise TimeoutError(f"garbage from {self.endpoint}: not [id][text] in two frames; is it the right server?")
        self.round_trip = time.monotonic() - start
        self._note("Connected")
        return reply[1].decode(errors="replace")

    def _close_socket(self) -> None:
        if self._socket:
            self._socket.close()
        self._socket = None


def play(client: BackgroundClient, options: argparse.Namespace) -> None:
    """What a game does: frame after frame. Each one runs what came back, and asks once."""
    replies, errors = list[str](), list[str]()
    asked, frames, longest, shown = 0, 0, 0.0, ""

    def show_trouble() -> None:
        nonlocal shown
        state, error = client.status
        if error != shown and state != "Lost":
            print(f"trouble: {(shown := error)}", flush=True)

    def on_reply(reply: str) -> None:
        show_trouble()
        replies.append(reply)
        print(f"{len(replies)}: sent {options.text}, received {printable(reply)}", flush=True)

    before = time.monotonic()
    while len(replies) < options.count and not errors:
        client.poll()
        if asked < options.count and client.request(options.text, on_reply, errors.append):
            asked += 1
        while options.naive and len(replies) < asked and not errors:
            client.poll()
        show_trouble()
        time.sleep(1 / 60)
        now = time.monotonic()
        frames, longest, before = frames + 1, max(longest, now - before), now
    print(f"frames: {frames}, the longest took {longest * 1000:.0f} ms")
    if errors:
        raise TimeoutError(errors[0])
    print(f"done: {len(replies)} replies")


def main() -> None:
    # In a pipe Windows would use another encoding, which has no sign for much of what a server may send.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Says hello once a frame, and never waits for world.")
    parser.add_argument("--endpoint", default="tcp://127.0.0.1:5554", help="the server")
    parser.add_argument("--count", type=int, default=10, help="how many requests")
    parser.add_argument("--text", default="hello", help="what to ask: 'hello' or 'echo TEXT'")
    parser.add_argument("--patience", type=float, default=1.0, help="seconds to wait for each reply")
    parser.add_argument("--tries", type=int, default=20, help="how often to send a request before giving up")
    parser.add_argument("--naive", action="store_true", help="let each frame wait for its reply")
    options = parser.parse_args()
    # libzmq itself takes port 99999 and an unknown host without a word, and waits.
    parts = re.fullmatch(r"tcp://([^\s:]+):(\d{1,5})", options.endpoint)
    if not parts or not 0 < int(parts[2]) < 65536:
        parser.error(f"bad endpoint '{options.endpoint}': write it like tcp://127.0.0.1:5554, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        parser.error(f"bad endpoint '{options.endpoint}': unknown host '{parts[1]}'; check its spelling")
    if options.count < 0 or options.tries < 1 or not 0 < options.patience < 86400:
        parser.error("--count takes a whole number, --tries 1 or more, --patience seconds, and none is negative")
    print(f"asking {options.endpoint}", flush=True)
    with contextlib.closing(BackgroundClient(options.endpoint, options.patience, options.tries)) as client:
        play(client, options)


if __name__ == "__main__":
    try:
        main()
    except TimeoutError as error:
        sys.exit(f"gave up: {error}")
    except KeyboardInterrupt:
        sys.exit("stopped")
