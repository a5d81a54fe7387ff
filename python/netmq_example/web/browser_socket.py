"""Lesson 16, the idea: the ZeroMQ socket of one browser, to one server. Nothing of the web is in this file.

Both kinds are asked for the next answer, so that at any time there is one on its way, and nowhere a queue that a slow
browser could fill: it gets less, and always the newest.
"""

import asyncio
import contextlib

import zmq
import zmq.asyncio

# A peer that announces more than the largest message is disconnected before it is in memory.
LARGEST = 4 * 1024 * 1024
# A million empty frames fit in that, too, and would keep the server busy for seconds.
MOST_FRAMES = 1000


class Requester:
    """Asks a server, one request at a time."""

    def __init__(self, context: zmq.asyncio.Context, endpoint: str, timeout: float) -> None:
        self.context, self.endpoint, self.timeout = context, endpoint, timeout
        self.socket: zmq.asyncio.Socket | None = None

    async def ask(self, frames: list[bytes]) -> list[bytes]:
        """The frames of the reply, or TimeoutError; ValueError if the request has too many."""
        if len(frames) > MOST_FRAMES:
            raise ValueError(f"more than {MOST_FRAMES} frames; several requests take more")
        self.socket = self.socket or opened(self.context, zmq.REQ, self.endpoint, self.timeout)
        try:
            await self.socket.send_multipart(frames or [b""])
            return list(await self.socket.recv_multipart())
        except zmq.Again:
            # A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
            self.close()
            why = f"no reply from {self.endpoint} within {self.timeout:g} s; is the server running?"
            raise TimeoutError(why) from None

    def close(self) -> None:
        if self.socket:
            self.socket.close()
        self.socket = None


class Listener:
    """Listens to a topic of a publisher, and keeps only what it has said last."""

    def __init__(self, context: zmq.asyncio.Context, endpoint: str, timeout: float) -> None:
        self.context, self.endpoint, self.timeout = context, endpoint, timeout
        self.topic: bytes | None = None
        self.newest, self.came = list[bytes](), asyncio.Event()

    async def ask(self, frames: list[bytes]) -> list[bytes]:
        """The newest message of the topic that the first frame names; no frames if nothing new came in time."""
        topic = frames[0] if frames else b""
        if topic != self.topic:
            self.close()
            self.topic, self.socket = topic, opened(self.context, zmq.SUB, self.endpoint, 0)
            self.socket.subscribe(topic)
            self.task = asyncio.create_task(self.listen())
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(self.timeout):
                await self.came.wait()
                self.came.clear()
                return self.newest
        return []

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
        if self.topic is not None:
            self.task.cancel()
            self.socket.close()
            self.came.clear()
        self.topic = None


BrowserSocket = Requester | Listener


def opened(context: zmq.asyncio.Context, kind: int, endpoint: str, timeout: float) -> zmq.asyncio.Socket:
    """A socket with its limits."""
    socket = context.socket(kind)
    # What is under way is dropped when the socket is closed; waiting for its delivery could take for ever.
    socket.linger, socket.maxmsgsize, socket.rcvhwm = 0, LARGEST, 100
    # 0 is for a publisher: between two of its messages any time may pass.
    socket.rcvtimeo = socket.sndtimeo = int(timeout * 1000) or -1
    socket.connect(endpoint)
    return socket


def more_files() -> None:
    """A browser takes three: its connection, its ZeroMQ socket, and that one's connection. Often 1024 are allowed."""
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (most if 0 < most < 8192 else 8192, most))
