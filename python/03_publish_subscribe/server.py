"""Lesson 03, publish-subscribe: one side speaks, many listen, and each listener finds out what it missed.

    python python/03_publish_subscribe/server.py   prints: snapshots on tcp://127.0.0.1:5653
                                                           listening on tcp://127.0.0.1:5553
    python python/03_publish_subscribe/client.py   or: dotnet run --project csharp-console -- 3

Bytes: UTF-8 text, one frame. The stream (PUB): `pose/ RUN NUMBER x y z qx qy qz qw`, in Unity's metres and axes with a
decimal point; `news/ RUN NUMBER TEXT`; `newsflash/ RUN NUMBER TEXT`. RUN is new with each start, NUMBER counts the
messages of each topic from 1. Snapshots (REP): `pose/` is answered with `CHECKSUM` and the last pose message, anything
else with a text that begins with `error:`.
Trouble on command: start a client late; `--rate 20000 --hwm 100` and a client with `--work 0.001`; stop this server
while a client listens, and start it again. Take home: this file.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import math
import re
import secrets
import signal
import sys
import time
from collections import Counter

import zmq


class Publisher:
    """A cube that goes round in circles, and tells so to whoever listens."""

    def __init__(self, stream: zmq.Socket[bytes]) -> None:
        # Numbers begin anew with each start. By the run, number 5 of now differs from number 5 of then.
        self.run, self.sent = secrets.token_hex(4), Counter[str]()
        # The checksum stands for any state to which each message adds: one lost or taken twice, and it is another.
        self.stream, self.pose, self.checksum = stream, b"", 0

    def publish(self, topic: str, body: str) -> bytes:
        # PUB never waits: a listener whose queue is full does not get it, and is not told.
        self.sent[topic] += 1
        message = f"{topic} {self.run} {self.sent[topic]} {body}".encode()
        self.stream.send(message)
        return message

    def step(self) -> None:
        """The next pose: on a circle of 2 m around the origin, one radian in 60 steps, facing forward."""
        steps = self.sent["pose/"] + 1
        x, z, half = 2 * math.cos(steps / 60), 2 * math.sin(steps / 60), -steps / 120
        pose = (x, 0, z, 0, math.sin(half), 0, math.cos(half))
        self.pose = self.publish("pose/", " ".join(f"{value:.4f}" for value in pose))
        self.checksum = (31 * self.checksum + sum(self.pose)) % 2**32
        for topic, every in (("news/", 60), ("newsflash/", 180)):
            if steps % every == 0:
                self.publish(topic, f"the cube has made {steps} steps")

    def snapshot(self, request: list[bytes]) -> bytes:
        """What a listener needs to go on with the next pose, as if it had heard every one before."""
        if request != [b"pose/"]:
            return f"error: expected pose/, got {len(request)} frames beginning {request[0][:20]!r}".encode()
        print(f"snapshot at {self.sent['pose/']}, checksum {self.checksum}", flush=True)
        return b"%d %s" % (self.checksum, self.pose)


def serve(publisher: Publisher, snapshots: zmq.Socket[bytes], rate: int, count: int) -> None:
    """Publish at a steady rate and answer in between, on one thread: no pose falls into the making of a snapshot."""
    due = time.monotonic()
    while True:
        ahead = not count or publisher.sent["pose/"] < count
        if ahead and time.monotonic() >= due:
            publisher.step()
            # After a long sleep of the machine one second is made up for, not the whole night.
            due = max(due + (1 / rate if rate else 0), time.monotonic() - 1)
            if publisher.sent["pose/"] == count:
                print(f"published {count}, checksum {publisher.checksum}", flush=True)
        # A poll with a limit, because on Windows Ctrl-C does not interrupt a wait without one.
        wait = min(0.2, max(0.0, due - time.monotonic())) if ahead else 0.2
        if snapshots.poll(math.ceil(wait * 1000)):
            # What poll saw may be a broken request, which the socket drops: recv alone would then wait for the next.
            with contextlib.suppress(zmq.Again):
                snapshots.send(publisher.snapshot(snapshots.recv_multipart(zmq.NOBLOCK)), zmq.NOBLOCK)


def endpoint(text: str) -> str:
    # libzmq itself would listen on port 99999 - 65536 without a word.
    port = re.fullmatch(r"tcp://[^\s:]+:(\*|\d{1,5})", text)
    if not port or (port[1] != "*" and int(port[1]) > 65535):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5553, port up to 65535")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Publishes a moving pose, and news of it.")
    parser.add_argument("--endpoint", type=endpoint, default="tcp://127.0.0.1:5553", help="port 0 takes a free one")
    parser.add_argument("--snapshots", type=endpoint, help="where to ask for one; if left out, the port 100 higher")
    parser.add_argument("--rate", type=int, default=60, help="poses a second; 0: as fast as this machine can")
    parser.add_argument("--count", type=int, default=0, help="poses to publish, after that only snapshots; 0: no end")
    parser.add_argument("--hwm", type=int, default=1000, help="messages that may wait for one listener; 0: no limit")
    options = parser.parse_args()
    if not all(0 <= number < 2**31 for number in (options.rate, options.count, options.hwm)):
        parser.error("--rate, --count and --hwm take whole numbers from 0 on")
    if not options.snapshots:
        # Parsed as if it had been given. Port 0 or * stays as it is: both sockets take a free one.
        higher = re.sub(r"[1-9]\d*$", lambda port: str(int(port[0]) + 100), options.endpoint)
        parser.parse_args(["--snapshots", higher], options)
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.PUB) as stream, context.socket(zmq.REP) as snapshots:
        # The high watermark holds for what is bound or connected after it is set.
        stream.sndhwm = options.hwm
        for socket, where in ((stream, options.endpoint), (snapshots, options.snapshots)):
            # What nobody fetched is dropped at the end; waiting for its delivery could take for ever.
            # What listeners send, subscriptions and requests, is short.
            socket.linger, socket.maxmsgsize = 0, 1000
            try:
                socket.bind(where)
            except zmq.ZMQError as error:
                causes = {zmq.EADDRINUSE: "the port is taken", errno.EACCES: "the system reserves this port"}
                cause = causes.get(error.errno or 0, "this machine has no such address")
                sys.exit(f"cannot listen on {where}: {cause}; try --endpoint tcp://127.0.0.1:0, which takes a free one")
        print("snapshots on", snapshots.getsockopt_string(zmq.LAST_ENDPOINT))
        print("listening on", stream.getsockopt_string(zmq.LAST_ENDPOINT), flush=True)
        serve(Publisher(stream), snapshots, options.rate, options.count)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
