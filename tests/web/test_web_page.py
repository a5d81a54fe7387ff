"""Lesson 16 in a real browser: the gateway's page, pages of strangers, and the WebGL half of its C# client."""

import base64
import functools
import http.server
import json
import re

import pytest
import zmq

from kitlib.lessons import Lesson
from kitlib.setup import dotnet
from tests.bad_peers import web_server
from tests.conftest import PYTHON
from tests.lessons.test_16_web_gateway import opened
from tests.programs import PATIENT, ROOT, Program

# One browser for all.
pytestmark = pytest.mark.xdist_group("chromium")
KEY = "16_web_gateway"
POSE = "document.querySelector('#pose').innerText"
NEWEST = "document.querySelector('#replies li')?.innerText"


def state(name):
    return f"document.querySelector('#{name}-state').innerText"


def say(page, form, text):
    """By keyboard: into the field, and Enter."""
    page.evaluate(f"document.querySelector('#{form}-text').select()")
    page.type(text)
    page.press("Enter")


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory):
    """A web server of a stranger: its address."""
    folder = tmp_path_factory.mktemp("elsewhere")
    with web_server(functools.partial(Quiet, directory=folder)) as port:
        (folder / "index.html").write_text("<!doctype html><title>a stranger's page</title>")
        yield f"http://127.0.0.1:{port}"


@pytest.fixture(scope="module")
def camera():
    """A publisher of pictures, and where it is."""
    with zmq.Context() as context, context.socket(zmq.PUB) as publisher:
        publisher.linger = 0
        yield publisher, f"tcp://127.0.0.1:{publisher.bind_to_random_port('tcp://127.0.0.1')}"


@pytest.fixture(scope="module")
def behind(camera):
    """The words for a gateway in front of a server of each lesson."""
    words, programs = ["--pictures", camera[1]], []
    try:
        for name, key in Lesson(KEY).behind:
            programs.append(
                Program([PYTHON, ROOT / "python" / key.key / "server.py", "--endpoint", "tcp://127.0.0.1:0"])
            )
            words += [name, programs[-1].wait_for(r"^listening on (\S+)")[1]]
        yield words
    finally:
        for program in programs:
            program.kill()


@pytest.fixture(scope="module")
def gateway(behind):
    with opened(*behind) as (_, endpoint):
        yield endpoint


def test_the_page_asks_and_listens(gateway, open_page):
    page = open_page(gateway)
    page.wait_for(f"{state('hello')} === 'connected'")
    say(page, "hello", "Hello")
    page.wait_for(f"{NEWEST} === 'sent Hello, received World'")
    say(page, "background", "echo äöü €")
    page.wait_for(f"{NEWEST} === 'sent echo äöü €, received äöü €'")
    say(page, "hello", "Goodbye")
    page.wait_for(f"{NEWEST}?.includes('error: expected Hello')")
    first = page.wait_for(f"/^pose [0-9]+: x/.test({POSE}) && {POSE}")
    page.wait_for(f"{POSE} !== {json.dumps(first)}")
    drawn = "document.querySelector('#cube').getContext('2d').getImageData(0, 0, 320, 200).data.some(value => value)"
    assert page.evaluate(drawn)
    assert page.errors == [] and page.said == []


def test_the_page_shows_pictures_in_their_own_colours(gateway, camera, open_page, tmp_path):
    """Those of lesson 08's bridge to LeRobot, in which red and blue have changed places."""
    image = pytest.importorskip("PIL.Image", reason="lesson 08's pictures need Pillow: pip install pillow")
    image.new("RGB", (64, 48), (0, 0, 255)).save(tmp_path / "red.jpg")
    text = json.dumps({"images": {"center": base64.b64encode((tmp_path / "red.jpg").read_bytes()).decode()}})
    page = open_page(gateway)
    seen = "document.querySelector('#picture').naturalWidth"
    while page.evaluate(seen) != 64:
        camera[0].send_string(text)
    assert "feColorMatrix" in page.evaluate("document.querySelector('#red-and-blue').innerHTML")
    page.evaluate("document.querySelector('#picture').scrollIntoView()")
    page.picture(tmp_path / "page.png")
    colours = image.open(tmp_path / "page.png").convert("RGB").getcolors(1 << 24)
    red = sum(count for count, (r, g, b) in colours if r > 200 and g < 60 and b < 60)
    assert red > 10_000, "no red picture on the page"


def test_a_server_and_a_gateway_that_are_killed_and_a_page_from_elsewhere_that_may_come_in(
    serve, behind, open_page, elsewhere
):
    server, hello = serve("01_request_reply")
    words = [*behind, "--hello", hello, "--origin", elsewhere]
    gateway, endpoint = serve(KEY, *words)
    page = open_page(endpoint)
    page.wait_for(f"{state('hello')} === 'connected' && {POSE}")
    server.kill()
    say(page, "hello", "Hello")
    page.wait_for(f"{state('hello')} === 'no reply from {hello} within 1 s; is the server running?'")
    # A question to the others does not wait for it. Nobody publishes pictures.
    say(page, "background", "hello")
    page.wait_for(f"{NEWEST} === 'sent hello, received world' && {state('pictures')}.includes('nothing new')")
    serve("01_request_reply", endpoint=hello)
    page.wait_for(f"{NEWEST} === 'sent Hello, received World' && {state('hello')} === 'connected'")
    gateway.kill()
    for name in ("hello", "poses"):
        page.wait_for(f"{state(name)} === 'the gateway is away; trying again'")
    say(page, "background", "hello")
    before = page.text("#pose")
    serve(KEY, *words, *PATIENT, endpoint=endpoint)
    page.wait_for(f"{NEWEST} === 'sent hello, received world'")
    page.wait_for(f"{POSE} !== {json.dumps(before)} && {state('poses')} === 'connected'")
    assert page.errors == []
    page = open_page(elsewhere)
    address = json.dumps(f"{endpoint}/ws/hello".replace("http", "ws"))
    assert page.evaluate(STRANGER.format(address=address)) == '["World"]'


def test_its_own_page_with_a_token_and_by_any_name_of_the_machine(behind, open_page):
    """At 0.0.0.0 the gateway does not know what it is called by those who come."""
    with opened(*behind, "--token", "grün & 7", "--endpoint", "http://0.0.0.0:0") as (_, endpoint):
        own = endpoint.replace("0.0.0.0", "127.0.0.1")
        page = open_page(own)
        page.wait_for(f"{state('hello')}.startsWith('the token is missing or wrong')")
        page.go(f"{own}/?token=gr%C3%BCn%20%26%207")
        page.wait_for(f"{state('hello')} === 'connected'")
        say(page, "hello", "Hello")
        page.wait_for(f"{NEWEST} === 'sent Hello, received World'")


# A page of any address may open a WebSocket to this machine, and ask.
STRANGER = """new Promise(resolve => {{
    const socket = new WebSocket({address});
    socket.onopen = () => socket.send('["Hello"]');
    socket.onmessage = event => resolve(event.data);
    socket.onclose = () => resolve('refused');
}})"""


# As Emscripten does it, but that a text's address is its number in a list.
EMSCRIPTEN = """
var texts = [null], library = {{}};
var LibraryManager = {{ library: library }};
var mergeInto = (all, more) => Object.assign(all, more);
var UTF8ToString = at => texts[at];
var lengthBytesUTF8 = text => new TextEncoder().encode(text).length;
var _malloc = size => texts.push(size) - 1;
var stringToUTF8 = (text, at, size) => {{
    if (size !== texts[at] || size <= lengthBytesUTF8(text)) throw new Error("room");
    texts[at] = text;
}};
{jslib}
var KitWeb = library.$KitWeb;
var text = value => texts.push(value) - 1;
var until = async (what, limit = 20000) => {{
    for (const end = Date.now() + limit; Date.now() < end; await new Promise(next => setTimeout(next, 5)))
        {{ const value = what(); if (value) return value; }}
    throw new Error("never: " + what);
}};
"""


def test_the_webgl_half_of_the_client_in_a_browser(behind, serve, open_page):
    """The very file that Unity compiles in, and each function that BrowserConnection.cs calls."""
    folder = ROOT / "unity/Assets/NetMQExample/16_web_gateway"
    jslib = (folder / "BrowserConnection.jslib").read_text(encoding="utf-8")
    called = set(re.findall(r"extern \w+ (\w+)\(", (folder / "BrowserConnection.cs").read_text(encoding="utf-8")))
    gateway, endpoint = serve(KEY, *behind, *PATIENT)
    page = open_page(endpoint)
    page.evaluate(f"(0, eval)({json.dumps(EMSCRIPTEN.format(jslib=jslib))})")
    there = page.evaluate("Object.keys(library).filter(name => !/^\\$|__deps$/.test(name))")
    assert set(there) == called
    assert page.evaluate("Object.keys(library).filter(name => /__deps$/.test(name)).length") == len(called)
    address = json.dumps(f"{endpoint}/ws/hello".replace("http", "ws"))
    assert page.evaluate(f"var one = library.KitWebOpen(text({address})); library.KitWebIsOpen(one)") == 0
    page.evaluate("until(() => library.KitWebIsOpen(one) === 1)")
    assert page.evaluate("library.KitWebReceive(one)") == 0, "nothing has come: null"
    page.evaluate("""library.KitWebSend(one, text('["Hello"]'))""")
    assert page.evaluate("until(() => library.KitWebReceive(one)).then(UTF8ToString)") == '["World"]'
    assert page.evaluate("library.KitWebClosed(one)") == 0
    # Two at a time, an address that cannot work, one where nobody is, and a gateway that ends.
    bad = page.evaluate("library.KitWebOpen(text('nonsense://'))")
    assert page.evaluate(f"UTF8ToString(library.KitWebClosed({bad}))").startswith("SyntaxError")
    assert page.evaluate(f"library.KitWebSend({bad}, text('x')); library.KitWebClose({bad}); true")
    gateway.kill()
    assert "is away" in page.evaluate("until(() => library.KitWebClosed(one)).then(UTF8ToString)")
    assert page.evaluate("library.KitWebSend(one, text('x')); library.KitWebClose(one); library.KitWebIsOpen(one)") == 0
    assert page.errors == []


def test_a_webgl_build_compiles_without_netmq(netmq):
    """The browser's half, which no other build sees, and nothing of the assembly that WebGL leaves out."""
    built = dotnet.build(netmq, ROOT / "tests" / "web" / "webgl")
    assert b"KitWebOpen" in built.read_bytes() and b"BrowserConnection" in built.read_bytes()
    assert "NetMQ.dll" not in {path.name for path in built.parent.iterdir()}
