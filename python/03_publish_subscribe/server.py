"""Lesson 03, publish-subscribe: one speaks, many listen; only the newest counts.

    python python/03_publish_subscribe/server.py   prints: listening on tcp://127.0.0.1:5553
    python python/03_publish_subscribe/client.py   or: dotnet run --project csharp-console -- 3

Bytes: UTF-8 text, one frame, which begins with its topic. `pose/ NUMBER x y z qx qy qz qw`: where a cube is, in Unity's
metres and axes, with a decimal point; NUMBER counts from 1. `news/ TEXT` and `newsflash/ TEXT` now and then.
Trouble on command: `--interval 0` publishes faster than a client with `--work 0.001` listens.
"""

import argparse
import contextlib
import itertools
import math
import re
import signal
import sys
import time

import zmq

# What listeners send are subscriptions, and those are short.
ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5553", zmq.PUB, 1000


def pose(steps: int) -> str:
    """Your own state goes here: this is a place on a circle of 2 m, one radian in 60 steps, facing forward."""
    angle = steps / 60
    place = (2 * math.cos(angle), 0, 2 * math.sin(angle), 0, math.sin(-angle / 2), 0, math.cos(angle / 2))
    return f"pose/ {steps} " + " ".join(f"{value:.4f}" for value in place)


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """Send never waits: whoever is not there yet, or listens too slowly, does not get it, and nobody is told."""
    for steps in itertools.count(1):
        socket.send_string(pose(steps))
        if steps % 60 == 0:
            socket.send_string(f"news/ the cube has made {steps} steps")
        if steps % 180 == 0:
            socket.send_string(f"newsflash/ it has made {steps} already")
        if options.interval:
            time.sleep(options.interval)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--interval", type=seconds, default=1 / 60, help="seconds between two poses; 0 is a flood")


# From here on all servers of this kit are the same, as far as they need it.


def seconds(text: str) -> float:
    if not 0 <= float(text) < 86_400:
        raise ValueError
    return float(text)


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
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does; on Windows that is SIGBREAK.
    signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
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
