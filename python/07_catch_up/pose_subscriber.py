"""Lesson 03, the listener to take home in Python: the twin of PoseSubscriber.cs. client.py is its command line.

One rule: a pose that is not the next one calls for a snapshot. It cures joining late, loss and a restart alike.
Bytes: as in server.py. Take home: this file.
"""

from __future__ import annotations

import contextlib
import itertools
import math
import re
import time
from collections.abc import Iterator
from typing import NamedTuple

import zmq

# Plain digits, as C# reads them: int() also takes 1_0 and the digits of every script, and fails at five thousand.
WHOLE, REAL = r"([0-9]{1,18})", r"(-?[0-9]{1,20}(?:\.[0-9]{1,20})?(?:[eE][-+]?[0-9]{1,2})?)"
POSE = re.compile(rf"pose/ ([^ ]+) {WHOLE}" + f" {REAL}" * 7)
SNAPSHOT = re.compile(rf"{WHOLE} (pose/ .*)")


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


class Pose(NamedTuple):
    run: str
    number: int
    position: tuple[float, ...]
    rotation: tuple[float, ...]

    def __str__(self) -> str:
        return f"{self.number}: at " + " ".join(f"{value:.4f}" for value in self.position)


def parse(message: str) -> Pose | None:
    """None for what is no pose: anybody can publish on a port."""
    if not (words := POSE.fullmatch(message)):
        return None
    x, y, z, qx, qy, qz, qw = map(float, words.groups()[2:])
    # More than C#'s numbers hold.
    if max(map(abs, (x, y, z, qx, qy, qz, qw))) > 3e38:
        return None
    return Pose(printable(words[1]), int(words[2]), (x, y, z), (qx, qy, qz, qw))


def text_of(frames: list[bytes]) -> str:
    """A message of several frames is none of this lesson's: it counts as an empty one."""
    return frames[0].decode(errors="replace") if len(frames) == 1 else ""


def take(socket: zmq.Socket[bytes], seconds: float) -> list[bytes]:
    """The frames of the next message; none if it does not come in time."""
    end = time.monotonic() + seconds
    while True:
        left = end - time.monotonic()
        # In slices, because on Windows Ctrl-C does not interrupt a wait.
        if socket.poll(math.ceil(min(0.2, max(0.0, left)) * 1000)):
            # What poll saw may be a broken message, which the socket drops: recv alone would then wait for the next.
            with contextlib.suppress(zmq.Again):
                return socket.recv_multipart(zmq.NOBLOCK)
        if left <= 0:
            return []


def waits(patience: float) -> Iterator[float]:
    """How long to wait for each try: 1, 2, 4, 8, 8 … seconds. A new connection takes four round trips."""
    end = time.monotonic() + patience
    for limit in itertools.chain((1, 2, 4), itertools.repeat(8)):
        left = end - time.monotonic()
        yield limit if left > 2 * limit else max(0.0, left)
        if time.monotonic() >= end:
            return


def reconnect(stream: zmq.Socket[bytes], endpoint: str) -> None:
    """For a stream that is silent: after another program than a publisher had the port, libzmq connects no more."""
    with contextlib.suppress(zmq.ZMQError):
        stream.disconnect(endpoint)
    stream.connect(endpoint)


class PoseSubscriber:
    """`pose` and `checksum` are what the publisher's were once it had sent that pose."""

    def __init__(self, stream: zmq.Socket[bytes], endpoint: str, snapshots: str) -> None:
        """The stream is a new SUB socket, which the caller closes; snapshots is an endpoint as well."""
        self.stream, self.endpoint, self.snapshots = stream, endpoint, snapshots
        self.pose: Pose | None = None
        self.checksum = self.received = self.missed = 0
        stream.subscribe("pose/")
        stream.connect(endpoint)

    def receive(self, patience: float) -> bool:
        """Wait for the next pose. False if there is none yet; TimeoutError if the publisher is gone."""
        end = time.monotonic() + 1
        while True:
            # The lost pose may have been the last one. So a second of silence calls for a snapshot as well.
            frames = take(self.stream, 1)
            pose = parse(text_of(frames))
            if not pose or not self.pose or pose.run != self.pose.run or pose.number > self.pose.number + 1:
                news = self.catch_up(patience)
                # The publisher went on, and nothing of it came.
                if news and not frames and not self.stream.poll(0):
                    reconnect(self.stream, self.endpoint)
                return news
            # A lower number was sent before the snapshot was made, and is contained in it.
            if pose.number == self.pose.number + 1:
                self.pose, self.checksum = pose, (31 * self.checksum + sum(frames[0])) % 2**32
                self.received += 1
                return True
            # A publisher that repeats itself must not hold the caller for ever.
            if time.monotonic() >= end:
                return False

    def catch_up(self, patience: float) -> bool:
        """Take over the publisher's state from a snapshot, and say which poses that skips."""
        old, (self.checksum, self.pose) = self.pose, self.ask(patience)
        run, number = self.pose[:2]
        if not old:
            print(f"joined run {run} at {number}, checksum {self.checksum}", flush=True)
        elif run != old.run:
            self.missed += number
            print(f"missed run {old.run} from {old.number + 1} on, and run {run} up to {number}", flush=True)
        elif number > old.number:
            self.missed += number - old.number
            print(f"missed {old.number + 1} to {number}", flush=True)
        return self.pose != old

    def ask(self, patience: float) -> tuple[int, Pose]:
        """A snapshot from the publisher: checksum and pose."""
        for limit in waits(patience):
            # Each try has a new socket, as in lesson 02: a restarted publisher does not know of the request before.
            with self.stream.context.socket(zmq.REQ) as socket:
                socket.linger, socket.maxmsgsize = 0, 65536
                socket.connect(self.snapshots)
                socket.send_string("pose/", zmq.NOBLOCK)
                frames = take(socket, limit)
            if frames:
                text = text_of(frames)
                found = SNAPSHOT.fullmatch(text)
                if found and int(found[1]) < 2**32 and (pose := parse(found[2])):
                    return int(found[1]), pose
                raise TimeoutError(f"what answers at {self.snapshots} gives no snapshots: {printable(text)}")
        raise TimeoutError(
            f"no snapshot from {self.snapshots} within {patience:g} s; is the server running, or the line slow?"
        )

    def newest(self, patience: float) -> bool:
        """Wait for a pose, then take all that wait behind it: only the last one counts."""
        for limit in waits(patience):
            frames = take(self.stream, limit)
            if not frames and not self.pose:
                reconnect(self.stream, self.endpoint)
            # The limit is for a publisher that sends faster than this loop takes.
            for _ in range(10_000):
                if not (later := take(self.stream, 0)):
                    break
                frames = later
            if pose := parse(text_of(frames)):
                old, self.pose = self.pose, pose
                self.received += 1
                self.missed += max(0, pose.number - old.number - 1) if old and old.run == pose.run else 0
                return True
        raise TimeoutError(f"no pose within {patience:g} s; is the server running, or the line slow?")

    def summary(self) -> str:
        """The last line that the lesson's programs print."""
        if not self.pose or (self.missed and not self.received):
            raise TimeoutError(f"no pose came over {self.endpoint}; is that the publisher, and its port open?")
        state = f"run {self.pose.run} at {self.pose.number}, checksum {self.checksum}"
        return f"done: received {self.received}, missed {self.missed}; {state}"
