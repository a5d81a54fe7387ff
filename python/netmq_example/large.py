"""A server of large messages does this besides: it copies no frame, and keeps few answers."""

import math
from collections.abc import Sequence
from typing import Any

import zmq

from netmq_example.program import Context, Socket, receive

# To combine pyzmq's own flags takes longer than to send.
MORE = int(zmq.SNDMORE)


def few_answers_wait(context: Context, socket: Socket) -> None:
    """To `prepare` a server with large answers. More are dropped: a client that reads none fills no memory."""
    socket.sndhwm = 10


def receive_frames(socket: Socket, timeout: float = math.inf) -> list[zmq.Frame]:
    """As `receive`, not copied into bytes: for large frames, and where it counts who sent one."""
    return receive(socket, timeout, uncopied)


def uncopied(socket: Socket) -> list[zmq.Frame]:
    frames = [socket.recv(0, False)]
    # A frame knows whether another one follows. recv_multipart asks the socket, which takes twice as long.
    while frames[-1].more:
        frames.append(socket.recv(0, False))
    return frames


def send_frames(socket: Socket, frames: Sequence[Any]) -> None:
    """Those of a Message, not copied: send_multipart would look at each once more."""
    for frame in frames[:-1]:
        socket.send(frame, MORE, False)
    socket.send(frames[-1], 0, False)
