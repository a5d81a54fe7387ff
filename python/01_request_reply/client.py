"""Lesson 01, the client in Python. In C# it is HelloRequester.cs, which prints the same lines.

    python python/01_request_reply/client.py                   ten times Hello, ten times World
    python python/01_request_reply/client.py --send-twice      what strict alternation means

Bytes: UTF-8 text, one frame each way.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.asking import client_options, connected
from netmq_example.program import LARGEST_BYTES, Socket, printable, receive, run, text_of, whole


def request(socket: Socket, text: str, timeout: float) -> str:
    """Send a request and wait for its reply, at most `timeout` seconds: zmq.Again after that."""
    # Where there is no connection to send on, as after a peer that is not ZeroMQ, this raises zmq.Again as well.
    socket.send(text.encode(errors="replace"))
    return receive_text(socket, timeout)


def receive_text(socket: Socket, timeout: float) -> str:
    """The text of the next message, which is that of all its frames, with a blank between them."""
    return " ".join(map(text_of, receive(socket, timeout)))


def show_refusal(socket: Socket, text: str, timeout: float) -> None:
    """REQ takes no second request before it has given the reply to the first."""
    socket.send(text.encode(errors="replace"))
    try:
        socket.send(text.encode(errors="replace"))
    except zmq.ZMQError as error:
        print(f"refused: {type(error).__name__}: {error}")
    print(f"received {printable(receive_text(socket, timeout))}: now REQ may send again")


def main() -> None:
    parser = client_options("Says Hello and waits for World.", "tcp://127.0.0.1:5551", timeout=2.5)
    parser.add_argument("--count", type=whole, default=10, help="how many times to ask")
    parser.add_argument("--text", default="Hello", help="what to say")
    parser.add_argument("--send-twice", action="store_true", help="send a second request before the reply")
    options = parser.parse_args()
    if len(options.text.encode(errors="replace")) > LARGEST_BYTES:
        parser.error(f"--text takes at most {LARGEST_BYTES} bytes: the server disconnects a client that sends more")
    with connected(zmq.REQ, options) as socket:
        if options.send_twice:
            show_refusal(socket, options.text, options.timeout)
        for i in range(1, options.count + 1):
            reply = request(socket, options.text, options.timeout)
            print(f"{i}: sent {options.text}, received {printable(reply)}", flush=True)
    print(f"done: {options.count} replies")


if __name__ == "__main__":
    run(main, stopped="stopped")
