"""Lesson 14: a job has one end, whoever is there to hear of it: cancel, deaf jobs, deaths, restarts, a full queue."""

# ruff: noqa: F401, F811

from __future__ import annotations

import itertools
import os
import re
import signal
import sys
import time
import uuid
from pathlib import Path

import pytest
import zmq

from kitlib.setup import dotnet
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.long_jobs.peers import KEY, Message, copied, jobs_server, memory, peer, read, units
from tests.programs import LIMIT, ROOT, Mark, finds_processes, leaves_nothing_to_collect

each_client = pytest.mark.parametrize("kind", CLIENTS)
# SIGKILL by its name, which Windows has not.
KILL = getattr(signal, "SIGKILL", signal.SIGTERM)


def process_of(server, job):
    return int(server.wait_for(rf"^job {job[:8]}: \w+ from \d+, in process (\d+)")[1])


@each_client
@pytest.mark.parametrize("work, said", [("count", "100 bytes, sum 5050"), ("picture", r"30000 bytes, sum \d+")])
def test_a_job_to_its_end(kind, work, said, serve, start, client_command):
    _, endpoint = serve(KEY)
    client = start(*client_command(kind, KEY, endpoint, "--kind", work, "--timeout", "20"))
    assert client.wait() == 0, client.output
    job = re.fullmatch(rf"asking {endpoint} for job ([0-9a-f]{{32}})", client.lines[0])[1]
    assert client.lines[1] == f"job {job[:8]}: accepted"
    places = [int(re.fullmatch(rf"job {job[:8]}: (\d+) of 100", line)[1]) for line in client.lines[2:-2]]
    assert places == sorted(places)
    tenths = [place // 10 for place in places]
    assert sorted(set(tenths)) == tenths, "a line for each tenth at the most"
    assert client.lines[-2] == f"job {job[:8]}: succeeded at 100 of 100"
    assert re.fullmatch(f"done: succeeded, {said}", client.lines[-1])


def test_all_clients_have_the_same_numbers(serve, start, client_command):
    """Of the same job: one begins it, and the others come back to it after its end."""
    _, endpoint = serve(KEY)
    first = start(*client_command("python", KEY, endpoint, "--kind", "picture", "--count", "40", "--timeout", "20"))
    assert first.wait() == 0, first.output
    job = first.lines[0].rpartition(" ")[2]
    for kind in CLIENTS:
        client = start(*client_command(kind, KEY, endpoint, "--resume", job, "--timeout", "20"))
        assert client.wait() == 0, client.output
        assert client.lines == [first.lines[0], *first.lines[-2:]]


@each_client
def test_leave_and_come_back(kind, jobs_server, start, client_command, peer):
    _, endpoint = jobs_server()
    long = ("--kind", "count", "--count", "5000", "--timeout", "20")
    client = start(*client_command(kind, KEY, endpoint, *long, "--leave-at", "30"))
    assert client.wait() == 0, client.output
    left, job = re.fullmatch(r"left at (\d+); come back with --resume (\w+)", client.lines[-1]).groups()
    peer(endpoint, job).at(int(left) + 20)
    again = start(*client_command(kind, KEY, endpoint, "--resume", job, "--cancel-at", "1", "--timeout", "20"))
    assert again.wait() == 0, again.output
    assert int(re.fullmatch(rf"job {job[:8]}: (\d+) of 5000", again.lines[1])[1]) >= int(left) + 20, "it went on"
    assert re.fullmatch(rf"job {job[:8]}: canceled at \d+ of 5000", again.lines[-2])


@each_client
def test_cancel(kind, serve, start, client_command):
    server, endpoint = serve(KEY)
    words = ("--kind", "count", "--count", "5000", "--cancel-at", "30", "--timeout", "20")
    client = start(*client_command(kind, KEY, endpoint, *words))
    assert client.wait() == 0, client.output
    name = client.lines[1].partition(":")[0]
    assert client.lines[-3] == f"{name}: canceling"
    done = int(re.fullmatch(rf"{name}: canceled at (\d+) of 5000", client.lines[-2])[1])
    assert client.lines[-1] == f"done: canceled, {done} bytes, sum {sum(unit % 256 for unit in range(1, done + 1))}"
    server.wait_for(rf"^{name}: canceled at {done} of 5000")


@each_client
def test_what_is_rejected_is_said_in_one_line(kind, serve, start, client_command, peer):
    _, endpoint = serve(KEY, "--workers", "1", "--queue", "1")
    for _ in range(2):
        peer(endpoint).goal(count=10_000).hear("accepted")
    full = start(*client_command(kind, KEY, endpoint))
    unknown = start(*client_command(kind, KEY, endpoint, "--resume", "no-such-job"))
    assert (full.wait(), unknown.wait()) == (1, 1)
    assert full.lines[-1] == "gave up: queue-full: 1 jobs wait already; try again later"
    assert unknown.lines[-1].startswith("gave up: unknown-job: there is no such job")


@each_client
def test_a_server_that_is_killed_goes_on_from_the_checkpoint(kind, jobs_server, start, client_command):
    server, endpoint = jobs_server("--crash-on", "40")
    # Long enough that a slow disk does not hide where it is until it has ended.
    # And so often that a busy machine has time to start another one.
    client = start(*client_command(kind, KEY, endpoint, "--kind", "count", "--count", "250", "--tries", "60"))
    assert server.wait() == 1
    again, _ = jobs_server()
    assert client.wait() == 0, client.output
    assert int(again.wait_for(r": count from (\d+), in process")[1]) >= 40, "not from the beginning"
    assert client.lines[-1] == f"done: succeeded, 250 bytes, sum {250 * 251 // 2}", "each unit was done once"


def test_progress_comes_soon_after_kill_9_and_restart(jobs_server, start, client_command, peer, capsys):
    server, endpoint = jobs_server()
    # So long that it is not over before it is killed.
    client = start(*client_command("python", KEY, endpoint, "--count", "1000", "--tries", "60"))
    client.wait_for(r": \d{3} of 1000")
    server.kill()
    began, seen = time.monotonic(), len(client.lines)
    jobs_server()
    client.wait_for(r": \d+ of 1000", start=seen)
    with capsys.disabled():
        print(f"\nprogress again {time.monotonic() - began:.2f} s after kill -9, the start of a new server included")
    peer(endpoint, client.lines[0].split()[-1]).ask("cancel")
    assert client.wait() == 0, client.output


def test_without_a_checkpoint_a_restart_aborts(jobs_server, peer, start, client_command):
    server, endpoint = jobs_server("--workers", "1")
    running, waiting = peer(endpoint).goal("path", 300), peer(endpoint)
    running.hear("feedback")
    waiting.goal("count", 5).hear("accepted")
    server.kill()
    jobs_server()
    result = running.result("aborted")
    assert result.values["text"] == "the server was restarted"
    assert waiting.result("succeeded").values["done"] == 5, "it had not begun"
    client = start(*client_command("python", KEY, endpoint, "--resume", running.job))
    assert client.wait() == 1
    assert client.lines[-1] == "gave up: the job was aborted; see above"


def test_the_same_goal_is_the_same_job_and_another_is_rejected(serve, peer):
    server, endpoint = serve(KEY)
    first = peer(endpoint).goal()
    for _ in range(4):
        first.goal()
    second = peer(endpoint, first.job).goal()
    assert units(first.result("succeeded")) == units(second.result("succeeded")) == 100
    assert len([line for line in server.lines if ": count from" in line]) == 1
    assert second.ask("goal", kind="count", count=99).hear("rejected").values["code"] == "other-goal"


def test_feedback_is_the_newest_state_and_not_often(serve, peer):
    _, endpoint = serve(KEY)
    watcher = peer(endpoint).goal(count=200)
    began = time.monotonic()
    watcher.result("succeeded")
    seqs = [news.values["seq"] for news in watcher.heard if news.kind == "feedback"]
    # Who asks again, in a second without a word, is told again where it stands.
    told_again = len(seqs) - len(set(seqs))
    assert told_again <= watcher.asked_again
    assert len(seqs) - told_again <= 10 * (time.monotonic() - began) + 2
    assert len(seqs) >= 3
    assert seqs == sorted(seqs)


def test_an_end_is_for_ever(jobs_server, peer):
    server, endpoint = jobs_server()
    done = peer(endpoint).goal(count=5)
    result = done.result("succeeded")
    for verb in ("cancel", "status", "cancel"):
        assert done.ask(verb).hear("result").frames() == result.frames(), "unchanged"
    server.kill()
    jobs_server()
    assert done.ask("cancel").hear("result").frames() == result.frames()
    assert done.ask("forget").hear("forgotten")
    # A goal that comes late begins nothing.
    assert done.goal(count=5).hear("forgotten")
    assert done.ask("cancel").hear("forgotten")


def test_cancel_in_the_queue_and_forget_too_early(serve, peer):
    _, endpoint = serve(KEY, "--workers", "1")
    running, waiting, last = peer(endpoint).goal(count=1000), peer(endpoint), peer(endpoint)
    running.hear("accepted")
    assert waiting.goal().hear("accepted").values["position"] == 1
    assert last.goal().hear("accepted").values["position"] == 2
    assert running.ask("forget").hear("rejected").values["code"] == "not-ended"
    assert waiting.ask("cancel").result("canceled").values["done"] == 0
    # Whoever was asked twice answers twice, and the second answer may be an old one.
    last.ask("status").hear("accepted", until=lambda news: news.values["position"] == 1)


def test_the_race_of_a_cancel_with_the_end(serve, peer):
    """However it goes, both say the same, and they go on saying it."""
    _, endpoint = serve(KEY)
    ends = set()
    for delay in range(12):
        racer = peer(endpoint).goal(count=3)
        racer.hear("feedback", "result")
        time.sleep(delay / 200)
        result = racer.ask("cancel").hear("result")
        ends.add(result.values["status"])
        assert racer.ask("status").hear("result").frames() == result.frames()
        assert units(result) == result.values["done"]
    assert ends <= {"succeeded", "canceled"}


def test_how_soon_a_cancel_works_with_four_busy_workers(serve, peer, capsys):
    # Two seconds are too few where a busy machine gives a worker that computes no processor.
    _, endpoint = serve(KEY, "--workers", "4", "--grace", "10")
    # Two that compute, and two that are deaf.
    busy = [peer(endpoint).goal(kind, 200) for kind in ("picture", "picture")]
    busy += [peer(endpoint).goal("deaf", 10_000) for _ in range(2)]
    for one in busy:
        one.hear("feedback")
    asked, told = [], []
    for one in busy:
        began = time.monotonic()
        one.ask("cancel").hear("canceling")
        asked.append((one, began, time.monotonic() - began))
    for one, began, acknowledged in asked:
        text = one.result("canceled").values["text"]
        told.append((acknowledged, time.monotonic() - began, text))
    with capsys.disabled():
        for acknowledged, ended, text in told:
            print(
                f"\ncancel: acknowledged after {acknowledged * 1000:.0f} ms, ended after {ended:.2f} s {text}", end=""
            )
        print()
    assert [text for _, _, text in told] == ["", "", *["it did not listen, and was killed"] * 2]
    assert min(ended for _, ended, _ in told[2:]) >= 10, "they had their time"
    # The workers are there for others again.
    assert units(peer(endpoint).goal(count=3).result("succeeded")) == 3


@finds_processes
def test_a_worker_that_dies(serve, peer):
    server, endpoint = serve(KEY, "--workers", "2")
    # The search first, and 300 units: so both are still at it when they are killed.
    searching = peer(endpoint).goal("path", 300)
    searching.hear("feedback")
    counting = peer(endpoint).goal(count=300)
    counting.at(30)
    os.kill(process_of(server, counting.job), KILL)
    os.kill(process_of(server, searching.job), KILL)
    assert searching.result("aborted").values["text"] == "its worker died"
    assert units(counting.result("succeeded")) == 300
    assert re.search(rf"job {counting.job[:8]}: count from ([3-9]\d|\d{{3}}), in process", server.output), "on it went"


@finds_processes
def test_a_job_that_always_kills_its_worker_is_aborted(serve, peer):
    server, endpoint = serve(KEY, "--workers", "1")
    fatal = peer(endpoint).goal(count=10_000)
    for death in itertools.count(1):
        if death > 3:
            break
        while len(found := re.findall(rf"job {fatal.job[:8]}: .* in process (\d+)", server.output)) < death:
            server.wait_for("in process", start=len(server.lines))
        os.kill(int(found[-1]), KILL)
    assert fatal.result("aborted").values["text"] == "its worker died"


@finds_processes
def test_no_worker_outlives_a_killed_server(serve, peer):
    """Not even one that is deaf."""
    mark = Mark()
    server, endpoint = serve(KEY, **mark.environment)
    peer(endpoint).goal("deaf", 10_000).hear("feedback")
    assert len(mark.processes()) > 1
    server.kill()
    end = time.monotonic() + LIMIT
    while mark.processes() and time.monotonic() < end:
        time.sleep(0.05)
    assert not mark.processes()


def test_a_mistake_in_the_work_aborts_the_job_and_is_shown(start, peer, tmp_path):
    lesson = copied(tmp_path)
    work = (lesson / "work.py").read_text(encoding="utf-8")
    (lesson / "work.py").write_text(
        work.replace("time.sleep(UNIT_SECONDS)", 'raise ValueError("my own\\nmistake")', 1), "utf-8"
    )
    server = start(PYTHON, lesson / "server.py", "--endpoint", "tcp://127.0.0.1:*", folder=tmp_path)
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    assert peer(endpoint).goal().result("aborted").values["text"] == r"ValueError('my own\nmistake')"
    server.wait_for(r'work\.py", line \d+, in count')
    assert server.process.poll() is None


HOSTILE = [
    [b""],
    [b"{}"],
    [b"goal", b"{}"],
    [b"\xff" * 100],
    [b"[" * 60_000],
    Message("goal").frames(),
    Message("goal", values={"job": 7}).frames(),
    Message("goal", values={"job": "x" * 65, "kind": "count", "count": 1}).frames(),
    Message("goal", values={"job": "../x", "kind": "count", "count": 1}).frames(),
    Message("goal", values={"job": "a", "kind": "count"}).frames(),
    Message("goal", values={"job": "a", "kind": "count", "count": "1"}).frames(),
    Message("goal", values={"job": "a", "kind": "count", "count": True}).frames(),
    Message("goal", values={"job": "a", "kind": "count", "count": 0}).frames(),
    Message("goal", values={"job": "a", "kind": "count", "count": 2**52}).frames(),
    Message("goal", values={"job": "a", "kind": "Step", "count": 1}).frames(),
    Message("goal", values={"job": "a", "kind": "picture", "count": 201}).frames(),
    Message("goal", values={"job": "a", "kind": "count", "count": 1, "text": 7}).frames(),
    Message("goal", values={"job": "a", "kind": "count", "count": 1, "text": "x" * 1001}).frames(),
    Message("eat", values={"job": "a"}).frames(),
    Message("status", values={"job": "a"}).frames(),
    Message("cancel", values={"job": "a"}).frames(),
    Message("forget", values={"job": "a"}).frames(),
]


def test_what_is_no_request_is_rejected_and_begins_nothing(serve, peer):
    server, endpoint = serve(KEY)
    rude = peer(endpoint)
    for frames in HOSTILE:
        rude.socket.send_multipart(frames)
        assert rude.socket.poll(LIMIT * 1000), frames
        answer = read(rude.socket.recv_multipart())
        assert answer.kind == "rejected", (frames, answer)
        assert answer.values["code"] and answer.values["text"].isprintable()
    # What it does not know it ignores.
    rude.ask("goal", kind="count", count=1, more="?")
    assert units(rude.result("succeeded")) == 1
    assert "Traceback" not in server.output


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="reads the server's memory in /proc")
def test_clients_that_never_fetch_leave_the_server_small(serve, peer):
    server, endpoint = serve(KEY, "--workers", "2")
    peer(endpoint).goal(count=1).result()
    before = memory(server)
    for _ in range(20):
        stuck = peer(endpoint)
        stuck.socket.rcvhwm = 1
        stuck.goal("picture", 60)
    assert peer(endpoint, stuck.job).result("succeeded").values["done"] == 60
    assert memory(server) - before < 40e6


LIMITED = f"""
import resource, signal, sys
sys.path.insert(0, {str(ROOT / "python" / KEY)!r})
import server
if __name__ == "__main__":
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (150_000, 150_000))
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
    for _ in range(300):
        last = peer(endpoint).goal(count=1)
        last.hear("accepted", "rejected", "result", "feedback")
        if last.heard[-1].kind == "rejected":
            break
    assert last.heard[-1].values["code"] == "journal"
    server.wait_for("^cannot use the journal .*; nothing new until it is over$")
    assert first.ask("status").hear("result").frames() == result.frames()
    assert server.process.poll() is None
    assert "Traceback" not in server.output


def test_a_second_server_does_not_get_the_same_journal(jobs_server, start, tmp_path):
    """It would do each job once more."""
    jobs_server()
    journal = str(tmp_path / "journal.sqlite3")
    words = ["--endpoint", "tcp://127.0.0.1:0", "--journal", journal]
    second = start(PYTHON, ROOT / "python" / KEY / "server.py", *words)
    assert second.wait() == 2
    assert second.lines[-1].endswith(
        f"cannot use the journal {journal}: database is locked; try --journal another.sqlite3"
    )


@pytest.mark.parametrize("work", ["count", "picture"])
def test_what_a_frame_costs(work, serve, start, netmq, capsys):
    """The main thread's share, while a job is watched and its picture drawn."""
    _, endpoint = serve(KEY)
    harness = dotnet.build(netmq, ROOT / "tests" / "unity" / "play")
    words = [f"endpoint={endpoint}", f"kind={work}", "count=10000" if work == "count" else "count=200"]
    player = start("dotnet", harness, "cost", "14", "300", "after= of ", *words)
    assert player.wait() == 0, player.output
    cost = player.wait_for("^cost: .*")[0]
    with capsys.disabled():
        print(f"\n{work}: {cost}")
    assert leaves_nothing_to_collect(cost), cost
