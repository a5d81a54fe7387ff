"""Lesson 16: both kinds of clients in three languages' programs, many browsers, and strangers on either side.

tests/web shows what a real browser makes of it.
"""

import asyncio
import contextlib
import json
import os
import re
import socket
import struct
import threading
import time
from pathlib import Path

import pytest
import zmq
import zmq.asyncio

from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import answering, bind
from tests.programs import LIMIT, PATIENT, ROOT, Program, steady_endpoint

aiohttp = pytest.importorskip("aiohttp", reason="lesson 16 needs aiohttp: kit.py run 16 installs it")
web = pytest.importorskip("aiohttp.web")
socketio = pytest.importorskip("socketio", reason="lesson 16 needs python-socketio: kit.py run 16 installs it")

KEY = "16_web_gateway"
FOLDER = ROOT / "python" / KEY
# For a program that changes a number of the package before it runs server.py.
PATH = os.pathsep.join([str(FOLDER), str(FOLDER.parent)])
HELLO, BACKGROUND = "01_request_reply", "04_background_client"
# Nobody is there.
ABSENT = [word for name in ("--hello", "--background", "--poses") for word in (name, "tcp://127.0.0.1:1")]
each_kind = pytest.mark.parametrize("kind", CLIENTS)
each_way = pytest.mark.parametrize("socketio_too", [False, True], ids=["websocket", "socketio"])


def by(kind, socketio_too):
    """The words with which a client takes this way."""
    return (["--socketio", *(["true"] if kind == "unity" else [])]) if socketio_too else []


@pytest.fixture(scope="module")
def echo():
    """A server behind the gateway that sends back what it gets, whatever it is; of Hello it makes World."""

    def answer(frames):
        return [b"World"] if frames == [b"Hello"] else frames

    with zmq.Context() as context, answering(context, answer) as endpoint:
        yield endpoint


@contextlib.contextmanager
def opened(*words, change=""):
    """A gateway: its program and its endpoint. It may change a number of the package; strangers make it no noise."""
    changed = f"from netmq_example.web import door; {change}; import server; server.run(server.main)"
    command = ["-c", changed] if change else [str(FOLDER / "server.py")]
    program = Program([PYTHON, *command, "--endpoint", "http://127.0.0.1:0", *PATIENT, *words], PYTHONPATH=PATH)
    try:
        yield program, program.wait_for(r"^listening on (\S+)")[1]
        assert program.process.poll() is not None or program.stop() == 0
        assert "Traceback" not in program.output and "Error" not in program.output, program.output
    finally:
        program.kill()


@pytest.fixture(scope="module")
def gateway(echo):
    """One for many tests: its program, and its endpoint."""
    with opened("--hello", echo, *ABSENT[2:]) as both:
        yield both


@pytest.fixture(scope="module")
def door(echo):
    """One that wants a token, and one that takes nobody: their programs and endpoints."""
    with (
        opened("--hello", echo, "--token", "a&b ü", *ABSENT[2:]) as with_token,
        opened(*ABSENT, change="door.MOST_BROWSERS = 0") as full,
    ):
        yield with_token, full


def in_browser(endpoint, talk, name="hello", **how):
    """The function is given a WebSocket, and its result is returned."""

    async def run():
        address = f"{endpoint}/ws/{name}"
        async with aiohttp.ClientSession() as session, session.ws_connect(address, max_msg_size=0, **how) as browser:
            return await talk(browser)

    return asyncio.run(run())


async def asked(browser, *frames):
    await browser.send_str(json.dumps(frames))
    return await browser.receive_json(timeout=LIMIT)


def status(endpoint, **how):
    """How a WebSocket is received: 101, or why not."""

    async def nothing(browser):
        return 101

    try:
        return in_browser(endpoint, nothing, **how)
    except aiohttp.WSServerHandshakeError as error:
        return error.status


def by_socketio(endpoint, talk, auth="40"):
    """The same as in_browser, with a connection of Socket.IO, by hand; its first word may be another."""

    async def run():
        address = f"{endpoint}/socket.io/?EIO=4&transport=websocket"
        async with aiohttp.ClientSession() as session, session.ws_connect(address) as browser:
            await browser.receive_str(timeout=LIMIT)
            await browser.send_str(auth)
            return await talk(browser, await browser.receive_str(timeout=LIMIT))

    return asyncio.run(run())


@each_kind
def test_the_lines_of_lesson_01_and_who_is_not_let_in(kind, door, runs):
    (gateway, endpoint), (_, full) = door
    begin = len(gateway.lines)
    table = [
        (endpoint, ["--token", "a&b ü", *PATIENT, "--count", "3"]),
        (endpoint, ["--token", "guessed", *PATIENT]),
        (full, ["--timeout", "4"]),
    ]
    # Unity's client is the terminal's, and need not wait as well.
    words = [
        ["--endpoint", place, *words, *by(kind, socketio_too)]
        for place, words in table[: 2 if kind == "unity" else 3]
        for socketio_too in (False, True)
    ]
    found = runs(kind, KEY, words)
    three = [f"{i}: sent Hello, received World" for i in range(1, 4)]
    assert found[:2] == [(0, [f"asking {endpoint}", *three, "done: 3 replies"])] * 2
    why = f"gave up: {endpoint} does not let this client in: its token is missing or wrong"
    for run in found[2:4]:
        assert run.code == 1 and [line for line in run.lines if not line.startswith("   ")][:2] == [
            f"asking {endpoint}",
            ("error: " if kind == "unity" and "error: " + why in run.lines else "") + why,
        ]
    for run, said in zip(found[4:], ("503", "browsers are here already"), strict=False):
        # A user with the right token would look for the mistake there.
        text = "\n".join(run.lines)
        assert run.code == 1 and "token" not in text
        assert f"no reply from {full} within 4 s; is the server running? (" in text and said in text
    for line in "came by WebSocket", "came by Socket.IO":
        number = gateway.wait_for(rf"^browser (\d+) {line}$", start=begin)[1]
        gateway.wait_for(f"^browser {number} left$", start=begin)
    assert len(gateway.lines) == begin + 4


def test_gateway_and_server_are_killed_and_the_clients_go_on(serve, start_client):
    behind = steady_endpoint()
    words = ["--hello", behind, *ABSENT[2:]]
    gateway, endpoint = serve(KEY, *words)
    clients = [
        start_client(kind, KEY, endpoint, "--count", "20", "--timeout", "600", *by(kind, socketio_too))
        for kind in ("python", "csharp")
        for socketio_too in (False, True)
    ]
    gateway.wait_for("^browser 4 came ")
    # What is under way is asked again.
    gateway.kill()
    server, _ = serve(HELLO, "--delay", "0.05", endpoint=behind)
    gateway, _ = serve(KEY, *words, endpoint=endpoint)
    for client in clients:
        client.wait_for("^3: ")
    server.kill()
    serve(HELLO, endpoint=behind)
    for client in clients:
        assert client.wait() == 0, client.output
        assert client.lines[1:-1] == [f"{i}: sent Hello, received World" for i in range(1, 21)]
    # On the same connection: the socket behind it was replaced.
    assert "Traceback" not in gateway.output and gateway.output.count(" came by ") == 4


@each_way
def test_many_browsers_are_answered_once_each(socketio_too, serve):
    """Lesson 04's server numbers what it has answered: what was asked twice it would count twice."""
    browsers, requests = 8, 12
    server, behind = serve(BACKGROUND)
    gateway, endpoint = serve(KEY, "--background", behind, *ABSENT[:2], *ABSENT[4:], *PATIENT)

    async def one(session, number):
        pairs = [(f"{number}-{i}", f"{number} says {i}") for i in range(requests)]
        if not socketio_too:
            async with session.ws_connect(f"{endpoint}/ws/background") as browser:
                # All at once: the gateway reads the next when the one before is answered.
                for name, text in pairs:
                    await browser.send_str(json.dumps([name, f"echo {text}"]))
                replies = [await browser.receive_json(timeout=LIMIT) for _ in pairs]
        else:
            client = socketio.AsyncClient()
            await client.connect(endpoint, transports=["websocket"], wait_timeout=LIMIT)
            replies = [await client.call("background", (name, f"echo {text}"), timeout=LIMIT) for name, text in pairs]
            await client.disconnect()
        assert [tuple(reply) for reply in replies] == pairs

    async def all_of_them():
        async with aiohttp.ClientSession() as session:
            await asyncio.gather(*(one(session, number) for number in range(browsers)))

    asyncio.run(all_of_them())
    server.wait_for(f"^{browsers * requests}: sent ")
    gateway.wait_for(rf"^browser {browsers} came ")
    assert not [line for line in server.lines if line.startswith(f"{browsers * requests + 1}: ")]


def test_a_page_of_a_stranger_does_not_come_in(serve):
    gateway, endpoint = serve(KEY, "--origin", "https://mine.example", *ABSENT)
    port = endpoint.rpartition(":")[2]
    may = [None, endpoint, f"http://localhost:{port}", "https://mine.example"]
    may_not = ["null", "", "https://evil.example", f"https://127.0.0.1:{port}", "http://127.0.0.1:1"]
    # The second is a stranger's name that leads to this machine.
    may_not += ["https://mine.example.org", f"http://evil.example:{port}"]

    async def polled(headers):
        where = f"{endpoint}/socket.io/?EIO=4&transport=polling"
        async with aiohttp.ClientSession() as session, session.get(where, headers=headers) as reply:
            # Else the browser would not show the page of a stranger why, and it may be its reader's own.
            assert reply.status == 200 or reply.headers["Access-Control-Allow-Origin"] == "*"
            return reply.status

    async def own_page():
        async with aiohttp.ClientSession() as session, session.get(endpoint) as reply:
            return reply.headers["Content-Security-Policy"]

    assert asyncio.run(own_page()) == "frame-ancestors 'none'", "in a frame its clicks could be stolen"
    for origin in [*may, *may_not]:
        headers = {} if origin is None else {"Origin": origin}
        assert status(endpoint, headers=headers) == (101 if origin in may else 403), origin
        assert asyncio.run(polled(headers)) == (200 if origin in may else 403), origin
    for number in range(20):
        assert status(endpoint, headers={"Origin": f"http://{number}.example"}) == 403
    assert gateway.stop() == 0
    why = "refused: the page of {!r} may not come in; if it is yours, start with --origin and its address"
    said = [line for line in gateway.lines if line.startswith("refused")]
    assert said[: len(may_not)] == [why.format(page) for page in may_not]
    assert len(said) == 20, "a flood of lines"


def test_a_name_that_is_too_long_and_keys_that_are_none_are_named(runs, tmp_path):
    long, none = runs(
        "server", KEY, [["--endpoint", f"http://{'a' * 70}:0", "--token", "x"], ["--keys", str(tmp_path)]]
    )
    assert long.code == none.code == 2
    assert "write it like http://127.0.0.1:5566" in long.lines[-1] and "keys.py makes keys" in none.lines[-1]


def test_others_than_this_machine_need_a_token(start):
    with_token = start(PYTHON, FOLDER / "server.py", "--endpoint", "http://0.0.0.0:0", "--token", "secret")
    port = with_token.wait_for(r"^listening on http://0\.0\.0\.0:(\d+)$")[1]
    assert status(f"http://127.0.0.1:{port}") == 403
    own = f"http://127.0.0.1:{port}"
    # Its own page comes by whatever name this machine has there.
    for host, page, code in [
        (f"127.0.0.1:{port}", own, 101),
        (f"my-machine:{port}", f"http://my-machine:{port}", 101),
        (f"my-machine:{port}", own, 403),
        (f"my-machine:{port}", "http://evil.example", 403),
    ]:
        assert status(own, params={"token": "secret"}, headers={"Host": host, "Origin": page}) == code, page


def test_a_server_with_keys_answers_a_gateway_that_has_them(serve, tmp_path):
    """Lesson 15's."""
    _, secure = serve("15_security", "--keys", str(tmp_path / "keys"))
    _, endpoint = serve(KEY, *ABSENT[2:], "--hello", secure, "--keys", str(tmp_path / "keys"), *PATIENT)
    assert in_browser(endpoint, lambda browser: asked(browser, "Hello")) == ["Hello alice"]


def test_bytes_and_texts_in_several_frames(gateway):
    """A picture of 1.5 MB both ways, and what text can be."""
    _, endpoint = gateway
    frames = [b"", bytes(range(256)) * 6000, b"\xff\xfe"]
    packed = b"".join(struct.pack("<I", len(frame)) + frame for frame in frames)

    async def talk(browser):
        await browser.send_bytes(packed)
        assert await browser.receive_bytes(timeout=LIMIT) == packed
        texts = ["", "äöü €\u2028\0", "\U0001f600", '"]', "2026-01-01T00:00:00Z"]
        assert await asked(browser, *texts) == texts
        assert await asked(browser, "half \ud800") == ["half ?"]
        # An error is text here as well, and then it goes on.
        await browser.send_bytes(packed[:-1])
        assert "a JSON list" in (await browser.receive_json())["error"]
        assert await asked(browser) == [""]

    in_browser(endpoint, talk)

    async def by_socket_io():
        client = socketio.AsyncClient()
        await client.connect(endpoint, transports=["websocket"], wait_timeout=LIMIT)
        assert await client.call("hello", (frames[1], "text"), timeout=LIMIT) == (frames[1], b"text")
        await client.disconnect()

    asyncio.run(by_socket_io())


STRANGE = ["", "Hello", "{}", '"Hello"', "[1]", '[["Hello"]]', "null", "[" * 100_000, '{"error": "x"}', '["Hello"']


def test_what_a_stranger_sends_is_answered_with_an_error_and_no_more(gateway):
    program, endpoint = gateway
    begin = len(program.lines)

    async def talk(browser):
        for text in STRANGE:
            await browser.send_str(text)
            assert list(await browser.receive_json(timeout=LIMIT)) == ["error"], text
        assert await asked(browser, "Hello") == ["World"]
        # Longer than it takes: its end, told where it can be, and nobody else's.
        with contextlib.suppress(ConnectionError, aiohttp.ClientError):
            await browser.send_bytes(bytes(5 * 1024 * 1024))
        ended = await browser.receive(timeout=LIMIT)
        assert ended.type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED, aiohttp.WSMsgType.ERROR)
        assert ended.type != aiohttp.WSMsgType.CLOSE or ended.data == aiohttp.WSCloseCode.MESSAGE_TOO_BIG

    in_browser(endpoint, talk)
    assert status(endpoint, name="etc") == 404
    assert in_browser(endpoint, lambda browser: asked(browser, "Hello")) == ["World"]
    assert len(program.lines) < begin + 20, program.output


def test_only_the_newest_of_a_topic(serve, context):
    """A browser that asks late gets what was said last, and not what has piled up."""
    with context.socket(zmq.XPUB) as publisher:
        publisher.sndhwm = 0
        _, endpoint = serve(KEY, "--poses", bind(publisher), *ABSENT[:4])

        async def talk(browser):
            assert await asked(browser, "a/") == [], "nothing new yet"
            assert publisher.recv() == b"\x01a/"
            for number in range(1000):
                publisher.send_string(f"a/ {number}")
                publisher.send_string(f"b/ {number}")
            heard = []
            while heard[-1:] != ["a/ 999"]:
                heard += await asked(browser, "a/")
            assert len(heard) < 300
            numbers = [int(text[3:]) for text in heard]
            assert numbers == sorted(set(numbers))

        in_browser(endpoint, talk, name="poses")


def test_a_slow_browser_is_let_go_and_holds_up_nobody(echo):
    async def talk(slow):
        protocol = slow._response.connection.protocol
        protocol.pause_reading()

        async def flood():
            for _ in range(30):
                await slow.send_bytes(struct.pack("<I", 1 << 20) + bytes(1 << 20))

        flooding = asyncio.create_task(flood())
        before = memory(program)
        async with aiohttp.ClientSession() as session, session.ws_connect(f"{endpoint}/ws/hello") as other:
            while not program.output.count("let a browser go: it does not"):
                assert await asked(other, "still there?") == ["still there?"]
                await asyncio.sleep(0.05)
        assert memory(program) - before < 64 * 1024, "what it does not take must not pile up"
        flooding.cancel()
        # Else it would wait ten seconds for the gateway's farewell.
        protocol.resume_reading()

    soon = "from netmq_example.web import websocket; websocket.SLOW_SECONDS = 2"
    with opened("--hello", echo, *ABSENT[2:], change=soon) as (program, endpoint):
        in_browser(endpoint, talk)


def memory(program):
    """KiB that it has at this moment."""
    return int(re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{program.process.pid}/status").read_text())[1])


def one_by_websocket(endpoint):
    assert in_browser(endpoint, lambda browser: asked(browser, "x")) == ["x"]


def one_by_socketio(endpoint):
    async def talk(browser, _):
        await browser.send_str('421["hello","x"]')
        assert await browser.receive_str(timeout=LIMIT) == '431["x"]'

    by_socketio(endpoint, talk)


def one_that_waits_for_answers(endpoint):
    async def talk(browser, _):
        for i in range(60):
            await browser.send_str(f'42{i}["background","Hello"]')
        await browser.send_str('4299["hello","Hello"]')
        assert await browser.receive_str(timeout=LIMIT) == '4399["World"]'

    by_socketio(endpoint, talk)


@pytest.mark.parametrize("come_and_go", [one_by_websocket, one_by_socketio, one_that_waits_for_answers])
def test_nothing_is_left_of_a_browser_that_has_gone(come_and_go, gateway):
    """The gateway has as many open files as after it was there once."""
    program, endpoint = gateway
    folder = Path(f"/proc/{program.process.pid}/fd")
    if not folder.exists():
        pytest.skip("counts what is open in /proc")

    def come_and_have_gone():
        begin = len(program.lines)
        come_and_go(endpoint)
        program.wait_for(r"^browser \d+ left$", start=begin)

    come_and_have_gone()
    before = len(list(folder.iterdir()))
    for _ in range(8):
        come_and_have_gone()
    deadline = time.monotonic() + LIMIT / 4
    while len(list(folder.iterdir())) > before + 3:
        assert time.monotonic() < deadline, "sockets that nobody closes"
        time.sleep(0.05)


# A stranger to the gateway


NOBODY = "behind the gateway there are hello, background, poses, pictures, no {!r}"
# Packets of a browser by Socket.IO, and the answer to an event with a number.
EVENTS = [
    *((f"42{event}", None) for event in ('["connect",{}]', '["connect"]', '["connect",1,2,3]')),
    *((f'42[{name},"Hello"]', None) for name in ('{"a":1}', '["a"]', '"*"')),
    *((f'427[{json.dumps(name)},"Hello"]', {"error": NOBODY.format(name)}) for name in ("nobody", 7, "")),
    ('427["hello","Hello"]', "World"),
]


def test_events_and_packets_that_are_none_make_no_noise(gateway):
    """A name that nobody has is answered, too: otherwise the server would seem to be slow."""
    program, endpoint = gateway
    begin = len(program.lines)

    async def talk(browser, _):
        for event, expected in EVENTS:
            await browser.send_str(event)
            if expected:
                assert json.loads((await browser.receive_str(timeout=LIMIT))[3:]) == [expected]
        # It says that it leaves, and asks once more.
        for packet in '42["disconnect"]', '422["hello","Hello"]':
            await browser.send_str(packet)
        assert await browser.receive_str(timeout=LIMIT) == "41"

    by_socketio(endpoint, talk)
    number = program.wait_for(r"^browser (\d+) came", start=begin)[1]
    program.wait_for(rf"^browser {number} left$", start=begin)
    assert len(program.lines) == begin + 2, program.output


def test_words_that_are_none_make_no_traceback(door):
    (_, endpoint), _ = door

    async def refused(_, said):
        assert "the token is missing or wrong" in said

    async def says_nothing(browser, said):
        assert said.startswith("40{")
        await browser.send_str("")
        while (await browser.receive(timeout=LIMIT)).type == aiohttp.WSMsgType.TEXT:
            pass

    # Half of a surrogate pair is no letter of UTF-8.
    by_socketio(endpoint, refused, '40{"token":"\\ud800"}')
    by_socketio(endpoint, says_nothing, '40{"token":"a&b ü"}')


def test_of_packets_by_the_thousand_in_one_request_none_is_looked_at(door):
    """They would keep all others waiting, and are read before anybody has asked for the token."""
    (_, endpoint), _ = door

    async def run():
        address = f"{endpoint}/socket.io/?EIO=4&transport=polling"
        async with aiohttp.ClientSession() as session:

            async def ask(method, **body):
                async with session.request(method, address, **body) as answer:
                    return await answer.text()

            address += "&sid=" + json.loads((await ask("GET"))[1:])["sid"]
            await ask("POST", data="\x1e".join(["40/nobody,"] * 5000))
            await ask("POST", data="40")
            return await ask("GET")

    said = asyncio.run(run())
    assert said.startswith('44{"message":"the token is missing') and "nobody" not in said


def test_a_million_frames_are_too_many(gateway):
    """Each is nothing, and all of them together would keep the server behind busy for seconds."""
    _, endpoint = gateway
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


def test_an_event_has_a_limit_however_many_bytes_follow_it(gateway):
    """Socket.IO has one for each of them alone."""
    program, endpoint = gateway
    before = memory(program)

    async def talk(browser, _):
        for number, (count, size) in enumerate([(50, 2**20), (2, 10)], 1):
            places = [{"_placeholder": True, "num": at} for at in range(count)]
            await browser.send_str(f"45{count}-{number}{json.dumps(['hello', *places])}")
            for _ in range(count):
                await browser.send_bytes(bytes(size))
            yes = f"46{count}-{number}" if size == 10 else f"43{number}"
            said = await browser.receive_str(timeout=LIMIT)
            assert said.startswith(yes)
            assert size == 10 or "more than 4194304 bytes; several requests take more" in said

    by_socketio(endpoint, talk)
    assert memory(program) < before + 25_000


def test_strangers_who_leave_without_reading_or_send_what_is_packed_fill_no_log(gateway):
    program, endpoint = gateway
    begin = len(program.lines)
    host, port = endpoint.removeprefix("http://").split(":")
    for _ in range(20):
        with socket.create_connection((host, int(port))) as stranger:
            # It closes hard, in the middle of what it has asked for.
            stranger.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            stranger.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n" * 200)
    with socket.create_connection((host, int(port))) as stranger:
        # These bytes are no gzip: whoever unpacks them says so.
        head = "POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Encoding: gzip\r\nContent-Length: 7\r\n\r\n"
        stranger.sendall(f"{head}no gzip".encode())
        assert stranger.recv(12) == b"HTTP/1.1 405"
    assert in_browser(endpoint, lambda browser: asked(browser, "Hello")) == ["World"]
    assert not [line for line in program.lines[begin:] if not line.startswith("browser ")]


def test_who_asks_nothing_is_let_go(echo):
    """Or asks half of something. A browser that has asked stays, silent as it is."""
    with opened("--hello", echo, "--token", "word", change="door.SILENT_SECONDS = 1.5") as (program, endpoint):
        polling = "/socket.io/?EIO=4&transport=polling"

        async def ends_of(said):
            reader, writer = await asyncio.open_connection(*endpoint.removeprefix("http://").split(":"))
            writer.write(said.encode())
            with contextlib.suppress(ConnectionError):
                # To its end, which comes when it is let go.
                await asyncio.wait_for(reader.read(), LIMIT)
            writer.close()

        async def talk(browser):
            async with aiohttp.ClientSession() as session:
                async with session.get(endpoint + polling) as opening:
                    name = json.loads((await opening.text())[1:])["sid"]
                body = f"POST {polling}&sid={name} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 10\r\n\r\n4"
                await asyncio.gather(*(ends_of(said) for said in ("", "GET / HTTP/1.1\r\nHos", body)))
                # Silent itself for as long.
                assert await asked(browser, "Hello") == ["World"]

        in_browser(endpoint, talk, params={"token": "word"})
        program.wait_for("^browser 1 left$")
    asked_nothing = [int(number) for number in re.findall(r"asked nothing within 1.5 s: (\d)$", program.output, re.M)]
    assert sum(asked_nothing) == 3


def test_a_flood_of_requests_holds_up_no_end(echo):
    async def talk(browser, _):
        with contextlib.suppress(ConnectionError):
            for i in range(1000):
                await browser.send_str(f'42{i}["background","Hello"]')
        await asyncio.to_thread(program.wait_for, "^browser 1 left$")
        # It is here still, and does not listen. Ten seconds are Socket.IO's own timeout.
        assert await asyncio.to_thread(program.stop, limit=8) == 0

    with opened("--hello", echo, *ABSENT[2:]) as (program, endpoint):
        by_socketio(endpoint, talk)
    assert program.lines[1:] == [
        "browser 1 came by Socket.IO",
        "let a browser go: 64 of its requests, or answers for it, wait",
        "browser 1 left",
    ]


# A stranger in the place of the gateway


WRONG = ['[{"a":1}]', "[1]", "[1", "[undefined]", "[" * 5000, "[new Date(1)]", '[{"error":{"a":"\\u001b"}}]']
# Over Socket.IO the rest would be no acknowledgement.
WRONG_TEXT = [*WRONG, "{}", "null", "new Date(1)", '[["x"]]', "", b"\0"]


@pytest.fixture
def stranger():
    """(endpoint, asked): it answers each request with the next wrong word, and then as the gateway does.

    `asked` has the requests by WebSocket, and those by Socket.IO.
    """
    asked, loop = ([], []), asyncio.new_event_loop()

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
            wrong = (WRONG if carried else WRONG_TEXT)[len(asked[carried]) :]
            asked[carried].append(message.data)
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


@each_kind
def test_a_client_tries_again_whatever_answers_it(kind, stranger, runs):
    endpoint, asked = stranger
    words = [
        ["--endpoint", endpoint, "--count", "1", *PATIENT, *by(kind, socketio_too)] for socketio_too in (False, True)
    ]
    lines = [f"asking {endpoint}", "1: sent Hello, received World", "done: 1 replies"]
    assert runs(kind, KEY, words) == [(0, lines)] * 2
    assert (len(asked[0]), len(asked[1])) == (len(WRONG_TEXT) + 1, len(WRONG) + 1)
