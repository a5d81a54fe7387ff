"""A requester with keys, which reports that it is refused. In C# it is SecureRequester.cs.

    keys = ClientKeys(Path("keys"))                                     server.key, and this client's own pair
    with SecureRequester("tcp://127.0.0.1:5565", keys=keys) as requester:
        print(requester.request("Hello"))                               the reply, or Timeout

A refused client is told nothing: it is connected, and cut off in the handshake. So that is what is reported. libzmq
never tries again on a socket that was refused, so each try has a new one: a client that is enrolled meanwhile comes in.
Bytes: UTF-8 text, one frame each way.
"""

import os
from pathlib import Path
from typing import Any

import zmq

from netmq_example import arguments, check
from netmq_example.former import positional
from netmq_example.one_process import one_at_a_time
from netmq_example.program import Context, Socket, encoded, option, text_of
from netmq_example.requester import Requester
from netmq_example.security.keys import checked, load, make


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


class SecureRequester(Requester):
    """Asks a server that knows its clients: on any thread, but on one at a time."""

    # Whether the last try was connected, and cut off.
    thrown_out = False

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
        self.number += 1
        return " ".join(map(text_of, self.ask([encoded(text)], self.number, "64 KB")))

    def trouble(self, timeout: float) -> str:
        return "connected and thrown out" if self.thrown_out else super().trouble(timeout)

    def cure(self, question: str) -> str:
        if not self.thrown_out:
            return super().cure(question)
        if not isinstance(self.keys, ClientKeys):
            return "a server with keys refuses who has none"
        key = self.keys.public.decode()
        return f"is this client on its list, is server.key its key, and has it keys at all? This client's is {key}"

    def prepared(self, kind: int) -> Socket:
        socket = super().prepared(kind)
        self.monitor = socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        return socket

    def is_dead(self) -> bool:
        return bool(self.monitor.poll(0))

    def close_socket(self) -> None:
        self.thrown_out = False
        if self.socket:
            self.thrown_out = self.is_dead()
            self.socket.disable_monitor()
            self.monitor.close()
        super().close_socket()
