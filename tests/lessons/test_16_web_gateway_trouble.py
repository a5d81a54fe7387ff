"""Lesson 16: what a stranger does to the gateway, and what a stranger in its place does to the clients."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import re
import struct
import sys
import threading
import time
from importlib.metadata import version
from pathlib import Path

import pytest

from tests.conftest import CLIENTS, PYTHON
from tests.lessons.test_16_web_gateway import ABSENT, HELLO, KEY, asked, by, each_kind, each_way, in_browser
from tests.programs import LIMIT, PATIENT, ROOT

aiohttp = pytest.importorskip("aiohttp", reason="lesson 16 needs aiohttp: pip install aiohttp")
web = pytest.importorskip("aiohttp.web")
pytest.importorskip("socketio", reason="lesson 16 needs python-socketio: pip install python-socketio")

FOLDER = ROOT / "python" / KEY
# For a program that changes a number of the package before it runs server.py.
PATH = os.pathsep.join([str(FOLDER), str(FOLDER.parent)])


@pytest.fixture
def gateway(serve):
    """gateway(*words): lesson 01's server, and the gateway in front of it."""
    _, behind = serve(HELLO)
    return lambda *words: serve(KEY, "--hello", behind, *ABSENT[2:], *PATIENT, *words)


def by_socketio(endpoint, talk, auth="40"):
    """The same as in_browser, with a connection of Socket.IO, by hand; its first word may be another."""

    async def run():
        address = f"{endpoint}/socket.io/?EIO=4&transport=websocket"
        async with aiohttp.ClientSession() as session, session.ws_connect(address) as browser:
            await browser.receive_str(timeout=LIMIT)
            await browser.send_str(auth)
            return await talk(browser, await browser.receive_str(timeout=LIMIT))

    return asyncio.run(run())


# A stranger to the gateway


def test_a_browsers_own_events_named_connect_and_disconnect(gateway):
    program, endpoint = gateway()

    async def talk(browser, _):
        for event in ('42["connect",{}]', '42["connect"]', '42["connect",1,2,3]'):
            await browser.send_str(event)
        await browser.send_str('421["hello","Hello"]')
        assert await browser.receive_str(timeout=LIMIT) == '431["World"]'
        await browser.send_str('42["disconnect"]')
        await browser.send_str('422["hello","Hello"]')
        # It has said that it leaves, and so it does.
        assert await browser.receive_str(timeout=LIMIT) == "41"

    by_socketio(endpoint, talk)
    program.wait_for("^browser 1 left$")
    assert program.stop() == 0
    assert program.lines[1:] == ["browser 1 came by Socket.IO", "browser 1 left"]


def test_words_that_are_none_make_no_traceback(gateway):
    program, endpoint = gateway("--token", "secret")

    async def refused(_, said):
        assert "the token is missing or wrong" in said

    async def says(browser, said):
        assert said.startswith("40{")
        await browser.send_str("")
        while (await browser.receive(timeout=LIMIT)).type == aiohttp.WSMsgType.TEXT:
            pass

    # Half of a surrogate pair is no letter of UTF-8.
    by_socketio(endpoint, refused, '40{"token":"\\ud800"}')
    by_socketio(endpoint, says, '40{"token":"secret"}')
    assert program.stop() == 0
    assert "Traceback" not in program.output and "Error" not in program.output


def test_a_name_that_nobody_has_is_answered_too(gateway):
    """Who waits for it would believe that the server is slow."""
    program, endpoint = gateway()

    async def talk(browser, _):
        for number, name in enumerate(["nobody", 7, ""], 1):
            await browser.send_str(f"42{number}{json.dumps([name, 'Hello'])}")
            said = f"behind the gateway there are hello, background, poses, pictures, no {name!r}"
            assert await browser.receive_str(timeout=LIMIT) == f"43{number}" + json.dumps(
                [{"error": said}], separators=(",", ":")
            )
        await browser.send_str('429["hello","Hello"]')
        assert await browser.receive_str(timeout=LIMIT) == '439["World"]'

    by_socketio(endpoint, talk)
    assert program.stop() == 0 and "Traceback" not in program.output


def test_a_million_frames_are_too_many(gateway):
    """Each is nothing, and all of them together would keep the server behind busy for seconds."""
    _, endpoint = gateway()
    said = {"error": "more than 1000 frames; several requests take more"}

    async def talk(browser):
        await browser.send_str("[" + ",".join(['""'] * 1_000_000) + "]")
        assert await browser.receive_json(timeout=LIMIT) == said
        await browser.send_bytes(struct.pack("<I", 0) * 1_000_000)
        assert await browser.receive_json(timeout=LIMIT) == said
        assert await asked(browser, "Hello") == ["World"]

    in_browser(endpoint, talk)

    async def events(browser, _):
        await browser.send_str("421" + json.dumps(["hello", *[""] * 2000]))
        assert json.loads((await browser.receive_str(timeout=LIMIT))[3:]) == [said]

    by_socketio(endpoint, events)


def test_who_connects_and_asks_nothing_is_let_go(serve, start):
    """Or asks half of something. A browser that has asked stays, however silent it is."""
    _, behind = serve(HELLO)
    code = "from netmq_example.web import door; door.SILENT_SECONDS = 1; import server; server.main()"
    words = ["--endpoint", "http://127.0.0.1:0", "--hello", behind, *PATIENT]
    program = start(PYTHON, "-c", code, *words, PYTHONPATH=PATH)
    endpoint = program.wait_for(r"^listening on (\S+)")[1]
    polling = "/socket.io/?EIO=4&transport=polling"

    async def talk(browser):
        async with aiohttp.ClientSession() as session, session.get(endpoint + polling) as opened:
            name = json.loads((await opened.text())[1:])["sid"]
        body = f"POST {polling}&sid={name} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 10\r\n\r\n4"
        for said in ("", "GET / HTTP/1.1\r\nHos", body):
            reader, writer = await asyncio.open_connection(*endpoint.removeprefix("http://").split(":"))
            writer.write(said.encode())
            with contextlib.suppress(ConnectionError):
                # To its end, which comes when it is let go.
                await asyncio.wait_for(reader.read(), LIMIT)
            writer.close()
        # Silent itself for three times as long.
        assert await asked(browser, "Hello") == ["World"]

    in_browser(endpoint, talk)
    program.wait_for("^browser 1 left$")
    assert program.stop() == 0
    said = "let go, since they asked nothing within 1 s: 1"
    outside = "let go, since it did not ask to come in within 1 s"
    lines = [line for line in program.lines[1:] if line != outside]
    assert lines == ["browser 1 came by WebSocket", said, said, said, "browser 1 left"]


def test_who_stays_outside_of_socketio_is_let_go(serve, start):
    """It opens Engine.IO's connection, goes on talking, and asks for nothing. Who came in stays."""
    if [int(part) for part in version("python-engineio").split(".")[:2]] < [4, 6]:
        pytest.skip("python-engineio before 4.6 keeps a WebSocket that it has closed until nothing came for 20 s")
    _, behind = serve(HELLO)
    code = "from netmq_example.web import door; door.SILENT_SECONDS = 3; import server; server.main()"
    words = ["--endpoint", "http://127.0.0.1:0", "--hello", behind, "--token", "word", *PATIENT]
    program = start(PYTHON, "-c", code, *words, PYTHONPATH=PATH)
    endpoint = program.wait_for(r"^listening on (\S+)")[1]

    async def stay(inside):
        """Until it is answered; a ping is answered, too."""
        async for said in inside:
            if said.data == "2":
                await inside.send_str("3")
            elif "World" in said.data:
                return
        raise AssertionError("it was let go")

    async def talk():
        async with aiohttp.ClientSession() as session:
            url = f"{endpoint}/socket.io/?EIO=4&transport=websocket"
            async with session.ws_connect(url) as inside:
                await inside.send_str('40{"token":"word"}')
                async with session.ws_connect(url) as outside:
                    staying, deadline = asyncio.create_task(stay(inside)), time.monotonic() + LIMIT
                    while not outside.closed and time.monotonic() < deadline:
                        # Its end is told by receiving alone, also where sending fails already.
                        with contextlib.suppress(ConnectionError):
                            await outside.send_str("3")
                        with contextlib.suppress(TimeoutError):
                            await outside.receive(timeout=0.1)
                    assert outside.closed
                    await inside.send_str('421["hello","Hello"]')
                    await asyncio.wait_for(staying, LIMIT)

    asyncio.run(talk())
    assert program.stop() == 0
    assert program.lines[1:3] == ["browser 1 came by Socket.IO", "let go, since it did not ask to come in within 3 s"]


def test_what_a_browser_has_asked_before_it_left_opens_nothing(gateway):
    program, endpoint = gateway()
    folder = Path(f"/proc/{program.process.pid}/fd")
    if not folder.exists():
        pytest.skip("counts what is open in /proc")

    async def talk(browser, _):
        for i in range(60):
            await browser.send_str(f'42{i}["background","Hello"]')
        await browser.send_str('4299["hello","Hello"]')
        assert await browser.receive_str(timeout=LIMIT) == '4399["World"]'

    in_browser(endpoint, lambda browser: asked(browser, "Hello"))
    program.wait_for("^browser 1 left$")
    before = len(list(folder.iterdir()))
    for i in range(2, 5):
        by_socketio(endpoint, talk)
        program.wait_for(f"^browser {i} left$")
    deadline = time.monotonic() + LIMIT / 4
    while len(list(folder.iterdir())) > before:
        assert time.monotonic() < deadline, "sockets that nobody closes"
        time.sleep(0.05)


def test_a_flood_of_requests_holds_up_no_end(gateway):
    program, endpoint = gateway()

    async def talk(browser, _):
        with contextlib.suppress(ConnectionError):
            for i in range(3000):
                await browser.send_str(f'42{i}["background","Hello"]')
        await asyncio.to_thread(program.wait_for, "^browser 1 left$")
        # It is here still, and does not listen. Ten seconds are Socket.IO's own timeout.
        assert await asyncio.to_thread(program.stop, limit=8) == 0

    by_socketio(endpoint, talk)
    assert program.lines[1:] == [
        "browser 1 came by Socket.IO",
        "let a browser go: 64 of its requests, or answers for it, wait",
        "browser 1 left",
    ]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of open files for a program")
def test_more_browsers_than_a_system_lets_a_program_open_files(serve, start):
    """Often 1024, and each browser takes three."""
    pytest.importorskip("resource")
    _, behind = serve(HELLO)
    words = [PYTHON, FOLDER / "server.py", "--endpoint", "http://127.0.0.1:0", "--hello", behind, *PATIENT]
    program = start("sh", "-c", 'ulimit -Sn 64; exec "$@"', "sh", *words)
    endpoint = program.wait_for(r"^listening on (\S+)")[1]

    async def crowd():
        async with aiohttp.ClientSession() as session:
            here = [await session.ws_connect(f"{endpoint}/ws/hello") for _ in range(60)]
            return [await asked(browser, "Hello") for browser in here]

    assert asyncio.run(crowd()) == [["World"]] * 60
    assert program.stop() == 0
    assert "Traceback" not in program.output


@each_way
@pytest.mark.parametrize(
    "kind", [kind if kind == "python" else pytest.param(kind, marks=pytest.mark.long) for kind in CLIENTS]
)
def test_a_full_gateway_is_not_a_wrong_token(kind, socketio_too, start, client_command):
    """Whoever has the right token would look for the mistake there."""
    code = "from netmq_example.web import door; door.MOST_BROWSERS = 0; import server; server.main()"
    program = start(PYTHON, "-c", code, "--endpoint", "http://127.0.0.1:0", PYTHONPATH=PATH)
    endpoint = program.wait_for(r"^listening on (\S+)")[1]
    client = start(*client_command(kind, KEY, endpoint, "--timeout", "4", *by(kind, socketio_too)))
    assert client.wait() == 1
    assert f"no reply from {endpoint} within 4 s; is the server running? (" in client.output
    assert "token" not in client.output
    assert ("browsers are here already" if socketio_too else "503") in client.output, client.output


@pytest.mark.parametrize("words", [["--endpoint", f"http://{'a' * 70}:0"], ["--timeout", "0"]], ids=["host", "timeout"])
def test_wrong_words_of_the_gateway(words, start):
    program = start(PYTHON, FOLDER / "server.py", "--endpoint", "http://127.0.0.1:0", "--token", "x", *words)
    assert program.wait() == 2 and "Traceback" not in program.output


# A stranger in the place of the gateway


WRONG = ['[{"a":1}]', "[1]", "[1", "[undefined]", "[" * 5000, "[new Date(1)]", '[{"error":{"a":"\\u001b"}}]']
# Over Socket.IO the rest would be no acknowledgement.
WRONG_TEXT = [*WRONG, "{}", "null", "new Date(1)", '[["x"]]', "", b"\0"]


@pytest.fixture
def stranger():
    """(endpoint, asked): it answers each request with the next wrong word, and then as the gateway does."""
    asked, loop = [], asyncio.new_event_loop()

    async def talk(request):
        browser = web.WebSocketResponse()
        await browser.prepare(request)
        carried = "socket.io" in request.path
        if carried:
            hello = {"sid": "a", "upgrades": [], "pingInterval": 25000, "pingTimeout": 20000, "maxPayload": 1000000}
            await browser.send_str("0" + json.dumps(hello))
        async for message in browser:
            if carried and message.data.startswith("40"):
                await browser.send_str('40{"sid":"b"}')
                continue
            if carried and not message.data.startswith("42"):
                continue
            wrong = (WRONG if carried else WRONG_TEXT)[len(asked) :]
            asked.append(message.data)
            number = re.match("42([0-9]*)", message.data)[1] if carried else ""
            answer = wrong[0] if wrong else '["World"]'
            if isinstance(answer, bytes):
                await browser.send_bytes(answer)
            else:
                await browser.send_str(f"43{number}{answer}" if carried else answer)
        return browser

    async def serve():
        app = web.Application()
        app.router.add_get("/{path:.*}", talk)
        runner = web.AppRunner(app, access_log=None)
        await runner.setup()
        await web.TCPSite(runner, "127.0.0.1", 0).start()
        return runner.addresses[0][1]

    thread = threading.Thread(target=loop.run_forever, daemon=True)
    thread.start()
    port = asyncio.run_coroutine_threadsafe(serve(), loop).result(LIMIT)
    yield f"http://127.0.0.1:{port}", asked
    loop.call_soon_threadsafe(loop.stop)
    thread.join(LIMIT)


@each_way
@each_kind
def test_a_client_tries_again_whatever_answers_it(kind, socketio_too, stranger, start, client_command):
    endpoint, asked = stranger
    words = ["--count", "1", *PATIENT, *by(kind, socketio_too)]
    client = start(*client_command(kind, KEY, endpoint, *words))
    assert client.wait() == 0, client.output
    lines = [f"asking {endpoint}", "1: sent Hello, received World", "done: 1 replies"]
    assert client.lines == lines and len(asked) == len(WRONG if socketio_too else WRONG_TEXT) + 1
