"""Lesson 01, request-reply: one side asks, the other answers, strictly in turn.

    python python/01_request_reply/server.py       prints: listening on tcp://127.0.0.1:5551
    python python/01_request_reply/client.py       or: dotnet run --project csharp-console -- 1

Bytes: UTF-8 text, one frame each way. `Hello` is answered with `World`, anything else with a text that begins with
`error:`. Any ZeroMQ program that says Hello is answered, in whatever language it is written.
Trouble on command: `--delay 5` answers later than the client waits. Take home: this file.
"""

from __future__ import annotations

import argparse
import errno
import re
import signal
import sys
import time
import traceback

import zmq


def answer(frames: list[bytes]) -> str:
    """The reply to one request, given as the frames of one message."""
    if len(frames) != 1:
        return f"error: expected one frame, got {len(frames)}"
    # The clients of some older tutorials send the closing zero byte of a C string along.
    if frames[0].rstrip(b"\0 \r\n") == b"Hello":
        return "World"
    return f"error: expected Hello, got {len(frames[0])} bytes beginning {frames[0][:20]!r}"


def serve(socket: zmq.Socket[bytes], delay: float, quiet: bool) -> None:
    """Answer for ever. REP alternates strictly: receive, send, receive, send."""
    # A wait with a limit in milliseconds, because on Windows Ctrl-C does not interrupt one without.
    socket.rcvtimeo = 200
    lines = Lines()
    while True:
        try:
            frames = socket.recv_multipart()
        except zmq.Again:
            continue
        reply = answer_or_error(frames)
        if delay:
            time.sleep(delay)
        # This never waits: REP drops the reply to a client that has gone, or does not read.
        socket.send(reply)
        if not quiet:
            lines.show(f"sent {printable(reply.decode())}", bad=reply.startswith(b"error:"))


def answer_or_error(frames: list[bytes]) -> bytes:
    """A mistake in `answer` is told to both sides, and ends neither."""
    try:
        return answer(frames).encode()
    except Exception as error:
        traceback.print_exc()
        return printable(f"error: {type(error).__name__}: {error}").encode()


class Lines:
    """Prints what happens, and of what is bad at most one line a second: a flood of it makes no flood of lines."""

    next, left_out = 0.0, 0

    def show(self, line: str, bad: bool) -> None:
        now = time.monotonic()
        if bad and now < self.next:
            self.left_out += 1
            return
        if self.left_out and now >= self.next:
            print(f"… {self.left_out:,} more in the last second", flush=True)
            self.left_out = 0
        if bad:
            self.next = now + 1
        print(line, flush=True)


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def endpoint(text: str) -> str:
    """What --endpoint takes. libzmq itself would listen on port 99999 - 65536 without a word."""
    port = re.fullmatch(r"tcp://[^\s:]+:(\*|\d{1,5})", text)
    if not port or (port[1] != "*" and int(port[1]) > 65535):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5551, port 0 to 65535")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Answers Hello with World.")
    parser.add_argument("--endpoint", type=endpoint, default="tcp://127.0.0.1:5551", help="port 0 takes a free one")
    parser.add_argument("--delay", type=float, default=0.0, help="seconds to wait before each reply")
    parser.add_argument("--quiet", action="store_true", help="no line per reply: it takes longer than the reply")
    options = parser.parse_args()
    if not 0 <= options.delay < 86400:
        parser.error("--delay takes seconds, 0 or more")
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.REP) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        socket.linger = 0
        # Who announces more is disconnected before it is in memory.
        socket.maxmsgsize = 65536
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            causes = {zmq.EADDRINUSE: "the port is taken", errno.EACCES: "the system reserves this port"}
            cause = causes.get(error.errno or 0, "this machine has no such address")
            where = options.endpoint
            sys.exit(f"cannot listen on {where}: {cause}; try --endpoint tcp://127.0.0.1:0, which takes a free one")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options.delay, options.quiet)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
