"""The same client of the gateway by Socket.IO. In C# it is SocketIORequester.cs.

    async with SocketIORequester("http://127.0.0.1:5566", "hello") as requester:
        reply = await requester.request("Hello")                                     ["World"], or Timeout

It needs python-socketio.
"""

import asyncio
from typing import Any

import socketio

from netmq_example.errors import Error, Refused
from netmq_example.extras import pip_install
from netmq_example.web.requester import REFUSED, WebRequester


class SocketIORequester(WebRequester):
    """A request is an event of the server's name, and its reply is the acknowledgement."""

    client: Any = None

    async def connect(self) -> None:
        # We try again ourselves: the requests that its own reconnection has lost nobody would hear of.
        self.client = socketio.AsyncClient(reconnection=False)
        self.gone = gone = asyncio.Event()
        refusals: list[Any] = []
        self.client.on("disconnect", lambda *_: gone.set())
        # A message that no gateway sends ends a task of Socket.IO, and the event loop hears of it. It also hears,
        # without an exception, that Socket.IO has not closed the connection of an earlier try.
        asyncio.get_running_loop().set_exception_handler(lambda _, what: gone.set() if "exception" in what else None)
        self.client.on("connect_error", refusals.append)
        try:
            await self.client.connect(self.endpoint, auth={"token": self.token}, transports=["websocket"])
        except socketio.exceptions.ConnectionError:
            if "token" in str(refusals):
                raise Refused(REFUSED.format(self.endpoint)) from None
            raise ConnectionError(refusals[0] if refusals else "it does not answer") from None
        except AttributeError as error:
            # The newest python-engineio needs aiohttp 3.11, and does not say so.
            why = f"aiohttp is too old for this python-socketio ({error})"
            raise Error(f"{why}: {pip_install('--upgrade', 'aiohttp')}") from None

    async def ask(self, *texts: str) -> Any:
        asked = asyncio.create_task(self.client.call(self.name, texts, timeout=self.timeout))
        gone = asyncio.create_task(self.gone.wait())
        try:
            await asyncio.wait([asked, gone], return_when=asyncio.FIRST_COMPLETED)
            if not asked.done():
                raise ConnectionError("the gateway has left")
            answer = asked.result()
        except socketio.exceptions.SocketIOError as error:
            raise ConnectionError(str(error)) from None
        finally:
            asked.cancel()
            gone.cancel()
        # One frame comes alone, several as a list, none as nothing.
        if isinstance(answer, str):
            return [answer]
        return [] if answer is None else answer

    async def close(self) -> None:
        if self.client:
            await self.client.disconnect()
        self.client = None
        self.connected = False
