"""Lesson 15, a gate: a server without keys stays on its machine, and clients with a key reach it from outside.

    python python/04_background_client/server.py
    python python/15_security/gate.py --to tcp://127.0.0.1:5554 --endpoint tcp://0.0.0.0:5565 --keys keys
    dotnet run --project csharp-console -- 4 --endpoint tcp://127.0.0.1:5565 --with-keys keys

The server behind it is not changed and knows nothing of keys. Each client has a connection of its own there, and each
message is looked at: a client that was revoked is not passed on any more, and gets no answer.
Bytes: those of the server behind it. A PUB socket, as in lesson 03, takes its keys itself: AllowList.guard.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.asking import client_endpoint
from netmq_example.program import Context, Socket, limit, listening, more_files, run, server_options, show
from netmq_example.security.allow_list import AllowList, keys_for
from netmq_example.trouble import Trouble

# Pictures pass as well.
LARGEST_BYTES = 64 << 20
# With more clients than that, the one that was silent longest is disconnected from the server. There are fewer where a
# program may not have so many files open: a client takes three, and two of them stay when it has gone.
MOST_CLIENTS = 500
FILES_OF_A_CLIENT = 4


class Gate:
    """Between `door`, the ROUTER socket to which clients come, and a connection to the server for each of them."""

    def __init__(self, context: Context, door: Socket, server: str, allowed: AllowList) -> None:
        self.context, self.door, self.server, self.allowed = context, door, server, allowed
        # By each client's address its connection, and the key that it has shown: an address may change hands.
        self.inside: dict[bytes, tuple[Socket, str]] = {}
        self.most = min(MOST_CLIENTS, more_files() // FILES_OF_A_CLIENT)
        self.trouble = Trouble(show)
        self.poller = zmq.Poller()
        self.poller.register(door, zmq.POLLIN)

    def pass_on(self) -> None:
        """In and out, for ever. A full connection drops messages, as ROUTER does: no client may hold up the others."""
        while True:
            ready = dict(self.poller.poll(200))
            for client, (socket, key) in list(self.inside.items()):
                if socket in ready:
                    self.pass_out(client, socket, key)
            if self.door in ready:
                address, *frames = self.door.recv_multipart(copy=False)
                self.pass_in(address, frames)

    def pass_out(self, client: bytes, socket: Socket, key: str) -> None:
        if self.allowed.name(key):
            self.door.send_multipart([client, *socket.recv_multipart(copy=False)], copy=False)
        else:
            # A client that only listens sends nothing by which it could be refused.
            self.disconnect(client)

    def pass_in(self, address: zmq.Frame, frames: list[zmq.Frame]) -> None:
        client = address.bytes
        key = self.allowed.key_of(frames[-1]) if frames else ""
        welcome = self.allowed.name(key)
        if client in self.inside and (not welcome or self.inside[client][1] != key):
            self.disconnect(client)
        if not welcome:
            # libzmq before 4.3.5 knows it of the client's own frames alone, and the address is ROUTER's.
            self.allowed.refuse(key, str((frames or [address])[-1].get("Peer-Address")))
            return
        if len(self.inside) == self.most and client not in self.inside:
            self.disconnect(next(iter(self.inside)))
        try:
            # Put in again at the end: the first is the one that was silent longest.
            socket = self.inside.pop(client)[0] if client in self.inside else self.connect()
        except zmq.ZMQError as error:
            # Connections of strangers are open files as well. The client asks again, and by then there is room.
            self.trouble(f"no connection to the server for one more client: {error}")
            if self.inside:
                self.disconnect(next(iter(self.inside)))
            return
        self.inside[client] = socket, key
        try:
            socket.send_multipart(frames, zmq.NOBLOCK, copy=False)
        except zmq.Again:
            pass

    def connect(self) -> Socket:
        socket = self.context.socket(zmq.DEALER)
        limit(socket, LARGEST_BYTES)
        socket.connect(self.server)
        self.poller.register(socket, zmq.POLLIN)
        return socket

    def disconnect(self, client: bytes) -> None:
        socket, _ = self.inside.pop(client)
        self.poller.unregister(socket)
        socket.close()


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5565")
    # The server may be on another machine, and every machine on the way there can read along.
    example = "tcp://127.0.0.1:5554"
    parser.add_argument("--to", type=client_endpoint(example), required=True, help=f"the server behind it: {example}")
    parser.add_argument("--keys", type=Path, metavar="DIR", help="the gate's pair, and allowed/; default: keys")
    options = parser.parse_args()

    def prepare(context: Context, door: Socket) -> None:
        """Before it listens: libzmq must ask about the first client already."""
        # Not before it is sure that it may listen there.
        allowed = options.allowed = keys_for(options.keys or "keys", make=True)
        allowed.answer(context)
        allowed.guard(door)

    with listening(zmq.ROUTER, options, LARGEST_BYTES, prepare) as door:
        Gate(door.context, door, options.to, options.allowed).pass_on()


if __name__ == "__main__":
    run(main)
