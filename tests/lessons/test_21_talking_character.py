"""Application 21: words while they are made, walking away, a server that is started again, and Ollama's side of it.

What lesson 14's tests say of jobs is not said again.
"""

import json
import re
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from http.server import BaseHTTPRequestHandler
from typing import Any, ClassVar

import pytest
import zmq

from netmq_example.talk.ollama import ollama_talk
from netmq_example.work import WorkError
from tests.bad_peers import web_server
from tests.conftest import CLIENTS
from tests.lessons.conftest import bind
from tests.lessons.long_jobs.peers import Message, Peer, read
from tests.programs import LIMIT, ROOT, free_port, steady_endpoint

KEY = "21_talking_character"
sys.path.append(str(ROOT / "python" / KEY))
import small_talk  # noqa: E402

each_client = pytest.mark.parametrize("kind", CLIENTS)
PROMPT = "Who built this bridge?"


def sentences(text):
    return [f"she: {one}" for one in re.sub(r"(?<=[.!?]) ", "\n", text).splitlines()]


@each_client
def test_what_is_said_is_heard_whole(kind, serve, runs):
    """Each sentence is a line, whatever pieces it came in; the same for every client."""
    server, endpoint = serve(KEY, "--delay", "0.01", "--seed", "7")
    strange = "Größe? \U0001f600 And: why. Now!"
    wrong = [["--prompt="], ["--prompt=" + "x" * 1001]]
    table = [[], ["--prompt", strange], ["--count", "6"], *wrong]
    *found, empty, long = runs(kind, KEY, [["--endpoint", endpoint, "--timeout", "60", *words] for words in table])
    whole, other = small_talk.reply(PROMPT, 7), small_talk.reply(strange, 7)
    six = " ".join(whole.split()[:6])
    for prompt, said, run in zip((PROMPT, strange, PROMPT), (whole, other, six), found, strict=True):
        assert run == (0, [f"asking {endpoint}: {prompt}", *sentences(said), f"done: {len(said.split())} words"])
    for run in empty, long:
        assert run.code == (1 if kind == "unity" else 2)
        assert re.search("prompt.* 1 to 1000 characters", "\n".join(run.lines))
    for words in whole, other, six:
        server.wait_for(rf"succeeded at {len(words.split())} of {len(words.split())}$")


def test_who_walks_away_ends_it(serve, start_client):
    # On a busy machine it takes seconds until the server hears of it, and then there must be words left.
    server, endpoint = serve(KEY, "--delay", "0.5", "--workers", "3")
    clients = [start_client(kind, KEY, endpoint, "--leave-after", "5", "--timeout", "60") for kind in CLIENTS]
    whole = small_talk.reply(PROMPT, 0).split()
    for client in clients:
        assert client.wait() == 0, client.output
        heard = int(re.fullmatch(r"done: (\d+) words, and you walked away", client.lines[-1])[1])
        assert 5 <= heard < len(whole)
        assert client.lines[1:-1] == sentences(" ".join(whole[:heard]))
    begin = 0
    for _ in clients:
        made = int(server.wait_for(rf"canceled at (\d+) of {len(whole)}$", start=begin)[1])
        assert 5 <= made < len(whole), "the work ended too"
        begin = next(i for i, line in enumerate(server.lines) if i >= begin and "canceled at" in line) + 1


def test_a_server_that_is_started_again_has_no_half_answer(serve, start_client):
    """It could not go on in the middle, and says so: what was said stays, and the rest is not waited for."""
    endpoint = steady_endpoint()
    server, _ = serve(KEY, "--delay", "0.3", "--workers", "3", endpoint=endpoint)
    clients = [start_client(kind, KEY, endpoint, "--timeout", "25") for kind in CLIENTS]
    for client in clients:
        client.wait_for("^she: Mind the third plank!$")
    server.kill()
    serve(KEY, endpoint=endpoint)
    why = "the answer broke off: the server was restarted; ask again"
    for client in clients:
        assert client.wait() == 1, client.output
        assert any(line.endswith(f"gave up: {why}") for line in client.lines), client.output


# A server that the test decides for

SPOKEN = [
    ("feedback", "A dog"),
    # All that was between them is lost.
    ("feedback", "A dog \x1b[2Jbarks.\n\nAt the \u202emoon? Yes,"),
    ("feedback", "A dog \x1b[2Jbarks.\n\nAt the \u202emoon? Yes, \U0001f600 e.g. this one."),
]


@pytest.fixture
def stage(context):
    """stage(*news): answers the next goal with these messages, and returns the goal."""
    with context.socket(zmq.ROUTER) as router:
        played = set()

        def play(*news):
            goal = None
            while not goal or goal.kind != "goal" or goal.values["job"] in played:
                way, *frames = router.recv_multipart()
                goal = read(frames)
            played.add(goal.values["job"])
            for seq, (kind, text) in enumerate(news):
                facts = {"job": goal.values["job"], "seq": seq, "done": 1, "total": 9, "text": text}
                status = {} if kind == "feedback" else {"status": kind}
                message = Message("result" if status else kind, values=facts | status)
                router.send_multipart([way, *message.frames()])
            return goal

        yield play, bind(router)


@each_client
def test_what_was_lost_is_in_the_next_one(kind, stage, runs):
    play, endpoint = stage
    ends = {
        ("succeeded", SPOKEN[-1][1]): "done: 11 words",
        ("canceled", "it did not listen, and was killed"): "done: 11 words, and you walked away",
        ("aborted", "no \x1b[2Jwords"): "gave up: the answer broke off: no ?[2Jwords; ask again",
    }
    with ThreadPoolExecutor() as pool:
        talks = pool.submit(runs, kind, KEY, [["--endpoint", endpoint, "--timeout", "60"]] * len(ends))
        for end in ends:
            goal = play(*SPOKEN, end)
            assert goal.values == {"job": goal.values["job"], "kind": "talk", "count": 200, "text": PROMPT}
    for run, (end, last) in zip(talks.result(), ends.items(), strict=True):
        assert run.code == (end[0] == "aborted"), run
        assert run.lines[1:4] == ["she: A dog ?[2Jbarks.", "she: At the ?moon?", "she: Yes, \U0001f600 e.g."]
        assert run.lines[4] == "she: this one."
        assert [line.removeprefix("error: ") for line in run.lines[5:] if line and not line.startswith("   ")] == [last]


# Ollama, by a small server that speaks as its documentation says


# Models that do not speak do this, as ollama/ollama#14793 shows it.
SILENT: dict[str, list[dict[str, Any]]] = {
    "thinking": [{"thinking": "hmm "}] * 50,
    "tool_calls": [{"content": None, "tool_calls": [{"function": {"name": "look", "arguments": {}}}]}],
    "thinking aloud": [{"content": "<think> hmm"}],
    "nothing": [],
    "blanks": [{"content": " \n"}],
}


NOT_FOUND = {"missing": b'{"error":"model \'tiny\' not found"}', "page": b"<html>not found</html>"}


class Ollama(BaseHTTPRequestHandler):
    """The prompt says what it does."""

    asked: ClassVar[list] = []
    gone = threading.Event()

    def do_POST(self):
        request = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.asked.append((self.path, request))
        what = request["messages"][-1]["content"]
        if what in NOT_FOUND:
            self.send_response(404)
            self.end_headers()
            self.wfile.write(NOT_FOUND[what])
            self.close_connection = True
            return
        self.send_response(200)
        self.send_header("Transfer-Encoding", "chunked")
        self.end_headers()
        try:
            self.speak(what)
        except OSError:
            self.gone.set()
        self.close_connection = True

    def speak(self, what):
        tagged = ["\n<thi", "nk> Who", " is it?\n</th", "ink>\n\n"] if what == "tagged" else []
        aloud = [{"content": piece} for piece in (*tagged, "Once", " there", " was a river.")]
        for message in SILENT.get(what, aloud):
            self.message(**message)
        if what == "error":
            self.line({"error": "an error was encountered while running the model"})
        if what == "list":
            self.line([1])
        if what == "long":
            for _ in range(60):
                self.message("\U0001f600" * 100)
        while what == "endless":
            self.message(" and")
            self.gone.wait(0.01)
        if what == "silent":
            # Until the other side closes.
            self.connection.recv(1)
            self.gone.set()
        if what in ("whole", "tagged", *SILENT):
            self.message(done=True)
            self.wfile.write(b"0\r\n\r\n")

    def message(self, content="", done=False, **more):
        self.line({"message": {"role": "assistant", "content": content, **more}, "done": done})

    def line(self, news):
        text = json.dumps(news).encode() + b"\n"
        self.wfile.write(b"%x\r\n%s\r\n" % (len(text), text))

    def log_message(self, *words):
        pass


@pytest.fixture
def ollama(serve, context):
    """The address of an Ollama, and a function that asks our server something, which asks it."""
    Ollama.asked, Ollama.gone = [], threading.Event()
    with web_server(Ollama) as port:
        url = f"http://127.0.0.1:{port}"
        server, endpoint = serve(KEY, "--ollama", url, "--model", "tiny")
        peers = []

        def ask(what):
            peers.append(Peer(context, endpoint))
            return peers[-1].ask("goal", kind="talk", count=50, text=what)

        yield server, url, ask
        for peer in peers:
            peer.socket.close()


def test_a_model_talks_and_all_that_can_go_wrong_with_it_is_a_line(ollama):
    server, url, ask = ollama
    assert ask("whole").result("succeeded").values["text"] == "Once there was a river."
    path, request = Ollama.asked[0]
    assert (path, request["model"], request["stream"], request["think"]) == ("/api/chat", "tiny", True, False)
    assert request["options"] == {"num_predict": 50}
    assert [message["role"] for message in request["messages"]] == ["system", "user"]
    long = ask("long").result("succeeded").values["text"]
    assert (len(long), long[-2:]) == (5001, "\U0001f600…"), "and its header is not too large"
    for what, why in {
        "missing": "Ollama says: model 'tiny' not found; try: ollama pull tiny",
        "error": "Ollama says: an error was encountered while running the model",
        "page": f"what answers at {url} is not Ollama: check --ollama",
        "list": f"what answers at {url} is not Ollama: check --ollama",
        "cut": f"{url} ended in the middle: did Ollama crash?",
    }.items():
        assert ask(what).result("aborted").values["text"] == why
    assert ask("whole").result("succeeded"), "it serves on"
    assert "Traceback" not in server.output


def test_a_model_that_says_nothing_has_not_answered_and_what_it_thinks_is_not_spoken(ollama):
    server, url, ask = ollama
    for what in SILENT:
        after = "" if what in ("nothing", "blanks") else f", after {what.partition(' ')[0]}"
        why = f"tiny ended without a word{after}: take another model, one that does not think"
        assert ask(what).result("aborted").values["text"] == why
    thoughts = [step.text for step in ollama_talk(50, b"", "tagged", url=url, model="tiny")]
    assert thoughts[-1] == "Once there was a river." and all(thoughts[-1].startswith(text) for text in thoughts)
    assert "Traceback" not in server.output


@pytest.mark.parametrize("what", ["endless", "silent"])
def test_walking_away_stops_the_model(what, ollama):
    """Its connection is closed, also while it says nothing."""
    server, _, ask = ollama
    talk = ask(what)
    talk.hear("feedback")
    assert not Ollama.gone.is_set()
    talk.ask("cancel").result("canceled")
    assert Ollama.gone.wait(LIMIT)
    assert "Traceback" not in server.output


def test_an_ollama_that_is_not_there_is_named(runs):
    url = f"http://127.0.0.1:{free_port()}"
    with pytest.raises(WorkError) as error:
        next(ollama_talk(1, b"", "?", url=url, model="x"))
    assert str(error.value) == f"no connection with {url} (Connection refused): start Ollama: ollama serve"
    urls = ["127.0.0.1:11434", "ftp://x", "http://", "http://x:99999"]
    for url, run in zip(urls, runs("server", KEY, [["--ollama", url] for url in urls]), strict=True):
        assert run.code == 2
        assert run.lines[-1].endswith(f"bad address '{url}': write it like http://127.0.0.1:11434")
