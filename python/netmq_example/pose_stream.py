"""Lesson 07, the subscriber to copy in Python: the C# version is PoseSubscriber.cs. client.py is its command line.

One rule: a pose that is not the next one calls for a snapshot. It cures joining late, loss and a restart alike.
Bytes: as in server.py.

Lesson 07, what the server knows: the state, the next message, and the snapshot that stands for all before it.

Bytes: as in server.py.
"""

import contextlib
import math
import re
import secrets
import time
from collections.abc import Callable
from typing import NamedTuple

import zmq


class Publisher:
    """A cube that goes round in circles, and the state that its messages add up to."""

    def __init__(self) -> None:
        # Numbers begin anew with each start. By the run, number 5 of now differs from number 5 of then.
        self.run, self.number = secrets.token_hex(4), 0
        # The checksum stands for any state to which each message adds: one lost or taken twice, and it is another.
        self.message, self.checksum = "", 0

    def step(self) -> str:
        """The next message, counted in."""
        self.number += 1
        angle = self.number / 60
        place = (2 * math.cos(angle), 0, 2 * math.sin(angle), 0, math.sin(-angle / 2), 0, math.cos(angle / 2))
        self.message = f"pose/ {self.run} {self.number} " + " ".join(f"{value:.4f}" for value in place)
        self.checksum = (31 * self.checksum + sum(self.message.encode())) % 2**32
        return self.message

    def snapshot(self, request: bytes) -> str:
        """What a subscriber needs to go on with the next message, as if it had heard every one before."""
        if request != b"pose/":
            return f"error: expected pose/, got {request[:40]!r}"
        print(f"snapshot at {self.number}, checksum {self.checksum}", flush=True)
        return f"{self.checksum} {self.message}"


# Plain digits, as C# reads them: int() and float() also take 1_0, nan and the digits of every script.
POSE = re.compile("pose/ ([0-9a-z]{1,32}) ([0-9]{1,18})" + r" (-?[0-9]{1,20}(?:\.[0-9]{1,20})?)" * 7)


class Pose(NamedTuple):
    run: str
    number: int
    position: tuple[float, ...]
    rotation: tuple[float, ...]


def parse(message: str) -> Pose | None:
    """None for what is no pose: anybody can publish on a port."""
    if words := POSE.fullmatch(message):
        numbers = tuple(map(float, words.groups()[2:]))
        return Pose(words[1], int(words[2]), numbers[:3], numbers[3:])
    return None


def take(socket: zmq.Socket[bytes], timeout: float) -> str | None:
    """The next message, or None. One of several frames is none of this lesson's, and as good as an empty one."""
    end = time.monotonic() + timeout
    # In slices: on Windows Ctrl-C does not interrupt a longer wait.
    while not socket.poll(200) and time.monotonic() < end:
        pass
    # What poll saw may be a broken message, which the socket drops: then there is none after all.
    with contextlib.suppress(zmq.Again):
        frames = socket.recv_multipart(zmq.NOBLOCK)
        return frames[0].decode(errors="replace") if len(frames) == 1 else ""
    return None


class PoseSubscriber:
    """`pose` and `checksum` are what the publisher's were once it had sent that pose."""

    def __init__(self, stream: zmq.Socket[bytes], endpoint: str, snapshots: str, report: Callable[[str], None]) -> None:
        """The stream is a new SUB socket, which the caller closes; `report` gets a line about what was missed."""
        self.stream, self.endpoint, self.snapshots, self.report = stream, endpoint, snapshots, report
        # No run has this name, so the first pose is not the next one.
        self.pose = Pose("", 0, (0, 0, 0), (0, 0, 0, 1))
        self.checksum = self.received = self.missed = self.deaf = 0
        stream.subscribe("pose/")
        stream.connect(endpoint)

    def receive(self, timeout: float) -> bool:
        """Wait for the next pose. False if there is none yet; TimeoutError if the publisher is gone."""
        end = time.monotonic() + 1
        while time.monotonic() < end:
            # The lost pose may have been the last one. So a second of silence calls for a snapshot as well.
            message = take(self.stream, 1)
            pose = parse(message or "")
            if not pose or pose.run != self.pose.run or pose.number > self.pose.number + 1:
                return self.catch_up(timeout, message is None)
            # A lower number was sent before the snapshot was made, and is contained in it.
            if pose.number == self.pose.number + 1:
                self.pose, self.checksum = pose, (31 * self.checksum + sum(map(ord, message or ""))) % 2**32
                self.received, self.deaf = self.received + 1, 0
                return True
        # A publisher that repeats itself must not hold the caller for ever.
        return False

    def catch_up(self, timeout: float, silent: bool) -> bool:
        """Take over the publisher's state from a snapshot, and say which poses that skips."""
        old, (self.checksum, self.pose) = self.pose, self.ask(timeout)
        run, number = self.pose.run, self.pose.number
        if not old.run:
            self.report(f"joined run {run} at {number}, checksum {self.checksum}")
        elif run != old.run:
            self.missed += number
            self.report(f"missed run {old.run} from {old.number + 1} on, and run {run} up to {number}")
        elif number > old.number:
            self.missed += number - old.number
            self.report(f"missed {old.number + 1} to {number}")
        if silent and self.pose != old and not self.stream.poll(0):
            self.connect_again()
        return self.pose != old

    def connect_again(self) -> None:
        """The publisher goes on and nothing comes: where another program had the port, libzmq connects no more."""
        self.deaf += 1
        if self.deaf > 5:
            raise TimeoutError(f"no pose came over {self.endpoint}; is that the publisher, and its port open?")
        self.stream.disconnect(self.endpoint)
        self.stream.connect(self.endpoint)

    def ask(self, timeout: float) -> tuple[int, Pose]:
        """A snapshot from the publisher: checksum and pose."""
        end, limit = time.monotonic() + timeout, 1
        while (left := end - time.monotonic()) > 0:
            # Each try has a new socket, as in lesson 02, and more time: a new connection takes four round trips.
            with self.stream.context.socket(zmq.REQ) as socket:
                socket.linger, socket.maxmsgsize = 0, 65_536
                socket.connect(self.snapshots)
                socket.send_string("pose/")
                text = take(socket, min(limit, left))
            if text is not None:
                checksum, _, message = text.partition(" ")
                if (pose := parse(message)) and re.fullmatch("[0-9]{1,10}", checksum) and int(checksum) < 2**32:
                    return int(checksum), pose
                raise TimeoutError(f"what answers at {self.snapshots} gives no snapshots: {text!r:.80}")
            limit *= 4
        raise TimeoutError(f"no snapshot from {self.snapshots} within {timeout:g} s; is the server running?")
