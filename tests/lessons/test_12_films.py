"""Lesson 12: the film writer and Films as a script uses them, beside a game of the test's own."""

from __future__ import annotations

import sys
import threading
import time
from types import SimpleNamespace

import pytest

from netmq_example.errors import Lost, Refused
from tests.web import chromium

np = pytest.importorskip("numpy", reason="lesson 12 needs numpy: kit.py run 12 installs it")
pytest.importorskip("PIL", reason="lesson 12 needs Pillow: kit.py run 12 installs it")
av = pytest.importorskip("av", reason="lesson 12 needs av: kit.py run 12 installs it")
from netmq_example.video.film_writer import open_film, usual_ending  # noqa: E402
from netmq_example.video.films import Films  # noqa: E402
from netmq_example.video.view_sender import FilmView, ViewSender  # noqa: E402
from tests.lessons.test_12_video import shown  # noqa: E402

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
    """Which picture it is."""
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
