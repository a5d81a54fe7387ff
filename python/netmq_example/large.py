"""A server of large messages does this besides: it copies no frame, and keeps few answers."""

import math

import zmq

from netmq_example.program import Context, Socket, receive


def few_answers_wait(context: Context, socket: Socket) -> None:
    """To `prepare` a server with large answers. More are dropped: a client that reads none fills no memory."""
    socket.sndhwm = 10


def receive_frames(socket: Socket, timeout: float = math.inf) -> list[zmq.Frame]:
    """Those of `receive`, not copied into bytes: for large frames, and where it counts who sent one."""
    return receive(socket, timeout, copy=False)
