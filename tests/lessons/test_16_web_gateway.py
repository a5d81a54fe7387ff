"""Lesson 16: both kinds of clients in three languages' programs, many browsers, and whom the door keeps out.

What a real browser makes of it is in tests/web.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import re
import struct
import threading
import time
from pathlib import Path

import pytest
import zmq
import zmq.asyncio

from tests.conftest import CLIENTS, PYTHON
from tests.programs import LIMIT, PATIENT, ROOT

aiohttp = pytest.importorskip("aiohttp", reason="lesson 16 needs aiohttp: pip install aiohttp")
socketio = pytest.importorskip("socketio", reason="lesson 16 needs python-socketio: pip install python-socketio")
from netmq_example.web.browser_socket import Listener, Requester  # noqa: E402
from netmq_example.web.door import Door  # noqa: E402
from netmq_example.web.requester import WebSocketRequester  # noqa: E402
from netmq_example.web.socketio_requester import SocketIORequester  # noqa: E402

KEY = "16_web_gateway"
HELLO, BACKGROUND, POSES = "01_request_reply", "04_background_client", "03_publish_subscribe"
# Nobody is there.
ABSENT = [word for name in ("--hello", "--background", "--poses") for word in (name, "tcp://127.0.0.1:1")]
each_kind = pytest.mark.parametrize("kind", CLIENTS)
each_way = pytest.mark.parametrize("socketio_too", [False, True], ids=["websocket", "socketio"])


def by(kind, socketio_too):
    """The words with which a client takes this way."""
    return (["--socketio", *(["true"] if kind == "unity" else [])]) if socketio_too else []


@pytest.fixture
def echo():
    """A server behind the gateway that sends back what it gets, whatever it is."""
    context = zmq.Context()
    socket = context.socket(zmq.REP)
    socket.linger = 0
    port = socket.bind_to_random_port("tcp://127.0.0.1")

    def serve():
        while True:
            try:
                socket.send_multipart(socket.recv_multipart())
            except zmq.ZMQError:
                return socket.close()

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    yield f"tcp://127.0.0.1:{port}"
    # It ends the wait of the thread, which closes the socket.
    context.term()
    thread.join(LIMIT)


def in_browser(endpoint, talk, name="hello", **how):
    """What an asynchronous function returns that is given a WebSocket."""

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


@each_way
@each_kind
def test_the_lines_of_lesson_01(kind, socketio_too, serve, start, client_command):
    gateway, endpoint = serve(KEY, "--token", "a&b ü", *ABSENT[2:])
    client = start(*client_command(kind, KEY, endpoint, "--token", "a&b ü", *PATIENT, *by(kind, socketio_too)))
    assert client.wait() == 0, client.output
    ten = [f"{i}: sent Hello, received World" for i in range(1, 11)]
    assert client.lines == [f"asking {endpoint}", *ten, "done: 10 replies"]
    gateway.wait_for("^browser 1 left$")
    assert gateway.lines[1:] == [f"browser 1 came by {'Socket.IO' if socketio_too else 'WebSocket'}", "browser 1 left"]


@each_way
@each_kind
def test_a_wrong_token(kind, socketio_too, serve, start, client_command):
    gateway, endpoint = serve(KEY, "--token", "secret", *ABSENT)
    client = start(*client_command(kind, KEY, endpoint, "--token", "guessed", *PATIENT, *by(kind, socketio_too)))
    assert client.wait() == 1, client.output
    why = f"gave up: {endpoint} does not let this client in: its token is missing or wrong"
    assert client.lines == [f"asking {endpoint}", why]
    assert len(gateway.lines) == 1


def goes_on(client, what):
    """Two seconds are the goal; on a busy machine the time is only printed."""
    seen, back = len(client.lines), time.monotonic()
    client.wait_for("received World$", start=seen)
    print(f"{time.monotonic() - back:.2f} s after the {what} was back the client goes on")


@each_way
@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_gateway_and_server_are_killed_and_the_client_goes_on(kind, socketio_too, serve, start, client_command):
    server, behind = serve(HELLO, "--delay", "0.01")
    gateway, endpoint = serve(KEY, "--hello", behind, *ABSENT[2:])
    words = ["--count", "150", "--timeout", "50", *by(kind, socketio_too)]
    client = start(*client_command(kind, KEY, endpoint, *words))
    client.wait_for("^30: ")
    gateway.kill()
    gateway, _ = serve(KEY, "--hello", behind, *ABSENT[2:], endpoint=endpoint)
    goes_on(client, "gateway")
    client.wait_for("^80: ")
    server.kill()
    serve(HELLO, endpoint=behind)
    goes_on(client, "server")
    assert client.wait() == 0, client.output
    assert client.lines[1:-1] == [f"{i}: sent Hello, received World" for i in range(1, 151)]
    # On the same connection: the socket behind it was replaced.
    assert "Traceback" not in gateway.output and gateway.output.count(" came by ") == 1


@pytest.mark.parametrize(
    ("browsers", "requests"), [(20, 50), pytest.param(100, 100, marks=pytest.mark.long)], ids=["20", "100"]
)
@each_way
def test_many_browsers_are_answered_once_each(browsers, requests, socketio_too, serve):
    """Lesson 04's server numbers what it has answered: what was asked twice it would count twice."""
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


def test_a_page_of_a_stranger_does_not_come_in(serve, start):
    gateway, endpoint = serve(KEY, "--origin", "https://mine.example", *ABSENT)
    port = endpoint.rpartition(":")[2]
    may = [None, endpoint, f"http://localhost:{port}", "https://mine.example"]
    may_not = [
        "null",
        "",
        "https://evil.example",
        f"https://127.0.0.1:{port}",
        "http://127.0.0.1:1",
        "https://mine.example.org",
    ]
    # A name of the stranger's that leads to this machine.
    may_not.append(f"http://evil.example:{port}")
    for origin in [*may, *may_not]:
        headers = {} if origin is None else {"Origin": origin}
        assert status(endpoint, headers=headers) == (101 if origin in may else 403), origin

    async def by_socket_io(origin):
        async with aiohttp.ClientSession() as session:
            where = f"{endpoint}/socket.io/?EIO=4&transport=polling"
            async with session.get(where, headers={} if origin is None else {"Origin": origin}) as reply:
                # Else the browser would not show the page of a stranger why, and it may be its reader's own.
                assert reply.status == 200 or reply.headers["Access-Control-Allow-Origin"] == "*"
                assert reply.status == 200 or "start with --origin" in await reply.text()
                return reply.status

    for origin in [*may, *may_not]:
        assert asyncio.run(by_socket_io(origin)) == (200 if origin in may else 403), origin
    why = "refused: the page of {!r} may not come in; if it is yours, start with --origin and its address"
    gateway.wait_for(re.escape(why.format(may_not[-1])))
    assert [line for line in gateway.lines if line.startswith("refused")] == [why.format(page) for page in may_not]
    for number in range(50):
        assert status(endpoint, headers={"Origin": f"http://{number}.example"}) == 403
    assert gateway.stop() == 0
    assert len([line for line in gateway.lines if line.startswith("refused")]) == 20, "a flood of lines"


def test_others_than_this_machine_need_a_token(start):
    server = [PYTHON, ROOT / "python" / KEY / "server.py", "--endpoint", "http://0.0.0.0:0"]
    refused = start(*server)
    assert refused.wait() == 1
    assert "everybody in the network could come in; give --token" in refused.lines[-1]
    with_token = start(*server, "--token", "secret")
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


@pytest.mark.parametrize("program", ["server", "client"])
@pytest.mark.parametrize("missing", ["aiohttp", "socketio"])
def test_a_python_without_what_it_needs_says_what_is_missing(program, missing, start, tmp_path):
    (tmp_path / f"{missing}.py").write_text(f"raise ImportError('No module named {missing}')", encoding="utf-8")
    ended = start(PYTHON, f"python/{KEY}/{program}.py", PYTHONPATH=str(tmp_path))
    assert ended.wait() == 1
    assert ended.lines[-1].startswith(f"No module named {missing}: this lesson needs aiohttp") and len(ended.lines) == 1


def test_a_server_with_keys_answers_a_gateway_that_has_them(serve, start, tmp_path):
    """Lesson 15's, and a gateway without keys is told in a line that nobody answers."""
    _, secure = serve("15_security", "--keys", str(tmp_path / "keys"))
    for words, answer in (["--keys", str(tmp_path / "keys"), *PATIENT], ["Hello alice"]), ([], None):
        _, endpoint = serve(KEY, *ABSENT[2:], "--hello", secure, *words)
        found = in_browser(endpoint, lambda browser: asked(browser, "Hello"))
        assert found == answer or (answer is None and found["error"].startswith(f"no reply from {secure}")), found
    lost = start(PYTHON, f"python/{KEY}/server.py", "--keys", str(tmp_path / "nothing"))
    assert lost.wait() == 2 and "keys.py makes keys" in lost.lines[-1], lost.output


async def made(kind, *words):
    return kind(*words)


@pytest.mark.parametrize(
    ("name", "attempt"),
    [
        ("context", lambda: Requester(None, "tcp://127.0.0.1:1", 1)),
        ("endpoint", lambda: Requester(zmq.asyncio.Context.instance(), "tcp://127.0.0.1:99999", 1)),
        ("timeout", lambda: Requester(zmq.asyncio.Context.instance(), "tcp://127.0.0.1:1", 0)),
        ("timeout", lambda: asyncio.run(made(Listener, zmq.asyncio.Context.instance(), "tcp://127.0.0.1:1", None))),
        ("origins", lambda: Door("http://localhost", "")),
        ("each origin", lambda: Door([""], "")),
        ("token", lambda: Door([], None)),
        ("endpoint", lambda: WebSocketRequester("tcp://127.0.0.1:5566", "hello")),
        ("endpoint", lambda: WebSocketRequester(None, "hello")),
        ("name", lambda: WebSocketRequester("http://127.0.0.1:5566", "")),
        ("token", lambda: WebSocketRequester("http://127.0.0.1:5566", "hello", token=0)),
        ("timeout", lambda: SocketIORequester("http://127.0.0.1:5566", "hello", timeout=float("nan"))),
        ("a text", lambda: asyncio.run(WebSocketRequester("http://127.0.0.1:1", "hello").request(None))),
    ],
)
def test_what_cannot_be_is_named_at_once(name, attempt):
    with pytest.raises((TypeError, ValueError), match=rf"^(bad )?{name}\b.*$"):
        attempt()


def test_bytes_and_texts_in_several_frames(serve, echo):
    """A picture of 1.5 MB both ways, and what text can be."""
    _, endpoint = serve(KEY, "--hello", echo, *ABSENT[2:], *PATIENT)
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


def test_what_a_stranger_sends_is_answered_with_an_error_and_no_more(serve):
    gateway, endpoint = serve(KEY, *PATIENT)

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

    async def noise():
        async with aiohttp.ClientSession() as session:
            where = f"{endpoint}/socket.io/?EIO=4&transport=polling"
            async with session.get(where) as reply:
                sid = json.loads((await reply.text())[1:])["sid"]
            for data in (
                "",
                "nonsense",
                "40",
                "42",
                '42["hello"',
                "451-[",
                '421["hello",{"_placeholder":true,"num":7}]',
            ):
                async with session.post(f"{where}&sid={sid}", data=data) as reply:
                    await reply.text()

    asyncio.run(noise())
    assert in_browser(endpoint, lambda browser: asked(browser, "Hello")) == ["World"]
    assert gateway.stop() == 0
    assert "Traceback" not in gateway.output and len(gateway.lines) < 20, gateway.output


def test_only_the_newest_of_a_topic(serve, context):
    """A browser that asks late gets what was said last, and not what has piled up."""
    with context.socket(zmq.XPUB) as publisher:
        publisher.linger, publisher.sndhwm, publisher.rcvtimeo = 0, 0, int(1000 * LIMIT)
        port = publisher.bind_to_random_port("tcp://127.0.0.1")
        _, endpoint = serve(KEY, "--poses", f"tcp://127.0.0.1:{port}", *ABSENT[:4])

        async def talk(browser):
            assert await asked(browser, "a/") == [], "nothing new yet"
            assert publisher.recv() == b"\x01a/"
            for number in range(5000):
                publisher.send_string(f"a/ {number}")
                publisher.send_string(f"b/ {number}")
            heard = []
            while heard[-1:] != ["a/ 4999"]:
                heard += await asked(browser, "a/")
            assert len(heard) < 500
            numbers = [int(text[3:]) for text in heard]
            assert numbers == sorted(set(numbers))
            # Another topic, on the same WebSocket; of the one before comes no more.
            assert await asked(browser, "b/") == []
            while publisher.recv() != b"\x01b/":
                pass
            publisher.send_string("a/ no")
            publisher.send_string("b/ yes")
            for _ in range(60):
                if heard := await asked(browser, "b/"):
                    break
            assert heard == ["b/ yes"]

        in_browser(endpoint, talk, name="poses")


def test_a_slow_browser_is_let_go_and_holds_up_nobody(serve, echo):
    gateway, endpoint = serve(KEY, "--hello", echo, *ABSENT[2:], *PATIENT)

    async def talk(slow):
        slow._response.connection.protocol.pause_reading()

        async def flood():
            for _ in range(30):
                await slow.send_bytes(struct.pack("<I", 1 << 20) + bytes(1 << 20))

        flooding = asyncio.create_task(flood())
        before = memory(gateway)
        async with aiohttp.ClientSession() as session, session.ws_connect(f"{endpoint}/ws/hello") as other:
            while not gateway.output.count("let a browser go"):
                assert await asked(other, "still there?") == ["still there?"]
                await asyncio.sleep(0.05)
        assert memory(gateway) - before < 64 * 1024, "what it does not take must not pile up"
        flooding.cancel()

    in_browser(endpoint, talk)


def memory(program):
    """KiB that it has at this moment."""
    return int(re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{program.process.pid}/status").read_text())[1])


@each_way
def test_nothing_is_left_of_a_browser_that_has_gone(socketio_too, serve, echo):
    gateway, endpoint = serve(KEY, "--hello", echo, *ABSENT[2:], *PATIENT)
    folder = Path(f"/proc/{gateway.process.pid}/fd")
    if not folder.exists():
        pytest.skip("counts what is open in /proc")

    async def come_and_go():
        if not socketio_too:
            async with aiohttp.ClientSession() as session, session.ws_connect(f"{endpoint}/ws/hello") as browser:
                assert await asked(browser, "x") == ["x"]
                return
        client = socketio.AsyncClient()
        await client.connect(endpoint, transports=["websocket"], wait_timeout=LIMIT)
        assert await client.call("hello", "x", timeout=LIMIT) == "x"
        await client.disconnect()

    asyncio.run(come_and_go())
    gateway.wait_for("^browser 1 left$")
    before = len(list(folder.iterdir()))
    for _ in range(20):
        asyncio.run(come_and_go())
    gateway.wait_for("^browser 21 left$")
    deadline = time.monotonic() + LIMIT
    while len(list(folder.iterdir())) > before + 3:
        assert time.monotonic() < deadline, "sockets are left"
        time.sleep(0.05)
