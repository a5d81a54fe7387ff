"""Lesson 12: what neither a peer nor a script may do to the films. The fixtures are those of test_12_films.py."""

# ruff: noqa: E402, F401, F811
import contextlib
import runpy
import signal
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest
import zmq

from kitlib.setup import dotnet
from netmq_example.messages import Array, Message, MessageError
from tests.conftest import CLIENTS, PYTHON
from tests.programs import LIMIT, ROOT, steady_endpoint

np = pytest.importorskip("numpy", reason="lesson 12 needs numpy: kit.py run 12 installs it")
pytest.importorskip("PIL.Image", reason="lesson 12 needs Pillow: kit.py run 12 installs it")
from netmq_example.video import film_writer
from netmq_example.video.films import Films
from netmq_example.video.view_film import ViewFilm
from netmq_example.video.view_sender import FilmView, ViewSender
from tests.lessons.test_12_films import films, game
from tests.lessons.test_12_video import KEY, filmer, shown


class Peer:
    """A game of the test's own making, which says what it likes."""

    def __init__(self, context, endpoint):
        self.socket = context.socket(zmq.DEALER)
        self.socket.linger = 0
        self.socket.connect(endpoint)

    def say(self, kind, id=0, values=None, *arrays):
        self.socket.send_multipart(Message(kind, id, values or {}, list(arrays)).frames())

    def next(self, *kinds):
        end = time.monotonic() + LIMIT
        while time.monotonic() < end:
            if self.socket.poll(100) and (message := Message.read(self.socket.recv_multipart())).kind in kinds:
                return message
        raise AssertionError(f"no {kinds} came")

    def hello(self, names="one", sizes=((8, 8),), dtype="int32"):
        """The answer, until it is not that another game is here."""
        data = np.array(sizes, dtype)
        while True:
            self.say("hello", 1, {"views": names}, Array(dtype, data.shape, data.tobytes()))
            answer = self.next("welcome", "error")
            if answer.values.get("code") != "busy":
                return answer.values.get("code", answer.kind)

    def begun(self, width=8, height=8):
        self.film = self.next("begin").id
        self.say("begun", self.film, {"view": "one", "width": width, "height": height})

    def frame(self, number, time, shape=(8, 8, 3)):
        values = {"view": "one", "number": number, "time": time, "bottom_up": True}
        self.say("frame", self.film, values, Array("uint8", shape, bytes(int(np.prod(shape)))))

    def end(self, time, skipped=0):
        ended = {"view": "one", "frames": 1, "skipped": skipped, "time": time}
        self.say("ended", self.next("end").id, ended)


@pytest.fixture
def peer(films, context):
    films.start()
    one = Peer(context, films.game.endpoint)
    yield one
    one.socket.close()


def begin(films, peer, **options):
    """A film of a view of the peer."""
    with threaded(films.begin_render, **options):
        peer.begun()


@contextlib.contextmanager
def threaded(do, **options):
    thread = threading.Thread(target=do, kwargs=options)
    thread.start()
    yield
    thread.join(LIMIT)
    assert not thread.is_alive()


# Of a game


@pytest.mark.parametrize(
    "hello",
    [
        {"sizes": [[np.nan, 48]], "dtype": "float64"},
        {"sizes": [[-5, 8]]},
        {"sizes": [[0, 8]]},
        {"sizes": [[8000, 8000]]},
        {"names": "../evil"},
        {"names": ""},
        {"names": "x" * 41},
        {"names": "one,two"},
        {"names": "one,one", "sizes": [[8, 8], [8, 8]]},
        {"sizes": [8, 8]},
        {"names": ",".join(map(str, range(65))), "sizes": [[8, 8]] * 65},
    ],
)
def test_views_that_cannot_be_are_not_welcome(hello, peer):
    assert peer.hello(**hello) == "bad-views"
    assert peer.hello() == "welcome"


def test_numbers_that_cannot_be_end_a_film_and_not_the_server(serve, context, tmp_path):
    """Each of these games is the next one after it."""
    server, endpoint = serve(KEY, "--seconds", "0.3")

    def at(time):
        return lambda peer: (peer.begun(), peer.frame(1, 0.0), peer.frame(2, time))

    games = {
        "bad-time: 1e+307 s is longer than it was filmed": at(1e307),
        "bad-time: -1 s is longer": at(-1.0),
        "bad-time: 1e+09 s is longer": lambda peer: (peer.begun(), peer.frame(1, 0.0), peer.end(1e9)),
        "bad-size: one has no pictures of 70000 x 8": lambda peer: peer.begun(70_000),
        "bad-size: one has no pictures of 8 x -1": lambda peer: peer.begun(8, -1),
        "libx264 has no pictures of 70000 x 2": lambda peer: (
            peer.begun(70_000, 1),
            peer.frame(1, 0.0, (1, 70_000, 3)),
        ),
    }
    for why, nonsense in games.items():
        peer = Peer(context, endpoint)
        assert peer.hello(sizes=[[70_000, 1]] if "x264" in why else [[8, 8]]) == "welcome"
        nonsense(peer)
        server.wait_for(rf"^trouble: film \S+\.mp4: .*its file has ended early: {why.replace('+', '.')}")
        peer.socket.close()
    peer = Peer(context, endpoint)
    assert peer.hello() == "welcome"
    peer.begun()
    peer.frame(1, 0.0)
    peer.end(0.3)
    server.wait_for(r"^film \S+\.mp4: 1 frames, 0\.3 s, 0 skipped$")
    assert "Traceback" not in server.output
    assert all(shown(path)[0] for path in tmp_path.iterdir()), "where no picture came there is no file"


def test_what_one_view_refuses_ends_the_films_of_the_others(serve, context):
    server, endpoint = serve(KEY, "--seconds", "60")
    peer = Peer(context, endpoint)
    assert peer.hello("one,two", [[8, 8], [8, 8]]) == "welcome"
    peer.begun()
    peer.frame(1, 0.0)
    peer.say("error", peer.next("begin").id, {"code": "no-light", "text": "it is dark"})
    server.wait_for("^trouble: 'no-light: it is dark'$")
    peer.end(0.5, skipped=3)
    server.wait_for(r"^film one_1\.mp4: 1 frames, 0\.5 s, 3 skipped$")
    peer.socket.close()


def test_what_a_game_said_before_it_went_is_heard(serve, context):
    server, endpoint = serve(KEY, "--seconds", "0.3", "--slow", "0.3")
    peer = Peer(context, endpoint)
    assert peer.hello() == "welcome"
    peer.begun()
    peer.frame(1, 0.0)
    ask = peer.next("end")
    # It goes while this picture is written.
    peer.frame(2, 0.1)
    peer.say("ended", ask.id, {"view": "one", "frames": 2, "skipped": 0, "time": 0.5})
    peer.socket.close(linger=5000)
    server.wait_for(r"^film one_1\.mp4: 2 frames, 0\.5 s, 0 skipped$")
    assert "trouble" not in server.output


def test_nonsense_is_answered_and_ends_the_film_and_a_game_that_is_gone_leaves_it_at_once(films, peer):
    peer.say("frame", 7, {"view": "one"})
    assert peer.next("error").values["code"] == "unknown-peer"
    peer.socket.send(b"{}")
    assert peer.next("error").values["code"] != "unknown-peer"
    peer.hello()
    begin(films, peer, path="film.gif")
    for number, shape in enumerate([(8, 8, 3), (8, 8, 4), (8, 9, 3), (8, 8), (8, 8, 4)], 1):
        peer.frame(number, number / 10, shape)
        peer.next("took")
    peer.socket.close()
    film = films.end_render("one")
    assert len([line for line in films.lines if "bad-picture" in line and line.startswith("trouble: film")]) == 1
    assert film.frames == len(shown(film.path)[0]) == 2 and film.skipped == 0
    assert film.newest.shape == (8, 8, 3), "without alpha"


def test_a_game_that_answers_too_late_is_not_filmed_for_ever(films, peer):
    peer.hello()
    films.timeout = 0.2
    with pytest.raises(TimeoutError, match=r"no answer to begin within 0\.2 s; does the game hang"):
        films.begin_render("one")
    peer.begun()
    assert peer.next("end").values["view"] == "one"
    films.timeout = LIMIT
    begin(films, peer)


# Of a script


def test_what_a_game_could_not_read_is_not_sent(films, game):
    for wrong, why in (
        ({"fps": float("nan"), "path": None}, "is not finite"),
        ({"fps": float("inf"), "path": None}, "is not finite"),
        ({"view": "x" * 70_000, "path": None}, "too-big"),
        ({"view": "\ud800", "path": None}, "bad-json"),
    ):
        with pytest.raises((ValueError, TypeError, MessageError), match=why):
            films.begin_render(**wrong)
    films.begin_render("two", "two.gif", width=np.int64(16), height=np.int32(12), fps=np.float32(50))
    assert films.render_all()["two"].shape == (12, 16, 3)
    assert films.end_render("two").frames
    assert films.lines[0] == "begin two 16 x 12", "the game was there all the time"


def test_films_that_are_closed_say_so(films, game):
    films.begin_render("one", "one.gif")
    films.close()
    for late in (films.wait, films.render_all, films.begin_render):
        with pytest.raises(ValueError, match="these films are closed: make new ones"):
            late()
    films.close()


def test_what_nobody_foresaw_ends_the_films_and_not_their_thread(films, game, monkeypatch):
    films.begin_render("one", "one.gif")

    def fail(message):
        raise RuntimeError("of the test")

    monkeypatch.setattr(films, "hear", fail)
    while "trouble: RuntimeError('of the test')" not in films.lines:
        time.sleep(0.01)
    monkeypatch.undo()
    assert films.wait() == {"one": (64, 48), "two": (32, 24)}, "the game came back"
    assert films.end_render("one").over


def test_a_line_that_cannot_be_told_ends_nothing(films, game, monkeypatch):
    def fail(line):
        raise BrokenPipeError

    monkeypatch.setattr("netmq_example.video.films.log", SimpleNamespace(info=fail))
    films.report = fail
    films.begin_render("one", "one.gif")
    assert films.end_render("one").over
    game.end()
    while films.game.views:
        time.sleep(0.01)
    assert films.thread.is_alive()


# Of the game's side


@pytest.mark.parametrize("names", [["one", "one"], []])
def test_views_without_names_of_their_own_are_refused(names):
    sender = ViewSender(steady_endpoint())
    with pytest.raises(ValueError, match=r"each view needs a name of its own: (one, one|none)"):
        sender.run([FilmView(name, 8, 8) for name in names], threading.Event())


@pytest.mark.parametrize(
    "names, why",
    [
        (["front", "front"], "each view needs a name of its own: front, front"),
        (["a/b"], "a view cannot be 'a/b': give it a name of letters, digits, - and _"),
        ([], "no camera to film: drag some into Cameras"),
    ],
)
def test_in_unity_it_is_one_line(names, why, netmq, start):
    play = start("dotnet", dotnet.build(netmq, ROOT / "tests" / "unity" / "play"), "views", *names)
    assert play.wait() == 0, play.output
    (said,) = [line for line in play.lines if "gave up: " in line]
    assert why in said and "errors: 1" in play.lines


def test_a_game_ends_when_it_wants_to_also_without_python(serve, start, client_command):
    server, endpoint = serve(KEY, "--seconds", "60", "--view", "map")
    client = start(*client_command("csharp", KEY, endpoint, "--count", "60", "--timeout", "600"))
    server.wait_for("^begin map")
    server.kill()
    assert client.wait() == 0, client.output
    assert client.lines[-1].startswith("done: ")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no Ctrl-C for another program")
def test_ctrl_c_does_not_wait_for_python(start, client_command, filmer):
    client = start(*client_command("python", KEY, filmer.endpoint, "--timeout", "600"))
    # Which is never answered.
    filmer.next("hello")
    assert client.stop(signal.SIGINT) == 1
    assert client.lines[-1] == "stopped"


def test_ctrl_c_at_the_start_of_the_thread_does_not_wait_either(monkeypatch):
    told, submit = [], ThreadPoolExecutor.submit

    def interrupted(*words):
        submit(*words)
        raise KeyboardInterrupt

    monkeypatch.setattr(ThreadPoolExecutor, "submit", interrupted)
    play = runpy.run_path(str(ROOT / "python" / KEY / "client.py"))["play"]
    with pytest.raises(KeyboardInterrupt):
        play(SimpleNamespace(run=lambda views, stop: told.append(stop.wait(20))), 0)
    assert told == [True]
