"""Lesson 16, the requester to copy in Python: the gateway is asked by WebSocket.

    async with WebSocketRequester("http://127.0.0.1:5566", "hello") as requester:
        reply = await requester.request("Hello")

Each try has a new connection; what was asked when one broke is asked again. Whether it was done already only an id can
tell, as in lesson 02.
"""

import asyncio
import json
from types import TracebackType
from typing import Any, Self

import aiohttp

# What it looks like when nobody is there, when somebody else is, and when somebody leaves.
GONE = (OSError, aiohttp.ClientError, TypeError, ValueError, KeyError, RecursionError)
REFUSED = "{} does not let this client in: its token is missing or wrong"


class WebRequester:
    """Asks one of the servers behind the gateway. What is said how, its two kinds know."""

    def __init__(self, endpoint: str, name: str, token: str = "", timeout: float = 2.5) -> None:
        self.endpoint, self.name, self.token, self.timeout = endpoint, name, token, timeout
        self.connected, self.trouble = False, "; is the server running?"
        self.session: aiohttp.ClientSession | None = None

    async def request(self, *texts: str) -> list[str]:
        """The frames of the reply; TimeoutError if none came, whatever was tried."""
        try:
            async with asyncio.timeout(self.timeout):
                while True:
                    try:
                        if not self.connected:
                            await self.connect()
                        self.connected = True
                        answer = await self.ask(*texts)
                        if isinstance(answer, list) and all(isinstance(text, str) for text in answer):
                            return answer
                        self.trouble = f": {answer['error']}"
                    except PermissionError:
                        raise
                    except GONE as error:
                        self.trouble = f"; is the server running? ({error})"
                        await self.close()
                    # Whatever it was, it is not over at once.
                    await asyncio.sleep(0.1)
        except TimeoutError:
            # The one that was under way may still be answered.
            await self.close()
            raise TimeoutError(f"no reply from {self.endpoint} within {self.timeout:g} s{self.trouble}") from None

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
            # It is there, and no timeout would help.
            if error.status == 403:
                raise PermissionError(REFUSED.format(self.endpoint)) from None
            # Its own text has the address in it, and so the token.
            raise ConnectionError(f"it says {error.status}") from None

    async def ask(self, *texts: str) -> Any:
        await self.socket.send_str(json.dumps(texts))
        return await self.socket.receive_json()

    async def close(self) -> None:
        if self.session:
            await self.session.close()
        self.session, self.connected = None, False
