"""Lesson 16's picture in a real browser: the tap's page, live and as a recording."""

import asyncio
import contextlib
import json
import re
import signal
import socket
import threading
import time
from urllib.request import urlopen

import pytest
import zmq

from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, finds_processes

pytest.importorskip("aiohttp", reason="the tap needs aiohttp: pip install aiohttp")
from netmq_example.tap.arrows import Arrows
from netmq_example.tap.page import Page
from netmq_example.tap.passing import Faults
from tests.lessons.test_16_web_gateway_tap import tapped

# One browser for all, and pages that need the processor for themselves.
pytestmark = pytest.mark.xdist_group("chromium")
ARROWS = "[...document.querySelectorAll('.arrow')]"
TEXTS = f"{ARROWS}.map(each => [each.classList[1], each.querySelector('b').textContent])"


@pytest.fixture
def tap():
    """tap(zmq.REP, zmq.REQ, "title"): two sockets with a tap of this process between them, and its page's address."""
    with contextlib.ExitStack() as stack:
        context = stack.enter_context(zmq.Context())

        def tap(behind, front, title="here"):
            server, client = (stack.enter_context(context.socket(kind)) for kind in (behind, front))
            for each in (server, client):
                each.linger = each.sndhwm = each.rcvhwm = 0
                each.rcvtimeo = int(1000 * LIMIT)
            arrows, faults = Arrows(), Faults()
            place = f"tcp://127.0.0.1:{server.bind_to_random_port('tcp://127.0.0.1')}"
            client.connect(stack.enter_context(tapped(place, arrows, faults)))
            return server, client, stack.enter_context(shown(Page(arrows, faults, title)))

        yield tap


@contextlib.contextmanager
def shown(page):
    """A tap's page, served by a thread: its address."""
    listener, loop = socket.create_server(("127.0.0.1", 0)), asyncio.new_event_loop()
    serving = loop.create_task(page.serve(listener))

    def serve():
        with contextlib.suppress(asyncio.CancelledError):
            loop.run_until_complete(serving)

    thread = threading.Thread(target=serve)
    thread.start()
    yield f"http://127.0.0.1:{listener.getsockname()[1]}/"
    loop.call_soon_threadsafe(serving.cancel)
    thread.join(LIMIT)


def test_each_message_is_an_arrow_and_one_is_dropped_as_the_page_asks(tap, open_page):
    server, client, page = tap(zmq.REP, zmq.REQ, "Lesson 01 <b>")
    client.req_relaxed = client.req_correlate = True

    def ask(text, reply, lost=False):
        client.send(text)
        assert server.recv() == text
        server.send(reply)
        assert lost or client.recv() == reply

    seen = open_page(page)
    for _ in range(2):
        ask(b"Hello", b"World")
    seen.wait_for(f"{ARROWS}.length === 4")
    assert [text.split(" · ")[-1] for _, text in seen.evaluate(TEXTS)] == ["Hello", "World"] * 2
    assert seen.text("#rows").startswith("connection 1 opened: REQ to REP")
    assert seen.text("h1") == seen.evaluate("document.title") == "Lesson 01 <b>"
    seen.wait_for("document.querySelector('#left').innerText === 'All 4 are drawn.'")
    # As a screen reader has it.
    said = seen.evaluate(f"{ARROWS}[1].getAttribute('aria-label')")
    assert re.fullmatch(r"\d+\.\d{3} s, to the client, .*World, \d+ B, connection 1", said)
    seen.wait_for("document.querySelector('#trips').innerText.includes('of 2 that were drawn')")
    seen.evaluate("document.querySelector('#way').value = 'down'")
    seen.click("[data-fault=drop]")
    seen.wait_for("document.querySelector('[data-fault=drop]').getAttribute('aria-pressed') === 'true'")
    ask(b"again", b"World", lost=True)
    seen.wait_for(f"{ARROWS}.length === 6")
    ask(b"and again", b"World")
    seen.wait_for(f"{ARROWS}.length === 8")
    classes = seen.evaluate(f"{ARROWS}.map(each => each.className.trim())")
    assert classes[4:] == ["arrow up", "arrow down drop", "arrow up", "arrow down"]
    assert "dropped" in seen.text(".drop .label")
    assert seen.evaluate("document.querySelector('[data-fault=drop]').getAttribute('aria-pressed')") == "false"
    assert seen.errors == seen.said == []


def test_ten_thousand_messages_a_second(tap, open_page):
    """Paced, since a publisher as fast as it can only shows that the subscriber is slower."""
    publisher, listener, page = tap(zmq.PUB, zmq.SUB)
    listener.subscribe(b"")
    seen = open_page(page)
    seen.wait_for(f"{ARROWS}.length === 1")
    for number in range(10_000):
        publisher.send(b"number %d " % number + b"x" * 100)
        if number % 1000 == 999:
            time.sleep(0.1)
    publisher.send(b"the last")
    for _ in range(10_001):
        last = listener.recv()
    assert last == b"the last"
    # The newest is drawn, and all others are drawn or said to be left out.
    seen.wait_for(f"{ARROWS}.at(-1).innerText.includes('the last')")
    seen.wait_for("/of 10,00[12] were left out/.test(document.querySelector('#left').innerText)")
    said = int(seen.text("#left").split(" of ")[0].replace(",", ""))
    assert 5_000 < said < 10_000
    seen.wait_for("/messages were left out/.test(document.querySelector('#spoken').textContent)")
    rows = seen.evaluate("[...document.querySelectorAll('li')].map(each => each.innerText)")
    assert len(rows) <= 250
    # A message is followed by the next one, or it is said how many are missing.
    following = None
    for row in rows:
        if found := re.search(r"number (\d+) ", row):
            assert following in (None, int(found[1]))
            following = int(found[1]) + 1
        elif following and (found := re.match(r"([\d,]+) more, left out", row)):
            following += int(found[1].replace(",", ""))
    assert following > 9_000
    assert seen.memory() < 100_000_000
    assert seen.errors == []


PICTURE = b"".join(bytes([x, y, 7]) for y in range(40) for x in range(60))
HEADER = {"kind": "frame", "version": 1, "id": 5, "values": {"bottom_up": True, "text": "</script><img src=x>"}}


@pytest.fixture
def opened(tap):
    """A text, a picture with a hostile header, and raw bytes have passed a tap: (page, send)."""
    router, dealer, page = tap(zmq.ROUTER, zmq.DEALER)

    def send(*frames):
        dealer.send_multipart(frames)
        assert router.recv_multipart()[1:] == [*frames]

    header = {**HEADER, "arrays": [{"dtype": "uint8", "shape": [40, 60, 3]}]}
    send(b"7", b"</script><b>text")
    send(json.dumps(header).encode(), PICTURE)
    send(b"\x00\xfe\xff")
    return page, send


def test_an_arrow_opens_by_the_keyboard_as_what_it_is(opened, open_page):
    page, _ = opened
    seen = open_page(page)
    seen.wait_for(f"{ARROWS}.length === 3")
    seen.evaluate(f"{ARROWS}[0].focus()")
    seen.press("Enter")
    seen.wait_for("document.querySelectorAll('.inside pre').length === 2")
    assert seen.evaluate("[...document.querySelectorAll('.inside pre')].map(each => each.innerText)") == [
        "7",
        "</script><b>text",
    ]
    seen.press("Escape")
    seen.wait_for("!document.querySelector('.inside')")
    seen.press("ArrowDown")
    seen.press("Enter")
    # The whole picture is fetched: the first pixel of the lowest row is that of the array.
    seen.wait_for("!!document.querySelector('.inside canvas')")
    pixel = "(x, y) => [...document.querySelector('.inside canvas').getContext('2d').getImageData(x, y, 1, 1).data]"
    assert seen.evaluate(f"({pixel})(0, 39)") == [0, 0, 7, 255]
    assert seen.evaluate(f"({pixel})(59, 0)") == [59, 39, 7, 255]
    assert '"bottom_up": true' in seen.text(".inside pre")
    assert seen.evaluate("document.querySelector('#newest canvas').width") == 60
    seen.evaluate("[...document.querySelectorAll('.inside button')].find(each => each.innerText === 'hex').click()")
    assert seen.text(".inside pre").startswith("0000  7b 22 6b 69 6e 64 22 3a 20 22 66 72")
    seen.press("ArrowDown")
    seen.press("Enter")
    seen.wait_for("document.querySelectorAll('.inside').length === 2")
    assert "00 fe ff" in seen.evaluate("[...document.querySelectorAll('.inside')].at(-1).innerText")
    assert seen.errors == []


def test_a_saved_recording_plays_without_a_server(opened, tmp_path, open_page):
    page, _ = opened
    file = tmp_path / "recording.html"
    with urlopen(f"{page}recording.html", timeout=20) as answer:
        file.write_bytes(answer.read())
    seen = open_page(file.as_uri())
    seen.wait_for("document.querySelector('#pause').innerText === 'Play'")
    # They are drawn with the next picture of the browser.
    seen.wait_for(f"{ARROWS}.length === 3")
    assert seen.evaluate(TEXTS)[0] == ["up", "7 · </script><b>text"]
    assert seen.text("#state") == "a recording"
    seen.evaluate(f"{ARROWS}[1].click()")
    seen.wait_for("!!document.querySelector('.inside canvas')")
    # Back to before the second message, and again.
    seen.evaluate(
        "document.querySelector('#place').value = 2; document.querySelector('#place').dispatchEvent(new Event('input'))"
    )
    assert len(seen.evaluate(TEXTS)) == 1
    seen.click("#again")
    seen.wait_for(f"{ARROWS}.length === 3")
    assert seen.errors == seen.said == []


ODD_ARRAYS = [
    5,
    [None],
    *([each] for each in ({"shape": 5}, {"dtype": "uint8"}, {"dtype": "constructor", "shape": [2, 3]})),
]
HOSTILE: list[dict[str, object]] = [
    *({"arrays": arrays} for arrays in (*ODD_ARRAYS, [{"dtype": "uint8", "shape": ["a", None, 3]}])),
    {"values": {"a": {"toString": 1}}},
    {"id": {"toString": 1}},
]


def test_a_header_of_any_shape_hides_no_other_message(opened, open_page):
    page, send = opened
    for header in HOSTILE:
        send(json.dumps({"kind": "x", **header}).encode(), b"abcdef")
    seen = open_page(page)
    seen.wait_for(f"{ARROWS}.length === {3 + len(HOSTILE)}")
    seen.evaluate(f"{ARROWS}.slice(3).forEach(arrow => arrow.click())")
    seen.wait_for(f"document.querySelectorAll('.frame').length === {2 * len(HOSTILE)}")
    assert seen.errors == seen.said == []


@finds_processes
def test_run_watch_opens_the_page_and_then_starts_the_client(start, tmp_path, open_page):
    """BROWSER names the program that opens a page: here one that leaves the address in a file."""
    address = tmp_path / "address"
    browser = f"'{PYTHON}' -c \"import sys; open(r'{address}', 'w').write(sys.argv[1])\" %s"
    words = ["run", "1", "--client", "python", "--watch", "--folder", tmp_path, "--options=--count 2"]
    kit = start(PYTHON, ROOT / "kit.py", *words, BROWSER=browser)
    page = kit.wait_for(r"^tap +\| page at (\S+)")[1]
    kit.wait_for(r"^tap +\| listening on")
    seen = open_page(page)
    kit.wait_for("^kit +. the page stays until Ctrl-C")
    speakers = [line.partition("|")[0].strip() for line in kit.lines]
    assert speakers.index("client") > kit.lines.index("tap    | a page looks on")
    assert "client | done: 2 replies" in kit.lines
    assert address.read_text() == page
    seen.wait_for(f"{ARROWS}.length === 4")
    assert seen.text("h1") == "Lesson 01: request reply"
    assert kit.stop(signal.SIGINT) == 0, kit.output
    seen.wait_for("document.querySelector('#state').innerText === 'the tap has ended'")
    assert seen.evaluate("document.querySelector('#state').getAttribute('role')") == "status"
    assert seen.evaluate("document.querySelector('[data-fault=cut]').disabled")
    assert seen.evaluate(TEXTS) == [["up", "Hello"], ["down", "World"]] * 2
