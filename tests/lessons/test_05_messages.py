"""Lesson 05: pictures of each client, golden bytes in both languages, and everything that is no message."""

from __future__ import annotations

import importlib
import io
import itertools
import json
import math
import os
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys

import pytest
import zmq

from kitlib.docs import guide
from kitlib.setup import dotnet
from tests.conftest import CLIENTS, PYTHON
from tests.programs import ROOT, steady_port

KEY = "05_messages"
FOLDER = ROOT / "python" / KEY
GOLDEN = json.loads((ROOT / "tests" / "lessons" / "golden" / f"{KEY}.json").read_text(encoding="utf-8"))
GERMAN = {"LANG": "de_DE.UTF-8", "LC_ALL": "de_DE.UTF-8"}
ITEMS = {"uint8": "B", "uint16": "H", "int32": "i", "int64": "q", "float32": "f", "float64": "d"}

sys.path.insert(0, str(FOLDER))
messages = importlib.import_module("messages")
Array, Message, MessageError = messages.Array, messages.Message, messages.MessageError


@pytest.fixture
def serve(serve):
    pytest.importorskip("numpy", reason="lesson 05's server needs numpy: pip install numpy")
    return serve


@pytest.fixture
def ask(context):
    """One request on a new socket; the reply as a message."""

    def ask(endpoint, frames):
        with context.socket(zmq.REQ) as asker:
            asker.linger = 0
            asker.connect(endpoint)
            asker.send_multipart(frames)
            assert asker.poll(20_000), f"no reply to {frames!r:.80}"
            return messages.read(asker.recv_multipart())

    return ask


def unpacked(entry):
    """The frames of a golden entry."""
    return [
        bytes.fromhex(frame) if isinstance(frame, str) else b"".join(bytes.fromhex(byte) * n for byte, n in frame)
        for frame in entry["frames"]
    ]


def line(kind, i, number, size):
    grey = 10 * number % 200
    mean = (grey * (320 * 240 - 64) + 255 * 64) / (320 * 240)
    x, y = 16 * number % 320, 8 * number % 240
    return f"{i}: sent {kind} {number}, {size} bytes; brightest at x {x}, y {y}, mean {mean:.1f}"


@pytest.mark.parametrize("kind", CLIENTS)
def test_ten_pictures(kind, serve, start, client_command):
    """x and y are right only if shape, flip and every byte of 230,400 are."""
    server, endpoint = serve(KEY)
    client = start(*client_command(kind, KEY, endpoint))
    assert client.wait() == 0, client.output
    ten = [line("frame", i, i, 230_400) for i in range(1, 11)]
    assert client.lines == [f"asking {endpoint}", *ten, "done: 10 replies, 0 pictures skipped"]
    # The server prints after it has replied: the client can be done before the tenth line is there.
    server.wait_for(r"^sent b'\{\"kind\":\"ok\",\"version\":1,\"id\":10,", start=10)
    assert server.stop() == 0
    assert len(server.lines) == 11


@pytest.mark.parametrize("kind", ["python", "unity"])
def test_jpeg(kind, serve, start, client_command):
    pytest.importorskip("PIL", reason="JPEG needs Pillow: pip install pillow")
    _, endpoint = serve(KEY)
    client = start(*client_command(kind, KEY, endpoint, "--count", "3", "--jpeg"))
    assert client.wait() == 0, client.output
    for i, printed in enumerate(client.lines[1:4], 1):
        size = int(re.search(r"(\d+) bytes", printed)[1])
        assert size < 10_000
        assert printed == line("jpeg", i, i, size)


@pytest.mark.parametrize("kind", CLIENTS)
def test_the_newest_picture_wins(kind, serve, start, client_command):
    """The server takes at least 0.1 s for each, the camera makes ten meanwhile: nine of ten must be skipped."""
    _, endpoint = serve(KEY, "--delay", "0.1")
    client = start(*client_command(kind, KEY, endpoint, "--count", "4", "--fps", "100"))
    assert client.wait() == 0, client.output
    numbers = [int(re.search(r"frame (\d+),", printed)[1]) for printed in client.lines[1:5]]
    assert client.lines[1:5] == [line("frame", i, number, 230_400) for i, number in enumerate(numbers, 1)]
    assert all(later - earlier >= 9 for earlier, later in itertools.pairwise(numbers)), numbers
    assert client.lines[5] == f"done: 4 replies, {numbers[-1] - 4} pictures skipped"


def test_a_shape_that_does_not_fit_is_refused_and_the_server_goes_on(serve, start, client_command):
    server, endpoint = serve(KEY)
    client = start(*client_command("python", KEY, endpoint, "--count", "1", "--wrong-shape"))
    assert client.wait() == 1, client.output
    assert client.lines[1] == "gave up: bad-shape: uint8 (240, 320, 4) is 307200 contiguous bytes, not 230400"
    client = start(*client_command("python", KEY, endpoint, "--count", "1"))
    assert client.wait() == 0, client.output
    assert not [line for line in server.lines[1:] if "error" in line], "whoever asked knows it"


# The standard: golden bytes.


def meant(entry):
    """The message that a golden entry stands for, made without messages.read."""
    means = entry["means"]
    arrays = [
        Array(a["dtype"], tuple(a["shape"]), struct.pack(f"<{len(a['items'])}{ITEMS[a['dtype']]}", *a["items"]))
        for a in means["arrays"]
    ]
    return Message(means["kind"], means["id"], means["values"], arrays)


def same(one, other):
    """Equal, where 1, 1.0 and true are three different things."""
    return one == other and [type(v) for v in one.values.values()] == [type(v) for v in other.values.values()]


@pytest.mark.parametrize("entry", GOLDEN["good"], ids=lambda entry: entry["name"])
def test_python_reads_and_writes_the_golden_bytes(entry):
    assert same(messages.read(unpacked(entry)), meant(entry))
    if entry["written"]:
        assert meant(entry).frames() == unpacked(entry)


@pytest.mark.parametrize("entry", GOLDEN["bad"], ids=lambda entry: entry["name"])
def test_python_refuses_the_bad_ones(entry):
    with pytest.raises(MessageError) as refusal:
        messages.read(unpacked(entry))
    assert refusal.value.code == entry["code"]
    assert len(refusal.value.text) < 300


@pytest.fixture(scope="session")
def program(engine):
    """The command of tests/lessons/messages."""
    return ["dotnet", str(dotnet.build(PYTHON, engine, ROOT / "tests" / "lessons" / "messages"))]


def csharp(program, batch, **environment):
    """What Message.cs makes of each message: ("ok", the frames it writes) or ("error", the code)."""
    lines = [" ".join(frame.hex() or "-" for frame in map(bytes, frames)) for frames in batch]
    done = subprocess.run(
        [*program, "read"],
        input="".join(f"{line}\n" for line in lines),
        capture_output=True,
        text=True,
        timeout=100,
        env={**os.environ, **environment},
    )
    assert done.returncode == 0, done.stderr
    german, *answers = done.stdout.splitlines()
    assert german == "here a half is written 0,5", "it must be checked where numbers have a comma"
    assert len(answers) == len(batch)
    return [
        ("ok", [b"" if frame == "-" else bytes.fromhex(frame) for frame in rest.split(" ")])
        if word == "ok"
        else (word, rest)
        for word, _, rest in (answer.partition(" ") for answer in answers)
    ]


@pytest.mark.parametrize("environment", [{}, GERMAN], ids=["this locale", "German locale"])
def test_csharp_reads_and_writes_the_golden_bytes(environment, program):
    for entry, (word, frames) in zip(
        GOLDEN["good"], csharp(program, map_list(GOLDEN["good"]), **environment), strict=True
    ):
        assert word == "ok", entry["name"]
        # Python's reader is checked by itself above; here it says what the C# side has understood.
        assert same(messages.read(frames), meant(entry)), entry["name"]
        if entry["written"]:
            assert frames == unpacked(entry), entry["name"]


def test_csharp_refuses_the_bad_ones_with_the_same_codes(program):
    answers = csharp(program, map_list(GOLDEN["bad"]))
    assert answers == [("error", entry["code"]) for entry in GOLDEN["bad"]]


def test_csharp_writes_no_value_that_the_standard_lacks(program):
    """NaN, infinity, 2**53, null, a character, a list; then 1.0 and 2, which it has."""
    done = subprocess.run([*program, "write"], capture_output=True, text=True, timeout=60)
    *wrong, one, two = done.stdout.splitlines()[1:]
    assert wrong == ["bad-value"] * 3 + ["wrong-type"] * 3
    assert ('"it":1.0}' in one, '"it":2}' in two) == (True, True), done.stdout


def test_a_requester_that_was_refused_asks_again(program, serve, start):
    _, endpoint = serve(KEY)
    asks = start(*program, "refused", endpoint)
    assert asks.wait() == 0, asks.output
    refusal = "unknown-kind: kind 'frames' is none of echo, frame, jpeg"
    assert asks.lines[1:] == [f"{name}: {said}" for name in ("plain", "pooled") for said in (refusal, "230400 bytes")]


def test_pooled_buffers_are_used_again(program, serve, start):
    _, endpoint = serve(KEY, "--quiet")
    asks = start(*program, "bytes", endpoint)
    assert asks.wait(100) == 0, asks.output
    plain, pooled = (int(line.partition(": ")[2]) for line in asks.lines[1:])
    assert plain > 230_400
    assert pooled < 23_040, "less than a tenth of one picture"


def map_list(entries):
    return [unpacked(entry) for entry in entries]


def test_python_under_a_german_locale_sends_the_same_bytes(serve, start, context, client_command):
    with context.socket(zmq.REP) as rep:
        rep.linger = 0
        port = rep.bind_to_random_port("tcp://127.0.0.1")
        client = start(*client_command("python", KEY, f"tcp://127.0.0.1:{port}", "--count", "1"), **GERMAN)
        assert rep.poll(20_000)
        header, pixels = rep.recv_multipart()
        array = b'[{"dtype":"uint8","shape":[240,320,3]}]'
        assert header == b'{"kind":"frame","version":1,"id":1,"values":{"bottom_up":true},"arrays":%s}' % array
        assert len(pixels) == 230_400
        rep.send_multipart(Message("ok", 1, {"mean": 0.25, "x": 1, "y": 2}).frames())
        assert client.wait() == 0
        assert client.lines[1].endswith("brightest at x 1, y 2, mean 0.2")


# The server, with what is no message or no picture.


@pytest.mark.parametrize("engine_client", ["csharp", "unity"])
def test_csharp_clients_send_the_same_bytes(engine_client, start, context, client_command):
    with context.socket(zmq.REP) as rep:
        rep.linger = 0
        port = rep.bind_to_random_port("tcp://127.0.0.1")
        client = start(*client_command(engine_client, KEY, f"tcp://127.0.0.1:{port}", "--count", "1"), **GERMAN)
        assert rep.poll(30_000)
        header, pixels = rep.recv_multipart()
        array = b'[{"dtype":"uint8","shape":[240,320,3]}]'
        assert header == b'{"kind":"frame","version":1,"id":1,"values":{"bottom_up":true},"arrays":%s}' % array
        assert pixels == importlib.import_module("pictures").picture(1).arrays[0].data
        rep.send_multipart(Message("ok", 1, {"mean": 0.75, "x": 1, "y": 2}).frames())
        assert client.wait() == 0, client.output
        assert client.lines[1].endswith("brightest at x 1, y 2, mean 0.8")


@pytest.mark.parametrize("kind", CLIENTS)
@pytest.mark.parametrize("reply", [[b"World"], [b""], [b"{}", b"x"]])
def test_a_client_names_a_reply_that_is_no_message(kind, reply, start, context, client_command):
    with context.socket(zmq.REP) as rep:
        rep.linger = 0
        port = rep.bind_to_random_port("tcp://127.0.0.1")
        client = start(*client_command(kind, KEY, f"tcp://127.0.0.1:{port}", "--count", "1"))
        assert rep.poll(30_000)
        rep.recv_multipart()
        rep.send_multipart(reply)
        assert client.wait() == 1, client.output
        assert re.match(r"gave up: (bad-json|missing-field): ", client.lines[-1]), client.output


ESC = "\x1b]0;owned\x07\r\nclient | done"
ODD = {
    "a mean that is text": (Message("ok", 1, {"x": 1, "y": 2, "mean": "ten"}), 0, "x 1, y 2, mean ten"),
    "a mean that is true": (Message("ok", 1, {"x": 1, "y": 2, "mean": True}), 0, "x 1, y 2, mean True"),
    "half a character": (Message("ok", 1, {"\ud800": "\udfff"}), 1, "gave up: bad-json: "),
    "terminal codes": (Message("ok", 1, {"a": ESC}), 0, "a ?]0;owned???client | done"),
    "a long text": (Message("ok", 1, {"a": "x" * 5000}), 0, "a " + "x" * 198 + "…"),
    "no values": (Message("ok", 1), 0, "1: sent frame 1, 230400 bytes"),
    "an error of no reason": (Message("error", 1), 1, "gave up: not said: not said"),
    "an error of odd types": (Message("error", 1, {"code": 5, "text": False}), 1, "gave up: 5: False"),
    "an error with terminal codes": (
        Message("error", 1, {"code": ESC, "text": "\0" + "y" * 5000}),
        1,
        "gave up: ?]0;owned???client | done: ?" + "y" * 199,
    ),
    "an unknown dtype": (
        [b'{"kind":"ok","version":1,"id":1,"values":{},"arrays":[{"dtype":"\\u001b[2J","shape":[]}]}', b""],
        1,
        r"gave up: bad-dtype: dtype '\x1b[2J",
    ),
}


@pytest.mark.parametrize("kind", CLIENTS)
@pytest.mark.parametrize(("reply", "code", "says"), ODD.values(), ids=ODD.keys())
def test_an_odd_reply_ends_in_one_line(kind, reply, code, says, start, context, client_command):
    with context.socket(zmq.REP) as rep:
        rep.linger = 0
        port = rep.bind_to_random_port("tcp://127.0.0.1")
        # As where output in a pipe is no UTF-8.
        command = client_command(kind, KEY, f"tcp://127.0.0.1:{port}", "--count", "1")
        client = start(*command, PYTHONIOENCODING="cp437")
        assert rep.poll(30_000)
        rep.recv_multipart()
        rep.send_multipart(reply.frames() if isinstance(reply, Message) else reply)
        assert client.wait() == code, client.output
    line = client.lines[-1] if code else client.lines[1]
    # How an escaped character is written differs.
    assert says in line.replace("\\u001b", "\\x1b")
    assert len(client.lines) == (2 if code else 3), client.output
    assert not re.search(r"[\x00-\x1f\x7f]|Traceback|Unhandled", client.output.replace("\n", ""))


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_reply_of_very_many_frames_is_refused(kind, start, context, client_command):
    """Whose time must not grow with the square of their number."""
    with context.socket(zmq.REP) as rep:
        rep.linger = 0
        port = rep.bind_to_random_port("tcp://127.0.0.1")
        client = start(*client_command(kind, KEY, f"tcp://127.0.0.1:{port}", "--count", "1", "--patience", "20"))
        assert rep.poll(30_000)
        rep.recv_multipart()
        rep.send_multipart([*Message("ok", 1).frames(), *[b""] * 200_000])
        assert client.wait(20) == 1, client.output
        assert client.lines[-1] == "gave up: bad-frames: the header lists 0 arrays, but 200000 frames follow it"


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_server_that_breaks_the_connection_does_not_hold_a_client(kind, start, client_command):
    """After such bytes libzmq connects no more, and a send without a limit would wait for ever."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(30)
        endpoint = f"tcp://127.0.0.1:{listener.getsockname()[1]}"
        once = ["--tries", "1"] if kind == "unity" else []
        client = start(*client_command(kind, KEY, endpoint, "--count", "3", "--patience", "1", *once))
        raw, _ = listener.accept()
        with raw:
            peer = Peer(raw, b"REP")
            peer.request()
            # A good reply, and behind it a frame of 2**63 bytes.
            header = Message("ok", 1, {"a": 1}).frames()[0]
            peer.send(b"\x01\x00" + b"\x00" + bytes([len(header)]) + header + b"\x02\xff" + b"\xff" * 7 + b"x" * 64)
            client.wait_for("^1: sent frame 1")
            assert client.wait(15) == 1, client.output
    assert client.lines[-1].startswith("gave up: no reply from"), client.output


class Peer:
    """The least that a ZeroMQ 3.0 peer has to say, over a plain TCP connection."""

    def __init__(self, raw, kind):
        self.raw = raw
        raw.settimeout(30)
        raw.sendall(b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(48))
        ready = b"\x05READY\x0bSocket-Type" + struct.pack(">I", len(kind)) + kind
        raw.sendall(bytes([4, len(ready)]) + ready)
        self.read(64)
        self.frame()

    def read(self, count):
        data = b""
        while len(data) < count:
            got = self.raw.recv(count - len(data))
            assert got, "it hung up"
            data += got
        return data

    def frame(self):
        """The flags and the bytes of the next frame."""
        flags = self.read(1)[0]
        size = int.from_bytes(self.read(8 if flags & 2 else 1), "big")
        return flags, self.read(size)

    def request(self):
        while self.frame()[0] & 1:
            pass

    def send(self, data):
        self.raw.sendall(data)


def test_every_bad_message_gets_an_error_reply_and_the_server_goes_on(serve, ask):
    server, endpoint = serve(KEY)
    for entry in GOLDEN["bad"]:
        reply = ask(endpoint, unpacked(entry))
        assert (reply.kind, reply.values.get("code")) == ("error", entry["code"]), entry["name"]
        assert reply.values["text"]
        assert ask(endpoint, Message("echo", 9).frames()) == Message("ok", 9), entry["name"]
    assert server.stop() == 0
    assert "Traceback" not in server.output


def image(shape, dtype="uint8", data=None, kind="frame", **values):
    size = math.prod(shape) * messages.DTYPES[dtype]
    return Message(kind, 5, values, [Array(dtype, shape, bytes(size) if data is None else data)])


REFUSED = {
    "an unknown kind": (Message("pickle", 5), "unknown-kind"),
    "a kind that no console can print": (Message("\x1b\n\0", 5), "unknown-kind"),
    "no array": (Message("frame", 5), "bad-shape"),
    "two arrays": (Message("frame", 5, {}, image((2, 2, 3)).arrays * 2), "bad-shape"),
    "a picture of no pixels": (image((0, 320, 3)), "bad-shape"),
    "a picture in two dimensions": (image((240, 320)), "bad-shape"),
    "four colours": (image((2, 2, 4)), "bad-shape"),
    "a picture of floats": (image((2, 2, 3), "float32"), "bad-shape"),
    "one number that is no list": (image((), "uint8"), "bad-shape"),
    "one number that is upside down": (image((), "uint8", bottom_up=True), "bad-shape"),
}


@pytest.mark.parametrize(("message", "code"), REFUSED.values(), ids=REFUSED.keys())
def test_a_message_that_cannot_be_answered(message, code, serve, ask):
    server, endpoint = serve(KEY)
    reply = ask(endpoint, message.frames())
    assert (reply.kind, reply.id, reply.values["code"]) == ("error", 5, code)
    assert ask(endpoint, Message("echo", 9).frames()) == Message("ok", 9)
    assert server.stop() == 0
    assert "Traceback" not in server.output


MISTAKES = {
    "an exception": ("raise ValueError('my own\\nmistake')", r"ValueError('my own\nmistake')"),
    "no reply": ("return None", "'NoneType' object has no attribute 'frames'"),
    "a number of numpy's": ("return Message('ok', 0, {'x': numpy.float32(1)})", "Object of type float32"),
    "NaN": ("return Message('ok', 0, {'x': float(numpy.float32('nan'))})", "JSON"),
}


@pytest.mark.parametrize(("body", "says"), MISTAKES.values(), ids=MISTAKES.keys())
def test_a_mistake_in_a_readers_own_answer_is_a_reply_and_a_traceback(body, says, start, ask, tmp_path):
    pytest.importorskip("numpy", reason="lesson 05's server needs numpy: pip install numpy")
    for path in FOLDER.glob("*.py"):
        shutil.copy(path, tmp_path)
    text = (tmp_path / "server.py").read_text(encoding="utf-8")
    own = (
        "def answer(request: Message) -> Message:\n"
        "    import numpy\n"
        "    from messages import Array\n"
        f"    if request.kind == 'mistake':\n        {body}\n"
    )
    text = text.replace("def answer(request: Message) -> Message:\n", own)
    (tmp_path / "server.py").write_text(text, encoding="utf-8")
    server = start(PYTHON, tmp_path / "server.py", "--endpoint", "tcp://127.0.0.1:*")
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    reply = ask(endpoint, Message("mistake", 7).frames())
    assert (reply.kind, reply.id, reply.values["code"]) == ("error", 7, "error-in-answer")
    assert says in reply.values["text"]
    assert ask(endpoint, Message("echo", 9).frames()) == Message("ok", 9)
    server.wait_for(r"\.py\", line \d+, in ")


def test_an_array_is_as_many_bytes_as_it_says_in_one_piece():
    np = pytest.importorskip("numpy", reason="lesson 05's server needs numpy: pip install numpy")
    Array("float64", (9,), np.zeros(9))
    for dtype, shape, data in [
        ("float64", (9,), np.zeros(9)[::-1]),
        ("float64", (9,), np.zeros(8)),
        ("float32", (9,), np.zeros(9)),
    ]:
        with pytest.raises(MessageError, match="contiguous bytes") as refusal:
            Array(dtype, shape, data)
        assert refusal.value.code == "bad-shape"


def test_numbers_are_read_little_endian():
    pytest.importorskip("numpy", reason="lesson 05's server needs numpy: pip install numpy")
    for dtype, data, number in [
        ("int32", b"\xfe\xff\xff\xff", -2),
        ("uint16", b"\x02\x01", 258),
        ("float32", b"\x00\x00\x20\x40", 2.5),
        ("float64", struct.pack("<d", -0.125), -0.125),
        ("int64", struct.pack("<q", 1 << 40), 1 << 40),
    ]:
        assert Array(dtype, (1, 1), data).numpy().tolist() == [[number]]


def test_top_down_pictures_are_not_turned_over(serve, ask):
    _, endpoint = serve(KEY)
    data = bytes(3) * 2 + b"\x01\x02\x03" + bytes(3) * 3
    assert ask(endpoint, image((2, 3, 3), data=data).frames()).values["y"] == 0
    assert ask(endpoint, image((2, 3, 3), data=data, bottom_up=True).frames()).values["y"] == 1
    # "yes" is not true: a value of the wrong type must not turn a picture over.
    assert ask(endpoint, image((2, 3, 3), data=data, bottom_up="yes").frames()).values["y"] == 0


def test_100_megabytes(serve, ask):
    server, endpoint = serve(KEY)
    for frames in [
        image((100_000_000,), kind="echo").frames(),
        [b" " * 100_000_000],
        Message("echo", 5, {}, [Array("uint8", (50_000_000,), bytes(50_000_000))] * 2).frames(),
    ]:
        reply = ask(endpoint, frames)
        assert (reply.kind, reply.values["code"]) == ("error", "too-big")
        assert ask(endpoint, Message("echo", 9).frames()) == Message("ok", 9)
    assert server.stop() == 0


def test_more_than_the_server_takes_from_the_network(serve, ask, context):
    """Over 256 MB libzmq hangs up on the sender; the others are served."""
    server, endpoint = serve(KEY)
    with context.socket(zmq.REQ) as asker:
        asker.linger = 0
        asker.connect(endpoint)
        asker.send(bytes(256 * 1024 * 1024 + 1), copy=False)
        assert ask(endpoint, Message("echo", 9).frames()) == Message("ok", 9)
        assert not asker.poll(0)
    assert server.stop() == 0


def jpeg(width, height, name="JPEG", mode="RGB"):
    image = pytest.importorskip("PIL.Image", reason="JPEG needs Pillow: pip install pillow")
    file = io.BytesIO()
    image.new(mode, (width, height)).save(file, name)
    return file.getvalue()


def claiming(width, height):
    """A small file whose header claims an enormous picture."""
    data = bytearray(jpeg(8, 8))
    at = data.index(b"\xff\xc0") + 5
    data[at : at + 4] = struct.pack(">HH", height, width)
    return bytes(data)


def slow(scans, size=4096):
    """A progressive JPEG with so many scans that say nothing, each of which costs a pass over the whole picture."""
    image = pytest.importorskip("PIL.Image", reason="JPEG needs Pillow: pip install pillow")
    file = io.BytesIO()
    image.new("RGB", (8, 8)).save(file, "JPEG", progressive=True)
    data = bytearray(file.getvalue())
    at = data.index(b"\xff\xc2") + 5
    data[at : at + 4] = struct.pack(">HH", size, size)
    # Its only code, a bit 0, says that in 2**14 blocks and as many as the next 14 bits say all is as it was.
    table = b"\xff\xc4" + struct.pack(">HB16BB", 20, 0x10, 1, *[0] * 15, 0xE0)
    bits = ("0" + "10" * 7) * (size * size // 64 // 27_306 + 1)
    bits += "0" * (-len(bits) % 8)
    nothing = int(bits, 2).to_bytes(len(bits) // 8, "big").replace(b"\xff", b"\xff\0")
    scan = b"\xff\xda" + struct.pack(">HBBBBBB", 8, 1, 1, 0, 1, 63, 0) + nothing
    return bytes(data[: data.index(b"\xff\xda")]) + table + scan * scans + b"\xff\xd9"


def notes(count):
    """A small JPEG with so many notes of applications before its pixels; Pillow puts them together one by one."""
    data = jpeg(8, 8)
    return data[:2] + b"\xff\xe1\x00\x09Exif\0\0x" * count + data[2:]


JPEGS = {
    "60,000 scans": (lambda: slow(60_000), "too-big"),
    "3,000,000 notes": (lambda: notes(3_000_000), "too-big"),
    "padding": (lambda: b"\xff\xd8" + b"\xff" * 60_000_000, "bad-jpeg"),
    "marks without an end": (lambda: b"\xff\xd8" + b"\xff\xd0" * 30_000_000, "bad-jpeg"),
    "ten scans": (lambda: slow(10), None),
    "ten notes": (lambda: notes(10), None),
    "its beginning": (lambda: b"\xff\xd8\xff", "bad-jpeg"),
    "other bytes": (lambda: b"x" * 5000, "bad-jpeg"),
    "cut off": (lambda: jpeg(64, 64)[:-200], "bad-jpeg"),
    "a PNG": (lambda: jpeg(8, 8, "PNG"), "bad-jpeg"),
    "a bomb": (lambda: claiming(60_000, 60_000), "bad-jpeg"),
    "a large one": (lambda: claiming(6_000, 6_000), "too-big"),
    "a good one": (lambda: jpeg(8, 8), None),
    "grey": (lambda: jpeg(8, 8, mode="L"), None),
    "CMYK": (lambda: jpeg(8, 8, mode="CMYK"), None),
}


def test_a_jpeg_that_is_none(serve, ask):
    """One server for all of them: it serves on after each."""
    server, endpoint = serve(KEY)
    for name, (make, code) in JPEGS.items():
        data = make()
        reply = ask(endpoint, image((len(data),), data=data, kind="jpeg").frames())
        assert reply.values.get("code") == code, name
        assert ask(endpoint, Message("echo", 9).frames()) == Message("ok", 9), name
    assert server.stop() == 0


def test_a_jpeg_that_no_camera_writes_is_not_even_begun(serve, ask):
    """It announces arithmetic coding, which takes ten times as long to decode."""
    data = jpeg(64, 64).replace(b"\xff\xc0", b"\xff\xc9")
    _, endpoint = serve(KEY)
    reply = ask(endpoint, image((len(data),), data=data, kind="jpeg").frames())
    assert reply.values["text"] == "this is no JPEG picture: its parts are not in order"


def test_pixels_are_not_copied(context):
    np = pytest.importorskip("numpy", reason="lesson 05's server needs numpy: pip install numpy")
    with context.socket(zmq.PAIR) as left, context.socket(zmq.PAIR) as right:
        left.linger = right.linger = 0
        right.connect(f"tcp://127.0.0.1:{left.bind_to_random_port('tcp://127.0.0.1')}")
        left.send_multipart(image((240, 320, 3)).frames())
        assert right.poll(20_000)
        received = right.recv_multipart(copy=False)
    message = messages.read(received)
    picture = message.arrays[0].numpy()
    assert picture.shape == (240, 320, 3)
    assert np.shares_memory(picture, np.frombuffer(received[1].buffer, np.uint8))
    assert np.shares_memory(picture[::-1], picture)


@pytest.mark.parametrize(
    ("module", "program", "says"),
    [
        ("numpy", ["server.py"], "this lesson needs numpy: pip install numpy"),
        ("PIL", ["client.py", "--jpeg"], "--jpeg needs Pillow: pip install pillow"),
    ],
)
def test_a_missing_package_is_one_line_with_the_cure(module, program, says, start, tmp_path):
    (tmp_path / f"{module}.py").write_text("raise ImportError")
    found = start(PYTHON, FOLDER / program[0], *program[1:], PYTHONPATH=str(tmp_path))
    assert found.wait() == 1
    assert found.lines[-1].startswith(says)
    assert "Traceback" not in found.output


def test_a_server_without_pillow_says_so_and_goes_on(start, ask, tmp_path):
    pytest.importorskip("numpy", reason="lesson 05's server needs numpy: pip install numpy")
    (tmp_path / "PIL.py").write_text("raise ImportError")
    server = start(PYTHON, FOLDER / "server.py", "--endpoint", "tcp://127.0.0.1:*", PYTHONPATH=str(tmp_path))
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    reply = ask(endpoint, image((3,), kind="jpeg").frames())
    assert reply.values["text"] == "the server needs Pillow for JPEG: pip install pillow"
    assert ask(endpoint, Message("echo", 9).frames()) == Message("ok", 9)


# Properties. With --long they are tried on more than 20,000 cases.

try:
    from hypothesis import HealthCheck, given, settings
    from hypothesis import strategies as st
except ImportError:

    @pytest.mark.skip(reason="hypothesis is not installed: pip install hypothesis")
    def test_properties():
        """Stands for the tests below, so that their absence is reported."""

else:
    QUIET = {
        "deadline": None,
        "database": None,
        "derandomize": True,
        "suppress_health_check": list(HealthCheck),
    }
    EXACT = 2**53 - 1
    texts = st.text(max_size=20)
    values = st.one_of(
        texts, st.booleans(), st.integers(-EXACT, EXACT), st.floats(allow_nan=False, allow_infinity=False)
    )

    @st.composite
    def arrays(draw):
        dtype = draw(st.sampled_from(sorted(messages.DTYPES)))
        shape = tuple(draw(st.lists(st.integers(0, 3), max_size=3)))
        size = math.prod(shape) * messages.DTYPES[dtype]
        return Array(dtype, shape, draw(st.binary(min_size=size, max_size=size)))

    good = st.builds(
        Message,
        texts,
        st.integers(0, EXACT),
        st.dictionaries(texts, values, max_size=4),
        st.lists(arrays(), max_size=3),
    )
    anything = st.recursive(
        st.one_of(st.none(), st.booleans(), st.integers(-(2**70), 2**70), st.floats(), texts),
        lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(texts, inner, max_size=3)),
        max_leaves=6,
    )

    @st.composite
    def spoiled(draw):
        """The frames of a good message with one thing, or some, gone wrong."""
        frames = [bytes(frame) for frame in draw(good).frames()]
        how = draw(st.sampled_from(["field", "inner", "cut", "byte", "frames", "bytes", "json"]))
        header = json.loads(frames[0])
        if how == "field":
            header[draw(st.sampled_from(sorted(header)))] = draw(anything)
        elif how == "inner":
            inner = draw(st.sampled_from(header["arrays"] or [header]))
            inner[draw(st.sampled_from(["dtype", "shape", "kind", "id", "values", "version"]))] = draw(anything)
        elif how == "json":
            header = draw(anything)
        frames[0] = json.dumps(header).encode()
        at = draw(st.integers(0, len(frames[0]) - 1))
        if how == "cut":
            frames[0] = frames[0][:at]
        elif how == "byte":
            frames[0] = frames[0][:at] + draw(st.binary(max_size=2)) + frames[0][at + 1 :]
        elif how == "frames":
            frames = frames[:1] + draw(st.lists(st.binary(max_size=9), max_size=4))
        elif how == "bytes":
            frames = draw(st.lists(st.binary(max_size=60), min_size=1, max_size=3))
        return frames

    def verdict(frames):
        """The message, or None if it is refused in the proper way; anything else that is raised fails the test."""
        try:
            return messages.read(frames)
        except MessageError as error:
            assert re.fullmatch(r"[a-z]+-[a-z]+", error.code)
            assert 0 < len(error.text) < 300
            assert type(error.id) is int
            # The reply that a server makes of it can always be sent.
            reply = Message("error", error.id, {"code": error.code, "text": error.text})
            assert messages.read(reply.frames()) == reply
            return None

    def cases(few, many):
        """How many; the many take a minute of a core."""
        return pytest.mark.parametrize("count", [few, pytest.param(many, marks=[pytest.mark.long])])

    @cases(300, 6000)
    @pytest.mark.timeout(600)
    def test_what_is_written_is_read_again(count):
        @settings(max_examples=count, **QUIET)
        @given(good)
        def check(message):
            assert same(messages.read(message.frames()), message)

        check()

    @cases(500, 14_000)
    @pytest.mark.timeout(600)
    def test_whatever_comes_is_read_or_refused(count):
        @settings(max_examples=count, **QUIET)
        @given(spoiled())
        def check(frames):
            if message := verdict(frames):
                assert same(messages.read(message.frames()), message)

        check()

    def collected(strategy, count):
        """So many cases of a strategy, to give them to another program at once."""
        cases = []

        @settings(max_examples=count, **QUIET)
        @given(strategy)
        def collect(case):
            cases.append(case)

        collect()
        return cases

    @cases(200, 2000)
    def test_csharp_reads_what_python_writes_and_the_other_way_round(program, count):
        written = collected(good, count)
        for message, (word, frames) in zip(written, csharp(program, [m.frames() for m in written]), strict=True):
            assert word == "ok", (message, frames)
            assert same(messages.read(frames), message)

    @cases(400, 4000)
    def test_csharp_and_python_agree_on_what_is_no_message(program, count):
        tried = [frames for frames in collected(spoiled(), count) if b"\n" not in frames[0]]
        refused = 0
        for frames, (word, result) in zip(tried, csharp(program, tried), strict=True):
            message = verdict(frames)
            refused += message is None
            assert (word == "ok") == (message is not None), (frames, word, result)
            assert message is None or same(messages.read(result), message)
        assert refused > len(tried) / 4, "most cases must be wrong, or nothing was tested"

    def test_the_server_survives_whatever_comes(serve, ask):
        server, endpoint = serve(KEY)
        for frames in collected(spoiled(), 200):
            message = verdict(frames)
            reply = ask(endpoint, frames)
            if message is None:
                assert reply.kind == "error", frames
            else:
                assert reply.id == message.id
        assert ask(endpoint, Message("echo", 9).frames()) == Message("ok", 9)
        assert server.stop() == 0
        assert "Traceback" not in server.output


# The contract of every program.


def test_in_unity_a_server_that_was_restarted_is_found_again(serve, start, client_command):
    """Whoever writes the Python side starts it again all day, while Unity plays."""
    endpoint = f"tcp://127.0.0.1:{steady_port()}"
    client = start(*client_command("unity", KEY, endpoint, "--count", "60", "--patience", "0.5"))
    # Unity is first, and its first picture is lost.
    client.wait_for(f"^trouble: no reply from {endpoint} within 0.5 s")
    for number in (1, 20, 40):
        server, _ = serve(KEY, "--delay", "0.02", endpoint=endpoint)
        client.wait_for(f"^{number}: sent frame")
        server.kill()
    serve(KEY, endpoint=endpoint)
    assert client.wait() == 0, client.output
    replies = [line for line in client.lines if "brightest" in line]
    assert [int(line.split(":")[0]) for line in replies] == list(range(1, 61))
    for line in replies:
        number = int(re.search(r"frame (\d+),", line)[1])
        assert f"x {16 * number % 320}, y {8 * number % 240}," in line, "an answer to another picture"


@pytest.mark.parametrize("kind", CLIENTS)
def test_a_reply_of_another_server_is_shown_as_it_is(kind, start, client_command):
    with zmq.Context() as context, context.socket(zmq.REP) as server:
        server.linger = 0
        port = server.bind_to_random_port("tcp://127.0.0.1")
        client = start(*client_command(kind, KEY, f"tcp://127.0.0.1:{port}", "--count", "1"))
        assert server.poll(20_000)
        request = messages.read(server.recv_multipart(copy=False))
        server.send_multipart(Message("ok", request.id, {"steer": 0.5, "gas": 1}).frames())
        assert client.wait() == 0, client.output
    assert "1: sent frame 1, 230400 bytes; steer 0.5, gas 1" in client.lines


@pytest.mark.parametrize("kind", CLIENTS)
def test_the_answer_of_the_page_is_an_action(kind, tmp_path, start, client_command):
    page = ROOT / "docs" / "guide" / f"{KEY}.md"
    (block,) = [each for each in guide.blocks(page) if "test_the_answer_of_the_page" in each.source]
    text = (FOLDER / "server.py").read_text(encoding="utf-8").replace("from pictures import brightest\n", "")
    before, _, rest = text.partition("def answer(")
    (tmp_path / "server.py").write_text(before + block.body + rest[rest.index("\n\n\ndef serve(") :], encoding="utf-8")
    shutil.copy(FOLDER / "messages.py", tmp_path)
    server = start(PYTHON, tmp_path / "server.py", "--endpoint", "tcp://127.0.0.1:0")
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    client = start(*client_command(kind, KEY, endpoint, "--count", "2", "--patience", "20"))
    assert client.wait() == 0, client.output
    said = re.search(r"`(1: sent frame 1, 230400 bytes; steer 0\.\d+)…`", page.read_text(encoding="utf-8"))[1]
    assert client.lines[1].startswith(said), client.output
    with zmq.Context() as context, context.socket(zmq.REQ) as other:
        other.linger = 0
        other.connect(endpoint)
        for request, code in (
            ([b"no message"], b"bad-json"),
            (Message("echo", 7).frames(), b"unknown-kind"),
        ):
            other.send_multipart(request)
            assert other.poll(20_000)
            assert code in other.recv()
        other.send_multipart(Message("frame", 7, {}, [Array("uint8", (), b"x")]).frames())
        assert other.poll(20_000)
        assert b"error-in-answer" in other.recv()
    if sys.platform != "win32":
        assert server.stop(signal.SIGINT) == 0
        assert "KeyboardInterrupt" not in server.output
