"""Lesson 04, the background client: frames go on while a thread of its own talks to the server.

    python python/04_background_client/server.py       prints: listening on tcp://127.0.0.1:5554
    python python/04_background_client/client.py       or: dotnet run --project csharp-console -- 4

Bytes: a request is two frames, [id][text], and so is its reply; all UTF-8, at most 65,536 bytes each. The client makes
the id, a new one for each request and the same one for its retries. `hello` is answered with `world`, `echo TEXT` with
TEXT, anything else with a text that begins with `error:`, and so is what makes an exception in `answer`. A retry is
answered from memory: what was done once is not done again.
Trouble on command, at the Nth message that arrives: `--crash-on N` leaves without a reply, `--drop N` goes on without
one, `--slow-on N --delay S` replies late, `--garbage-on N` and `--half-on N` reply with other bytes than agreed.
Take home: this file. Its memory ends with the process; lesson 02 keeps it on disk.
"""

from __future__ import annotations

import argparse
import errno
import functools
import itertools
import re
import signal
import sys
import time
import traceback

import zmq

MAX_BYTES = 65536


def answer(text: bytes) -> bytes:
    """The work: put your own here."""
    if text == b"hello":
        return b"world"
    if text.startswith(b"echo "):
        return text[5:].decode(errors="replace").encode()
    return f"error: expected hello or echo TEXT, got {text[:40]!r}".encode()


@functools.lru_cache(maxsize=1000)
def remembered(name: bytes, text: bytes) -> bytes:
    """The last thousand answers, 200 MB at the most: a retry has the same id, and gets the same answer."""
    if len(reply := answer(text)) > MAX_BYTES:
        return b"error: the answer has %d bytes, more than %d" % (len(reply), MAX_BYTES)
    return reply


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """Answer for ever. A REP socket has to reply to everything; a ROUTER may leave a request without a reply."""
    left_out, quiet_until = 0, 0.0
    for number in itertools.count(1):
        # A poll with a limit, because on Windows Ctrl-C does not interrupt a wait without one.
        while not socket.poll(200):
            pass
        frames = socket.recv_multipart(zmq.NOBLOCK)
        # REQ puts an empty frame before the request; all up to it is the way back to that client.
        end = frames.index(b"", 1) + 1 if b"" in frames[1:] else 1
        way_back, request = frames[:end], frames[end:]
        hits = remembered.cache_info().hits
        reply = [b"", b"error: expected two frames, [id][text], got %d" % len(request)]
        if len(request) == 2:
            try:
                reply = [request[0], remembered(*request)]
            except Exception as error:
                # One request in trouble is not the end of the server. What is wrong with it stands in this terminal.
                traceback.print_exc()
                reply = [request[0], f"error: {type(error).__name__}: {' '.join(str(error).split())[:200]}".encode()]
        again = " again" * (remembered.cache_info().hits - hits)
        if number == options.crash_on:
            sys.exit(f"{number}: left without a reply")
        if number == options.slow_on:
            time.sleep(max(0.0, options.delay))
        garbage = {options.drop: [], options.garbage_on: [b"\xff\x00?", b"\x80\x81"], options.half_on: reply[:1]}
        reply = garbage.get(number, reply)
        if reply:
            socket.send_multipart(way_back + reply, zmq.NOBLOCK)
        if len(request) != 2:
            # A flood of bad messages makes no flood of lines.
            if time.monotonic() < quiet_until:
                left_out += 1
                continue
            if left_out:
                print(f"… {left_out:,} more in the last second")
            left_out, quiet_until = 0, time.monotonic() + 1
        print(f"{number}: sent {b' '.join(reply[1:])[:40]!r}{again}", flush=True)


def endpoint(text: str) -> str:
    """What --endpoint takes. libzmq itself would listen on port 99999 - 65536 without a word."""
    port = re.fullmatch(r"tcp://[^\s:]+:(\*|\d{1,5})", text)
    if not port or (port[1] != "*" and int(port[1]) > 65535):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5554, port up to 65535")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Answers hello with world, each request once.")
    parser.add_argument("--endpoint", type=endpoint, default="tcp://127.0.0.1:5554", help="port 0 takes a free one")
    for name in ("crash-on", "drop", "slow-on", "garbage-on", "half-on"):
        parser.add_argument(f"--{name}", type=int, default=0, metavar="N", help="trouble at the Nth message")
    parser.add_argument("--delay", type=float, default=1.5, metavar="S", help="how late --slow-on is, in seconds")
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.ROUTER) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        socket.linger, socket.maxmsgsize = 0, MAX_BYTES
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            causes = {zmq.EADDRINUSE: "the port is taken", errno.EACCES: "the system reserves this port"}
            cause = causes.get(error.errno or 0, "this machine has no such address")
            cure = "try --endpoint tcp://127.0.0.1:0, which takes a free one"
            sys.exit(f"cannot listen on {options.endpoint}: {cause}; {cure}")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
