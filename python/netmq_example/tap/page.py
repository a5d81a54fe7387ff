"""The page of the tap: tap.html, what it shows ten times a second, and a file that shows it all again.

    page = Page(arrows, faults, "Lesson 02")
    asyncio.run(page.serve(socket.create_server(("127.0.0.1", 8000))))

The browser gets the newest arrows and the numbers of all messages, so it costs the same however many there are; the
whole of a message it fetches when somebody opens it. It sends the fault that it wants.
Other web pages may ask a browser to connect here too. They cannot hide who they are: `Origin` and `Host` tell.
It needs aiohttp.
"""

import asyncio
import contextlib
import json
import logging
import re
import socket
from collections.abc import Awaitable, Callable

from aiohttp import WSMsgType, web

from netmq_example import arguments
from netmq_example.json_text import shallow
from netmq_example.tap.arrows import HTML, WHOLE_BYTES, Arrows, recording
from netmq_example.tap.passing import Faults

# A page gets so many arrows at a time, ten times a second: an eye does not follow more.
ARROWS_AT_A_TIME = 40
EVERY_SECONDS = 0.1
# And so many when it opens.
ARROWS_AT_FIRST = 200
SLOWEST_SECONDS = 10

log = logging.getLogger("netmq_example.server")


class Page:
    """Shows the arrows, and passes on what somebody asks for to the faults."""

    def __init__(self, arrows: Arrows, faults: Faults, title: str, frame: str = "") -> None:
        self.arrows = arrows
        self.faults = faults
        self.title = title
        # Nobody's page, or that of one server here, may show this one in a frame.
        self.frame = frame or "'none'"

    async def serve(self, listener: socket.socket) -> None:
        """Until it is cancelled."""
        application = web.Application(middlewares=[only_from_here])
        application.router.add_get("/", self.html)
        application.router.add_get("/live", self.live)
        application.router.add_get("/arrow/{number}", self.arrow)
        application.router.add_get("/recording.html", self.save)
        # It is asked who comes before anything is unpacked.
        runner = web.AppRunner(application, access_log=None, auto_decompress=False)
        await runner.setup()
        await web.SockSite(runner, listener).start()
        while True:
            # In slices: on Windows Ctrl-C does not interrupt a longer wait.
            await asyncio.sleep(0.2)

    async def html(self, request: web.Request) -> web.StreamResponse:
        # In a frame of another page clicks on Drop and Cut could be stolen.
        return web.FileResponse(HTML, headers={"Content-Security-Policy": f"frame-ancestors {self.frame}"})

    async def live(self, request: web.Request) -> web.StreamResponse:
        # No heartbeat: a page that draws much is slow to answer, and would take a closed connection for the tap's end.
        page = web.WebSocketResponse(max_msg_size=1000)
        await page.prepare(request)
        log.info("a page looks on")
        sending = asyncio.create_task(self.send(page))
        async for message in page:
            if message.type == WSMsgType.TEXT:
                self.ask(message.data)
        sending.cancel()
        return page

    async def send(self, page: web.WebSocketResponse) -> None:
        """A page that reads slowly is waited for here, and then gets the newest."""
        shown = 0
        most = ARROWS_AT_FIRST
        with contextlib.suppress(ConnectionError):
            while not page.closed:
                new = self.arrows.after(shown, most)
                state = {"title": self.title, "totals": self.arrows.totals, **self.faults.state()}
                await page.send_json({**state, "arrows": [each.as_json() for each in new]})
                if new:
                    shown = new[-1].number
                most = ARROWS_AT_A_TIME
                await asyncio.sleep(EVERY_SECONDS)

    def ask(self, text: str) -> None:
        """Do what the page asks for. A message that does not fit is not from our page."""
        with contextlib.suppress(ValueError, KeyError, TypeError):
            wish = json.loads(shallow(text))
            if "slow" in wish:
                self.faults.slow = arguments.number("slow", wish["slow"], 0, SLOWEST_SECONDS)
            if "fault" in wish:
                self.faults.ask(wish["fault"], wish["way"])

    async def arrow(self, request: web.Request) -> web.StreamResponse:
        number = request.match_info["number"]
        found = self.arrows.find(int(number)) if number.isdecimal() and len(number) < 16 else None
        return web.json_response(found.as_json(WHOLE_BYTES)) if found else web.Response(status=404, text="gone by now")

    async def save(self, request: web.Request) -> web.StreamResponse:
        # On another thread, since the browser must hear of the messages meanwhile.
        text = await asyncio.to_thread(recording, self.arrows, self.title)
        name = {"Content-Disposition": 'attachment; filename="recording.html"'}
        return web.Response(text=text, content_type="text/html", headers=name)


def own_origin(name: str, value: str) -> str:
    """A server of this machine, as a browser names it."""
    if not re.fullmatch(r"http://(127\.0\.0\.1|localhost):\d{1,5}", value, re.ASCII):
        raise ValueError(f"{name} is an origin of this machine, such as http://127.0.0.1:8000, not {value!r:.40}")
    return value


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
