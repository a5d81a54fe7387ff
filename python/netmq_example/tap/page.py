"""Lesson 16, the page of the tap: tap.html, what it shows ten times a second, and a file that shows it all again.

The browser gets the newest arrows and the numbers of all messages, so it costs the same however many there are; the
whole of a message it fetches when somebody opens it. What it sends is the trouble that it asks for.
Other web pages may ask a browser to connect here too. They cannot hide who they are: `Origin` and `Host` tell.
It needs aiohttp.
"""

import asyncio
import contextlib
import json
import socket
import sys
from collections.abc import Awaitable, Callable

from netmq_example.tap.arrows import HTML, WHOLE, Arrows, recording
from netmq_example.tap.passing import FATES, Trouble

try:
    from aiohttp import WSMsgType, web
except ImportError:
    sys.exit("the tap needs aiohttp: pip install aiohttp, or let kit.py run 1 --watch do it")

# A page gets so many arrows at a time, ten times a second: an eye does not follow more.
AT_A_TIME, EVERY = 40, 0.1
HISTORY = 200


class Page:
    def __init__(self, arrows: Arrows, trouble: Trouble, title: str) -> None:
        self.arrows, self.trouble, self.title = arrows, trouble, title

    async def serve(self, listener: socket.socket) -> None:
        """Until it is cancelled."""
        application = web.Application(middlewares=[only_from_here])
        application.router.add_get("/", self.html)
        application.router.add_get("/live", self.live)
        application.router.add_get("/arrow/{number}", self.arrow)
        application.router.add_get("/recording.html", self.save)
        runner = web.AppRunner(application, access_log=None)
        await runner.setup()
        await web.SockSite(runner, listener).start()
        while True:
            # In slices: on Windows Ctrl-C does not interrupt a longer wait.
            await asyncio.sleep(0.2)

    async def html(self, request: web.Request) -> web.StreamResponse:
        return web.FileResponse(HTML)

    async def live(self, request: web.Request) -> web.StreamResponse:
        # A page that draws much, or is not in front, is slow to answer: who closes it tells it that the tap has ended.
        page = web.WebSocketResponse(heartbeat=60, max_msg_size=1000)
        await page.prepare(request)
        print("a page looks on", flush=True)
        sending = asyncio.create_task(self.send(page))
        async for message in page:
            if message.type == WSMsgType.TEXT:
                self.ask(message.data)
        sending.cancel()
        return page

    async def send(self, page: web.WebSocketResponse) -> None:
        """A page that reads slowly is waited for here, and then gets the newest."""
        shown, most = 0, HISTORY
        with contextlib.suppress(ConnectionError):
            while not page.closed:
                new = self.arrows.after(shown, most)
                told = {"title": self.title, "totals": self.arrows.totals, **self.trouble.state()}
                await page.send_json({**told, "arrows": [each.as_json() for each in new]})
                shown, most = new[-1].number if new else shown, AT_A_TIME
                await asyncio.sleep(EVERY)

    def ask(self, text: str) -> None:
        """What does not fit is no wish of our page."""
        with contextlib.suppress(ValueError, KeyError, TypeError, AttributeError, RecursionError):
            asked = json.loads(text)
            if 0 <= float(asked.get("slow", -1)) <= 10:
                self.trouble.slow = float(asked["slow"])
            if asked.get("fate", "none") in ("", *FATES) and asked["way"] in ("", "up", "down"):
                self.trouble.ask(asked["fate"], asked["way"])

    async def arrow(self, request: web.Request) -> web.StreamResponse:
        number = request.match_info["number"]
        found = self.arrows.find(int(number)) if number.isdecimal() and len(number) < 16 else None
        return web.json_response(found.as_json(WHOLE)) if found else web.Response(status=404, text="gone by now")

    async def save(self, request: web.Request) -> web.StreamResponse:
        # On another thread, since the browser must hear of the messages meanwhile.
        text = await asyncio.to_thread(recording, self.arrows, self.title)
        name = {"Content-Disposition": 'attachment; filename="recording.html"'}
        return web.Response(text=text, content_type="text/html", headers=name)


@web.middleware
async def only_from_here(
    request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
) -> web.StreamResponse:
    """A name that leads to this machine by a trick is another Host; a page from elsewhere has another Origin."""
    host = request.headers.get("Host", "")
    if host.partition(":")[0] not in ("127.0.0.1", "localhost"):
        raise web.HTTPForbidden(text="only for this machine: open it by 127.0.0.1")
    if request.headers.get("Origin", f"http://{host}") != f"http://{host}":
        raise web.HTTPForbidden(text="only for the page of this tap")
    return await handler(request)
