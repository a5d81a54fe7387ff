"""Sends a driver one picture at a time and gets an action for it, without waiting longer than it may.

    with DriverClient("tcp://127.0.0.1:5558") as client:
        client.send(frame)                    a message of kind `frame`, whose id is the picture's number
        action = client.receive(until)        None: not yet, as long as `client.asked` is there; else there is none

A picture without an action is not sent again: by then there is a newer one. Each failure costs the socket, because REQ
can only receive after it has sent, and a new one finds a server that is back again. After `tries` pictures in a row
without an action it raises what the last one met.

Bytes: messages of messages.py. pictures.py says what a `frame` has; the reply is of kind `action`, with the values
`frame`, `throttle`, `brake`, `steer` and those of your own. The C# side is DriverClient.cs.
"""

import math
import time
from dataclasses import dataclass, field
from typing import Any

import zmq

from netmq_example import arguments, check
from netmq_example.console import printable
from netmq_example.errors import MessageError, Refused, Timeout
from netmq_example.former import positional
from netmq_example.messages import EXACT, LIMIT, Message
from netmq_example.program import SLICE_MS, Context, Socket
from netmq_example.requester import Client
from netmq_example.trouble import longer


@dataclass
class Action:
    """An action, the picture that it answers, and the time it took. Each number is put back into its range.

    `values` has what Python returned beside the three: numbers, texts, true or false.
    """

    frame: int
    throttle: float
    brake: float
    steer: float
    milliseconds: float = 0.0
    values: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.frame = check.count("frame", self.frame, least=0, most=EXACT - 1)
        self.milliseconds = arguments.number("milliseconds", self.milliseconds, least=0)
        self.throttle = min(1.0, max(-1.0, arguments.number("throttle", self.throttle)))
        self.brake = min(1.0, max(0.0, arguments.number("brake", self.brake)))
        self.steer = min(1.0, max(-1.0, arguments.number("steer", self.steer)))


def read_action(reply: Message, frame: int) -> Action:
    """The action in a reply; MessageError says why it is none for this picture."""
    values = reply.values
    for name in ("frame", "throttle", "brake", "steer"):
        if reply.kind != "action" or type(values.get(name)) not in (int, float):
            raise MessageError("no-action", f"the reply is no action, or without a number '{name}'")
    if values["frame"] != frame:
        raise MessageError("wrong-frame", f"an action for picture {values['frame']}, but {frame} was asked about")
    return Action(frame, values["throttle"], values["brake"], values["steer"], values=values)


class DriverClient(Client):
    """Asks about one picture at a time. Use it on one thread."""

    # Above LIMIT a reply is refused by name. Above four times as much libzmq takes no more of it and hangs up.
    largest = 4 * LIMIT

    @positional("context", "endpoint", "timeout", "tries", "report")
    def __init__(self, endpoint: str, *, timeout: float = 1.0, tries: int = 5, context: Context | None = None) -> None:
        """It waits `timeout` seconds for an action, and after each that did not come twice as long, up to 8 times.

        Of `tries` pictures in a row one must get its action. Each that has none is logged as a warning.
        """
        super().__init__(endpoint, "tcp://127.0.0.1:5558", timeout, tries, context=context)
        # The message that waits until the server is found, and where that is.
        self.unsent: list[Any] = []
        self.where = ""
        self.asked: Message | None = None
        self.began = 0.0
        self.lost = 0

    @property
    def wait_seconds(self) -> float:
        """How many seconds the action may take that is asked for now."""
        return longer(self.timeout, self.lost)

    def send(self, frame: Message) -> None:
        """Ask about a picture."""
        self.check_process()
        if self.asked:
            raise ValueError(f"picture {self.asked.id} is asked about; receive its action first")
        frames = check.instance("frame", frame, Message).frames()
        self.asked = frame
        self.began = time.monotonic()
        if self.socket is None:
            self.socket = self.prepared(zmq.REQ)
            # Sending does not wait: libzmq would take for sent what it has lost with a broken connection.
            self.socket.sndtimeo = 0
            self.where = ""
        self.unsent = frames
        self.flush(self.socket, 0)

    def flush(self, socket: Socket, wait: float) -> None:
        if not self.where:
            self.where = self.search.find(wait)
            if not self.where:
                return
            socket.connect(self.where)
        try:
            socket.send_multipart(self.unsent)
        except zmq.Again:
            # Nothing will come, and `receive` says so.
            self.began -= self.wait_seconds
        self.unsent = []

    def receive(self, until: float = math.inf) -> Action | None:
        """The action, if it comes before that time of time.monotonic(), and within the timeout.

        None while something is asked: not yet. None and nothing is asked any more: there is none. After `tries` of
        them it raises Timeout, Refused or MessageError, which says why.
        """
        if not (until == math.inf or check.is_number(until)):
            raise ValueError(f"until takes a time of time.monotonic(), not {until!r:.40}")
        if not self.asked or not self.socket:
            raise ValueError("no picture is asked about; send one first")
        last = self.began + self.wait_seconds
        try:
            frames = self.wait(self.socket, min(until, last))
            if not frames and time.monotonic() < last:
                return None
            if not frames:
                within = f"within {self.wait_seconds:g} s"
                cure = self.search.cure("is the server running?")
                raise Timeout(f"no reply from {self.endpoint} {within}; {cure}")
            action = read_action(Message.read_reply(frames), self.asked.id)
        except (Timeout, Refused, MessageError) as error:
            self.fail(error)
            return None
        action.milliseconds = (time.monotonic() - self.began) * 1000
        self.asked = None
        self.lost = 0
        return action

    def wait(self, socket: Socket, until: float) -> list[zmq.Frame]:
        """The frames of what came before that time, or none. In slices: on Windows Ctrl-C ends no longer wait."""
        while True:
            left = max(0.0, until - time.monotonic())
            if self.unsent:
                self.flush(socket, min(SLICE_MS / 1000, left))
            elif socket.poll(min(SLICE_MS, math.ceil(left * 1000))):
                return socket.recv_multipart(zmq.NOBLOCK, copy=False)
            if not left:
                return []

    def fail(self, error: Exception) -> None:
        self.close()
        self.lost += 1
        if self.lost >= self.tries:
            raise error
        self.report(f"trouble: {printable(str(error))}")

    def close(self) -> None:
        """Give up what is asked. It may be used again, and twice is once."""
        self.close_socket()
        self.asked = None
