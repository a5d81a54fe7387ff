"""Lesson 03, the listener to take home in Python: the twin of PoseSubscriber.cs. client.py is its command line.

One rule: a pose that is not the next one calls for a snapshot. It cures joining late, loss and a restart alike.
Bytes: as in server.py. Take home: this file.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import zmq


class Pose(NamedTuple):
    run: str
    number: int
    position: tuple[float, ...]
    rotation: tuple[float, ...]

    def __str__(self) -> str:
        return f"{self.number}: at " + " ".join(f"{value:.4f}" for value in self.position)


def parse(frames: list[bytes]) -> Pose | None:
    """None for what is no pose: anybody can publish on a port."""
    try:
        (frame,) = frames
        topic, run, number, *text = frame.decode().split(" ")
        x, y, z, qx, qy, qz, qw = map(float, text)
        return Pose(run, int(number), (x, y, z), (qx, qy, qz, qw)) if topic == "pose/" else None
    except ValueError:
        return None


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
        while True:
            # The lost pose may have been the last one. So a second of silence calls for a snapshot as well.
            frames = self.stream.recv_multipart() if self.stream.poll(1000) else []
            pose = parse(frames)
            if not pose or not self.pose or pose.run != self.pose.run or pose.number > self.pose.number + 1:
                return self.catch_up(patience)
            # A lower number was sent before the snapshot was made, and is contained in it.
            if pose.number == self.pose.number + 1:
                self.pose, self.checksum = pose, (31 * self.checksum + sum(frames[0])) % 2**32
                self.received += 1
                return True

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
        end = time.monotonic() + patience
        while (left := end - time.monotonic()) > 0:
            # Each try has a new socket, as in lesson 02: a restarted publisher does not know of the request before.
            with self.stream.context.socket(zmq.REQ) as socket:
                socket.linger = 0
                socket.connect(self.snapshots)
                socket.send_string("pose/")
                if socket.poll(math.ceil(min(1.0, left) * 1000)):
                    checksum, _, frame = socket.recv_multipart()[0].partition(b" ")
                    if (pose := parse([frame])) and checksum.isdigit():
                        return int(checksum), pose
                    raise TimeoutError(f"what answers at {self.snapshots} gives no snapshots: {checksum + frame!r:.40}")
        raise TimeoutError(f"no snapshot from {self.snapshots} within {patience:g} s; is the server running?")

    def newest(self, patience: float) -> bool:
        """Wait for a pose, then take all that wait behind it: only the last one counts."""
        frames: list[bytes] = []
        # The limit is for a publisher that sends faster than this loop takes.
        for i in range(10_000):
            if not self.stream.poll(0 if i else math.ceil(patience * 1000)):
                break
            frames = self.stream.recv_multipart()
        old, self.pose = self.pose, parse(frames)
        if not self.pose:
            raise TimeoutError(f"no pose within {patience:g} s; is the server running?")
        self.received += 1
        self.missed += self.pose.number - old.number - 1 if old and old.run == self.pose.run else 0
        return True

    def summary(self) -> str:
        """The last line that the lesson's programs print."""
        if not self.pose or (self.missed and not self.received):
            raise TimeoutError(f"no pose came over {self.endpoint}; is that the publisher, and its port open?")
        state = f"run {self.pose.run} at {self.pose.number}, checksum {self.checksum}"
        return f"done: received {self.received}, missed {self.missed}; {state}"
