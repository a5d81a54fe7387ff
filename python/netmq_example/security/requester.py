"""Lesson 15, the client's side: a requester with keys, that says so when it is refused. In C#: SecureRequester.cs.

    keys = ClientKeys(Path("keys"))                                     server.key, and this client's own pair
    requester = SecureRequester(context, endpoint, keys, 1.0, 3, print)
    requester.request("Hello")                                          the reply, or TimeoutError

A refused client is told nothing: it is connected, and cut off in the handshake. So that is what it says. libzmq never
tries again on a socket that was refused, so each try has a new one: whoever is enrolled meanwhile comes in.
Bytes: UTF-8 text, one frame each way.
"""

import contextlib
import time
from collections.abc import Callable
from pathlib import Path

import zmq

from netmq_example.security.keys import checked, load, make

LARGEST = 65_536
# Seconds between two tries, where the first was over at once.
PAUSE = 0.25
THROWN_OUT = "connected and thrown out"


class ClientKeys:
    """Made at the first start: a secret key that came with a program would be everybody's."""

    def __init__(self, folder: Path, server_key: str = "") -> None:
        self.server = checked(server_key.encode()) if server_key else load(folder / "server.key")[0]
        if not (folder / "client.key_secret").exists():
            make(folder, "client")
        self.public, self.secret = load(folder / "client.key_secret")

    def apply(self, socket: zmq.Socket[bytes]) -> None:
        """Before connect."""
        socket.curve_serverkey, socket.curve_publickey, socket.curve_secretkey = self.server, self.public, self.secret


class SecureRequester:
    """Asks a server that knows its clients."""

    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        endpoint: str,
        keys: ClientKeys | None,
        timeout: float,
        tries: int,
        report: Callable[[str], object],
    ) -> None:
        """Without keys it speaks plain, which such a server refuses too."""
        self.context, self.endpoint, self.keys, self.report = context, endpoint, keys, report
        self.timeout, self.tries = timeout, tries
        self.socket: zmq.Socket[bytes] | None = None
        self.number = 0

    def request(self, text: str) -> str:
        """The reply; TimeoutError, which says why, when no try was answered."""
        self.number += 1
        for attempt in range(1, self.tries + 1):
            reply, trouble = self._try(text)
            if reply is not None:
                return reply
            # A REQ socket that waits for a reply refuses to send, and one that was refused is dead.
            self.close()
            if attempt < self.tries:
                self.report(f"{self.number}: {trouble}; try {attempt + 1} of {self.tries}")
        cure = self._advice() if trouble == THROWN_OUT else "is the server running?"
        raise TimeoutError(f"{self.tries} tries to ask {self.endpoint}, the last: {trouble}; {cure}")

    def close(self) -> None:
        if self.socket:
            self.socket.disable_monitor()
            self.monitor.close()
            self.socket.close()
        self.socket = None

    def _try(self, text: str) -> tuple[str | None, str]:
        """One try: the reply, or what came in its place."""
        socket = self.socket = self.socket or self._open()
        end = time.monotonic() + self.timeout
        with contextlib.suppress(zmq.Again):
            socket.send_string(text, zmq.NOBLOCK)
        while (left := end - time.monotonic()) > 0:
            if socket.poll(min(10, int(left * 1000) + 1)):
                return socket.recv().decode(errors="replace"), ""
            if self.monitor.poll(0):
                # Most often it is refused again; and if the server was started anew, it is there a moment later.
                time.sleep(PAUSE)
                return None, THROWN_OUT
        return None, f"no reply within {self.timeout:g} s"

    def _open(self) -> zmq.Socket[bytes]:
        socket = self.context.socket(zmq.REQ)
        socket.linger, socket.maxmsgsize = 0, LARGEST
        if self.keys:
            self.keys.apply(socket)
        self.monitor = socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        socket.connect(self.endpoint)
        return socket

    def _advice(self) -> str:
        if not self.keys:
            return "a server with keys refuses who has none"
        key = self.keys.public.decode()
        return f"is this client on its list, is server.key its key, and has it keys at all? This client's is {key}"
