"""The ZeroMQ socket of one browser, to one server. Nothing of the web is in this file.

    socket = Requester(context, "tcp://127.0.0.1:5551", timeout=1)       a zmq.asyncio.Context
    frames = await socket.ask([b"Hello"])                                [b"World"], or Timeout
    socket = Listener(context, "tcp://127.0.0.1:5553", timeout=1)
    frames = await socket.ask([b"pose/"])                                the newest message, or [] for nothing new

Both kinds are asked for the next answer, so that at any time there is one on its way, and nowhere a queue that a slow
browser could fill: it gets less, and always the newest.
"""

import asyncio
import contextlib
from collections.abc import Sequence
from typing import Any

import zmq
import zmq.asyncio

from netmq_example import check, program
from netmq_example.errors import Timeout
from netmq_example.one_process import Keys

# A peer that announces a larger message is disconnected before it is in memory.
LARGEST_BYTES = 4 * 1024 * 1024
# A million empty frames fit in that, too, and would keep the server busy for seconds.
MOST_FRAMES = 1000


def for_browsers(keys: Keys | None = None) -> zmq.asyncio.Context:
    """A context with a socket for each name of each browser, as Socket.IO has them: libzmq's own limit is 1023."""
    context = zmq.asyncio.Context()
    if keys:
        # To the servers the gateway is one client. Each new socket of a context has the context's options.
        keys.apply(context)
    context.set(zmq.MAX_SOCKETS, program.MOST_FILES)
    return context


class BrowserSocket:
    """To the server at `endpoint`, which has `timeout` seconds for each answer."""

    def __init__(self, context: zmq.asyncio.Context, endpoint: str, timeout: float) -> None:
        self.context: zmq.asyncio.Context = check.instance("context", context, zmq.asyncio.Context)
        self.endpoint = check.endpoint(endpoint, "tcp://127.0.0.1:5551")
        self.timeout = check.seconds("timeout", timeout)
        self.socket: Any = None

    async def ask(self, frames: list[bytes]) -> list[bytes]:
        raise NotImplementedError

    def close(self) -> None:
        if self.socket:
            self.socket.close()
        self.socket = None


class Requester(BrowserSocket):
    """Asks a server, one request at a time."""

    async def ask(self, frames: list[bytes]) -> list[bytes]:
        """The frames of the reply, or Timeout; ValueError if the request has too many, or if there is no room."""
        if len(frames) > MOST_FRAMES:
            raise ValueError(f"more than {MOST_FRAMES} frames; several requests take more")
        if not self.socket:
            self.socket = opened(self.context, zmq.REQ, self.endpoint)
            self.socket.rcvtimeo = self.socket.sndtimeo = max(1, int(self.timeout * 1000))
        try:
            await self.socket.send_multipart(frames or [b""])
            return list(await self.socket.recv_multipart())
        except zmq.Again:
            # A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
            self.close()
            why = f"no reply from {self.endpoint} within {self.timeout:g} s; is the server running?"
            # A server of texts hangs up without a word. One with arrays takes more, and only it knows.
            if (longest := max(map(len, frames), default=0)) > program.LARGEST_BYTES:
                why += f" One of texts takes {program.LARGEST_BYTES} bytes, not {longest}"
            raise Timeout(why) from None


class Listener(BrowserSocket):
    """Listens to a topic of a publisher, and keeps only its newest message."""

    topic: bytes | None = None
    newest: Sequence[bytes] = ()

    async def ask(self, frames: list[bytes]) -> list[bytes]:
        """The newest message of the topic that the first frame names; no frames if nothing new came in time."""
        topic = frames[0] if frames else b""
        if topic != self.topic:
            self.close()
            self.socket = opened(self.context, zmq.SUB, self.endpoint)
            self.topic = topic
            self.came = asyncio.Event()
            self.socket.subscribe(topic)
            self.task = asyncio.create_task(self.listen())
        try:
            async with asyncio.timeout(self.timeout):
                await self.came.wait()
        except TimeoutError:
            return []
        self.came.clear()
        return [*self.newest]

    async def listen(self) -> None:
        while True:
            self.newest = await self.socket.recv_multipart()
            with contextlib.suppress(zmq.Again):
                # The limit is for a publisher that sends faster than this loop takes.
                for _ in range(100):
                    self.newest = await self.socket.recv_multipart(zmq.NOBLOCK)
            self.came.set()
            # No screen shows more, and the other browsers have their turn.
            await asyncio.sleep(0.005)

    def close(self) -> None:
        if self.socket:
            self.task.cancel()
        super().close()
        self.topic = None


def opened(context: zmq.asyncio.Context, kind: int, endpoint: str) -> zmq.asyncio.Socket:
    """A socket with its limits; ValueError if there is no room for one more."""
    try:
        socket = context.socket(kind)
    except zmq.ZMQError as error:
        raise ValueError(f"no room for a connection to {endpoint}: {error}; try again later") from None
    # A closed socket drops its messages: to wait for their delivery could take for ever.
    socket.linger = 0
    socket.maxmsgsize = LARGEST_BYTES
    socket.rcvhwm = 100
    socket.connect(endpoint)
    return socket
