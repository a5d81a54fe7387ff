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
Trouble on command: `--delay 0.1` is slower than a camera. Take home: this file and messages.py; for arrays and pictures
also pixels.py.
"""

from __future__ import annotations

import argparse
import re
import signal
import sys
import time

import zmq
from messages import LIMIT, Message, MessageError, read
from pixels import as_numpy, brightest, decode, mean


def answer(request: Message) -> Message:
    """The reply to a request; MessageError says why there is none."""
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
        values |= brightest(items[::-1] if request.values.get("bottom_up") is True else items)
    return Message("ok", request.id, values)


def serve(socket: zmq.Socket[bytes], delay: float, quiet: bool) -> None:
    """Answer for ever."""
    # A wait with a limit in milliseconds, because on Windows Ctrl-C does not interrupt one without.
    socket.rcvtimeo = 200
    while True:
        request = Message("")
        try:
            request = read([frame.buffer for frame in socket.recv_multipart(copy=False)])
            reply = answer(request)
        except zmq.Again:
            continue
        except MessageError as error:
            reply = Message("error", error.id or request.id, {"code": error.code, "text": error.text})
        if delay:
            time.sleep(delay)
        socket.send_multipart(reply.frames(), copy=False)
        if not quiet:
            print(f"sent {reply.kind} {reply.values.get('code', '')}".rstrip(), flush=True)


def endpoint(text: str) -> str:
    """What --endpoint takes. libzmq itself would listen on port 99999 - 65536 without a word."""
    port = re.fullmatch(r"tcp://[^\s:]+:(\*|\d{1,5})", text)
    if not port or (port[1] != "*" and int(port[1]) > 65535):
        raise argparse.ArgumentTypeError(
            f"bad endpoint '{text}': write it like tcp://127.0.0.1:5555, port 0 to 65535 or *"
        )
    return text


def main() -> None:
    parser = argparse.ArgumentParser(description="Says where the brightest pixel of a picture is.")
    parser.add_argument("--endpoint", type=endpoint, default="tcp://127.0.0.1:5555", help="port * takes a free one")
    parser.add_argument("--delay", type=float, default=0.0, help="seconds to wait before each reply")
    parser.add_argument("--quiet", action="store_true", help="no line per reply")
    options = parser.parse_args()
    if not 0 <= options.delay < 86400:
        parser.error("--delay takes seconds, 0 or more")
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.REP) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        socket.linger = 0
        # Above the limit of messages.py a sender is told so. Above this one libzmq takes no more of it and hangs up.
        socket.maxmsgsize = 4 * LIMIT
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            cause = "the port is taken" if error.errno == zmq.EADDRINUSE else "no such address, or no right to it"
            sys.exit(f"cannot listen on {options.endpoint}: {cause}; try --endpoint tcp://127.0.0.1:*")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options.delay, options.quiet)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
