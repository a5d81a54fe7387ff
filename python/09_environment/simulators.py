"""Lesson 09, the simulators: where they come from, by hand or launched, and that none is left behind.
"""

import os
import re
import subprocess
from collections.abc import Callable, Sequence
from typing import Any

import launched
import zmq
from connection import Connection, Lost
from launched import game
from messages import LIMIT, Message, MessageError

ENDPOINT, FREE = "tcp://127.0.0.1:5559", "tcp://127.0.0.1:*"


def bound(endpoint: str) -> zmq.Socket[bytes]:
    # libzmq itself would listen on port 99999 - 65536 without a word.
    port = re.fullmatch(r"tcp://[\w.*-]+:(\*|\d{1,5})", endpoint, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise ValueError(f"bad endpoint '{endpoint}': write it like {ENDPOINT}, port 0 to 65535")
    context = zmq.Context()
    socket = context.socket(zmq.ROUTER)
    # Who announces more than the largest message is disconnected before it is in memory. One answer is under way; what
    # others send while nobody listens must not fill the memory.
    socket.maxmsgsize, socket.rcvhwm = 4 * LIMIT, 10
    # At its end so many milliseconds for what it has said last, such as why it refused a simulator.
    socket.linger, socket.rcvtimeo = 500, 200
    try:
        socket.bind(endpoint)
    except zmq.ZMQError as error:
        context.destroy()
        cure = f"if another trainer has it, give this one its own endpoint, such as {FREE}"
        raise OSError(f"cannot listen on {endpoint}: {zmq.strerror(error.errno or 0)}; {cure}") from None
    return socket


class Simulators:
    """`launch` is a path as `game` takes it, or a list: a program and its first words; `--endpoint` follows. Without it
    one waits for Play.

    `wait` is how many seconds for a simulator, `timeout` how many for each answer. A socket that is given is not
    closed.
    """

    def __init__(
        self,
        endpoint: str = "",
        launch: str | os.PathLike[str] | Sequence[str] | None = (),
        wait: float = 60,
        timeout: float = 10,
        socket: zmq.Socket[bytes] | None = None,
        default: str = ENDPOINT,
    ) -> None:
        for name, seconds in ("wait", wait), ("timeout", timeout):
            if not isinstance(seconds, int | float) or not 0 < seconds <= 86400:
                raise ValueError(f"{name} takes seconds, more than 0 and at most a day, not {seconds!r:.40}")
        words = [launch] if isinstance(launch, str | os.PathLike) else list(launch or ())
        self.launch = [game(os.fspath(words[0])), *words[1:]] if launch else []
        self.limit, self.own, self.pid = wait, socket is None, os.getpid()
        # Each one that launches has a port of its own: several environments at once are no trouble.
        self.connection = Connection(socket or bound(endpoint or (FREE if launch else default)), timeout)
        self.process: subprocess.Popen[bytes] | None = None

    def find(self, accept: Callable[[Message], None]) -> None:
        """Wait for a simulator that `accept` likes."""
        endpoint = self.connection.endpoint
        if not self.launch:
            print(f"waiting for a simulator on {endpoint}: press Play", flush=True)
        else:
            # One that was lost may still be there, and hang.
            self.end()
            self.process = launched.start([*self.launch, "--endpoint", endpoint])
        self.connection.wait(self.limit, accept, lambda: self.process.poll() if self.process else None)

    def begin(self, accept: Callable[[Message], None], ask: Callable[[Lost | None], Any]) -> Any:
        """What `ask` for a reset returns, in another simulator if one is lost; it is told what was lost before.

        The next one may be lost as well: lesson 17's hub is started anew just then. Or each one ends of a reset, so
        that after three it is over.
        """
        lost = None
        for _ in range(2):
            try:
                return ask(lost)
            except Lost as why:
                lost = why
                self.find(accept)
        return ask(lost)

    def end(self) -> None:
        if process := self.process:
            self.process = None
            launched.end(process)

    def close(self) -> None:
        if self.connection.closed or os.getpid() != self.pid:
            # A process that was forked has a copy of this, and the simulator is not its own.
            return
        self.connection.timeout = min(2, self.connection.timeout)
        try:
            # It answers: a connection that ends right after a message may take the message with it.
            self.connection.ask("close", {}, [])
        except (Lost, MessageError):
            pass
        finally:
            self.connection.closed = True
            self.end()
            if self.own:
                self.connection.socket.context.destroy()
