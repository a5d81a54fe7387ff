"""Each Python class and function names in one line the argument that it cannot use."""

from __future__ import annotations

import asyncio
import inspect
import sys
from contextlib import closing

import pytest

from netmq_example.background_client import BackgroundClient
from netmq_example.camera.client import Action, DriverClient
from netmq_example.errors import Error
from netmq_example.jobs.client import JobClient
from netmq_example.jobs.jobs import Jobs
from netmq_example.jobs.journal import Journal
from netmq_example.jobs.workers import Workers
from netmq_example.lazy_pirate import LazyPirate
from netmq_example.many_requester import ManyRequester
from netmq_example.message_requester import MessageRequester
from netmq_example.messages import Message
from netmq_example.pose_stream import PoseSubscriber
from netmq_example.publisher import Publisher
from netmq_example.security import keys
from netmq_example.security.allow_list import AllowList
from netmq_example.security.requester import ClientKeys, SecureRequester
from netmq_example.server import Server
from netmq_example.topic_listener import TopicListener
from netmq_example.work import Kind, Step
from netmq_example.worker_threads import WorkerThreads
from tests.programs import ROOT

sys.path += [str(ROOT / "python" / key) for key in ("14_long_jobs", "21_talking_character")]
import progress

NAN, WHERE = float("nan"), "tcp://127.0.0.1:5552"
# All of them refuse an object, and these by the name of the argument. The rules of check.py and arguments.py are tried
# by the first few.
MORE: dict[str, list[object]] = {
    "endpoint": [None, "", "127.0.0.1:5552", "tcp://127.0.0.1:99999"],
    "timeout": [0, -1, NAN, float("inf"), "1"],
    "tries": [None, 0, -1, NAN, 1.5, ""],
    "window": [0],
    "capacity": [0],
    "snapshots": [-1, "127.0.0.1:5552", "tcp://127.0.0.1:0"],
    "a": [-1, 33],
    "at": [-1, 10**6],
    "c": [33],
    "device": [-1, ""],
    "done": [-1, 2**53],
    "folder": [""],
    "frame": [-1],
    "grace": [-1],
    "job": ["", "../x", "x" * 65],
    "journal": ["", ":memory:", "no/such/folder", "a\0b"],
    "kinds": [{"count": print}],
    "most": [-1],
    "origins": ["http://localhost"],
    "pictures": [[]],
    "planned": [{0: "drop"}, {1: ""}],
    "prompt": ["", "x" * 1001],
    "role": ["../server"],
    "share": ["", -1, 2],
    "workers": [0, 101],
}


def lessons_02_to_07(context, folder):
    for kind in LazyPirate, ManyRequester, BackgroundClient, DriverClient, MessageRequester:
        yield kind, "endpoint context timeout tries", WHERE
    for kind in ManyRequester, BackgroundClient:
        yield kind, "window", WHERE
    yield BackgroundClient, "capacity", WHERE
    yield Publisher, "endpoint context", "tcp://127.0.0.1:0"
    yield Server, "answer endpoint context", str, "tcp://127.0.0.1:0"
    yield TopicListener, "endpoint topic socket", WHERE, "pose/"
    yield PoseSubscriber, "endpoint stream snapshots timeout", WHERE
    yield WorkerThreads, "number answer", 1, str
    for wrong in 0, 100_000:
        yield lambda number, wrong=wrong: WorkerThreads(wrong, str), "number"


def lesson_08(context, folder):
    np = pytest.importorskip("numpy", reason="lesson 08 needs numpy: kit.py run 8 installs it")
    pytest.importorskip("PIL", reason="lesson 08 needs Pillow: kit.py run 8 installs it")
    from netmq_example.camera import pictures
    from netmq_example.camera.recording import Recorder, recorded
    from netmq_example.worlds.road import Car, DrawnCamera, Road

    road = Road()
    car = Car.on(road)
    with DriverClient(WHERE, context=context) as client:
        yield client.send, "frame"
        yield client.receive, "until"
        yield Action, "frame throttle brake steer milliseconds", 1, 0, 0, 0
        yield pictures.pictures, "frame"
        yield pictures.encode, "picture"
        for wrong in np.zeros((8, 8, 3)), np.zeros((0, 8, 3), np.uint8):
            yield lambda picture, wrong=wrong: pictures.encode(wrong), "picture"
        yield pictures.decode, "file"
        yield Recorder, "folder"
        yield Recorder(None).add, "frame", None, Message("action")
        yield recorded, "folder"
        yield DrawnCamera, "road"
        yield Car.on, "road at", road
        yield road.nearest, "x y", 0, 0
        yield Car, "speed", 0, 0, 1, 0
        yield car.step, "throttle brake steer", 0, 0, 0
        yield lambda throttle: car.step(-2, 0, 0), "throttle"
        yield lambda brake: car.step(0, 2, 0), "brake"
        yield DrawnCamera(road).draw, "number right", car, 0
        yield lambda number: DrawnCamera(road).draw(car, -1), "number"


def nothing(total, finished, text):
    yield from ()


def lesson_14(context, folder):
    journal, kinds, shown = Journal(folder / "journal.sqlite3"), {"nothing": Kind(nothing, most=1)}, progress.Progress()
    with closing(Jobs(journal, kinds).workers), JobClient(WHERE, context=context) as client:
        yield Kind, "work most has_checkpoint", nothing, 1
        yield Step, "done total text checkpoint", 1, 1
        yield JobClient, "endpoint job timeout tries context", WHERE
        yield client.goal, "kind count text", "count", 1
        yield client.ask, "verb"
        yield client.watch, "request"
        yield Journal, "path"
        yield lambda journal: Journal(journal if isinstance(journal, str) else ""), "journal"
        yield Jobs, "journal kinds workers queue grace", journal, kinds
        yield Workers, "workers kinds", 1, kinds
        yield shown.show, "line share", "line"
        yield progress.words, "news"
        yield progress.share, "news"


def lesson_15(context, folder):
    keys.example(folder / "keys")
    before, allowed = sorted(folder.rglob("*")), AllowList(folder / "keys")
    with SecureRequester(WHERE, keys=ClientKeys(folder / "keys"), context=context) as requester:
        yield keys.make, "folder role", folder, "server"
        yield keys.rotate, "folder role", folder, "server"
        yield keys.enrol, "folder name key", folder, "bob", "a" * 40
        yield lambda name: keys.enrol(folder, "../bob", "a" * 40), "name"
        yield keys.revoke, "folder name", folder, "bob"
        yield keys.checked, "key"
        yield AllowList, "folder"
        yield ClientKeys, "folder"
        yield allowed.answer, "context"
        yield allowed.guard, "socket"
        yield allowed.name_of, "frame"
        yield allowed.name, "key"
        yield SecureRequester, "endpoint context keys timeout tries", WHERE
        yield requester.request, "text"
    assert sorted(folder.rglob("*")) == before


def done(call, words):
    made = call(**words)
    if inspect.iscoroutine(made):
        asyncio.run(made)
    if inspect.isgenerator(made):
        next(made)


LESSONS = [lessons_02_to_07, lesson_08, lesson_14, lesson_15]


@pytest.mark.parametrize("lesson", LESSONS)
def test_what_a_method_cannot_use_is_named(lesson, context, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for call, names, *right in lesson(context, tmp_path):
        parameters = [*inspect.signature(call).parameters]
        for name in names.split():
            for value in (object(), *MORE.get(name, [])):
                words = {**dict(zip(parameters, right, strict=False)), name: value}
                with pytest.raises((Error, ValueError, TypeError), match=rf"\b{name}\b|^bad endpoint ") as refused:
                    done(call, words)
                assert "\n" not in str(refused.value) and len(str(refused.value)) < 200
