"""A client of the gateway by WebSocket. In C# it is WebSocketRequester.cs.

    async with WebSocketRequester("http://127.0.0.1:5566", "hello") as requester:
        reply = await requester.request("Hello")                                     ["World"], or Timeout

Each try has a new connection; what was asked when one broke is asked again. Whether it was done already only an id can
tell, as in lesson 02. Refused: the gateway does not let this client in. socketio_requester.py does it by Socket.IO.
"""

import asyncio
import json
import time
from types import TracebackType
from typing import Any, Self

import aiohttp

from netmq_example import arguments, check
from netmq_example.errors import Refused, Timeout
from netmq_example.json_text import shallow

# Raised when nobody is there, when another program is, and when the gateway leaves.
GONE = (OSError, aiohttp.ClientError, TypeError, ValueError, KeyError)
REFUSED = "{} does not let this client in: its token is missing or wrong"


class WebRequester:
    """Asks one of the servers behind the gateway, in one event loop. Its two kinds know how."""

    def __init__(self, endpoint: str, name: str, *, token: str = "", timeout: float = 2.5) -> None:
        """For each request it has `timeout` seconds in all, in which it tries again and again."""
        self.endpoint = check.endpoint(endpoint, "http://127.0.0.1:5566")
        self.name = arguments.text("name", name)
        self.token: str = check.instance("token", token, str)
        self.timeout = check.seconds("timeout", timeout)
        self.connected = False
        self.trouble = "is the server running?"
        self.session: aiohttp.ClientSession | None = None

    async def request(self, *texts: str) -> list[str]:
        """The frames of the reply; Timeout if none came, however often it was asked."""
        for text in texts:
            check.instance("a text", text, str)
        end = time.monotonic() + self.timeout
        try:
            async with asyncio.timeout(self.timeout):
                # It cancels once, and what is awaited may swallow that, as Python 3.11's own wait_for does.
                while time.monotonic() < end:
                    try:
                        return await self.try_once(texts)
                    except GONE as error:
                        self.trouble = f"is the server running? ({error})"
                        await self.close()
                    except NoAnswer as error:
                        self.trouble = str(error)
                    # After any trouble it waits a moment.
                    await asyncio.sleep(0.1)
            raise TimeoutError
        except TimeoutError:
            # The one that was under way may still be answered.
            await self.close()
            raise Timeout(f"no reply from {self.endpoint} within {self.timeout:g} s; {self.trouble}") from None

    async def try_once(self, texts: tuple[str, ...]) -> list[str]:
        if not self.connected:
            await self.connect()
        self.connected = True
        answer = await self.ask(*texts)
        if isinstance(answer, list) and all(isinstance(text, str) for text in answer):
            return answer
        raise NoAnswer(answer["error"])

    async def connect(self) -> None:
        raise NotImplementedError

    async def ask(self, *texts: str) -> Any:
        raise NotImplementedError

    async def close(self) -> None:
        """Twice is once."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.endpoint!r})"

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: type | BaseException | TracebackType | None) -> None:
        await self.close()


class NoAnswer(Exception):
    """The gateway is there, and says why it has no answer."""


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
                raise Refused(REFUSED.format(self.endpoint)) from None
            # Its own text has the address in it, and so the token.
            raise ConnectionError(f"it says {error.status}") from None

    async def ask(self, *texts: str) -> Any:
        await self.socket.send_str(json.dumps(texts))
        return await self.socket.receive_json(loads=lambda text: json.loads(shallow(text)))

    async def close(self) -> None:
        if self.session:
            await self.session.close()
        self.session = None
        self.connected = False
