"""Lesson 04, the background client: frames go on while a thread of its own talks to the server.

    python python/04_background_client/server.py       prints: listening on tcp://127.0.0.1:5554
    python python/04_background_client/client.py       or: dotnet run --project csharp-console -- 4

Bytes: a request is two frames, [id][text], and so is its reply; all UTF-8. The client makes the id, a new one for each
request and the same one for its retries. `hello` is answered with `world`, `echo TEXT` with TEXT, anything else with a
text that begins with `error:`. A retry is answered from memory: what was done once is not done again.
Trouble on command, at the Nth message that arrives: `--crash-on N` leaves without a reply, `--drop N` goes on without
one, `--slow-on N --delay S` replies late, `--garbage-on N` and `--half-on N` reply with other bytes than agreed.
Take home: this file. Its memory ends with the process; lesson 02 keeps it on disk.
"""

from __future__ import annotations

import argparse
import functools
import itertools
import re
import signal
import sys
import time

import zmq


@functools.lru_cache(maxsize=1000)
def answer(name: bytes, text: bytes) -> bytes:
    """The work. The cache is the memory of the last thousand: a retry has the same id, and gets the same answer."""
    if text == b"hello":
        return b"world"
    if text.startswith(b"echo "):
        return text[5:].decode(errors="replace").encode()
    return f"error: expected hello or echo TEXT, got {text[:40]!r}".encode()


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """Answer for ever. A REP socket has to reply to everything; a ROUTER may leave a request without a reply."""
    for number in itertools.count(1):
        # A poll with a limit, because on Windows Ctrl-C does not interrupt a wait without one.
        while not socket.poll(200):
            pass
        frames = socket.recv_multipart()
        # REQ puts an empty frame before the request; all up to it is the way back to that client.
        end = frames.index(b"", 1) + 1 if b"" in frames[1:] else 1
        way_back, request = frames[:end], frames[end:]
        answered_before = answer.cache_info().hits
        if len(request) == 2:
            reply = [request[0], answer(*request)]
        else:
            reply = [b"", b"error: expected two frames, [id][text], got %d" % len(request)]
        again = " again" * (answer.cache_info().hits - answered_before)
        if number == options.crash_on:
            sys.exit(f"{number}: left without a reply")
        if number == options.slow_on:
            time.sleep(max(0.0, options.delay))
        garbage = {options.drop: [], options.garbage_on: [b"\xff\x00?", b"\x80\x81"], options.half_on: reply[:1]}
        reply = garbage.get(number, reply)
        if reply:
            socket.send_multipart(way_back + reply)
        print(f"{number}: sent {b' '.join(reply[1:])[:40]!r}{again}", flush=True)


def endpoint(text: str) -> str:
    """What --endpoint takes. libzmq itself would listen on port 99999 - 65536 without a word."""
    port = re.fullmatch(r"tcp://[^\s:]+:(\*|\d{1,5})", text)
    if not port or (port[1] != "*" and int(port[1]) > 65535):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5554, port up to 65535")
    return text


def main() -> None:
    parser = argparse.ArgumentParser(description="Answers hello with world, each request once.")
    parser.add_argument("--endpoint", type=endpoint, default="tcp://127.0.0.1:5554", help="port * takes a free one")
    for name in ("crash-on", "drop", "slow-on", "garbage-on", "half-on"):
        parser.add_argument(f"--{name}", type=int, default=0, metavar="N", help="trouble at the Nth message")
    parser.add_argument("--delay", type=float, default=1.5, metavar="S", help="how late --slow-on is, in seconds")
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.ROUTER) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        socket.linger = 0
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            cause = "the port is taken" if error.errno == zmq.EADDRINUSE else "no such address, or no right to it"
            sys.exit(f"cannot listen on {options.endpoint}: {cause}; try --endpoint tcp://127.0.0.1:*")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
