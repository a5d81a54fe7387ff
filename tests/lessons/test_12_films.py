"""Lesson 12: the film writer and Films as a script uses them, beside a game of the test's own; and what neither a peer
nor a script may do to the films.
"""

import contextlib
import runpy
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest
import zmq

from kitlib.setup import dotnet
from netmq_example.errors import Lost, Refused
from netmq_example.messages import Array, Message, MessageError
from tests.programs import LIMIT, ROOT, steady_endpoint
from tests.web import chromium

np = pytest.importorskip("numpy", reason="lesson 12 needs numpy: kit.py run 12 installs it")
pytest.importorskip("PIL", reason="lesson 12 needs Pillow: kit.py run 12 installs it")
av = pytest.importorskip("av", reason="lesson 12 needs av: kit.py run 12 installs it")
from netmq_example.video.film_writer import open_film, usual_ending  # noqa: E402
from netmq_example.video.films import Films  # noqa: E402
from netmq_example.video.view_sender import FilmView, ViewSender  # noqa: E402
from tests.lessons.test_12_video import KEY, shown  # noqa: E402

each_ending = pytest.mark.parametrize("end", [".mp4", ".webm", ".gif"])


def picture(number, width=64, height=48):
    """One that no other is equal to, without loss in 256 colours."""
    pixels = np.full((height, width, 3), (40 * number, 80, 120), np.uint8)
    pixels[: 6 + number, : 10 + 3 * number] = (250, 30, 10)
    return pixels


# The writer


@each_ending
def test_uneven_times_come_back_also_of_odd_sides(end, tmp_path):
    film = open_film(tmp_path / f"film{end}")
    for number, seen in enumerate((0.2, 0.24, 0.3, 0.31, 0.31, 0.8, 1.0)):
        film.add(picture(number, 63, 47), seen)
    film.close(1.25)
    pictures, times = shown(film.path)
    assert times == pytest.approx([40, 60, 10, 0, 490, 200, 250], abs=1.1)
    assert pictures[0].shape == ((47, 63, 3) if end == ".gif" else (48, 64, 3))
    for number, pixels in enumerate(pictures):
        lost = np.abs(pixels[:47, :63].astype(int) - picture(number, 63, 47)).mean()
        assert lost <= (0 if end == ".gif" else 12)


def test_a_gif_neither_favours_a_picture_nor_wraps_around(tmp_path):
    """Of two hundred a second in a GIF's hundred each second one is seen."""
    film = open_film(tmp_path / "film.gif")
    for number in range(61):
        film.add(np.full((16, 16, 3), 4 * number, np.uint8), 10 + number / 200)
    film.close(1e6)
    assert shown(film.path)[1] == [0, 10] * 30 + [655_350]
    data = film.path.read_bytes()
    assert b"NETSCAPE2.0" in data and data.endswith(b";"), "it begins again, and is whole"


@each_ending
@pytest.mark.parametrize("shape", [(48, 64), (48, 64, 4), (1, 1, 3), (7, 5)])
def test_one_picture_of_any_kind_is_a_film_and_what_is_none_leaves_it_whole(end, shape, tmp_path):
    film = open_film(tmp_path / f"film{end}")
    pixels = np.arange(np.prod(shape)).astype(np.uint8).reshape(shape)
    for _ in range(2):
        with pytest.raises(ValueError, match=r"^picture takes uint8 .*, not float64 \["):
            film.add(pixels / 1, 0)
        if not film.frames:
            film.add(pixels, 0)
    film.close(0.04)
    (seen,), times = shown(film.path)
    assert times == [40]
    if end == ".gif":
        assert seen.shape == (*shape[:2], 3)
        assert len(shape) == 3 or np.array_equal(seen, np.stack([pixels] * 3, axis=2))


@each_ending
def test_a_film_without_a_picture_leaves_no_file(end, tmp_path):
    open_film(tmp_path / f"film{end}").close(1)
    assert list(tmp_path.iterdir()) == []


def test_without_av_or_its_h264_a_line_says_what_to_do(tmp_path, monkeypatch):
    assert usual_ending() == ".mp4"
    monkeypatch.setitem(sys.modules, "av", SimpleNamespace(codecs_available={"libvpx-vp9"}))
    assert usual_ending() == ".webm"
    with pytest.raises(OSError, match=r"^this av has no libx264: let the film end in .webm or .gif$"):
        open_film(tmp_path / "film.mp4")
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(OSError, match=r"pip install av; or let the film end in \.gif$"):
        open_film(tmp_path / "film.mp4")
    assert list(tmp_path.iterdir()) == []


def killed(end, start, folder):
    """A film whose program was killed after twenty pictures, of a second."""
    code = f"""
import sys, time; sys.path[:0] = {sys.path!r}
from tests.lessons.test_12_films import *
film = open_film("film{end}", 20)
for number in range(20): film.add(picture(number % 6), number / 20)
print("written", flush=True)
time.sleep(600)
"""
    program = start(sys.executable, "-c", code, folder=folder)
    program.wait_for("^written")
    program.kill()
    return folder / f"film{end}"


@each_ending
def test_a_kill_takes_the_last_two_pictures_at_most(end, start, tmp_path):
    pictures, times = shown(killed(end, start, tmp_path))
    assert len(pictures) >= 18
    assert times[:17] == pytest.approx([50] * 17, abs=1)


@pytest.mark.xdist_group("chromium")
def test_a_browser_plays_what_a_kill_left(start, tmp_path):
    if not chromium.find():
        pytest.skip(chromium.MISSING)
    film = killed(".mp4", start, tmp_path)
    page = tmp_path / "page.html"
    page.write_text(f'<video src="{film.name}" autoplay muted></video>')
    with chromium.Chromium() as browser:
        video = browser.open(page.as_uri())
        video.wait_for("document.querySelector('video').ended")
        assert video.evaluate("document.querySelector('video').currentTime") >= 0.8


# Films, as a script uses them


class Game:
    """A game in two threads. Its pictures are `draw(width, height)`, or one after the other those of `picture`."""

    def __init__(self, endpoint, sizes, draw=None):
        self.views = [FilmView(name, *size) for name, size in sizes.items()]
        self.step = 0
        self.draw = draw or (lambda width, height: picture(self.step % 6, width, height))
        self.over = threading.Event()
        self.sender = ViewSender(endpoint)
        self.threads = [threading.Thread(target=self.sender.run, args=(self.views, self.over))]
        self.threads.append(threading.Thread(target=self.play))
        for thread in self.threads:
            thread.start()

    def play(self):
        while not self.over.wait(0.01):
            self.step += 1
            for view in self.views:
                if due := view.due():
                    # The lowest row first.
                    view.take(due, np.ascontiguousarray(self.draw(due.film.width, due.film.height)[::-1]))

    def end(self):
        self.over.set()
        for thread in self.threads:
            thread.join()


class Heard(Films):
    """And what they say."""

    def __init__(self):
        self.lines = []
        super().__init__("tcp://127.0.0.1:*")

    def say(self, log, line):
        self.lines.append(line)
        super().say(log, line)


@pytest.fixture
def films(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with Heard() as films:
        yield films


@pytest.fixture
def game(films):
    sizes = {"one": (64, 48), "two": (32, 24)}
    game = Game(films.game.endpoint, sizes)
    assert films.wait() == sizes
    yield game
    game.end()


def known(pixels):
    height, width, _ = pixels.shape
    return [number for number in range(6) if np.array_equal(pixels, picture(number, width, height))]


def test_films_at_the_same_time_and_the_newest_pictures(films, game, tmp_path):
    films.begin_render(path="one.gif", fps=50)
    # So few that a busy machine's game, which makes fewer than 50 of the other one, makes more of that all the same.
    films.begin_render("two", "two.mp4", width=16, height=12, fps=1)
    while films.films["one"].frames < 10:
        time.sleep(0.01)
    seen = films.render_all()
    assert list(seen) == ["one", "two"] and seen["two"].shape == (12, 16, 3)
    assert all(known(pixels) for pixels in seen.values()), "upright"
    one, two = films.end_render("one"), films.end_render("two")
    assert films.lines == ["begin one 64 x 48", "begin two 16 x 12", str(one), str(two)]
    for film in (one, two):
        pictures, times = shown(film.path)
        assert len(pictures) == film.frames
        assert film is two or all(known(pixels) for pixels in pictures)
        assert sum(times) == pytest.approx(1000 * film.seconds, abs=10)
    assert one.frames > 2 * two.frames
    # Of views that nobody films as well, and no file is made of them.
    assert [pixels.shape for pixels in films.render_all().values()] == [(48, 64, 3), (24, 32, 3)]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.gif", "two.mp4"]


def test_what_cannot_be_done_is_said(films, game, tmp_path):
    with pytest.raises(OSError, match="No such file or directory"):
        films.begin_render("one", "nowhere/film.gif")
    films.begin_render("one", width=-1, height=-1)
    with pytest.raises(Refused, match="busy-view: one is being filmed already: end that film first"):
        films.begin_render("one", "other.gif")
    while not films.films["one"].frames:
        time.sleep(0.01)
    assert films.end_render("one").frames
    assert [path.name for path in tmp_path.iterdir()] == ["one_1.mp4"], "what was refused left no file"
    with pytest.raises(OSError, match=r"close\(\) the Films that have it, or end the other program, or take another"):
        Films(films.game.endpoint)


def test_nothing_that_is_there_is_deleted_or_written_over(films, game, tmp_path, runs):
    """gymize deleted a folder `tmp` beside its video."""
    (tmp_path / "tmp").mkdir()
    kept = {tmp_path / name: name.encode() for name in ("tmp/mine.txt", "one_1.mp4")}
    for path, text in kept.items():
        path.write_bytes(text)
    for view in ("one", "two"):
        films.begin_render(view)
    assert all(picture.any() for picture in films.render_all().values())
    assert [films.end_render(view).path.name for view in ("one", "two")] == ["one_2.mp4", "two_1.mp4"]
    words = ["--endpoint", "tcp://127.0.0.1:0", "--film"]
    there, other = runs("server", "12_video", [[*words, str(tmp_path / "one_1.mp4")], [*words, "drive.webp"]])
    assert there.code == other.code == 2
    assert "one_1.mp4' is there already, and nothing is written over: give another name" in there.lines[-1]
    assert "'drive.webp' is no film: its name must end in .mp4, .webm or .gif" in other.lines[-1]
    assert {path: path.read_bytes() for path in kept} == kept
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one_1.mp4", "one_2.mp4", "tmp", "two_1.mp4"]


@pytest.fixture
def small_disk():
    """Of a file no more than a few pictures can be written."""
    resource = pytest.importorskip("resource", reason="Windows has no limit for the size of a file")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_full_disk_ends_the_film_and_not_the_game(films, game, small_disk):
    for end in (".mp4", ".webm", ".gif"):
        films.begin_render("one", f"full{end}", fps=100)
        while not films.films["one"].trouble:
            time.sleep(0.01)
        film = films.end_render("one")
        assert film.over and "its file has ended early: [" in film.trouble
        assert film.frames - 2 <= len(shown(film.path)[0]) <= film.frames
        assert len([line for line in films.lines if line.startswith(f"trouble: film full{end}: ")]) == 1


def test_a_second_game_is_busy_and_takes_the_place_of_one_that_is_gone(films, game):
    second = Game(films.game.endpoint, {"three": (8, 8)})
    try:
        films.begin_render("one", "one.gif")
        while not films.films["one"].frames:
            time.sleep(0.01)
        assert not second.sender.connected
        game.end()
        assert list(films.wait()) == list(films.render_all()) == ["three"]
        film = films.end_render("one")
        assert film.over and film.frames == len(shown(film.path)[0])
        assert f"trouble: the game is gone; {film}" in films.lines
        second.end()
        while films.game.views:
            time.sleep(0.01)
        with pytest.raises(Lost, match="there is no game, or it is gone"):
            films.begin_render("three")
    finally:
        second.end()


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
    thread = threading.Thread(target=films.begin_render, kwargs=options)
    thread.start()
    peer.begun()
    thread.join(LIMIT)
    assert not thread.is_alive()


# A game of nonsense


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


# A script of nonsense


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


def test_two_threads_may_be_the_first_to_use_them(monkeypatch):
    with Films("tcp://127.0.0.1:0") as films:
        start, both = films.thread.start, threading.Barrier(2)

        def meets():
            with contextlib.suppress(threading.BrokenBarrierError):
                both.wait(0.2)
            start()

        monkeypatch.setattr(films.thread, "start", meets)
        with ThreadPoolExecutor(2) as pool:
            assert [*pool.map(lambda _: films.start(), range(2))] == [None, None]


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


# The game's side


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
        ([], "no camera to film: drag some into Cameras, or tag one MainCamera"),
    ],
)
def test_in_unity_it_is_one_line(names, why, netmq, start):
    play = start("dotnet", dotnet.build(netmq, ROOT / "tests" / "unity" / "play"), "views", *names)
    assert play.wait() == 0, play.output
    (said,) = [line for line in play.lines if "gave up: " in line]
    assert why in said and "errors: 1" in play.lines


def test_a_game_ends_when_it_wants_to_also_without_python(serve, start_client):
    server, endpoint = serve(KEY, "--seconds", "60", "--view", "map")
    client = start_client("csharp", KEY, endpoint, "--count", "60", "--timeout", "600")
    server.wait_for("^begin map")
    server.kill()
    assert client.wait() == 0, client.output
    assert client.lines[-1].startswith("done: ")


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
