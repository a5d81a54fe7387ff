"""A snapshot, then the stream: a subscriber that joins late or loses a message gets back to the publisher's state.

    with PoseSubscriber("tcp://127.0.0.1:5557") as subscriber:
        while True:
            if subscriber.receive():
                print(subscriber.pose.position, subscriber.gaps)

Bytes: UTF-8 text, one frame. The stream (PUB): `pose/ RUN NUMBER x y z qx qy qz qw`, a position in metres and a
rotation as a quaternion; RUN is new with each start of the publisher, NUMBER counts its poses from 1. Snapshots (REP):
`pose/` is answered with `CHECKSUM` and the last pose message, anything else with a text that begins with `error:`.

Timeout is a publisher that is gone, Error what gives no snapshots. The subscriber in C# is PoseSubscriber.cs.
"""

import contextlib
import logging
import re
import secrets
import time
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import zmq

from netmq_example import arguments, check
from netmq_example.errors import Error, Timeout
from netmq_example.former import positional
from netmq_example.one_process import Keys, OneProcess
from netmq_example.program import SLICE_MS, Context, Socket, encoded, limit
from netmq_example.trouble import cure

# After so much silence a subscriber asks for a snapshot: the message that was lost may have been the last one.
SILENCE_SECONDS = 1.0
# New connections without a pose after which the stream's port is taken for closed.
MOST_CONNECTIONS = 5
# So many of the newest gaps are kept.
MOST_GAPS = 1000

log = logging.getLogger("netmq_example.client")
publish_log = logging.getLogger("netmq_example.publish")


def snapshots_beside(endpoint: str) -> str:
    """The endpoint of a stream's snapshots, unless you give one: the port is 100 higher; 0 and * stay."""
    check.endpoint(endpoint, "tcp://127.0.0.1:5557", lowest_port=0)
    higher = re.sub(r"[1-9]\d*$", lambda port: str(int(port[0]) + 100), endpoint)
    return check.endpoint(higher, "tcp://127.0.0.1:5657", lowest_port=0)


class PosePublisher:
    """The messages of a stream of poses, and the state that they add up to."""

    def __init__(self, *, run: str | None = None) -> None:
        """`run` has 1 to 32 small letters and digits, new with each start: by default it is random."""
        # By the run, number 5 of now differs from number 5 of then.
        self.run = secrets.token_hex(4) if run is None else arguments.text("run", run)
        self.number = 0
        self.message = ""
        # The checksum stands for any state to which each message adds: one lost or taken twice, and it is another.
        self.checksum = 0

    def step(self, position: Sequence[float], rotation: Sequence[float]) -> str:
        """The next message, counted in: a position x y z in metres, and a rotation as a quaternion x y z w."""
        numbers = [arguments.number("position", value) for value in position]
        numbers += [arguments.number("rotation", value) for value in rotation]
        if len(position) != 3 or len(rotation) != 4:
            raise ValueError(f"a pose has 3 and 4 numbers, not {len(position)} and {len(rotation)}")
        self.number += 1
        self.message = f"pose/ {self.run} {self.number} " + " ".join(f"{value:.4f}" for value in numbers)
        # Before it is counted in: nobody would ever get a longer one.
        encoded(self.message)
        self.checksum = added(self.checksum, self.message)
        return self.message

    def snapshot(self) -> str:
        """All that a subscriber needs to go on with the next message, as if it had received every one before."""
        publish_log.info("snapshot at %d, checksum %d", self.number, self.checksum)
        return f"{self.checksum} {self.message}"


def added(checksum: int, message: str) -> int:
    return (31 * checksum + sum(message.encode())) % 2**32


# Plain digits, as C# reads them: int() and float() also take 1_0, nan and the digits of every script.
POSE = re.compile("pose/ ([0-9a-z]{1,32}) ([0-9]{1,18})" + r" (-?[0-9]{1,20}(?:\.[0-9]{1,20})?)" * 7)


class Pose(NamedTuple):
    """Pose `number` of a `run`, from 1: x y z in metres, and a quaternion x y z w."""

    run: str
    number: int
    position: tuple[float, ...]
    rotation: tuple[float, ...]


class Gap(NamedTuple):
    """Poses of a run that did not come, the `first` to the `last`. None: the run has ended, and nobody knows where."""

    run: str
    first: int
    last: int | None


def parse(message: str) -> Pose | None:
    """None for what is no pose: anybody can publish on a port."""
    words = POSE.fullmatch(message)
    if not words:
        return None
    numbers = tuple(map(float, words.groups()[2:]))
    return Pose(words[1], int(words[2]), numbers[:3], numbers[3:])


class PoseSubscriber(OneProcess):
    """Knows of each pose it missed. `pose` and `checksum` are what the publisher's were once it had sent that pose.

    `missed` counts them, also the pose of a snapshot, whose message did not come; `received` counts messages. `gaps`
    has the newest 1000 gaps, and its popleft() takes the oldest. What was before it joined is no gap. Use it on one
    thread; after a Timeout it may be called again.
    One rule: a pose that is not the next one calls for a snapshot. It cures joining late, loss and a restart alike.
    """

    @positional("stream", "endpoint", "snapshots", "report")
    def __init__(
        self,
        endpoint: str,
        *,
        snapshots: str = "",
        timeout: float = 5.0,
        stream: Socket | None = None,
        keys: Keys | None = None,
        context: Context | None = None,
    ) -> None:
        """A snapshot may take `timeout` seconds. Its endpoint is that of the stream with a port 100 higher, unless you
        give one. A SUB socket with options of your own goes in as `stream`, and is closed by you.
        """
        self.endpoint = check.endpoint(endpoint, "tcp://127.0.0.1:5557")
        self.snapshots = check.endpoint(snapshots or snapshots_beside(endpoint), "tcp://127.0.0.1:5657")
        self.timeout = check.seconds("timeout", timeout)
        self.own_stream = stream is None
        stream = arguments.context(context).socket(zmq.SUB) if stream is None else stream
        self.stream: Socket = arguments.blocking("stream", stream, zmq.Socket)
        self.keys = arguments.keys(keys)
        if stream.type != zmq.SUB:
            raise ValueError(f"stream takes a SUB socket, not {stream.type!s:.40}")
        self.report = log.info
        # No run has this name, so the first pose is not the next one.
        self.pose = Pose("", 0, (0, 0, 0), (0, 0, 0, 1))
        self.checksum = 0
        self.received = 0
        self.missed = 0
        self.gaps: deque[Gap] = deque(maxlen=MOST_GAPS)
        self.connections = 0
        limit(stream)
        if self.keys:
            self.keys.apply(stream)
        stream.subscribe("pose/")
        stream.connect(self.endpoint)

    def receive(self, timeout: float | None = None) -> bool:
        """Wait for the next pose, and for a snapshot at most so many seconds. False if there is none yet.

        Timeout: the publisher is gone. Error: what answers there gives no snapshots.
        """
        self.check_process()
        timeout = self.timeout if timeout is None else check.seconds("timeout", timeout)
        end = time.monotonic() + 1
        while time.monotonic() < end:
            message = take(self.stream, SILENCE_SECONDS)
            pose = parse(message or "")
            if not pose or pose.run != self.pose.run or pose.number > self.pose.number + 1:
                return self.catch_up(timeout, silent=message is None)
            # A lower number was sent before the snapshot was made, and is contained in it.
            if pose.number == self.pose.number + 1:
                self.pose = pose
                self.checksum = added(self.checksum, message or "")
                self.received += 1
                self.connections = 0
                return True
        # A publisher that repeats itself must not hold the caller for ever.
        return False

    def catch_up(self, timeout: float, silent: bool) -> bool:
        """Take over the publisher's state from a snapshot, and report which poses that skips."""
        old = self.pose
        try:
            self.checksum, self.pose = self.ask(timeout)
        except Timeout as error:
            if silent:
                raise
            why = f"poses do come from {self.endpoint}; give snapshots, unless these are 100 ports higher"
            raise Timeout(f"{why}: {error}") from None
        run, number = self.pose.run, self.pose.number
        if not old.run:
            self.report(f"joined run {run} at {number}, checksum {self.checksum}")
        elif run != old.run:
            self.missed += number
            self.gaps += [Gap(old.run, old.number + 1, None), Gap(run, 1, number)]
            self.report(f"missed run {old.run} from {old.number + 1} on, and run {run} up to {number}")
        elif number > old.number:
            self.missed += number - old.number
            self.gaps.append(Gap(run, old.number + 1, number))
            self.report(f"missed {old.number + 1} to {number}")
        if silent and self.pose != old and not self.stream.poll(0):
            self.connect_again()
        return self.pose != old

    def connect_again(self) -> None:
        """The publisher goes on and nothing comes: where another program had the port, libzmq connects no more."""
        self.connections += 1
        if self.connections > MOST_CONNECTIONS:
            raise Timeout(f"no pose came over {self.endpoint}; is that the publisher, and its port open?")
        self.stream.disconnect(self.endpoint)
        self.stream.connect(self.endpoint)

    def ask(self, timeout: float) -> tuple[int, Pose]:
        end = time.monotonic() + timeout
        wait = 1.0
        while (left := end - time.monotonic()) > 0:
            # Each try has a new socket, as in lesson 02, and more time: a new connection takes four round trips.
            with self.stream.context.socket(zmq.REQ) as socket:
                limit(socket)
                if self.keys:
                    self.keys.apply(socket)
                socket.connect(self.snapshots)
                socket.send_string("pose/")
                text = take(socket, min(wait, left))
            if text is not None:
                checksum, _, message = text.partition(" ")
                pose = parse(message)
                if pose and re.fullmatch("[0-9]{1,10}", checksum) and int(checksum) < 2**32:
                    return int(checksum), pose
                question = "is that lesson 07's second port?"
                why = f"what answers at {self.snapshots} gives no snapshots: {text!r:.80}; {question}"
                raise Error(why)
            wait *= 4
        why = cure(self.snapshots, "is the server running?")
        raise Timeout(f"no snapshot from {self.snapshots} within {timeout:g} s; {why}")

    def close(self) -> None:
        """Close the stream, unless it was the caller's. Twice is once."""
        if self.own_stream:
            self.stream.close()


def take(socket: Socket, timeout: float) -> str | None:
    """The next message, or None. One of several frames is no pose and no snapshot, and as good as an empty one."""
    end = time.monotonic() + timeout
    while not socket.poll(SLICE_MS) and time.monotonic() < end:
        pass
    # The message that poll saw may be a broken one, which the socket drops: then there is none after all.
    with contextlib.suppress(zmq.Again):
        frames = socket.recv_multipart(zmq.NOBLOCK)
        return frames[0].decode(errors="replace") if len(frames) == 1 else ""
    return None
