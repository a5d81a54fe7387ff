"""Lesson 15, a gate: a server without keys stays on its machine, and who has a key comes to it from outside.

    python python/04_background_client/server.py
    python python/15_security/gate.py --to tcp://127.0.0.1:5554 --endpoint tcp://0.0.0.0:5565 --keys keys
    dotnet run --project csharp-console -- 4 --endpoint tcp://127.0.0.1:5565 --with-keys keys

The server behind it is not changed and knows nothing of keys. Each client has a connection of its own there, and each
message is looked at: whoever was revoked is not passed on any more, and gets no answer.
Bytes: those of the server behind it. A PUB socket, as in lesson 03, takes its keys itself: AllowList.guard.
"""

import argparse
import contextlib
import re
import signal
import sys
from pathlib import Path

import zmq
from server import ENDPOINT, endpoint, keys_for

# Pictures pass as well; and this many clients at a time, after which the one that was silent longest is let go.
LARGEST, CLIENTS = 64 << 20, 500


def pass_on(context: zmq.Context[zmq.Socket[bytes]], door: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """In and out. What does not fit is dropped, as ROUTER does: nobody may make the others wait."""
    allowed, poller = options.allowed, zmq.Poller()
    # Each client's connection to the server, and the key that the client has shown: an address may change hands.
    inside: dict[bytes, tuple[zmq.Socket[bytes], str]] = {}

    def let_go(way: bytes) -> None:
        socket, _ = inside.pop(way)
        poller.unregister(socket)
        socket.close()

    poller.register(door, zmq.POLLIN)
    while True:
        ready = dict(poller.poll(200))
        for client, (socket, key) in list(inside.items()):
            if socket not in ready:
                continue
            if allowed.name(key):
                door.send_multipart([client, *socket.recv_multipart(copy=False)], copy=False)
            else:
                # Who only listens says nothing by which it could be refused.
                let_go(client)
        if door in ready:
            way, *frames = door.recv_multipart(copy=False)
            client, key = way.bytes, allowed.key_of(frames[-1]) if frames else ""
            welcome = allowed.name(key)
            if client in inside and (not welcome or inside[client][1] != key):
                let_go(client)
            if not welcome:
                # libzmq before 4.3.5 knows it of the client's own frames alone, and way is ROUTER's.
                allowed.refuse(key, str((frames or [way])[-1].get("Peer-Address")))
                continue
            if len(inside) == CLIENTS and client not in inside:
                let_go(next(iter(inside)))
            socket = inside.pop(client)[0] if client in inside else connected(context, options.to, poller)
            inside[client] = socket, key
            with contextlib.suppress(zmq.Again):
                socket.send_multipart(frames, zmq.NOBLOCK, copy=False)


def behind(text: str) -> str:
    """Where to connect to, and not to listen: it may be any machine; who is on the way there reads along."""
    port = re.fullmatch(r"tcp://[\w.-]+:(\d{1,5})", text, re.ASCII)
    if not port or not 0 < int(port[1]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5554, port 1 to 65535")
    return text


def connected(context: zmq.Context[zmq.Socket[bytes]], where: str, poller: zmq.Poller) -> zmq.Socket[bytes]:
    socket = context.socket(zmq.DEALER)
    socket.linger, socket.maxmsgsize = 0, LARGEST
    socket.connect(where)
    poller.register(socket, zmq.POLLIN)
    return socket


def main() -> None:
    parser = argparse.ArgumentParser(description="Lets those in whose keys are on the list, to a server without keys.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="where clients come; port 0: a free one")
    parser.add_argument("--to", type=behind, required=True, help="the server behind it: tcp://127.0.0.1:5554")
    parser.add_argument("--keys", type=Path, default="keys", metavar="DIR", help="the server's pair, and allowed/")
    parser.set_defaults(no_authenticator=False, any_domain=False)
    options = parser.parse_args()
    signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.ROUTER) as door:
        door.linger, door.maxmsgsize = 0, LARGEST
        options.allowed = keys_for(context, door, options)
        try:
            door.bind(options.endpoint)
        except zmq.ZMQError as error:
            sys.exit(f"cannot listen on {options.endpoint}: {zmq.strerror(error.errno or 0)}")
        print(f"listening on {door.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        pass_on(context, door, options)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
