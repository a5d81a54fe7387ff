"""Lesson 09, the simulators: where they come from, by hand or launched, and that none is left behind.

Take home: this file and connection.py, with messages.py of lesson 05.
"""

import glob
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence

import zmq
from connection import Connection, Lost
from messages import LIMIT, Message, MessageError

ENDPOINT, FREE = "tcp://127.0.0.1:5559", "tcp://127.0.0.1:*"


def bound(endpoint: str) -> zmq.Socket[bytes]:
    context = zmq.Context()
    socket = context.socket(zmq.ROUTER)
    # Who announces more than the largest message is disconnected before it is in memory.
    socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, 4 * LIMIT, 200
    try:
        socket.bind(endpoint)
    except zmq.ZMQError as error:
        context.destroy()
        cure = "if another trainer has it, give this one its own, such as endpoint='tcp://127.0.0.1:*'"
        raise OSError(f"cannot listen on {endpoint}: {zmq.strerror(error.errno or 0)}; {cure}") from None
    return socket


def game(path: str) -> str:
    """The program that is meant by a build's path: each system has an ending, or a folder, of its own for it."""
    ending = {"win32": ".exe", "darwin": ".app/Contents/MacOS/*"}.get(sys.platform, ".x86_64")
    for way in (glob.escape(path), glob.escape(path) + ending):
        for found in filter(os.path.isfile, sorted(glob.glob(way))):
            # What was unpacked from an archive may have forgotten that it is a program.
            if not os.access(found, os.X_OK):
                os.chmod(found, 0o755)
            return os.path.abspath(found)
    if program := shutil.which(path):
        return program
    raise FileNotFoundError(f"no game at {path}: there is neither this file nor {path}{ending}")


class Simulators:
    """`launch` is a path as `game` takes it, or a program with its first words; `--endpoint` follows. Without it one
    waits for Play.

    `wait` is how many seconds for a simulator, `patience` how many for each answer. A socket that is given is not
    closed.
    """

    def __init__(
        self,
        endpoint: str = "",
        launch: str | Sequence[str] = (),
        wait: float = 60,
        patience: float = 10,
        socket: zmq.Socket[bytes] | None = None,
        default: str = ENDPOINT,
    ) -> None:
        self.launch = [game(launch)] if launch and isinstance(launch, str) else list(launch)
        self.limit, self.own = wait, socket is None
        # Each one that launches has a port of its own: several environments at once are no trouble.
        self.connection = Connection(socket or bound(endpoint or (FREE if launch else default)), patience)
        self.process: subprocess.Popen[bytes] | None = None

    def find(self, accept: Callable[[Message], None]) -> None:
        """Wait for a simulator that `accept` likes."""
        endpoint = self.connection.endpoint
        if not self.launch:
            print(f"waiting for a simulator on {endpoint}: press Play", flush=True)
        else:
            # One that was lost may still be there, and hang.
            self.end()
            self.process = subprocess.Popen([*self.launch, "--endpoint", endpoint])
        self.connection.wait(self.limit, accept, lambda: self.process is None or self.process.poll() is None)

    def end(self) -> None:
        """Let the one that was launched end by itself for a moment, then end it."""
        if self.process:
            try:
                self.process.wait(2)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()

    def close(self) -> None:
        self.connection.patience = min(2, self.connection.patience)
        try:
            # It answers: a connection that ends right after a message may take the message with it.
            self.connection.ask("close", {}, [])
        except (Lost, MessageError):
            pass
        if self.own:
            self.connection.socket.context.destroy()
        self.end()
