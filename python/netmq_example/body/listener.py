"""Application 20, the listener to copy in Python: the C# version is BodyListener.cs. client.py is its command line.

Bytes: as in server.py.
"""

import math
import re
import time
from typing import NamedTuple

import zmq

from netmq_example.topic_listener import TopicListener

# Plain numbers, as C# reads them: float() also takes 1_0, nan and the digits of every script.
NUMBER = r" (-?[0-9]{1,9}(?:\.[0-9]{1,9})?)"
LANDMARKS = {"pose": 33, "hand": 21}
TOPIC = r"(?:pose/[0-9]+|(hand)/(?:left|right))/"
POSE = re.compile(rf"{TOPIC} ([0-9]{{1,18}}) ([0-9]{{1,9}}\.[0-9]{{1,9}})((?:{NUMBER})*)")


class BodyPose(NamedTuple):
    """A body's 33 landmarks or a hand's 21: x, y, z and visibility, in Unity's axes. None when nobody is there."""

    number: int
    seconds: float
    landmarks: list[tuple[float, float, float, float]]

    def angle(self, a: int, b: int, c: int) -> float:
        """How far the limb is bent open at landmark b, in degrees; 180 is straight."""
        first, middle, last = (self.landmarks[i][:3] for i in (a, b, c))
        one, other = ([end[i] - middle[i] for i in range(3)] for end in (first, last))
        lengths = math.sqrt(dot(one, one)) * math.sqrt(dot(other, other))
        return math.acos(max(-1, min(1, dot(one, other) / lengths))) * 180 / math.pi if lengths else 0.0


def dot(one: list[float], other: list[float]) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def parse(message: str) -> BodyPose | None:
    """None for what is no pose: anybody can publish on a port."""
    if not (words := POSE.fullmatch(message)):
        return None
    n = [float(word) for word in words[4].split()]
    if len(n) not in (0, 4 * LANDMARKS[words[1] or "pose"]):
        return None
    # MediaPipe's y points down, Unity's up. That also makes its right-handed axes left-handed ones.
    landmarks = [(n[i], -n[i + 1], n[i + 2], n[i + 3]) for i in range(0, len(n), 4)]
    return BodyPose(int(words[2]), float(words[3]), landmarks)


class BodyListener:
    """The newest pose of one person or hand: how many were skipped for it, and how late it is."""

    def __init__(self, socket: zmq.Socket[bytes], endpoint: str, topic: str) -> None:
        """The socket is a new SUB socket, which the caller closes; the topic is pose/0/, say, or hand/left/."""
        self.listener = TopicListener(socket, endpoint, topic)
        self.number = self.skipped = 0
        self.ahead = self.behind = math.inf
        self.restarted = False

    def receive(self, timeout: float) -> BodyPose:
        """Wait for a pose; TimeoutError if none comes."""
        end = time.monotonic() + timeout
        while not (pose := parse(self.listener.newest(timeout))):
            # However much of something else comes.
            if time.monotonic() >= end:
                raise TimeoutError(f"no pose from {self.listener.endpoint} within {timeout:g} s; is that this server?")
        # Numbers begin anew with each start of the server, and seconds where it is another computer's.
        self.restarted = pose.number < self.number
        if self.restarted:
            self.ahead = math.inf
        elif self.number:
            self.skipped += max(0, pose.number - self.number - 1)
        self.number = pose.number
        # The two clocks need not agree: a pose is late if it took longer than the quickest one.
        travelled = time.monotonic() - pose.seconds
        self.ahead = min(self.ahead, travelled)
        self.behind = travelled - self.ahead
        return pose
