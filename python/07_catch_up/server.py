"""Lesson 07, catch up: a snapshot, then the stream; a client that joins late or loses something catches up.

    python python/07_catch_up/server.py   prints: snapshots on tcp://127.0.0.1:5657
                                                  listening on tcp://127.0.0.1:5557
    python python/07_catch_up/client.py   or: dotnet run --project csharp-console -- 7

Bytes: UTF-8 text, one frame. The stream (PUB): `pose/ RUN NUMBER x y z qx qy qz qw`, as in lesson 03; RUN is new with
each start, NUMBER counts its poses from 1. Snapshots (REP): `pose/` is answered with `CHECKSUM` and the last pose
message, anything else with a text that begins with `error:`.
Trouble on command: start a client late; `--interval 0` and a client with `--work 0.001`; stop this server while a
client follows, and start it again.
"""

import argparse
import contextlib
import math
import re
import signal
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.pose_stream import Publisher

# What subscribers send, subscriptions and requests, is short.
ENDPOINT, LARGEST = "tcp://127.0.0.1:5557", 1000


def serve(stream: zmq.Socket[bytes], snapshots: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """Publish and answer on one thread, so that a snapshot is always that of a whole message."""
    publisher, due = Publisher(), time.monotonic()
    while True:
        if time.monotonic() >= due:
            stream.send_string(publisher.step())
            # After a long sleep of the machine one second is made up for, not the whole night.
            due = max(due + options.interval, time.monotonic() - 1)
            if publisher.number == options.count:
                print(f"published {options.count}, checksum {publisher.checksum}", flush=True)
                due = math.inf
        # In slices: on Windows Ctrl-C does not interrupt a longer wait.
        if snapshots.poll(math.ceil(1000 * min(0.2, max(0, due - time.monotonic())))):
            # What poll saw may be a broken request, which the socket drops: then there is none after all.
            with contextlib.suppress(zmq.Again):
                request = b" ".join(snapshots.recv_multipart(zmq.NOBLOCK))
                snapshots.send_string(publisher.snapshot(request), zmq.NOBLOCK)


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


# This lesson alone has two sockets to bind, and says that it listens when both are.


def bind(socket: zmq.Socket[bytes], where: str) -> str:
    """Where it listens, which port 0 does not say."""
    # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
    # Who announces more than the largest message is disconnected before it is in memory.
    socket.linger, socket.maxmsgsize = 0, LARGEST
    try:
        socket.bind(where)
    except zmq.ZMQError as error:
        cure = "try --endpoint tcp://127.0.0.1:0, which takes a free port"
        sys.exit(f"cannot listen on {where}: {zmq.strerror(error.errno or 0)}; {cure}")
    return socket.getsockopt_string(zmq.LAST_ENDPOINT)


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="port 0 takes a free one")
    parser.add_argument("--open-to-anyone", action="store_true", help="also from other machines, without keys")
    parser.add_argument("--snapshots", type=endpoint, help="where to ask for one; if left out, the port 100 higher")
    parser.add_argument("--interval", type=seconds, default=1 / 60, help="seconds between two poses; 0 is a flood")
    parser.add_argument("--count", type=int, default=0, help="poses to publish, after that only snapshots; 0: no end")
    options = parser.parse_args()
    # 100 higher; port 0 and * stay as they are.
    higher = re.sub(r"[1-9]\d*$", lambda port: str(int(port[0]) + 100), options.endpoint)
    try:
        where = options.snapshots or endpoint(higher)
    except argparse.ArgumentTypeError as error:
        parser.error(f"--snapshots: {error}")
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does; on Windows that is SIGBREAK.
    signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.PUB) as stream, context.socket(zmq.REP) as snapshots:
        listening = bind(stream, options.endpoint)
        print("snapshots on", bind(snapshots, where))
        print("listening on", listening, flush=True)
        serve(stream, snapshots, options)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
