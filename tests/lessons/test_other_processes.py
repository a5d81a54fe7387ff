"""Errors, copies and sockets cross to another process, or are used in one after a fork; and programs whose console
is a notebook's, or nobody's.
"""

import copy
import gc
import importlib
import inspect
import pickle
import pkgutil
import re
import shlex
import subprocess
import sys
import threading

import pytest
import zmq

import netmq_example
from netmq_example import extras
from netmq_example.background_client import BackgroundClient
from netmq_example.messages import MessageError
from netmq_example.one_process import OneProcess
from tests.conftest import PYTHON
from tests.lessons.uses import USES
from tests.programs import LIMIT, ROOT, finished, steady_endpoint

posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows neither forks nor fills a pipe that way")


def modules():
    """Each module of the package whose packages are here."""
    for found in pkgutil.walk_packages(netmq_example.__path__, "netmq_example."):
        try:
            yield importlib.import_module(found.name)
        except ImportError:
            pass


def classes(kind):
    # Not what a door would load, whose packages may be missing.
    found = {each for module in modules() for each in vars(module).values() if inspect.isclass(each)}
    return [each for each in found if issubclass(each, kind) and each.__module__.startswith("netmq_example")]


# An error comes whole


def test_each_error_survives_what_libraries_do_with_it():
    errors = [kind("what: is wrong") for kind in classes(Exception)]
    errors += [kind("a-code", "what: is wrong", 7) for kind in classes(MessageError)]
    assert len(errors) > 8
    for error in errors:
        # Gymnasium's AsyncVectorEnv gives the error itself to its class.
        made = [pickle.loads(pickle.dumps(error)), copy.copy(error), copy.deepcopy(error)]
        again = [type(error)(error), type(error)(str(error)), type(error)(*error.args)]
        for other in made + again:
            assert (type(other), str(other)) == (type(error), str(error))
        if isinstance(error, MessageError):
            assert {(other.code, other.text, other.id) for other in made} == {(error.code, error.text, error.id)}
            assert {(other.code, other.text) for other in again} == {(error.code, error.text)}


# An object with a socket has one process


def test_what_has_a_socket_or_a_thread_is_not_copied():
    kinds = classes(OneProcess)
    assert len(kinds) >= 10
    for kind in kinds:
        for way in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(TypeError) as refused:
                way(kind.__new__(kind))
            cure = "give a function that makes one"
            assert str(refused.value) == f"a {kind.__name__} cannot be copied, nor sent to another process: {cure}"


# Made in the parent, used in the child: each would wait there for ever.
FORKS = """
import os, sys
sys.path[:0] = [{root!r}, {root!r} + "/python"]
from netmq_example.envs.simulators import FREE_PORT, Simulators
from netmq_example.fleet.trainer import FleetSocket
from netmq_example.journal import Journal
from netmq_example.messages import Message
from netmq_example.video.films import Films
from tests.lessons.uses import USES

nowhere = "tcp://127.0.0.1:9"
simulators = Simulators(FREE_PORT)
made = {{name: (make(nowhere), use) for name, (make, use) in USES.items()}} | {{
    "environment": (simulators, lambda it: it.connection.ask(Message("render"))),
    "waiting": (simulators, lambda it: it.find(print)),
    "Films": (Films(FREE_PORT), lambda it: it.wait(0.1)),
    "FleetSocket": (FleetSocket(nowhere, "CartPole", 1), lambda it: it.recv_multipart()),
    "Journal": (Journal(sys.argv[1]), lambda it: it.find(b"1")),
}}
if os.fork():
    os.wait()
else:
    for name, (it, use) in made.items():
        try:
            use(it)
        except RuntimeError as error:
            print(name, error, flush=True)
        it.close()
    print("all", flush=True)
os._exit(0)
"""


@posix
def test_the_use_of_a_parents_socket_after_a_fork_is_refused_at_once(tmp_path):
    pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
    pytest.importorskip("PIL", reason="lesson 12 needs pillow: kit.py run 12 installs it")
    done = finished([PYTHON, "-c", FORKS.format(root=str(ROOT)), tmp_path / "journal"])
    *lines, last = [line for line in done.stdout.splitlines() if "press Play" not in line]
    assert last == "all", done
    cure = "this was made in another process: make a new one in this process, after the fork"
    assert len(lines) == len(USES) + 5 and all(line.endswith(f" {cure}") for line in lines), done.stdout


FILMS = """
import os, sys
import numpy as np
from netmq_example.video.film_writer import open_film
film = open_film(sys.argv[1])
picture = np.zeros((32, 32, 3), np.uint8)
film.add(picture, 0)
if os.fork():
    os.wait()
    film.add(picture, 0.04)
    film.close(0.08)
    print(film.frames)
else:
    try:
        film.add(picture, 0.04)
    except RuntimeError as error:
        print(error, flush=True)
    film.close(0.08)
    os._exit(0)
"""


@posix
@pytest.mark.parametrize("ending", ["mp4", "gif"])
def test_a_film_is_that_of_the_process_which_began_it(ending, tmp_path):
    pytest.importorskip("av", reason="lesson 12 needs av: kit.py run 12 installs it")
    done = finished([PYTHON, "-c", FILMS, tmp_path / f"film.{ending}"], cwd=ROOT / "python", timeout=30)
    cure = "this film was begun in another process: begin one in this process, after the fork"
    assert done.stdout.splitlines() == [cure, "2"], done


def test_a_forgotten_client_ends_its_thread():
    class Game:
        def __init__(self):
            self.client = BackgroundClient(steady_endpoint(), timeout=60)
            self.client.request("hello", self.hear, self.hear)

        def hear(self, text):
            """The thread must not hold the object of this method, which has the client."""

    before = {*threading.enumerate()}
    for _ in range(3):
        game = Game()
    (thread,) = game.client.threads
    del game
    gc.collect()
    thread.join(LIMIT)
    for left in {*threading.enumerate()} - before:
        left.join(LIMIT)
    assert {*threading.enumerate()} <= before


# What is printed ends no server, and does not stop it


@posix
@pytest.mark.parametrize("console", ["unread", "closed", "full", "none"])
def test_a_server_goes_on_whatever_becomes_of_its_lines(console, start, connect):
    """As it is started by a program that reads one line of it, on a full disk, or without a console."""
    endpoint = steady_endpoint()
    asker = connect(endpoint, zmq.REQ)

    def answered(times):
        for _ in range(times):
            asker.send(b"Hello")
            assert asker.recv() == b"World"

    server = [str(PYTHON), str(ROOT / "python" / "01_request_reply" / "server.py"), "--endpoint", endpoint]
    if console in ("full", "none"):
        files = "< /dev/null > /dev/full 2> /dev/full" if console == "full" else "<&- >&- 2>&-"
        program = start("sh", "-c", f'exec "$@" {files}', "sh", *server)
        answered(3)
        program.stop()
        return
    with subprocess.Popen(server, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout.readline().startswith(b"listening on ")
        if console == "closed":
            process.stdout.close()
            process.stderr.close()
        # A pipe has room for some 4,000 of its lines.
        answered(6000 if console == "unread" else 3)
        process.kill()


def test_a_command_to_paste_is_quoted(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/home/O'Brien/R&D kit/python")
    words = [sys.executable, "-m", "pip", "install", "mediapipe"]
    assert shlex.split(extras.pip_install("mediapipe")) == words
    monkeypatch.setattr(sys, "platform", "win32")
    assert extras.pip_install("mediapipe") == '"/home/O\'Brien/R&D kit/python" -m pip install mediapipe'


# Its console is IDLE's or a notebook's, it has words of its own, and a loop.
HOST = """
import asyncio, io, runpy, sys, threading, zmq

class Console(io.TextIOBase):
    def write(self, text):
        return sys.__stdout__.write(text)

python, endpoint = sys.argv[1:]
sys.path[:0] = [python]
from netmq_example import program
options = program.server_options
program.server_options = lambda about, _: options(about, endpoint)
sys.stdout = Console()
sys.argv = ["host", "-f", "kernel.json"]
main = runpy.run_path(f"{python}/01_request_reply/server.py")["main"]
for how in (main, lambda: program.run(main)):
    thread = threading.Thread(target=how, daemon=True)
    thread.start()
    with zmq.Context() as context, context.socket(zmq.REQ) as socket:
        socket.linger = 0
        socket.connect(endpoint)
        socket.send(b"Hello")
        print(f"got {socket.recv().decode()}\\n", end="", flush=True)
# The port is taken, and it says so, although it is in a thread.
thread.join()

async def loop():
    sys.argv = ["host"]
    runpy.run_path(f"{python}/16_web_gateway/server.py")["main"]()

asyncio.run(loop())
"""


def test_a_server_in_a_thread_of_another_program():
    pytest.importorskip("socketio", reason="lesson 16 needs python-socketio: kit.py run 16 installs it")
    endpoint = steady_endpoint()
    done = finished([PYTHON, "-c", HOST, ROOT / "python", endpoint])
    assert done.stdout.count("got World") == 2, done
    taken, loop = done.stderr.splitlines()
    assert taken.startswith(f"cannot listen on {endpoint}: Address already in use"), done
    assert loop.startswith("a loop runs here already, as in a notebook: "), done
    assert done.returncode == 1


# A cell has no file. IPython shows each error that an end was raised from, and before 8.27 some 150 lines for two.
RUN_IN_A_CELL = """
import runpy, sys
sys.path[:0] = [sys.argv[1]]
del __file__
words, sys.argv = sys.argv[2:], ["host", "-f", "kernel.json"]
from netmq_example import program
print(program.server_options("", "tcp://127.0.0.1:5551").parse_args().endpoint)
sys.argv = words
try:
    runpy.run_path(words[0], run_name="__main__")
except SystemExit as end:
    print(end, end.__suppress_context__)
"""


def test_a_cell_of_a_notebook(tmp_path):
    (tmp_path / "cell.py").write_text(RUN_IN_A_CELL, encoding="utf-8")
    client = ROOT / "python" / "01_request_reply" / "client.py"
    words = ["--endpoint", steady_endpoint(), "--timeout", "0.2"]
    done = finished([PYTHON, tmp_path / "cell.py", ROOT / "python", client, *words])
    first, *_, last = done.stdout.splitlines()
    assert first == "tcp://127.0.0.1:5551", done
    assert re.fullmatch("gave up: .* True", last), done


# Ctrl-C as soon as it listens. IPython keeps an end, which holds every object that was there.
RUN_TWICE = """
import _thread, io, runpy, sys

class Console(io.TextIOBase):
    def write(self, text):
        sys.__stdout__.write(text)
        if text.startswith("listening on"):
            _thread.interrupt_main()
        return len(text)

kept, sys.argv, sys.stdout = [], sys.argv[1:], Console()
for _ in range(2):
    try:
        runpy.run_path(sys.argv[0], run_name="__main__")
    except SystemExit as end:
        kept.append(end)
"""


def test_a_server_that_is_stopped_in_a_notebook_can_be_run_again(tmp_path):
    """Its journal is in no use any more, although the process lives on."""
    server = ROOT / "python" / "14_long_jobs" / "server.py"
    words = ["--endpoint", "tcp://127.0.0.1:0", "--journal", "journal.sqlite3"]
    done = finished([PYTHON, "-c", RUN_TWICE, server, *words], cwd=tmp_path)
    assert done.stdout.count("listening on") == 2 and not done.stderr, done


# A limit is said by the side that meets it

TOO_LONG = "answer returned what cannot be sent: a text of 100000 bytes, more than 65536: lesson 05 carries more"


@pytest.mark.parametrize(
    ("key", "frames"),
    [
        ("01_request_reply", [b"Hello"]),
        ("02_lazy_pirate", [b"1", b"add 1"]),
        ("04_background_client", [b"1", b"hello"]),
        ("06_many_in_flight", [b"1", b"echo 1"]),
        ("06_many_in_flight", [b"1", b"sleep 0"]),
    ],
)
def test_an_answer_that_no_client_would_take_is_refused_where_it_is_made(key, frames, serve_own, connect):
    server, endpoint = serve_own(key, "answer = lambda *_: 'x' * 100_000")
    socket = connect(endpoint, zmq.DEALER if key[:2] == "06" else zmq.REQ)
    # A journal gives no answer to a retry that it would not have given at first.
    for _ in range(2):
        socket.send_multipart(frames)
        assert socket.recv_multipart() == [*frames[:-1], f"error: {TOO_LONG}".encode()]
    assert server.wait_for(rf"^trouble: {TOO_LONG}")
    assert "Traceback" not in server.output


@pytest.mark.parametrize("key", ["03_publish_subscribe", "07_catch_up", "20_body_tracking"])
def test_what_no_listener_would_take_is_not_published(key):
    code = (
        f"import sys; sys.path.insert(0, {str(ROOT / 'python' / key)!r}); import server\n"
        "from netmq_example import pose_stream\n"
        "pose_stream.secrets.token_hex = lambda _: 'x' * 100_000\n"
        "server.pose = lambda *_: 'x' * 100_000; server.main()"
    )
    done = finished([PYTHON, "-c", code, "--endpoint", "tcp://127.0.0.1:*"])
    assert done.stderr.splitlines()[-1].endswith("bytes, more than 65536: lesson 05 carries more"), done.stderr
