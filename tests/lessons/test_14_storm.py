"""Lesson 14 in a storm: kill -9, cancel, the same goal again, leaving and coming back, in a random order each time.

A seed says what happens and in which order; when, the machine says as well. What must hold in every order: each id ends
once, whoever asks hears the same, what was told stays true, and each unit was done once.
"""

# ruff: noqa: F401, F811
from __future__ import annotations

import random
import time
from collections import Counter

import pytest

from tests.lessons.long_jobs.peers import jobs_server, memory, peer, read, units

VERBS = ("kill", "cancel", "resend", "resend", "leave", "come back", "nothing")


class Storm:
    """One server after the other with one journal, and what was heard of each job."""

    def __init__(self, jobs_server, peer):
        self.begin, self.peer, self.kills = jobs_server, peer, 0
        self.server, self.endpoint = jobs_server()

    def kill(self):
        self.server.kill()
        self.kills += 1
        self.server, _ = self.begin()

    def interleaving(self, seed):
        chance = random.Random(seed)
        job, total, canceled = f"seed-{seed}-{chance.randrange(10**6)}", chance.randint(3, 30), False
        here, all_peers, told = [], [], []

        def come():
            here.append(self.peer(self.endpoint, job))
            all_peers.append(here[-1].goal(count=total))

        come()
        for _ in range(chance.randint(3, 8)):
            verb = chance.choice(VERBS)
            told.append(verb)
            if verb == "kill":
                self.kill()
            elif verb == "come back" or not here:
                come()
            elif verb == "leave":
                here.pop(chance.randrange(len(here))).socket.close()
            elif verb == "resend":
                chance.choice(here).goal(count=total)
            elif verb == "cancel":
                canceled = True
                chance.choice(here).ask("cancel")
            listen(here, chance.uniform(0, 0.12))
        come()
        # A cancel that came before its goal, or was lost with a server that was killed, is none.
        result = here[-1].result(None if canceled else "succeeded")
        for one in here[:-1]:
            one.ask("status").result(result.values["status"])
        check(job, total, result, all_peers, told)
        return result


def listen(peers, seconds):
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        heard = False
        for one in peers:
            if one.socket.poll(int(left * 1000 / len(peers))):
                one.heard.append(read(one.socket.recv_multipart()))
                heard = True
        if not peers or (not heard and left < 0.01):
            return


def check(job, total, result, peers, told):
    assert units(result) == result.values["done"] <= total, told
    assert result.values["status"] == "canceled" or result.values["done"] == total, told
    said = {}
    for one in peers:
        for news in one.heard:
            # The same number never means two things, whichever server said it. Where it waits may change.
            if news.kind not in ("accepted", "rejected"):
                frames = [bytes(frame) for frame in news.frames()]
                assert said.setdefault(news.values["seq"], frames) == frames, (job, told)
            if news.kind == "rejected":
                assert news.values["code"] == "unknown-job", (news.values, told)
    ends = [frames for frames in said.values() if frames[0].startswith(b'{"kind":"result"')]
    assert ends == [[bytes(frame) for frame in result.frames()]], told
    assert max(said) == result.values["seq"], "nothing after the end"


@pytest.mark.timeout(900)
def test_whatever_happens_each_job_ends_once(jobs_server, peer, pytestconfig, tmp_path, capsys):
    seeds = 200 if pytestconfig.getoption("--long") else 20
    storm, ends = Storm(jobs_server, peer), {}
    for seed in range(seeds):
        result = storm.interleaving(seed)
        ends[result.values["job"]] = result
    # And once more from the journal, by a server that has seen none of them.
    storm.kill()
    for job, result in ends.items():
        assert storm.peer(storm.endpoint, job).ask("cancel").hear("result").frames() == result.frames()
    counts = Counter(result.values["status"] for result in ends.values())
    with capsys.disabled():
        print(f"\n{seeds} interleavings, {storm.kills} kills: {dict(counts)}")
    assert counts.keys() == {"succeeded", "canceled"}, "the storm had both"
    assert storm.kills > seeds / 4


@pytest.mark.long
@pytest.mark.timeout(900)
def test_ten_thousand_jobs_leave_the_server_as_small_as_it_was(jobs_server, peer, capsys):
    server, endpoint = jobs_server("--workers", "4")
    one, began, ended, waiting, after = peer(endpoint), time.monotonic(), set(), set(), {}
    while len(ended) < 10_000:
        while len(ended) + len(waiting) < 10_000 and len(waiting) < 40:
            waiting.add(job := f"job-{len(ended) + len(waiting)}")
            one.ask("goal", job=job, kind="count", count=1)
        if not one.socket.poll(1000):
            # As clients do: who has not asked for some seconds is told nothing more.
            for job in waiting:
                one.ask("status", job=job)
            continue
        news = read(one.socket.recv_multipart())
        assert news.kind != "rejected", news.values
        if news.kind == "result":
            assert news.values["status"] == "succeeded"
            ended.add(news.values["job"])
            waiting.discard(news.values["job"])
            after[len(ended)] = after.get(len(ended)) or (memory(server) if len(ended) in (1000, 10_000) else 0)
    with capsys.disabled():
        seconds = time.monotonic() - began
        print(f"\n10,000 jobs in {seconds:.0f} s; memory {after[1000] / 1e6:.1f} MB, then {after[10_000] / 1e6:.1f} MB")
    assert after[10_000] - after[1000] < 10e6
