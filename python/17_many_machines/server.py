"""Lesson 17, many machines: simulators come to the hub, the hub never looks for them.

    python python/17_many_machines/server.py                prints: listening on tcp://127.0.0.1:5567
    python python/17_many_machines/client.py                a simulator; start some, here or on other machines
    python python/17_many_machines/train.py --areas 2       or: dotnet run --project csharp-console -- 17
"""

import argparse
import contextlib
import functools
import re
import signal
import sys
import time

import zmq

from pathlib import Path
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from hub import Hub
from messages import LIMIT, Message
from upkeep import tick

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5567", zmq.ROUTER, 4 * LIMIT


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    # To send to a peer that is gone is then an error, and not silence.
    socket.router_mandatory = True
    hub, ticked = Hub(functools.partial(send, socket), options, functools.partial(print, flush=True)), 0.0
    while True:
        if time.monotonic() > ticked + 0.1:
            tick(hub)
            ticked = time.monotonic()
        if socket.poll(100):
            peer, *frames = socket.recv_multipart()
            hub.take(peer, frames or [b""])


def send(socket: zmq.Socket[bytes], peer: bytes, message: Message) -> bool:
    try:
        socket.send_multipart([peer, *message.frames()], zmq.NOBLOCK)
    except zmq.ZMQError:
        return False
    return True


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--version", default="1", help="what simulators must be of")
    parser.add_argument("--late", type=float, default=5, help="seconds until an answer is asked for elsewhere too")
    parser.add_argument("--patience", type=float, default=30, help="seconds that an episode waits for a simulator")
    parser.add_argument("--idle", type=float, default=15, help="seconds until one without work is sent home")


# From here on all servers of this kit are the same, as far as they need it.


def endpoint(text: str) -> str:
    """libzmq itself would listen on port 99999 - 65536, and for everybody, without a word."""
    port = re.fullmatch(r"tcp://[\w.*-]+:(\*|\d{1,5})", text, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 0 to 65535")
    # Options are read one after the other, and this one may come first.
    told = any(word.startswith(("--keys", "--open-to-anyone")) for word in sys.argv)
    if not told and not re.match(r"tcp://(localhost|127\.[\d.]+):", text):
        raise argparse.ArgumentTypeError(f"'{text}' lets anyone in: lesson 15 has keys, --open-to-anyone has none")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="port 0 takes a free one")
    parser.add_argument("--open-to-anyone", action="store_true", help="also from other machines, without keys")
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
