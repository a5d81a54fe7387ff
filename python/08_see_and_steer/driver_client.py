"""Lesson 08, the driver's client: sends one picture at a time and gets its action, without waiting longer than it may.

    client.send(frame)                   a message of kind `frame`, whose id is the picture's number
    action = client.receive(0.02)        as long as `client.asked` is there, its action may still come

A picture without an action is not sent again: by then there is a newer one. Each failure costs the socket, because REQ
can only receive after it has sent, and a new one finds a server that is back again.
Take home: this file, drive.py, world.py and messages.py of lesson 05.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path

import zmq
from drive import Action, read_action

# messages.py is lesson 05's. At home it lies beside this file.
sys.path.append(str(Path(__file__).parent / "../05_messages"))
from messages import LIMIT, Message, MessageError, read


class GaveUp(Exception):
    """So many pictures in a row have no action that it makes no sense to go on."""


class DriverClient:
    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        endpoint: str,
        patience: float,
        tries: int,
        log: Callable[[str], object],
    ) -> None:
        self.context, self.endpoint, self.patience, self.tries, self.log = context, endpoint, patience, tries, log
        self.asked: Message | None = None
        self._socket: zmq.Socket[bytes] | None = None
        self._began, self._lost = 0.0, 0

    def send(self, frame: Message) -> None:
        self.asked, self._began = frame, time.monotonic()
        if self._socket is None:
            self._socket = self.context.socket(zmq.REQ)
            # Above the limit of messages.py a reply is refused by name. Above this one libzmq takes no more of it.
            self._socket.linger, self._socket.maxmsgsize = 0, 4 * LIMIT
            self._socket.connect(self.endpoint)
        try:
            self._socket.send_multipart(frame.frames(), zmq.NOBLOCK, copy=False)
        except zmq.Again:
            # The connection has just ended. Nothing will come, and `receive` says so.
            self._began -= self.patience

    def receive(self, wait: float) -> Action | None:
        """The action, if it comes within so many seconds. None, and nothing asked any more: there is none."""
        if self.asked is None or self._socket is None:
            return None
        left = self._began + self.patience - time.monotonic()
        try:
            if not self._socket.poll(int(1000 * max(0, min(wait, left)))):
                if left > wait:
                    return None
                raise MessageError(
                    "", f"no reply from {self.endpoint} within {self.patience:g} s; is the server running?"
                )
            reply = read(self._socket.recv_multipart(copy=False))
            if reply.kind == "error":
                code, text = (str(reply.values.get(name, "not said")) for name in ("code", "text"))
                raise MessageError(code, text)
            action = read_action(reply, self.asked.id)
        except MessageError as error:
            self._fail(str(error).removeprefix(": "))
            return None
        action.milliseconds = (time.monotonic() - self._began) * 1000
        self.asked, self._lost = None, 0
        return action

    def wait(self) -> Action | None:
        """The same, however long it takes; in slices, because on Windows Ctrl-C does not interrupt a longer wait."""
        while (action := self.receive(0.2)) is None and self.asked:
            pass
        return action

    def _fail(self, why: str) -> None:
        self.close()
        self._lost += 1
        if self._lost >= self.tries:
            raise GaveUp(why)
        self.log(f"trouble: {why}")

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
        self.asked = self._socket = None
