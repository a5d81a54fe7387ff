"""Lesson 05, the client in Python: the twin of MessageRequester.cs, and it prints the same lines.

    python python/05_messages/client.py                   ten pictures as raw bytes
    python python/05_messages/client.py --wrong-shape     a header that does not fit its bytes is refused
    python python/05_messages/client.py --fps 60          a camera with 60 pictures a second: the newest wins
    python python/05_messages/client.py --jpeg            JPEG files; needs Pillow

Bytes: a JSON header and one frame for each array, as messages.py beside this file says. Take home: this file and
messages.py; pictures.py only stands for your camera.
"""

import argparse
import re
import sys
import time
from socket import getaddrinfo
from typing import Any

import zmq
from messages import LIMIT, Message, MessageError, read
from pictures import Camera, described, picture

ENDPOINT = "tcp://127.0.0.1:5555"


def request(socket: zmq.Socket[bytes], frames: list[Any], patience: float) -> Message:
    """Send a message and wait for its reply, at most `patience` seconds: zmq.Again after that."""
    socket.send_multipart(frames, copy=False)
    end = time.monotonic() + patience
    # In slices: on Windows Ctrl-C does not interrupt a longer wait.
    while not socket.poll(200) and time.monotonic() < end:
        pass
    reply = read(socket.recv_multipart(zmq.NOBLOCK, copy=False))
    if reply.kind == "error":
        code, text = (str(reply.values.get(name, "not said")) for name in ("code", "text"))
        raise MessageError(printable(code), printable(text))
    return reply


# From here on all clients of this kit are the same, but for their own options.


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def endpoint(text: str) -> str:
    """libzmq itself takes port 99999 and an unknown host without a word, and waits."""
    parts = re.fullmatch(r"tcp://([\w.-]+):(\d{1,5})", text, re.ASCII)
    if not parts or not 0 < int(parts[2]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': unknown host '{parts[1]}'; check it") from None
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Sends pictures and asks where they are brightest.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--count", type=int, default=10, help="how many pictures to send")
    parser.add_argument("--patience", type=float, default=2.5, help="seconds to wait for each reply")
    parser.add_argument("--fps", type=int, default=0, help="the camera's pictures a second; 0: one for each reply")
    parser.add_argument("--jpeg", action="store_true", help="send JPEG files instead of raw bytes")
    parser.add_argument("--wrong-shape", action="store_true", help="claim a shape that does not fit the bytes")
    options = parser.parse_args()
    if options.count < 0 or not 0 < options.patience < 86400 or options.fps < 0:
        parser.error("--count and --fps take whole numbers from 0, --patience seconds, more than 0")
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context, context.socket(zmq.REQ) as socket:
        # A request that nobody fetched is dropped at the end; waiting for its delivery could take for ever.
        # Above the limit of messages.py a reply is refused by name. Above this one libzmq takes no more and hangs up.
        # Sending does not wait: libzmq would say of a request whose connection ends in that moment that it is sent.
        socket.linger, socket.maxmsgsize, socket.sndtimeo = 0, 4 * LIMIT, 0
        socket.connect(options.endpoint)
        camera = Camera(options.fps)
        try:
            for i in range(1, options.count + 1):
                # The newest wins: what the camera saw meanwhile is skipped, and never queues up.
                sent = picture(camera.newest(), options.jpeg)
                header, data = sent.frames()
                if options.wrong_shape:
                    header = header.replace(b"[240,320,3]", b"[240,320,4]")
                reply = request(socket, [header, data], options.patience)
                what = f"{sent.kind} {sent.id}, {len(data)} bytes"
                print(f"{i}: sent {what}; {printable(described(reply.values))}", flush=True)
        except zmq.Again:
            sys.exit(f"gave up: no reply from {options.endpoint} within {options.patience:g} s; is the server running?")
        except MessageError as error:
            sys.exit(f"gave up: {error}")
    print(f"done: {options.count} replies, {camera.number - options.count} pictures skipped")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
