"""Plain WebSocket at /ws/NAME: each message of a browser is answered by one, in the same form.

    attach(app, door, ["hello"], lambda name: Requester(context, endpoint, 1))         app is an aiohttp.web.Application

Text is a JSON list of texts, one for each frame. Binary is each frame behind its length, 4 bytes, little-endian. An
error is text in both cases: {"error": why}. TCP holds back a browser that does not wait for its answer.
"""

import asyncio
import contextlib
import json
import logging
import struct
from collections.abc import Callable

from aiohttp import WSMessage, WSMsgType, web

from netmq_example.json_text import shallow
from netmq_example.web.browser_socket import LARGEST_BYTES, MOST_FRAMES, BrowserSocket
from netmq_example.web.door import Door, refused

# How long a browser may take to accept its answer before it is disconnected.
SLOW_SECONDS = 10

log = logging.getLogger("netmq_example.server")


def attach(app: web.Application, door: Door, names: list[str], opened: Callable[[str], BrowserSocket]) -> None:
    """Browsers may ask for these names, and each gets a socket of its own from `opened`."""

    async def come_in(request: web.Request) -> web.StreamResponse:
        name = request.match_info["name"]
        if why := door.refusal(request.query.get("token")):
            return refused(403, why)
        if why := door.full():
            return refused(503, why)
        if name not in names:
            return refused(404, f"behind the gateway there are {', '.join(names)}, no {name[:40]!r}")
        # A browser that was not heard for so long is not there any more. All of them offer to compress; small texts and
        # pictures become no smaller, and an exchange would take a tenth longer.
        browser = web.WebSocketResponse(heartbeat=20, max_msg_size=LARGEST_BYTES, compress=False)
        await browser.prepare(request)
        with door.entered("WebSocket"), contextlib.closing(opened(name)) as socket:
            await talk(browser, socket)
        return browser

    app.router.add_get("/ws/{name}", come_in)


async def talk(browser: web.WebSocketResponse, socket: BrowserSocket) -> None:
    """One at a time: the next request is read when this one is answered."""
    async for message in browser:
        # It was longer than the largest message: aiohttp has told the browser, and closes the connection.
        if message.type == WSMsgType.ERROR:
            return
        binary = message.type == WSMsgType.BINARY
        try:
            answer = pack(await socket.ask(unpack(message)), binary)
        except (TimeoutError, ValueError) as error:
            answer = json.dumps({"error": str(error)})
        try:
            async with asyncio.timeout(SLOW_SECONDS):
                if isinstance(answer, bytes):
                    await browser.send_bytes(answer)
                else:
                    await browser.send_str(answer)
        except (TimeoutError, ConnectionError):
            log.warning("let a browser go: it does not take its answers")
            return


def unpack(message: WSMessage) -> list[bytes]:
    """The frames of a browser's message. A stranger may send anything: no JSON, no list, no texts, no such length."""
    with contextlib.suppress(ValueError, AttributeError, struct.error):
        if message.type == WSMsgType.BINARY:
            return split(message.data)
        texts = json.loads(shallow(message.data))
        if isinstance(texts, list):
            return [text.encode(errors="replace") for text in texts]
    raise ValueError('write a JSON list of texts, such as ["Hello"], or binary: each frame behind its length')


def split(data: bytes) -> list[bytes]:
    """The frames of a binary message, of which one too many is enough to refuse it."""
    frames: list[bytes] = []
    at = 0
    while at < len(data) and len(frames) <= MOST_FRAMES:
        (length,) = struct.unpack_from("<I", data, at)
        frames.append(data[at + 4 : at + 4 + length])
        at += 4 + length
    if at > len(data):
        raise ValueError("the last frame is cut")
    return frames


def pack(frames: list[bytes], binary: bool) -> bytes | str:
    if binary:
        return b"".join(struct.pack("<I", len(frame)) + frame for frame in frames)
    return json.dumps([frame.decode(errors="replace") for frame in frames])
