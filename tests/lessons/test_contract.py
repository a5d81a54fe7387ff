"""Every program of every lesson keeps to this. They are found: a new lesson is under it before it has a test.

The table is *The contract of every program* in CONTRIBUTING.md. What a lesson's programs take is read from their own
--help; what cannot be read there stands in the few lines before the first test.
"""

import contextlib
import re
import signal
import socket
import sys
import time

import pytest
import zmq

from kitlib.lessons import Lesson, lessons
from tests.bad_peers import NetMQsFault, cuts_off_what_is_endless, greeting, ready
from tests.conftest import PYTHON
from tests.lessons.conftest import answering
from tests.programs import PATIENT, ROOT, finished, free_port, places

sys.path.append(str(ROOT / "python" / "15_security"))
from netmq_example import Server
from netmq_example.program import IN_USE
from netmq_example.security import keys

KEYS = [lesson.key for lesson in lessons()]
each_lesson = pytest.mark.parametrize("key", KEYS)
# Options that take any text; every other value can be wrong.
FREE_TEXT = {
    *["--record", "--hands", "--model", "--text", "--journal", "--topic", "--view"],
    *["--keys", "--build", "--server-key", "--prompt", "--origin", "--token", "--kind"],
}
# These speak to no stranger: the peers of this file get keys there as well.
KEYED = {"15_security"}
# How many there are at least is one.
NEVER_ZERO = {"--tries", "--window", "--workers", "--queue"}
# With its defaults a client ends by itself, and one component at Stop. These are given less to do.
SHORTER = {
    ("03_publish_subscribe", "server"): ["--interval", "0.004"],
    ("07_catch_up", "server"): ["--interval", "0.004"],
    ("12_video", "server"): ["--seconds", "0.2"],
    ("14_long_jobs", "server"): ["--workers", "1"],
    ("17_many_machines", "server"): ["--idle", "1"],
    ("21_talking_character", "server"): ["--workers", "1", "--delay", "0.01"],
    ("08_see_and_steer", "client"): ["--count", "10"],
    ("09_environment", "client"): ["--count", "1"],
    ("10_many_agents", "client"): ["--count", "1"],
    ("11_observations", "client"): ["--count", "1"],
    ("12_video", "client"): ["--count", "10"],
    ("14_long_jobs", "client"): ["--count", "10"],
    ("20_body_tracking", "client"): ["--count", "10"],
}

# A sign for each kind of harm: the screen, the line, the direction of writing, what looks like nothing, no character.
HARM = "\x1b[2J\x1b]0;title\x07 one\r\n2: sent \u202e \u2028 \u2029 \x85 \xad \ufeff \U0010ffff".encode() + b"\xff\0"
# With the lesson's port in them.
BAD = [
    "127.0.0.1:{}",
    "tcp://127.0.0.1",
    "tcp://127.0.0.1:99999",
    "tcp://127.0.0.1:x",
    "tcp://:{}",
    "tcp://[::1]:{}",
    "",
    "tcp://127.0.0.1:\u0665\u0661",
]
NO_HOST = ["tcp://no-such-host.invalid:{}", f"tcp://{'a' * 100}:{{}}"]

# It prints what a Python client tells its sockets: limits, and each wait of the main thread in milliseconds.
WATCHED = """
import threading, zmq
def waits(limit):
    if threading.current_thread() is threading.main_thread():
        print("waits", limit, flush=True)
class Watched(zmq.Socket):
    def connect(self, endpoint):
        print("connects", endpoint, self.maxmsgsize, self.linger, flush=True)
        return super().connect(endpoint)
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


def port(key):
    """The lesson's own."""
    return Lesson(key).port


def port_of(place):
    return int(place.rpartition(":")[2])


def at(key, place):
    """An endpoint of this lesson: of ZeroMQ, or of the web."""
    return place.replace("tcp", Lesson(key).scheme)


def told(key):
    """The words with which a server without keys listens for other machines too."""
    if key in KEYED:
        return []
    return ["--token", "word"] if Lesson(key).scheme == "http" else ["--open-to-anyone"]


def only_publishes(key):
    """Whether its server only speaks: what it is sent is never answered."""
    text = (Lesson(key).python / "server.py").read_text(encoding="utf-8")
    return set(re.findall(r"zmq\.(REP|ROUTER|PUB)\b", text)) == {"PUB"}


def secrets(key, folder):
    """The words for a server or a client of a lesson with keys, which are in the test's folder."""
    if key not in KEYED:
        return []
    if not (folder / "keys").exists():
        keys.example(folder / "keys")
    return ["--keys", str(folder / "keys")]


def give_keys(key, folder, peer, server):
    """The keys of that server, or of its client, for a socket of this file, where a lesson has keys."""
    if key in KEYED:
        own = f"{'server' if server else 'client'}.key_secret"
        peer.curve_publickey, peer.curve_secretkey = keys.load(folder / "keys" / own)
        if server:
            peer.curve_server = True
        else:
            peer.curve_serverkey = keys.load(folder / "keys" / "server.key")[0]


@contextlib.contextmanager
def rude_server(key, folder):
    """Answers with harm, or publishes it: where it listens, and whether anybody has come."""
    asked: list[bytes] = []

    def answer(frames):
        *way, text = frames
        asked.append(text)
        # Not for ever: who asks again at once is soon left waiting.
        if len(asked) > 20:
            return []
        # The way back and the id as they came: what a client takes for its reply. Or what it subscribed to.
        return [text[1:] + HARM] if only_publishes(key) else [*way, HARM]

    kind = zmq.XPUB if only_publishes(key) else zmq.ROUTER
    with (
        zmq.Context() as context,
        answering(context, answer, kind, lambda rude: give_keys(key, folder, rude, server=True)) as place,
    ):
        context.linger = 0
        yield place, asked


class Side:
    """A lesson's programs of one kind, which run one after the other, and the options that --help names."""

    def __init__(self, run, kind, key, folder):
        self.kind, self.key, self.folder = kind, key, folder
        self.run = lambda *words: run(kind, key, *secrets(key, folder), *words)
        self.help = "\n".join(self.run("--help").lines)
        # Behind the name is its value's, or in C# what the value is when it is left out, which may be empty.
        self.somewhere = ["--endpoint", Lesson(key).anywhere] if kind == "server" else []
        word = r"(--[\w-]+)( (?! \S))?" if kind in ("csharp", "unity") else r"^  (--[\w-]+)( [A-Z{])?"
        self.takes = dict(re.findall(word, self.help, re.MULTILINE))
        self.values = [name for name, value in self.takes.items() if value and name not in FREE_TEXT | {"--endpoint"}]

    def ends(self, words, code, *patterns):
        """One line of this run has all this."""
        if "--journal" in self.takes:
            # Each has its own: of two servers of one journal the second says only that.
            words = ["--journal", str(self.folder / f"{time.monotonic_ns()}.sqlite3"), *words]
        ended = self.run(*words)
        assert code in (None, ended.code) and ended.code in (0, 1, 2), (words, ended)
        assert [line for line in ended.lines if not line.isprintable()] == [], words
        assert not re.search("Traceback|Unhandled|^listening on ", "\n".join(ended.lines), re.MULTILINE), (words, ended)
        assert [line for line in ended.lines if all(re.search(each, line) for each in patterns)], (words, ended)
        return ended

    def impatient(self, timeout):
        """Words with which a client gives up soon."""
        return ["--timeout", timeout, *(["--tries", "2"] if "--tries" in self.takes else [])]

    def refuses(self):
        """An option that there is not, and for each value one that it cannot be."""
        self.ends(["--conut", "3"], 2, r"(^|error: )(unknown|unrecognized arguments): --conut")
        for name in self.values:
            # A number as a German writes it, and one that is too small.
            wrong = ["1,5", *(["-1"] if self.kind != "server" else []), *(["0"] if name in NEVER_ZERO else [])]
            # Unity's has one inspector for all.
            for each in wrong if self.kind != "unity" else wrong[: name == "--count"]:
                self.ends(
                    [*self.somewhere, name, each], 2, rf"(^(?!unknown)|error: ).*{name[2:]}\b|bad endpoint '{each}'"
                )

    def names_bad_endpoints(self, wrong, code, cure):
        for place in (at(self.key, each.format(port(self.key))) for each in wrong):
            host = place.partition("//")[2].partition(":")[0]
            why = f"unknown host '{host}'" if "no-such" in host or "aaa" in host else at(self.key, cure)
            ended = self.ends(["--endpoint", place], code, rf"bad endpoint '{re.escape(place)}': .*{re.escape(why)}")
            assert sum("bad endpoint" in line for line in ended.lines) == 1, ended

    def gives_up(self):
        """Where nobody listens."""
        place = at(self.key, f"tcp://127.0.0.1:{free_port()}")
        ended = self.ends(["--endpoint", place, *self.impatient("0.3")], 1)
        why = "\n".join(line for line in ended.lines if "gave up: " in line)
        assert place in why or f":{port_of(place) + 100}" in why, "what it waited for"
        assert re.search(r"\b0\.[36] s\b", why), "how long"
        assert "server" in why, "what to try"
        return ended

    def prints_what_it_is_sent(self, serve):
        with rude_server(self.key, self.folder) as (place, asked):
            second = ["--snapshots", place] if "--snapshots" in self.takes else []
            # What is behind a gateway is not the gateway's.
            if behind := [word for name, _ in Lesson(self.key).behind for word in (name, place)]:
                place = serve(self.key, *behind)[1]
            # It gives up, but not before it has asked or subscribed, for which on a busy machine a second may not do.
            for timeout in "1", "20":
                ended = self.ends(["--endpoint", place, *second, "--count", "1", *self.impatient(timeout)], None)
                if asked:
                    return
        raise AssertionError(("it asked nobody", ended))


# Runs that end by themselves


@each_lesson
def test_python_programs_say_why_they_end(key, run, serve, tmp_path, monkeypatch):
    with monkeypatch.context() as watched:
        (tmp_path / "sitecustomize.py").write_text(WATCHED, encoding="utf-8")
        watched.setenv("PYTHONPATH", str(tmp_path))
        server = Side(run, "server", key, tmp_path)
    server.refuses()
    server.names_bad_endpoints(BAD, 2, f"write it like tcp://127.0.0.1:{port(key)}")
    with socket.create_server(("127.0.0.1", 0)) as listener:
        taken = at(key, f"tcp://127.0.0.1:{listener.getsockname()[1]}")
        cure = at(key, "try --endpoint tcp://127.0.0.1:0, which takes a free port")
        for name in server.takes.keys() & {"--endpoint", "--snapshots"}:
            why = f"cannot listen on {taken}: {zmq.strerror(zmq.EADDRINUSE)}; {IN_USE}, or {cure}"
            server.ends([*server.somewhere, name, taken], 1, f"^{re.escape(why)}$")
            # Well written, but not of this machine.
            for place in at(key, "tcp://no-such-host.invalid:0"), at(key, "tcp://192.0.2.1:0"):
                server.ends([*server.somewhere, *told(key), name, place], 1, re.escape(place), cure)
            # For this machine alone, unless there are keys or it is told.
            for host in "0.0.0.0", "*", "192.0.2.1", "127.0.0.1.example.org":
                words = [*server.somewhere, name, at(key, f"tcp://{host}:0")]
                if Lesson(key).scheme == "http":
                    server.ends(words, 1, "everybody in the network could come in; give --token")
                elif key not in KEYED:
                    server.ends(words, 2, "would let anyone in, .*; use lesson 15's keys, or add --open-to-anyone")

    client = Side(run, "python", key, tmp_path)
    client.refuses()
    client.names_bad_endpoints([*BAD, *NO_HOST], 2, f"write it like tcp://127.0.0.1:{port(key)}")
    client.prints_what_it_is_sent(serve)
    ended = client.gives_up()
    if Lesson(key).scheme == "tcp":
        # On Windows Ctrl-C interrupts no wait of ZeroMQ's, and is heard between two of them.
        waits = [int(line.split()[1]) for line in ended.lines if line.startswith("waits ")]
        assert [wait for wait in waits if not 0 <= wait <= 200] == [], ended
        limits = [line.split()[2:] for line in ended.lines if line.startswith("connects tcp")]
        assert limits and all(0 < int(largest) < 2**30 and int(linger) >= 0 for largest, linger in limits), ended


FAULTS = {
    "an empty command": ("01_request_reply", b"NULL", ready(b"ROUTER") + b"\x04\0"),
    "a property of 4 GB": ("01_request_reply", b"NULL", b"\x04\x0c\x05READY\x01X" + b"\xff" * 4),
    "READY before WELCOME": ("15_security", b"CURVE", b"\x04\x2e\x05READY" + bytes(40)),
}


@pytest.mark.parametrize("name", FAULTS)
def test_what_netmq_cannot_read_ends_a_csharp_client_in_one_line(name, tmp_path, start_client):
    key, *bad = FAULTS[name]
    with NetMQsFault(*bad) as server:
        client = start_client("csharp", key, server.endpoint, *secrets(key, tmp_path))
        assert client.wait() == 1
    # On a busy machine a try may have been in vain before.
    why = "gave up: NetMQ cannot read what the server sent: .*; is it one of this kit\\?"
    assert re.fullmatch(why, client.lines[-1])


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such limit")
def test_too_few_open_files_are_one_line(tmp_path):
    """libzmq itself would abort in some lessons, and pyzmq print a traceback in others; program.py looks for all."""
    few = ["sh", "-c", 'ulimit -n 8; exec "$@"', "few", str(PYTHON)]
    for name in "server.py", "client.py":
        program = ROOT / "python" / "02_lazy_pirate" / name
        done = finished([*few, program, "--endpoint", "tcp://127.0.0.1:1"], cwd=tmp_path)
        assert (done.returncode, done.stdout) == (1, ""), done
        assert done.stderr.splitlines() == [
            "failed: it may open 8 files, and needs 32: allow more, as by ulimit -n 1024"
        ]


LISTENERS = {
    "03_publish_subscribe": "^received pose/",
    "07_catch_up": "^[0-9]+: at ",
    "20_body_tracking": "^person 0: ",
}


@each_lesson
def test_csharp_clients_say_why_they_end(key, run, serve, tmp_path):
    """Code that they share is asked for everything once."""
    # A Play goes on after an error, and says at its end that there was one.
    for kind, code in ("csharp", 2), ("unity", 1):
        client = Side(run, kind, key, tmp_path)
        assert at(key, f"--endpoint tcp://127.0.0.1:{port(key)} ") in client.help
        client.refuses()
        wrong = [*BAD, *NO_HOST] if key == KEYS[0] and kind == "csharp" else [BAD[2]]
        client.names_bad_endpoints(wrong, code, "write it like tcp://127.0.0.1:PORT")
        # A component that listens waits on.
        if not (kind == "unity" and key in LISTENERS):
            client.prints_what_it_is_sent(serve)
            client.gives_up()


@pytest.mark.parametrize("key", LISTENERS)
def test_a_component_that_listens_goes_on_after_an_outage(key, serve, start_client):
    """Of any length, which is here a second: it is logged once."""
    heard = LISTENERS[key]
    server, endpoint = serve(key)
    words = ["--count", "100000", "--every", "1", "--timeout", "0.4"]
    player = start_client("unity", key, endpoint, *words)
    player.wait_for(heard)
    server.kill()
    player.wait_for("^trouble: ", start=len(player.lines))
    away = len(player.lines)
    # Another program may take the port meanwhile: it listens, and accepts nobody.
    with socket.create_server(("127.0.0.1", port_of(endpoint))) as nobody:
        nobody.accept()
    serve(key, endpoint=endpoint)
    player.wait_for(heard, limit=60, start=away)
    assert not any(line.startswith("trouble: ") for line in player.lines[away:-1]), player.output


# A server of `[id][text]` is asked this, and answers that; and so begins its answer to lesson 01's client, which sends
# no id. The last two are those of one's own: netmq_example.Server and 04_background_client/Server.cs.
TEXTS = {
    "02_lazy_pirate": ("balance", "0", "error: expected two frames, [id][text]"),
    "04_background_client": ("echo größer", "größer", "error: expected two frames, [id][text]"),
    "06_many_in_flight": ("echo größer", "größer", "größer"),
    "Python": ("hi", "HI", "HI"),
    "C#": ("echo größer", "größer", "größer"),
}


@pytest.mark.parametrize("key", TEXTS)
def test_every_client_of_an_id_and_a_text_fits_every_server_of_them(key, csharp_kinds, serve, game, run):
    text, reply, without = TEXTS[key]
    with Server(str.upper) as own:
        endpoint = own.endpoint if key == "Python" else game()[1] if key == "C#" else serve(key)[1]
        for kind in ["python", *csharp_kinds[:1]]:
            for client, expected in [*((client, f"{reply}\n") for client in [*TEXTS][:3]), (KEYS[0], without)]:
                done = run(kind, client, "--endpoint", endpoint, "--count", "2", "--text", text, *PATIENT)
                assert f"2: sent {text}, received {expected}" in "\n".join(done.lines), (kind, client, done)


# A server goes on, and ends


@pytest.fixture
def csharp_kinds(request):
    """Of which kinds there are C# clients here."""
    try:
        request.getfixturevalue("csharp_in_turn")
    except pytest.skip.Exception:
        return []
    return ["csharp", "unity"]


@each_lesson
def test_a_server_serves_on_whatever_comes_and_leaves_its_ports(key, csharp_kinds, serve, run, tmp_path, start_client):
    own = [*secrets(key, tmp_path), *SHORTER.get((key, "server"), [])]
    for name, other in Lesson(key).behind:
        own += [name, serve(other.key)[1]]
    # Its lines are flushed, also where Python is not told to.
    server, endpoint = serve(key, *own, endpoint="tcp://127.0.0.1:*", PYTHONUNBUFFERED="")
    assert re.fullmatch(at(key, r"tcp://127\.0\.0\.1:[1-9]\d+"), endpoint)

    second = [word for name, place in places(server).items() if name != "listening" for word in (f"--{name}", place)]
    words = [*secrets(key, tmp_path), *second, *SHORTER.get((key, "client"), []), *PATIENT]
    whole = greeting()
    half = [b"GET / HTTP/1.1\r\n\r\n", b"\0" * 5000, b"\xff" * 64, whole[:20], whole, whole + b"\x04\xff" * 20]
    with zmq.Context() as context, context.socket(zmq.DEALER) as rude:
        # A PUB socket takes no notice, and hangs up: then there is nobody to send to, and a send would wait for ever.
        rude.linger = 0
        rude.sndtimeo = 0 if only_publishes(key) else 100_000
        give_keys(key, tmp_path, rude, server=False)
        for place in places(server).values():
            for noise in half:
                with socket.create_connection(("127.0.0.1", port_of(place)), timeout=20) as raw:
                    raw.sendall(noise)
            if key not in KEYED and Lesson(key).scheme == "tcp":
                with socket.create_connection(("127.0.0.1", port_of(place)), timeout=20) as raw:
                    assert cuts_off_what_is_endless(raw), place
            rude.connect(place.replace("http", "tcp"))
        # Without REQ's empty frame, with it, and with an id: each kind of server answers one of them. And lesson 09's
        # records begin with a 2.
        framed = [b"", HARM], [b"", HARM, HARM]
        bare = [HARM], [HARM, HARM], [HARM[:50], HARM], [b"\2" + HARM], [b"\2"]
        # REP answers the framed ones: 8, while a server of large answers keeps 10 for a client that has not read. With
        # more to keep, libzmq up to 4.3.5 takes what has no empty frame so that the next client's reply is lost.
        flood = (framed + bare) * 4 + bare * 20
        for frames in framed + bare if only_publishes(key) else flood:
            with contextlib.suppress(*([zmq.Again] if only_publishes(key) else [])):
                rude.send_multipart(frames)
        if not only_publishes(key) and Lesson(key).scheme == "tcp":
            assert rude.poll(100_000), "no answer to what is no request"
            assert HARM not in rude.recv_multipart()[-1:]
        # While the stranger is still there: where it has left, the same happens. Asking again is lesson 02.
        client = start_client("python", key, endpoint, *words)
        assert client.wait() == 0, client.output
    # The contract says half a second; the rest is the interpreter's own end on a busy machine.
    assert server.stop(signal.SIGINT, limit=30) == 0, server.output
    assert fits_a_terminal(server), server.output
    # The client knows what is wrong: a flood of messages is no flood of lines. Lesson 15 names all whom it lets in.
    assert key in KEYED or len(server.lines) < 50, server.output
    # The ports are free again, for other machines too.
    everywhere = [word.replace("127.0.0.1", "0.0.0.0") for word in (endpoint, *second)]
    again, _ = serve(key, *own, *told(key), *everywhere[1:], endpoint=everywhere[0])
    assert {name: place.replace("0.0.0.0", "127.0.0.1") for name, place in places(again).items()} == places(server)
    for kind in csharp_kinds:
        more = [*(told(key) if Lesson(key).scheme == "http" else []), *(["--seen"] if kind == "unity" else [])]
        client = run(kind, key, "--endpoint", endpoint, *words, *more)
        assert client.code == 0, client
        # The editor's window shows its messages.
        if kind == "unity" and Lesson(key).scheme == "tcp":
            shown = re.search(r"^shown: (\d+) sent, (\d+) received$", client.lines[-1])
            assert int(shown[2]) > 0 and (int(shown[1]) > 0 or only_publishes(key)), client
    assert again.stop(signal.SIGTERM, limit=30) == 0, again.output
    assert fits_a_terminal(again), again.output


def fits_a_terminal(server):
    return all(line.isprintable() and "Traceback" not in line for line in server.lines)


BUSY = {KEYS[0]: ["--delay", "60"], "03_publish_subscribe": ["--interval", "0"], "07_catch_up": ["--interval", "0"]}


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals to end a program with")
@pytest.mark.parametrize("key", BUSY)
def test_a_busy_server_ends_at_once(key, serve, connect):
    server, endpoint = serve(key, *BUSY[key])
    if not only_publishes(key):
        connect(endpoint).send_multipart([b"", b"Hello"])
        # Not a wait for something: it sleeps by then.
        time.sleep(0.2)
    assert server.stop(limit=30) == 0
    assert "Traceback" not in server.output


@pytest.mark.parametrize("key", [KEYS[0], *(lesson.key for lesson in lessons() if lesson.scheme == "http")])
@pytest.mark.skipif(sys.platform == "win32", reason="there every test ends its servers so")
def test_a_server_takes_windows_ctrl_break_for_ctrl_c(key, serve, tmp_path):
    """It is what one program can send another there. Here another signal has its name."""
    (tmp_path / "sitecustomize.py").write_text("import signal\nsignal.SIGBREAK = signal.SIGUSR1\n", encoding="utf-8")
    behind = [word for name, _ in Lesson(key).behind for word in (name, "tcp://127.0.0.1:1")]
    server, _ = serve(key, *behind, endpoint="tcp://127.0.0.1:0", PYTHONPATH=str(tmp_path))
    assert server.stop(signal.SIGUSR1) == 0, server.output
    assert "Traceback" not in server.output
