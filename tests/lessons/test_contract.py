"""What every program of every lesson keeps to, found by discovery: a new lesson is under it before it has a test.

The table is *The contract of every program* in CONTRIBUTING.md. What a lesson's programs take is read from their own
--help; what cannot be read there stands in the few lines before the first test.
"""

from __future__ import annotations

import functools
import re
import signal
import socket
import sys

import pytest
import zmq

from kitlib.lessons import Lesson, lessons
from tests.bad_peers import EndlessPeer, cuts_off_what_is_endless
from tests.conftest import CLIENTS, PYTHON
from tests.programs import LIMIT, PATIENT, ROOT, finished, free_port

sys.path.append(str(ROOT / "python" / "15_security"))
from netmq_example.security import keys

KEYS = [lesson.key for lesson in lessons()]
each_lesson = pytest.mark.parametrize("key", KEYS)
each_client = pytest.mark.parametrize("kind", CLIENTS)
# Options that take any text; every other value can be wrong.
FREE_TEXT = {
    "--record",
    "--hands",
    "--model",
    "--text",
    "--journal",
    "--topic",
    "--view",
    "--keys",
    "--build",
    "--server-key",
    "--prompt",
    "--origin",
    "--token",
    "--kind",
}
# What speaks to no stranger: the peers of this file get keys there as well.
KEYED = {"15_security"}
# A component that goes on until Stop, as one who adds it to a scene wants it.
ENDLESS = {("20_body_tracking", "unity"): ["--count", "10"]}
# How many there are at least is one.
NEVER_ZERO = {"--tries", "--window", "--workers", "--queue"}

# A sign for each kind of harm: the screen, the line, the direction of writing, what looks like nothing, no character.
HARM = "\x1b[2J\x1b]0;title\x07 one\r\n2: sent \u202e \u2028 \u2029 \x85 \xad \ufeff \U0010ffff".encode() + b"\xff\0"


@functools.cache
def options(program: str) -> dict[str, str]:
    """The options that a Python program says it takes, each with the name of its value, or nothing for a switch."""
    helped = finished([PYTHON, program, "--help"], cwd=ROOT)
    return dict(re.findall(r"^  (--[\w-]+)(?: ([A-Z{]\S*))?", helped.stdout, re.MULTILINE))


def server_of(key):
    return f"python/{key}/server.py"


def client_of(key):
    return f"python/{key}/client.py"


def port(key):
    """The lesson's own."""
    return 5550 + int(key[:2])


def at(key, place):
    """An endpoint of this lesson: of ZeroMQ, or of the web."""
    return place.replace("tcp", Lesson(key).scheme)


def told(key):
    """The words with which a server without keys listens for other machines too."""
    if key in KEYED:
        return []
    return ["--token", "word"] if Lesson(key).scheme == "http" else ["--open-to-anyone"]


def takes(key, kind, name):
    """Whether this client has this option; in Unity a serialized field is one."""
    if kind == "unity":
        scripts = [path.read_text(encoding="utf-8") for path in (ROOT / "unity/Assets/NetMQExample" / key).glob("*.cs")]
        return any(re.search(rf"SerializeField.*\] private \S+ {name[2:]}\b", script) for script in scripts)
    return name in options(client_of(key))


def only_publishes(key):
    """Whether its server only speaks: what it is sent is never answered."""
    sockets = set(re.findall(r"zmq\.(REP|ROUTER|PUB)\b", (ROOT / server_of(key)).read_text(encoding="utf-8")))
    return sockets == {"PUB"}


def patient(key, kind):
    return PATIENT if takes(key, kind, "--timeout") else ()


def impatient(key, kind, timeout="0.3"):
    """Options with which a client gives up soon."""
    return ["--timeout", timeout, *(["--tries", "2"] if takes(key, kind, "--tries") else [])]


@pytest.fixture
def serve(serve, tmp_path):
    """As the shared one, and what a server keeps it keeps in the test's folder."""

    def serve_there(key, *words, **where):
        return serve(key, *kept_there(key, tmp_path), *words, **where)

    return serve_there


def kept_there(key, folder):
    if key in KEYED:
        return ["--keys", str(folder / "keys")]
    return ["--journal", str(folder / "journal.sqlite3")] if "--journal" in options(server_of(key)) else []


@pytest.fixture
def client_command(client_command, tmp_path):
    """As the shared one, and where a lesson has keys, with those that its server makes for a first client."""

    def command(kind, key, endpoint, *words):
        if key in KEYED and not (tmp_path / "keys").exists():
            keys.example(tmp_path / "keys")
        return client_command(kind, key, endpoint, *(kept_there(key, tmp_path) if key in KEYED else []), *words)

    return command


def give_keys(key, folder, socket, server):
    """The keys of that server, or of its client, for a socket of this file, where a lesson has keys."""
    if key in KEYED:
        socket.curve_publickey, socket.curve_secretkey = keys.load(
            folder / f"{'server' if server else 'client'}.key_secret"
        )
        if server:
            socket.curve_server = True
        else:
            socket.curve_serverkey = keys.load(folder / "server.key")[0]


def places(server):
    """Where a server listens, all its endpoints: {"listening": …, "snapshots": …}."""
    return dict(re.findall(r"^(\w+) on ((?:tcp|http)://\S+)$", server.output, re.MULTILINE))


def ended(program, code, limit=LIMIT):
    """The last line of a program that has ended with this code, and not in a traceback."""
    assert program.wait(limit) == code, program.output
    assert "Traceback" not in program.output
    assert "Unhandled" not in program.output
    return program.lines[-1]


# A server begins


@each_lesson
@pytest.mark.parametrize("free", ["0", "*"])
def test_port_0_and_a_star_take_a_free_port_and_the_ready_line_has_it(key, free, serve):
    server, endpoint = serve(key, endpoint=at(key, f"tcp://127.0.0.1:{free}"))
    assert re.fullmatch(at(key, r"tcp://127\.0\.0\.1:[1-9]\d+"), endpoint)
    for place in places(server).values():
        socket.create_connection(("127.0.0.1", int(place.rpartition(":")[2])), timeout=20).close()


@each_lesson
def test_the_default_port_is_the_lessons_own_everywhere(key):
    """In the server, in both terminal clients, and in a component."""
    lesson = next(lesson for lesson in lessons() if lesson.key == key)
    for paths in (
        [lesson.python / "server.py"],
        [lesson.python / "client.py"],
        [lesson.console],
        sorted(lesson.unity.glob("*.cs")),
    ):
        ports = [re.findall(r'"(?:tcp|http)://127\.0\.0\.1:(\d+)"', path.read_text(encoding="utf-8")) for path in paths]
        assert any(str(port(key)) in found for found in ports), paths


BAD = [
    "127.0.0.1:{}",
    "tcp://127.0.0.1",
    "tcp://127.0.0.1:99999",
    "tcp://127.0.0.1:x",
    "tcp://:{}",
    "",
    "tcp://127.0.0.1:\u0665\u0661",
]
NO_HOST = ["tcp://no-such-host.invalid:{}", f"tcp://{'a' * 100}:{{}}"]


@each_lesson
def test_a_server_names_what_is_wrong_with_an_endpoint(key, start, tmp_path):
    wrong = {at(key, endpoint.format(port(key))): 2 for endpoint in BAD}
    # Well written, but not of this machine.
    wrong |= {at(key, "tcp://no-such-host.invalid:0"): 1, at(key, "tcp://192.0.2.1:0"): 1}
    servers = {}
    for number, endpoint in enumerate(wrong):
        # Each has its own: of two servers of one journal the second says only that.
        (own := tmp_path / str(number)).mkdir()
        servers[endpoint] = start(PYTHON, server_of(key), *kept_there(key, own), *told(key), "--endpoint", endpoint)
    for endpoint, server in servers.items():
        line = ended(server, wrong[endpoint])
        assert endpoint in line
        cure = "try --endpoint tcp://127.0.0.1:0" if wrong[endpoint] == 1 else f"like tcp://127.0.0.1:{port(key)}"
        assert at(key, cure) in line
        assert "listening" not in server.output


@each_lesson
def test_a_server_without_keys_is_for_this_machine_alone_unless_it_is_told(key, start, tmp_path):
    for name in {"--endpoint", "--snapshots"} & options(server_of(key)).keys():

        def begin(host, *words, name=name):
            elsewhere = ["--endpoint", "tcp://127.0.0.1:0"] if name == "--snapshots" else []
            command = [PYTHON, ROOT / server_of(key), *elsewhere, name, at(key, f"tcp://{host}:0"), *words]
            return start(*command, folder=tmp_path)

        for server in [begin(host) for host in ("0.0.0.0", "*", "192.0.2.1", "127.0.0.1.example.org")]:
            if Lesson(key).scheme == "http":
                assert "everybody in the network could come in; give --token" in ended(server, 1)
            else:
                assert "lets anyone in: lesson 15 has keys, --open-to-anyone has none" in ended(server, 2)
        begin("0.0.0.0", *told(key), *kept_there(key, tmp_path)).wait_for(at(key, r"^\w+ on tcp://0\.0\.0\.0:"))


@each_lesson
def test_a_taken_port_is_named_with_its_cure(key, serve, start, tmp_path):
    server, _ = serve(key)
    elsewhere = tmp_path / "another"
    elsewhere.mkdir()
    for name, place in places(server).items():
        words = (
            ["--endpoint", place] if name == "listening" else ["--endpoint", "tcp://127.0.0.1:0", f"--{name}", place]
        )
        second = start(PYTHON, server_of(key), *kept_there(key, elsewhere), *words)
        cause = zmq.strerror(zmq.EADDRINUSE)
        cure = at(key, "try --endpoint tcp://127.0.0.1:0, which takes a free port")
        assert ended(second, 1) == f"cannot listen on {place}: {cause}; {cure}"
        assert "listening" not in second.output


# A server goes on, and ends


@each_lesson
def test_what_strangers_send_does_not_end_a_server_and_is_printed_without_harm(
    key, serve, start, client_command, tmp_path
):
    server, endpoint = serve(key)
    greeting = b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(16 + 32)
    half = [b"GET / HTTP/1.1\r\n\r\n", b"\0" * 5000, b"\xff" * 64, greeting[:20], greeting, greeting + b"\x04\xff" * 20]
    for place in places(server).values():
        for noise in half:
            with socket.create_connection(("127.0.0.1", int(place.rpartition(":")[2])), timeout=20) as raw:
                raw.sendall(noise)
    with zmq.Context() as context, context.socket(zmq.DEALER) as rude:
        # A PUB socket takes no notice.
        rude.linger = 0
        give_keys(key, tmp_path / "keys", rude, server=False)
        for place in places(server).values():
            rude.connect(place.replace("http", "tcp"))
        # Without REQ's empty frame, with it, and with an id: each kind of server answers one of them.
        strange = [HARM], [HARM, HARM], [b"", HARM], [b"", HARM, HARM], [HARM[:50], HARM]
        for frames in strange * (1 if only_publishes(key) else 50):
            rude.send_multipart(frames)
        if not only_publishes(key) and Lesson(key).scheme == "tcp":
            assert rude.poll(100_000), "no answer to what is no request"
            assert HARM not in rude.recv_multipart()[-1:]
        # While the stranger is still there: when one that sends REP no empty frame leaves at once, libzmq up to 4.3.5
        # loses the next client's reply, and asking again is lesson 02.
        words = ["--count", "1"] if "--count" in options(client_of(key)) else []
        words += ["--timeout", "20"] if takes(key, "python", "--timeout") else []
        client = start(*client_command("python", key, endpoint, *words))
        assert client.wait() == 0, client.output
    assert server.stop() == 0, server.output
    assert "Traceback" not in server.output
    assert [line for line in server.lines if not line.isprintable()] == []
    # Whoever asked knows what is wrong: a flood of messages is no flood of lines. Lesson 15 names all whom it lets in.
    assert key in KEYED or len(server.lines) < 50, server.output


def needs_no_keys(key):
    if key in KEYED or Lesson(key).scheme == "http":
        pytest.skip("who has no key, or speaks ZeroMQ to a web server, does not come so far")


@each_lesson
def test_who_announces_too_much_is_cut_off_by_a_server(key, serve):
    needs_no_keys(key)
    server, _ = serve(key)
    for place in places(server).values():
        with socket.create_connection(("127.0.0.1", int(place.rpartition(":")[2])), timeout=20) as raw:
            assert cuts_off_what_is_endless(raw), place


@each_lesson
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to end a program with")
def test_a_server_ends_at_once_and_leaves_its_ports(key, how, serve):
    server, endpoint = serve(key)
    # The contract says half a second; the rest is the interpreter's own end on a busy machine.
    assert server.stop(how, limit=30) == 0
    assert "Traceback" not in server.output
    again, same = serve(key, endpoint=endpoint)
    assert same == endpoint
    assert places(again) == places(server)
    assert again.stop() == 0


@each_lesson
@pytest.mark.skipif(sys.platform == "win32", reason="there every test ends its servers so")
def test_a_server_takes_windows_ctrl_break_for_ctrl_c(key, serve, tmp_path):
    """It is what one program can send another there. Here another signal has its name."""
    (tmp_path / "sitecustomize.py").write_text("import signal\nsignal.SIGBREAK = signal.SIGUSR1\n", encoding="utf-8")
    server, _ = serve(key, PYTHONPATH=str(tmp_path))
    assert server.stop(signal.SIGUSR1) == 0, server.output
    assert "Traceback" not in server.output


# A client


@each_lesson
@each_client
def test_a_client_with_its_defaults_ends_by_itself(key, kind, serve, start, client_command):
    _, endpoint = serve(key)
    options = [*ENDLESS.get((key, kind), []), *patient(key, kind)]
    client = start(*client_command(kind, key, endpoint, *options))
    ended(client, 0, limit=500)


@each_lesson
@each_client
def test_a_client_without_a_server_gives_up(key, kind, start, client_command):
    endpoint = at(key, f"tcp://127.0.0.1:{free_port()}")
    client = start(*client_command(kind, key, endpoint, *impatient(key, kind)))
    ended(client, 1)
    why = "\n".join(line for line in client.lines if "gave up: " in line)
    higher = f"tcp://127.0.0.1:{int(endpoint.rpartition(':')[2]) + 100}"
    assert endpoint in why or higher in why, "what it waited for"
    assert re.search(r"\b0\.[36] s\b", why), "how long"
    assert "server" in why, "what to try"


@each_lesson
@each_client
def test_a_client_names_what_is_wrong_with_an_endpoint(key, kind, start, client_command):
    """All of it where each lesson has a check of its own; what is shared is asked for everything once."""
    wrong = [*BAD, *NO_HOST] if kind == "python" or key == KEYS[0] else [BAD[2]]
    # A Play goes on after an error, and says at its end that there was one.
    code = 1 if kind == "unity" else 2
    clients = {}
    for endpoint in (at(key, each.format(port(key))) for each in wrong):
        clients[endpoint] = start(*client_command(kind, key, endpoint))
    for endpoint, client in clients.items():
        ended(client, code)
        (line,) = [line for line in client.lines if f"bad endpoint '{endpoint}'" in line]
        if "no-such" in endpoint or "aaa" in endpoint:
            assert f"unknown host '{endpoint.partition('//')[2].partition(':')[0]}'" in line
        else:
            assert at(key, f"write it like tcp://127.0.0.1:{port(key) if kind == 'python' else 'PORT'}") in line
        assert kind != "python" or not [line for line in client.lines if line.startswith("asking")], "it asks nobody"


@each_lesson
@each_client
def test_what_a_server_sends_is_printed_without_harm(key, kind, serve, start, client_command, tmp_path):
    kind_of_server = zmq.XPUB if only_publishes(key) else zmq.ROUTER
    with zmq.Context() as context, context.socket(kind_of_server) as router:
        router.linger = 0
        if key in KEYED:
            keys.example(tmp_path / "keys")
        give_keys(key, tmp_path / "keys", router, server=True)
        endpoint = f"tcp://127.0.0.1:{router.bind_to_random_port('tcp://127.0.0.1')}"
        second = ["--snapshots", endpoint] if takes(key, kind, "--snapshots") else []
        # What is behind a gateway is not the gateway's.
        if Lesson(key).behind:
            endpoint = serve(key, *[word for name, _ in Lesson(key).behind for word in (name, endpoint)])[1]
        asked = False
        # It gives up, but not before it has asked or subscribed, for which on a busy machine two seconds may not do.
        for timeout in ["20"] if Lesson(key).behind else ["2", "20"]:
            words = [*second, "--count", "1", *impatient(key, kind, timeout)]
            client = start(*client_command(kind, key, endpoint, *words))
            while client.process.poll() is None:
                if router.poll(50):
                    *way, text = router.recv_multipart()
                    # The way back and the id as they came: what a client takes for its reply. Or what it subscribed to.
                    router.send_multipart([text[1:] + HARM] if only_publishes(key) else [*way, HARM])
                    asked = True
            assert client.wait() in (0, 1), client.output
            if asked:
                break
    assert asked, client.output
    assert [line for line in client.lines if not line.isprintable()] == []
    assert "Traceback" not in client.output


@each_lesson
@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_who_announces_too_much_is_cut_off_by_a_client(key, kind, start, client_command):
    """Unity's is the same C# client."""
    needs_no_keys(key)
    with EndlessPeer() as peer:
        # The stream's connection, and that for snapshots.
        second = ["--snapshots", peer.endpoint] if takes(key, kind, "--snapshots") else []
        # So that it does not hang up for another reason: before it sends its request again.
        start(*client_command(kind, key, peer.endpoint, *second, *patient(key, kind)))
        for _ in ["", *second[1:]]:
            assert peer.cut_off.get(timeout=LIMIT)


WAITS = """
import threading, zmq
# Each wait of the main thread, in milliseconds; -1 has no end.
def waits(limit):
    if threading.current_thread() is threading.main_thread():
        print("waits", limit, flush=True)
class Watched(zmq.Socket):
    def poll(self, timeout=None, flags=zmq.POLLIN):
        waits(-1 if timeout is None else timeout)
        return super().poll(timeout, flags)
    def recv(self, flags=0, *more, **named):
        waits(0 if flags & zmq.NOBLOCK else self.rcvtimeo)
        return super().recv(flags, *more, **named)
    def send(self, data, flags=0, *more, **named):
        # A new socket has room at once, unless it wants a connection first.
        waits(0 if flags & zmq.NOBLOCK or not self.immediate else self.sndtimeo)
        return super().send(data, flags, *more, **named)
zmq.Context._socket_class = Watched
"""


@each_lesson
def test_a_client_waits_in_slices(key, start, client_command, tmp_path):
    """On Windows Ctrl-C interrupts no wait of ZeroMQ's: it is heard between two of them."""
    if Lesson(key).scheme == "http":
        pytest.skip("it waits in asyncio, which hears Ctrl-C")
    (tmp_path / "sitecustomize.py").write_text(WAITS, encoding="utf-8")
    words = client_command("python", key, f"tcp://127.0.0.1:{free_port()}", *impatient(key, "python", "0.9"))
    client = start(*words, PYTHONPATH=str(tmp_path))
    ended(client, 1)
    waits = [int(line.split()[1]) for line in client.lines if line.startswith("waits ")]
    assert [wait for wait in waits if not 0 <= wait <= 200] == [], client.output


# Wrong usage


def mistakes(program):
    """Words that a program must refuse: an option that there is not, and for each value one that it cannot be."""
    found = [["--conut", "3"]]
    for name, value in options(program).items():
        if value and name not in FREE_TEXT | {"--endpoint"}:
            # A number as a German writes it, and one that is too small.
            found += [
                [name, wrong]
                for wrong in ("1,5", "-1" if program.endswith("client.py") else "", "0" * (name in NEVER_ZERO))
            ]
    return [words for words in found if words[1]]


@each_lesson
@pytest.mark.parametrize("side", ["server", *CLIENTS])
def test_wrong_usage_is_one_line_and_2(key, side, start, client_command, tmp_path):
    wrong = mistakes(server_of(key) if side == "server" else client_of(key))
    if side == "csharp":
        wrong = [words for words in wrong if words[0] in twins_options(key, client_command) or words[0] == "--conut"]
    if side == "unity":
        # One inspector for all: what is no field, and what is no number.
        wrong = [["--conut", "3"], ["--count", "1,5"]]
    programs = []
    for number, words in enumerate(wrong):
        if side == "server":
            # Each has its own: of two servers of one journal the second says only that.
            (own := tmp_path / str(number)).mkdir()
            command = [PYTHON, server_of(key), *kept_there(key, own), "--endpoint", Lesson(key).anywhere, *words]
        else:
            command = client_command(side, key, at(key, "tcp://127.0.0.1:1"), *words)
        programs.append(start(*command))
    for words, program in zip(wrong, programs, strict=True):
        assert words[0].lstrip("-") in ended(program, 2) or f"bad endpoint '{words[1]}'" in program.lines[-1], words


def twins_options(key, client_command):
    """A few of the Python client's options are not the C# version's."""
    asked = finished(client_command("csharp", key, "", "--help"))
    return re.findall(r"--[\w-]+", asked.stderr)
