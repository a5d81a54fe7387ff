"""Lesson 05, the client in Python: the twin of MessageRequester.cs, and it prints the same lines.

    python python/05_messages/client.py                      ten pictures as raw bytes
    python python/05_messages/client.py --jpeg               the same as JPEG; needs Pillow
    python python/05_messages/client.py --fps 60             a camera with 60 pictures a second: the newest wins
    python python/05_messages/client.py --wrong shape        a wrong message first: json, version, kind, shape, frames

Bytes: a JSON header and one frame for each array, as messages.py beside this file says. Take home: both files;
camera.py only stands for your camera.
"""

from __future__ import annotations

import argparse
import re
import sys
from socket import getaddrinfo

import zmq
from camera import HEIGHT, WIDTH, Camera, jpeg, picture
from messages import Array, Bytes, Message, MessageError, read

# What --wrong changes in the header of a good message.
SPOIL = {
    "json": (b'{"kind"', b"{kind"),
    "version": (b'"version":1', b'"version":2'),
    "kind": (b'"frame"', b'"frames"'),
    "shape": (b"[240,320,3]", b"[240,320,4]"),
    "frames": (b"[{", b'[{"dtype":"uint8","shape":[0]},{'),
}


def request(socket: zmq.Socket[bytes], frames: list[Bytes], patience: float) -> Message:
    """Send a message and wait for its reply: TimeoutError without one, MessageError if it is an error."""
    socket.send_multipart(frames, copy=False)
    if not socket.poll(int(patience * 1000)):
        raise TimeoutError(
            f"no reply from {socket.getsockopt_string(zmq.LAST_ENDPOINT)} within {patience:g} s; is the server running?"
        )
    reply = read([frame.buffer for frame in socket.recv_multipart(copy=False)])
    if reply.kind == "error":
        raise MessageError(str(reply.values["code"]), str(reply.values["text"]))
    return reply


def message(number: int, as_jpeg: bool) -> Message:
    """A picture as a request."""
    pixels = picture(number)
    if as_jpeg:
        file = jpeg(pixels)
        return Message("jpeg", number, {}, [Array("uint8", (len(file),), file)])
    return Message("frame", number, {"bottom_up": True}, [Array("uint8", (HEIGHT, WIDTH, 3), pixels)])


def show_refusal(socket: zmq.Socket[bytes], wrong: str, patience: float) -> None:
    header, *payloads = message(1, False).frames()
    try:
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
    except OSError:
        raise argparse.ArgumentTypeError(
            f"bad endpoint '{text}': unknown host '{parts[1]}'; check its spelling"
        ) from None
    return text


def main() -> None:
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
    with zmq.Context() as context, context.socket(zmq.REQ) as socket:
        # A request that nobody fetched is dropped at the end; waiting for its delivery could take for ever.
        socket.linger = 0
        socket.connect(options.endpoint)
        if options.wrong:
            show_refusal(socket, options.wrong, options.patience)
        camera = Camera(options.fps)
        for i in range(1, options.count + 1):
            # The newest wins: what the camera saw while the last request was under way is skipped and never queues up.
            sent = message(camera.newest(), options.jpeg)
            found = request(socket, sent.frames(), options.patience).values
            what = f"{sent.kind} {sent.id}, {len(sent.arrays[0].data)} bytes"
            where = ", ".join(f"{name} {value}" for name, value in found.items())
            # A server of your own may answer with something else.
            if found.keys() >= {"x", "y", "mean"}:
                where = f"brightest at x {found['x']}, y {found['y']}, mean {found['mean']:.1f}"
            print(f"{i}: sent {what}; {where}", flush=True)
        print(f"done: {options.count} replies, {camera.number - options.count} pictures skipped")


if __name__ == "__main__":
    try:
        main()
    except (TimeoutError, MessageError) as error:
        sys.exit(f"gave up: {error}")
    except KeyboardInterrupt:
        sys.exit("stopped")
