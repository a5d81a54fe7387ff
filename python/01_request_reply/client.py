"""Lesson 01, the client in Python: the twin of HelloRequester.cs, and it prints the same lines.

    python python/01_request_reply/client.py                   ten times Hello, ten times World
    python python/01_request_reply/client.py --send-twice      what strict alternation means

Bytes: UTF-8 text, one frame each way. Take home: this file.
"""

from __future__ import annotations

import argparse
import re
import sys
from socket import getaddrinfo

import zmq


def request(socket: zmq.Socket[bytes], text: str, patience: float) -> str:
    """Send a request and wait for its reply, at most `patience` seconds: TimeoutError after that."""
    socket.send_string(text)
    return receive(socket, patience)


def receive(socket: zmq.Socket[bytes], patience: float) -> str:
    """The second half of a request: wait for the reply, at most `patience` seconds."""
    if not socket.poll(int(patience * 1000)):
        raise TimeoutError(
            f"no reply from {socket.getsockopt_string(zmq.LAST_ENDPOINT)} within {patience:g} s; is the server running?"
        )
    return socket.recv_multipart()[0].decode(errors="replace")


def show_refusal(socket: zmq.Socket[bytes], text: str, patience: float) -> None:
    """REQ takes no second request before it has given the reply to the first."""
    socket.send_string(text)
    try:
        socket.send_string(text)
    except zmq.ZMQError as error:
        print(f"refused: {type(error).__name__}: {error}")
    print(f"received {receive(socket, patience)}: now REQ may send again")


def endpoint(text: str) -> str:
    """What --endpoint takes. libzmq itself takes port 99999 and an unknown host without a word, and waits."""
    parts = re.fullmatch(r"tcp://([^\s:]+):(\d{1,5})", text)
    if not parts or not 0 < int(parts[2]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5551, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except OSError:
        raise argparse.ArgumentTypeError(
            f"bad endpoint '{text}': unknown host '{parts[1]}'; check its spelling"
        ) from None
    return text


def main() -> None:
    parser = argparse.ArgumentParser(description="Says Hello and waits for World.")
    parser.add_argument("--endpoint", type=endpoint, default="tcp://127.0.0.1:5551", help="the server")
    parser.add_argument("--count", type=int, default=10, help="how many times to ask")
    parser.add_argument("--text", default="Hello", help="what to say")
    parser.add_argument("--patience", type=float, default=2.5, help="seconds to wait for each reply")
    parser.add_argument("--send-twice", action="store_true", help="send a second request before the reply")
    options = parser.parse_args()
    if options.count < 0 or not 0 < options.patience < 86400:
        parser.error("--count takes a whole number, --patience seconds, and neither is negative")
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context, context.socket(zmq.REQ) as socket:
        # A request that nobody fetched is dropped at the end; waiting for its delivery could take for ever.
        socket.linger = 0
        socket.connect(options.endpoint)
        if options.send_twice:
            show_refusal(socket, options.text, options.patience)
        for i in range(1, options.count + 1):
            print(f"{i}: sent {options.text}, received {request(socket, options.text, options.patience)}", flush=True)
        print(f"done: {options.count} replies")


if __name__ == "__main__":
    try:
        main()
    except TimeoutError as error:
        sys.exit(f"gave up: {error}")
    except KeyboardInterrupt:
        sys.exit("stopped")
