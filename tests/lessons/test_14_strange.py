"""Lesson 14 among strangers: what a worker, a journal, a signal or a peer does that nobody expects."""

# ruff: noqa: F401, F811

from __future__ import annotations

import os
import re
import signal
import sqlite3
import sys
import threading
from contextlib import closing

import pytest
import zmq

from kitlib.docs import guide
from netmq_example.jobs.client import JobClient
from netmq_example.jobs.jobs import Jobs
from netmq_example.jobs.journal import Journal
from netmq_example.jobs.progress import Progress, share, words
from netmq_example.jobs.work import Kind, Step
from netmq_example.jobs.workers import Workers
from netmq_example.messages import Array
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.long_jobs.peers import KEY, Message, copied, jobs_server, peer, read, units
from tests.programs import LIMIT, ROOT, Mark, finds_processes

each_client = pytest.mark.parametrize("kind", CLIENTS)

# A server's workers


@pytest.mark.parametrize("key, work", [(KEY, "count"), ("21_talking_character", "talk")])
def test_workers_find_their_work_from_every_folder(key, work, start, peer, tmp_path):
    """A worker imports the program again, by the path by which it was started."""
    words = ["--endpoint", "tcp://127.0.0.1:*", "--journal", tmp_path / "journal.sqlite3"]
    server = start(PYTHON, f"../python/{key}/server.py", *words, folder=ROOT / "docs")
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    assert peer(endpoint).goal(work, 3).result("succeeded").values["done"] == 3


OWN = """
def own(total, finished, text):
    yield Step(1, total)
    wrong = {
        "long": lambda: Step(2, total, "x" * 70_000),
        "half": lambda: Step(2, total, "name \\udcff"),
        "part": lambda: Step(1.5, total),
        "huge": lambda: Step(2**53, total),
        "none": lambda: None,
    }
    yield wrong[text]()

KINDS["own"] = Kind(own, 10)
"""


@pytest.fixture
def own_server(start, tmp_path):
    """own_server(more): lesson 14's, at home, with so much more in its work.py."""

    def own_server(more):
        lesson = copied(tmp_path)
        with (lesson / "work.py").open("a", encoding="utf-8") as work:
            work.write(more)
        words = ["--endpoint", "tcp://127.0.0.1:*", "--workers", "1"]
        return start(PYTHON, lesson / "server.py", *words, folder=tmp_path)

    return own_server


@each_client
def test_every_client_has_a_kind_of_your_own_done_with_its_text(kind, own_server, start, client_command):
    """The one of the page, which it says to put at the end of work.py."""
    page = guide.blocks(ROOT / "docs" / "guide" / f"{KEY}.md")
    server = own_server("\n\n" + next(block.body for block in page if "has it done by every client" in block.source))
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    words = ("--count", "3", "--timeout", "20")
    client = start(*client_command(kind, KEY, endpoint, "--kind", "primes", "--text", "1000000", *words))
    wrong = start(*client_command(kind, KEY, endpoint, "--kind", "primes", "--text", "zwölf", *words))
    unknown = start(*client_command(kind, KEY, endpoint, "--kind", "proofs", *words))
    assert (client.wait(), wrong.wait(), unknown.wait()) == (0, 1, 1), client.output
    assert client.lines[-2].endswith("succeeded at 3 of 3, 1000037")
    assert wrong.lines[-2].endswith("the text says where to begin, such as 1000000, and not 'zwölf'")
    assert unknown.lines[-1].startswith("gave up: bad-goal: 'proofs' with count 3 is none of: count up to 10000")


def test_a_kind_that_no_process_can_be_handed_is_one_line_at_the_start(own_server):
    server = own_server('KINDS["small"] = Kind(lambda total, finished, text: iter([Step(1, 1)]), 10)\n')
    assert server.wait() == 1
    assert server.lines[-1] == (
        "kind 'small' cannot be handed to a worker: make it a function of a module, or functools.partial of one"
    )
    assert "Traceback" not in server.output


def test_a_step_that_cannot_be_told_aborts_its_job_and_no_other(own_server, peer):
    server = own_server(OWN)
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    said = {}
    for text in ("long", "half", "part", "huge", "none"):
        job = peer(endpoint)
        result = job.ask("goal", kind="own", count=3, text=text).result("aborted").values
        assert result["done"] == 1, "as far as could be told"
        said[text] = result["text"]
    assert "too-big" in said["long"]
    assert "bad-json" in said["half"]
    assert "done takes an int, not 1.5" in said["part"]
    assert "done takes a whole number from 0 to 9007199254740991" in said["huge"]
    assert units(peer(endpoint).goal(count=3).result("succeeded")) == 3, "the only worker works on"


@pytest.mark.skipif(sys.platform != "linux", reason="limits another process, as Linux does")
def test_a_worker_that_cannot_be_started_is_waited_for(serve, peer):
    import resource

    server, endpoint = serve(KEY)
    job = peer(endpoint).ask("status")
    job.hear("rejected")
    number, limits = server.process.pid, resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE)
    resource.prlimit(number, resource.RLIMIT_NOFILE, (len(os.listdir(f"/proc/{number}/fd")), limits[1]))
    job.goal(count=3)
    server.wait_for("^cannot start a worker: .*Too many open files; jobs wait until that is over$")
    assert job.ask("status").hear("accepted").values["position"] == 1, "it has not begun"
    resource.prlimit(number, resource.RLIMIT_NOFILE, limits)
    assert units(job.result("succeeded")) == 3
    assert len([line for line in server.lines if line.startswith("cannot start")]) == 1


@finds_processes
def test_a_worker_that_was_stopped_does_not_hold_the_server(serve, peer):
    mark = Mark()
    server, endpoint = serve(KEY, **mark.environment)
    job = peer(endpoint).goal("deaf", 10_000)
    job.hear("feedback")
    worker = int(server.wait_for(r"in process (\d+)")[1])
    os.kill(worker, signal.SIGSTOP)
    try:
        assert server.stop(limit=LIMIT / 2) == 0
    finally:
        for left in mark.processes():
            os.kill(left, signal.SIGKILL)


@pytest.mark.skipif(sys.platform == "win32", reason="sends Ctrl-C to one process")
def test_ctrl_c_in_the_moment_in_which_a_worker_begins(serve, peer):
    """A terminal sends it to all processes; a worker is there for the server to end."""
    server, endpoint = serve(KEY)
    job = peer(endpoint).goal(count=3)
    os.kill(int(server.wait_for(r"in process (\d+)")[1]), signal.SIGINT)
    assert units(job.result("succeeded")) == 3
    assert server.stop(signal.SIGINT) == 0
    assert "Traceback" not in server.output
    assert server.output.count("in process") == 1, "it took no notice"


@finds_processes
def test_a_restart_is_no_death_of_a_worker(jobs_server, peer):
    server, endpoint = jobs_server("--workers", "1")
    job = peer(endpoint).goal(count=300)
    job.at(1)
    server.kill()
    server, _ = jobs_server("--workers", "1")
    seen = 0
    for _ in range(2):
        worker = server.wait_for(r"in process (\d+)", start=seen)[1]
        seen = len(server.lines)
        os.kill(int(worker), signal.SIGKILL)
    assert units(job.result("succeeded")) == 300


def test_a_server_that_was_crashed_on_purpose_goes_on_when_started_in_the_same_way(jobs_server, peer):
    # It takes eight seconds to get there, and nobody asks meanwhile, so that after five nobody is told any more.
    server, endpoint = jobs_server("--crash-on", "400")
    job = peer(endpoint).goal(count=1000)
    assert server.wait() == 1
    jobs_server("--crash-on", "400")
    assert units(job.result("succeeded")) == 1000


@pytest.mark.parametrize(
    "words",
    [
        ("--grace", "nan"),
        ("--grace", "inf"),
        ("--grace", "-1"),
        ("--crash-on", "-3"),
        ("--workers", "1000000000"),
        ("--queue", "0.5"),
    ],
    ids=" ".join,
)
def test_numbers_have_limits(words, start, tmp_path):
    command = [PYTHON, ROOT / "python" / KEY / "server.py", "--endpoint", "tcp://127.0.0.1:0", *words]
    server = start(*command, folder=tmp_path)
    assert server.wait() == 2
    name = words[0].removeprefix("--")
    assert re.search(rf"error: (argument --{name}: it|{name}) takes .*, not '?{words[1]}", server.lines[-1]), (
        server.output
    )


# Journals


def test_another_programs_file_is_refused_and_left_as_it_is(start, tmp_path):
    for name, table in (("other", "notes (text)"), ("same_name", "jobs (id, salary)")):
        path = tmp_path / name
        with closing(sqlite3.connect(path)) as other, other:
            other.execute(f"CREATE TABLE {table}")
        before = path.read_bytes()
        server = start(
            PYTHON, ROOT / "python" / KEY / "server.py", "--journal", path, "--endpoint", "tcp://127.0.0.1:0"
        )
        assert server.wait() == 2
        assert server.lines[-1].endswith(
            f"cannot use the journal {path}: it is another program's; try --journal another.sqlite3"
        )
        assert path.read_bytes() == before


def test_a_job_that_cannot_be_read_or_done_any_more_is_not_the_others_business(jobs_server, peer, tmp_path):
    server, endpoint = jobs_server("--workers", "1")
    blocker, newer, cut, odd, good = (peer(endpoint) for _ in range(5))
    blocker.goal("deaf", 10_000).hear("feedback")
    for job in (newer, cut, odd, good):
        job.goal(count=3).hear("accepted")
    server.kill()
    with closing(sqlite3.connect(tmp_path / "journal.sqlite3")) as journal, journal:
        for job, change in (
            (newer, "goal = CAST(replace(CAST(goal AS TEXT), '\"version\":1', '\"version\":2') AS BLOB)"),
            (cut, "news = substr(news, 1, 20)"),
            (odd, "goal = CAST(replace(CAST(goal AS TEXT), '\"count\",', '\"paint\",') AS BLOB)"),
        ):
            done = journal.execute(f"UPDATE jobs SET {change} WHERE id = ?", (job.job,))
            assert done.rowcount == 1
    server, _ = jobs_server("--workers", "1")
    assert units(good.result("succeeded")) == 3
    assert odd.result("aborted").values["text"] == "the server does not know this kind of work any more"
    assert newer.ask("status").hear("rejected").values["code"] == "bad-version"
    assert cut.goal(count=3).hear("rejected").values["code"] == "bad-json"
    assert len([line for line in server.lines if line.startswith("cannot read job '")]) == 2
    assert "Traceback" not in server.output


RACE = f"""
import sys
import threading
sys.path.insert(0, {str(ROOT / "python")!r})
from netmq_example.jobs.journal import Journal
journal = Journal(sys.argv[1])
threading.Event().wait(600)
"""


def test_of_servers_that_begin_together_one_gets_the_journal(start, tmp_path):
    race = tmp_path / "race.py"
    race.write_text(RACE, encoding="utf-8")
    # Half of them race for a journal that a killed one has left.
    for number in range(6):
        path = str(tmp_path / f"{number // 2}.sqlite3")
        programs = [start(PYTHON, race, path) for _ in range(3)]
        said = []
        for program in programs:
            program.wait_for("^journal|ValueError: cannot use the journal")
            said.append(program.lines[0].startswith("journal"))
        assert sorted(said) == [False, False, True]
        for program in programs:
            program.kill()


# Clients, by a server that is not the kit's


class Wrong:
    """Answers each message about a job with what `replies` makes of the job's id; a context manager."""

    def __init__(self, context, replies):
        self.replies, self.ended = replies, threading.Event()
        self.socket = context.socket(zmq.ROUTER)
        self.socket.linger = 0
        self.endpoint = f"tcp://127.0.0.1:{self.socket.bind_to_random_port('tcp://127.0.0.1')}"
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        while not self.ended.is_set():
            if self.socket.poll(50):
                client, *frames = self.socket.recv_multipart()
                for reply in self.replies(read(frames).values["job"]):
                    self.socket.send_multipart([client, *reply])
        self.socket.close()


def said(kind, *arrays, **values):
    return lambda job: [Message(kind, values={"job": job, **values}, arrays=list(arrays)).frames()]


def both(*parts):
    return lambda job: [message for part in parts for message in part(job)]


STATE = {"done": 1, "total": 2, "text": ""}
END = said("result", seq=3, status="succeeded", **STATE)
STRANGE = [
    (said("result", seq=1, **STATE), "gave up: missing-field: there is no 'status'"),
    (said("result", seq=1, status=5, **STATE), "gave up: wrong-type: 'status' must be str"),
    (
        said("result", seq=1, status="exploded", **STATE),
        "gave up: bad-status: status 'exploded' is none of succeeded, canceled, aborted",
    ),
    (
        said("hurray", seq=1),
        "gave up: unknown-kind: kind 'hurray' is none of accepted, feedback, canceling, result, forgotten",
    ),
    (said("feedback", **STATE), "gave up: missing-field: there is no 'seq'"),
    (said("rejected", code=5, text=True), "gave up: wrong-type: 'code' must be str"),
    (said("forgotten"), "gave up: forgotten: its result was deleted; begin a job with a new id"),
    # The server has another journal, and has begun anew.
    (both(said("feedback", seq=9, **STATE), END), "done: succeeded, 0 bytes, sum 0"),
    *[
        (both(said("feedback", array, seq=1, **STATE), END), "done: succeeded, 0 bytes, sum 0")
        for array in (
            Array("uint8", (1, 50_000, 3), bytes(150_000)),
            Array("uint8", (0, 30_000, 3), b""),
            Array("uint8", (3, 1, 3), bytes(9)),
            Array("float64", (1, 1, 3), bytes(24)),
        )
    ],
]


@each_client
def test_what_a_strange_server_says_of_a_job_is_one_line(kind, context, start, client_command):
    servers = [Wrong(context, replies) for replies, _ in STRANGE]
    try:
        clients = [start(*client_command(kind, KEY, server.endpoint, "--timeout", "20")) for server in servers]
        for client, (_, last) in zip(clients, STRANGE, strict=True):
            assert client.wait() == (1 if last.startswith("gave up") else 0), client.output
            assert client.lines[-1] == last
            assert len(client.lines) < 6
    finally:
        for server in servers:
            server.ended.set()
            server.thread.join()


@each_client
def test_a_flood_of_what_is_no_message_is_no_flood_of_lines(kind, context, start, client_command):
    server = Wrong(context, lambda job: [[b"rubbish"]] * 900)
    try:
        client = start(*client_command(kind, KEY, server.endpoint, "--timeout", "2", "--tries", "2"))
        assert client.wait() == 1
    finally:
        server.ended.set()
        server.thread.join()
    assert 0 < len([line for line in client.lines if line.startswith("dropped: ")]) <= 20, client.output


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_numbers_have_the_same_limits_in_every_client(kind, start, client_command):
    words = [("--count", "0"), ("--count", "99999999999"), ("--cancel-at", "99999999999")]
    clients = [start(*client_command(kind, KEY, "tcp://127.0.0.1:1", *pair)) for pair in words]
    assert [client.wait() for client in clients] == [2, 2, 2], [client.output for client in clients]


# What a method cannot use


def nothing(total, finished, text):
    yield from ()


@pytest.fixture
def made(context, tmp_path):
    """One of each, by its name."""
    journal = Journal(tmp_path / "journal.sqlite3")
    kinds = {"nothing": Kind(nothing, most=1)}
    with closing(Jobs(journal, kinds).workers), JobClient(context, "tcp://127.0.0.1:1") as client:
        yield {"context": context, "journal": journal, "kinds": kinds, "client": client}


NAN = float("nan")
WRONG = {
    "work": [lambda value, made: Kind(value, 1), None, 0, "count"],
    "most": [lambda value, made: Kind(nothing, value), None, 0, -1, NAN, "", 0.5],
    "has_checkpoint": [lambda value, made: Kind(nothing, 1, value), None, 0, ""],
    "done": [lambda value, made: Step(value, 1), None, -1, NAN, "", 0.5, 2**53],
    "total": [lambda value, made: Step(1, value), None, -1, NAN, "", 0.5],
    "text ": [lambda value, made: Step(1, 1, value), None, 0],
    "checkpoint": [lambda value, made: Step(1, 1, "", value), 0, b"1"],
    "context": [lambda value, made: JobClient(value, "tcp://127.0.0.1:1"), None, 0, ""],
    "endpoint": [lambda value, made: JobClient(made["context"], value), None, 0, "", "tcp://127.0.0.1:99999"],
    "job": [lambda value, made: JobClient(made["context"], "tcp://x:1", value), 0, -1, NAN, "", "../x", "x" * 65],
    "timeout": [lambda value, made: JobClient(made["context"], "tcp://x:1", None, value), None, 0, -1, NAN, ""],
    "tries": [lambda value, made: JobClient(made["context"], "tcp://x:1", None, 1, value), None, 0, -1, NAN, ""],
    "report": [lambda value, made: JobClient(made["context"], "tcp://x:1", None, 1, 1, value), None, 0, ""],
    "kind": [lambda value, made: made["client"].goal(value, 1), None, 0, NAN],
    "count": [lambda value, made: made["client"].goal("count", value), None, 0, -1, NAN, "", 0.5],
    "text": [lambda value, made: made["client"].goal("count", 1, value), None, 0, NAN],
    "verb": [lambda value, made: made["client"].ask(value), None, 0, NAN, ""],
    "request": [lambda value, made: next(made["client"].watch(value)), None, 0, "", "goal"],
    "path": [lambda value, made: Journal(value), None, 0, -1, NAN],
    "journal": [lambda value, made: Journal(value), "", ":memory:", "no/such/folder", "a\0b"],
    "journal ": [lambda value, made: Jobs(value, made["kinds"]), None, 0, "journal.sqlite3"],
    "kinds": [lambda value, made: Jobs(made["journal"], value), None, 0, "", {"count": nothing}],
    "workers": [lambda value, made: Jobs(made["journal"], made["kinds"], value), None, 0, -1, NAN, "", 101],
    "workers ": [lambda value, made: Workers(value, made["kinds"]), None, 0, -1, NAN, "", 101],
    "queue": [lambda value, made: Jobs(made["journal"], made["kinds"], 1, value), None, 0, -1, NAN, ""],
    "grace": [lambda value, made: Jobs(made["journal"], made["kinds"], 1, 1, value), None, -1, NAN, ""],
    "line": [lambda value, made: Progress().show(value), None, 0, NAN],
    "share": [lambda value, made: Progress().show("line", value), -1, NAN, "", 2],
    "news": [lambda value, made: words(value), None, 0, ""],
    "news ": [lambda value, made: share(value), None, 0, ""],
}


@pytest.mark.parametrize(
    ("name", "call", "value"),
    [(name, call, value) for name, (call, *values) in WRONG.items() for value in values],
    ids=lambda value: None if callable(value) else f"{value!r:.20}",
)
def test_what_a_method_cannot_use_is_named(name, call, value, made):
    with pytest.raises((ValueError, TypeError), match=rf"\b{name.strip()}\b") as caught:
        call(value, made)
    assert "\n" not in str(caught.value)
