"""Lesson 12: the film writer and Films as a script uses them, beside a game of the test's own."""

from __future__ import annotations

import json
import sys
import threading
import time

import pytest
import zmq

np = pytest.importorskip("numpy", reason="lesson 12 needs numpy: kit.py run 12 installs it")
Image = pytest.importorskip("PIL.Image", reason="lesson 12 needs Pillow: kit.py run 12 installs it")

try:
    import av
except ImportError:
    av = None
from netmq_example.errors import Lost, Refused  # noqa: E402
from netmq_example.messages import Array, Message  # noqa: E402
from netmq_example.video.film_writer import CODECS, open_film  # noqa: E402
from netmq_example.video.films import Films  # noqa: E402
from netmq_example.video.view_sender import FilmView, ViewSender  # noqa: E402
from tests.lessons.test_12_video import is_whole, shown  # noqa: E402

each_format = pytest.mark.parametrize("end", [".gif", ".png", ".webp"])
needs_av = pytest.mark.skipif(av is None, reason="MP4 and WebM need av: kit.py run 12 installs it")
CODED = [pytest.param(end, marks=needs_av) for end in (".mp4", ".webm")]
each_codec = pytest.mark.parametrize("end", CODED)
# Seconds at which pictures were seen, and after which the last one was over.
TIMES, END = [0.2, 0.24, 0.3, 0.31, 0.8, 1.0], 1.25


def picture(number, width=64, height=48):
    """One that no other is equal to, without loss in 256 colours."""
    pixels = np.full((height, width, 3), (40 * number, 80, 120), np.uint8)
    pixels[: 6 + number, : 10 + 3 * number] = (250, 30, 10)
    return pixels


# The writer


@each_format
def test_a_film_has_its_pictures_and_their_times(end, tmp_path):
    film = open_film(tmp_path / f"film{end}")
    for number, seen in enumerate(TIMES):
        film.add(picture(number), seen)
        # As if it was killed now.
        assert len(shown(tmp_path / f"film{end}")[0]) == number + 1
        assert is_whole(tmp_path / f"film{end}")
    film.close(END)
    pictures, times = shown(tmp_path / f"film{end}")
    # GIF counts in hundredths.
    assert times == pytest.approx([40, 60, 10, 490, 200, 250], abs=1e-6)
    for number, pixels in enumerate(pictures):
        # WebP has some loss.
        assert np.abs(pixels.astype(int) - picture(number)).mean() <= (5 if end == ".webp" else 0)
    with Image.open(tmp_path / f"film{end}") as again:
        assert again.info["loop"] == 0, "it begins again"
    with pytest.raises(ValueError, match="is there already, and nothing is written over"):
        open_film(tmp_path / f"film{end}")


def test_rounding_does_not_add_up(tmp_path):
    """At 30 a second a GIF's steps of 0.01 s are 3, 3 and 4."""
    film = open_film(tmp_path / "film.gif")
    for number in range(90):
        film.add(picture(number % 6), number / 30)
    film.close(3)
    _, times = shown(tmp_path / "film.gif")
    assert sum(times) == 3000 and set(times) == {30, 40}


def test_a_picture_is_shown_as_long_as_its_format_can_say(tmp_path):
    for end, longest in ((".gif", 655_350), (".png", 65_535), (".webp", 16_777_215)):
        film = open_film(tmp_path / f"film{end}")
        film.add(picture(1), 0)
        film.add(picture(2), 0)
        film.close(1e6)
        assert shown(tmp_path / f"film{end}")[1] == pytest.approx([0, longest])


@pytest.mark.parametrize("count", [1, 2, 3, 30])
@pytest.mark.parametrize("end", [".gif", ".png", ".webp", *CODED])
@pytest.mark.parametrize("last", [0.04, 0.01])
def test_readers_find_each_picture_and_its_time(last, end, count, tmp_path):
    """Also the last one, when it was seen for a quarter of the time of the others."""
    film = open_film(tmp_path / f"film{end}", 25)
    for number in range(count):
        film.add(picture(number % 6), number / 25)
    film.close((count - 1) / 25 + last)
    assert film.frames == count
    if end in CODECS:
        _, times = played(film.path)
        assert times == pytest.approx([number / 25 for number in range(count)], abs=2e-3)
        return
    pictures, times = shown(film.path)
    assert times == pytest.approx([40] * (count - 1) + [1000 * last]) and len(pictures) == count


def pixels(*shape):
    return np.arange(np.prod(shape)).astype(np.uint8).reshape(shape)


@pytest.mark.parametrize("end", [".gif", ".png", ".webp", *CODED])
@pytest.mark.parametrize("shape", [(48, 64), (48, 64, 4), (1, 1, 3), (7, 5)])
def test_grey_and_transparent_pictures_of_any_size_make_films(end, shape, tmp_path):
    film = open_film(tmp_path / f"film{end}")
    for number in range(3):
        film.add(pixels(*shape), number / 25)
    film.close(3 / 25)
    if end in CODECS:
        assert len(played(film.path)[0]) == 3
        return
    (found, *_), times = shown(film.path)
    wanted = pixels(*shape)[..., :3] if len(shape) == 3 else np.stack([pixels(*shape)] * 3, axis=2)
    assert len(times) == 3 and found.shape == wanted.shape
    if end != ".webp" and (end == ".png" or len(shape) == 2):
        assert np.array_equal(found, wanted)


@pytest.mark.parametrize("end", [".gif", ".png", ".webp", *CODED])
def test_what_is_no_picture_is_refused_and_leaves_the_film_whole(end, tmp_path):
    for wrong, form in (
        (np.zeros((48, 64, 3)), r"float64 \[48, 64, 3\]"),
        (pixels(3, 48, 64), r"uint8 \[3, 48, 64\]"),
        (pixels(48), r"uint8 \[48\]"),
        (pixels(0, 64, 3), r"uint8 \[0, 64, 3\]"),
        (np.zeros((48, 64), bool), r"bool \[48, 64\]"),
        (None, r"object \[\]"),
    ):
        film = open_film(tmp_path / f"film{end}")
        with pytest.raises(ValueError, match=f"^picture takes uint8 .*, not {form}$"):
            film.add(wrong, 0)
        film.add(pixels(48, 64), 0)
        with pytest.raises(ValueError, match=rf"^picture takes .*, not {form}$"):
            film.add(wrong, 0.04)
        with pytest.raises(ValueError, match="size of the first one"):
            film.add(pixels(47, 64, 3), 0.04)
        film.close(0.04)
        assert len((played if end in CODECS else shown)(film.path)[0]) == 1
        film.path.unlink()


def test_of_pictures_that_come_evenly_none_is_favoured(tmp_path):
    """Of two hundred a second in a GIF's hundred each second one is seen."""
    film = open_film(tmp_path / "film.gif")
    for number in range(60):
        film.add(np.full((16, 16, 3), 4 * number, np.uint8), 10 + number / 200)
    film.close(10 + 60 / 200)
    assert shown(film.path)[1] == [0, 10] * 30


@pytest.mark.parametrize("end", [".gif", ".png", ".webp", *CODED])
def test_a_film_without_a_picture_leaves_no_file(end, tmp_path):
    open_film(tmp_path / f"film{end}").close(1)
    assert list(tmp_path.iterdir()) == []


def test_without_av_an_mp4_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(OSError, match=r"pip install av; or let the film end in \.gif"):
        open_film(tmp_path / "film.mp4")
    assert list(tmp_path.iterdir()) == []


def played(path):
    """The pictures of an MP4 or a WebM, and their seconds."""
    with pytest.importorskip("av").open(path) as film:
        frames = list(film.decode(video=0))
    return [frame.to_ndarray(format="rgb24") for frame in frames], [frame.time for frame in frames]


@each_codec
def test_uneven_times_come_back_and_odd_sides_become_even(end, tmp_path):
    film = open_film(tmp_path / f"film{end}")
    for number, seen in enumerate(TIMES):
        film.add(picture(number, 63, 47), seen)
    film.close(END)
    pictures, times = played(film.path)
    assert times == pytest.approx([seen - TIMES[0] for seen in TIMES], abs=2e-3)
    with av.open(film.path) as file:
        assert file.duration / 1e6 == pytest.approx(END - TIMES[0], abs=2e-3), "the last picture has its length"
    for number, pixels in enumerate(pictures):
        assert pixels.shape == (48, 64, 3)
        # There is some loss.
        assert np.abs(pixels[:47, :63].astype(int) - picture(number, 63, 47)).mean() <= 12


@each_codec
def test_a_killed_program_leaves_a_film_that_plays(end, start, tmp_path):
    code = f"""
import sys, time; sys.path[:0] = {sys.path!r}
from tests.lessons.test_12_films import *
film = open_film("film{end}", 20)
for number in range(60): film.add(picture(number % 6), number / 20)
print("written", flush=True)
time.sleep(60)
"""
    program = start(sys.executable, "-c", code, folder=tmp_path)
    program.wait_for("^written")
    program.kill()
    assert len(played(tmp_path / f"film{end}")[0]) >= 55


# Films, as a script uses them


class Game:
    """A game of two views in a thread: its pictures are `picture(step)`."""

    def __init__(self, endpoint, sizes=None):
        sizes = sizes or {"one": (64, 48), "two": (32, 24)}
        self.views = [FilmView(name, *size) for name, size in sizes.items()]
        self.over = threading.Event()
        self.sender = ViewSender(endpoint)
        self.threads = [threading.Thread(target=self.sender.run, args=(self.views, self.over))]
        self.threads.append(threading.Thread(target=self.play))
        for thread in self.threads:
            thread.start()

    def play(self):
        step = 0
        while not self.over.wait(0.01):
            step = (step + 1) % 6
            for view in self.views:
                if due := view.due():
                    # The lowest row first.
                    pixels = np.ascontiguousarray(picture(step, due.film.width, due.film.height)[::-1])
                    view.take(due, pixels)

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
    game = Game(films.game.endpoint)
    assert films.wait() == {"one": (64, 48), "two": (32, 24)}
    yield game
    game.end()


def known(pixels):
    """Which picture it is."""
    height, width, _ = pixels.shape
    return [number for number in range(6) if np.array_equal(pixels, picture(number, width, height))]


def test_films_at_the_same_time_and_the_newest_pictures(films, game, tmp_path):
    films.begin_render(path="one.gif", fps=50)
    # So few that a busy machine's game, which makes fewer than 50 of the other one, makes more of that all the same.
    films.begin_render("two", "two.png", width=16, height=12, fps=1)
    while films.films["one"].frames < 10:
        time.sleep(0.01)
    seen = films.render_all()
    assert list(seen) == ["one", "two"] and seen["two"].shape == (12, 16, 3)
    assert all(known(pixels) for pixels in seen.values()), "upright"
    one, two = films.end_render("one"), films.end_render("two")
    assert films.lines[:2] == ["begin one 64 x 48", "begin two 16 x 12"]
    assert films.lines[2:] == [str(one), str(two)]
    for film in (one, two):
        pictures, times = shown(film.path)
        assert len(pictures) == film.frames and all(known(pixels) for pixels in pictures)
        assert sum(times) == pytest.approx(1000 * film.seconds, abs=10)
    assert one.frames > 2 * two.frames
    # Of views that nobody films as well, and no file is made of them.
    assert {view: pixels.shape for view, pixels in films.render_all().items()} == {
        "one": (48, 64, 3),
        "two": (24, 32, 3),
    }
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.gif", "two.png"]


def test_with_a_rate_of_0_there_are_the_pictures_that_were_asked_for(films, game):
    for view in ("one", "two"):
        films.begin_render(view, None, fps=0)
    for _ in range(3):
        assert all(known(pixels) for pixels in films.look(["one", "two"]).values())
    films.look(["two"])
    assert [(film.frames, film.skipped) for film in map(films.end_render, ("one", "two"))] == [(3, 0), (4, 0)]


def test_what_cannot_be_done_is_said(films, game, tmp_path):
    for wrong, why in (
        ({"view": "side"}, "unknown-view: there is no view 'side'; there are: one, two"),
        ({"width": 65}, "bad-size: one is at most 64 x 48"),
        ({"fps": 1001, "path": None}, "bad-rate: fps is at most 1000, and 0 for pictures on demand alone"),
    ):
        with pytest.raises(Refused, match=why):
            films.begin_render(**wrong)
    with pytest.raises(Refused, match="not-filmed: one is not being filmed"):
        films.end_render("one")
    with pytest.raises(OSError, match="No such file or directory"):
        films.begin_render("one", "nowhere/film.gif")
    films.begin_render("one", width=-1, height=-1)
    with pytest.raises(Refused, match="busy-view: one is being filmed already: end that film first"):
        films.begin_render("one", "other.gif")
    while not films.films["one"].frames:
        time.sleep(0.01)
    assert films.end_render("one").frames
    assert [path.name for path in tmp_path.iterdir()] == ["one_1.gif"], "what was refused left no file"
    with pytest.raises(
        OSError, match=r"close\(\) the Films that have it, or end the other program, or take another port"
    ):
        Films(films.game.endpoint)


def test_nothing_that_is_there_is_deleted_or_written_over(films, game, tmp_path, runs):
    """gymize deleted a folder `tmp` beside its video."""
    (tmp_path / "tmp").mkdir()
    kept = {tmp_path / name: name.encode() for name in ("tmp/mine.txt", "one_1.gif")}
    for path, text in kept.items():
        path.write_bytes(text)
    for view in ("one", "two"):
        films.begin_render(view)
    assert all(picture.any() for picture in films.render_all().values())
    assert [films.end_render(view).path.name for view in ("one", "two")] == ["one_2.gif", "two_1.gif"]
    words = ["--endpoint", "tcp://127.0.0.1:0", "--film"]
    there, other = runs("server", "12_video", [[*words, str(tmp_path / "one_1.gif")], [*words, "drive.avi"]])
    assert there.code == other.code == 2
    assert "one_1.gif' is there already, and nothing is written over: give another name" in there.lines[-1]
    assert "'drive.avi' is no film: its name must end in .gif, .png, .apng, .webp, .mp4 or .webm" in other.lines[-1]
    assert {path: path.read_bytes() for path in kept} == kept
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one_1.gif", "one_2.gif", "tmp", "two_1.gif"]


@pytest.fixture
def small_disk():
    """Of a file no more than a few pictures can be written."""
    resource = pytest.importorskip("resource", reason="Windows has no limit for the size of a file")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_full_disk_ends_the_film_and_not_the_game(films, game, small_disk):
    for end in (".gif", ".png", ".webp", *((".mp4", ".webm") if av else ())):
        films.begin_render("one", f"full{end}", fps=100)
        while not films.films["one"].trouble:
            time.sleep(0.01)
        film = films.end_render("one")
        assert film.over and "its file has ended early: [" in film.trouble
        if end in CODECS:
            assert 0 < len(played(film.path)[0]) <= film.frames
        else:
            assert len(shown(film.path)[0]) == film.frames >= 1
            assert is_whole(film.path)
        assert len([line for line in films.lines if line.startswith(f"trouble: film full{end}: ")]) == 1


def test_a_second_game_is_busy_and_takes_the_place_of_one_that_is_gone(films, game):
    second = Game(films.game.endpoint, {"three": (8, 8)})
    try:
        films.begin_render("one", "one.gif")
        while not films.films["one"].frames:
            time.sleep(0.01)
        assert not second.sender.connected
        game.end()
        assert list(films.wait()) == ["three"]
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


def test_a_game_that_sends_nonsense_gets_errors_and_the_film_goes_on(films, context):
    with context.socket(zmq.DEALER) as peer:
        peer.linger = 0
        peer.connect(films.game.endpoint)

        def said(*frames):
            peer.send_multipart(frames or hello("a b").frames())
            assert peer.poll(100_000)
            return json.loads(peer.recv_multipart()[0])

        def hello(names, size=b"\x08\0\0\0\x08\0\0\0"):
            return Message("hello", 1, {"views": names}, [Array("int32", (1, 2), size)])

        films.start()
        for names in ("../evil", "", "a,b", "x" * 41):
            assert said(*hello(names).frames())["values"]["code"] == "bad-views"
        assert said(*Message("frame", 7, {"view": "a"}).frames())["values"]["code"] == "unknown-peer"
        assert said(b"{}")["kind"] == "error"
        assert said()["kind"] == "welcome"
        begin = threading.Thread(target=films.begin_render, args=("a b", "film.gif"))
        begin.start()
        while (message := json.loads(peer.recv_multipart()[0]))["kind"] != "begin":
            pass
        id, values = message["id"], {"view": "a b", "width": 8, "height": 8}
        peer.send_multipart(Message("begun", id, values).frames())
        begin.join()
        shapes = [(8, 8, 3), (8, 8, 4), (8, 9, 3), (8, 8), (8, 8, 4)]
        for number, shape in enumerate(shapes, 1):
            values = {"view": "a b", "number": number, "time": number / 10, "bottom_up": False}
            data = Array("uint8", shape, bytes(int(np.prod(shape))))
            assert said(*Message("frame", id, values, [data]).frames())["kind"] == "took"
    while films.game.views:
        time.sleep(0.01)
    film = films.end_render("a b")
    assert [line for line in films.lines if "bad-picture" in line and line.startswith("trouble: film")]
    assert len(shown(film.path)[0]) == film.frames == 2
    assert film.newest.shape == (8, 8, 3), "without alpha"
