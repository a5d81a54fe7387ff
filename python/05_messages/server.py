"""Lesson 05, messages: agree on the bytes, then numbers, texts and pictures go both ways.

    python python/05_messages/server.py       prints: listening on tcp://127.0.0.1:5555
    python python/05_messages/client.py       or: dotnet run --project csharp-console -- 5

Bytes: a JSON header and one frame for each array, as messages.py beside this file says. The kinds of request are
    echo     any arrays                       the same values and arrays
    mean     one array                        `mean`; numbers that are not finite are refused
    frame    uint8 [height, width, 3]         `x` and `y` of the brightest pixel, counted from the top left, and `mean`;
                                              with the value `bottom_up` the lowest row comes first, as Unity has it
    jpeg     uint8, the bytes of a JPEG file  the same
A request that cannot be answered gets a reply of kind `error`, and the server serves on.
Trouble on command: `--delay 0.1` is slower than a camera.
Take home: this file, messages.py and pixels.py.
"""

from __future__ import annotations

import argparse
import errno
import re
import signal
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import suppress

import zmq
from messages import LIMIT, Message, MessageError, read
from pixels import as_numpy, brightest, decode, mean

Answer = Callable[[Message], Message]


def answer(request: Message) -> Message:
    """The reply to a request; put your own here. MessageError says why there is none."""
    if request.kind == "echo":
        return Message("ok", request.id, request.values, request.arrays)
    if request.kind not in ("mean", "frame", "jpeg"):
        raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of echo, mean, frame, jpeg")
    if len(request.arrays) != 1 or 0 in request.arrays[0].shape:
        raise MessageError("bad-shape", f"{request.kind} takes one array that is not empty")
    items = decode(request.arrays[0]) if request.kind == "jpeg" else as_numpy(request.arrays[0])
    values = {"mean": mean(items)}
    if request.kind != "mean":
        # Backwards is a view: it copies nothing.
        values |= brightest(items[::-1] if request.values.get("bottom_up") is True and items.ndim else items)
    return Message("ok", request.id, values)


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


class Complaints:
    """Prints at most one line of bad input a second: a flood of it makes no flood of lines."""

    next, left_out = 0.0, 0

    def add(self, line: str) -> None:
        if time.monotonic() < self.next:
            self.left_out += 1
            return
        if self.left_out:
            print(f"… {self.left_out:,} more in the last second", flush=True)
        print(line, flush=True)
        self.next, self.left_out = time.monotonic() + 1, 0


def refusal(error: Exception, id: int) -> Message:
    """The reply to a request that could not be answered."""
    if not isinstance(error, MessageError):
        # A mistake in `answer`: the place is for whoever writes it, the reason for the client too.
        traceback.print_exception(error)
        error = MessageError("error-in-answer", f"{type(error).__name__}: {error}")
    return Message("error", error.id or id, {"code": error.code, "text": printable(error.text)})


def serve(socket: zmq.Socket[bytes], answer: Answer, delay: float, quiet: bool) -> None:
    """Answer for ever."""
    # Waits with a limit in milliseconds, because on Windows Ctrl-C does not interrupt one without.
    socket.rcvtimeo = socket.sndtimeo = 200
    complaints = Complaints()
    while True:
        try:
            received = socket.recv_multipart(copy=False)
        except zmq.Again:
            continue
        request = Message("")
        try:
            request = read([frame.buffer for frame in received])
            reply = answer(request)
            # What cannot be sent is found out here, before a part of it is on its way.
            frames = [zmq.Frame(part, copy=False) for part in reply.frames()]
        except Exception as error:
            reply = refusal(error, request.id)
            frames = [zmq.Frame(part) for part in reply.frames()]
        if delay:
            time.sleep(delay)
        socket.send_multipart(frames, copy=False)
        if quiet:
            continue
        if reply.kind != "error":
            print(f"sent {reply.kind}", flush=True)
        else:
            complaints.add(f"sent error {reply.values.get('code')}")


def endpoint(text: str) -> str:
    """What --endpoint takes. libzmq itself would listen on port 99999 - 65536 without a word."""
    port = re.fullmatch(r"tcp://[^\s:]+:(\*|\d{1,5})", text)
    if not port or (port[1] != "*" and int(port[1]) > 65535):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5555, port 0 to 65535")
    return text


def run(where: str, answer: Answer, delay: float = 0.0, quiet: bool = False) -> None:
    """Listen, and answer until Ctrl-C."""
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with suppress(KeyboardInterrupt), zmq.Context() as context, context.socket(zmq.REP) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        socket.linger = 0
        # Above the limit of messages.py a sender is told so. Above this one libzmq takes no more of it and hangs up.
        socket.maxmsgsize = 4 * LIMIT
        try:
            socket.bind(where)
        except zmq.ZMQError as error:
            causes = {zmq.EADDRINUSE: "the port is taken", errno.EACCES: "the system reserves this port"}
            cause = causes.get(error.errno or 0, "this machine has no such address")
            sys.exit(f"cannot listen on {where}: {cause}; try --endpoint tcp://127.0.0.1:0, which takes a free one")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, answer, delay, quiet)


def main() -> None:
    # In a pipe Windows would use another encoding, which lacks most letters.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Says where the brightest pixel of a picture is.")
    parser.add_argument("--endpoint", type=endpoint, default="tcp://127.0.0.1:5555", help="port 0 takes a free one")
    parser.add_argument("--delay", type=float, default=0.0, help="seconds to wait before each reply")
    parser.add_argument("--quiet", action="store_true", help="no line per reply")
    options = parser.parse_args()
    if not 0 <= options.delay < 86400:
        parser.error("--delay takes seconds, 0 or more")
    run(options.endpoint, answer, options.delay, options.quiet)


if __name__ == "__main__":
    main()
