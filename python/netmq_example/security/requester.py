"""A requester with keys, which reports that it is refused. In C# it is SecureRequester.cs.

    keys = ClientKeys(Path("keys"))                                     server.key, and this client's own pair
    with SecureRequester("tcp://127.0.0.1:5565", keys=keys) as requester:
        print(requester.request("Hello"))                               the reply, or Timeout

A refused client is told nothing: it is connected, and cut off in the handshake. So that is what is reported. libzmq
never tries again on a socket that was refused, so each try has a new one: a client that is enrolled meanwhile comes in.
Bytes: UTF-8 text, one frame each way.
"""

import os
import time
from pathlib import Path
from typing import Any

import zmq

from netmq_example import arguments, check
from netmq_example.errors import Timeout
from netmq_example.former import positional
from netmq_example.one_process import one_at_a_time
from netmq_example.program import Context, Socket, encoded, option, text_of
from netmq_example.requester import PAUSE_SECONDS, Client
from netmq_example.security.keys import checked, load, make
from netmq_example.trouble import longer, tried

THROWN_OUT = "connected and thrown out"


class ClientKeys:
    """A client's pair, made at the first start: a secret key that came with a program would be everybody's."""

    def __init__(self, folder: Path | str, server_key: str = "") -> None:
        """From this folder; `server_key` takes the place of server.key. ValueError says what is missing."""
        folder = arguments.path("folder", folder)
        if server_key:
            self.server = checked(arguments.text("server_key", server_key).encode())
        else:
            self.server = load(folder / "server.key")[0]
        if not os.path.exists(folder / "client.key_secret"):
            make(folder, "client")
        self.public, self.secret = load(folder / "client.key_secret")

    def apply(self, socket: Any) -> None:
        """Before connect. If it gets a context, all later sockets of that have the keys."""
        check.instance("socket", socket, zmq.Socket, zmq.Context)
        socket.curve_serverkey = self.server
        socket.curve_publickey = self.public
        socket.curve_secretkey = self.secret


def client_keys(text: str) -> ClientKeys:
    return option(lambda _, folder: ClientKeys(folder), text, str)


class SecureRequester(Client):
    """Asks a server that knows its clients: on any thread, but on one at a time."""

    @positional("context", "endpoint", "keys", "timeout", "tries", "report")
    def __init__(
        self,
        endpoint: str,
        *,
        keys: ClientKeys | None = None,
        timeout: float = 1.0,
        tries: int = 3,
        context: Context | None = None,
    ) -> None:
        """The first of at most `tries` tries has `timeout` seconds, and each one after it twice as long, up to 8 times.

        Each retry is logged as a warning. Without keys it speaks plain, which such a server refuses too.
        """
        check.instance("keys", keys, ClientKeys, type(None))
        super().__init__(endpoint, "tcp://127.0.0.1:5565", timeout, tries, keys, context)
        self.number = 0

    @one_at_a_time
    def request(self, text: str) -> str:
        """The reply; Timeout, which says why, when no try was answered. ValueError: it is too long."""
        check.instance("text", text, str)
        self.number += 1
        request = encoded(text)
        for attempt in range(1, self.tries + 1):
            reply, trouble = self._try(request, longer(self.timeout, attempt - 1))
            if reply is not None:
                return reply
            # A REQ socket that waits for a reply refuses to send, and one that was refused is dead.
            self.close_socket()
            if attempt < self.tries:
                self.report(f"{self.number}: {trouble}; try {attempt + 1} of {self.tries}")
        if trouble == THROWN_OUT:
            cure = self._advice()
        else:
            cure = self.search.cure("is the server running, or its reply over 64 KB?")
        raise Timeout(f"{tried(self.tries)} to ask {self.endpoint}, the last: {trouble}; {cure}")

    def close_socket(self) -> None:
        if self.socket:
            self.socket.disable_monitor()
            self.monitor.close()
        super().close_socket()

    def _try(self, request: bytes, timeout: float) -> tuple[str | None, str]:
        """One try: the reply, or what came in its place."""
        if not self.socket:
            where = self.search.find(timeout)
            if not where:
                return None, f"nobody answers to this name within {timeout:g} s"
            self.socket = self._open(where)
        end = time.monotonic() + timeout
        try:
            self.socket.send(request, zmq.NOBLOCK)
        except zmq.Again:
            # There is no connection to send on. The monitor may say why.
            pass
        while time.monotonic() < end:
            left_ms = int((end - time.monotonic()) * 1000) + 1
            if self.socket.poll(min(10, left_ms)):
                return " ".join(map(text_of, self.socket.recv_multipart())), ""
            if self.monitor.poll(0):
                # Most often it is refused again; and if the server was started anew, it is there a moment later.
                time.sleep(PAUSE_SECONDS)
                return None, THROWN_OUT
        return None, f"no reply within {timeout:g} s"

    def _open(self, where: str) -> Socket:
        socket = self.prepared(zmq.REQ)
        self.monitor = socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        socket.connect(where)
        return socket

    def _advice(self) -> str:
        if not isinstance(self.keys, ClientKeys):
            return "a server with keys refuses who has none"
        key = self.keys.public.decode()
        return f"is this client on its list, is server.key its key, and has it keys at all? This client's is {key}"
