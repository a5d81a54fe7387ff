"""Lesson 01: the happy path of each client, strict alternation, and everything that must not stop the server."""

import shlex
import shutil
import subprocess
import sys

import pytest

from netmq_example import replies, trouble
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import answering, ask
from tests.programs import PATIENT, ROOT, finished, steady_endpoint

KEY = "01_request_reply"
SERVER = ROOT / "python" / KEY / "server.py"


def test_a_second_request_before_the_reply_is_refused(serve, run):
    """A transcript of the page has what the C# client says."""
    _, endpoint = serve(KEY)
    client = run("python", KEY, "--endpoint", endpoint, "--count", "1", "--send-twice", *PATIENT)
    assert client.code == 0, client
    assert client.lines == [
        f"asking {endpoint}",
        "refused: ZMQError: Operation cannot be accomplished in current state",
        "received World: now REQ may send again",
        "1: sent Hello, received World",
        "done: 1 replies",
    ]


SLOW = {"RES_OPTIONS": "timeout:30 attempts:5"}
SILENCE = """
import os, re, socket, subprocess, sys
subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
named = re.findall(r"^nameserver\\s+(\\d[\\d.]+)", open("/etc/resolv.conf").read(), re.MULTILINE)
for server in named or ["127.0.0.1"]:
    subprocess.run(["ip", "address", "add", server + "/32", "dev", "lo"])
    ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    ear.bind((server, 53))
    os.set_inheritable(ear.fileno(), True)
os.execvp(sys.argv[1], sys.argv[1:])
"""


def test_a_silent_name_server_is_not_waited_for_long(start, client_command):
    """In a network of its own, in which the system's name servers hear and say nothing."""
    before = ["unshare", "-rn", str(PYTHON), "-c", SILENCE]
    if not shutil.which("unshare") or not shutil.which("ip") or subprocess.run([*before, "true"]).returncode:
        pytest.skip("there is no unshare and ip here, for a network with a silent name server")
    client = start(*before, *client_command("csharp", KEY, "tcp://no-such-host.example:5551"), **SLOW)
    assert client.wait() == 1, client.output
    if "unknown host" in client.output:
        pytest.skip("a name server cannot be silenced here")
    assert "gave up: no address for host 'no-such-host.example' within 5 s" in client.output


def test_a_bad_request_gets_an_error_and_the_next_one_an_answer(serve, context):
    """The client knows it: a flood of bad requests is no flood of lines."""
    server, endpoint = serve(KEY)
    for _ in range(20):
        assert ask(context, endpoint, b"\x1b[2J") == [rb"error: expected Hello, got '\x1b[2J'"]
    assert ask(context, endpoint, b"Hello", b"Hello")[0].startswith(b"error: expected ")
    # The second and the third as the clients of older tutorials send it.
    for hello in b"Hello", b"Hello\0", b"Hello ":
        assert ask(context, endpoint, hello) == [b"World"]
    server.wait_for("^sent ", start=3)
    assert server.stop() == 0
    assert server.lines == [f"listening on {endpoint}", *["sent b'World'"] * 3]


def test_a_text_that_the_server_would_not_take_is_named(run, serve):
    long = run("python", KEY, "--endpoint", "tcp://127.0.0.1:1", "--text", "ü" * 32_769)
    assert long.code == 2 and "--text takes at most 65536 bytes" in long.lines[-1], long
    right = run("python", KEY, "--endpoint", serve(KEY)[1], "--text", "ü" * 32_768, "--count", "1", *PATIENT)
    assert right.lines[-1] == "done: 1 replies", right


def shown(text):
    """The clients show a reply so; Python's own isprintable() is the judge."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


@pytest.mark.parametrize("kind", CLIENTS)
def test_any_reply_is_printed_in_one_line_and_without_harm(kind, run, context):
    texts = [
        "Wörld ✓",
        "\x1b[2J\x1b]0;title\x07 clear the screen",
        "one\r\n2: sent Hello, received World\x00",
        "to the left \u202e, a line \u2028 and a paragraph \u2029, \xa0 \u3000 \ufeff \xad \x85",
        "private \ue000 \U000f0000, no character \uffff \U0010ffff, an emoji \U0001f600 \u0378",
        "\U0001f600" * 201,
        "x" * 60_000,
        "y" * 200,
    ]
    # A message is all of its frames.
    several = [b"one", b"two", b"\xff\xd8\xff", b""]
    replies = iter([*([text.encode()] for text in texts), several])
    with answering(context, lambda frames: next(replies) if frames == [b"Hello"] else frames) as endpoint:
        client = run(kind, KEY, "--endpoint", endpoint, "--count", str(len(texts) + 1), *PATIENT)
    assert client.code == 0, client
    lines = [f"{i}: sent Hello, received {shown(text)}" for i, text in enumerate([*texts, "one two (3 bytes) "], 1)]
    assert client.lines == [f"asking {endpoint}", *lines, f"done: {len(lines)} replies"]


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_reply_that_is_too_large_is_not_read(kind, run, context):
    replies = iter([[b"x" * 65_536], [b"x" * 65_537]])
    with answering(context, lambda frames: next(replies)) as endpoint:
        client = run(kind, KEY, "--endpoint", endpoint, "--timeout", "6")
    assert client.code == 1, client
    assert client.lines[1] == f"1: sent Hello, received {'x' * 200}…"
    assert client.lines[2].startswith("gave up: no reply from ")
    assert client.lines[2].endswith("; is the server running, or its reply over 64 KB?")


def raising(text):
    raise ValueError(text)


# An answer, the request, and how its reply begins. The last ones may be the fault of whoever asked.
MISTAKES = [
    # Two servers of one program fail in the same line, and a client hangs up on a reply of more than 64 KB.
    (lambda text: raising(text), b"no\nsuch world", "error: ValueError('no\\nsuch world')"),
    (lambda text: raising(text * 2), b"x" * 65_000, "error: ValueError('xxx"),
    (lambda text: None, b"ask", "error: answer returned None: return a text"),
    (lambda text: "\ud800", b"ask", "error: answer returned what cannot be sent: 'utf-8' codec can't encode"),
    (lambda text: "x" * 65_537, b"", "error: answer returned what cannot be sent: a text of 65537 bytes, more than"),
]


def test_a_mistake_in_ones_own_answer_is_told_to_both_sides(printed, monkeypatch):
    """In one line; and the first time with its traceback, unless it is the result that is wrong."""
    monkeypatch.setattr(trouble, "again", {})
    for answer, request, begins in MISTAKES:
        raised = "Error(" in begins
        if not raised:
            # All three in the same place of the code.
            trouble.again.clear()
        for again in (False, True):
            reply = replies.reply_to(answer, request).decode()
            assert reply.startswith(begins) and len(reply) < 1100
            said = printed.readouterr()
            assert ("Traceback" in said.err) == (raised and not again), begins
            if raised == again:
                assert said.out.startswith(f"trouble: {begins[7:]}"), begins
                assert said.out.count("\n") == 1
    assert replies.reply_to(lambda text: "x" * 65_536, b"") == b"x" * 65_536


IN_THE_MIDDLE = """
import os, signal, zmq
add = zmq.Context._add_socket
def interrupted(context, socket):
    os.kill(os.getpid(), signal.SIGINT)
    return add(context, socket)
zmq.Context._add_socket = interrupted
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no signal to one program alone")
@pytest.mark.parametrize(("program", "code", "end"), [("server.py", 0, ""), ("client.py", 1, "stopped")])
def test_ctrl_c_while_a_socket_is_made_ends_the_program(program, code, end, start, tmp_path):
    """Raised there, it would leave a socket that nobody closes, and the end of its context would wait for ever."""
    (tmp_path / "sitecustomize.py").write_text(IN_THE_MIDDLE, encoding="utf-8")
    words = ["--endpoint", steady_endpoint()]
    ended = start(PYTHON, SERVER.with_name(program), *words, PYTHONPATH=str(tmp_path))
    assert ended.wait() == code, ended.output
    assert ended.lines[-1:] in ([], [end]) or "listening" in ended.lines[-1]
    assert "Traceback" not in ended.output


@pytest.mark.skipif(sys.platform == "win32", reason="it is a shell's way to say it")
@pytest.mark.parametrize(("words", "code"), [("| head -1", 0), (">&-", 0), ("2>&1 >/dev/full | grep -c Traceback", 1)])
def test_output_that_nobody_takes_is_no_traceback(words, code, serve, tmp_path):
    """Nobody reads on, there is no output at all, or no room for it."""
    client = SERVER.with_name("client.py")
    command = shlex.join(map(str, [PYTHON, client, "--endpoint", serve(KEY)[1], "--count", 3000, "--timeout", 60]))
    done = finished(["bash", "-c", f"{command} {words}"])
    assert "Traceback" not in done.stderr and "No such file" not in done.stderr, done.stderr
    assert done.returncode == code, done.stdout + done.stderr
