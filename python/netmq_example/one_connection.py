"""A socket's only connection: whether it is there is known, and no second one takes its place unseen. At the other end
a ROUTER knows of each peer whether it is there.
"""

import threading
import time
from typing import Any

import zmq

from netmq_example import check
from netmq_example.errors import Timeout
from netmq_example.messages import LIMIT
from netmq_example.program import SLICE_MS, cannot_listen, limit

# For a connection, and then for the answer to hello: so long waits the first try.
TRY_SECONDS = 1.0
NO_CONNECTION = "no connection"


def connect_once(socket: zmq.Socket[Any], endpoint: str, wait: float, stop: threading.Event | None = None) -> None:
    """Wait for it so many seconds. Timeout: it did not come.

    ConnectionRefusedError: nobody listens, or whoever does hung up.
    """
    # Nothing can be sent while there is no connection, and this socket makes no second one: it might do so between two
    # looks, without a hello, and Python and simulator would wait for each other.
    socket.immediate = True
    socket.reconnect_ivl = -1
    # A pulled cable closes no connection: a silent peer is asked, and gone when 2.5 s bring no answer. After less, a
    # computer that learns on all its cores would be taken for gone.
    socket.heartbeat_ivl, socket.heartbeat_timeout = 500, 2500
    with socket.get_monitor_socket(zmq.EVENT_CLOSED | zmq.EVENT_DISCONNECTED) as refused:
        try:
            socket.connect(endpoint)
            if not poll(socket, zmq.POLLOUT, wait, stop):
                raise (ConnectionRefusedError if refused.poll(0) else Timeout)(NO_CONNECTION)
        finally:
            socket.disable_monitor()


def bound(endpoint: str, example: str, cure: str, context: zmq.Context[Any] | None = None) -> zmq.Socket[bytes]:
    """A ROUTER socket that listens there, in a context of its own unless one is given. ListenError: it cannot."""
    check.endpoint(endpoint, example, lowest_port=0)
    own = context or zmq.Context()
    socket = own.socket(zmq.ROUTER)
    limit(socket, 4 * LIMIT)
    socket.rcvtimeo = SLICE_MS
    try:
        socket.bind(endpoint)
    except zmq.ZMQError as error:
        socket.close()
        if not context:
            own.destroy()
        raise cannot_listen(endpoint, error, cure) from None
    return socket


def sent(socket: Any, peer: bytes, frames: list[Any]) -> bool:
    """By a ROUTER socket. False if the peer is gone. One that takes nothing now gets it later, once more."""
    try:
        socket.send_multipart([peer, *frames], zmq.NOBLOCK)
    except zmq.ZMQError as error:
        return error.errno == zmq.EAGAIN
    return True


def poll(socket: zmq.Socket[Any], event: int, wait: float, stop: threading.Event | None = None) -> bool:
    """Whether it comes within so many seconds, looked at in slices."""
    end = time.monotonic() + wait
    while not socket.poll(min(SLICE_MS, int(1000 * wait)), event):
        if time.monotonic() > end or (stop and stop.is_set()):
            return False
    return True
