"""Lesson 05, messages: agree on the bytes, then numbers, texts and arrays go both ways.

    python python/05_messages/server.py       prints: listening on tcp://127.0.0.1:5555
    python python/05_messages/client.py       or: dotnet run --project csharp-console -- 5

Bytes: a JSON header and one frame for each array, as messages.py beside this file says. The kinds of request are
    echo     any arrays                       the same values and arrays
    frame    uint8 [height, width, 3]         `x` and `y` of the brightest pixel, counted from the top left, and `mean`;
                                              with the value `bottom_up` the lowest row comes first, as Unity has it
    jpeg     uint8, the bytes of a JPEG file  the same
A request that cannot be answered gets a reply of kind `error`, and the server serves on.
Trouble on command: `--delay 0.1` is slower than a camera. Take home: this file and messages.py; pictures.py is only
for the lesson's pictures.
"""

import argparse
import contextlib
import re
import signal
import sys
import time
import traceback
from typing import Any

import zmq
from messages import LIMIT, Message, MessageError, read
from pictures import brightest

# Above the limit of messages.py a sender is told so. Above this one libzmq takes no more of it and hangs up.
ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5555", zmq.REP, 4 * LIMIT


def answer(request: Message) -> Message:
    """Your own answer goes here; MessageError says why there is none."""
    if request.kind == "echo":
        return Message("ok", request.id, request.values, request.arrays)
    if request.kind in ("frame", "jpeg"):
        return Message("ok", request.id, brightest(request))
    raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of echo, frame, jpeg")


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    while True:
        # It waits in slices: on Windows Ctrl-C does not interrupt a longer wait.
        with contextlib.suppress(zmq.Again):
            # Without a copy: the arrays stay where ZeroMQ has received them.
            reply = reply_to(socket.recv_multipart(copy=False))
            # To sleep for no time takes as long as the whole reply.
            if options.delay:
                time.sleep(options.delay)
            socket.send_multipart(reply, copy=False)
            if not (options.quiet or reply[0].startswith(b'{"kind":"error"')):
                print(f"sent {reply[0]!r:.80}", flush=True)


def reply_to(frames: list[zmq.Frame]) -> list[Any]:
    """What is wrong is told to whoever asked, and the server serves on."""
    request = Message("")
    try:
        request = read(frames)
        # What cannot be written is found out here, before a part of it is on its way.
        return answer(request).frames()
    except Exception as error:
        if not isinstance(error, MessageError):
            # A mistake in `answer`: its place is for whoever writes it.
            traceback.print_exc()
            error = MessageError("error-in-answer", repr(error))
        return Message("error", error.id or request.id, {"code": error.code, "text": error.text}).frames()


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--delay", type=seconds, default=0, help="seconds to wait before each reply")
    parser.add_argument("--quiet", action="store_true", help="no line per reply: it takes longer than the reply")


# From here on all servers of this kit are the same, as far as they need it.


def seconds(text: str) -> float:
    if not 0 <= float(text) < 86_400:
        raise ValueError
    return float(text)


def endpoint(text: str) -> str:
    """libzmq itself would listen on port 99999 - 65536 without a word."""
    port = re.fullmatch(r"tcp://[\w.*-]+:(\*|\d{1,5})", text, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 0 to 65535")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="port 0 takes a free one")
    add_options(parser)
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with zmq.Context() as context, context.socket(SOCKET) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        # Who announces more than the largest message is disconnected before it is in memory.
        socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, LARGEST, 200
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            cure = "try --endpoint tcp://127.0.0.1:0, which takes a free port"
            sys.exit(f"cannot listen on {options.endpoint}: {zmq.strerror(error.errno or 0)}; {cure}")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
