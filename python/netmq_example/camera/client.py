"""Lesson 08, the driver's client: sends one picture at a time and gets its action, without waiting longer than it may.

    client.send(frame)                   a message of kind `frame`, whose id is the picture's number
    action = client.receive(until)       as long as `client.asked` is there, its action may still come

A picture without an action is not sent again: by then there is a newer one. Each failure costs the socket, because REQ
can only receive after it has sent, and a new one finds a server that is back again.

Lesson 08, an action: what to do, and about which picture.

Bytes: a reply of kind `action`, with the values `frame`, `throttle`, `brake` and `steer`. The C# side is
DriverClient.cs.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import zmq

from netmq_example.messages import LIMIT, Message, MessageError, read


@dataclass
class Action:
    """What to do, about which picture, and how long it took to be told. What is out of range is put back into it."""

    frame: int
    throttle: float
    brake: float
    steer: float
    milliseconds: float = 0.0

    def __post_init__(self) -> None:
        self.throttle, self.brake = min(1.0, max(0.0, self.throttle)), min(1.0, max(0.0, self.brake))
        self.steer = min(1.0, max(-1.0, self.steer))


def read_action(reply: Message, frame: int) -> Action:
    """The action in a reply; MessageError says why it is none for this picture."""
    for name in ("frame", "throttle", "brake", "steer"):
        if reply.kind != "action" or type(reply.values.get(name)) not in (int, float):
            raise MessageError("no-action", f"the reply is no action, or without a number '{name}'")
    values = reply.values
    if values["frame"] != frame:
        raise MessageError("wrong-frame", f"an action for picture {values['frame']}, but {frame} was asked about")
    return Action(frame, values["throttle"], values["brake"], values["steer"])


class GaveUp(Exception):
    """So many pictures in a row have no action that it makes no sense to go on."""


class DriverClient:
    """One picture at a time. `log` gets a line about each that has no action."""

    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        endpoint: str,
        timeout: float,
        tries: int,
        log: Callable[[str], object],
    ) -> None:
        self.context, self.endpoint, self.timeout, self.tries, self.log = context, endpoint, timeout, tries, log
        self.asked: Message | None = None
        self.socket: zmq.Socket[bytes] | None = None
        self.began, self.lost = 0.0, 0

    def send(self, frame: Message) -> None:
        """Ask about a picture."""
        self.asked, self.began = frame, time.monotonic()
        if self.socket is None:
            self.socket = self.context.socket(zmq.REQ)
            # Above the limit of messages.py a reply is refused by name. Above this one libzmq takes no more of it.
            # Sending does not wait: libzmq would say of a request whose connection ends just then that it is sent.
            self.socket.linger, self.socket.maxmsgsize, self.socket.sndtimeo = 0, 4 * LIMIT, 0
            self.socket.connect(self.endpoint)
        try:
            self.socket.send_multipart(frame.frames())
        except zmq.Again:
            # Nothing will come, and `receive` says so.
            self.began -= self.timeout

    def receive(self, until: float, patient: bool = False) -> Action | None:
        """The action, if it comes before that time; or, `patient`, in the time that it may take at all.

        None while something is asked: not yet. None and nothing is asked any more: there is none.
        """
        last = self.began + self.timeout
        try:
            while not self.arrived(last if patient else min(until, last)):
                if time.monotonic() >= last:
                    raise TimeoutError(
                        f"no reply from {self.endpoint} within {self.timeout:g} s; is the server running?"
                    )
                if not patient:
                    return None
            return self.read()
        except (TimeoutError, MessageError) as error:
            self.fail(printable(str(error)))
            return None

    def arrived(self, until: float) -> bool:
        # In slices: on Windows Ctrl-C does not interrupt a longer wait.
        wait = min(0.2, max(0.0, until - time.monotonic()))
        return self.socket is not None and bool(self.socket.poll(math.ceil(wait * 1000)))

    def read(self) -> Action:
        assert self.socket and self.asked
        reply = read(self.socket.recv_multipart(zmq.NOBLOCK, copy=False))
        if reply.kind == "error":
            code, text = (str(reply.values.get(name, "not said")) for name in ("code", "text"))
            raise MessageError(code, text)
        action = read_action(reply, self.asked.id)
        action.milliseconds = (time.monotonic() - self.began) * 1000
        self.asked, self.lost = None, 0
        return action

    def fail(self, why: str) -> None:
        self.close()
        self.lost += 1
        if self.lost >= self.tries:
            raise GaveUp(why)
        self.log(f"trouble: {why}")

    def close(self) -> None:
        if self.socket:
            self.socket.close()
        self.asked = self.socket = None


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")
