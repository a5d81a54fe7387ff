"""Lesson 05, the client in Python. In C# it is MessageRequester.cs, which prints the same lines.

    python python/05_messages/client.py                   ten pictures, each an array of 230,400 bytes
    python python/05_messages/client.py --wrong-shape     a header that does not fit its bytes is refused

Bytes: a JSON header and one frame for each array, as netmq_example/messages.py says.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.asking import client_options, connected
from netmq_example.errors import Refused
from netmq_example.messages import LIMIT, Array, Message
from netmq_example.program import Socket, printable, receive, run, whole


def picture(number: int) -> Message:
    """240 rows of 320 grey pixels with a white square; the lowest row first, as Unity's textures have it."""
    grey = bytes([10 * number % 200])
    x, y = 16 * number % 320, 8 * number % 240
    row = 3 * x * grey + 24 * b"\xff" + 3 * (312 - x) * grey
    pixels = (232 - y) * 960 * grey + 8 * row + y * 960 * grey
    return Message("frame", number, {"bottom_up": True}, [Array("uint8", (240, 320, 3), pixels)])


def request(socket: Socket, frames: list[bytes], timeout: float) -> Message:
    """Send a message and wait for its reply, at most `timeout` seconds: zmq.Again after that."""
    socket.send_multipart(frames, copy=False)
    try:
        return Message.read_reply(receive(socket, timeout))
    except Refused as error:
        raise Refused(printable(error.code), printable(error.text), error.id) from None


def main() -> None:
    parser = client_options("Sends pictures and asks where they are brightest.", "tcp://127.0.0.1:5555", timeout=2.5)
    parser.add_argument("--count", type=whole, default=10, help="how many pictures to send")
    parser.add_argument("--wrong-shape", action="store_true", help="claim a shape that does not fit the bytes")
    options = parser.parse_args()
    # Above LIMIT a reply is refused by name. Above four times as much libzmq takes no more of it and hangs up.
    with connected(zmq.REQ, options, largest=4 * LIMIT) as socket:
        for i in range(1, options.count + 1):
            header, pixels = picture(i).frames()
            if options.wrong_shape:
                header = header.replace(b"[240,320,3]", b"[240,320,4]")
            reply = request(socket, [header, pixels], options.timeout)
            found = ", ".join(f"{name} {value}" for name, value in reply.values.items())
            print(f"{i}: sent frame {i}, {len(pixels)} bytes; brightest at {printable(found)}", flush=True)
    print(f"done: {options.count} replies")


if __name__ == "__main__":
    run(main, stopped="stopped")
