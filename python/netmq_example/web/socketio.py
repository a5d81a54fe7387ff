"""Socket.IO (protocol 5, that of its clients 3 and 4): the name of an event is the name of a server.

    attach(app, door, ["hello"], lambda name: Requester(context, endpoint, 1))         app is an aiohttp.web.Application

    socket.emit("hello", "Hello", world => …)          in JavaScript: the callback gets the frames of the answer
    socket.emit("poses", "pose/", newest => …)         or, if there is none, {error: why}

A text is a frame, and so are bytes. A browser that sends bytes is answered with bytes.
"""

import asyncio
import logging
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import socketio
from aiohttp import web
from engineio.payload import Payload
from socketio.packet import Packet

from netmq_example.web.browser_socket import LARGEST_BYTES, MOST_FRAMES, BrowserSocket
from netmq_example.web.door import Door, close_strangers

# So many requests of one browser may wait, and so many answers for it. Socket.IO itself has no limit.
MOST_WAITING = 64
# Stands for bytes that were too many.
TOO_LARGE = object()

log = logging.getLogger("netmq_example.server")


class BoundedPacket(Packet):  # type: ignore[misc, unused-ignore]  # It has no types.
    """An event and the bytes that follow it, each a message of its own: Socket.IO bounds one of them, and not all."""

    def decode(self, encoded_packet: Any) -> int:
        self.size = 0
        count = int(super().decode(encoded_packet))
        if count > MOST_FRAMES:
            raise ValueError(f"{count} attachments")
        # Socket.IO would look up what cannot be looked up, or take its own sign for all names for one of them.
        if isinstance(self.data, list) and self.data and (isinstance(self.data[0], list | dict) or self.data[0] == "*"):
            raise ValueError("no name of an event")
        return count

    def add_attachment(self, attachment: Any) -> bool:
        self.size += len(attachment)
        return bool(super().add_attachment(attachment if self.size <= LARGEST_BYTES else TOO_LARGE))


class Browser:
    """One connection, and a ZeroMQ socket for each server that it has asked for something."""

    def __init__(self) -> None:
        self.sockets: dict[str, tuple[BrowserSocket, asyncio.Lock]] = {}
        self.waiting = 0
        self.inside = ExitStack()

    def close(self) -> None:
        self.inside.close()
        for socket, _ in self.sockets.values():
            socket.close()


class Gateway(socketio.AsyncNamespace):  # type: ignore[misc, unused-ignore]  # It has no types.
    """The browsers that are here, and what they ask."""

    def __init__(self, door: Door, names: list[str], opened: Callable[[str], BrowserSocket]) -> None:
        super().__init__("/")
        self.door, self.names, self.opened = door, names, opened
        self.browsers: dict[str, Browser] = {}

    async def trigger_event(self, event: str, sid: str, *args: Any) -> Any:
        # Any other name is a request: a browser that asks for an unknown one gets an answer, too.
        if event == "connect":
            return self.come_in(sid, *args)
        if event == "disconnect":
            return self.leave(sid)
        return await self.ask(event, sid, *args)

    def come_in(self, sid: str, environ: Any = None, auth: Any = None, *_: Any) -> None:
        # A browser may send an event of this name, too, when it is here already.
        if sid in self.browsers:
            return
        token = auth.get("token") if isinstance(auth, dict) else None
        if why := self.door.refusal(token) or self.door.full():
            raise socketio.exceptions.ConnectionRefusedError(why)
        self.browsers[sid] = Browser()
        self.browsers[sid].inside.enter_context(self.door.entered("Socket.IO"))

    def leave(self, sid: str) -> None:
        if sid in self.browsers:
            self.browsers.pop(sid).close()

    async def let_go(self, sid: str, browser: Browser) -> None:
        """Behind the answer that says why: no client hears what comes after its end."""
        await self.server.disconnect(sid)
        browser.close()

    def connection(self, sid: str) -> str:
        """Engine.IO's own name of a browser."""
        return str(self.server.manager.eio_sid_from_sid(sid, "/"))

    def connections(self) -> set[str]:
        return {self.connection(sid) for sid in self.browsers}

    async def ask(self, name: str, sid: str, *frames: Any) -> Any:
        # A request from before its leave may be read after it.
        if sid not in self.browsers:
            return await self.server.disconnect(sid)
        browser = self.browsers[sid]
        unread = self.server.eio.sockets[self.connection(sid)].queue.qsize()
        if unread > MOST_WAITING or browser.waiting == MOST_WAITING:
            log.warning("let a browser go: %s of its requests, or answers for it, wait", MOST_WAITING)
            # Out of the dictionary at once, so that this is said once.
            self.server.start_background_task(self.let_go, sid, self.browsers.pop(sid))
            return {"error": "too many requests at once"}
        if name not in self.names:
            return {"error": f"behind the gateway there are {', '.join(self.names)}, no {name!r:.40}"}
        if name not in browser.sockets:
            browser.sockets[name] = self.opened(name), asyncio.Lock()
        socket, turn = browser.sockets[name]
        browser.waiting += 1
        try:
            # A ZeroMQ socket has one request under way.
            async with turn:
                if sid not in self.browsers:
                    # A socket that is opened now nobody would close.
                    return None
                return answer(frames, await socket.ask([to_bytes(frame) for frame in frames]))
        except (TimeoutError, ValueError) as error:
            return {"error": str(error)}
        finally:
            browser.waiting -= 1


def attach(app: web.Application, door: Door, names: list[str], opened: Callable[[str], BrowserSocket]) -> None:
    """Browsers may ask for these names, and each gets sockets of its own from `opened`."""
    # With more requests at once by HTTP, python-socketio drops them all without a word: its own 16 are few. A million
    # would keep all others waiting, and are read before anybody has asked for the token.
    Payload.max_decode_packets = 2 * MOST_FRAMES
    # It reports the mistakes of strangers, each with a traceback.
    noise = logging.getLogger("noise")
    noise.setLevel(logging.CRITICAL)
    # The door has looked at the Origin. A browser that was not heard for both times is not there any more.
    server = socketio.AsyncServer(
        async_mode="aiohttp",
        serializer=BoundedPacket,
        cors_allowed_origins="*",
        max_http_buffer_size=LARGEST_BYTES,
        ping_interval=10,
        ping_timeout=10,
        engineio_logger=noise,
    )
    gateway = Gateway(door, names, opened)
    server.register_namespace(gateway)
    server.attach(app)
    server.start_background_task(close_strangers, server.eio.sockets, gateway.connections)


def to_bytes(frame: Any) -> bytes:
    if isinstance(frame, bytes):
        return frame
    if isinstance(frame, str):
        return frame.encode(errors="replace")
    if frame is TOO_LARGE:
        raise ValueError(f"more than {LARGEST_BYTES} bytes; several requests take more")
    raise ValueError("a frame is a text or bytes")


def answer(asked: tuple[Any, ...], frames: list[bytes]) -> Any:
    """A tuple: to Socket.IO those are several arguments of the callback, and a list would be one."""
    if any(isinstance(frame, bytes) for frame in asked):
        return tuple(frames)
    return tuple(frame.decode(errors="replace") for frame in frames)
