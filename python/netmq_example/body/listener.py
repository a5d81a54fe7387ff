"""The newest pose of a person or hand: how many were skipped for it, and how late it is.

    with BodyListener("tcp://127.0.0.1:5570", "pose/0/") as listener:
        pose = listener.receive(timeout=5)                  a BodyPose, or Timeout
        print(pose.landmarks[26], listener.skipped, listener.behind)

Landmarks are numbered as MediaPipe does, and in metres in Unity's axes: y points up, z away from the viewer.
The bytes are in python/20_body_tracking/server.py. In C# it is BodyListener.cs, and BodyPose.cs.
"""

import math
import re
import time
from typing import NamedTuple

from netmq_example import arguments, check
from netmq_example.errors import Timeout
from netmq_example.former import positional
from netmq_example.one_process import OneProcess
from netmq_example.program import Context, Socket
from netmq_example.topic_listener import TopicListener

LANDMARKS = {"pose": 33, "hand": 21}
TOPIC = r"(?:pose/[0-9]+|(hand)/(?:left|right))/"
# Plain numbers, as C# reads them: float() also takes 1_0, nan and the digits of every script.
NUMBER = r" (-?[0-9]{1,9}(?:\.[0-9]{1,9})?)"
POSE = re.compile(rf"{TOPIC} ([0-9]{{1,18}}) ([0-9]{{1,9}}\.[0-9]{{1,9}})((?:{NUMBER})*)")


class BodyPose(NamedTuple):
    """A body's 33 landmarks or a hand's 21, each x, y, z and visibility; none when nobody is there."""

    number: int
    seconds: float
    landmarks: list[tuple[float, float, float, float]]

    def angle(self, a: int, b: int, c: int) -> float:
        """How far the limb is bent open at landmark b, in degrees; 180 is straight."""
        first, middle, last = self.place("a", a), self.place("b", b), self.place("c", c)
        one = [first[i] - middle[i] for i in range(3)]
        other = [last[i] - middle[i] for i in range(3)]
        lengths = math.sqrt(dot(one, one)) * math.sqrt(dot(other, other))
        return math.acos(max(-1, min(1, dot(one, other) / lengths))) * 180 / math.pi if lengths else 0.0

    def place(self, name: str, landmark: int) -> tuple[float, float, float]:
        if not self.landmarks:
            raise ValueError(f"{name} takes a landmark of somebody, but nobody is there")
        x, y, z, _ = self.landmarks[check.count(name, landmark, least=0, most=len(self.landmarks) - 1)]
        return x, y, z


def dot(one: list[float], other: list[float]) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def parse(message: str) -> BodyPose | None:
    """None for what is no pose: anybody can publish on a port."""
    words = POSE.fullmatch(check.instance("message", message, str))
    if not words:
        return None
    n = [float(word) for word in words[4].split()]
    if len(n) not in (0, 4 * LANDMARKS[words[1] or "pose"]):
        return None
    # MediaPipe's y points down, Unity's up. That also makes its right-handed axes left-handed ones.
    landmarks = [(n[i], -n[i + 1], n[i + 2], n[i + 3]) for i in range(0, len(n), 4)]
    return BodyPose(int(words[2]), float(words[3]), landmarks)


class BodyListener(OneProcess):
    """Listens to one person or hand. Use it on one thread."""

    @positional("socket", "endpoint", "topic")
    def __init__(
        self,
        endpoint: str,
        topic: str,
        *,
        timeout: float = 5.0,
        socket: Socket | None = None,
        context: Context | None = None,
    ) -> None:
        """The topic is pose/0/, say, or hand/left/. It waits `timeout` seconds for a pose.

        A SUB socket with options of your own goes in as `socket`, and is closed by you.
        """
        self.endpoint = check.endpoint(endpoint, "tcp://127.0.0.1:5570", beacon=True)
        if not re.fullmatch(TOPIC, arguments.text("topic", topic)):
            raise ValueError(f"topic takes pose/0/, hand/left/ or hand/right/, not {topic!r:.40}")
        self.timeout = check.seconds("timeout", timeout)
        self.listener = TopicListener(endpoint, topic, socket=socket, context=context)
        # The newest pose's, and how many were passed over for newer ones.
        self.number = 0
        self.skipped = 0
        # Whether the server was started again before the newest pose, and how many seconds that pose is late.
        self.restarted = False
        self.behind = math.inf
        # How much this clock is ahead of the server's, with the time of the quickest pose on its way.
        self.ahead = math.inf

    def receive(self, timeout: float | None = None) -> BodyPose:
        """The next pose. Timeout if none comes within so many seconds, or the listener's own."""
        timeout = self.timeout if timeout is None else check.seconds("timeout", timeout)
        end = time.monotonic() + timeout
        while not (pose := parse(self.listener.newest(timeout))):
            # However much of something else comes.
            if time.monotonic() >= end:
                raise Timeout(f"no pose from {self.listener.endpoint} within {timeout:g} s; is that this server?")
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

    def close(self) -> None:
        """Close the socket, unless it was given. Twice is once."""
        self.listener.close()
