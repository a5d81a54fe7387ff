"""Lesson 05, the client in Python: the twin of MessageRequester.cs, and it prints the same lines.

    python python/05_messages/client.py                      ten pictures as raw bytes
    python python/05_messages/client.py --jpeg               the same as JPEG; needs Pillow
    python python/05_messages/client.py --fps 60             a camera with 60 pictures a second: the newest wins
    python python/05_messages/client.py --wrong shape        a wrong message first: json, version, kind, shape, frames

Bytes: a JSON header and one frame for each array, as messages.py beside this file says.
Take home: this file with messages.py and camera.py, which only stands for your camera.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from socket import getaddrinfo

import zmq
from camera import HEIGHT, WIDTH, Camera, jpeg, picture
from messages import LIMIT, MOST_ARRAYS, Array, Bytes, Message, MessageError, printable, read

# What --wrong changes in the header of a good message.
SPOIL = {
    "json": (b'{"kind"', b"{kind"),
    "version": (b'"version":1', b'"version":2'),
    "kind": (b'"frame"', b'"frames"'),
    "shape": (b"[240,320,3]", b"[240,320,4]"),
    "frames": (b"[{", b'[{"dtype":"uint8","shape":[0]},{'),
}


def connect(context: zmq.Context[zmq.Socket[bytes]], endpoint: str) -> zmq.Socket[bytes]:
    socket = context.socket(zmq.REQ)
    # A request that nobody fetched is dropped at the end; waiting for its delivery could take for ever.
    socket.linger = 0
    # Above the limit of messages.py a reply is refused by name. Above this one libzmq takes no more and hangs up.
    socket.maxmsgsize = 4 * LIMIT
    # Waits with a limit in milliseconds, because on Windows Ctrl-C does not interrupt one without.
    socket.sndtimeo = socket.rcvtimeo = 200
    socket.connect(endpoint)
    return socket


def request(socket: zmq.Socket[bytes], frames: list[Bytes], patience: float) -> Message:
    """Send a message and wait for its reply: TimeoutError without one, MessageError if it is an error."""
    where, deadline = socket.getsockopt_string(zmq.LAST_ENDPOINT), time.monotonic() + patience
    try:
        socket.send_multipart(frames, copy=False)
    except zmq.Again:
        raise TimeoutError(f"{where} takes no more; is the server running?") from None
    received: list[zmq.Frame] = []
    # More frames than a message may have are not waited for: `read` refuses them.
    while not received or (received[-1].more and len(received) < MOST_ARRAYS + 2):
        try:
            received.append(socket.recv(copy=False))
        except zmq.Again:
            if time.monotonic() >= deadline:
                raise TimeoutError(f"no reply from {where} within {patience:g} s; is the server running?") from None
    reply = read([frame.buffer for frame in received])
    if reply.kind == "error":
        code, text = reply.values.get("code"), reply.values.get("text")
        raise MessageError(
            printable(code) if isinstance(code, str) else "error",
            printable(text) if isinstance(text, str) else "the server gave no reason",
        )
    return reply


def message(number: int, as_jpeg: bool) -> Message:
    """A picture as a request."""
    pixels = picture(number)
    if as_jpeg:
        file = jpeg(pixels)
        return Message("jpeg", number, {}, [Array("uint8", (len(file),), file)])
    return Message("frame", number, {"bottom_up": True}, [Array("uint8", (HEIGHT, WIDTH, 3), pixels)])


def show_refusal(context: zmq.Context[zmq.Socket[bytes]], endpoint: str, wrong: str, patience: float) -> None:
    header, *payloads = message(1, False).frames()
    try:
        with connect(context, endpoint) as socket:
            request(socket, [bytes(header).replace(*SPOIL[wrong]), *payloads], patience)
    except MessageError as error:
        print(f"refused: {error}", flush=True)


def endpoint(text: str) -> str:
    """What --endpoint takes. libzmq itself takes port 99999 and an unknown host without a word, and waits."""
    parts = re.fullmatch(r"tcp://([^\s:]+):(\d{1,5})", text)
    if not parts or not 0 < int(parts[2]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5555, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        raise argparse.ArgumentTypeError(
            f"bad endpoint '{text}': unknown host '{parts[1]}'; check its spelling"
        ) from None
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, which lacks most letters.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Sends pictures and asks where they are brightest.")
    parser.add_argument("--endpoint", type=endpoint, default="tcp://127.0.0.1:5555", help="the server")
    parser.add_argument("--count", type=int, default=10, help="how many pictures to send")
    parser.add_argument("--patience", type=float, default=2.5, help="seconds to wait for each reply")
    parser.add_argument("--fps", type=int, default=0, help="the camera's pictures a second; 0: one for each reply")
    parser.add_argument("--jpeg", action="store_true", help="send JPEG instead of raw bytes")
    parser.add_argument("--wrong", choices=SPOIL, help="send a wrong message first")
    options = parser.parse_args()
    if options.count < 0 or not 0 < options.patience < 86400 or options.fps < 0:
        parser.error("--count and --fps take whole numbers, --patience seconds, and none is negative")
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context, connect(context, options.endpoint) as socket:
        if options.wrong:
            show_refusal(context, options.endpoint, options.wrong, options.patience)
        camera = Camera(options.fps)
        for i in range(1, options.count + 1):
            # The newest wins: what the camera saw while the last request was under way is skipped and never queues up.
            sent = message(camera.newest(), options.jpeg)
            found = request(socket, sent.frames(), options.patience).values
            what = f"{sent.kind} {sent.id}, {len(sent.arrays[0].data)} bytes"
            where = ", ".join(f"{name} {value}" for name, value in found.items())
            # A server of your own may answer with something else.
            if found.keys() >= {"x", "y", "mean"} and type(found["mean"]) in (int, float):
                where = f"brightest at x {found['x']}, y {found['y']}, mean {found['mean']:.1f}"
            print(f"{i}: sent {what}" + (f"; {printable(where)}" if where else ""), flush=True)
        print(f"done: {options.count} replies, {camera.number - options.count} pictures skipped")


if __name__ == "__main__":
    try:
        main()
    except (TimeoutError, MessageError) as error:
        sys.exit(f"gave up: {error}")
    except KeyboardInterrupt:
        sys.exit("stopped")
