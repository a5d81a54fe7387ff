"""Lesson 01, the client in Python: the C# version is HelloRequester.cs, and it prints the same lines.

    python python/01_request_reply/client.py                   ten times Hello, ten times World
    python python/01_request_reply/client.py --send-twice      what strict alternation means

Bytes: UTF-8 text, one frame each way.
"""

import argparse
import re
import sys
import time
from socket import getaddrinfo

import zmq

ENDPOINT = "tcp://127.0.0.1:5551"


def request(socket: zmq.Socket[bytes], text: str, timeout: float) -> str:
    """Send a request and wait for its reply, at most `timeout` seconds: zmq.Again after that."""
    # Where there is no connection to send on, as after a peer that is not ZeroMQ, this raises zmq.Again as well.
    socket.send(text.encode(errors="replace"))
    return receive(socket, timeout)


def receive(socket: zmq.Socket[bytes], timeout: float) -> str:
    end = time.monotonic() + timeout
    # In slices: on Windows Ctrl-C does not interrupt a longer wait.
    while not socket.poll(200) and time.monotonic() < end:
        pass
    return socket.recv_multipart(zmq.NOBLOCK)[0].decode(errors="replace")


def show_refusal(socket: zmq.Socket[bytes], text: str, timeout: float) -> None:
    """REQ takes no second request before it has given the reply to the first."""
    socket.send(text.encode(errors="replace"))
    try:
        socket.send(text.encode(errors="replace"))
    except zmq.ZMQError as error:
        print(f"refused: {type(error).__name__}: {error}")
    print(f"received {printable(receive(socket, timeout))}: now REQ may send again")


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
    parser = argparse.ArgumentParser(description="Says Hello and waits for World.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--count", type=int, default=10, help="how many times to ask")
    parser.add_argument("--text", default="Hello", help="what to say")
    parser.add_argument("--timeout", type=float, default=2.5, help="seconds to wait for each reply")
    parser.add_argument("--send-twice", action="store_true", help="send a second request before the reply")
    options = parser.parse_args()
    if options.count < 0 or not 0 < options.timeout < 86400:
        parser.error("--count takes a whole number from 0, --timeout seconds, more than 0")
    print(f"asking {options.endpoint}", flush=True)
    with zmq.Context() as context, context.socket(zmq.REQ) as socket:
        # A request that nobody fetched is dropped at the end; waiting for its delivery could take for ever.
        # A peer that announces more than the largest message is disconnected before it is in memory.
        # Sending does not wait: libzmq would say of a request whose connection ends in that moment that it is sent.
        socket.linger, socket.maxmsgsize, socket.sndtimeo = 0, 65_536, 0
        socket.connect(options.endpoint)
        try:
            if options.send_twice:
                show_refusal(socket, options.text, options.timeout)
            for i in range(1, options.count + 1):
                reply = request(socket, options.text, options.timeout)
                print(f"{i}: sent {options.text}, received {printable(reply)}", flush=True)
        except zmq.Again:
            sys.exit(f"gave up: no reply from {options.endpoint} within {options.timeout:g} s; is the server running?")
    print(f"done: {options.count} replies")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
