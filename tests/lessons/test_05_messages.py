"""Lesson 05: each client's message, golden bytes in both languages, and everything that is no message."""

import array
import json
import math
import re
import struct
import time

import pytest
import zmq

from netmq_example import messages
from netmq_example.messages import Array, Message, MessageError
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import answering, ask, bind
from tests.programs import PATIENT, ROOT, finished, steady_endpoint

KEY = "05_messages"
FOLDER = ROOT / "python" / KEY
GOLDEN = json.loads((ROOT / "tests" / "lessons" / "golden" / f"{KEY}.json").read_text(encoding="utf-8"))
ITEMS = {"uint8": "B", "uint16": "H", "int32": "i", "int64": "q", "float32": "f", "float64": "d"}
NUMPY = {"reason": "lesson 05's server needs numpy: pip install numpy"}

each_client = pytest.mark.parametrize("kind", CLIENTS)


def asked(context, endpoint, message):
    """The reply to one request, or to these frames, on a new socket."""
    return Message.read(ask(context, endpoint, *(message.frames() if isinstance(message, Message) else message)))


def unpacked(entry):
    """The frames of a golden entry."""
    return [
        bytes.fromhex(frame) if isinstance(frame, str) else b"".join(bytes.fromhex(byte) * n for byte, n in frame)
        for frame in entry["frames"]
    ]


def line(i):
    mean = (10 * i * (320 * 240 - 64) + 255 * 64) / (320 * 240)
    return f"{i}: sent frame {i}, 230400 bytes; brightest at x {16 * i}, y {8 * i}, mean {mean:.1f}"


def test_ten_pictures(serve, runs):
    """x and y are right only if shape, flip and every byte of 230,400 are."""
    pytest.importorskip("numpy", **NUMPY)
    server, endpoint = serve(KEY)
    words = ["--endpoint", endpoint, *PATIENT]
    # A transcript of the page has the C# client's.
    for kind in ("python", "unity"):
        begin = len(server.lines)
        (done,) = runs(kind, KEY, [words])
        assert done == (0, [f"asking {endpoint}", *map(line, range(1, 11)), "done: 10 replies"]), kind
        # The server prints after it has replied: the client can be done before the tenth line is there.
        server.wait_for(r"^sent b'\{\"kind\":\"ok\",\"version\":1,\"id\":10,", start=begin)
    assert server.stop() == 0
    assert len(server.lines) == 21


# The standard: golden bytes.


def meant(entry):
    """The message that a golden entry stands for, made without Message.read."""
    means = entry["means"]
    arrays = [
        Array(a["dtype"], tuple(a["shape"]), struct.pack(f"<{len(a['items'])}{ITEMS[a['dtype']]}", *a["items"]))
        for a in means["arrays"]
    ]
    return Message(means["kind"], means["id"], means["values"], arrays)


def same(one, other):
    """Equal, where 1, 1.0 and true are three different things."""
    return one == other and [type(v) for v in one.values.values()] == [type(v) for v in other.values.values()]


def python(batch):
    """Each message written again, or the code with which it is refused."""
    for frames in batch:
        try:
            yield "ok", Message.read(frames).frames()
        except MessageError as refusal:
            assert len(refusal.text) < 300
            yield "error", refusal.code


def test_all_arrays_together_have_a_limit():
    message = picture((messages.LIMIT,), kind="echo")
    assert Message.read(message.frames()) == message
    message.arrays.append(Array("uint8", (1,), b"x"))
    for attempt in (message.frames, lambda: Message.read(unchecked(message))):
        with pytest.raises(MessageError, match="too-big: "):
            attempt()


def csharp(program, batch):
    """Message.cs makes this of each message: ("ok", the frames it writes) or ("error", the code)."""
    lines = [" ".join(frame.hex() or "-" for frame in map(bytes, frames)) for frames in batch]
    done = finished([*program, "read"], input="".join(f"{line}\n" for line in lines))
    assert done.returncode == 0, done.stderr
    german, *answers = done.stdout.splitlines()
    assert german == "here a half is written 0,5", "it must be checked where numbers have a comma"
    assert len(answers) == len(lines)
    return [
        ("ok", [b"" if frame == "-" else bytes.fromhex(frame) for frame in rest.split(" ")])
        if word == "ok"
        else (word, rest)
        for word, _, rest in (answer.partition(" ") for answer in answers)
    ]


@pytest.mark.parametrize("side", ["python", "csharp"])
def test_the_golden_bytes(side, request):
    good, bad = GOLDEN["good"], GOLDEN["bad"]
    batch = map(unpacked, good + bad)
    answers = [*(python(batch) if side == "python" else csharp(request.getfixturevalue("messages_program"), batch))]
    assert answers[len(good) :] == [("error", entry["code"]) for entry in bad]
    for entry, (word, frames) in zip(good, answers, strict=False):
        assert word == "ok", entry["name"]
        assert same(Message.read(frames), meant(entry)), entry["name"]
        assert not entry["written"] or frames == unpacked(entry), entry["name"]


def test_csharp_writes_no_value_that_the_standard_lacks(messages_program):
    """NaN, infinity, 2**53, null, char, a list, a long text, half characters; 1.0 and 2, which it has; wrong ids and
    shapes; arrays of the limit and more."""
    done = finished([*messages_program, "write"])
    *wrong, one, two, id_1, id_2, shape_1, shape_2, shape_3, most, more = done.stdout.splitlines()[1:]
    assert wrong == ["bad-value"] * 3 + ["wrong-type"] * 3 + ["too-big"] + ["bad-json"] * 2
    assert [id_1, id_2, shape_1, shape_2, shape_3] == ["bad-value"] * 2 + ["bad-shape"] * 3
    assert ('"it":1.0}' in one, '"it":2}' in two) == (True, True), done.stdout
    assert most.startswith('{"kind":"echo"') and more == "too-big"


def test_a_requester_with_tries_asks_again(messages_program, context):
    asked = []

    def slow_at_first(frames):
        asked.append(frames)
        # Not a wait for something: the first try is over meanwhile.
        time.sleep(1 if len(asked) == 1 else 0)
        return echo(frames)

    with answering(context, slow_at_first) as endpoint:
        done = finished([*messages_program, "again", endpoint])
    assert done.stdout.splitlines()[1:] == ["7"], done.stderr
    assert len(asked) > 1


@pytest.mark.parametrize("kind", ["plain", "pooled"])
def test_a_requester_that_was_refused_asks_again_and_a_pooled_one_uses_its_buffers_again(
    kind, messages_program, context
):
    with answering(context, echo) as endpoint:
        done = finished([*messages_program, "ask", kind, endpoint])
    _, refused, size, *allocated = done.stdout.splitlines()
    assert [refused, size] == ["5 unknown-kind: only echo", "230400 bytes"], done.stderr
    assert kind == "plain" or int(allocated[0]) < 23_040, "less than a tenth of one picture"


def test_numbers_are_of_the_dtype_that_they_are_called():
    np = pytest.importorskip("numpy", **NUMPY)
    for dtype, data in [
        ("float32", np.arange(4, dtype="int32")),
        ("int32", np.arange(4, dtype="uint32")),
        ("float32", np.arange(4, dtype=">f4")),
        ("float64", np.arange(4)),
        ("uint16", np.arange(4, dtype="float16")),
        ("uint8", np.arange(4, dtype="int8")),
        ("int64", np.array([None] * 4)),
        ("int32", array.array("f", range(4))),
    ]:
        with pytest.raises(MessageError, match=rf"^bad-dtype: the data is no {dtype}, .*numpy's astype\('{dtype}'\)"):
            Array(dtype, (4,), data)
    for dtype in messages.DTYPES:
        numbers = np.arange(4, dtype=dtype)
        # Bytes are taken as whatever they are called.
        for data in (numbers, memoryview(numbers), numbers.tobytes(), numbers.view("uint8"), zmq.Frame(numbers)):
            assert Array(dtype, (4,), data).numpy().tolist() == [0, 1, 2, 3]
    assert Array("uint8", (2,), np.array([False, True])).numpy().tolist() == [0, 1]
    assert Array("int64", (4,), np.arange(4, dtype="longlong")).numpy().tolist() == [0, 1, 2, 3]
    # Little-endian, and as many as it says, in one piece.
    for dtype, data, number in [("uint16", b"\x02\x01", 258), ("float32", b"\x00\x00\x20\x40", 2.5)]:
        assert Array(dtype, (1, 1), data).numpy().tolist() == [[number]]
    for dtype, data in [("float64", np.zeros(9)[::-1]), ("float64", np.zeros(8)), ("float32", np.zeros(9))]:
        with pytest.raises(MessageError, match=r"^bad-shape: .*contiguous bytes"):
            Array(dtype, (9,), data)


def test_a_message_shows_no_pixels():
    """A notebook, a debugger and an assert print it."""
    assert len(repr(picture((240, 320, 3)))) < 200


def test_arrays_are_not_copied(context, connect):
    np = pytest.importorskip("numpy", **NUMPY)
    with context.socket(zmq.PAIR) as left:
        right = connect(bind(left), zmq.PAIR)
        left.send_multipart(picture((240, 320, 3)).frames())
        received = right.recv_multipart(copy=False)
    message = Message.read(received)
    found = message.arrays[0].numpy()
    assert found.shape == (240, 320, 3)
    assert np.shares_memory(found, np.frombuffer(received[1].buffer, np.uint8))
    assert np.shares_memory(found[::-1], found)


WRONG = {
    "a list as dtype": lambda: Array([], (1,), b"x"),
    "no shape": lambda: Array("uint8", None, b""),
    "a shape of -1 twice": lambda: Array("uint8", (-1, -1), b"x"),
    "a shape of true": lambda: Array("uint8", (True,), b"x"),
    "text as data": lambda: Array("uint8", (1,), "x"),
    "no kind": lambda: Message(None).frames(),
    "the id 2**53": lambda: Message("ok", 2**53).frames(),
    "no values": lambda: Message("ok", 1, None).frames(),
    "a set among the values": lambda: Message("ok", 1, {"it": {1}}).frames(),
    "a value without a text as its name": lambda: Message("ok", 1, {1: "it"}).frames(),
    "a header of more than 64 KB": lambda: Message("a" * 70_000).frames(),
    "half a character": lambda: Message("ok", 1, {"a": "\ud800"}).frames(),
    "a frame of text": lambda: Message.read(["x"]),
    "bytes as frames": lambda: Message.read(b"{}"),
    "no frame": lambda: Message.read([]),
    "no frames": lambda: Message.read(None),
}


def test_what_a_reader_would_refuse_is_not_even_written():
    for name, make in WRONG.items():
        with pytest.raises(MessageError) as refusal:
            make()
        assert "\n" not in str(refusal.value) and len(str(refusal.value)) < 300, name


def test_an_answer_that_cannot_be_written_is_answered_with_an_error(printed):
    """Also where what is wrong with it could not be written; and a mistake in one's own answer has a traceback."""

    def refusing(error):
        def answer(request):
            raise error

        return answer

    for answer, code, says in (
        (refusing(MessageError("no", "\ud800" * 70_000)), "no", "???"),
        (refusing(MessageError("no", "☃" * 70_000)), "no", "☃☃☃"),
        (lambda request: Message("ok", 1, {"a": "x" * 70_000}), "too-big", "at most 65536 bytes"),
        (lambda request: Message("ok", 1, {"a": "\ud800"}), "bad-json", "UTF-8"),
        (refusing(ValueError("my own\nmistake")), "error-in-answer", r"ValueError('my own\nmistake')"),
        (lambda request: None, "error-in-answer", "answer returned None: return a Message"),
        (lambda request: Message("ok", 0, {"x": {1}}), "wrong-type", "must be text, a number, true or false"),
        (lambda request: Message("ok", 0, {"x": math.nan}), "bad-value", "not finite"),
    ):
        *_, frames = messages.message_reply(answer, Message("ask", 7).frames())
        reply = Message.read(frames)
        assert (reply.kind, reply.id, reply.values["code"]) == ("error", 7, code)
        assert says in reply.values["text"]
        assert ("Traceback" in printed.readouterr().err) == ("ValueError" in says)


# The clients, and servers that are not the kit's.


def echo(frames):
    def answer(request):
        if request.kind != "echo":
            raise MessageError("unknown-kind", "only echo")
        return Message("ok", request.id, request.values, request.arrays)

    return messages.message_reply(answer, frames)[2]


@each_client
def test_all_clients_send_the_same_bytes_under_a_german_locale_as_well(kind, context, start_client):
    asked = []

    def answer(frames):
        asked.append(frames)
        return Message("ok", 1, {"mean": 0.75, "x": 1, "it": "\u2603"}).frames()

    with answering(context, answer) as endpoint:
        # As where output in a pipe is no UTF-8.
        german = {"PYTHONIOENCODING": "cp437", "LANG": "de_DE.UTF-8", "LC_ALL": "de_DE.UTF-8"}
        client = start_client(kind, KEY, endpoint, "--count", "1", "--timeout", "60.5", **german)
        assert client.wait() == 0, client.output
    ((header, pixels),) = asked
    array = b'[{"dtype":"uint8","shape":[240,320,3]}]'
    assert header == b'{"kind":"frame","version":1,"id":1,"values":{"bottom_up":true},"arrays":%s}' % array
    grey, square = b"\x0a\x0a\x0a", b"\xff\xff\xff"
    top_down = [[square if 8 <= y < 16 <= x < 24 else grey for x in range(320)] for y in range(240)]
    assert pixels == b"".join(pixel for row in reversed(top_down) for pixel in row)
    says = "; brightest at mean 0.75, x 1, it \u2603"
    assert client.lines[1].endswith(says), "the values as they come, and with a point"


ESC = "\x1b]0;owned\x07\r\nclient | done"
HALF_A_CHARACTER = Message("ok", 1, {"it": "?"}).frames()[0].replace(b"?", rb"\udfff")
ODD = {
    "a text": ([b"World"], 1, "gave up: bad-json: "),
    "a header that is none": ([b"{}", b"x"], 1, "gave up: missing-field: "),
    "half a character": ([HALF_A_CHARACTER], 1, "gave up: bad-json: "),
    "another server's": (Message("ok", 1, {"steer": 0.5, "left": True}).frames(), 0, "at steer 0.5, left True"),
    "terminal codes": (Message("ok", 1, {"a": ESC}).frames(), 0, "a ?]0;owned???client | done"),
    "a long text": (Message("ok", 1, {"a": "x" * 5000}).frames(), 0, "a " + "x" * 198 + "…"),
    "no reason": (Message("error", 1).frames(), 1, "gave up: not said: not said"),
    "odd types": (Message("error", 1, {"code": 5, "text": False}).frames(), 1, "gave up: 5: False"),
    "an error with terminal codes": (
        Message("error", 1, {"code": ESC, "text": "\0" + "y" * 5000}).frames(),
        1,
        "gave up: ?]0;owned???client | done: ?" + "y" * 199,
    ),
    "an unknown dtype": (
        [b'{"kind":"ok","version":1,"id":1,"values":{},"arrays":[{"dtype":"\\u001b[2J","shape":[]}]}', b""],
        1,
        r"gave up: bad-dtype: dtype '\x1b[2J",
    ),
    # The time for it must not grow with the square of their number.
    "very many frames": (
        [*Message("ok", 1).frames(), *[b""] * 200_000],
        1,
        "gave up: bad-frames: the header lists 0 arrays, but 200000 frames follow it",
    ),
}


@each_client
def test_an_odd_reply_ends_in_one_line(kind, context, runs):
    replies = iter([reply for reply, *_ in ODD.values()])
    with answering(context, lambda frames: next(replies)) as endpoint:
        # A busy machine takes a while to send 200,000 frames.
        found = runs(kind, KEY, [["--endpoint", endpoint, "--count", "1", "--timeout", "100"]] * len(ODD))
    for (name, (_, code, says)), run in zip(ODD.items(), found, strict=True):
        assert run.code == code, (name, run)
        # How an escaped character is written differs.
        assert says in run.lines[1].replace("\\u001b", "\\x1b"), name
        assert len(run.lines) == (2 if code else 3), (name, run)
        assert not re.search(r"[\x00-\x1f\x7f]|Traceback|Unhandled", "".join(run.lines)), (name, run)


def test_in_unity_a_server_that_was_restarted_is_found_again(serve, start_client):
    """The author of the Python side starts it again all day, while Unity plays."""
    pytest.importorskip("numpy", **NUMPY)
    endpoint = steady_endpoint()
    client = start_client("unity", KEY, endpoint, "--count", "1000000", "--timeout", "3")
    for _ in range(2):
        # Unity is first: it has asked nobody yet, or somebody who is gone.
        client.wait_for(f"^trouble: no reply from {endpoint} within 3 s", start=len(client.lines))
        server, _ = serve(KEY, endpoint=endpoint)
        client.wait_for(r"^\d+: sent frame", start=len(client.lines))
        server.kill()
    found = [re.findall(r"\d+", line)[:5] for line in client.lines if "brightest" in line]
    assert [int(number) for number, *_ in found] == list(range(1, len(found) + 1)), "each once, and in order"
    for number, frame, size, x, y in found:
        i = int(number)
        assert [frame, size, x, y] == [number, "230400", f"{16 * i % 320}", f"{8 * i % 240}"], "an answer to another"


# The server, asked by no message, or about no picture.


def picture(shape, dtype="uint8", data=None, kind="frame", **values):
    size = math.prod(shape) * messages.DTYPES[dtype]
    return Message(kind, 5, values, [Array(dtype, shape, bytes(size) if data is None else data)])


def unchecked(message):
    """The frames of what `frames` would not write."""
    arrays = [{"dtype": array.dtype, "shape": array.shape} for array in message.arrays]
    header = {"kind": message.kind, "version": 1, "id": message.id, "values": message.values, "arrays": arrays}
    return [json.dumps(header).encode(), *(array.data for array in message.arrays)]


REFUSED = {
    "a kind that no console can print": (Message("\x1b\n\0", 5), "unknown-kind"),
    "no array": (Message("frame", 5), "bad-shape"),
    "two arrays": (Message("frame", 5, {}, picture((2, 2, 3)).arrays * 2), "bad-shape"),
    "a picture of no pixels": (picture((0, 320, 3)), "bad-shape"),
    "four colours": (picture((2, 2, 4)), "bad-shape"),
    "a picture of floats": (picture((2, 2, 3), "float32"), "bad-shape"),
    "one number that is upside down": (picture((), bottom_up=True), "bad-shape"),
    "two of 35 MB": (unchecked(Message("echo", 5, {}, picture((35_000_000,)).arrays * 2)), "too-big"),
}


def test_what_cannot_be_answered_gets_an_error_reply_and_the_server_goes_on(serve, context):
    pytest.importorskip("numpy", **NUMPY)
    server, endpoint = serve(KEY)
    for name, (message, code) in REFUSED.items():
        reply = asked(context, endpoint, message)
        # What is too big is not read, so it has no id.
        assert (reply.kind, reply.id, reply.values["code"]) == ("error", 0 if code == "too-big" else 5, code), name
    data = bytes(3) * 2 + b"\x01\x02\x03" + bytes(3) * 3
    # "yes" is not true: a value of the wrong type must not turn a picture over.
    for values, y in (({}, 0), ({"bottom_up": True}, 1), ({"bottom_up": "yes"}, 0)):
        reply = asked(context, endpoint, picture((2, 3, 3), data=data, **values))
        assert reply.values == {"x": 2, "y": y, "mean": 0.3}
    assert server.stop() == 0
    assert "Traceback" not in server.output


def test_a_server_without_numpy_says_so_and_goes_on(start, context, tmp_path):
    (tmp_path / "numpy.py").write_text("raise ImportError")
    server = start(PYTHON, FOLDER / "server.py", "--endpoint", "tcp://127.0.0.1:*", PYTHONPATH=str(tmp_path))
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    reply = asked(context, endpoint, picture((2, 2, 3)))
    assert (reply.kind, reply.id, reply.values["code"]) == ("error", 5, "no-numpy")
    assert reply.values["text"] == "arrays need numpy where they are read: pip install numpy"
    assert asked(context, endpoint, Message("echo", 9)) == Message("ok", 9)
    assert server.stop() == 0
    assert "Traceback" not in server.output


def test_the_limit_counts_bytes_and_not_items():
    np = pytest.importorskip("numpy", **NUMPY)
    header = b'{"kind":"k","version":1,"id":1,"values":{},"arrays":[{"dtype":"float32","shape":[2,9000000]}]}'
    with pytest.raises(MessageError, match=r"^too-big: "):
        Message.read([header, np.zeros((2, 9_000_000), "float32")])
