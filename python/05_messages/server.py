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
Take home: this file, serving.py, messages.py and pixels.py.
"""

from __future__ import annotations

import argparse
import re
import sys

from messages import Message, MessageError
from pixels import as_numpy, brightest, decode, mean
from serving import run


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


def endpoint(text: str) -> str:
    """What --endpoint takes. libzmq itself would listen on port 99999 - 65536 without a word."""
    port = re.fullmatch(r"tcp://[^\s:]+:(\*|\d{1,5})", text)
    if not port or (port[1] != "*" and int(port[1]) > 65535):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5555, port 0 to 65535")
    return text


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
