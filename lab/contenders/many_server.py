"""Lesson 06's bytes, answered as fast as Python can, for the performance lab: a ROUTER and nothing beside it.

Bytes: as in lesson 06, [id][text] each way. `echo TEXT` is answered with TEXT, anything else with an error. There are
no workers: whatever takes long holds up everybody.
"""

from __future__ import annotations

from functools import partial

import zmq


def answer(text: bytes) -> bytes:
    return text[5:] if text.startswith(b"echo ") else b"error: expected an id and 'echo TEXT'"


def serve(socket: zmq.Socket[bytes]) -> None:
    # Each saves a part of a microsecond: whole numbers in place of zmq.SNDMORE and zmq.RCVMORE, which are members of an
    # enum, and pyzmq's inner `send`, without the Python function around it that looks after rarer sockets.
    more, is_more = int(zmq.SNDMORE), int(zmq.RCVMORE)
    receive, ask, send = socket.recv, socket.get, partial(zmq.backend.Socket.send, socket)
    while True:
        client, request_id = receive(), receive()
        text = receive() if ask(is_more) else b""
        while ask(is_more):
            text = receive()[:0]
        send(client, more)
        send(request_id, more)
        send(answer(text))


def main() -> None:
    with zmq.Context() as context, context.socket(zmq.ROUTER) as socket:
        socket.linger = 0
        socket.bind("tcp://127.0.0.1:*")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
