"""Lesson 05, the client in Python: the C# version is MessageRequester.cs, and it prints the same lines.

    python python/05_messages/client.py                   ten pictures, each an array of 230,400 bytes
    python python/05_messages/client.py --wrong-shape     a header that does not fit its bytes is refused

Bytes: a JSON header and one frame for each array, as messages.py beside this file says.
"""

import argparse
import re
import sys
import time
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.messages import LIMIT, Array, Message, MessageError, read

ENDPOINT = "tcp://127.0.0.1:5555"


def picture(number: int) -> Message:
    """240 rows of 320 grey pixels with a white square; the lowest row first, as Unity's textures have it."""
    grey, x, y = bytes([10 * number % 200]), 16 * number % 320, 8 * number % 240
    row = 3 * x * grey + 24 * b"\xff" + 3 * (312 - x) * grey
    pixels = (232 - y) * 960 * grey + 8 * row + y * 960 * grey
    return Message("frame", number, {"bottom_up": True}, [Array("uint8", (240, 320, 3), pixels)])


def request(socket: zmq.Socket[bytes], frames: list[bytes], timeout: float) -> Message:
    """Send a message and wait for its reply, at most `timeout` seconds: zmq.Again after that."""
    socket.send_multipart(frames, copy=False)
    end = time.monotonic() + timeout
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
    parser.add_argument("--timeout", type=float, default=2.5, help="seconds to wait for each reply")
    parser.add_argument("--wrong-shape", action="store_true", help="claim a shape that does not fit the bytes")
    options = parser.parse_args()
    if options.count < 0 or not 0 < options.timeout < 86400:
        parser.error("--count takes a whole number from 0, --timeout seconds, more than 0")
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context, context.socket(zmq.REQ) as socket:
        # A request that nobody fetched is dropped at the end; waiting for its delivery could take for ever.
        # Above the limit of messages.py a reply is refused by name. Above this one libzmq takes no more and hangs up.
        # Sending does not wait: libzmq would say of a request whose connection ends in that moment that it is sent.
        socket.linger, socket.maxmsgsize, socket.sndtimeo = 0, 4 * LIMIT, 0
        socket.connect(options.endpoint)
        try:
            for i in range(1, options.count + 1):
                header, pixels, *more = picture(i).frames()
                if options.wrong_shape:
                    header = header.replace(b"[240,320,3]", b"[240,320,4]")
                reply = request(socket, [header, pixels, *more], options.timeout)
                found = ", ".join(f"{name} {value}" for name, value in reply.values.items())
                print(f"{i}: sent frame {i}, {len(pixels)} bytes; brightest at {printable(found)}", flush=True)
        except zmq.Again:
            sys.exit(f"gave up: no reply from {options.endpoint} within {options.timeout:g} s; is the server running?")
        except MessageError as error:
            sys.exit(f"gave up: {error}")
    print(f"done: {options.count} replies")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
