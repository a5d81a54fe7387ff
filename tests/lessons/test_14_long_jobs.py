"""Lesson 14: a job has one end, whoever is there to hear of it: cancel, deaf jobs, deaths, restarts, a full queue."""

# ruff: noqa: F401, F811

import importlib.util
import io
import os
import random
import re
import signal
import sys
import time
from collections import Counter
from contextlib import closing
from itertools import accumulate
from pathlib import Path
from typing import Any

import pytest
import zmq

from kitlib.setup import dotnet
from netmq_example.jobs import jobs as jobs_module
from netmq_example.jobs.jobs import Jobs
from netmq_example.jobs.journal import Journal
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.long_jobs.peers import KEY, Message, jobs_server, peer, read, units
from tests.programs import LIMIT, ROOT, finds_processes, leaves_nothing_to_collect

sys.path.append(str(ROOT / "python" / KEY))
from progress import Progress

# SIGKILL by its name, which Windows has not.
KILL = getattr(signal, "SIGKILL", signal.SIGTERM)
SUM = dict(enumerate(accumulate(unit % 256 for unit in range(5001))))


def process_of(server, job, seen=0):
    return int(server.wait_for(rf"^job {job[:8]}: \w+ from \d+, in process (\d+)", start=seen)[1])


@pytest.fixture
def work(monkeypatch):
    """The module with the kinds of work; a worker finds it by its name, too."""
    monkeypatch.syspath_prepend(str(ROOT / "python" / KEY))
    spec = importlib.util.spec_from_file_location("work", ROOT / "python" / KEY / "work.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "work", module)
    spec.loader.exec_module(module)
    return module


# The clients


@pytest.mark.parametrize("kind", CLIENTS)
def test_clients_in_a_terminal_and_in_unity(kind, serve, runs, peer):
    server, endpoint = serve(KEY, "--workers", "3")
    ended = peer(endpoint).goal("picture", 6)
    drawn = bytes(ended.result("succeeded").arrays[0].data)
    held = peer(endpoint).goal(count=5000)
    table = {
        "count": ["--kind", "count", "--count", "40"],
        "picture": ["--kind", "picture", "--count", "8"],
        "again": ["--resume", ended.job],
        "leave": ["--kind", "count", "--count", "60", "--leave-at", "5"],
        "held": ["--resume", held.job, "--leave-at", "1"],
        "cancel": ["--kind", "count", "--count", "5000", "--cancel-at", "10"],
        "held again": ["--resume", held.job, "--cancel-at", "1"],
        "unknown": ["--resume", "no-such-job"],
        "forget": ["--kind", "path", "--count", "3", "--forget", *(["true"] if kind == "unity" else [])],
    }
    words = [["--endpoint", endpoint, "--timeout", "20", *each] for each in table.values()]
    said, jobs = {}, {}
    for name, run in zip(table, runs(kind, KEY, words), strict=True):
        assert run.code == (1 if name == "unknown" else 0), (name, run.lines)
        first, *lines = [line for line in run.lines if "runInBackground" not in line]
        jobs[name] = re.fullmatch(rf"asking {endpoint} for job ([0-9a-f]{{32}}|no-such-job)", first)[1]
        said[name] = [line.replace(f"job {jobs[name][:8]}: ", "") for line in lines]
    accepted, *places, end, done = said["count"]
    tenths = [int(re.fullmatch(r"(\d+) of 40", place)[1]) // 4 for place in places]
    assert tenths and sorted(set(tenths)) == tenths, "a line for each tenth at the most"
    assert [accepted, end, done] == [
        "accepted",
        "succeeded at 40 of 40",
        f"done: succeeded, 40 bytes, sum {SUM[40]}",
    ]
    assert said["picture"][-2:] == ["succeeded at 8 of 8", "done: succeeded, 192 bytes, sum 5861"]
    assert said["again"] == ["succeeded at 6 of 6", f"done: succeeded, {len(drawn)} bytes, sum {sum(drawn)}"]
    left = {}
    for name, least in ("leave", 5), ("held", 1):
        left[name], again = re.fullmatch(r"left at (\d+); come back with --resume (\w+)", said[name][-1]).groups()
        assert again == jobs[name] and int(left[name]) >= least
    assert int(re.fullmatch(r"(\d+) of 5000", said["held again"][0])[1]) > int(left["held"]), "it went on"
    *_, canceling, end, done = said["cancel"]
    count = int(re.fullmatch(r"canceled at (\d+) of 5000", end)[1])
    assert canceling == "canceling" and count >= 10
    assert done == f"done: canceled, {count} bytes, sum {SUM[count]}"
    server.wait_for(rf"^job {jobs['cancel'][:8]}: canceled at {count} of 5000")
    assert said["unknown"][-1].startswith("gave up: unknown-job: there is no such job")
    end = ["succeeded at 900 of 900, a path of 122 steps", "forgotten", "done: succeeded, 0 bytes, sum 0"]
    assert said["forget"][-3:] == end
    assert peer(endpoint, jobs["forget"]).goal("path", 3).hear("forgotten", "accepted").kind == "forgotten"


def test_a_server_that_crashes_goes_on_from_the_checkpoint_when_started_in_the_same_way(
    jobs_server, start, start_client
):
    server, endpoint = jobs_server("--crash-on", "40")
    # Long enough that a slow disk does not hide where it is until it has ended.
    # And so often that a busy machine has time to start another one.
    first = start_client("python", KEY, endpoint, "--kind", "count", "--count", "250", "--tries", "60")
    job = first.wait_for("^asking .* for job (.*)")[1]
    first.wait_for("accepted")
    watching = start_client("csharp", KEY, endpoint, "--resume", job, "--tries", "60")
    assert server.wait() == 1
    again, _ = jobs_server("--crash-on", "40")
    for client in (first, watching):
        assert client.wait() == 0, client.output
        assert client.lines[-1] == f"done: succeeded, 250 bytes, sum {SUM[250]}", "each unit was done once"
    assert int(again.wait_for(r": count from (\d+), in process")[1]) >= 40, "not from the beginning"


def test_unity_shows_the_picture_and_what_a_frame_costs(serve, start, netmq):
    """JobView, and the main thread's share while a picture is drawn."""
    checks = dotnet.build(netmq, ROOT / "tests" / "lessons" / "checks")
    program = start("dotnet", checks, "jobs", serve(KEY)[1])
    assert program.wait() == 0, program.output
    assert leaves_nothing_to_collect(program.wait_for("^cost: .*")[0]), program.output


# The work


def test_work_that_goes_on_is_the_same_as_work_that_was_never_interrupted(work):
    whole = [step.checkpoint for step in work.picture(8, b"", "")]
    assert [checkpoint.shape for checkpoint in whole] == [(y, 8, 3) for y in range(1, 9)]
    rest = list(work.picture(8, bytes(whole[4].data), ""))
    assert [(step.done, step.total) for step in rest] == [(6, 8), (7, 8), (8, 8)]
    assert rest[-1].checkpoint == whole[-1]
    counted = list(work.count(3, b"\1", ""))
    assert [(step.done, step.total, bytes(step.checkpoint.data)) for step in counted] == [
        (2, 3, b"\1\2"),
        (3, 3, b"\1\2\3"),
    ]
    searched = [(step.done, step.total, step.text) for step in work.path(4, b"", "")]
    assert searched == [(1000, 1600, "9 cells at the edge"), (1600, 1600, "a path of 270 steps")]


# The server's answers


def test_goals_ends_and_what_is_forgotten(jobs_server, peer):
    server, endpoint = jobs_server()
    began = time.monotonic()
    first = peer(endpoint).goal()
    for _ in range(4):
        first.goal()
    second = peer(endpoint, first.job).goal()
    # Feedback is the newest state and not often.
    assert units(first.result("succeeded")) == units(second.result("succeeded")) == 100
    seqs = [news.values["seq"] for news in first.heard if news.kind == "feedback"]
    # A client that asks again, in a second without a word, is told again where it stands.
    told_again = len(seqs) - len(set(seqs))
    assert told_again <= 5 + first.asked_again
    assert len(seqs) - told_again <= 10 * (time.monotonic() - began) + 2
    assert len(seqs) >= 3 and seqs == sorted(seqs)
    # The same goal is the same job, and another is rejected.
    assert len([line for line in server.lines if ": count from" in line]) == 1
    assert second.ask("goal", kind="count", count=99).hear("rejected").values["code"] == "other-goal"
    # An end is for ever.
    done = peer(endpoint).goal(count=5)
    result = done.result("succeeded")
    for verb in ("cancel", "status", "cancel"):
        assert done.ask(verb).hear("result").frames() == result.frames(), "unchanged"
    # The race of a cancel with the end: however it goes, both say the same, and they go on saying it.
    for delay in range(4):
        racer = peer(endpoint).goal(count=3)
        racer.hear("feedback", "result")
        time.sleep(delay / 66)
        end = racer.ask("cancel").hear("result")
        assert end.values["status"] in ("succeeded", "canceled")
        assert racer.ask("status").hear("result").frames() == end.frames()
        assert units(end) == end.values["done"]
    server.kill()
    jobs_server()
    assert done.ask("cancel").hear("result").frames() == result.frames()
    assert done.ask("forget").hear("forgotten")
    # A goal that comes late begins nothing.
    assert done.goal(count=5).hear("forgotten")
    assert done.ask("cancel").hear("forgotten")


def test_the_queue(start, peer, tmp_path):
    """The server is started from another folder: a worker imports the program again, by the path that was given."""
    words = ["--endpoint", "tcp://127.0.0.1:*", "--journal", tmp_path / "journal.sqlite3"]
    server = start(PYTHON, f"../python/{KEY}/server.py", *words, "--workers", "1", "--queue", "2", folder=ROOT / "docs")
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    running, waiting, last, full = peer(endpoint).goal(count=1000), *(peer(endpoint) for _ in range(3))
    assert running.hear("accepted").values["position"] == 0
    assert waiting.goal().hear("accepted").values["position"] == 1
    assert last.goal(count=3).hear("accepted").values["position"] == 2
    rejected = full.goal().hear("rejected").values
    assert (rejected["code"], rejected["text"]) == ("queue-full", "2 jobs wait already; try again later")
    assert running.ask("forget").hear("rejected").values["code"] == "not-ended"
    assert waiting.ask("cancel").result("canceled").values["done"] == 0
    # A server that was asked twice answers twice, and the second answer may be an old one.
    last.ask("status").hear("accepted", until=lambda news: news.values["position"] == 1)
    full.goal(count=4).hear("accepted")
    running.ask("cancel").result("canceled")
    assert units(last.result("succeeded")) == 3
    assert units(full.result("succeeded")) == 4


def test_who_does_not_ask_again_is_told_nothing_more(work, tmp_path, monkeypatch):
    """For a client that is gone nothing piles up."""
    monkeypatch.setattr(jobs_module, "WATCH_SECONDS", 0.5)
    jobs = Jobs(Journal(tmp_path / "journal.sqlite3"), work.KINDS, workers=1)
    goal = Message("goal", values={"job": "a", "kind": "count", "count": 5000}).frames()
    with closing(jobs.workers):
        jobs.answer(b"client", goal)
        end, told = time.monotonic() + LIMIT, Counter()
        while jobs.live["a"].done < 60:
            assert time.monotonic() < end
            told.update(news.values.get("done", 0) for _, news in jobs.turn())
            zmq.select([jobs.workers.wake_socket], [], [], 0.1)
        assert len(told) > 0 and max(told) < 50, told
        jobs.answer(b"another", Message("status", values={"job": "a"}).frames())
        assert [client for client, _ in jobs.turn()][:1] == [b"another"]


GOAL = {"job": "a", "kind": "count", "count": 1}
WRONG_GOALS: list[dict[str, Any]] = [
    *({"job": job} for job in (7, "x" * 65, "../x")),
    *({"count": count} for count in ("1", True, 0, 2**52)),
    *({"text": text} for text in (7, "x" * 1001)),
    {"kind": "Step"},
    {"kind": "picture", "count": 201},
]
HOSTILE = [
    *([b""], [b"{}"], [b"goal", b"{}"], [b"\xff" * 100], [b"[" * 60_000]),
    *(Message("goal", values=values).frames() for values in ({}, {"job": "a", "kind": "count"})),
    *(Message("goal", values={**GOAL, **wrong}).frames() for wrong in WRONG_GOALS),
    *(Message(kind, values={"job": "a"}).frames() for kind in ("eat", "status", "cancel", "forget")),
]


def test_what_is_no_request_is_rejected_and_begins_nothing(serve, peer):
    server, endpoint = serve(KEY)
    rude = peer(endpoint)
    for frames in HOSTILE:
        rude.socket.send_multipart(frames)
        answer = read(rude.socket.recv_multipart())
        assert answer.kind == "rejected", (frames, answer)
        assert answer.values["code"] and answer.values["text"].isprintable()
    # A field that it does not know is ignored; and these are as long as may be.
    longest = peer(endpoint, "x" * 64).ask("goal", kind="count", count=1, more="?", text="x" * 1000)
    assert units(longest.result("succeeded")) == 1
    assert "Traceback" not in server.output


# What happens to a server and its workers


@finds_processes
def test_workers_that_die_and_servers_that_are_killed(jobs_server, peer):
    """No worker outlives a killed server, not even one that is deaf."""
    server, endpoint = jobs_server("--workers", "2")
    counting, deaf, waiting = peer(endpoint).goal(count=5000), peer(endpoint).goal("deaf", 10_000), peer(endpoint)
    deaf.hear("feedback")
    counting.at(10)
    os.kill(process_of(server, counting.job), KILL)
    os.kill(process_of(server, deaf.job), KILL)
    assert deaf.result("aborted").values["text"] == "its worker died"
    server.wait_for(rf"job {counting.job[:8]}: count from [1-9]\d+, in process")
    deaf = peer(endpoint).goal("deaf", 10_000)
    deaf.hear("feedback")
    waiting.goal(count=5).hear("accepted")
    workers = re.findall(r"in process (\d+)", server.output)[-2:]
    server.kill()
    end = time.monotonic() + LIMIT
    while any(alive(number) for number in workers) and time.monotonic() < end:
        time.sleep(0.05)
    assert not [number for number in workers if alive(number)]
    server, _ = jobs_server("--workers", "2")
    assert deaf.result("aborted").values["text"] == "the server was restarted"
    assert waiting.result("succeeded").values["done"] == 5, "it had not begun"
    for _ in range(4):
        counting.hear("feedback")
        server.kill()
        server, _ = jobs_server("--workers", "2")
    # A restart is no death of a worker: three times it may take that with it.
    seen = 0
    for _ in range(3):
        number = process_of(server, counting.job, seen)
        seen = len(server.lines)
        os.kill(number, KILL)
    result = counting.result("aborted")
    assert result.values["text"] == "its worker died" and units(result) >= 10
    said: dict[int, list[bytes]] = {}
    for news in counting.heard:
        if news.kind != "accepted":
            frames = [bytes(frame) for frame in news.frames()]
            assert said.setdefault(news.values["seq"], frames) == frames, "a number never means two things"


def alive(number):
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(sys.platform == "win32", reason="sends Ctrl-C to one process")
def test_a_deaf_job_is_killed_and_a_worker_takes_no_notice_of_ctrl_c(serve, peer):
    # Two seconds are too few where a busy machine gives a worker that counts no processor.
    server, endpoint = serve(KEY, "--workers", "2", "--grace", "5")
    # A terminal sends Ctrl-C to all processes; a worker is there for the server to end. In the moment of its begin:
    counting = peer(endpoint).goal(count=300)
    os.kill(process_of(server, counting.job), signal.SIGINT)
    deaf = peer(endpoint).goal("deaf", 10_000)
    deaf.hear("feedback")
    asked = time.monotonic()
    for job in (counting, deaf):
        job.ask("cancel").hear("canceling")
    assert counting.result("canceled").values["text"] == ""
    result = deaf.result("canceled").values
    assert (result["text"], result["done"]) == ("it did not listen, and was killed", 1)
    assert time.monotonic() - asked >= 5, "it had its time"
    # The workers are there for others again.
    last = [peer(endpoint).goal("deaf", 10_000) for _ in range(2)]
    for job in last:
        job.hear("feedback")
    assert server.output.count("in process") == 4
    # One that was stopped does not hold the server.
    os.kill(process_of(server, last[0].job), signal.SIGSTOP)
    assert server.stop(signal.SIGINT, limit=LIMIT / 2) == 0
    assert "Traceback" not in server.output


LIMITED = f"""
import resource, signal, sys
sys.path.insert(0, {str(ROOT / "python" / KEY)!r})
import server
if __name__ == "__main__":
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
    server.main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits the size of files as Unix does")
def test_a_full_disk_rejects_what_cannot_be_written_down(start, peer, tmp_path):
    """A limit on the size of files is a full disk to SQLite; the jobs before it stay as they were."""
    words = ["--endpoint", "tcp://127.0.0.1:*", "--journal", tmp_path / "journal.sqlite3"]
    # Its workers would begin with this text again, so it is a file.
    limited = tmp_path / "limited.py"
    limited.write_text(LIMITED, encoding="utf-8")
    server = start(PYTHON, limited, *words)
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    first = peer(endpoint).goal(count=3)
    result = first.result("succeeded")
    for _ in range(200):
        last = peer(endpoint).goal(count=1)
        last.hear("accepted", "rejected", "result", "feedback")
        if last.heard[-1].kind == "rejected":
            break
    assert last.heard[-1].values["code"] == "journal"
    server.wait_for("^cannot use the journal .*; nothing new until this is fixed$")
    assert first.ask("status").hear("result").frames() == result.frames()
    assert server.process.poll() is None
    assert "Traceback" not in server.output
