"""Lesson 16, the requesters to take home in Python: the gateway is asked by WebSocket, or the same by Socket.IO.

    async with WebSocketRequester("http://127.0.0.1:5566", "hello") as requester:
        reply = await requester.request("Hello")

Each try has a new connection; what was asked when one broke is asked again. Whether it was done already only an id can
tell, as in lesson 02. Take home: this file.
"""

import asyncio
import json
from types import TracebackType
from typing import Any, Self

import aiohttp
import socketio

# What it looks like when nobody is there, when somebody else is, and when somebody leaves.
GONE = (OSError, aiohttp.ClientError, socketio.exceptions.SocketIOError, TimeoutError, TypeError, ValueError)
REFUSED = "{} does not let this client in: its token is missing or wrong"


class WebRequester:
    """Asks one of the servers behind the gateway. What is said how, its two kinds know."""

    def __init__(self, endpoint: str, name: str, token: str = "", patience: float = 2.5) -> None:
        self.endpoint, self.name, self.token, self.patience = endpoint, name, token, patience
        self.connected, self.trouble = False, ""
        self.session: aiohttp.ClientSession | None = None
        self.client: Any = None

    async def request(self, *texts: str) -> list[str]:
        """The frames of the reply; TimeoutError if none came, whatever was tried."""
        try:
            async with asyncio.timeout(self.patience):
                while True:
                    try:
                        if not self.connected:
                            await self.connect()
                        self.connected = True
                        answer = await self.ask(*texts)
                        if isinstance(answer, list):
                            return [str(text) for text in answer]
                        self.trouble = f": {answer['error']}"
                    except PermissionError:
                        raise
                    except GONE:
                        await self.close()
                        # A new try takes the time of a connection at least.
                        await asyncio.sleep(0.1)
        except TimeoutError:
            # The one that was under way may still be answered.
            await self.close()
            why = f"no reply from {self.endpoint} within {self.patience:g} s{self.trouble}"
            raise TimeoutError(why if self.trouble else f"{why}; is the server running?") from None

    async def connect(self) -> None:
        raise NotImplementedError

    async def ask(self, *texts: str) -> Any:
        raise NotImplementedError

    async def close(self) -> None:
        raise NotImplementedError

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: type | BaseException | TracebackType | None) -> None:
        await self.close()


class WebSocketRequester(WebRequester):
    """A request is a message, and so is its reply."""

    async def connect(self) -> None:
        self.session = aiohttp.ClientSession()
        where = f"{self.endpoint}/ws/{self.name}"
        try:
            self.socket = await self.session.ws_connect(where, params={"token": self.token}, max_msg_size=0)
        except aiohttp.WSServerHandshakeError as error:
            # It is there, and no patience would help.
            if error.status == 403:
                raise PermissionError(REFUSED.format(self.endpoint)) from None
            raise

    async def ask(self, *texts: str) -> Any:
        await self.socket.send_str(json.dumps(texts))
        return await self.socket.receive_json()

    async def close(self) -> None:
        if self.session:
            await self.session.close()
        self.session, self.connected = None, False


class SocketIORequester(WebRequester):
    """A request is an event of the server's name, and its reply is the acknowledgement."""

    async def connect(self) -> None:
        # We try again ourselves: the requests that its own reconnection has lost nobody would hear of.
        self.client, gone = socketio.AsyncClient(reconnection=False), asyncio.Event()
        self.client.on("disconnect", lambda *_: gone.set())
        self.gone = gone
        try:
            await self.client.connect(self.endpoint, auth={"token": self.token}, transports=["websocket"])
        except socketio.exceptions.ConnectionError as error:
            if "token" in str(error):
                raise PermissionError(REFUSED.format(self.endpoint)) from None
            raise

    async def ask(self, *texts: str) -> Any:
        asked = asyncio.create_task(self.client.call(self.name, texts, timeout=self.patience))
        gone = asyncio.create_task(self.gone.wait())
        try:
            await asyncio.wait([asked, gone], return_when=asyncio.FIRST_COMPLETED)
            if not asked.done():
                raise ConnectionError
            answer = asked.result()
        finally:
            asked.cancel()
            gone.cancel()
        # One frame comes alone, several as a list, none as nothing.
        return [answer] if isinstance(answer, str) else [] if answer is None else answer

    async def close(self) -> None:
        if self.client:
            await self.client.disconnect()
        self.client, self.connected = None, False
