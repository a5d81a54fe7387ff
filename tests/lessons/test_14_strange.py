"""Lesson 14 among strangers: what a worker, a journal or a peer does that nobody expects."""

# ruff: noqa: F401, F811

import json
import os
import re
import shutil
import sqlite3
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest
import zmq

from kitlib.docs import guide
from netmq_example.errors import Error
from netmq_example.jobs import client as client_module
from netmq_example.jobs import journal, workers
from netmq_example.jobs.client import JobClient
from netmq_example.jobs.jobs import Jobs
from netmq_example.jobs.journal import Journal
from netmq_example.jobs.workers import Workers
from netmq_example.messages import Array, Message
from netmq_example.work import Kind, Step
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import bind
from tests.lessons.long_jobs.peers import KEY, Message, jobs_server, peer, read, units
from tests.programs import LIMIT, ROOT

sys.path.append(str(ROOT / "python" / KEY))
import progress

PAGE = [*guide.blocks(ROOT / "docs" / "guide" / f"{KEY}.md")]
each_side = pytest.mark.parametrize("side", ["python", "csharp"])

# Work of one's own


OWN = """
def own(total, finished, text):
    if text == "nothing":
        return
    yield Step(1, total)
    wrong = {
        "long": lambda: Step(2, total, "x" * 70_000),
        "half": lambda: Step(2, total, "name \\udcff"),
        "none": lambda: None,
        "boom": lambda: mistake("my own\\nmistake"),
    }
    yield wrong[text]()

def mistake(text):
    raise ValueError(text)

KINDS["own"] = Kind(own, 10)
"""


def test_the_client_on_the_page_watches_its_job(jobs_server, start):
    (program,) = [block.body for block in PAGE if "watches_its_job" in block.source]
    program = program.replace("tcp://127.0.0.1:5564", jobs_server()[1])
    client = start(PYTHON, "-c", program, PYTHONPATH=str(ROOT / "python"))
    assert client.wait() == 0, client.output
    assert client.lines[0].startswith("accepted {"), client.lines
    assert client.lines[-1].startswith("result {") and "'done': 100, 'total': 100" in client.lines[-1], client.lines


@pytest.mark.parametrize("kind", CLIENTS)
def test_every_client_has_a_kind_of_your_own_done_with_its_text(kind, serve_own, runs):
    """The one of the page, which it says to put at the end of work.py."""
    own = next(block.body for block in PAGE if "has it done by every client" in block.source)
    always = ("--endpoint", serve_own(KEY, own, file="work.py")[1], "--count", "3", "--timeout", "20", "--kind")
    texts = (["primes", "--text", "1000000"], ["primes", "--text", "zwölf"], ["proofs"])
    good, wrong, unknown = runs(kind, KEY, [[*always, *each] for each in texts])
    assert (good.code, wrong.code, unknown.code) == (0, 1, 1), (good, wrong, unknown)
    assert good.lines[-2].endswith("succeeded at 3 of 3, 1000037")
    assert wrong.lines[-2].endswith("the text says where to begin, such as 1000000, and not 'zwölf'")
    assert wrong.lines[-1] == "gave up: the job was aborted; see above"
    assert unknown.lines[-1].startswith("gave up: bad-goal: 'proofs' with count 3 is none of: count up to 10000")


def test_a_kind_that_no_process_can_be_handed_is_one_line_at_the_start(start, tmp_path):
    code = "import server, work; work.KINDS['small'] = work.Kind(lambda *_: iter([]), 10); server.run(server.main)"
    server = start(PYTHON, "-c", code, folder=tmp_path, PYTHONPATH=str(ROOT / "python" / KEY))
    assert server.wait() == 1
    assert server.lines[1:] == [
        "kind 'small' cannot be handed to a worker: make it a function of a module, or functools.partial of one"
    ]


def test_a_step_that_cannot_be_told_aborts_its_job_and_no_other(serve_own, peer):
    server, endpoint = serve_own(KEY, OWN, "--workers", "1", file="work.py")
    said = {}
    for text in ("long", "half", "none", "boom"):
        job = peer(endpoint)
        result = job.ask("goal", kind="own", count=3, text=text).result("aborted").values
        assert result["done"] == 1, "as far as could be told"
        said[text] = result["text"]
    result = peer(endpoint).ask("goal", kind="own", count=3, text="nothing").result("aborted").values
    assert (result["done"], result["text"]) == (0, "the work ended without a step: nothing was done")
    assert "too-big" in said["long"]
    assert "bad-json" in said["half"]
    # A mistake is shown where it is written.
    assert said["boom"] == r"ValueError('my own\nmistake')"
    server.wait_for(r'work\.py", line \d+, in mistake')
    assert units(peer(endpoint).goal(count=3).result("succeeded")) == 3, "the only worker works on"


@pytest.mark.skipif(sys.platform != "linux", reason="limits another process, as Linux does")
def test_a_caller_that_takes_its_time_is_no_silence_of_the_servers(jobs_server, context, monkeypatch):
    later = [0.0]
    clocks = SimpleNamespace(monotonic=lambda: time.monotonic() + later[0])
    monkeypatch.setattr(client_module, "time", clocks)
    _, endpoint = jobs_server()
    with JobClient(endpoint, timeout=LIMIT, tries=1, context=context) as client:
        seen = []
        for news in client.watch(client.goal("count", 20)):
            seen.append(news)
            # The caller was busy so long.
            later[0] += 2 * LIMIT
    assert seen[-1].values["status"] == "succeeded"


def test_an_id_that_grows_when_it_is_written_anew_is_refused(jobs_server, peer):
    """Sent back, each of its letters becomes six bytes."""
    _, endpoint = jobs_server()
    header = {"kind": "status", "version": 1, "id": 0, "values": {"job": "é" * 20_000}, "arrays": []}
    stranger = peer(endpoint)
    stranger.socket.send(json.dumps(header, ensure_ascii=False).encode())
    assert stranger.hear("rejected").values["code"] == "bad-job"


def test_a_worker_whose_server_is_gone_ends_without_a_word(monkeypatch, capsys):
    ours, its = workers.SPAWN.Pipe()
    ours.close()
    monkeypatch.setattr(os, "_exit", sys.exit)
    goal = Message("goal", values={"job": "a", "done": 0, "count": 1, "text": ""})
    with pytest.raises(SystemExit):
        workers.perform(its, goal, Kind(lambda *_: [Step(1, 1)], 1), threading.Event())
    assert capsys.readouterr() == ("", "")


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


# Options, and journals


def test_a_clock_that_is_set_forgets_no_job_and_a_day_that_passes_does(tmp_path, monkeypatch):
    """As a board without a battery sets it, when it has found the network."""
    now = {"time": 1e6, "monotonic": 5.0}
    clocks = SimpleNamespace(time=lambda: now["time"], monotonic=lambda: now["monotonic"])
    monkeypatch.setattr(journal, "time", clocks)
    book = Journal(tmp_path / "jobs.sqlite3")

    def end(job):
        goal = Message("goal", values={"job": job, "kind": "count", "count": 1, "text": ""})
        state = {"job": job, "seq": 1, "done": 1, "total": 1, "text": ""}
        assert book.add(goal, Message("accepted", values={"job": job, "seq": 0, "position": 0}))
        assert book.save([Message("result", values={**state, "status": "succeeded"})])

    end("early")
    now["time"] += 1e9
    end("late")
    assert book.find("early") and book.find("late")
    for clock in now:
        now[clock] += 90_000
    end("next")
    assert not book.find("early") and not book.find("late") and book.find("next")


def test_a_server_says_in_one_line_what_it_cannot_use(runs, tmp_path):
    mine = str(tmp_path / "mine.sqlite3")
    others = {"notes (text)": tmp_path / "other", "jobs (id, salary)": tmp_path / "same_name"}
    for table, path in others.items():
        with closing(sqlite3.connect(path)) as other, other:
            other.execute(f"CREATE TABLE {table}")
    before = [path.read_bytes() for path in others.values()]
    # A second server of the same journal would do each job once more.
    with closing(Journal(mine).db):
        always = ("--endpoint", "tcp://127.0.0.1:0", "--journal")
        journals = [(*always, str(path)) for path in (*others.values(), mine)]
        found = runs("server", KEY, journals)
    assert {run.code for run in found} == {2}
    causes = ["it is another program's"] * 2 + ["database is locked"]
    for path, cause, run in zip([*others.values(), mine], causes, found, strict=True):
        assert run.lines[-1].endswith(f"cannot use the journal {path}: {cause}; try another file")
    assert before == [path.read_bytes() for path in others.values()]


COLUMNS = "goal", "news"


def test_a_job_that_cannot_be_read_or_done_any_more_is_not_the_others_business(jobs_server, peer, tmp_path):
    server, endpoint = jobs_server("--workers", "1")
    damaged = (newer, cut, bare, number, text, other, far, past, sign) = [peer(endpoint) for _ in range(9)]
    blocker, odd, good = (peer(endpoint) for _ in range(3))
    blocker.goal("deaf", 10_000).hear("feedback")
    for job in (*damaged, odd, good):
        job.goal(count=3).hear("accepted")
    server.kill()
    escaped = r"{column} = CAST(replace(CAST({column} AS TEXT), '{job}', '\u001b') AS BLOB)"
    with closing(sqlite3.connect(tmp_path / "journal.sqlite3")) as journal, journal:
        for job, change in (
            (newer, "goal = CAST(replace(CAST(goal AS TEXT), '\"version\":1', '\"version\":2') AS BLOB)"),
            (cut, "news = substr(news, 1, 20)"),
            (bare, "news = CAST(replace(CAST(news AS TEXT), '\"position\"', '\"place\"') AS BLOB)"),
            (number, "goal = 5"),
            (text, "news = CAST(x'ff' AS TEXT)"),
            (other, f"goal = CAST(replace(CAST(goal AS TEXT), '{other.job}', 'another') AS BLOB)"),
            (far, f"news = CAST(replace(CAST(news AS TEXT), '\"seq\":0', '\"seq\":{2**53 - 1}') AS BLOB)"),
            (past, "news = CAST(replace(CAST(news AS TEXT), 'accepted', 'forgotten') AS BLOB)"),
            (sign, f"id = char(27), {', '.join(escaped.format(column=one, job=sign.job) for one in COLUMNS)}"),
            (odd, "goal = CAST(replace(CAST(goal AS TEXT), '\"count\",', '\"paint\",') AS BLOB)"),
        ):
            done = journal.execute(f"UPDATE jobs SET {change} WHERE id = ?", (job.job,))
            assert done.rowcount == 1
    server, _ = jobs_server("--workers", "1")
    assert units(good.result("succeeded")) == 3
    assert odd.result("aborted").values["text"] == "the server does not know this kind of work any more"
    assert newer.ask("status").hear("rejected").values["code"] == "bad-version"
    assert cut.goal(count=3).hear("rejected").values["code"] == "bad-json"
    assert len([line for line in server.lines if re.match(r"cannot read row \d+ of the journal, ", line)]) == len(
        damaged
    )
    assert "Traceback" not in server.output


# Clients, by a server that is not the kit's


@contextmanager
def wrong_server(context, replies):
    """Answers each message about a job with what `replies` makes of the job's id: where it is."""

    def run():
        while not ended.is_set():
            if socket.poll(50):
                client, *frames = socket.recv_multipart()
                for reply in replies(read(frames).values["job"]):
                    socket.send_multipart([client, *reply])

    ended, thread = threading.Event(), threading.Thread(target=run)
    with context.socket(zmq.ROUTER) as socket:
        endpoint = bind(socket)
        thread.start()
        yield endpoint
        ended.set()
        thread.join()


def said(kind, *arrays, **values):
    return lambda job: [Message(kind, values={"job": job, **values}, arrays=list(arrays)).frames()]


def both(*parts):
    return lambda job: [message for part in parts for message in part(job)]


STATE = {"done": 1, "total": 2, "text": ""}
END = said("result", seq=3, status="succeeded", **STATE)
STRANGE = [
    (said("result", seq=1, **STATE), "gave up: missing-field: there is no 'status'"),
    (
        said("result", seq=1, status="exploded", **STATE),
        "gave up: bad-status: status 'exploded' is none of succeeded, canceled, aborted",
    ),
    (
        said("hurray", seq=1),
        "gave up: unknown-kind: kind 'hurray' is none of accepted, feedback, canceling, result, forgotten",
    ),
    (said("feedback", **STATE), "gave up: missing-field: there is no 'seq'"),
    (said("feedback", seq=-1, **STATE), "gave up: bad-value: 'seq' must be 0 or more"),
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


def header(values, job):
    news = {"kind": "feedback", "version": 1, "id": 0, "values": {"job": job, **values}, "arrays": []}
    return [[json.dumps(news).encode()]]


@each_side
def test_what_a_strange_server_says_of_a_job_is_one_line(side, context, runs):
    flood = lambda job: [[b"rubbish"]] * 300  # noqa: E731
    # An answer that no reader takes, as a server of another release may give it.
    bad = [{"done": None, "text": ""}, {"done": 1, "text": "\ud800"}]
    unreadable = [
        both(said("accepted", seq=0, position=0), partial(header, {"seq": 1, "total": 2, **values})) for values in bad
    ]
    with ExitStack() as stack:
        answers = [flood, *unreadable, *(replies for replies, _ in STRANGE)]
        servers = [stack.enter_context(wrong_server(context, replies)) for replies in answers]
        few = [["--timeout", "0.5", "--tries", tries] for tries in ("2", "3", "3")]
        patience = [*few, *[["--timeout", "20"]] * len(STRANGE)]
        clients = [["--endpoint", *each] for each in zip(servers, patience, strict=True)]
        numbers = [("--count", "0"), ("--count", "99999999999"), ("--cancel-at", "99999999999")]
        nowhere = [["--endpoint", "tcp://127.0.0.1:1", *pair] for pair in numbers]
        flooded, *found = runs(side, KEY, [*([*words[:2], *words[2]] for words in clients), *nowhere])
    # A flood of nonsense is no flood of lines.
    assert flooded.code == 1
    assert 0 < len([line for line in flooded.lines if line.startswith("dropped: ")]) <= 20, flooded.lines
    # It is one line for each try, and not for each answer.
    for run in found[:2]:
        assert run.code == 1 and len(run.lines) < 12, run.lines
        assert re.fullmatch("gave up: no word of it .* in 3 tries of .* s; (wrong-type|bad-json): .*", run.lines[-1])
    for run, (_, last) in zip(found[2:], STRANGE, strict=False):
        assert run.code == (1 if last.startswith("gave up") else 0), run.lines
        assert run.lines[-1] == last
        assert len(run.lines) < 6
    # Numbers have the same limits in every client.
    assert [run.code for run in found[-3:]] == [2, 2, 2]
